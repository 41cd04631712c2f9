//! Conversion by matched poles and zeros.

use nalgebra::{Complex, DMatrix};

use super::{Realization, period};
use crate::spectrum::eigenvalues;
use crate::zeros::invariant_zeros;
use crate::{LinalgError, Result};

/// A transfer function `gain prod(z - zeros) / prod(z - poles)`.
#[derive(Debug, Clone, PartialEq)]
pub struct ZerosPolesGain {
    /// The finite zeros.
    pub zeros: Vec<Complex<f64>>,
    /// The poles.
    pub poles: Vec<Complex<f64>>,
    /// The gain.
    pub gain: f64,
}

/// Discrete-time transfer function of a plant with one input and one output, by matched poles and zeros (`matched` of
/// MATLAB's `c2d`): each finite pole and zero `s` becomes `e^{sh}`, and the gain at frequency zero is kept.
///
/// Zeros at infinity stay there, as in python-control's `c2d` (Franklin, Powell and Workman, section 6.2, place them at
/// -1). With a pole or zero of multiplicity k at `s = 0` the gain of `s^k H(s)` or `s^-k H(s)` is kept, `(z - 1)/h` for
/// `s`. Hidden modes are poles and zeros at once, and cancel.
///
/// # Errors
/// [`LinalgError::DimensionMismatch`] for more than one input or output; [`LinalgError::InvalidPeriod`];
/// [`LinalgError::Empty`] if the transfer function is zero; those of [`invariant_zeros`].
///
/// # Example
/// ```
/// use luenberger_linalg::{Realization, c2d_matched};
/// use nalgebra::dmatrix;
///
/// let lag = Realization::new(&dmatrix![-2.0], &dmatrix![2.0], &dmatrix![1.0], &dmatrix![0.0])?;
/// let matched = c2d_matched(&lag, 0.1)?;
/// let pole: f64 = (-0.2_f64).exp();
/// assert!((matched.poles[0].re - pole).abs() < 1e-15 && (matched.gain - (1.0 - pole)).abs() < 1e-15);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub fn c2d_matched(system: &Realization, h: f64) -> Result<ZerosPolesGain> {
    system.check()?;
    let h = period(h)?;
    let Realization { a, b, c, d } = system;
    if (c.nrows(), b.ncols()) != (1, 1) {
        return Err(LinalgError::DimensionMismatch {
            what: "D (one input and one output)",
            expected: (1, 1),
            found: d.shape(),
        });
    }
    let (poles, zeros) = (eigenvalues(a)?, invariant_zeros(a, b, c, d)?);
    if zeros.normal_rank == 0 {
        return Err(LinalgError::Empty { what: "the transfer function" });
    }
    let zeros = zeros.zeros;
    let gain = gain(system, &zeros, &poles)?;
    // A pole computed as 1e-17 is one at zero.
    let size = poles.iter().chain(&zeros).map(|s| s.norm()).fold(0.0, f64::max);
    let is_zero = |s: &Complex<f64>| s.norm() <= 1e3 * f64::EPSILON * size;
    let image = |s: &Complex<f64>| if is_zero(s) { Complex::from(1.0) } else { (s * h).exp() };
    // What each factor contributes at frequency zero: -s before, 1 - e^{sh} after; at zero s before, (z - 1) = s h
    // after.
    let ratio = |s: &Complex<f64>| if is_zero(s) { Complex::from(1.0 / h) } else { -s / (1.0 - image(s)) };
    let product = |list: &[Complex<f64>]| list.iter().map(ratio).product::<Complex<f64>>();
    let gain = (product(&zeros) / product(&poles) * gain).re;
    let images = |list: Vec<Complex<f64>>| list.iter().map(image).collect();
    Ok(ZerosPolesGain { zeros: images(zeros), poles: images(poles), gain })
}

/// The factor k of `H(s) = k prod(s - zeros) / prod(s - poles)`, from the value at a point away from all of them.
fn gain(system: &Realization, zeros: &[Complex<f64>], poles: &[Complex<f64>]) -> Result<f64> {
    let size = zeros.iter().chain(poles).map(|s| s.norm()).fold(0.0, f64::max);
    let s = Complex::from(2.0 * size.max(f64::MIN_POSITIVE.sqrt()));
    let s = if size == 0.0 { Complex::from(1.0) } else { s };
    let n = system.a.nrows();
    let complex = |m: &DMatrix<f64>| m.map(Complex::from);
    let pencil = DMatrix::identity(n, n) * s - complex(&system.a);
    let singular = || LinalgError::Singular { what: "s I - A", condition: f64::INFINITY };
    let states = pencil.lu().solve(&complex(&system.b)).ok_or_else(singular)?;
    let value = (complex(&system.c) * states + complex(&system.d))[0];
    let factors = |list: &[Complex<f64>]| list.iter().map(|z| s - z).product::<Complex<f64>>();
    Ok((value * factors(poles) / factors(zeros)).re)
}

impl ZerosPolesGain {
    /// The controllable companion form `x+ = A x + B u, y = C x + D u`.
    ///
    /// Its conditioning grows fast with the order; poles and zeros themselves are more accurate.
    pub fn realization(&self) -> Realization {
        let n = self.poles.len();
        let (numerator, denominator) = (polynomial(&self.zeros), polynomial(&self.poles));
        let coefficient = |power: usize| numerator.get(power).map_or(0.0, |x| self.gain * x);
        let d = coefficient(n);
        let a = DMatrix::from_fn(n, n, |i, j| match (i + 1 == n, j == i + 1) {
            (true, _) => -denominator[j],
            (false, true) => 1.0,
            (false, false) => 0.0,
        });
        let b = DMatrix::from_fn(n, 1, |i, _| if i + 1 == n { 1.0 } else { 0.0 });
        let c = DMatrix::from_fn(1, n, |_, j| coefficient(j) - d * denominator[j]);
        Realization { a, b, c, d: DMatrix::from_element(1, 1, d) }
    }
}

/// Coefficients of the monic polynomial with these roots, the constant first.
fn polynomial(roots: &[Complex<f64>]) -> Vec<f64> {
    let mut coefficients = vec![Complex::from(1.0)];
    for root in roots {
        let mut next = vec![Complex::from(0.0); coefficients.len() + 1];
        for (k, x) in coefficients.iter().enumerate() {
            next[k + 1] += x;
            next[k] -= root * x;
        }
        coefficients = next;
    }
    coefficients.into_iter().map(|x| x.re).collect()
}
