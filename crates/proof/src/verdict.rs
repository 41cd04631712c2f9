//! The three outcomes of an attempt to prove a mathematical statement.
//!
//! Floating point proposes; this crate decides. A statement that could be neither proved nor refuted within the
//! effort allowed is `Undecided`, which is an honest answer and never an error.

use core::fmt;

use crate::statement::NoErrorBallReason;
use crate::wording::at_least;

/// What is known of a mathematical statement. `W` is the witness that refutes it.
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
        /// What a reader can check without trusting this crate, for instance a direction `v` with `v'Mv <= 0`.
        witness: W,
    },
    /// Neither was shown.
    Undecided {
        /// What stood in the way.
        why: UndecidedReason,
        /// The floating-point estimate of the margin, which proves nothing.
        best: f64,
    },
}

/// Why a statement stayed undecided.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum UndecidedReason {
    /// The rounding error of the quick test exceeds the margin, and the exact referee was not allowed at this size.
    RoundingDominates {
        /// Bound on the rounding error of the test.
        error: f64,
        /// The order of the matrix.
        order: usize,
    },
    /// The data are intervals, and matrices of both kinds lie within them.
    DataTooUncertain {
        /// The widest entry.
        width: f64,
    },
    /// The solver that should have proposed a solution gave none.
    NoProposal {
        /// The solver's own word for how it ended.
        status: &'static str,
    },
    /// The solver proposed a solution at which an inequality could not be proved.
    ProposalNotProved {
        /// The margin of that inequality as floating point sees it.
        estimate: f64,
    },
    /// The matrix that was to prove the statement does not, and nothing shows that no other would.
    NotByThisMatrix {
        /// Its name.
        name: &'static str,
    },
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
    /// No bound of the error of a running observer is proved.
    NoErrorBall {
        /// Why not.
        obstacle: NoErrorBallReason,
    },
}

impl fmt::Display for UndecidedReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::RoundingDominates { error, order } => write!(
                f,
                "the rounding error bound {error:e} exceeds the margin, and order {order} is beyond the exact referee"
            ),
            Self::DataTooUncertain { width } => {
                write!(f, "the data are known only up to intervals as wide as {width:e}")
            }
            Self::NoProposal { status } => write!(f, "the solver proposed no solution ({status})"),
            Self::ProposalNotProved { estimate } => {
                write!(
                    f,
                    "an inequality is not proved at the solution proposed, where its margin is about {estimate:e}"
                )
            }
            Self::NotByThisMatrix { name } => write!(f, "this {name} does not prove it, and another might"),
            Self::Overflow => write!(f, "an intermediate quantity left the range of binary64"),
            Self::TighterThanProved { row, column, claimed, proved } => write!(
                f,
                "at row {row}, column {column} the bound {claimed:e} is claimed, which is tighter than {proved:e}, which is proved"
            ),
            Self::NoErrorBall { obstacle } => write!(f, "no bound of the running error: {obstacle}"),
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
    /// Whether the statement is proved. There is no `is_false` to go with it: not proved is not refuted.
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

    /// The same verdict with its witness translated, for instance from a block of a matrix to the whole.
    pub fn map_witness<V>(self, f: impl FnOnce(W) -> V) -> Verdict<V> {
        match self {
            Self::Proved { margin } => Verdict::Proved { margin },
            Self::Refuted { witness } => Verdict::Refuted { witness: f(witness) },
            Self::Undecided { why, best } => Verdict::Undecided { why, best },
        }
    }

    /// One word for tables.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Proved { .. } => "Proved",
            Self::Refuted { .. } => "Refuted",
            Self::Undecided { .. } => "Undecided",
        }
    }
}
