//! Definiteness of a symmetric matrix, in units in which its diagonal is one.
//!
//! `V = diag(1, 1e-18)`, a noise in volts and nanometres, is as definite as `diag(1, 1)`, and `W = diag(1e6, -1e-10)`
//! has a negative variance: with `D = diag(2^e_i)`, M is definite iff `D M D` is. The signs of its eigenvalues are
//! judged where all variances are about one and the entries are correlations; rounding moves them by `4 n eps |D M D|`
//! (van der Sluis, Numer. Math. 14, 1969: no diagonal scaling is much better).

use crate::argument::{RealMatrixView, owned, symmetric};
use crate::sequential::hermitian_eigen;
use crate::units::shift;
use crate::{LinalgError, Result, lambda_min};
use nalgebra::{Cholesky, DMatrix};

/// The symmetric mean of `m`, if that is positive definite beyond rounding; `what` is its name in errors.
///
/// ```
/// use luenberger_linalg::{LinalgError, positive_definite};
/// use nalgebra::dmatrix;
/// assert!(positive_definite("V", &dmatrix![1.0, 0.0; 0.0, 1e-18]).is_ok());
/// let refused = positive_definite("V", &dmatrix![1.0, 2e-9; 2e-9, 1e-18]);
/// assert!(matches!(refused, Err(LinalgError::NotPositiveDefinite { what: "V", lambda_min }) if lambda_min < 0.0));
/// ```
/// # Errors
/// [`LinalgError::NotPositiveDefinite`]; [`LinalgError::NotSquare`], [`LinalgError::NotFinite`],
/// [`LinalgError::NotSymmetric`].
pub fn positive_definite<'a>(what: &'static str, m: impl Into<RealMatrixView<'a>>) -> Result<DMatrix<f64>> {
    let m = symmetric(what, &owned(m))?;
    match least(&m, Bound::Definite)? {
        None => Ok(m),
        Some(lambda_min) => Err(LinalgError::NotPositiveDefinite { what, lambda_min }),
    }
}

/// The symmetric mean of `m`, if that is positive semidefinite up to rounding; `what` is its name in errors. A negative
/// entry of the diagonal is no rounding.
///
/// # Errors
/// [`LinalgError::NotPositiveSemidefinite`]; [`LinalgError::NotSquare`], [`LinalgError::NotFinite`],
/// [`LinalgError::NotSymmetric`].
pub fn positive_semidefinite<'a>(what: &'static str, m: impl Into<RealMatrixView<'a>>) -> Result<DMatrix<f64>> {
    let m = symmetric(what, &owned(m))?;
    match least(&m, Bound::Semidefinite)? {
        None => Ok(m),
        Some(lambda_min) => Err(LinalgError::NotPositiveSemidefinite { what, lambda_min }),
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Bound {
    Definite,
    Semidefinite,
}

/// The exponents `e_i` with which `2^(e_i + e_j) m_ij` has a diagonal of about one. Where the diagonal is zero, the row
/// has entries of about one.
pub(crate) fn unit_diagonal(m: &DMatrix<f64>) -> Vec<i32> {
    let half = |x: f64| -(0.5 * x.log2()).round() as i32;
    let mut exponents: Vec<i32> = m.diagonal().iter().map(|&x| if x == 0.0 { 0 } else { half(x.abs()) }).collect();
    for i in (0..m.nrows()).filter(|&i| m[(i, i)] == 0.0) {
        let largest = (0..m.nrows()).map(|j| shift(m[(i, j)].abs(), exponents[j])).fold(0.0, f64::max);
        if largest > 0.0 {
            exponents[i] = -(largest.log2().round() as i32);
        }
    }
    exponents
}

/// `D M D`.
pub(crate) fn in_units(m: &DMatrix<f64>, exponents: &[i32]) -> DMatrix<f64> {
    if exponents.iter().all(|e| *e == 0) {
        return m.clone();
    }
    DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| shift(m[(i, j)], exponents[i] + exponents[j]))
}

/// A number not above zero that an eigenvalue of `m` does not exceed, unless `m` is definite (semidefinite).
fn least(m: &DMatrix<f64>, bound: Bound) -> Result<Option<f64>> {
    let diagonal = m.diagonal();
    let refused = |x: f64| if bound == Bound::Definite { x <= 0.0 } else { x < 0.0 };
    if let Some(entry) = diagonal.iter().copied().filter(|&x| refused(x)).reduce(f64::min) {
        return Ok(Some(lower(m, entry)?));
    }
    let exponents = unit_diagonal(m);
    let scaled = in_units(m, &exponents);
    let rounding = 4.0 * m.nrows() as f64 * f64::EPSILON * scaled.norm();
    let shifted = if bound == Bound::Definite { -2.0 * rounding } else { 0.5 * rounding };
    // A factor exists, at a tenth of the cost of eigenvalues.
    if Cholesky::new(&scaled + DMatrix::identity(m.nrows(), m.nrows()) * shifted).is_some() {
        return Ok(None);
    }
    let no_eigenvalues = LinalgError::NotConverged {
        method: "the eigenvalues of a symmetric matrix",
        iterations: 0,
        remaining: f64::NAN,
        allowed: rounding,
    };
    let (values, vectors) = hermitian_eigen(crate::product::view(&scaled)).ok_or(no_eigenvalues)?;
    let Some(&value) = values.first() else { return Ok(None) };
    let threshold = if bound == Bound::Definite { rounding } else { -rounding };
    if value > threshold || (value == threshold && bound == Bound::Semidefinite) {
        return Ok(None);
    }
    // The quotient of Rayleigh for D times that eigenvector: an upper bound in the units given, with the right sign.
    let square: f64 = (0..m.nrows()).map(|i| shift(vectors[(i, 0)], exponents[i]).powi(2)).sum();
    Ok(Some(lower(m, value / square)?))
}

/// The least eigenvalue of `m`, which `known` bounds from above: as computed in the units given, if that is below it by
/// more than its rounding.
fn lower(m: &DMatrix<f64>, known: f64) -> Result<f64> {
    let computed = lambda_min(m)?;
    let rounding = 4.0 * m.nrows() as f64 * f64::EPSILON * m.norm();
    Ok(if computed < known - rounding { computed } else { known })
}
