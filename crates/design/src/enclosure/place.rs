//! Coordinates, entries and positions in a box as text.

use core::fmt;

use luenberger_plants::Dimensions;

use crate::names;
use luenberger_proof::wording::significant;

/// A coordinate of the box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// A state, from 0.
    State(usize),
    /// An input, from 0.
    Input(usize),
    /// Time.
    Time,
}

impl Axis {
    pub(crate) fn of(k: usize, size: Dimensions) -> Self {
        if k < size.states {
            Self::State(k)
        } else if k < size.states + size.inputs {
            Self::Input(k - size.states)
        } else {
            Self::Time
        }
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::State(k) => f.write_str(&names::state(*k)),
            Self::Input(k) => f.write_str(&names::input(*k)),
            Self::Time => f.write_str("t"),
        }
    }
}

/// An entry of Df or Dh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Entry {
    /// Whether it belongs to Dh.
    pub of_output: bool,
    /// Its row, from 0.
    pub row: usize,
    /// Its column, from 0.
    pub column: usize,
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&names::derivative(self.of_output, self.row, self.column))
    }
}

/// Digits of a coordinate that people read: a bisection ends beside the point that it looks for.
const DIGITS: usize = 10;

/// A point of the box, with a part of the box around it that the search ended in. Coordinates that make no difference
/// are left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// The coordinates with their values: 0 where the part contains 0, else its middle; for an unbounded part its
    /// finite end.
    pub point: Vec<(Axis, f64)>,
    /// The part: lower and upper bounds of these coordinates.
    pub part: Vec<(f64, f64)>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let coordinates: Vec<String> = self
            .point
            .iter()
            .zip(&self.part)
            // A coordinate of which all values are meant says nothing.
            .filter(|(_, part)| part.0.is_finite() || part.1.is_finite())
            .map(|((axis, x), (lo, hi))| {
                if hi.is_infinite() {
                    format!("{axis} >= {}", significant(*x, DIGITS))
                } else if lo.is_infinite() {
                    format!("{axis} <= {}", significant(*x, DIGITS))
                } else {
                    format!("{axis} = {}", significant(*x, DIGITS))
                }
            })
            .collect();
        f.write_str(&if coordinates.is_empty() { "every point".to_owned() } else { coordinates.join(", ") })
    }
}
