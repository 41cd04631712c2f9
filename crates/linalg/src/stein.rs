//! Discrete Lyapunov (Stein) equation `A'P A - P + Q = 0`.
//!
//! `P` exists and is unique iff no two eigenvalues of `A` multiply to one. For Schur-stable `A` and `Q > 0` it is
//! positive definite, and `V(e) = e'Pe` decreases along `e+ = A e` by `e'Qe` at each step. The transposed equation
//! `A P A' - P + Q = 0` (Gramian, covariance) is this one with `A'` for `A`.
//!
//! Method: real Schur form `A = U T U'`, then `T'Y T - Y = -U'Q U` by recursive substitution (Kitagawa, Int. J. Control
//! 25, 1977; Jonsson and Kagstrom, ACM TOMS 28, 2002).

use crate::Result;
use crate::argument::{RealMatrixView, owned};
use crate::lyapunov::{Lyapunov, SymmetricEquation};
use crate::schur_operator::{Kind, SchurEquation};
use nalgebra::DMatrix;

/// Solution of `A'P A - P + Q = 0` with residual, separation and condition.
pub type Stein = Lyapunov;

/// The solution without residual and condition; `None` if the equation is singular to working precision.
pub(crate) fn stein_step(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<Option<DMatrix<f64>>> {
    SchurEquation::step(Kind::Stein, a, q)
}

/// `A'P A - P + Q = 0` for one `A` and any number of `Q`: the Schur form is computed once, each solution costs about
/// `14 n^3`.
/// ```
/// use luenberger_linalg::SteinEquation;
/// use nalgebra::dmatrix;
/// let a = dmatrix![0.5, 1.0; 0.0, -0.5];
/// let mut equation = SteinEquation::new(&a)?;
/// for q in [dmatrix![1.0, 0.0; 0.0, 1.0], dmatrix![0.0, 0.0; 0.0, 1.0]] {
///     assert!(equation.solve(&q)?.residual <= 10.0 * 2.0 * f64::EPSILON);
/// }
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub type SteinEquation = SymmetricEquation<true>;

/// Solves `A'P A - P + Q = 0` for symmetric `P`.
///
/// `a` and `q` are n x n, `q` symmetric (definite or not). A unique `P` exists iff `lambda_i lambda_j != 1` for all
/// eigenvalues of `a`. Singular `a` is allowed. The equation is solved in balanced units of the state (powers of two,
/// rows and columns of `a` of equal size) if that makes the largest entry of `a` a thousand times smaller, or if the
/// equation seems singular otherwise. About 32 n^3 flops for `P`, and at most 33 n^3 for the separation.
///
/// # Errors
/// [`LinalgError::SingularEquation`](crate::LinalgError::SingularEquation) names two eigenvalues whose product is one:
/// the determinant of the equation is zero for `a` as stored, computed in exact integer arithmetic;
/// [`LinalgError::UndecidedEquation`](crate::LinalgError::UndecidedEquation) if a pivot of the substitution is at
/// rounding level or the separation is at most `n eps max(1, ||A||)`, and refinement does not converge (see
/// [`lyapunov()`](crate::lyapunov())); [`LinalgError::NotSymmetric`](crate::LinalgError::NotSymmetric) names the entry
/// of `q` that differs from its mirror image; [`LinalgError::Overflow`](crate::LinalgError::Overflow) if entries of `a`
/// exceed 2^250 or `P` overflows;
/// [`LinalgError::NotSquare`](crate::LinalgError::NotSquare),
/// [`LinalgError::DimensionMismatch`](crate::LinalgError::DimensionMismatch),
/// [`LinalgError::NotFinite`](crate::LinalgError::NotFinite), and those of [`schur()`](crate::schur()).
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let a = dmatrix![0.5, 1.0; 0.0, -0.5];
/// let q = dmatrix![1.0, 0.0; 0.0, 1.0];
/// let stein = luenberger_linalg::stein(&a, &q)?;
/// let defect = a.transpose() * &stein.p * &a - &stein.p + q;
/// println!("residual {:e}, {:e}", stein.residual, defect.norm());
/// assert!(stein.residual <= 10.0 * 2.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Kitagawa, Int. J. Control 25, 1977; SLICOT SB03MD (DICO = 'D').
pub fn stein<'a>(a: impl Into<RealMatrixView<'a>>, q: impl Into<RealMatrixView<'a>>) -> Result<Stein> {
    SteinEquation::solved(&owned(a), &owned(q))
}
