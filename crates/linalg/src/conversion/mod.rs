//! Conversion of state-space models between continuous and discrete time.
//!
//! `x' = A x + B u, y = C x + D u` becomes `x+ = Ad x + Bd u, y = Cd x + Dd u` at the period `h`:
//!
//! | method (MATLAB's `c2d`) | exact for | A, B | C, D |
//! |---|---|---|---|
//! | `zoh` | an input held over each period | `e^{Ah}`, `int_0^h e^{As} ds B` | as they are |
//! | `foh` | an input that is linear between samples | `e^{Ah}`, `(G0 + (Ad - I) G1) B` | `C`, `D + C G1 B` |
//! | `impulse` | the response to an impulse | `e^{Ah}`, `h Ad B` | `C`, `D + h C B` |
//! | `tustin` | the imaginary axis onto the unit circle | `M^-1 (I + A h/2)`, `h M^-1 B` | `C M^-1`, `D + (h/2) C M^-1 B` |
//!
//! with `M = I - A h/2`, `G0 = int_0^h e^{As} ds` and `G1 = int_0^h (1 - s/h) e^{As} ds`. All four keep the transfer
//! function of the method; the coordinates of the state are those of scipy (MATLAB scales the state of `tustin`). With
//! prewarping `h` is replaced by `2 tan(w h/2) / w`: the frequency responses agree at `w`. `matched` maps poles and
//! zeros: [`c2d_matched`]. Delayed inputs are held: [`c2d_delayed`].
//!
//! Source: Franklin, Powell, Workman, Digital Control of Dynamic Systems, chapter 6.

mod delay;
mod descriptor;
mod logarithm;
mod matched;
mod noise;

pub use delay::c2d_delayed;
pub use descriptor::{StandardForm, standard_form};
pub use logarithm::logm;
pub use matched::{ZerosPolesGain, c2d_matched};
pub use noise::{
    continuous_process_noise, discrete_process_noise, measurement_intensity, sampled_measurement_covariance,
};

use nalgebra::DMatrix;

use crate::argument::{RealMatrixView, owned, shaped, square};
use crate::balance::are_near;
use crate::discretize::{expm, exponential, hold};
use crate::equilibration::Equilibrated;
use crate::rosenbrock::Rosenbrock;
use crate::units::shift;
use crate::{LinalgError, Result};

/// The matrices of `x' = A x + B u, y = C x + D u` or of `x+ = A x + B u, y = C x + D u`.
#[derive(Debug, Clone, PartialEq)]
pub struct Realization {
    /// A, n x n.
    pub a: DMatrix<f64>,
    /// B, n x m.
    pub b: DMatrix<f64>,
    /// C, p x n.
    pub c: DMatrix<f64>,
    /// D, p x m.
    pub d: DMatrix<f64>,
}

impl Realization {
    /// The realization with these matrices.
    ///
    /// # Errors
    /// [`LinalgError::NotSquare`], [`LinalgError::DimensionMismatch`], [`LinalgError::NotFinite`];
    /// [`LinalgError::Empty`] without states.
    pub fn new<'a>(
        a: impl Into<RealMatrixView<'a>>,
        b: impl Into<RealMatrixView<'a>>,
        c: impl Into<RealMatrixView<'a>>,
        d: impl Into<RealMatrixView<'a>>,
    ) -> Result<Self> {
        let system = Self { a: owned(a), b: owned(b), c: owned(c), d: owned(d) };
        system.check()?;
        Ok(system)
    }

    /// The fields are public: what uses them checks them.
    pub(crate) fn check(&self) -> Result<()> {
        let n = square("A", &self.a)?;
        if n == 0 {
            return Err(LinalgError::Empty { what: "A" });
        }
        shaped("B", &self.b, n, self.b.ncols())?;
        shaped("C", &self.c, self.c.nrows(), n)?;
        shaped("D", &self.d, self.c.nrows(), self.b.ncols())
    }

    /// What `convert` makes of the plant in balanced units of its states, `x_j = 2^units[j] z_j`: rounding and the test
    /// for singularity then do not depend on the units given. Inputs, outputs and time keep theirs: all conversions are
    /// linear in B and C. Where the entries of A are near to each other there is nothing to balance.
    fn in_balanced_units(&self, convert: impl FnOnce(&Self) -> Result<Self>) -> Result<Self> {
        if are_near(self.a.iter()) {
            return convert(self);
        }
        let (balanced, units) = self.balanced()?;
        convert(&balanced)?.in_given_units(&units)
    }

    /// The plant in these units, and the units.
    fn balanced(&self) -> Result<(Self, Vec<i32>)> {
        let units = Rosenbrock::new(&self.a, &self.b, &self.c, &self.d)?;
        let (a, b, c) = (units.dynamics_of(&self.a, 0), units.driven_of(&self.b, 0), units.seen_of(&self.c));
        Ok((Self { a, b, c, d: self.d.clone() }, units.states()))
    }

    /// Back from these units.
    fn in_given_units(self, units: &[i32]) -> Result<Self> {
        let Self { a, b, c, d } = self;
        Self {
            a: DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| shift(a[(i, j)], units[i] - units[j])),
            b: DMatrix::from_fn(b.nrows(), b.ncols(), |i, j| shift(b[(i, j)], units[i])),
            c: DMatrix::from_fn(c.nrows(), c.ncols(), |i, j| shift(c[(i, j)], -units[j])),
            d,
        }
        .finite()
    }

    fn finite(self) -> Result<Self> {
        let all = [&self.a, &self.b, &self.c, &self.d];
        if all.iter().all(|m| m.iter().all(|x| x.is_finite())) {
            Ok(self)
        } else {
            Err(LinalgError::Overflow { what: "the converted model" })
        }
    }
}

/// A method of conversion, by the names of MATLAB's `c2d`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Discretization {
    /// `zoh`: the input is held over each period.
    ZeroOrderHold,
    /// `foh`: the input is linear between samples (triangle hold).
    FirstOrderHold,
    /// `impulse`: the impulse response is sampled, and multiplied by the period.
    Impulse,
    /// `tustin`: `s = (2/h) (z - 1)/(z + 1)`, the trapezoidal rule.
    Tustin,
    /// `tustin` prewarped: the frequency response is exact at this frequency, in radians per unit of time, between 0
    /// and `pi/h`.
    TustinPrewarped(f64),
}

impl Discretization {
    /// The period of the trapezoidal rule; none for the other methods.
    fn step(self, h: f64) -> Result<Option<f64>> {
        match self {
            Self::Tustin => Ok(Some(h)),
            Self::TustinPrewarped(w) if w > 0.0 && w * h < core::f64::consts::PI => {
                Ok(Some(2.0 * (w * h / 2.0).tan() / w))
            }
            Self::TustinPrewarped(frequency) => Err(LinalgError::InvalidFrequency { frequency, period: h }),
            _ => Ok(None),
        }
    }
}

fn period(h: f64) -> Result<f64> {
    if h > 0.0 && h.is_finite() { Ok(h) } else { Err(LinalgError::InvalidPeriod { h }) }
}

/// Discrete-time model of `x' = A x + B u, y = C x + D u` at the period `h`, by one of the methods of MATLAB's `c2d`.
///
/// `h > 0` is in the unit of time of A; m = 0 and p = 0 are allowed.
///
/// # Errors
/// [`LinalgError::InvalidPeriod`]; [`LinalgError::InvalidFrequency`] of a prewarping outside of (0, pi/h);
/// [`LinalgError::Singular`] if `2/h` is a pole and the method is Tustin's; those of [`Realization::new`];
/// [`LinalgError::Overflow`].
///
/// # Cost
/// One exponential of order n + 2 m, or one solution with `I - A h/2`.
///
/// # Example
/// The trapezoidal rule maps the pole -1 to `(1 - h/2)/(1 + h/2)` and keeps the gain at frequency zero.
/// ```
/// use luenberger_linalg::{Discretization, Realization, c2d};
/// use nalgebra::dmatrix;
///
/// let lag = Realization::new(&dmatrix![-1.0], &dmatrix![1.0], &dmatrix![1.0], &dmatrix![0.0])?;
/// let sampled = c2d(&lag, 0.2, Discretization::Tustin)?;
/// let residual = (sampled.a[0] - 0.9 / 1.1).abs();
/// let gain = sampled.c[0] * sampled.b[0] / (1.0 - sampled.a[0]) + sampled.d[0];
/// println!("residual {residual:e}, gain {gain}");
/// assert!(residual < 1e-15 && (gain - 1.0).abs() < 1e-14);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub fn c2d(system: &Realization, h: f64, method: Discretization) -> Result<Realization> {
    system.check()?;
    let h = period(h)?;
    system.in_balanced_units(|system| sampled(system, h, method))
}

fn sampled(system: &Realization, h: f64, method: Discretization) -> Result<Realization> {
    let Realization { a, b, c, d } = system;
    if let Some(step) = method.step(h)? {
        let identity = DMatrix::identity(a.nrows(), a.nrows());
        let half = a * (step / 2.0);
        let inverse = inverse("I - A h/2", &(&identity - &half))?;
        let ad = &inverse * (identity + half);
        let bd = &inverse * b * step;
        let d = d + c * &bd / 2.0;
        return Realization { a: ad, b: bd, c: c * inverse, d }.finite();
    }
    let (c, d) = (c.clone(), d.clone());
    let converted = match method {
        Discretization::FirstOrderHold => {
            let (ad, linear) = triangle(a, b, h)?;
            let (_, held) = hold(a, b, h)?;
            let bd = rising((a, &ad), b, (&held, &linear), h) + &ad * &linear;
            Realization { a: ad, b: bd, d: d + &c * linear, c }
        }
        Discretization::Impulse => {
            let ad = expm(&(a * h))?;
            let bd = &ad * b * h;
            Realization { a: ad, b: bd, d: d + &c * b * h, c }
        }
        _ => {
            let (ad, bd) = hold(a, b, h)?;
            Realization { a: ad, b: bd, c, d }
        }
    };
    converted.finite()
}

/// Continuous-time model whose [`c2d`] is `x+ = A x + B u, y = C x + D u` at the period `h`.
///
/// For the methods other than Tustin's, A is the principal logarithm of the discrete one: the model whose poles have
/// imaginary parts below `pi/h` in magnitude. A pole at zero or on the negative real axis has no such model of the same
/// order.
///
/// # Errors
/// [`LinalgError::NoLogarithm`] for such a pole; [`LinalgError::Singular`] for a pole at -1 and Tustin's method;
/// otherwise those of [`c2d`].
///
/// # Example
/// ```
/// use luenberger_linalg::{Discretization, Realization, c2d, d2c};
/// use nalgebra::dmatrix;
///
/// let plant = Realization::new(
///     &dmatrix![0.0, 1.0; -4.0, -0.4], &dmatrix![0.0; 1.0], &dmatrix![1.0, 0.0], &dmatrix![0.5])?;
/// for method in [Discretization::ZeroOrderHold, Discretization::FirstOrderHold, Discretization::Tustin] {
///     let back = d2c(&c2d(&plant, 0.1, method)?, 0.1, method)?;
///     let error = (back.a - &plant.a).norm() + (back.b - &plant.b).norm() + (back.d - &plant.d).norm();
///     println!("error {error:e}");
///     assert!(error < 1e-12);
/// }
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub fn d2c(system: &Realization, h: f64, method: Discretization) -> Result<Realization> {
    system.check()?;
    let h = period(h)?;
    system.in_balanced_units(|system| continued(system, h, method))
}

fn continued(system: &Realization, h: f64, method: Discretization) -> Result<Realization> {
    let Realization { a, b, c, d } = system;
    let n = a.nrows();
    let identity = DMatrix::identity(n, n);
    if let Some(step) = method.step(h)? {
        // M = 2 (Ad + I)^-1.
        let m = inverse("A + I", &(a + &identity))? * 2.0;
        let b = &m * b / step;
        let c = c * &m;
        let d = d - &system.c * &b * (step / 2.0);
        return Realization { a: (a - identity) * &m / step, b, c, d }.finite();
    }
    let continuous = logm(a)? / h;
    let solve = |what, map: &DMatrix<f64>| Ok::<_, LinalgError>(inverse(what, map)? * b);
    let converted = match method {
        Discretization::FirstOrderHold => {
            let (_, linear) = triangle(&continuous, &identity, h)?;
            let (_, held) = hold(&continuous, &identity, h)?;
            let map = rising((&continuous, a), &identity, (&held, &linear), h) + a * &linear;
            let b = solve("the map of the first-order hold", &map)?;
            let d = d - c * linear * &b;
            Realization { a: continuous, b, c: c.clone(), d }
        }
        Discretization::Impulse => {
            let b = solve("A", a)? / h;
            let d = d - c * &b * h;
            Realization { a: continuous, b, c: c.clone(), d }
        }
        _ => {
            let (_, held) = hold(&continuous, &identity, h)?;
            let b = solve("the map of the zero-order hold", &held)?;
            Realization { a: continuous, b, c: c.clone(), d: d.clone() }
        }
    };
    converted.finite()
}

/// `e^{Ah}` and `int_0^h (1 - s/h) e^{As} ds B`, blocks of one exponential. B is brought to the size of A by a power of
/// two, in which both are linear: that saves squarings.
fn triangle(a: &DMatrix<f64>, b: &DMatrix<f64>, h: f64) -> Result<(DMatrix<f64>, DMatrix<f64>)> {
    let (n, m) = b.shape();
    let (of_a, of_b) = (a.amax().max(1.0 / h), b.amax());
    let power = if of_b > 0.0 { (of_a / of_b).log2().round().clamp(-1000.0, 1000.0) as i32 } else { 0 };
    let mut augmented = DMatrix::zeros(n + 2 * m, n + 2 * m);
    augmented.view_mut((0, 0), (n, n)).copy_from(&(a * h));
    augmented.view_mut((0, n), (n, m)).copy_from(&b.map(|x| shift(x, power) * h));
    augmented.view_mut((n, n + m), (m, m)).fill_with_identity();
    let overflow = LinalgError::Overflow { what: "e^{Ah}" };
    if !augmented.iter().all(|x| x.is_finite()) {
        return Err(overflow);
    }
    let e = exponential(&augmented, n);
    let (ad, falling) = (e.view((0, 0), (n, n)).into_owned(), e.view((0, n + m), (n, m)).map(|x| shift(x, -power)));
    if ad.iter().chain(falling.iter()).all(|x| x.is_finite()) { Ok((ad, falling)) } else { Err(overflow) }
}

/// `X = int_0^h (s/h) e^{As} ds B` from the held part `int_0^h e^{As} ds B`, the falling part `int_0^h (1 - s/h) e^{As}
/// ds B` and `Ad = e^{Ah}`.
///
/// X is the difference of both parts, which cancel for a mode that decays within a fraction of the period, or by parts
/// the solution of `A X = Ad B - held/h`, whose right-hand side cancels for a slow mode. Where the difference loses
/// three digits or more, its entries are replaced by those that the equation gives with a digit more.
fn rising(
    (a, ad): (&DMatrix<f64>, &DMatrix<f64>),
    b: &DMatrix<f64>,
    (held, falling): (&DMatrix<f64>, &DMatrix<f64>),
    h: f64,
) -> DMatrix<f64> {
    let difference = held - falling;
    let lost = |(x, (y, z)): (&f64, (&f64, &f64))| x.abs() * 1024.0 < y.abs() + z.abs();
    if !difference.iter().zip(held.iter().zip(falling.iter())).any(lost) {
        return difference;
    }
    let Some(inverse) = a.clone().try_inverse().filter(|m| m.iter().all(|x| x.is_finite())) else {
        return difference;
    };
    let solved = &inverse * (ad * b - held / h);
    // Both errors in units of the roundoff.
    let rounding = inverse.abs() * (ad.abs() * b.abs() + held.abs() / h);
    DMatrix::from_fn(b.nrows(), b.ncols(), |i, j| {
        let cancelled = held[(i, j)].abs() + falling[(i, j)].abs();
        if rounding[(i, j)] * 16.0 < cancelled { solved[(i, j)] } else { difference[(i, j)] }
    })
}

/// The inverse of a matrix that is regular to working precision with rows and columns scaled to entries of about one. A
/// small condition needs no scaling.
fn inverse(what: &'static str, m: &DMatrix<f64>) -> Result<DMatrix<f64>> {
    match inverse_condition(what, m) {
        Ok((inverse, condition)) if condition <= WELL_CONDITIONED => Ok(inverse),
        _ => Ok(equilibrated_inverse(what, m)?.0),
    }
}

/// A condition that costs three or four digits at most.
const WELL_CONDITIONED: f64 = 4096.0;

/// The same, and the condition number of the scaled matrix.
fn equilibrated_inverse(what: &'static str, m: &DMatrix<f64>) -> Result<(DMatrix<f64>, f64)> {
    let equilibrated = Equilibrated::new(m);
    let (inverse, condition) = inverse_condition(what, &equilibrated.matrix)?;
    Ok((equilibrated.inverse_back(&inverse), condition))
}

/// The inverse of a matrix that is regular to working precision, and the condition number.
fn inverse_condition(what: &'static str, m: &DMatrix<f64>) -> Result<(DMatrix<f64>, f64)> {
    let singular = |condition| LinalgError::Singular { what, condition };
    let inverse = m.clone().try_inverse().ok_or_else(|| singular(f64::INFINITY))?;
    let condition = m.norm() * inverse.norm();
    if condition < 1.0 / f64::EPSILON { Ok((inverse, condition)) } else { Err(singular(condition)) }
}
