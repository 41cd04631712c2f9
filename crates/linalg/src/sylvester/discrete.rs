//! Discrete Sylvester equation `A X B - X + C = 0`.
//!
//! `X` exists and is unique iff no eigenvalue of `A` is the inverse of one of `B`. If the product of the spectral radii
//! is below one, it is the sum of `A^k C B^k`: the cross-covariance or cross-Gramian of two discrete-time systems. With
//! `A'` in place of A and A in place of B it is the Stein equation, without the symmetry. `T A - F T = G C` with a
//! regular `A`, the change of coordinates of a discrete-time Luenberger observer, is this equation with `F` for A and
//! `A^-1` for B; it is also a Sylvester equation without inverting A.
//!
//! Method: real Schur forms `A = U S U'`, `B = V T V'`, then `S Y T - Y = -U'C V` by recursive substitution (Kitagawa,
//! Int. J. Control 25, 1977; Jonsson and Kagstrom, ACM TOMS 28, 2002, II).

use super::{PairEquation, Sylvester};
use crate::Result;
use crate::argument::{RealMatrixView, owned};

/// Solution of `A X B - X + C = 0` with residual, separation and condition.
/// ```
/// use nalgebra::dmatrix;
/// let (a, b) = (dmatrix![0.5, 1024.0; 0.0, 0.25], dmatrix![0.5]);
/// let x = dmatrix![1.0; 3.0];
/// let found = luenberger_linalg::discrete_sylvester(&a, &b, &(&x - &a * &x * &b))?;
/// assert!((&found.x - &x).norm() / x.norm() <= found.forward_error());
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub type DiscreteSylvester = Sylvester;

/// `A X B - X + C = 0` for one pair `(A, B)` and any number of `C`: the Schur forms are computed once, each solution
/// costs about `6 n m (n + m)`.
/// ```
/// use luenberger_linalg::DiscreteSylvesterEquation;
/// use nalgebra::dmatrix;
/// let (a, b) = (dmatrix![0.0, 1.0; -0.5, -1.0], dmatrix![3.0]);
/// let mut equation = DiscreteSylvesterEquation::new(&a, &b)?;
/// for c in [dmatrix![1.0; 2.0], dmatrix![0.0; 1.0]] {
///     assert!(equation.solve(&c)?.residual <= 10.0 * 2.0 * f64::EPSILON);
/// }
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub type DiscreteSylvesterEquation = PairEquation<true>;

/// Solves `A X B - X + C = 0`.
///
/// `a` is n x n, `b` m x m, `c` n x m. A unique `X` exists iff `lambda_i(A) lambda_j(B) != 1` for all i, j. Singular
/// coefficients are allowed, and so are very different sizes with a moderate product (`A` of 1e200 with `B` of 1e-200).
/// About `25 (n^3 + m^3) + 6 n m (n + m)` flops, and `6 n m (n + m)` for the separation. For several `c` see
/// [`DiscreteSylvesterEquation`].
///
/// Other conventions: MATLAB's `dlyap(A, B, C)` solves this same equation; `X + A X B = C` (SLICOT SB04QD) is
/// `discrete_sylvester(&-a, &b, &c)`; `A X Q' - X + C = 0` (python-control's `dlyap(A, Q, C)`) is
/// `discrete_sylvester(&a, &q.transpose(), &c)`.
///
/// # Errors
/// [`SingularEquation`](crate::LinalgError::SingularEquation) names eigenvalues of `a` and `b` whose product is one:
/// the determinant of the equation is zero for the coefficients as stored, computed in exact integer arithmetic;
/// [`UndecidedEquation`](crate::LinalgError::UndecidedEquation) if a pivot of the substitution is at rounding level or
/// the separation is at most `max(n, m) eps max(1, sqrt(||A|| ||B||))`, and refinement does not converge (see
/// [`lyapunov()`](crate::lyapunov())); [`Overflow`](crate::LinalgError::Overflow) if the product of the largest entries
/// of `a` and `b` exceeds 2^500, or `X` overflows; [`NotSquare`](crate::LinalgError::NotSquare),
/// [`DimensionMismatch`](crate::LinalgError::DimensionMismatch), [`NotFinite`](crate::LinalgError::NotFinite), and
/// those of [`schur()`](crate::schur()).
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let a = dmatrix![0.5, 1.0; -0.5, 0.0];
/// let b = dmatrix![0.25];
/// let c = dmatrix![1.0; 2.0];
/// let found = luenberger_linalg::discrete_sylvester(&a, &b, &c)?;
/// let defect = &a * &found.x * &b - &found.x + &c;
/// println!("residual {:e}, {:e}", found.residual, defect.norm());
/// assert!(found.residual <= 10.0 * 2.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Golub, Nash and Van Loan, IEEE TAC 24, 1979; Jonsson and Kagstrom, ACM TOMS 28, 2002, II; SLICOT SB04QD.
pub fn discrete_sylvester<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
) -> Result<DiscreteSylvester> {
    DiscreteSylvesterEquation::solved(&owned(a), &owned(b), &owned(c))
}
