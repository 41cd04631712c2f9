//! Conversion by matched poles and zeros.

use nalgebra::{Complex, DMatrix};

use super::{Realization, period};
use crate::exactly_singular::{characteristic_of, prime_below, residue};
use crate::rosenbrock::Rosenbrock;
use crate::spectrum::eigenvalues;
use crate::units::shift;
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
/// `s`: of a small pole or zero the same factor is kept, up to the order of `s h`, so that it does not matter which of
/// the two it is. Poles and zeros are exactly 1 where the matrices as stored have them at 0. Hidden modes are poles and
/// zeros at once, and cancel.
///
/// # Errors
/// [`LinalgError::DimensionMismatch`] for more than one input or output; [`LinalgError::InvalidPeriod`];
/// [`LinalgError::Empty`] if the transfer function is zero; [`LinalgError::Overflow`] for a root
/// or a gain beyond the range of a double; those of [`invariant_zeros`].
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
    let (mut poles, zeros) = (eigenvalues(&system.balanced()?.0.a)?, invariant_zeros(a, b, c, d)?);
    if zeros.normal_rank == 0 {
        return Err(LinalgError::Empty { what: "the transfer function" });
    }
    let mut zeros = zeros.zeros;
    let exact = at_zero(system);
    set_least_to_zero(&mut poles, exact.poles);
    set_least_to_zero(&mut zeros, exact.zeros);
    let overflow = LinalgError::Overflow { what: "the transfer function at matched poles and zeros" };
    let gain = gain(system, &zeros, &poles, h)?;
    let images = |list: Vec<Complex<f64>>| list.iter().map(|s| (s * h).exp()).collect::<Vec<_>>();
    let (zeros, poles) = (images(zeros), images(poles));
    let finite = zeros.iter().chain(&poles).all(|z| z.re.is_finite() && z.im.is_finite());
    if finite && gain.is_finite() { Ok(ZerosPolesGain { zeros, poles, gain }) } else { Err(overflow) }
}

/// Multiplicities of the pole and of the zero at the origin.
struct AtZero {
    poles: usize,
    zeros: usize,
}

/// How often the plant as stored has a pole and a zero at 0, in integers modulo a prime: `det(s I - A)` and
/// `C adj(s I - A) B + D det(s I - A) = det(s I - A + B C) - (1 - D) det(s I - A)` have so many vanishing coefficients.
/// An eigenvalue computed as 1e-8 does not tell an integrator from a slow mode. A prime that divides a coefficient by
/// chance (one in 2^31) would make a slow mode an integrator; two primes are asked.
fn at_zero(system: &Realization) -> AtZero {
    let Realization { a, b, c, d } = system;
    let n = a.nrows();
    let first = prime_below(1 << 31);
    let found = [first, prime_below(first)].map(|p| {
        let entries = |m: &DMatrix<f64>| m.map(|x| residue(x, p));
        let (of_a, of_b, of_c) = (entries(a), entries(b), entries(c));
        let lowered = DMatrix::from_fn(n, n, |i, j| (of_a[(i, j)] + (p - of_b[i]) * of_c[j]) % p);
        let (poles, with) = (characteristic_of(of_a, p), characteristic_of(lowered, p));
        let rest = (p + 1 - residue(d[0], p)) % p;
        let numerator = with.iter().zip(&poles).map(|(x, y)| (x + (p - rest) * y) % p);
        let leading_zeros = |list: &mut dyn Iterator<Item = u64>| list.take_while(|x| *x == 0).count();
        (leading_zeros(&mut poles.iter().copied()), leading_zeros(&mut numerator.into_iter()))
    });
    AtZero { poles: found[0].0.min(found[1].0), zeros: found[0].1.min(found[1].1) }
}

/// The `count` entries of least modulus become zero.
fn set_least_to_zero(list: &mut [Complex<f64>], count: usize) {
    list.sort_by(|x, y| x.norm().total_cmp(&y.norm()));
    list.iter_mut().take(count).for_each(|s| *s = Complex::from(0.0));
}

/// A complex number times a power of two: products over many poles do not overflow.
struct Scaled {
    mantissa: Complex<f64>,
    exponent: i32,
}

impl Scaled {
    fn times(self, factor: Complex<f64>) -> Self {
        let product = self.mantissa * factor;
        let size = product.re.abs().max(product.im.abs());
        if size == 0.0 || !size.is_finite() {
            return Self { mantissa: product, ..self };
        }
        let power = size.log2().floor() as i32;
        let mantissa = Complex::new(shift(product.re, -power), shift(product.im, -power));
        Self { mantissa, exponent: self.exponent + power }
    }
}

/// The gain after the conversion: that of `H(s) = k prod(s - zeros) / prod(s - poles)` with a factor for each root.
///
/// k is taken from the value of H at a real point beyond all roots and of the size of the plant, in balanced units. In
/// `H(0)` a root s contributes `-s` before and `1 - e^{sh}` after: their ratio is smooth, 1/h at s = 0, and tells
/// nothing of whether a small root is one at zero.
fn gain(system: &Realization, zeros: &[Complex<f64>], poles: &[Complex<f64>], h: f64) -> Result<f64> {
    let scaled = Rosenbrock::new(&system.a, &system.b, &system.c, &system.d)?;
    let (n, time) = (system.a.nrows(), scaled.time());
    let complex = |z: &Complex<f64>, power: i32| Complex::new(shift(z.re, power), shift(z.im, power));
    let roots = || zeros.iter().chain(poles).map(|z| complex(z, -time));
    let size = roots().map(Complex::norm).fold(scaled.a.norm(), f64::max);
    let point = if size > 0.0 { 2.0 * size } else { 1.0 };
    let pencil = DMatrix::identity(n, n) * point - &scaled.a;
    let singular = || LinalgError::Singular { what: "s I - A", condition: f64::INFINITY };
    let states = pencil.lu().solve(&scaled.b).ok_or_else(singular)?;
    let value = (&scaled.c * states + &scaled.d)[0];
    // A factor of the given value over that of the converted one: `(s0 - s)` over `s / (e^{sh} - 1)`, time in units of
    // the plant.
    let period = shift(h, time);
    let factor = |z: Complex<f64>| (point - z) * period * exponential_quotient(z * period);
    let mut found = Scaled { mantissa: Complex::from(value), exponent: scaled.gain_power() };
    let mut inverted = zeros.iter();
    // Alternating, so that mantissas stay near one.
    for pole in poles {
        found = found.times(factor(complex(pole, -time)));
        if let Some(zero) = inverted.next() {
            found = found.times(factor(complex(zero, -time)).inv());
        }
    }
    for zero in inverted {
        found = found.times(factor(complex(zero, -time)).inv());
    }
    Ok(shift(found.mantissa.re, found.exponent))
}

/// `(e^x - 1) / x`, accurate near zero.
fn exponential_quotient(x: Complex<f64>) -> Complex<f64> {
    if x.norm() == 0.0 {
        return Complex::from(1.0);
    }
    let half = (0.5 * x.im).sin();
    Complex::new(x.re.exp_m1() * x.im.cos() - 2.0 * half * half, x.re.exp() * x.im.sin()) / x
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
