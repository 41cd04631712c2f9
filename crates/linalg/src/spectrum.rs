//! Eigenvalues, spectral abscissa and radius, and eigenvalues of symmetric matrices with their extremes.
//!
//! General matrices use the real Schur form (`schur`), symmetric ones tridiagonalisation and faer's symmetric
//! eigensolver. Both are backward stable: each eigenvalue is exact for a matrix within a small multiple of
//! `n eps ||A||`. For a symmetric matrix this bounds the error of the eigenvalue (Weyl); for a general one the error is
//! this times the condition number of the eigenvalue, which is infinite for a defective one.

use crate::argument::{RealMatrixView, owned, square, symmetric, unit_scale};
use crate::balance::Balance;
use crate::{LinalgError, Result, SchurWorkspace, sequential};
use faer::MatRef;
use nalgebra::{Complex, DMatrix};

/// Eigenvalues of the square matrix `a`, complex pairs adjacent, the one above the real axis first. About 10 n^3 flops.
/// Units of the state that are decades apart are balanced first.
///
/// # Errors
/// Those of [`schur()`](crate::schur()).
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// // A damped oscillator, s^2 + 2 s + 5.
/// let poles = luenberger_linalg::eigenvalues(&dmatrix![0.0, 1.0; -5.0, -2.0])?;
/// let residual = (poles[0] * poles[0] + poles[0] * 2.0 + 5.0).norm();
/// println!("{} {residual:e}", poles[0]);
/// assert!(residual <= 20.0 * f64::EPSILON * 5.0);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub fn eigenvalues<'a>(a: impl Into<RealMatrixView<'a>>) -> Result<Vec<Complex<f64>>> {
    spectrum(&owned(a))
}

fn spectrum(a: &DMatrix<f64>) -> Result<Vec<Complex<f64>>> {
    square("A", a)?;
    let mut found = Vec::with_capacity(a.nrows());
    // Units of the state decades apart would cost the small eigenvalues their digits.
    let balanced = Balance::worthwhile(a);
    SchurWorkspace::new().eigenvalues(balanced.as_ref().map_or(a, |(_, balanced)| balanced), &mut found)?;
    Ok(found)
}

/// Spectral abscissa: the largest real part of the eigenvalues of `a`. `x' = A x` is stable iff it is negative.
///
/// # Errors
/// Those of [`schur()`](crate::schur()); [`LinalgError::Empty`] for order zero.
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let alpha = luenberger_linalg::spectral_abscissa(&dmatrix![0.0, 1.0; -5.0, -2.0])?;
/// assert!((alpha + 1.0).abs() <= 20.0 * f64::EPSILON * 5.0);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub fn spectral_abscissa<'a>(a: impl Into<RealMatrixView<'a>>) -> Result<f64> {
    largest("A", eigenvalues(a)?.iter().map(|l| l.re))
}

/// Spectral radius: the largest modulus of the eigenvalues of `a`. `x+ = A x` is stable iff it is below one.
///
/// # Errors
/// Those of [`schur()`](crate::schur()); [`LinalgError::Empty`] for order zero.
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let rho = luenberger_linalg::spectral_radius(&dmatrix![0.0, 0.25; -1.0, 0.0])?;
/// assert!((rho - 0.5).abs() <= 20.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub fn spectral_radius<'a>(a: impl Into<RealMatrixView<'a>>) -> Result<f64> {
    largest("A", eigenvalues(a)?.iter().map(|l| l.re.hypot(l.im)))
}

/// Eigenvalues of the symmetric matrix `m`, ascending. About 4/3 n^3 flops.
///
/// # Errors
/// [`LinalgError::NotSquare`], [`LinalgError::NotFinite`], [`LinalgError::NotSymmetric`] (an asymmetry beyond the
/// rounding of a matrix product); [`LinalgError::NotConverged`] (no such case is known).
pub fn symmetric_eigenvalues<'a>(m: impl Into<RealMatrixView<'a>>) -> Result<Vec<f64>> {
    symmetric_spectrum(&owned(m))
}

fn symmetric_spectrum(m: &DMatrix<f64>) -> Result<Vec<f64>> {
    let m = symmetric("M", m)?;
    eigenvalues_of_symmetric(&m)
}

/// [`symmetric_eigenvalues`] of a matrix that is known to be finite and exactly symmetric.
pub(crate) fn eigenvalues_of_symmetric(m: &DMatrix<f64>) -> Result<Vec<f64>> {
    let n = m.nrows();
    if n == 0 {
        return Ok(Vec::new());
    }
    let scale = unit_scale(m);
    let scaled = m * scale;
    let view = MatRef::from_column_major_slice(scaled.as_slice(), n, n);
    let found = sequential::symmetric_eigenvalues(view).ok_or_else(|| LinalgError::NotConverged {
        method: "the symmetric eigenvalue iteration",
        iterations: 30 * n,
        remaining: f64::NAN,
        allowed: f64::EPSILON * m.norm(),
    })?;
    let mut values: Vec<f64> = found.into_iter().map(|l| l / scale).collect();
    values.sort_by(f64::total_cmp);
    Ok(values)
}

/// Smallest eigenvalue of the symmetric matrix `m`, with an error of at most a small multiple of `n eps ||m||`. It is
/// no proof of definiteness; for that see the crate `luenberger-proof`.
///
/// # Errors
/// Those of [`symmetric_eigenvalues`]; [`LinalgError::Empty`] for order zero.
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let lambda = luenberger_linalg::lambda_min(&dmatrix![2.0, 1.0; 1.0, 2.0])?;
/// assert!((lambda - 1.0).abs() <= 20.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub fn lambda_min<'a>(m: impl Into<RealMatrixView<'a>>) -> Result<f64> {
    symmetric_eigenvalues(m)?.first().copied().ok_or(LinalgError::Empty { what: "M" })
}

/// Largest eigenvalue of the symmetric matrix `m`, with an error of at most a small multiple of `n eps ||m||`.
///
/// # Errors
/// Those of [`symmetric_eigenvalues`]; [`LinalgError::Empty`] for order zero.
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let lambda = luenberger_linalg::lambda_max(&dmatrix![2.0, 1.0; 1.0, 2.0])?;
/// assert!((lambda - 3.0).abs() <= 20.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub fn lambda_max<'a>(m: impl Into<RealMatrixView<'a>>) -> Result<f64> {
    symmetric_eigenvalues(m)?.last().copied().ok_or(LinalgError::Empty { what: "M" })
}

fn largest(what: &'static str, values: impl Iterator<Item = f64>) -> Result<f64> {
    values.reduce(f64::max).ok_or(LinalgError::Empty { what })
}
