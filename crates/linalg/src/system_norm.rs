//! H2 and H-infinity norms of `x' = A x + B w`, `z = C x + D w` (D = 0 for H2) and of `x+ = A x + B w`.
//!
//! **H2**: `||G||_2^2 = tr(B'QB)` with `A'Q + Q A + C'C = 0` (in discrete time `A'QA - Q + C'C = 0`).
//!
//! **H-infinity**: the maximum over w of the largest singular value of `C(jw I - A)^-1 B + D`. For gamma above the norm
//! of D, gamma is a singular value at the frequency w iff `jw` is an eigenvalue of the Hamiltonian matrix
//! ```text
//! [A + B R^-1 D'C           B R^-1 B'            ]
//! [-C'(I + D R^-1 D')C      -(A + B R^-1 D'C)'   ],    R = gamma^2 I - D'D.
//! ```
//! Two-step method of N. A. Bruinsma and M. Steinbuch, Systems & Control Letters 14, 1990: gamma is set slightly above
//! the largest value found so far; the imaginary eigenvalues bound the frequency intervals with larger values, and the
//! midpoints of these intervals are evaluated next. In discrete time the bilinear transformation `z = (1 + s)/(1 - s)`
//! is applied first, which keeps the norm.

use nalgebra::{Complex, DMatrix};

use crate::argument::{RealMatrixView, owned, shaped, square, symmetric_part};
use crate::{LinalgError, Result, eigenvalues, lyapunov, stein};

/// Relative gap allowed between the returned value and the norm.
const CLOSENESS: f64 = 1e-9;
const ITERATIONS: usize = 40;

/// The H-infinity norm of a system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HInfinityNorm {
    /// The largest singular value found. It is attained; the norm is at most larger by a relative 1e-9, up to rounding.
    pub norm: f64,
    /// Frequency at which it is attained, in radians per unit of time; infinite for the norm of D. In discrete time an
    /// angle in radians per sample, from 0 to pi.
    pub frequency: f64,
}

/// The H2 norm of `C(sI - A)^-1 B` for a Hurwitz A.
///
/// `a` is n x n, `b` n x m, `c` p x n.
///
/// ```
/// use luenberger_linalg::h2_norm;
/// use nalgebra::dmatrix;
/// // 1/(s + 2): the integral of exp(-4 t) is 1/4.
/// assert!((h2_norm(&dmatrix![-2.0], &dmatrix![1.0], &dmatrix![1.0])? - 0.5).abs() < 1e-15);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// # Errors
/// [`LinalgError::NotStable`] names an eigenvalue that is not in the open left half plane; [`LinalgError::NotSquare`],
/// [`LinalgError::DimensionMismatch`], [`LinalgError::NotFinite`], and those of [`lyapunov()`].
pub fn h2_norm<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
) -> Result<f64> {
    h2(&owned(a), &owned(b), &owned(c))
}

fn h2(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<f64> {
    check(a, b, c)?;
    // Otherwise tr(B'QB) may be any number.
    if let Some(eigenvalue) = eigenvalues(a)?.into_iter().find(|lambda| lambda.re >= 0.0) {
        return Err(LinalgError::NotStable { equation: "Lyapunov", eigenvalue });
    }
    let q = lyapunov(a, &symmetric_part(&(c.transpose() * c)))?.p;
    Ok((b.transpose() * q * b).trace().max(0.0).sqrt())
}

/// The H2 norm of `C(zI - A)^-1 B` for A with all eigenvalues inside the unit circle. Otherwise as [`h2_norm`].
///
/// # Errors
/// [`LinalgError::NotStable`] names an eigenvalue that is not inside the unit circle; [`LinalgError::NotSquare`],
/// [`LinalgError::DimensionMismatch`], [`LinalgError::NotFinite`], and those of [`stein()`].
pub fn discrete_h2_norm<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
) -> Result<f64> {
    discrete_h2(&owned(a), &owned(b), &owned(c))
}

fn discrete_h2(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<f64> {
    check(a, b, c)?;
    if let Some(eigenvalue) = eigenvalues(a)?.into_iter().find(|lambda| lambda.norm() >= 1.0) {
        return Err(LinalgError::NotStable { equation: "Stein", eigenvalue });
    }
    let q = stein(a, &symmetric_part(&(c.transpose() * c)))?.p;
    Ok((b.transpose() * q * b).trace().max(0.0).sqrt())
}

/// The H-infinity norm of `C(sI - A)^-1 B + D` for a Hurwitz A.
///
/// `a` is n x n, `b` n x m, `c` p x n, `d` p x m. Whether A is Hurwitz is not tested.
///
/// ```
/// use luenberger_linalg::h_infinity_norm;
/// use nalgebra::dmatrix;
/// // 1/(s^2 + 0.2 s + 1): the peak is 1/(2 zeta sqrt(1 - zeta^2)) for zeta = 0.1.
/// let (a, b, c) = (dmatrix![0.0, 1.0; -1.0, -0.2], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]);
/// let found = h_infinity_norm(&a, &b, &c, &dmatrix![0.0])?;
/// assert!((found.norm - 1.0 / (0.2 * 0.99f64.sqrt())).abs() < 1e-8);
/// assert!((found.frequency - 0.98f64.sqrt()).abs() < 1e-4);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// # Errors
/// [`LinalgError::NotSquare`], [`LinalgError::DimensionMismatch`], [`LinalgError::NotFinite`], and those of
/// [`eigenvalues`]; [`LinalgError::NotConverged`] after 40 steps.
pub fn h_infinity_norm<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
    d: impl Into<RealMatrixView<'a>>,
) -> Result<HInfinityNorm> {
    h_infinity(&owned(a), &owned(b), &owned(c), &owned(d))
}

fn h_infinity(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>, d: &DMatrix<f64>) -> Result<HInfinityNorm> {
    let n = check(a, b, c)?;
    shaped("D", d, c.nrows(), b.ncols())?;
    let at = |frequency: f64| {
        let s = Complex::new(0.0, frequency);
        let shifted = DMatrix::from_fn(n, n, |i, j| {
            let entry = Complex::from(-a[(i, j)]);
            if i == j { s + entry } else { entry }
        });
        let response =
            shifted.lu().solve(&b.map(Complex::from)).map(|x| c.map(Complex::from) * x + d.map(Complex::from));
        response.map_or(0.0, |m| largest(&m))
    };
    let mut best = HInfinityNorm { norm: largest(&d.map(Complex::from)), frequency: f64::INFINITY };
    let attempt = |frequency: f64, best: &mut HInfinityNorm| {
        let value = at(frequency);
        if value > best.norm {
            *best = HInfinityNorm { norm: value, frequency };
        }
    };
    attempt(0.0, &mut best);
    for pole in eigenvalues(a)? {
        attempt(pole.norm(), &mut best);
        attempt(pole.im.abs(), &mut best);
    }
    let scale = a.norm() + 1.0;
    for _ in 0..ITERATIONS {
        if best.norm == 0.0 {
            return Ok(best);
        }
        let gamma = best.norm * (1.0 + CLOSENESS);
        let r = DMatrix::identity(d.ncols(), d.ncols()) * (gamma * gamma) - d.transpose() * d;
        let Some(r) = r.cholesky() else { return Ok(best) };
        let fed = r.solve(&(d.transpose() * c));
        let first = a + b * &fed;
        let corner = b * r.solve(&b.transpose());
        let lower = -(c.transpose() * (c + d * &fed));
        let mut hamiltonian = DMatrix::zeros(2 * n, 2 * n);
        hamiltonian.view_mut((0, 0), (n, n)).copy_from(&first);
        hamiltonian.view_mut((0, n), (n, n)).copy_from(&corner);
        hamiltonian.view_mut((n, 0), (n, n)).copy_from(&lower);
        hamiltonian.view_mut((n, n), (n, n)).copy_from(&-first.transpose());
        // Near the maximum two eigenvalues meet on the axis: rounding moves them by the square root of eps.
        let near = 1e-7 * scale.max(hamiltonian.norm() * 1e-3);
        let mut crossings: Vec<f64> =
            eigenvalues(&hamiltonian)?.iter().filter(|z| z.re.abs() <= near && z.im >= 0.0).map(|z| z.im).collect();
        crossings.sort_by(f64::total_cmp);
        let before = best.norm;
        crossings.first().copied().into_iter().for_each(|first| attempt(0.5 * first, &mut best));
        for pair in crossings.windows(2) {
            attempt(0.5 * (pair[0] + pair[1]), &mut best);
        }
        for crossing in &crossings {
            attempt(*crossing, &mut best);
        }
        if best.norm <= before * (1.0 + CLOSENESS) {
            return Ok(best);
        }
    }
    Err(LinalgError::NotConverged {
        method: "the bisection of the H-infinity norm",
        iterations: ITERATIONS,
        remaining: best.norm,
        allowed: CLOSENESS * best.norm,
    })
}

/// The H-infinity norm of `C(zI - A)^-1 B + D` for A with all eigenvalues inside the unit circle.
///
/// # Errors
/// As [`h_infinity_norm`].
pub fn discrete_h_infinity_norm<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
    d: impl Into<RealMatrixView<'a>>,
) -> Result<HInfinityNorm> {
    discrete_h_infinity(&owned(a), &owned(b), &owned(c), &owned(d))
}

fn discrete_h_infinity(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    c: &DMatrix<f64>,
    d: &DMatrix<f64>,
) -> Result<HInfinityNorm> {
    let n = check(a, b, c)?;
    shaped("D", d, c.nrows(), b.ncols())?;
    let identity = DMatrix::identity(n, n);
    let plus = (a + &identity).lu();
    let singular = LinalgError::NotFinite { what: "(A + I)^-1", row: 0, col: 0, value: f64::INFINITY };
    let inverse = plus.solve(&identity).ok_or(singular)?;
    let shifted = &inverse * (a - &identity);
    let (half, root) = (&inverse * b, std::f64::consts::SQRT_2);
    let found = h_infinity(&shifted, &(&half * root), &(c * &inverse * root), &(d - c * &half))?;
    Ok(HInfinityNorm { frequency: 2.0 * found.frequency.atan(), ..found })
}

/// The order of (A, B, C), if their shapes fit and their entries are finite.
fn check(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<usize> {
    let n = square("A", a)?;
    shaped("B", b, n, b.ncols())?;
    shaped("C", c, c.nrows(), n)?;
    Ok(n)
}

fn largest(m: &DMatrix<Complex<f64>>) -> f64 {
    if m.is_empty() { 0.0 } else { m.clone().svd(false, false).singular_values.max() }
}
