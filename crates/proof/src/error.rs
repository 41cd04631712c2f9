//! What makes a question to this crate meaningless, as distinct from undecided.

use thiserror::Error;

/// An input about which nothing can be said. Each variant names the quantity and carries its value.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ProofError {
    /// Two shapes that should agree do not.
    #[error("{what} should be {} x {} and is {} x {}", expected.0, expected.1, found.0, found.1)]
    DimensionMismatch {
        /// The quantity.
        what: &'static str,
        /// Rows and columns it should have.
        expected: (usize, usize),
        /// Rows and columns it has.
        found: (usize, usize),
    },
    /// An entry is NaN or infinite.
    #[error("{what} has the entry {value} at row {row}, column {column}")]
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
    /// A matrix whose definiteness is asked is not symmetric. Definiteness is never asked of the symmetric part in silence.
    #[error("{what} is not symmetric: ({row}, {column}) is {upper:e} and ({column}, {row}) is {lower:e}")]
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
}
