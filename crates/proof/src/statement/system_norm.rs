//! Bounds of the H-infinity and the H2 norm of the error system of a linear observer.
//!
//! Plant `x' = A x + B u + E w`, `y = C x + D w`, observer `xhat' = A xhat + B u + L(y - C xhat)`. With `F = A - LC`
//! and `G = E - LD` the error `e = x - xhat` obeys `e' = F e + G w`; `z = H e`. In discrete time `e+ = F e + G w`.
//!
//! **H-infinity** (bounded real lemma). Let `P > 0` and, with `V = e'Pe`,
//! ```text
//! [F'P + PF + H'H, PG; *, -gamma^2 I] < 0,    in discrete time    [F'PF - P + H'H, F'PG; *, G'PG - gamma^2 I] < 0.
//! ```
//! The quadratic form at (e, w) is `V' + |z|^2 - gamma^2 |w|^2` (`V(e+) - V(e)` in place of V'), hence at most
//! `-q (|w|^2 + |e|^2)` for some q > 0. For w = 0, V decreases, and F is stable. Integrated from 0 to T with
//! `V(T) >= 0`, the integral of `|z|^2` is at most V(0) plus `gamma^2 - q` times that of `|w|^2`; for e(0) = 0 the L2
//! gain from w to z is below gamma.
//!
//! **H2.** Let `P > 0`, `F'P + PF + H'H < 0` (`F'PF - P + H'H < 0`) and `tr G'PG < gamma^2`. Then F is stable, and P >=
//! W, the observability Gramian, which solves the equation: `|T|_2^2 = tr G'WG <= tr G'PG`. This is the stationary
//! variance of z for white noise w of unit intensity (unit covariance).

use super::{Expression, embed, embed_symmetric, number};
use crate::definite::{Direction, Sense};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::Verdict;

/// Continuous or discrete time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimeDomain {
    /// `e' = F e + G w`.
    Continuous,
    /// `e+ = F e + G w`.
    Discrete,
}

/// The error system of a linear observer from w to `z = H e`.
#[derive(Debug, Clone, Copy)]
pub struct ErrorSystem<'a> {
    /// Time domain.
    pub time: TimeDomain,
    /// A, n x n.
    pub a: &'a Matrix<f64>,
    /// C, p x n.
    pub c: &'a Matrix<f64>,
    /// E, n x q.
    pub e: &'a Matrix<f64>,
    /// D, p x q.
    pub d: &'a Matrix<f64>,
    /// H, r x n.
    pub h: &'a Matrix<f64>,
    /// L, n x p, as stored.
    pub l: &'a Matrix<f64>,
}

impl ErrorSystem<'_> {
    fn check(&self, p: &Matrix<f64>) -> Result<(), ProofError> {
        let (n, outputs, q) = (self.a.rows(), self.c.rows(), self.e.cols());
        embed::<Interval>(self.a, "A", (n, n))?;
        embed::<Interval>(self.c, "C", (outputs, n))?;
        embed::<Interval>(self.e, "E", (n, q))?;
        embed::<Interval>(self.d, "D", (outputs, q))?;
        embed::<Interval>(self.h, "H", (self.h.rows(), n))?;
        embed::<Interval>(self.l, "L", (n, outputs))?;
        embed_symmetric::<Interval>(p, "P", n)?;
        Ok(())
    }

    /// F and G.
    fn flow<R: Ring>(&self) -> Result<(Matrix<R>, Matrix<R>), ProofError> {
        let l = Matrix::<R>::embed(self.l, "L")?;
        let f = Matrix::<R>::embed(self.a, "A")?.difference(&l.product(&Matrix::embed(self.c, "C")?)?)?;
        let g = Matrix::<R>::embed(self.e, "E")?.difference(&l.product(&Matrix::embed(self.d, "D")?)?)?;
        Ok((f, g))
    }
}

/// `[F'P + PF + H'H, PG; *, -gamma^2 I] < 0`, or the inequality in discrete time.
///
/// ```
/// use luenberger_proof::{Matrix, statement::{ErrorSystem, TimeDomain, bounded_real}};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// // e' = -2 e + w: the norm of 1/(s + 2) is 1/2.
/// let (one, two, zero) = (Matrix::from_rows([[1.0]]), Matrix::from_rows([[2.0]]), Matrix::from_rows([[0.0]]));
/// let system = ErrorSystem { time: TimeDomain::Continuous, a: &zero, c: &one, e: &one, d: &zero, h: &one, l: &two };
/// assert!(bounded_real(&system, &Matrix::from_rows([[0.5]]), 0.501)?.is_proved());
/// assert!(bounded_real(&system, &Matrix::from_rows([[0.5]]), 0.499)?.is_refuted());
/// # Ok(())
/// # }
/// ```
/// # Errors
/// [`ProofError`] for inconsistent shapes, entries that are not finite, or a P that is not symmetric.
pub fn bounded_real(system: &ErrorSystem<'_>, p: &Matrix<f64>, gamma: f64) -> Result<Verdict<Direction>, ProofError> {
    system.check(p)?;
    Decrease { system, p, gamma: Some(gamma) }.decide(Sense::NegativeDefinite)
}

/// `F'P + PF + H'H < 0` (or `F'PF - P + H'H < 0`) and `tr G'PG < gamma^2`.
///
/// # Errors
/// As [`bounded_real`].
pub fn bounded_variance(
    system: &ErrorSystem<'_>,
    p: &Matrix<f64>,
    gamma: f64,
) -> Result<[Verdict<Direction>; 2], ProofError> {
    system.check(p)?;
    Ok([
        Decrease { system, p, gamma: None }.decide(Sense::NegativeDefinite)?,
        Room { system, p, gamma }.decide(Sense::PositiveDefinite)?,
    ])
}

/// The inequality in (e, w), or without gamma its first block.
struct Decrease<'a> {
    system: &'a ErrorSystem<'a>,
    p: &'a Matrix<f64>,
    gamma: Option<f64>,
}

impl Expression for Decrease<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let (f, g) = self.system.flow::<R>()?;
        let p = Matrix::<R>::embed(self.p, "P")?;
        let h = Matrix::<R>::embed(self.system.h, "H")?;
        let seen = h.congruence(&Matrix::scalar(h.rows(), &number(1.0, "1")?))?;
        let driven = p.product(&g)?;
        let (first, corner, last) = match self.system.time {
            TimeDomain::Continuous => (p.product(&f)?.plus_transpose()?, driven, Matrix::zeros(g.cols(), g.cols())),
            TimeDomain::Discrete => {
                (f.congruence(&p)?.difference(&p)?, f.transpose().product(&driven)?, g.congruence(&p)?)
            }
        };
        let first = first.sum(&seen)?;
        let Some(gamma) = self.gamma else { return Ok(first) };
        let gamma = number::<R>(gamma, "gamma")?;
        first.bordered(&corner, &last.difference(&Matrix::scalar(g.cols(), &gamma.mul(&gamma)))?)
    }
}

/// `gamma^2 - tr G'PG`, 1 x 1.
struct Room<'a> {
    system: &'a ErrorSystem<'a>,
    p: &'a Matrix<f64>,
    gamma: f64,
}

impl Expression for Room<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let (_, g) = self.system.flow::<R>()?;
        let gamma = number::<R>(self.gamma, "gamma")?;
        let spent = g.congruence(&Matrix::embed(self.p, "P")?)?;
        let room = (0..spent.rows()).fold(gamma.mul(&gamma), |room, i| room.sub(&spent[(i, i)]));
        Matrix::from_row_major(1, 1, vec![room])
    }
}
