//! Errors of invalid input, as distinct from undecided verdicts.

use luenberger_wording::{entry, shortest};
use thiserror::Error;

/// Invalid input. Each variant names the quantity and carries its value.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ProofError {
    /// Two shapes that should agree do not.
    #[error("{what} must be {} x {}, found {} x {}", expected.0, expected.1, found.0, found.1)]
    DimensionMismatch {
        /// The quantity.
        what: &'static str,
        /// Rows and columns it should have.
        expected: (usize, usize),
        /// Rows and columns it has.
        found: (usize, usize),
    },
    /// A list or a matrix has no entry, so that a statement about it would be vacuous.
    #[error("{what} is empty")]
    Empty {
        /// The quantity.
        what: &'static str,
    },
    /// An entry is NaN or infinite.
    #[error("{what}{} is {value}", entry(*row, *column))]
    NotFinite {
        /// The quantity.
        what: &'static str,
        /// Row of the entry, from 0.
        row: usize,
        /// Column of the entry, from 0.
        column: usize,
        /// The entry.
        value: f64,
    },
    /// A matrix is not symmetric. Definiteness of the symmetric part is never tested implicitly.
    #[error("{what} is not symmetric: entry {} is {} and {} is {}", entry(*row, *column), shortest(*upper), entry(*column, *row), shortest(*lower))]
    NotSymmetric {
        /// The quantity.
        what: &'static str,
        /// Row of the entry above the diagonal, from 0.
        row: usize,
        /// Its column, from 0.
        column: usize,
        /// The entry above the diagonal (the midpoint, of an interval).
        upper: f64,
        /// The entry below the diagonal.
        lower: f64,
    },
    /// An unsupported fixed-point format.
    #[error(
        "a fixed-point format of {integer_bits} integer bits (the sign among them) and {fraction_bits} fraction bits: \
         at least 1 integer bit and 2 to 53 bits in all are supported"
    )]
    Format {
        /// Bits before the point, the sign among them.
        integer_bits: u32,
        /// Bits after the point.
        fraction_bits: u32,
    },
    /// A number that cannot be stored in its format.
    #[error("{what}{} is {}, and its format ends at {}", entry(*row, *column), shortest(*value), shortest(*largest))]
    OutOfRange {
        /// The quantity.
        what: &'static str,
        /// Row of the entry, from 0.
        row: usize,
        /// Column of the entry, from 0.
        column: usize,
        /// The entry.
        value: f64,
        /// The largest number of the format.
        largest: f64,
    },
    /// A matrix that exceeds the memory limit of the checker.
    #[error("{what} would be of order {order}; at most {allowed} are formed")]
    TooLarge {
        /// The matrix.
        what: &'static str,
        /// Its order.
        order: usize,
        /// The largest order.
        allowed: usize,
    },
    /// A label that is no inequality in the names that are given.
    #[error("\"{label}\" is no inequality in the names given")]
    Label {
        /// The label, or the expression.
        label: String,
    },
    /// Motions between corrections that are more than the checker decides in bounded time.
    #[error(
        "the motion of {states} states over {spans} spans of time is {motion} in all, and at most {allowed} is decided"
    )]
    TooMuchMotion {
        /// The number of states.
        states: usize,
        /// The spans of time, of all maps.
        spans: usize,
        /// Their product with the cube of the states.
        motion: usize,
        /// The limit.
        allowed: usize,
    },
    /// A bound or a scalar that must not be negative (or must be positive) is, or is not finite.
    #[error("{what} is {value}")]
    Sign {
        /// The quantity, and what it should be.
        what: &'static str,
        /// Its value.
        value: f64,
    },
}
