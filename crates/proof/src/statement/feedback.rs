//! Observer-based feedback: the block inequality (25) of Share Pasand.

use super::lyapunov::error_matrix;
use super::{Expression, embed, embed_symmetric};
use crate::definite::{Direction, Sense};
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::Verdict;

struct Block<'a> {
    a: &'a Matrix<f64>,
    b: &'a Matrix<f64>,
    k: &'a Matrix<f64>,
    l: &'a Matrix<f64>,
    c: &'a Matrix<f64>,
    p1: &'a Matrix<f64>,
    p: &'a Matrix<f64>,
}

impl Expression for Block<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let n = self.a.rows();
        let m = self.b.cols();
        let a = embed::<R>(self.a, "A", (n, n))?;
        let bk = embed::<R>(self.b, "B", (n, m))?.product(&embed(self.k, "K", (m, n))?)?;
        let p1 = embed_symmetric::<R>(self.p1, "P1", n)?;
        let p = embed_symmetric::<R>(self.p, "P", n)?;
        let plant = p1.product(&a.difference(&bk)?)?.plus_transpose()?;
        let error = p.product(&error_matrix::<R>(self.a, self.l, self.c)?)?.plus_transpose()?;
        plant.bordered(&p1.product(&bk)?, &error)
    }
}

/// `[[(A-BK)'P1 + P1(A-BK), P1 B K], [K'B'P1, (A-LC)'P + P(A-LC)]] < 0` (Share Pasand, eq. 25): `x'P1 x + e'Pe`
/// decreases along the plant under `u = -K xhat` and the error of its observer. A witness is the stacked direction
/// `(x, e)`.
/// # Errors
/// [`ProofError`] for inconsistent shapes, entries that are not finite, or a `P` or `P1` that is not symmetric.
pub fn feedback_block(
    a: &Matrix<f64>,
    b: &Matrix<f64>,
    k: &Matrix<f64>,
    l: &Matrix<f64>,
    c: &Matrix<f64>,
    p1: &Matrix<f64>,
    p: &Matrix<f64>,
) -> Result<Verdict<Direction>, ProofError> {
    Block { a, b, k, l, c, p1, p }.decide(Sense::NegativeDefinite)
}
