//! Zero-order hold of a plant whose inputs and outputs are delayed.
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
//! A delayed output is what it was `tau` ago: for r = 0 the output of d samples before, for r > 0 that at the time
//! `h - r` after the sample `k-d-1`, `C x((k-d-1) h + h - r) + ..`, which state and inputs of that sample determine as
//! above. The past of these outputs are the last states, the latest first, of the first output first.
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
    /// Of the rest.
    rounding: f64,
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
            return Ok(Self { whole: nearest as usize, rest: 0.0, rounding: 0.0 });
        }
        let whole = ratio.floor();
        let (rest, rounding) = ((delay - whole * period).clamp(0.0, period), 2.0 * f64::EPSILON * (delay + period));
        Ok(Self { whole: whole as usize, rest, rounding })
    }

    /// The number of past inputs.
    fn states(&self) -> usize {
        self.whole + usize::from(self.rest > 0.0)
    }
}

/// Discrete-time model of `x' = A x + B u(t - tau), y = C x + D u(t - tau)` at the period `h` for an input that is held
/// over each period, with a delay of its own for each input and for each output, `y_i(t - sigma_i)`.
///
/// `inputs` has m entries, `outputs` p, in the unit of time of A: 0 or more, whole periods or not. A delay of `d`
/// periods adds d states to the n of the plant, one between d and d + 1 periods d + 1: the past inputs `u_1[k-1],
/// u_1[k-2], .., u_2[k-1], ..`, then the past outputs likewise, where delays are not whole between the samples. A delay
/// within two roundings of whole periods counts as whole. Cost: an exponential of order n + m and, for each output whose
/// delay is not whole, another one; with each of them two of order n + 1 for each input whose delay is not whole.
///
/// # Errors
/// [`LinalgError::InvalidDelay`] if a delay is negative, not a number, or longer than 1000 periods;
/// [`LinalgError::DimensionMismatch`] if there are not m and p; otherwise those of [`super::c2d`].
///
/// # Example
/// ```
/// use luenberger_linalg::{Realization, c2d_delayed};
/// use nalgebra::dmatrix;
///
/// let lag = Realization::new(&dmatrix![-1.0], &dmatrix![1.0], &dmatrix![1.0], &dmatrix![0.0])?;
/// let sampled = c2d_delayed(&lag, 0.1, &[0.13], &[0.0])?;
/// // x+ = e^-0.1 x + (e^-0.07 - e^-0.1) u[k-2] + (1 - e^-0.07) u[k-1].
/// let (new, old) = (-(-0.07_f64).exp_m1(), (-0.07_f64).exp() - (-0.1_f64).exp());
/// let residual = (sampled.a - dmatrix![(-0.1_f64).exp(), new, old; 0.0, 0.0, 0.0; 0.0, 1.0, 0.0]).amax();
/// println!("residual {residual:e}");
/// assert!(residual < 1e-15 && sampled.b == dmatrix![0.0; 1.0; 0.0]);
/// // The output 0.03 ago: w+ = e^-0.07 x + (1 - e^-0.07) u, y = w.
/// let late = c2d_delayed(&lag, 0.1, &[0.0], &[0.03])?;
/// assert!((late.a[(1, 0)] - (-0.07_f64).exp()).abs() < 1e-15 && (late.b[1] - new).abs() < 1e-15);
/// assert_eq!(late.c, dmatrix![0.0, 1.0]);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Astrom and Wittenmark, Computer-Controlled Systems, section 2.3.
pub fn c2d_delayed(system: &Realization, h: f64, inputs: &[f64], outputs: &[f64]) -> Result<Realization> {
    system.check()?;
    let ((n, m), p) = (system.b.shape(), system.c.nrows());
    let h = period(h)?;
    let read = |what, given: &[f64], expected| {
        if given.len() != expected {
            return Err(LinalgError::DimensionMismatch { what, expected: (1, expected), found: (1, given.len()) });
        }
        given.iter().map(|delay| Delay::new(*delay, h)).collect::<Result<Vec<_>>>()
    };
    let (inputs, outputs) =
        (read("the delays of the inputs", inputs, m)?, read("the delays of the outputs", outputs, p)?);
    let (balanced, units) = system.balanced()?;
    let back = |motion: Motion| {
        let of = |b| Realization { a: motion.transition.clone(), b, ..balanced.clone() }.in_given_units(&units);
        let (new, old) = (of(motion.new.clone())?, of(motion.old.clone())?);
        Ok::<_, LinalgError>(Motion { transition: new.a, new: new.b, old: old.b })
    };

    // First state of the past of each input and output, and their number.
    let mut order = n;
    let mut place = |delays: &[Delay]| -> Vec<usize> {
        let first = |delay: &Delay| {
            order += delay.states();
            order - delay.states()
        };
        delays.iter().map(first).collect()
    };
    let (past_inputs, past_outputs) = (place(&inputs), place(&outputs));
    let zeros = |rows| DMatrix::zeros(rows, order + m);
    // Coefficients of the state and of the inputs behind it.
    let (mut next, mut seen) = (zeros(order), zeros(p));
    // A row of coefficients for row i of the plant's state (or of C times it) at the end of a motion.
    let write = |rows: &mut DMatrix<f64>, first: usize, motion: [&DMatrix<f64>; 3]| {
        let [transition, new, old] = motion;
        rows.view_mut((first, 0), transition.shape()).copy_from(transition);
        for (j, delay) in inputs.iter().enumerate() {
            let column = |age: usize| if age == 0 { order + j } else { past_inputs[j] + age - 1 };
            rows.view_mut((first, column(delay.whole)), (new.nrows(), 1)).copy_from(&new.column(j));
            if delay.rest > 0.0 {
                rows.view_mut((first, column(delay.whole + 1)), (old.nrows(), 1)).copy_from(&old.column(j));
            }
        }
    };

    let whole = back(Motion::over(&balanced, h, &inputs)?)?;
    write(&mut next, 0, [&whole.transition, &whole.new, &whole.old]);
    for (j, delay) in inputs.iter().enumerate() {
        for k in 0..delay.states() {
            let from = if k == 0 { order + j } else { past_inputs[j] + k - 1 };
            next[(past_inputs[j] + k, from)] = 1.0;
        }
    }
    for (i, delay) in outputs.iter().enumerate() {
        // The time after a sample at which the output is taken.
        let at = if delay.rest > 0.0 { h - delay.rest } else { 0.0 };
        let motion = if at > 0.0 { back(Motion::over(&balanced, at, &inputs)?)? } else { Motion::none(n, m) };
        let (c, d) = (system.c.rows(i, 1), system.d.rows(i, 1));
        // The input that acts at this time; at the time of its change, up to rounding, the new one.
        let is_new = |j: usize| at >= inputs[j].rest - inputs[j].rounding - delay.rounding;
        let direct = |new: bool| DMatrix::from_fn(1, m, |_, j| if is_new(j) == new { d[j] } else { 0.0 });
        let row = [c * &motion.transition, c * &motion.new + direct(true), c * &motion.old + direct(false)];
        let row = [&row[0], &row[1], &row[2]];
        let states = delay.states();
        if states == 0 {
            write(&mut seen, i, row);
            continue;
        }
        write(&mut next, past_outputs[i], row);
        for k in 1..states {
            next[(past_outputs[i] + k, past_outputs[i] + k - 1)] = 1.0;
        }
        seen[(i, past_outputs[i] + states - 1)] = 1.0;
    }
    let split = |rows: &DMatrix<f64>| (rows.columns(0, order).into_owned(), rows.columns(order, m).into_owned());
    let ((a, b), (c, d)) = (split(&next), split(&seen));
    Ok(Realization { a, b, c, d })
}

/// The state after a time t of at most a period: `transition x + new u + old v` with the input u that acts at its end,
/// and v before that.
struct Motion {
    transition: DMatrix<f64>,
    new: DMatrix<f64>,
    old: DMatrix<f64>,
}

impl Motion {
    /// Over no time.
    fn none(n: usize, m: usize) -> Self {
        Self { transition: DMatrix::identity(n, n), new: DMatrix::zeros(n, m), old: DMatrix::zeros(n, m) }
    }

    /// Over the time `t > 0` from a sample on, for inputs that change after the rest of their delay.
    fn over(system: &Realization, t: f64, inputs: &[Delay]) -> Result<Self> {
        let (transition, mut new) = hold(&system.a, &system.b, t)?;
        let mut old = DMatrix::zeros(new.nrows(), new.ncols());
        for (j, delay) in inputs.iter().enumerate().filter(|(_, delay)| delay.rest > 0.0) {
            if t <= delay.rest {
                old.set_column(j, &new.column(j));
                new.column_mut(j).fill(0.0);
                continue;
            }
            let b = system.b.columns(j, 1).into_owned();
            let (left, recent) = hold(&system.a, &b, t - delay.rest)?;
            let (_, before) = hold(&system.a, &b, delay.rest)?;
            new.set_column(j, &recent.column(0));
            old.set_column(j, &(left * before).column(0));
        }
        Ok(Self { transition, new, old })
    }
}
