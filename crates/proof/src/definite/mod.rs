//! Whether a symmetric matrix is positive or negative (semi)definite: proved, refuted, or undecided.
//!
//! Three tests, in the order of their cost:
//! 1. a floating-point Cholesky factorisation of a shifted, equilibrated matrix with a rigorous bound of its rounding
//!    error proves definiteness (`cholesky.rs`);
//! 2. a direction `v` with negative `v'Mv`, enclosed or computed exactly, refutes it (`direction.rs`);
//! 3. if both are inconclusive, exact fraction-free elimination decides, up to order [`REFEREE_ORDER`] (`referee.rs`).
//!
//! An interval matrix stands for all symmetric matrices within it: `Proved` holds for each of them, and `Refuted` gives
//! one direction that refutes all of them. Otherwise the verdict is `Undecided`.
//!
//! The matrix of order 0 is positive and negative definite, with margin infinity: there is no nonzero direction.

pub(crate) mod cholesky;
mod direction;
mod entry;
mod referee;

pub use entry::Entry;

use std::fmt;

use crate::error::ProofError;
use crate::exact::Exact;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::{UndecidedReason, Verdict};
use crate::wording::{at_least, at_most, significant};
use cholesky::{Ball, Completion, Factor};
use referee::Finding;

/// A direction v in which the quadratic form has the wrong sign.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// The direction: not zero, largest entry about 1.
    pub v: Vec<f64>,
    /// Rigorous upper bound of `v'Mv` (of `v'(-M)v` for negative definiteness): at most 0 if definiteness is refuted,
    /// below 0 if semidefiniteness is.
    pub value: f64,
    /// The exact direction, if no binary64 vector is one (for example the null vector of a singular matrix). Then `v`
    /// is its rounding, and `value` bounds the form in the exact direction.
    pub exact: Option<Vec<Exact>>,
    /// Whether negative definiteness was asked, and the form is that of -M.
    pub is_negated: bool,
}

impl fmt::Display for Direction {
    /// The value is that of `v'Mv`, of the matrix as the condition has it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let entries: Vec<String> = self.v.iter().map(|x| significant(*x, 6)).collect();
        let bound = if self.is_negated {
            format!("at least {}", at_least(-self.value, 6))
        } else {
            format!("at most {}", at_most(self.value, 6))
        };
        write!(f, "v = ({}), where the form is {bound}", entries.join(", "))
    }
}

/// Largest order for exact elimination; larger matrices are decided by the first two tests only.
pub const REFEREE_ORDER: usize = 64;

/// Largest order for which exact elimination improves a margin already proved in floating point.
const EXACT_MARGIN_ORDER: usize = 16;

/// Limit of exact elimination for all matrices of one certificate, in 64-bit word multiplications: about a minute.
const CERTIFICATE_WORK: f64 = 2e10;

/// Runs the checks of one certificate within [`CERTIFICATE_WORK`].
pub(crate) fn of_one_certificate<T>(checks: impl FnOnce() -> T) -> T {
    referee::within(CERTIFICATE_WORK, checks)
}

/// Whether `v'Mv > 0` for every `v != 0`. The margin is a lower bound of the smallest eigenvalue of `M`.
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

/// Whether `v'Mv < 0` for every `v != 0`. The margin is a lower bound of the smallest eigenvalue of `-M`.
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

/// Exact value of `v'Mv`, to check a witness.
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

/// The four properties that can be decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sense {
    PositiveDefinite,
    PositiveSemidefinite,
    NegativeDefinite,
    NegativeSemidefinite,
}

impl Sense {
    fn is_negated(self) -> bool {
        matches!(self, Self::NegativeDefinite | Self::NegativeSemidefinite)
    }

    fn is_strict(self) -> bool {
        matches!(self, Self::PositiveDefinite | Self::NegativeDefinite)
    }
}

pub(crate) fn decide<T: Entry>(m: &Matrix<T>, sense: Sense) -> Result<Verdict<Direction>, ProofError> {
    let mut verdict = decided(m, sense)?;
    if let Verdict::Refuted { witness } = &mut verdict {
        witness.is_negated = sense.is_negated();
    }
    Ok(verdict)
}

/// The same, with the form of -M not told from that of M.
fn decided<T: Entry>(m: &Matrix<T>, sense: Sense) -> Result<Verdict<Direction>, ProofError> {
    let n = m.rows();
    m.expect_shape("a matrix whose definiteness is asked", (n, n))?;
    if n == 0 {
        return Ok(Verdict::Proved { margin: f64::INFINITY });
    }
    let enclosed = symmetric_enclosure(m, sense.is_negated())?;
    let exact = if sense.is_negated() { exact_entries(m).map(|m| m.negative()) } else { exact_entries(m) };
    let strict = sense.is_strict();
    if n == 1 {
        let lo = enclosed[(0, 0)].lo();
        if lo > 0.0 || (lo == 0.0 && !strict) {
            return Ok(Verdict::Proved { margin: lo });
        }
    }
    let quick = match ball(&enclosed) {
        Some(ball) => match quick(&ball, &enclosed, exact.as_ref(), strict) {
            Verdict::Undecided { why, best } => (why, best),
            decided => return Ok(decided),
        },
        None => (UndecidedReason::Overflow, f64::NAN),
    };
    let Some(exact) = exact else { return Ok(Verdict::Undecided { why: quick.0, best: quick.1 }) };
    let undecided = Verdict::Undecided { why: quick.0, best: quick.1 };
    let refuted = |v: &[Exact]| match referee::witness(&exact, v, strict) {
        Some(witness) => Verdict::Refuted { witness },
        None => undecided.clone(),
    };
    Ok(match referee::judge(&exact) {
        Finding::Definite(factor) => Verdict::Proved { margin: referee::margin(&exact, &factor, 0.0) },
        Finding::Singular(_) if !strict => Verdict::Proved { margin: 0.0 },
        Finding::Singular(v) | Finding::Indefinite(v) => refuted(&v),
        Finding::TooLarge => undecided,
    })
}

/// Whether one factorisation proves `M - c I > 0`, for c >= 0 and a symmetric M of floats.
pub(crate) fn smallest_eigenvalue_above(m: &Matrix<f64>, c: f64) -> bool {
    let Ok(enclosed) = symmetric_enclosure(m, false) else { return false };
    ball(&enclosed).is_some_and(|ball| matches!(cholesky::certify(&ball, c), Completion::Certified(_)))
}

/// A proved positive lower bound of the smallest eigenvalue, usually within a factor of two; cheaper than the margin of
/// [`positive_definite`].
pub(crate) fn proved_eigenvalue_bound(m: &Matrix<Interval>) -> Option<f64> {
    let ball = ball(m)?;
    let Completion::Certified(factor) = cholesky::certify(&ball, 0.0) else { return None };
    let (estimate, _) = factor.smallest_eigenvalue()?;
    [0.5, 0.1, 1e-2, 1e-4]
        .into_iter()
        .map(|share| share * estimate)
        .find(|c| *c > 0.0 && matches!(cholesky::certify(&ball, *c), Completion::Certified(_)))
}

/// `M^-1 rhs` for a positive definite M, in floating point, without error bound.
pub(crate) fn solve_approximately(m: &Matrix<f64>, rhs: &Matrix<f64>) -> Option<Matrix<f64>> {
    let n = m.rows();
    let r = cholesky::factor(m.clone()).ok()?;
    let factor = Factor { r, exponent: vec![0; n], order: (0..n).collect() };
    let mut columns = rhs.transpose();
    for j in 0..rhs.cols() {
        factor.solve(columns.row_mut(j));
    }
    columns.as_slice().iter().all(|x| x.is_finite()).then(|| columns.transpose())
}

/// The first two tests.
fn quick(ball: &Ball, enclosed: &Matrix<Interval>, exact: Option<&Matrix<Exact>>, strict: bool) -> Verdict<Direction> {
    let refutation = |v: Vec<f64>| direction::verify(enclosed, exact, v, strict);
    let completion = cholesky::certify(ball, 0.0);
    if let Completion::Certified(factor) = &completion {
        let (margin, estimate) = cholesky::margin(ball, factor);
        // If rounding reduces the margin much and the matrix is small, exact elimination improves it.
        let is_loose = margin < (1.0 - 1e-4) * estimate && ball.mid.rows() <= EXACT_MARGIN_ORDER;
        return Verdict::Proved {
            margin: exact.filter(|_| is_loose).map_or(margin, |m| referee::bettered_margin(m, margin)),
        };
    }
    let stopped = match &completion {
        Completion::Stopped { r, exponent, row } => Some(direction::from_stopped(r, exponent, *row)),
        _ => None,
    };
    let candidates =
        [direction::from_diagonal(ball), direction::from_minor(ball), stopped, direction::from_eigenvector(ball)];
    let mut best = f64::INFINITY;
    for v in candidates.into_iter().flatten() {
        best = best.min(rayleigh_quotient(&ball.mid, &v));
        if let Some(witness) = refutation(v) {
            return Verdict::Refuted { witness };
        }
    }
    let width = enclosed.as_slice().iter().map(Interval::width).fold(0.0, f64::max);
    let why = if exact.is_none() {
        UndecidedReason::DataTooUncertain { width }
    } else {
        let order = ball.mid.rows();
        let trace: f64 = (0..order).map(|i| ball.mid[(i, i)].abs()).sum();
        UndecidedReason::RoundingDominates { error: cholesky::relative_rounding_bound(order) * trace, order }
    };
    Verdict::Undecided { why, best: if best.is_finite() { best } else { f64::NAN } }
}

fn rayleigh_quotient(m: &Matrix<f64>, v: &[f64]) -> f64 {
    let (mut form, mut square) = (0.0, 0.0);
    for (i, x) in v.iter().enumerate() {
        form += x * m.row(i).iter().zip(v).map(|(a, y)| a * y).sum::<f64>();
        square += x * x;
    }
    form / square
}

/// Enclosures of the entries: for (i, j) and (j, i) the narrower of the two; negated if `negated`.
fn symmetric_enclosure<T: Entry>(m: &Matrix<T>, negated: bool) -> Result<Matrix<Interval>, ProofError> {
    let n = m.rows();
    let what = "a matrix whose definiteness is asked";
    let mut enclosed = Matrix::from_fn(n, n, |_, _| Interval::zero());
    let enclosure = |row: usize, column: usize| {
        m[(row, column)].enclosure().map_err(|value| ProofError::NotFinite { what, row, column, value })
    };
    for row in 0..n {
        for column in row..n {
            let (upper, lower) = (enclosure(row, column)?, enclosure(column, row)?);
            let asymmetric =
                || ProofError::NotSymmetric { what, row, column, upper: upper.midpoint(), lower: lower.midpoint() };
            if let (Some(x), Some(y)) = (m[(row, column)].exact(), m[(column, row)].exact())
                && x != y
            {
                return Err(asymmetric());
            }
            let both = upper.intersection(&lower).ok_or_else(asymmetric)?;
            let both = if negated { both.neg() } else { both };
            enclosed[(row, column)] = both;
            enclosed[(column, row)] = both;
        }
    }
    Ok(enclosed)
}

/// The exact matrix, if every entry is a single number.
fn exact_entries<T: Entry>(m: &Matrix<T>) -> Option<Matrix<Exact>> {
    let entries: Option<Vec<Exact>> = m.as_slice().iter().map(Entry::exact).collect();
    Matrix::from_row_major(m.rows(), m.cols(), entries?).ok()
}

fn ball(enclosed: &Matrix<Interval>) -> Option<Ball> {
    let n = enclosed.rows();
    let parts: Option<Vec<(f64, f64)>> = enclosed.as_slice().iter().map(Interval::midpoint_radius).collect();
    let parts = Matrix::from_row_major(n, n, parts?).ok()?;
    Some(Ball { mid: parts.map(|x| x.0), rad: parts.map(|x| x.1) })
}
