//! Witnesses that refute an inequality of a certificate.

use core::fmt;

use crate::definite::Direction;
use crate::wording::shortest;

/// The witness that refutes an inequality of a certificate.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Witness {
    /// A direction along which the quadratic form has the wrong sign.
    Direction(Direction),
    /// A linear equation of multipliers that is not satisfied.
    Equation {
        /// The unknown whose coefficient should vanish, from 1; 0 for the constant, which should have the right sign.
        unknown: usize,
        /// The coefficient, rounded.
        value: f64,
    },
    /// Multipliers that are all zero.
    Zero,
    /// A point of the box at which a quantity exceeds its bound.
    Point {
        /// The entry of the quantity, from 0.
        entry: usize,
        /// The states and the inputs.
        at: Vec<f64>,
        /// The value there is at least this.
        value: f64,
        /// The bound.
        bound: f64,
    },
    /// A number of a target that is not what rounding into its format gives.
    Stored {
        /// The matrix.
        matrix: &'static str,
        /// The row, from 0.
        row: usize,
        /// The column, from 0.
        column: usize,
        /// The value in the file.
        stored: f64,
        /// What rounding to nearest gives.
        nearest: f64,
    },
}

impl fmt::Display for Witness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Direction(direction) => direction.fmt(f),
            Self::Equation { unknown: 0, value } => write!(f, "the constant is {}", shortest(*value)),
            Self::Equation { unknown, value } => write!(f, "the coefficient of x_{unknown} is {}", shortest(*value)),
            Self::Zero => f.write_str("they are all zero"),
            Self::Point { entry, at, value, bound } => {
                let (value, bound) = (shortest(*value), shortest(*bound));
                write!(f, "entry {} is at least {value}, and {bound} is claimed, at {at:?}", entry + 1)
            }
            Self::Stored { matrix, row, column, stored, nearest } => {
                write!(
                    f,
                    "stored.{matrix}[{row}][{column}] is {}, and to nearest it would be {}",
                    shortest(*stored),
                    shortest(*nearest)
                )
            }
        }
    }
}
