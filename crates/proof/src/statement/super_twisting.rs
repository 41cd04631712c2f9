//! The matrix inequality of Moreno and Osorio for the super-twisting observer.
//!
//! `A = [-k1 1; -2 k2 0]`, `B = (0, 1)`, `C = (1, 0)`: twice the matrices of the error in the coordinates
//! `(|e1|^(1/2) sign(e1), e2)`, so that no entry is rounded. The inequalities are
//! ```text
//! P > 0,    [A'P + PA + 2 alpha P + 2 bound^2 C'C, 2PB; *, -2] < 0,    c^2 P - C'C >= 0.
//! ```

use super::{Expression, number};
use crate::definite::{self, Direction, Sense};
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::Verdict;

struct Decrease<'a> {
    gains: (f64, f64, f64),
    p: &'a Matrix<f64>,
    alpha: f64,
}

impl Expression for Decrease<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let (k1, k2, bound) = self.gains;
        let (k1, k2, bound) = (number::<R>(k1, "k1")?, number::<R>(k2, "k2")?, number::<R>(bound, "the bound")?);
        let p = super::embed_symmetric::<R>(self.p, "P", 2)?;
        let one = number::<R>(1.0, "1")?;
        let alpha = number::<R>(self.alpha, "alpha")?;
        let a = Matrix::from_rows([[k1.neg(), one.clone()], [k2.add(&k2).neg(), R::zero()]]);
        let mut flow = p.product(&a.sum(&Matrix::scalar(2, &alpha))?)?.plus_transpose()?;
        let square = bound.mul(&bound);
        let entry = flow[(0, 0)].add(&square.add(&square));
        flow[(0, 0)] = entry;
        let corner = Matrix::from_rows([[p[(0, 1)].add(&p[(0, 1)])], [p[(1, 1)].add(&p[(1, 1)])]]);
        let last = Matrix::from_rows([[one.add(&one).neg()]]);
        flow.bordered(&corner, &last)
    }
}

struct Reach<'a> {
    p: &'a Matrix<f64>,
    c: f64,
}

impl Expression for Reach<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let c = number::<R>(self.c, "c")?;
        let mut m = super::embed_symmetric::<R>(self.p, "P", 2)?.scaled(&c.mul(&c));
        let entry = m[(0, 0)].sub(&number(1.0, "1")?);
        m[(0, 0)] = entry;
        Ok(m)
    }
}

/// The three inequalities for `(k1, k2, bound)`, P, and `(alpha, c)`.
///
/// ```
/// use luenberger_proof::{Matrix, statement::super_twisting};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// let p = Matrix::from_rows([[0.5, -0.0625], [-0.0625, 0.0625]]);
/// // k1 = k2 = 4 against a disturbance up to 1; with k2 below the bound nothing can be proved.
/// let with = |k2| super_twisting((4.0, k2, 1.0), &p, (0.1, 1.6));
/// assert!(with(4.0)?.iter().all(luenberger_proof::Verdict::is_proved));
/// assert!(with(0.5)?[1].is_refuted());
/// # Ok(())
/// # }
/// ```
/// # Errors
/// [`ProofError`] for numbers that are not finite, or a P that is not 2 x 2 and symmetric.
pub fn super_twisting(
    gains: (f64, f64, f64),
    p: &Matrix<f64>,
    (alpha, c): (f64, f64),
) -> Result<[Verdict<Direction>; 3], ProofError> {
    p.expect_shape("P", (2, 2))?;
    Ok([
        definite::decide(p, Sense::PositiveDefinite)?,
        Decrease { gains, p, alpha }.decide(Sense::NegativeDefinite)?,
        Reach { p, c }.decide(Sense::PositiveSemidefinite)?,
    ])
}
