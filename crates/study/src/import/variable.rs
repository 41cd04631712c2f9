//! Content of a model file of any format: named variables.

use super::{ImportError, LARGEST_MATRIX};
use nalgebra::DMatrix;

/// The names that are used, in lower case.
const KNOWN: [&str; 7] = ["a", "b", "c", "d", "e", "dt", "ts"];

/// One variable of a file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Variable {
    /// Its name, as the file has it.
    pub(super) name: String,
    pub(super) value: Value,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    /// A matrix of real numbers.
    Matrix(DMatrix<f64>),
    /// A structure, with its fields.
    Structure(Vec<Variable>),
    /// Anything else, with a description.
    Other(String),
}

impl Variable {
    /// The name, with a description of the type if it is neither a matrix nor a model and its type is known.
    pub(super) fn described(&self) -> String {
        match &self.value {
            Value::Other(what) if what != UNREAD => format!("{} ({what})", self.name),
            _ => self.name.clone(),
        }
    }
}

/// Description of a variable that was skipped.
pub(super) const UNREAD: &str = "not read";

/// Whether a variable of this name is read; of all others only the names are kept.
pub(super) fn is_known(name: &str) -> bool {
    KNOWN.iter().any(|known| known.eq_ignore_ascii_case(name))
}

/// The number of entries of a matrix, if it is within the limit.
pub(super) fn entries(name: &str, rows: u64, columns: u64) -> Result<usize, ImportError> {
    let too_large = || ImportError::TooLarge { name: name.to_owned(), rows, columns, limit: LARGEST_MATRIX };
    // The dimensions are bounded too: an empty matrix has no entries, whatever its other dimension.
    if rows.max(columns) > LARGEST_MATRIX as u64 {
        return Err(too_large());
    }
    let count = rows.checked_mul(columns).filter(|count| *count <= LARGEST_MATRIX as u64).ok_or_else(too_large)?;
    Ok(count as usize)
}
