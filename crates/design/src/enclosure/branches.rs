//! Bounds of the jump between two branches of a right-hand side.
//!
//! Let `f_i` and `f_j` be the formulas of two ways through the comparisons that a part X of the box leaves open, c the
//! middle of X. By the mean value theorem, over all coordinates (states, inputs and time),
//! ```text
//!     f_i(x) - f_j(x)  in  f_i(c) - f_j(c) + sum_k (df_i/dx_k - df_j/dx_k)(X) (X_k - c_k)        for x in X.
//! ```
//! What the two have in common cancels at c, and its slope nearly does. If 0 is not in this interval (and in that of
//! the difference of the values), f jumps wherever these two ways meet in X; and no jump between them in X is larger
//! than the interval's magnitude.

use core::fmt;

use luenberger_proof::{Interval, Ring};

use super::error::CHOICE;
use super::evaluation::{Evaluation, Failure, middle};
use super::paths::{Undefined, Way, explore_ways, follow};
use super::scalar::IntervalDual;
use luenberger_proof::wording::significant;

/// Bounds of the discontinuity of f and h where they change branches. Continuity there is a hypothesis of every
/// conclusion from the Jacobians: a jump can be arbitrarily small.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Branches {
    /// How many parts of the box leave a comparison open.
    pub parts: usize,
    /// No jump is larger than this, in any row of f or h: rigorous. Infinite where no bound was found.
    pub jump: f64,
}

impl fmt::Display for Branches {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("f and h are continuous where they change branches (no jump was found")?;
        if self.jump.is_finite() {
            // Three digits, rounded up.
            write!(f, ", and none is larger than {}", significant(self.jump * 1.01, 3))?;
        }
        f.write_str(")")
    }
}

/// The largest difference of two ways over a part, and the coordinate that contributes most to it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gap {
    pub(super) bound: f64,
    pub(super) axis: Option<usize>,
}

/// A difference below this share of the values is rounding: of the constants that make two branches meet, and of the
/// formulas.
const ROUNDING: f64 = 256.0 * f64::EPSILON;

/// One way: its values and, for each coordinate, its slopes over the part; its values in the middle.
struct Branch {
    values: Vec<Interval>,
    slopes: Vec<Vec<Interval>>,
    centre: Option<Vec<Interval>>,
}

impl Evaluation<'_> {
    /// How far apart the ways through the open comparisons of this part can be; an error where two of them cannot meet.
    pub(super) fn gap(&self, cell: &[Interval]) -> Result<Gap, Failure> {
        let mut largest = Gap { bound: 0.0, axis: None };
        for side in ["f", "h"] {
            let branches = self.branches(side, cell)?;
            for (i, first) in branches.iter().enumerate() {
                for second in &branches[..i] {
                    let gap =
                        between(first, second, cell).ok_or(Failure::Undefined(Undefined::Operation(CHOICE), side))?;
                    if gap.bound > largest.bound {
                        largest = gap;
                    }
                }
            }
        }
        Ok(largest)
    }

    fn branches(&self, side: &'static str, cell: &[Interval]) -> Result<Vec<Branch>, Failure> {
        let undefined = |why: Undefined| Failure::Undefined(why, side);
        let centre: Vec<Interval> =
            cell.iter().map(|axis| Interval::new(middle(axis), middle(axis)).unwrap_or(*axis)).collect();
        let mut branches: Vec<Branch> = Vec::new();
        for along in 0..cell.len() {
            let ways = explore_ways(|| self.over(side, cell, Some(along))).map_err(undefined)?;
            // A right-hand side that is not a function, such as one that counts its calls, takes other ways each time.
            if along > 0 && ways.len() != branches.len() {
                return Err(undefined(Undefined::TooManyBranches));
            }
            for (which, (result, way)) in ways.into_iter().enumerate() {
                let result: Vec<IntervalDual> = result?;
                if along == 0 {
                    branches.push(Branch {
                        values: result.iter().map(IntervalDual::value).collect(),
                        slopes: Vec::with_capacity(cell.len()),
                        centre: self.at(side, &centre, &way),
                    });
                }
                branches[which].slopes.push(result.iter().map(IntervalDual::slope).collect());
            }
        }
        Ok(branches)
    }

    fn at(&self, side: &str, centre: &[Interval], way: &Way) -> Option<Vec<Interval>> {
        let result = follow(way, || self.over(side, centre, None))?.ok()?;
        Some(result.iter().map(IntervalDual::value).collect())
    }
}

/// The largest difference of two branches in a row; none if they cannot meet.
fn between(first: &Branch, second: &Branch, cell: &[Interval]) -> Option<Gap> {
    let mut largest = Gap { bound: 0.0, axis: None };
    for row in 0..first.values.len().min(second.values.len()) {
        let mut size = first.values[row].magnitude().max(second.values[row].magnitude());
        let mut difference = first.values[row].sub(&second.values[row]);
        let mut main = (0.0, None);
        if let (Some(a), Some(b)) = (&first.centre, &second.centre) {
            size = size.min(a[row].magnitude().max(b[row].magnitude()));
            let mut expansion = a[row].sub(&b[row]);
            for (k, axis) in cell.iter().enumerate() {
                let slope = first.slopes[k][row].sub(&second.slopes[k][row]);
                // Two equal numbers cancel exactly, and a coordinate may be unbounded.
                let term = if first.slopes[k][row] == second.slopes[k][row] && first.slopes[k][row].is_point() {
                    Interval::zero()
                } else {
                    slope.mul(&axis.sub(&Interval::of(middle(axis))))
                };
                if term.magnitude() > main.0 {
                    main = (term.magnitude(), Some(k));
                }
                expansion = expansion.add(&term);
            }
            let rounding = ROUNDING * size;
            // Both enclose it, up to the rounding that is forgiven.
            difference = difference.intersection(&expansion).filter(|d| d.lo() <= rounding && d.hi() >= -rounding)?;
        } else if difference.lo() > ROUNDING * size || difference.hi() < -ROUNDING * size {
            return None;
        }
        if difference.magnitude() > largest.bound {
            largest = Gap { bound: difference.magnitude(), axis: main.1 };
        }
    }
    Some(largest)
}
