//! Errors of an enclosure.

use thiserror::Error;

use super::place::{Axis, Entry, Place};

/// Why there is no enclosure.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum EnclosureError {
    /// Bounds of an empty interval: NaN, or the lower above the upper, or both infinite of one sign.
    #[error("{axis} has the bounds [{lo}, {hi}], between which there is no number")]
    Bounds {
        /// Which coordinate.
        axis: Axis,
        /// Its lower bound.
        lo: f64,
        /// Its upper bound.
        hi: f64,
    },
    /// The box, or a column of the plant, does not have the declared number of entries.
    #[error("the plant says that it has {expected} {what}; the box, or what the plant itself works with, has {found}")]
    Dimension {
        /// Of what.
        what: &'static str,
        /// The number that the plant declares.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// An entry of a Jacobian that is not bounded.
    #[error("{entry} has no finite bound at {place}")]
    Unbounded {
        /// The entry.
        entry: Entry,
        /// Where.
        place: Place,
    },
    /// An operation in the right-hand side or in the output that is not defined at some point, or jumps there.
    #[error("{}", undefined(operation, side, place))]
    Undefined {
        /// The operation.
        operation: &'static str,
        /// `f` or `h`.
        side: &'static str,
        /// Where.
        place: Place,
    },
    /// A right-hand side with more open branches than are explored.
    #[error("{side} has more than 64 ways through its branches at {place}")]
    TooManyBranches {
        /// `f` or `h`.
        side: &'static str,
        /// Where.
        place: Place,
    },
    /// The limit of evaluated parts was reached before every part of the box had a finite enclosure.
    #[error("after {parts} bisections, parts of the box have no finite enclosure, such as that at {place}")]
    Effort {
        /// How many parts were examined.
        parts: usize,
        /// A part that was left.
        place: Place,
    },
}

/// Branches that do not meet; see [`branches`](super::branches).
pub(super) const CHOICE: &str = "the choice between two branches";

fn undefined(operation: &str, side: &str, place: &Place) -> String {
    match operation {
        CHOICE => format!(
            "{side} jumps at {place}: two branches of a condition do not meet there, and certified designs need a continuous right-hand side"
        ),
        "signum" => format!("{side} jumps by sign at {place}: certified designs need a continuous right-hand side"),
        "floor" => {
            format!(
                "{side} jumps by floor, wrap or mod at {place}: certified designs need a continuous right-hand side"
            )
        }
        _ => format!("{operation} in {side} is not defined, or jumps, at {place}"),
    }
}
