//! The keys of an `[[observer]]` and their values.

use luenberger_proof::wording::shortest;
use nalgebra::DMatrix;

/// The value of a key.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A number.
    Number(f64),
    /// A list.
    List(Vec<Value>),
    /// An inline table.
    Table(Keys),
}

/// Keys with their values.
pub type Keys = Vec<(&'static str, Value)>;

impl Value {
    pub(crate) fn numbers(numbers: impl IntoIterator<Item = f64>) -> Self {
        Self::List(numbers.into_iter().map(Self::Number).collect())
    }

    pub(crate) fn pairs(pairs: &[(f64, f64)]) -> Self {
        Self::List(pairs.iter().map(|(low, high)| Self::numbers([*low, *high])).collect())
    }

    pub(crate) fn rows(matrix: &DMatrix<f64>) -> Self {
        Self::List(matrix.row_iter().map(|row| Self::numbers(row.iter().copied())).collect())
    }

    /// A weight: the list of the diagonal of a diagonal matrix, else its rows.
    pub(crate) fn weight(matrix: &DMatrix<f64>) -> Self {
        let is_diagonal = (0..matrix.nrows()).all(|i| (0..matrix.ncols()).all(|j| i == j || matrix[(i, j)] == 0.0));
        if is_diagonal { Self::numbers(matrix.diagonal().iter().copied()) } else { Self::rows(matrix) }
    }

    pub(crate) fn toml(&self) -> String {
        match self {
            Self::Number(x) => shortest(*x),
            Self::List(list) => format!("[{}]", list.iter().map(Self::toml).collect::<Vec<_>>().join(", ")),
            Self::Table(keys) => inline(keys),
        }
    }

    pub(crate) fn json(&self) -> serde_json::Value {
        match self {
            Self::Number(x) if x.is_finite() => (*x).into(),
            Self::Number(x) => shortest(*x).into(),
            Self::List(list) => list.iter().map(Self::json).collect(),
            Self::Table(keys) => object(keys).into(),
        }
    }
}

pub(crate) fn inline(keys: &Keys) -> String {
    let entries: Vec<String> = keys.iter().map(|(key, value)| format!("{key} = {}", value.toml())).collect();
    format!("{{ {} }}", entries.join(", "))
}

pub(crate) fn object(keys: &Keys) -> serde_json::Map<String, serde_json::Value> {
    keys.iter().map(|(key, value)| ((*key).to_owned(), value.json())).collect()
}
