//! Decay of the error of an observer in the coordinates `(x_m, x_u - K x_m)`, with output injection into the measured
//! rows and contracting unmeasured rows.
//!
//! With `T = [I 0; K I]` the Jacobian J becomes `T^-1 J T`, with the unmeasured block `J_uu - K J_mu`. The injection of
//! the measured error into the measured rows gives `d' = (T^-1 J T - [G_m 0; 0 0]) d` with G_m diagonal and
//! `G_m >= g I`. With `V = |d_m|^2 + d_w' Q d_w` the injection contributes `-2 d_m' G_m d_m`, so a decrease for `g I`
//! implies one for every larger G_m.

use super::{Expression, embed, embed_symmetric, number};
use crate::definite::{Direction, Sense};
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::Verdict;

struct Cascade<'a> {
    j: &'a Matrix<f64>,
    k: &'a Matrix<f64>,
    q: &'a Matrix<f64>,
    injection: f64,
    rate: f64,
}

impl Expression for Cascade<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let (unmeasured, measured) = self.k.shape();
        let n = measured + unmeasured;
        let one: R = number(1.0, "1")?;
        let j = embed::<R>(self.j, "J", (n, n))?;
        let k = embed::<R>(self.k, "K", (unmeasured, measured))?;
        let q = embed_symmetric::<R>(self.q, "Q", unmeasured)?;
        let triangular = |sign: &dyn Fn(&R) -> R| {
            Matrix::from_fn(n, n, |row, column| match (row < measured, column < measured) {
                (false, true) => sign(&k[(row - measured, column)]),
                _ if row == column => one.clone(),
                _ => R::zero(),
            })
        };
        let moved = triangular(&Ring::neg).product(&j)?.product(&triangular(&Clone::clone))?;
        let p = Matrix::from_fn(n, n, |row, column| match (row < measured, column < measured) {
            (false, false) => q[(row - measured, column - measured)].clone(),
            (true, true) if row == column => one.clone(),
            _ => R::zero(),
        });
        let (g, rate): (R, R) = (number(self.injection, "the injection")?, number(self.rate, "the rate")?);
        let shift = Matrix::from_fn(n, n, |row, column| match row == column {
            true if row < measured => rate.sub(&g),
            true => rate.clone(),
            false => R::zero(),
        });
        p.product(&moved.sum(&shift)?)?.plus_transpose()
    }
}

/// `He(P (T^-1 J T - [g I 0; 0 0])) + 2 rate P < 0` with `He(X) = X + X'`, `T = [I 0; K I]`, `P = [I 0; 0 Q]`, for the
/// numbers exactly as given.
///
/// J is n x n, K (n - p) x p, Q symmetric of order n - p. With [`positive`](super::positive) of Q it proves that the
/// error of an observer whose injection into the p measured rows is diagonal and at least g decays faster than
/// `exp(-rate t)`.
///
/// ```
/// use luenberger_proof::{Matrix, statement::cascade_decrease};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// // A stable plant with the unstable unmeasured block 1: with K = 2 the block is 1 - 2 * 2 = -3, and an injection of
/// // 2 is enough.
/// let j = Matrix::from_rows([[-3.0, 2.0], [-2.0, 1.0]]);
/// let (two, one, none) = (Matrix::from_rows([[2.0]]), Matrix::from_rows([[1.0]]), Matrix::from_rows([[0.0]]));
/// assert!(cascade_decrease(&j, &two, &one, 2.0, 0.5)?.is_proved());
/// assert!(cascade_decrease(&j, &none, &one, 1e9, 0.0)?.is_refuted());
/// # Ok(())
/// # }
/// ```
/// # Errors
/// [`ProofError`] for inconsistent shapes, entries that are not finite, or a Q that is not symmetric.
pub fn cascade_decrease(
    j: &Matrix<f64>,
    k: &Matrix<f64>,
    q: &Matrix<f64>,
    injection: f64,
    rate: f64,
) -> Result<Verdict<Direction>, ProofError> {
    Cascade { j, k, q, injection, rate }.decide(Sense::NegativeDefinite)
}
