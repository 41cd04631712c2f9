//! Discrete Lyapunov (Stein) equation `A'P A - P + Q = 0`.
//!
//! `P` exists and is unique iff no two eigenvalues of `A` multiply to one. For Schur-stable `A` and `Q > 0` it is positive definite, and
//! `V(e) = e'Pe` decreases along `e+ = A e` by `e'Qe` at each step. The transposed equation `A P A' - P + Q = 0` (Gramian, covariance) is this
//! one with `A'` for `A`.
//!
//! Method: real Schur form `A = U T U'`, then `T'Y T - Y = -U'Q U` by back-substitution (Kitagawa, Int. J. Control 25, 1977).

use crate::argument::{shaped, square, symmetric, unit_scale};
use crate::schur_operator::{Operator, retried_in_balanced_units, step};
use crate::separation::{nearly_singular, relative, rescaled, separation};
use crate::{LinalgError, Result, triangular};
use nalgebra::{Complex, DMatrix};

/// Solution of `A'P A - P + Q = 0` with its evidence.
///
/// Where the equation had to be solved in balanced units of the state (see [`stein()`]), the evidence is in these units.
#[derive(Debug, Clone, PartialEq)]
pub struct Stein {
    /// The solution, exactly symmetric.
    pub p: DMatrix<f64>,
    /// `||A'P A - P + Q|| / ((||A||^2 + 1) ||P|| + ||Q||)` in the Frobenius norm.
    pub residual: f64,
    /// Estimate of the separation, `min ||A'X A - X||_1 / ||X||_1` (entries summed, in the coordinates of the Schur form).
    /// An upper bound, seldom more than three times too large.
    pub separation: f64,
    /// `(||A||^2 + 1) / separation`: about how much `P` may change, relative to its norm, for a unit relative change of the data.
    /// The relative error of `P` is at most about this times `n eps`; often it is far smaller.
    pub condition: f64,
}

/// The solution alone, for iterations that need no evidence; `None` if the equation is singular to working precision.
pub(crate) fn stein_step(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<Option<DMatrix<f64>>> {
    step(a, q, triangular::stein)
}

/// Solves `A'P A - P + Q = 0` for symmetric `P`.
///
/// `a` and `q` are n x n, `q` symmetric (of either sign). A unique `P` exists iff `lambda_i lambda_j != 1` for all eigenvalues of `a`. Singular `a` is
/// allowed. If there seems to be none, the equation is tried again in units of the state (powers of two) in which rows and columns of `a` are of equal size. About 32 n^3 flops for `P`, and at most 33 n^3 for the separation.
///
/// # Errors
/// [`LinalgError::NearlySingular`] names the two eigenvalues whose product is nearest to one, when a pivot of the substitution
/// vanishes against its rounding or the separation is not above `n eps max(1, ||A||)`;
/// [`LinalgError::NotSymmetric`] names the entry of `q` that differs from its mirror image;
/// [`LinalgError::Overflow`] if `a` has entries beyond 2^250, whose products leave the range, or `P` does;
/// [`LinalgError::NotSquare`], [`LinalgError::DimensionMismatch`], [`LinalgError::NotFinite`], and those of [`schur()`](crate::schur()).
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
pub fn stein(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<Stein> {
    let n = square("a", a)?;
    shaped("q", q, n, n)?;
    let q = symmetric("q", q)?;
    retried_in_balanced_units(a, &q, solve, |found| &mut found.p)
}

fn solve(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<Stein> {
    let n = a.nrows();
    if a.amax() > 2.0_f64.powi(250) {
        return Err(LinalgError::Overflow { what: "the product of entries of a" });
    }
    let units_q = unit_scale(q);
    let q = q * units_q;
    let operator = Operator::new(a, triangular::stein)?;
    let (p, regular) = operator.solution(&q);
    let found = separation(n, n, |d| _ = operator.solve(d), |d| operator.solve_adjoint(d));
    let size = a.norm();
    let finite = p.iter().all(|e| e.is_finite());
    if n > 0 && (!regular || !finite || found <= n as f64 * f64::EPSILON * size.max(1.0)) {
        let values = operator.schur.eigenvalues();
        let one = Complex::new(1.0, 0.0);
        return Err(nearly_singular("Stein", &values, &values, found, |x, y| (x * y - one).norm()));
    }
    let defect = a.transpose() * &p * a - &p + &q;
    let weight = size * size + 1.0;
    Ok(Stein {
        residual: relative(defect.norm(), weight * p.norm() + q.norm()),
        p: rescaled("the solution p", &p, 1.0, units_q)?,
        separation: found,
        condition: weight / found,
    })
}
