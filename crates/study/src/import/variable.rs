//! Content of a model file of any format: named variables.

use super::{ImportError, LARGEST_MATRIX};
use nalgebra::DMatrix;

/// The names that are used, in lower case.
const KNOWN: [&str; 7] = ["a", "b", "c", "d", "e", "dt", "ts"];

/// The names of lists of names, in lower case: MATLAB's, python-control's, and those of a study.
const NAMES: [[&str; 3]; 3] = [
    ["statename", "state_labels", "states"],
    ["inputname", "input_labels", "inputs"],
    ["outputname", "output_labels", "outputs"],
];

/// Which columns a list of names is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Columns {
    States,
    Inputs,
    Outputs,
}

/// Which columns a variable of this name names, if any.
pub(super) fn names_of(name: &str) -> Option<Columns> {
    let all = [Columns::States, Columns::Inputs, Columns::Outputs];
    let is_of = |list: &&[&str; 3]| list.iter().any(|known| known.eq_ignore_ascii_case(name));
    NAMES.iter().zip(all).find(|(list, _)| is_of(list)).map(|(_, columns)| columns)
}

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
    /// A list of texts.
    Names(Vec<String>),
    /// Anything else, with a description.
    Other(String),
}

impl Variable {
    /// The name, with a description of the type if it is neither a matrix nor a model and its type is known.
    pub(super) fn described(&self) -> String {
        match &self.value {
            Value::Other(what) if what != UNREAD => format!("{} ({what})", self.name),
            Value::Names(_) => format!("{} (a list of texts)", self.name),
            _ => self.name.clone(),
        }
    }
}

/// Description of a variable that was skipped.
pub(super) const UNREAD: &str = "not read";

/// Description of what is there in place of a value.
pub(super) const NONE: &str = "null";

/// Whether a variable of this name is read; of all others only the names are kept.
pub(super) fn is_known(name: &str) -> bool {
    KNOWN.iter().any(|known| known.eq_ignore_ascii_case(name)) || names_of(name).is_some()
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
