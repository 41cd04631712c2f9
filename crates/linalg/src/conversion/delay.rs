//! Zero-order hold of a plant whose inputs are delayed.
//!
//! With `tau = d h + r`, `0 <= r < h`, the delayed input of period k is `u[k-d-1]` for the time r and `u[k-d]` after
//! it:
//!
//! ```text
//! x[k+1] = Ad x[k] + G1 u[k-d-1] + G0 u[k-d]    G0 = int_0^(h-r) e^{As} ds B    G1 = e^{A(h-r)} int_0^r e^{As} ds B
//! y[k]   = C x[k] + D u[k-d]   for r = 0          y[k] = C x[k] + D u[k-d-1]   for r > 0
//! ```
//! The state is extended by the past inputs `u[k-1], u[k-2], ..` that are needed, of the first input first.
//!
//! Source: Franklin, Powell, Workman, Digital Control of Dynamic Systems, section 4.3; Astrom and Wittenmark,
//! Computer-Controlled Systems, section 2.3.

use super::{Realization, period};
use crate::discretize::hold;
use crate::{LinalgError, Result};
use nalgebra::DMatrix;

/// The longest delay in periods: each of them is a state.
const LONGEST: f64 = 1000.0;

/// A delay in whole periods and a rest.
struct Delay {
    whole: usize,
    /// Between 0 and the period.
    rest: f64,
}

impl Delay {
    fn new(delay: f64, period: f64) -> Result<Self> {
        let ratio = delay / period;
        if !(delay >= 0.0 && ratio <= LONGEST) {
            return Err(LinalgError::InvalidDelay { delay, period, longest: LONGEST });
        }
        // A quotient of rounded numbers: within two roundings of a whole one it is whole.
        let nearest = ratio.round();
        if (ratio - nearest).abs() <= 2.0 * f64::EPSILON * ratio {
            return Ok(Self { whole: nearest as usize, rest: 0.0 });
        }
        let whole = ratio.floor();
        Ok(Self { whole: whole as usize, rest: (delay - whole * period).clamp(0.0, period) })
    }

    /// The number of past inputs.
    fn states(&self) -> usize {
        self.whole + usize::from(self.rest > 0.0)
    }
}

/// Discrete-time model of `x' = A x + B u(t - tau), y = C x + D u(t - tau)` at the period `h` for an input that is held
/// over each period, with a delay of its own for each input.
///
/// `delays` has m entries, in the unit of time of A: 0 or more, whole periods or not. A delay of `d` periods adds d
/// states to the n of the plant, one between d and d + 1 periods d + 1: the past inputs `u_1[k-1], u_1[k-2], ..,
/// u_2[k-1], ..`. A delay within two roundings of whole periods counts as whole. Cost: an exponential of order n + m,
/// and two of order n + 1 for each input whose delay is not whole.
///
/// # Errors
/// [`LinalgError::InvalidDelay`] if a delay is negative, not a number, or longer than 1000 periods;
/// [`LinalgError::DimensionMismatch`] if there are not m; otherwise those of [`super::c2d`].
///
/// # Example
/// ```
/// use luenberger_linalg::{Realization, c2d_delayed};
/// use nalgebra::dmatrix;
///
/// let lag = Realization::new(&dmatrix![-1.0], &dmatrix![1.0], &dmatrix![1.0], &dmatrix![0.0])?;
/// let sampled = c2d_delayed(&lag, 0.1, &[0.13])?;
/// // x+ = e^-0.1 x + (e^-0.07 - e^-0.1) u[k-2] + (1 - e^-0.07) u[k-1].
/// let (new, old) = (-(-0.07_f64).exp_m1(), (-0.07_f64).exp() - (-0.1_f64).exp());
/// let residual = (sampled.a - dmatrix![(-0.1_f64).exp(), new, old; 0.0, 0.0, 0.0; 0.0, 1.0, 0.0]).amax();
/// println!("residual {residual:e}");
/// assert!(residual < 1e-15 && sampled.b == dmatrix![0.0; 1.0; 0.0]);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Astrom and Wittenmark, Computer-Controlled Systems, section 2.3.
pub fn c2d_delayed(system: &Realization, h: f64, delays: &[f64]) -> Result<Realization> {
    system.check()?;
    let (n, m) = system.b.shape();
    if delays.len() != m {
        return Err(LinalgError::DimensionMismatch { what: "the delays", expected: (1, m), found: (1, delays.len()) });
    }
    let h = period(h)?;
    let delays = delays.iter().map(|delay| Delay::new(*delay, h)).collect::<Result<Vec<_>>>()?;
    let (balanced, units) = system.balanced()?;
    let (ad, mut new) = hold(&balanced.a, &balanced.b, h)?;
    let mut old = DMatrix::zeros(n, m);
    for (j, delay) in delays.iter().enumerate().filter(|(_, delay)| delay.rest > 0.0) {
        let b = balanced.b.columns(j, 1).into_owned();
        let (left, recent) = hold(&balanced.a, &b, h - delay.rest)?;
        let (_, before) = hold(&balanced.a, &b, delay.rest)?;
        new.set_column(j, &recent.column(0));
        old.set_column(j, &(left * before).column(0));
    }
    let back = |b| Realization { a: ad.clone(), b, c: balanced.c.clone(), d: system.d.clone() }.in_given_units(&units);
    let (Realization { a: ad, b: new, c, d }, old) = (back(new)?, back(old)?.b);

    let order = n + delays.iter().map(Delay::states).sum::<usize>();
    let mut found = Realization {
        a: DMatrix::zeros(order, order),
        b: DMatrix::zeros(order, m),
        c: DMatrix::zeros(c.nrows(), order),
        d: DMatrix::zeros(c.nrows(), m),
    };
    found.a.view_mut((0, 0), (n, n)).copy_from(&ad);
    found.c.view_mut((0, 0), c.shape()).copy_from(&c);
    let mut first = n;
    for (j, delay) in delays.iter().enumerate() {
        let states = delay.states();
        // Where the input of this age stands: the present one among the inputs, older ones among the states.
        let mut enter = |age: usize, driven: &DMatrix<f64>, direct: Option<&DMatrix<f64>>| {
            let (dynamics, output, column) = match age.checked_sub(1) {
                None => (&mut found.b, &mut found.d, j),
                Some(older) => (&mut found.a, &mut found.c, first + older),
            };
            dynamics.view_mut((0, column), (n, 1)).copy_from(&driven.column(j));
            if let Some(direct) = direct {
                output.set_column(column, &direct.column(j));
            }
        };
        let is_whole = delay.rest == 0.0;
        enter(delay.whole, &new, is_whole.then_some(&d));
        if !is_whole {
            enter(delay.whole + 1, &old, Some(&d));
        }
        for k in 0..states {
            if k == 0 {
                found.b[(first, j)] = 1.0;
            } else {
                found.a[(first + k, first + k - 1)] = 1.0;
            }
        }
        first += states;
    }
    Ok(found)
}
