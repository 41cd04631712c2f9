//! Decoupling and convergence of an observer of a plant whose unknown input also enters the outputs, in both times.
//!
//! Plant `x' = A x + B u + E d`, `y = C x + F d` (or `x+`), d arbitrary. The observer
//! ```text
//! z' = T A xhat + T B u + J r,    r = y - C xhat,    xhat = z + H y,    T = I - HC
//! ```
//! has `e = x - xhat = T x - H F d - z`. If `H F = 0` and `T E = J F`, then `e' = (TA - JC) e + (TE - JF) d = (TA - JC)
//! e` for every d; in discrete time likewise. With `J = L + G` for a stored L the two conditions are
//! ```text
//! [H G] S = [E - LF, 0],    S = [CE F1; F 0],
//! ```
//! F1 being the columns of F that are not 0. If S has full column rank, `[H G] = [E - LF, 0] (S'S)^-1 S'` solves them
//! exactly. H and G are rational functions of the data and are enclosed as in `left_inverse.rs`; then `P > 0` and
//! ```text
//! (TA - JC)'P + P(TA - JC) < 0,    in discrete time    (TA - JC)'P(TA - JC) - P < 0
//! ```
//! are decided. S has full column rank iff the columns of F1 are independent and `rank [CE F; F 0] = q + rank(F)`
//! (Hautus, Linear Algebra and its Applications 50, 1983, for the estimate of x from y and y'). For F = 0 it is
//! `H = E((CE)'CE)^-1(CE)'` and J = L.

use super::left_inverse::times_left_inverse;
use super::{Expression, TimeDomain, embed, embed_symmetric};
use crate::definite::{self, Direction, Sense};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::{UndecidedReason, Verdict};

/// A plant with an unknown input in the states and in the outputs, and the gain of its observer.
#[derive(Debug, Clone, Copy)]
pub struct Decoupling<'a> {
    /// Continuous or discrete time.
    pub time: TimeDomain,
    /// A, n x n.
    pub a: &'a Matrix<f64>,
    /// C, p x n.
    pub c: &'a Matrix<f64>,
    /// E, n x q.
    pub e: &'a Matrix<f64>,
    /// F, p x q.
    pub f: &'a Matrix<f64>,
    /// L, n x p, as stored.
    pub l: &'a Matrix<f64>,
}

/// Verdicts on such an observer.
#[derive(Debug, Clone, PartialEq)]
pub struct Undisturbed {
    /// `S'S > 0`.
    pub rank: Verdict<Direction>,
    /// `P > 0`.
    pub positive: Verdict<Direction>,
    /// `(TA - JC)'P + P(TA - JC) < 0`, or `(TA - JC)'P(TA - JC) - P < 0`.
    pub decrease: Verdict<Direction>,
}

/// Convergence of the observer with L exactly as stored and the real matrices H, T and J.
///
/// ```
/// use luenberger_proof::{Matrix, statement::{Decoupling, TimeDomain, decoupling}};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// // x' = x + d, y1 = x, y2 = d: H = (1, 0) and J = L, or H = 0 and J = (l, 1).
/// let (a, c, e) = (Matrix::from_rows([[1.0]]), Matrix::from_rows([[1.0], [0.0]]), Matrix::from_rows([[1.0]]));
/// let (f, l, p) = (Matrix::from_rows([[0.0], [1.0]]), Matrix::from_rows([[3.0, 1.0]]), Matrix::from_rows([[1.0]]));
/// let of = Decoupling { time: TimeDomain::Continuous, a: &a, c: &c, e: &e, f: &f, l: &l };
/// let found = decoupling(&of, &p)?;
/// assert!(found.rank.is_proved() && found.decrease.is_proved());
/// # Ok(())
/// # }
/// ```
/// # Errors
/// [`ProofError`] for inconsistent shapes, entries that are not finite, or a P that is not symmetric.
pub fn decoupling(of: &Decoupling<'_>, p: &Matrix<f64>) -> Result<Undisturbed, ProofError> {
    let Decoupling { time, a, c, e, f, l } = *of;
    let (n, outputs) = (a.rows(), c.rows());
    let a = embed::<Interval>(a, "A", (n, n))?;
    let c_enclosed = embed::<Interval>(c, "C", (outputs, n))?;
    embed::<Interval>(e, "E", (n, e.cols()))?;
    embed::<Interval>(f, "F", (outputs, e.cols()))?;
    let l_enclosed = embed::<Interval>(l, "L", (n, outputs))?;
    let p_enclosed = embed_symmetric::<Interval>(p, "P", n)?;
    let columns = Columns::of(of);
    let rank = Rank(&columns).decide(Sense::PositiveDefinite)?;
    let positive = definite::decide(p, Sense::PositiveDefinite)?;
    let injected = if rank.is_proved() { times_left_inverse(&Left(&columns), &columns)? } else { None };
    let decrease = match injected {
        Some(injected) => {
            // [CA; C].
            let ca = c_enclosed.product(&a)?;
            let rates = Matrix::from_fn(2 * outputs, n, |i, j| {
                if i < outputs { ca[(i, j)].clone() } else { c_enclosed[(i - outputs, j)].clone() }
            });
            let flow = a.difference(&l_enclosed.product(&c_enclosed)?)?.difference(&injected.product(&rates)?)?;
            let change = match time {
                TimeDomain::Continuous => p_enclosed.product(&flow)?.plus_transpose()?,
                TimeDomain::Discrete => flow.congruence(&p_enclosed)?.difference(&p_enclosed)?,
            };
            definite::decide(&change, Sense::NegativeDefinite)?
        }
        None => Verdict::Undecided { why: UndecidedReason::NotByThisMatrix { name: "P" }, best: f64::NAN },
    };
    Ok(Undisturbed { rank, positive, decrease })
}

/// `S = [CE F1; F 0]`.
struct Columns<'a> {
    of: &'a Decoupling<'a>,
    /// The columns of F that are not 0.
    fed: Vec<usize>,
}

impl<'a> Columns<'a> {
    fn of(of: &'a Decoupling<'a>) -> Self {
        let is_fed = |j: &usize| (0..of.f.rows()).any(|i| of.f[(i, *j)] != 0.0);
        Self { of, fed: (0..of.f.cols()).filter(is_fed).collect() }
    }
}

impl Expression for Columns<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let Decoupling { c, e, f, .. } = self.of;
        let (outputs, inputs) = (f.rows(), f.cols());
        let seen = Matrix::<R>::embed(c, "C")?.product(&Matrix::embed(e, "E")?)?;
        let f = Matrix::<R>::embed(f, "F")?;
        Ok(Matrix::from_fn(2 * outputs, inputs + self.fed.len(), |i, j| match (i < outputs, j < inputs) {
            (true, true) => seen[(i, j)].clone(),
            (true, false) => f[(i, self.fed[j - inputs])].clone(),
            (false, true) => f[(i - outputs, j)].clone(),
            (false, false) => R::zero(),
        }))
    }
}

/// `[E - LF, 0]`.
struct Left<'a>(&'a Columns<'a>);

impl Expression for Left<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let Decoupling { e, f, l, .. } = self.0.of;
        let injected = Matrix::<R>::embed(l, "L")?.product(&Matrix::embed(f, "F")?)?;
        let left = Matrix::<R>::embed(e, "E")?.difference(&injected)?;
        Ok(Matrix::from_fn(left.rows(), left.cols() + self.0.fed.len(), |i, j| {
            if j < left.cols() { left[(i, j)].clone() } else { R::zero() }
        }))
    }
}

/// `S'S`.
struct Rank<'a>(&'a Columns<'a>);

impl Expression for Rank<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let s = self.0.evaluate::<R>()?;
        s.congruence(&Matrix::scalar(s.rows(), &super::number(1.0, "1")?))
    }
}
