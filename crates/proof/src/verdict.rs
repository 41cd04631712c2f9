//! The three outcomes of a rigorous verification.
//!
//! Approximate data come from floating point; this crate verifies them. A statement that could be neither proved nor
//! refuted within the limits is `Undecided`, which is not an error.

use core::fmt;

use crate::wording::{at_least, at_most, entry, shortest, significant};

/// Verdict on a mathematical statement. `W` is the type of the witness of a refutation.
#[derive(Debug, Clone, PartialEq)]
pub enum Verdict<W> {
    /// The statement holds, by a computation that bounds or avoids every rounding error.
    Proved {
        /// A rigorous lower bound on the distance to falsehood, in the units of the statement: for `M > 0`, a number
        /// not above the smallest eigenvalue of `M`. Zero where the statement holds with no room.
        margin: f64,
    },
    /// The statement is false, and the witness shows it.
    Refuted {
        /// A witness that can be checked independently of this crate, for instance a direction `v` with `v'Mv <= 0`.
        witness: W,
    },
    /// Neither proved nor refuted.
    Undecided {
        /// The reason.
        why: UndecidedReason,
        /// The floating-point estimate of the margin, not rigorous.
        best: f64,
    },
}

/// Why a statement stayed undecided.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum UndecidedReason {
    /// The rounding error bound of the floating-point test exceeds the margin, and the order exceeds the limit of exact
    /// elimination.
    RoundingDominates {
        /// Bound on the rounding error of the test.
        error: f64,
        /// The order of the matrix.
        order: usize,
    },
    /// The data are intervals that contain matrices of both kinds.
    DataTooUncertain {
        /// The widest entry.
        width: f64,
    },
    /// The solver returned no approximate solution.
    NoProposal {
        /// The status reported by the solver.
        status: &'static str,
    },
    /// The solver returned an approximate solution for which an inequality could not be proved.
    ProposalNotProved {
        /// The margin of that inequality in floating point.
        estimate: f64,
    },
    /// The given matrix does not prove the statement, and it is not shown that no other does.
    NotByThisMatrix {
        /// Its name.
        name: &'static str,
    },
    /// The data of a theorem are not shown to contain all that it is applied to.
    OutsideTheData,
    /// An intermediate quantity left the range of binary64.
    Overflow,
    /// A bound is claimed that is tighter than what is proved.
    TighterThanProved {
        /// Row of the entry, from 0.
        row: usize,
        /// Column of the entry, from 0.
        column: usize,
        /// The claim.
        claimed: f64,
        /// What is proved.
        proved: f64,
    },
    /// A bound over a box is claimed that is not shown.
    NotBounded {
        /// The entry of the quantity, from 0.
        entry: usize,
        /// The claim.
        claimed: f64,
        /// What is shown.
        shown: f64,
    },
    /// A map is not shown to be defined: the argument of a logarithm or a root is not shown to be positive, or a
    /// denominator to have one sign.
    Undefined {
        /// The argument, in the order of the expressions, from 1.
        argument: usize,
        /// It is shown to be at least this.
        least: f64,
    },
    /// Times between corrections that would have to be divided further than the checker does.
    TooMuchWork,
    /// Expressions whose polynomials exceed the limits of the checker.
    ExpressionTooLarge,
    /// An expression with a denominator that is 0 everywhere.
    DivisionByZero,
    /// No bound of the error of a running observer is proved.
    NoErrorBall {
        /// Why not.
        reason: NoErrorBallReason,
    },
}

/// Why no bound of the running error of a deployed observer is proved.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum NoErrorBallReason {
    /// The observer is not proved to converge as stored, in exact arithmetic.
    NotStable,
    /// Contraction and rounding together do not shorten the error: `contraction + relative` is 1 or more.
    RoundingDominates {
        /// The factor of the exact map, proved; infinite where outward rounding left none.
        contraction: f64,
        /// What rounding adds.
        relative: f64,
    },
    /// An intermediate number may leave its range.
    Range {
        /// Which one.
        what: &'static str,
        /// The bound of its magnitude.
        size: f64,
        /// The magnitude that it may have.
        limit: f64,
    },
    /// The cubic observer takes a root, and the fixed-point one is not specified.
    RootInFixedPoint,
}

impl fmt::Display for NoErrorBallReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotStable => write!(f, "this P does not prove the stored observer stable"),
            Self::RoundingDominates { contraction, relative } => {
                write!(
                    f,
                    "a step shortens the error by the factor {contraction}, to which rounding adds {}",
                    at_most(*relative, 3)
                )
            }
            Self::Range { what, size, limit } => {
                write!(f, "{what} may be as large as {}, and its range ends at {}", at_most(*size, 3), shortest(*limit))
            }
            Self::RootInFixedPoint => write!(f, "the root of the cubic observer is not specified in fixed point"),
        }
    }
}

impl fmt::Display for UndecidedReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::RoundingDominates { error, order } => write!(
                f,
                "the rounding error bound {} exceeds the margin, and order {order} is beyond the exact referee",
                at_most(*error, 3)
            ),
            Self::DataTooUncertain { width } => {
                write!(f, "the data are known only up to intervals as wide as {}", at_most(*width, 3))
            }
            Self::NoProposal { status } => write!(f, "the solver proposed no solution ({status})"),
            Self::ProposalNotProved { estimate } => {
                write!(
                    f,
                    "an inequality is not proved at the solution proposed, where its margin is about {}",
                    significant(*estimate, 3)
                )
            }
            Self::NotByThisMatrix { name } => write!(f, "this {name} does not prove it, and another might"),
            Self::OutsideTheData => write!(f, "the data of the theorem are not shown to contain them all"),
            Self::Overflow => write!(f, "an intermediate quantity left the range of binary64"),
            Self::TooMuchWork => {
                write!(f, "the times between corrections would have to be divided further than the checker does")
            }
            Self::TighterThanProved { row, column, claimed, proved } => write!(
                f,
                "at {} the bound {} is claimed, which is tighter than {}, which is proved",
                entry(*row, *column),
                shortest(*claimed),
                shortest(*proved)
            ),
            Self::NotBounded { entry, claimed, shown } => {
                let (claimed, shown) = (shortest(*claimed), shortest(*shown));
                write!(f, "entry {}: the bound {claimed} is claimed, and {shown} is shown", entry + 1)
            }
            Self::Undefined { argument, least } => write!(
                f,
                "argument {argument} of the logarithms, roots and denominators is shown to be at least {} only: it should be positive, or a denominator of one sign",
                at_least(*least, 3)
            ),
            Self::ExpressionTooLarge => write!(f, "the polynomials of the expressions have too many terms or digits"),
            Self::DivisionByZero => write!(f, "a denominator is 0 everywhere"),
            Self::NoErrorBall { reason } => write!(f, "no bound of the running error: {reason}"),
        }
    }
}

/// `Proved, margin >= 0.76`, `Refuted: ` and the witness, `Undecided: ` and why; the margin is rounded down.
///
/// ```
/// use luenberger_proof::{Matrix, positive_definite};
/// let verdict = |m| positive_definite(&Matrix::<f64>::from_rows(m)).map(|verdict| verdict.to_string());
/// assert!(verdict([[2.0, 0.0], [0.0, 2.0]])?.starts_with("Proved, margin >= 1.9"));
/// assert!(verdict([[1.0, 2.0], [2.0, 1.0]])?.starts_with("Refuted: v = ("));
/// # Ok::<(), luenberger_proof::ProofError>(())
/// ```
impl<W: fmt::Display> fmt::Display for Verdict<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())?;
        match self {
            Self::Proved { margin } if *margin > 0.0 => write!(f, ", margin >= {}", at_least(*margin, 7)),
            Self::Proved { .. } => Ok(()),
            Self::Refuted { witness } => write!(f, ": {witness}"),
            Self::Undecided { why, .. } => write!(f, ": {why}"),
        }
    }
}

impl<W> Verdict<W> {
    /// Whether the statement is proved. A statement that is not proved need not be refuted.
    pub fn is_proved(&self) -> bool {
        matches!(self, Self::Proved { .. })
    }

    /// Whether the statement is refuted.
    pub fn is_refuted(&self) -> bool {
        matches!(self, Self::Refuted { .. })
    }

    /// The proved margin, if there is one.
    pub fn margin(&self) -> Option<f64> {
        match self {
            Self::Proved { margin } => Some(*margin),
            _ => None,
        }
    }

    /// The same verdict with its witness mapped, for instance from a block of a matrix to the whole.
    pub fn map_witness<V>(self, f: impl FnOnce(W) -> V) -> Verdict<V> {
        match self {
            Self::Proved { margin } => Verdict::Proved { margin },
            Self::Refuted { witness } => Verdict::Refuted { witness: f(witness) },
            Self::Undecided { why, best } => Verdict::Undecided { why, best },
        }
    }

    /// The verdict in one word, for tables.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Proved { .. } => "Proved",
            Self::Refuted { .. } => "Refuted",
            Self::Undecided { .. } => "Undecided",
        }
    }
}
