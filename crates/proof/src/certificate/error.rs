//! Errors of a certificate file, with the line and the field.

use core::fmt;

use thiserror::Error;

use super::limits::{DEEPEST, LARGEST_FILE, MOST_MOTION, MOST_VALUES};
use crate::error::ProofError;
use crate::number::{Number, NumberError};
use crate::polynomial::ExpressionError;
use crate::semidefinite::ProgramError;
use crate::verdict::Verdict;
use crate::witness::Witness;
use crate::wording::{shortest, significant};

/// Why a text is not a certificate, before any verification.
#[derive(Debug, Clone, PartialEq)]
pub struct FileError {
    /// The line, from 1.
    pub line: usize,
    /// The field, as in `lyapunov.P[1][0]`; empty where the text is not yet a tree of fields.
    pub path: String,
    /// The error.
    pub fault: Fault,
}

impl FileError {
    pub(super) fn at(line: usize, fault: Fault) -> Self {
        Self { line, path: String::new(), fault }
    }

    /// Whether the text is not JSON at all.
    pub fn is_unreadable(&self) -> bool {
        matches!(
            self.fault,
            Fault::TooLarge { .. }
                | Fault::NotUtf8 { .. }
                | Fault::Truncated { .. }
                | Fault::Unexpected { .. }
                | Fault::TooDeep
                | Fault::TooManyMembers
                | Fault::TooManyValues
                | Fault::NotJson { .. }
                | Fault::Duplicate { .. }
        )
    }
}

impl std::error::Error for FileError {}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}", self.line)?;
        if !self.path.is_empty() {
            write!(f, ", {}", self.path)?;
        }
        write!(f, ": {}", self.fault)
    }
}

/// Error at a position of a file.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Fault {
    /// More bytes than the limit.
    #[error("the file has {bytes} bytes or more, {LARGEST_FILE} are read at most")]
    TooLarge {
        /// The number of bytes, at least.
        bytes: usize,
    },
    /// The bytes are not UTF-8 text.
    #[error("the byte at position {byte} is not UTF-8")]
    NotUtf8 {
        /// The position, from 0.
        byte: usize,
    },
    /// The text ends early.
    #[error("the file ends where {expected} should be")]
    Truncated {
        /// The expectation.
        expected: &'static str,
    },
    /// An unexpected character.
    #[error("{found:?} stands where {expected} should be")]
    Unexpected {
        /// The expectation.
        expected: &'static str,
        /// The character found.
        found: char,
    },
    /// The nesting exceeds the limit.
    #[error("arrays and objects are nested deeper than {DEEPEST}")]
    TooDeep,
    /// An object with more members than any certificate has.
    #[error("an object has more than 64 members")]
    TooManyMembers,
    /// More values than any certificate has.
    #[error("the file has more than {MOST_VALUES} values")]
    TooManyValues,
    /// A text that begins as a number but is not a JSON number.
    #[error("{text} is no number of JSON (no leading zeros, digits on both sides of a point, digits in an exponent)")]
    NotJson {
        /// The text, or its beginning.
        text: String,
    },
    /// A name twice in one object.
    #[error("the field \"{name}\" is given twice")]
    Duplicate {
        /// The name.
        name: String,
    },
    /// A field that a certificate of this kind must have.
    #[error("the field \"{name}\" is missing")]
    Missing {
        /// Its name.
        name: &'static str,
    },
    /// An unknown field for this kind of certificate.
    #[error("the field \"{name}\" does not belong here")]
    Unknown {
        /// Its name.
        name: String,
    },
    /// A value of the wrong type.
    #[error("is {found}, and should be {expected}")]
    Type {
        /// The expected type.
        expected: &'static str,
        /// The actual type.
        found: &'static str,
    },
    /// A text that is not a number.
    #[error("{0}")]
    Number(#[from] NumberError),
    /// A fraction where the theorem takes the numbers that are stored, or multipliers that must satisfy equations
    /// exactly.
    #[error("{number} is no {needed}: this quantity is not enclosed, it must be exact")]
    NotExact {
        /// The number, or its beginning.
        number: String,
        /// The expectation.
        needed: &'static str,
    },
    /// A lower bound above the upper bound.
    #[error("the lower bound {lo} lies above the upper bound {hi}")]
    Bounds {
        /// The lower bound.
        lo: Box<Number>,
        /// The upper bound.
        hi: Box<Number>,
    },
    /// Rows of different lengths.
    #[error("has {found} entries, and the first row has {expected}")]
    Ragged {
        /// Entries of the first row.
        expected: usize,
        /// Entries of this one.
        found: usize,
    },
    /// A matrix of the wrong shape.
    #[error("must be {} x {}, found {} x {}", expected.0, expected.1, found.0, found.1)]
    Shape {
        /// Rows and columns it should have.
        expected: (usize, usize),
        /// Rows and columns it has.
        found: (usize, usize),
    },
    /// No rows or no columns.
    #[error("is empty")]
    Empty,
    /// More rows or columns than are checked in bounded time.
    #[error("is of order {order}; the checker goes up to {allowed}")]
    TooManyRows {
        /// The larger of rows and columns.
        order: usize,
        /// The limit.
        allowed: usize,
    },
    /// Sparse matrices that are too large together.
    #[error("the matrices have {entries} entries together, zeros included; the checker goes up to {allowed}")]
    TooManyEntries {
        /// How many.
        entries: usize,
        /// The limit.
        allowed: usize,
    },
    /// More motions between corrections than are checked in bounded time.
    #[error(
        "{misses} misses are too many for {states} states: {states}^3 states times {spans} spans of time are {motion}; the checker goes up to {MOST_MOTION}"
    )]
    TooMuchMotion {
        /// The number of states.
        states: usize,
        /// How many samples in a row may be missed.
        misses: usize,
        /// The spans of time over which the decrease is shown, of all maps.
        spans: usize,
        /// Their product with the cube of the states.
        motion: usize,
    },
    /// A list whose length does not match another field.
    #[error("has {found} elements, and should have {expected}")]
    Length {
        /// The required length.
        expected: usize,
        /// The actual length.
        found: usize,
    },
    /// A matrix that must be symmetric.
    #[error("is {lower}, and its mirror image is {upper}: the matrix must be symmetric")]
    NotSymmetric {
        /// The entry below the diagonal.
        lower: String,
        /// The entry above.
        upper: String,
    },
    /// A word that is not one of the allowed ones.
    #[error("\"{found}\" is unknown; known are {known}")]
    Word {
        /// The word.
        found: String,
        /// The allowed words.
        known: String,
    },
    /// An index out of range.
    #[error("the index {found} is too large: {limit} is the largest")]
    Index {
        /// The index.
        found: usize,
        /// The largest.
        limit: usize,
    },
    /// A quantity outside its valid range.
    #[error("is {value}, and {requirement}")]
    Range {
        /// Its value.
        value: f64,
        /// The valid range.
        requirement: &'static str,
    },
    /// A text that is no expression in the variables of its place.
    #[error("entry {}: {error}", entry + 1)]
    Expression {
        /// The entry of the list, from 0.
        entry: usize,
        /// The error.
        error: ExpressionError,
    },
    /// Data that do not define a semidefinite program.
    #[error("{0}")]
    Program(#[from] ProgramError),
    /// Another version of the format.
    #[error("version {found} of the format is not known; this checker knows version {}", super::VERSION)]
    Version {
        /// The version of the file.
        found: String,
    },
}

/// Why a certificate that was read is rejected.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Rejection {
    /// The text is not a certificate.
    #[error("{0}")]
    File(#[from] FileError),
    /// The design has no theorem, so there is nothing to write.
    #[error("no theorem is claimed")]
    Nothing,
    /// The content does not match its digest.
    #[error("line {line}, sha256: the digest of the content is {computed}, and the file says {found}")]
    Digest {
        /// The line of the digest.
        line: usize,
        /// The value in the file.
        found: String,
        /// The digest of its content.
        computed: String,
    },
    /// The text does not match the data.
    #[error("line {line}, statement: the words do not say what the data say; they should be \"{derived}\"")]
    Words {
        /// The line of the statement.
        line: usize,
        /// What the checker derives from the data.
        derived: String,
    },
    /// A claimed inequality is not one of the theorem, or in the wrong position.
    #[error("line {line}, margins[{index}].inequality: the inequality in this place is \"{expected}\"")]
    Inequality {
        /// The line.
        line: usize,
        /// The position in the list, from 0.
        index: usize,
        /// The inequality of the theorem.
        expected: String,
    },
    /// More or fewer claims than the theorem has inequalities.
    #[error("line {line}, margins: the theorem has {expected} inequalities, and {found} are claimed")]
    Claims {
        /// The line.
        line: usize,
        /// Inequalities of the theorem.
        expected: usize,
        /// Claims of the file.
        found: usize,
    },
    /// A claimed margin is larger than the verified one.
    #[error(
        "line {line}, margins[{index}].margin: {inequality} is proved with the margin {proved} ({proved_decimal:e}), and {claimed} ({claimed_decimal:e}) is claimed"
    )]
    Margin {
        /// The line.
        line: usize,
        /// The position in the list, from 0.
        index: usize,
        /// The inequality.
        inequality: String,
        /// The claim.
        claimed: Box<Number>,
        /// The same, rounded.
        claimed_decimal: f64,
        /// The verified margin.
        proved: Box<Number>,
        /// The same.
        proved_decimal: f64,
    },
    /// An inequality is not proved: refuted by the witness, or undecided.
    #[error("{inequality} {}", not_proved(verdict))]
    NotProved {
        /// The inequality.
        inequality: String,
        /// The verdict.
        verdict: Box<Verdict<Witness>>,
    },
    /// The inequality could not be evaluated.
    #[error("the inequalities cannot be evaluated: {0}")]
    Proof(#[from] ProofError),
}

fn not_proved(verdict: &Verdict<Witness>) -> String {
    match verdict {
        Verdict::Proved { margin } => format!("is proved with the margin {}", shortest(*margin)),
        Verdict::Refuted { witness } => format!("is false: {witness}"),
        Verdict::Undecided { why, best } if best.is_nan() => format!("is not proved: {why}"),
        Verdict::Undecided { why, best } => format!("is not proved: {why} (best margin {})", significant(*best, 3)),
    }
}
