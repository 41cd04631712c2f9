//! Continuous Lyapunov equation `A'P + P A + Q = 0`.
//!
//! `P` exists and is unique iff no two eigenvalues of `A` add to zero. For Hurwitz `A` and `Q > 0` it is positive definite, and
//! `V(e) = e'Pe` decreases along `e' = A e` at the rate `e'Qe`: this is how every observer in this workspace gets its certificate. The
//! transposed equation `A P + P A' + Q = 0`, whose solution is a Gramian or a covariance, is this one with `A'` for `A`.
//!
//! Method: real Schur form `A = U T U'`, then `T'Y + Y T = -U'Q U` by back-substitution (Bartels and Stewart, CACM 15, 1972).

use crate::argument::{shaped, square, symmetric, unit_scale};
use crate::schur_operator::{Operator, retried_in_balanced_units, step};
use crate::separation::{nearly_singular, relative, rescaled, separation};
use crate::{Result, triangular};
use nalgebra::DMatrix;

/// Solution of `A'P + P A + Q = 0` with its evidence.
///
/// Where the equation had to be solved in balanced units of the state (see [`lyapunov()`]), the evidence is in these units.
#[derive(Debug, Clone, PartialEq)]
pub struct Lyapunov {
    /// The solution, exactly symmetric.
    pub p: DMatrix<f64>,
    /// `||A'P + P A + Q|| / (2 ||A|| ||P|| + ||Q||)` in the Frobenius norm.
    pub residual: f64,
    /// Estimate of the separation, `min ||A'X + X A||_1 / ||X||_1` (entries summed, in the coordinates of the Schur form).
    /// An upper bound, seldom more than three times too large.
    pub separation: f64,
    /// `2 ||A|| / separation`: about how much `P` may change, relative to its norm, for a unit relative change of `A`. The relative error
    /// of `P` is at most about this times `n eps`; often it is far smaller.
    pub condition: f64,
}

/// `A'P + P A + Q`, exactly symmetric for symmetric `P` and `Q`.
fn defect(a: &DMatrix<f64>, p: &DMatrix<f64>, q: &DMatrix<f64>) -> DMatrix<f64> {
    let half = p * a;
    half.transpose() + half + q
}

/// The solution alone, for iterations that need no evidence; `None` if the equation is singular to working precision.
pub(crate) fn lyapunov_step(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<Option<DMatrix<f64>>> {
    step(a, q, triangular::sylvester)
}

/// Solves `A'P + P A + Q = 0` for symmetric `P`.
///
/// `a` and `q` are n x n, `q` symmetric (of either sign: definiteness is not asked for). The answer does not depend on the units of `a` or `q`.
/// A unique `P` exists iff `lambda_i + lambda_j != 0` for all eigenvalues of `a`. If it seems not to, the equation is tried again in units of
/// the state (powers of two) in which rows and columns of `a` are of equal size. About 30 n^3 flops for `P`, and at most 22 n^3 for
/// the separation.
///
/// # Errors
/// [`LinalgError::NearlySingular`](crate::LinalgError::NearlySingular) names the two eigenvalues whose sum is nearest to zero, when the separation is not above
/// `n eps ||A||`, in the units of `a` nor in units of the state that balance it: a change of `A` within its own rounding makes the equation singular.
/// [`LinalgError::NotSymmetric`](crate::LinalgError::NotSymmetric) names the entry of `q` that differs from its mirror image;
/// [`LinalgError::NotSquare`](crate::LinalgError::NotSquare), [`LinalgError::DimensionMismatch`](crate::LinalgError::DimensionMismatch),
/// [`LinalgError::NotFinite`](crate::LinalgError::NotFinite), [`LinalgError::Overflow`](crate::LinalgError::Overflow), and those of [`schur()`](crate::schur()).
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let a = dmatrix![0.0, 1.0; -2.0, -3.0];
/// let q = dmatrix![1.0, 0.0; 0.0, 1.0];
/// let lyapunov = luenberger_linalg::lyapunov(&a, &q)?;
/// println!("P = {}residual {:e}, condition {:.1}", lyapunov.p, lyapunov.residual, lyapunov.condition);
/// assert!(lyapunov.residual <= 10.0 * 2.0 * f64::EPSILON);
/// assert!((&lyapunov.p - dmatrix![1.25, 0.25; 0.25, 0.25]).amax() <= lyapunov.condition * 2.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Bartels and Stewart, CACM 15, 1972; SLICOT SB03MD, SB03QD.
pub fn lyapunov(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<Lyapunov> {
    let n = square("a", a)?;
    shaped("q", q, n, n)?;
    let q = symmetric("q", q)?;
    retried_in_balanced_units(a, &q, solve, |found| &mut found.p)
}

fn solve(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<Lyapunov> {
    let n = a.nrows();
    let (units_a, units_q) = (unit_scale(a), unit_scale(q));
    let (a, q) = (a * units_a, q * units_q);
    let operator = Operator::new(&a, triangular::sylvester)?;
    let (p, regular) = operator.solution(&q);
    let found = separation(n, n, |d| _ = operator.solve(d), |d| operator.solve_adjoint(d));
    let size = a.norm();
    let finite = p.iter().all(|e| e.is_finite());
    if n > 0 && (!regular || !finite || found <= n as f64 * f64::EPSILON * size) {
        let values: Vec<_> = operator.schur.eigenvalues().iter().map(|l| l / units_a).collect();
        return Err(nearly_singular("Lyapunov", &values, &values, found / units_a, |x, y| (x + y).norm()));
    }
    let residual = relative(defect(&a, &p, &q).norm(), 2.0 * size * p.norm() + q.norm());
    Ok(Lyapunov {
        p: rescaled("the solution p", &p, units_a, units_q)?,
        residual,
        separation: found / units_a,
        condition: 2.0 * size / found,
    })
}
