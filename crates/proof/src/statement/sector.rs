//! Observers of plants with sector-bounded nonlinearities: the matrix inequality of Thau, Rajamani and the circle
//! criterion.
//!
//! Plant `x' = A x + sum_k G_k phi_k(H_k x)`, observer `xhat' = A xhat + sum_k G_k phi_k(H_k xhat) + L (y - C xhat)`.
//! With `e = x - xhat` and `w_k = phi_k(H_k x) - phi_k(H_k xhat)`, the incremental sector `[low, high]` is
//! `(w_k - low H_k e)'(high H_k e - w_k) >= 0`: for a scalar phi_k bounds of its slope, for `low = -high` the Lipschitz
//! condition `|w_k| <= high |H_k e|`. By the S-procedure,
//! ```text
//! [ F'P + PF + 2 alpha P - sum tau_k low_k high_k H_k'H_k     P G_k + tau_k (low_k + high_k)/2 H_k' ]
//! [ its transpose                                                          -tau_k I                 ]  < 0,   F = A - LC,
//! ```
//! implies that `V = e'Pe` decreases faster than `exp(-2 alpha t)` for every nonlinearity in the sectors. The
//! inequality includes `tau_k > 0`.

use super::lyapunov::error_matrix;
use super::{Expression, embed, embed_symmetric, number};
use crate::definite::{self, Direction, Sense};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::Verdict;

/// One nonlinearity `G phi(H x)` in the incremental sector `[low, high]`, and its multiplier.
#[derive(Debug, Clone, PartialEq)]
pub struct SectorTerm {
    /// Input matrix of the nonlinearity, n x q.
    pub g: Matrix<f64>,
    /// Argument matrix of the nonlinearity, r x n; `r = q` unless `low = -high`.
    pub h: Matrix<f64>,
    /// Lower bound of the sector.
    pub low: f64,
    /// Upper bound of the sector.
    pub high: f64,
    /// Multiplier tau of the S-procedure.
    pub tau: f64,
}

struct SectorDecrease<'a> {
    a: &'a Matrix<f64>,
    l: &'a Matrix<f64>,
    c: &'a Matrix<f64>,
    p: &'a Matrix<f64>,
    alpha: f64,
    terms: &'a [SectorTerm],
}

impl Expression for SectorDecrease<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        left_hand_side(&error_matrix::<R>(self.a, self.l, self.c)?, self.p, self.alpha, self.terms)
    }
}

/// The left-hand side of the block inequality, for F.
fn left_hand_side<R: Ring>(
    f: &Matrix<R>,
    p: &Matrix<f64>,
    alpha: f64,
    terms: &[SectorTerm],
) -> Result<Matrix<R>, ProofError> {
    let n = f.rows();
    let p = embed_symmetric::<R>(p, "P", n)?;
    let half: R = number(0.5, "1/2")?;
    let shift = Matrix::scalar(n, &number(alpha, "alpha")?);
    // Half of the first diagonal block; its transpose is added at the end.
    let mut first = p.product(&f.sum(&shift)?)?;
    let (mut columns, mut taus): (Vec<Matrix<R>>, Vec<R>) = (vec![], vec![]);
    for term in terms {
        let (q, r) = (term.g.cols(), term.h.rows());
        let (g, h) = (embed::<R>(&term.g, "G", (n, q))?, embed::<R>(&term.h, "H", (r, n))?);
        let (low, high): (R, R) = (number(term.low, "low")?, number(term.high, "high")?);
        let half_tau: R = number::<R>(term.tau, "tau")?.mul(&half);
        first = first.difference(&h.transpose().product(&h)?.scaled(&half_tau.mul(&low.mul(&high))))?;
        let mut column = p.product(&g)?;
        if term.low != -term.high {
            term.h.expect_shape("H of a sector that is not symmetric", (q, n))?;
            column = column.sum(&h.transpose().scaled(&half_tau.mul(&low.add(&high))))?;
        }
        taus.extend(std::iter::repeat_n(number::<R>(-term.tau, "tau")?, q));
        columns.push(column);
    }
    let places: Vec<(usize, usize)> =
        columns.iter().enumerate().flat_map(|(k, block)| (0..block.cols()).map(move |j| (k, j))).collect();
    let corner = Matrix::from_fn(n, places.len(), |i, j| columns[places[j].0][(i, places[j].1)].clone());
    let last = Matrix::from_fn(taus.len(), taus.len(), |i, j| if i == j { taus[i].clone() } else { R::zero() });
    first.plus_transpose()?.bordered(&corner, &last)
}

/// The block inequality above, for L, P and the multipliers exactly as given. With [`positive`](super::positive) of P
/// it proves that the error of the observer tends to 0 like `exp(-alpha t)`, for all nonlinearities in their sectors.
///
/// Proved with margin q: `V' <= -2 alpha V - q (|e|^2 + |w|^2)`. A witness is the stacked direction
/// `(e, w_1, w_2, ..)`; it refutes this P and these multipliers, not the observer.
///
/// ```
/// use luenberger_proof::{Matrix, statement::{SectorTerm, sector_decrease}};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// // x' = phi(x), y = x, xhat' = phi(xhat) + 3 (y - xhat): e' = -3 e + w with |w| <= gamma |e|.
/// let one = |x: f64| Matrix::from_rows([[x]]);
/// let at = |gamma: f64| {
///     let term = SectorTerm { g: one(1.0), h: one(1.0), low: -gamma, high: gamma, tau: 1.0 };
///     sector_decrease(&one(0.0), &one(3.0), &one(1.0), &one(3.0), 0.0, &[term])
/// };
/// assert!(at(2.99)?.is_proved() && at(3.0)?.is_refuted());
/// # Ok(())
/// # }
/// ```
/// # Errors
/// [`ProofError`] for inconsistent shapes, entries that are not finite, or a `P` that is not symmetric.
///
/// Sources: R. Rajamani, Observers for Lipschitz nonlinear systems, IEEE Transactions on Automatic Control 43, 1998; M.
/// Arcak and P. Kokotovic, Nonlinear observers: a circle criterion design and robustness analysis, Automatica 37, 2001.
pub fn sector_decrease(
    a: &Matrix<f64>,
    l: &Matrix<f64>,
    c: &Matrix<f64>,
    p: &Matrix<f64>,
    alpha: f64,
    terms: &[SectorTerm],
) -> Result<Verdict<Direction>, ProofError> {
    SectorDecrease { a, l, c, p, alpha, terms }.decide(Sense::NegativeDefinite)
}

/// As [`sector_decrease`], for every pair (A, C) between these bounds: where they vary in time, too. If all data are
/// single numbers, the decision is that of [`sector_decrease`], exact if necessary.
///
/// # Errors
/// As [`sector_decrease`].
pub fn sector_decrease_within(
    a: &Matrix<Interval>,
    l: &Matrix<f64>,
    c: &Matrix<Interval>,
    p: &Matrix<f64>,
    alpha: f64,
    terms: &[SectorTerm],
) -> Result<Verdict<Direction>, ProofError> {
    if a.as_slice().iter().chain(c.as_slice()).all(Interval::is_point) {
        return sector_decrease(&a.map(Interval::lo), l, &c.map(Interval::lo), p, alpha, terms);
    }
    let n = a.rows();
    a.expect_shape("A", (n, n))?;
    c.expect_shape("C", (c.rows(), n))?;
    let l = embed::<Interval>(l, "L", (n, c.rows()))?;
    let f = a.difference(&l.product(c)?)?;
    definite::decide(&left_hand_side(&f, p, alpha, terms)?, Sense::NegativeDefinite)
}
