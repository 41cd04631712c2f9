//! Errors of importing a model.

use luenberger_linalg::LinalgError;
use luenberger_proof::wording::entry;
use thiserror::Error;

/// Error of importing a model.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ImportError {
    /// The file cannot be read.
    #[error("the file cannot be read: {message}")]
    Read {
        /// The error of the system.
        message: String,
    },
    /// The file is longer than the limit.
    #[error("the file is longer than {limit} bytes")]
    TooLong {
        /// The limit.
        limit: u64,
    },
    /// The file is empty.
    #[error("the file is empty")]
    Empty,
    /// The format is not recognized.
    #[error(
        "the file is of no known kind ({bytes} bytes, the first are {first:02x?}): MATLAB's versions 4 and 5 (save -v7), Octave's text, numpy's npz and JSON are read"
    )]
    UnknownKind {
        /// The length of the file.
        bytes: usize,
        /// Its first bytes, eight at most.
        first: Vec<u8>,
    },
    /// MATLAB's version 7.3, which is HDF5.
    #[error(
        "the file is of MATLAB's version 7.3 (HDF5), which is not read: save it with save('model.mat', 'A', 'B', 'C', '-v7')"
    )]
    Hdf5,
    /// numpy's npy format, which holds a single array.
    #[error("the file holds one array of numpy (npy): save all with np.savez('model.npz', A=A, B=B, C=C)")]
    OneArray,
    /// The file is truncated or inconsistent.
    #[error("the file is damaged: {what} at byte {at}")]
    Damaged {
        /// What is wrong.
        what: &'static str,
        /// Byte offset; within compressed data, that of the compressed element.
        at: usize,
    },
    /// The archive of an npz file cannot be opened, or a member cannot be read.
    #[error("the archive is damaged: {message}")]
    Archive {
        /// The error of the zip reader.
        message: String,
    },
    /// The text is not JSON of the expected form.
    #[error("line {line}, column {column}: {message}")]
    Json {
        /// The line, from 1.
        line: usize,
        /// The column, from 1.
        column: usize,
        /// What is wrong.
        message: String,
    },
    /// The text is not Octave's.
    #[error("line {line}: {message}")]
    Text {
        /// The line, from 1.
        line: usize,
        /// What is wrong.
        message: String,
    },
    /// The decompressed data are longer than [`INFLATED`](super::INFLATED).
    #[error("the compressed parts of the file come to more than {limit} bytes")]
    Inflated {
        /// The limit.
        limit: u64,
    },
    /// A matrix of more than [`LARGEST_MATRIX`](super::LARGEST_MATRIX) entries.
    #[error("{name} is {rows} x {columns}; matrices of at most {limit} entries are read")]
    TooLarge {
        /// The variable.
        name: String,
        /// Its rows.
        rows: u64,
        /// Its columns.
        columns: u64,
        /// The limit.
        limit: usize,
    },
    /// A variable that should be a real matrix has another type.
    #[error("{name} is {found}, and must be a matrix of real numbers")]
    NotReal {
        /// The variable.
        name: String,
        /// What it is.
        found: String,
    },
    /// A required matrix is missing.
    #[error("there is no {name} in the file; it holds {}", listed(.found))]
    Missing {
        /// The matrix.
        name: &'static str,
        /// The names in the file.
        found: Vec<String>,
    },
    /// Two variables differ only in the case of their letters, or two structures are candidates.
    #[error("{first} and {second} could both be meant: leave one of them in the file")]
    Ambiguous {
        /// The one.
        first: String,
        /// The other.
        second: String,
    },
    /// A matrix of the wrong shape.
    #[error("{name} must be {expected}, found {} x {}", found.0, found.1)]
    Shape {
        /// The matrix.
        name: &'static str,
        /// The shape it has.
        found: (usize, usize),
        /// The required shape, as text.
        expected: String,
    },
    /// An entry is NaN or infinite.
    #[error("{name}{} is {value}", entry(*row, *column))]
    NotFinite {
        /// The matrix.
        name: &'static str,
        /// The row, from 0.
        row: usize,
        /// The column, from 0.
        column: usize,
        /// The entry.
        value: f64,
    },
    /// E is singular to working precision, or E^-1 A overflows.
    #[error("{0}: the plant of a study is x' = A x + B u, and E x' = A x + B u becomes one if E is regular")]
    Descriptor(LinalgError),
    /// A sampling time that is no number.
    #[error("the sampling time {name} is {value}, and must be positive, or 0 for a model in continuous time")]
    Discrete {
        /// The name of the sampling time.
        name: String,
        /// The sampling time.
        value: String,
    },
}

fn listed(names: &[String]) -> String {
    const SHOWN: usize = 12;
    match names.len() {
        0 => "nothing".to_owned(),
        n if n > SHOWN => format!("{} and {} more", names[..SHOWN].join(", "), n - SHOWN),
        _ => names.join(", "),
    }
}
