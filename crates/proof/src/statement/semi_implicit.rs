//! One semi-implicit step of the cubic flow: `d - s N C d = e` with any `s >= 0`.
//!
//! For `R = P N + C'S` and `S + S' >= 0`, and any d and s >= 0, with `w = s C d`,
//! ```text
//! (d - N w)'P(d - N w) = d'Pd - 2 d'P N w + w'N'P N w >= d'Pd - 2 d'R w + w'N'P N w,
//! ```
//! because `2 d'C'S w = s (Cd)'(S + S')(Cd) >= 0`. The right-hand side is at least `d'(P - X)d` for every s if
//! `[X, -R; -R', N'PN] >= 0`. If N has full column rank, `N'PN > 0`, and the residual R of a stored N is allowed as
//! long as it is small compared with X and N: no exact structure is needed.

use super::lyapunov::error_matrix;
use super::{Expression, embed, embed_symmetric, number};
use crate::definite::{Direction, Sense};
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::Verdict;

/// `[X, PN + C'S; *, N'PN]`.
fn block<R: Ring>(
    x: &Matrix<R>,
    c: &Matrix<R>,
    n: &Matrix<f64>,
    p: &Matrix<R>,
    s: &Matrix<f64>,
) -> Result<Matrix<R>, ProofError> {
    let (order, outputs) = (p.rows(), c.rows());
    let n = embed::<R>(n, "N", (order, outputs))?;
    let s = embed::<R>(s, "S", (outputs, outputs))?;
    let residual = p.product(&n)?.sum(&c.transpose().product(&s)?)?;
    x.bordered(&residual, &n.congruence(p)?)
}

struct SemiImplicit<'a> {
    a: &'a Matrix<f64>,
    l: &'a Matrix<f64>,
    c: &'a Matrix<f64>,
    n: &'a Matrix<f64>,
    p: &'a Matrix<f64>,
    s: &'a Matrix<f64>,
}

impl Expression for SemiImplicit<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let p = embed_symmetric::<R>(self.p, "P", self.a.rows())?;
        let c = embed::<R>(self.c, "C", (self.c.rows(), self.a.rows()))?;
        let next = error_matrix::<R>(self.a, self.l, self.c)?.congruence(&p)?;
        let half = number::<R>(0.5, "1/2")?;
        block(&p.difference(&next)?.scaled(&half), &c, self.n, &p, self.s)
    }
}

/// `[(P - F'PF)/2, PN + C'S; *, N'PN] >= 0` with `F = A - LC`, for the numbers as stored. Together with `F'PF < P`,
/// `P > 0` and `S + S' >= 0` it proves that `V = e'Pe` decreases by a fixed factor per step along `e+ = F d`,
/// `d - s N C d = e`, for every `s >= 0`; see the head of `certificate/theorem/semi_implicit.rs`.
///
/// `A` n x n, `L` and `N` n x p, `C` p x n, `P` symmetric n x n, `S` p x p.
/// # Errors
/// [`ProofError`] for inconsistent shapes, entries that are not finite, or a `P` that is not symmetric.
/// ```
/// use luenberger_proof::{Matrix, statement::semi_implicit_decrease};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// // x+ = x/2, N = -S = -1/3 as stored, P = 1: PN + C'S is the rounding.
/// let number = |x: f64| Matrix::from_rows([[x]]);
/// let (a, one) = (number(0.5), number(1.0));
/// let third = 1.0 / 3.0;
/// assert!(semi_implicit_decrease(&a, &number(0.0), &one, &number(-third), &one, &number(third))?.is_proved());
/// // The wrong sign of N.
/// assert!(semi_implicit_decrease(&a, &number(0.0), &one, &number(third), &one, &number(third))?.is_refuted());
/// # Ok(())
/// # }
/// ```
pub fn semi_implicit_decrease(
    a: &Matrix<f64>,
    l: &Matrix<f64>,
    c: &Matrix<f64>,
    n: &Matrix<f64>,
    p: &Matrix<f64>,
    s: &Matrix<f64>,
) -> Result<Verdict<Direction>, ProofError> {
    SemiImplicit { a, l, c, n, p, s }.decide(Sense::PositiveSemidefinite)
}

struct Room<'a> {
    c: &'a Matrix<f64>,
    n: &'a Matrix<f64>,
    p: &'a Matrix<f64>,
    s: &'a Matrix<f64>,
    factor: f64,
}

impl Expression for Room<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let p = embed_symmetric::<R>(self.p, "P", self.p.rows())?;
        let c = embed::<R>(self.c, "C", (self.c.rows(), p.rows()))?;
        let factor = number::<R>(self.factor, "the factor")?;
        let share = number::<R>(1.0, "1")?.sub(&factor.mul(&factor)).mul(&number::<R>(0.5, "1/2")?);
        block(&p.scaled(&share), &c, self.n, &p, self.s)
    }
}

/// `[(1 - factor^2)P/2, PN + C'S; *, N'PN] >= 0`: with `S + S' >= 0`, `V(d) (1 + factor^2)/2 <= V(e)` for every
/// `d - s N C d = e`, `s >= 0`.
/// # Errors
/// As [`semi_implicit_decrease`].
pub fn semi_implicit_room(
    c: &Matrix<f64>,
    n: &Matrix<f64>,
    p: &Matrix<f64>,
    s: &Matrix<f64>,
    factor: f64,
) -> Result<Verdict<Direction>, ProofError> {
    Room { c, n, p, s, factor }.decide(Sense::PositiveSemidefinite)
}
