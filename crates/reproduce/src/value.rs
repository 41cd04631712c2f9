//! Printed and computed values: numbers, vectors, matrices or truth values.
//!
//! A printed decimal implies its accuracy: `1.18` stands for any number in `[1.175, 1.185]`. A printed number is
//! therefore kept as its text, from which half a unit of its last digit is derived.

use luenberger_plants::serialization::rows;
use luenberger_proof::wording::significant;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use std::fmt;

/// Six significant digits.
pub(crate) fn short(x: f64) -> String {
    significant(x, 6)
}

/// A number, a vector, a matrix (rows first) or a truth value. In JSON: a number, a list, a list of rows, a boolean;
/// a number that is not finite becomes `null`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Value {
    /// Whether something holds.
    Truth(bool),
    /// A scalar.
    Number(f64),
    /// A list of numbers.
    Vector(Vec<f64>),
    /// The rows of a matrix.
    Matrix(Vec<Vec<f64>>),
}

impl Value {
    /// The entries, row after row; a truth value has none.
    pub fn entries(&self) -> Vec<f64> {
        match self {
            Self::Truth(_) => Vec::new(),
            Self::Number(x) => vec![*x],
            Self::Vector(v) => v.clone(),
            Self::Matrix(rows) => rows.concat(),
        }
    }

    /// `(rows, columns)`: a number is 1 x 1 and a vector of `n` entries n x 1. A truth value is 0 x 0.
    pub fn shape(&self) -> (usize, usize) {
        match self {
            Self::Truth(_) => (0, 0),
            Self::Number(_) => (1, 1),
            Self::Vector(v) => (v.len(), 1),
            Self::Matrix(rows) => (rows.len(), rows.first().map_or(0, Vec::len)),
        }
    }

    /// Whether every entry is finite.
    pub fn is_finite(&self) -> bool {
        self.entries().iter().all(|x| x.is_finite())
    }

    /// Entries of `other` can be compared with these one by one: same shape, where a vector may stand for one row as
    /// well as for one column.
    pub(crate) fn comparable(&self, other: &Self) -> bool {
        let is_truth = |v: &Self| matches!(v, Self::Truth(_));
        let turned = |(r, c): (usize, usize)| (c, r);
        let any_vector = matches!(self, Self::Vector(_)) || matches!(other, Self::Vector(_));
        is_truth(self) == is_truth(other)
            && (self.shape() == other.shape() || (any_vector && self.shape() == turned(other.shape())))
    }
}

impl From<bool> for Value {
    fn from(x: bool) -> Self {
        Self::Truth(x)
    }
}

impl From<f64> for Value {
    fn from(x: f64) -> Self {
        Self::Number(x)
    }
}

impl From<Vec<f64>> for Value {
    fn from(x: Vec<f64>) -> Self {
        Self::Vector(x)
    }
}

impl<const N: usize> From<[f64; N]> for Value {
    fn from(x: [f64; N]) -> Self {
        Self::Vector(x.to_vec())
    }
}

impl From<&DVector<f64>> for Value {
    fn from(x: &DVector<f64>) -> Self {
        Self::Vector(x.as_slice().to_vec())
    }
}

impl From<&DMatrix<f64>> for Value {
    fn from(x: &DMatrix<f64>) -> Self {
        Self::Matrix(rows(x))
    }
}

impl From<DMatrix<f64>> for Value {
    fn from(x: DMatrix<f64>) -> Self {
        Self::from(&x)
    }
}

/// Six significant digits, for tables read by people; the JSON has all of them.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |row: &[f64]| row.iter().map(|&x| short(x)).collect::<Vec<_>>().join("  ");
        match self {
            Self::Truth(x) => write!(f, "{x}"),
            Self::Number(x) => f.write_str(&short(*x)),
            Self::Vector(v) => write!(f, "({})", list(v).replace("  ", ", ")),
            Self::Matrix(rows) => {
                write!(f, "[{}]", rows.iter().map(|row| list(row)).collect::<Vec<_>>().join("; "))
            }
        }
    }
}

/// The printed value.
#[derive(Debug, Clone, PartialEq)]
pub enum Printed {
    /// Decimals exactly as printed: `"1.18"`, a list `"0.48 1.18"`, or a matrix with rows ended by semicolons,
    /// `"13.5 -2.4; -2.4 1.07"` (a column is `"7.5; 3.1"`). A decimal may begin with its point and may carry an
    /// exponent.
    Decimals(&'static str),
    /// A statement that the paper claims to be true (or, rarely, false).
    Holds(bool),
    /// Numbers that the paper gives without rounding: small integers, or what a formula of the paper yields.
    Exactly(Value),
}

/// A printed value that could not be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PrintedError {
    /// One entry is no decimal number.
    #[error("the printed entry {entry:?} is not a decimal number")]
    NotDecimal {
        /// The entry.
        entry: String,
    },
    /// The rows differ in length.
    #[error("row {row} of the printed matrix has {found} entries, and the first has {expected}")]
    Ragged {
        /// The offending row, counted from 1.
        row: usize,
        /// Entries in the first row.
        expected: usize,
        /// Entries in this row.
        found: usize,
    },
    /// Nothing is printed.
    #[error("the printed value is empty")]
    Empty,
}

/// A printed value as numbers, with half a unit of the last printed digit of every entry (0 for exact values).
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reading {
    pub(crate) value: Value,
    pub(crate) half_units: Vec<f64>,
}

impl Printed {
    /// The printed value as numbers.
    /// # Errors
    /// [`PrintedError`] where the text is empty, ragged or no decimal.
    pub fn value(&self) -> Result<Value, PrintedError> {
        self.read().map(|reading| reading.value)
    }

    /// The printed value letter by letter; none for a truth.
    pub fn text(&self) -> Option<String> {
        match self {
            Self::Decimals(text) => Some((*text).to_owned()),
            Self::Holds(_) => None,
            Self::Exactly(value) => Some(value.to_string()),
        }
    }

    pub(crate) fn read(&self) -> Result<Reading, PrintedError> {
        let text = match self {
            Self::Holds(truth) => return Ok(Reading { value: Value::Truth(*truth), half_units: Vec::new() }),
            Self::Exactly(value) => {
                return Ok(Reading { half_units: vec![0.0; value.entries().len()], value: value.clone() });
            }
            Self::Decimals(text) => text,
        };
        let is_matrix = text.contains(';');
        let mut rows: Vec<Vec<f64>> = Vec::new();
        let mut half_units = Vec::new();
        for (i, row) in text.split(';').enumerate() {
            let mut numbers = Vec::new();
            for entry in row.split_whitespace() {
                let (number, half_unit) =
                    decimal(entry).ok_or_else(|| PrintedError::NotDecimal { entry: entry.to_owned() })?;
                numbers.push(number);
                half_units.push(half_unit);
            }
            if numbers.is_empty() {
                return Err(PrintedError::Empty);
            }
            if let Some(first) = rows.first()
                && first.len() != numbers.len()
            {
                return Err(PrintedError::Ragged { row: i + 1, expected: first.len(), found: numbers.len() });
            }
            rows.push(numbers);
        }
        let value = match (is_matrix, rows.as_slice()) {
            (false, [row]) if row.len() == 1 => Value::Number(row[0]),
            (false, [row]) => Value::Vector(row.clone()),
            _ => Value::Matrix(rows),
        };
        Ok(Reading { value, half_units })
    }
}

/// A computed entry with one digit more than the printed one has behind its point, so that the comparison can be seen;
/// six significant digits where the printed one is no plain decimal or the entry is far from it.
pub(crate) fn beside(computed: f64, printed: &str) -> String {
    let places = printed.split_once('.').map_or(0, |(_, fraction)| fraction.len());
    match decimal(printed) {
        Some((number, _)) if !printed.contains(['e', 'E']) && (computed - number).abs() < 10.0 * number.abs() => {
            format!("{computed:.*}", places + 1)
        }
        _ => short(computed),
    }
}

/// The number and half a unit of its last printed digit.
fn decimal(entry: &str) -> Option<(f64, f64)> {
    let (mantissa, exponent) = match entry.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().ok()?),
        None => (entry, 0),
    };
    let digits = mantissa.strip_prefix(['-', '+']).unwrap_or(mantissa);
    let well_formed = digits.chars().all(|c| c.is_ascii_digit() || c == '.') && digits.matches('.').count() <= 1;
    if !well_formed || !digits.contains(|c: char| c.is_ascii_digit()) {
        return None;
    }
    let places = i32::try_from(mantissa.split_once('.').map_or(0, |(_, fraction)| fraction.len())).ok()?;
    let number: f64 = entry.parse().ok()?;
    // Parsed as a decimal too, because a product of powers of ten would add its own rounding.
    let half_unit: f64 = format!("5e{}", exponent.checked_sub(places)?.checked_sub(1)?).parse().ok()?;
    (number.is_finite() && half_unit.is_finite()).then_some((number, half_unit))
}
