//! The cubic term of the cubic observer: condition (13') of Share Pasand, `P N C + C'N'P <= 0`.
//!
//! Where rank C < n the inequality is never strict, and it is equivalent to a structural condition: it holds if and
//! only if `P N = -C'S` with `S + S' >= 0` (C of full row rank). A gain `N` rounded to binary64 violates `P N = -C'S`
//! in the last digit, and then the inequality for the given data is false, by about 1e-17. There are three statements
//! for this:
//! - [`cubic_dissipation`] decides the inequality exactly for `N` as given;
//! - [`cubic_dissipation_structured`] decides it for the real gain `N = -P^-1 C'S`, which is defined by `S`;
//! - [`deployed_cubic`](super::deployed_cubic) proves convergence with `N` as given by other means.

use super::{Expression, embed, embed_symmetric};
use crate::definite::{self, Direction, Sense};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::Verdict;

struct Dissipation<'a> {
    p: &'a Matrix<f64>,
    n: &'a Matrix<f64>,
    c: &'a Matrix<f64>,
}

impl Expression for Dissipation<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let order = self.p.rows();
        let p = embed_symmetric::<R>(self.p, "P", order)?;
        let c = embed::<R>(self.c, "C", (self.c.rows(), order))?;
        let n = embed::<R>(self.n, "N", (order, c.rows()))?;
        p.product(&n)?.product(&c)?.plus_transpose()
    }
}

/// `P N C + C'N'P <= 0` (13'), for the numbers exactly as given.
///
/// `P` is n x n symmetric, `N` n x p, `C` p x n. With rank C < n the statement lies on the boundary: expect `Proved`
/// with margin 0 where `P N = -C'S` holds to the last bit (integers, say), and `Refuted` by a value of the order of the
/// rounding of `N` where it does not. That refutation is true and seldom what is wanted: see the head of this module.
/// # Errors
/// [`ProofError`] for shapes that do not fit, entries that are not finite, a `P` that is not symmetric.
pub fn cubic_dissipation(p: &Matrix<f64>, n: &Matrix<f64>, c: &Matrix<f64>) -> Result<Verdict<Direction>, ProofError> {
    Dissipation { p, n, c }.decide(Sense::NegativeSemidefinite)
}

struct Structured<'a> {
    s: &'a Matrix<f64>,
    c: &'a Matrix<f64>,
}

impl Expression for Structured<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let c = embed::<R>(self.c, "C", self.c.shape())?;
        let s = embed::<R>(self.s, "S", (c.rows(), c.rows()))?;
        c.transpose().product(&s)?.product(&c)?.plus_transpose()
    }
}

/// `P N C + C'N'P <= 0` (13') for the real matrix `N = -P^-1 C'S`, of which a stored gain is a rounding.
///
/// `P` is n x n symmetric, `S` p x p, `C` p x n. Then `P N C + C'N'P = -C'(S + S')C`, whatever `P > 0` is: the
/// inequality is proved by `P > 0` and `S + S' >= 0`. The margin is that of `S + S' >= 0`, in the units of `S`: the
/// cubic term contributes at most `-margin (y'theta y) |y|^2` to `V'`.
///
/// Refuted when `P > 0` is (the gain is not defined), or when `C'(S + S')C >= 0` is, with the direction as witness.
/// That is also what decides where C lacks rank and `S + S' >= 0` alone is false; the margin is then 0.
/// # Errors
/// [`ProofError`] for shapes that do not fit, entries that are not finite, a `P` that is not symmetric.
pub fn cubic_dissipation_structured(
    p: &Matrix<f64>,
    s: &Matrix<f64>,
    c: &Matrix<f64>,
) -> Result<Verdict<Direction>, ProofError> {
    embed_symmetric::<Interval>(p, "P", p.rows())?;
    embed::<Interval>(c, "C", (c.rows(), p.rows()))?;
    embed::<Interval>(s, "S", (c.rows(), c.rows()))?;
    let defined = definite::decide(p, Sense::PositiveDefinite)?;
    if !defined.is_proved() {
        return Ok(defined);
    }
    let sufficient = accretive(s)?;
    if sufficient.is_proved() {
        return Ok(sufficient);
    }
    Ok(match (Structured { s, c }).decide(Sense::PositiveSemidefinite)? {
        Verdict::Proved { .. } => Verdict::Proved { margin: 0.0 },
        other => other,
    })
}

struct Accretive<'a> {
    s: &'a Matrix<f64>,
}

impl Expression for Accretive<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        embed::<R>(self.s, "S", (self.s.rows(), self.s.rows()))?.plus_transpose()
    }
}

/// `S + S' >= 0`: `w'Sw >= 0` for every `w`. The margin bounds the smallest eigenvalue of `S + S'` from below.
/// # Errors
/// [`ProofError`] for an `S` that is not square or not finite.
pub fn accretive(s: &Matrix<f64>) -> Result<Verdict<Direction>, ProofError> {
    Accretive { s }.decide(Sense::PositiveSemidefinite)
}
