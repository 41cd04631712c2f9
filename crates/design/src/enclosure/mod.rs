//! Enclosures of the Jacobians of a plant over a box: every mean value of Df and Dh lies in them.
//!
//! For f and h locally Lipschitz, `f(x) - f(xhat) = Fbar (x - xhat)` with `Fbar = int_0^1 Df(xhat + s (x - xhat)) ds`, and where the segment stays in the box so does
//! every Df on it: entry by entry, Fbar lies in the interval hull of Df over the box. The hull is convex, which is all that is needed.
//!
//! Method: the plant, written once for every scalar, is evaluated with the scalar [`IntervalDual`], an interval with the interval of its derivative (forward mode,
//! one evaluation for each state), outward rounded throughout. Boxes where that has no finite result are bisected until they have, or until
//! a point is left that is named in the error; then the boxes that hold the extremes of an entry are bisected until samples of the Jacobian show that little is
//! left to gain. The union over the parts is an enclosure at every stage.
//!
//! # What is enclosed
//! The Jacobians of f and h in real arithmetic, with the constants that the plant stores. Where a right-hand side branches, all branches that the box leaves open are
//! taken. That f and h are continuous where they change branches is a hypothesis and not a result; see [`Branches`]. The difference of two branches is enclosed over every part
//! that leaves both open, in mean value form, so that what the branches have in common cancels. Parts are halved, the largest difference first: a difference that cannot vanish
//! leads to the error that names the point, and the largest that is left bounds every jump that was not found. About the library's elementary functions see [`luenberger_proof::interval`].
//!
//! Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, SIAM 2009, chapters 5, 6 and 11; A. Griewank and A. Walther, Evaluating Derivatives,
//! SIAM 2008, ch. 3.

mod branches;
mod linear;
pub(crate) mod paths;
mod region;
mod scalar;
mod subdivide;

use core::fmt;

use luenberger_plants::{Column, Dimensions, Plant};
use luenberger_proof::{Interval, Matrix, Ring};
use thiserror::Error;

use crate::names;
use luenberger_proof::wording::significant;

pub use branches::Branches;
pub use paths::Undefined;
pub use region::{Axis, Region};
pub use scalar::IntervalDual;

/// An enclosure of the Jacobians over a box.
#[derive(Debug, Clone, PartialEq)]
pub struct JacobianEnclosure {
    /// Df, n x n: entry (i, j) encloses the derivative of `f_i` by `x_j`.
    pub a: Matrix<Interval>,
    /// Dh, p x n.
    pub c: Matrix<Interval>,
    /// Of how many parts of the box it is the union.
    pub parts: usize,
    /// By how much it exceeds what samples of the Jacobians show to be needed: the largest excess of an entry at one end, relative to the
    /// size of that entry. Not a bound of the overestimation: samples need not hit the extremes.
    pub excess: f64,
    /// Where comparisons stay open, what is known of the jumps there. `None` where none does: then there is no such hypothesis.
    pub branches: Option<Branches>,
}

/// Why there is no enclosure.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum EnclosureError {
    /// Bounds that hold no number: NaN, or the lower above the upper, or both infinite of one sign.
    #[error("{axis} has the bounds [{lo}, {hi}], between which there is no number")]
    Bounds {
        /// Which coordinate.
        axis: Axis,
        /// Its lower bound.
        lo: f64,
        /// Its upper bound.
        hi: f64,
    },
    /// The box has another number of coordinates than the plant, or the plant another than it says.
    #[error("the plant says that it has {expected} {what}; the box, or what the plant itself works with, has {found}")]
    Dimension {
        /// Of what.
        what: &'static str,
        /// How many the plant says it has.
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
    #[error("{operation} in {side} is not defined, or jumps, at {place}")]
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
    /// The effort ended before every part of the box had a finite enclosure.
    #[error("after {parts} bisections, parts of the box have no finite enclosure, such as that at {place}")]
    Effort {
        /// How many parts were examined.
        parts: usize,
        /// A part that was left.
        place: Place,
    },
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

/// A point of the box, with a part of the box around it that the search ended in. Coordinates that make no difference are left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// The coordinates with their values: 0 where the part contains 0, else its middle; for an unbounded part its finite end.
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

/// An enclosure of Df (n x n) and Dh (p x n) over the box.
///
/// Cost: two evaluations of the plant for each state and each part of the box; the parts are at most twice the region's
/// [subdivisions](Region::subdivisions), and more only where that is needed for a finite result.
///
/// ```
/// use luenberger_design::{Region, enclosure::enclose};
/// use luenberger_plants::flexible_joint;
/// // The only nonlinearity is -3.33 sin x3, whose derivative is bounded everywhere.
/// let jacobians = enclose(&flexible_joint::classical(), &Region::everywhere(4))?;
/// let entry = jacobians.a[(3, 2)];
/// assert!(entry.contains(-19.5 - 3.33) && entry.contains(-19.5 + 3.33) && entry.width() < 6.660_000_1);
/// assert!(jacobians.a[(1, 0)].is_point() && jacobians.a[(1, 0)].contains(-48.6));
/// # Ok::<(), luenberger_design::enclosure::EnclosureError>(())
/// ```
/// # Errors
/// [`EnclosureError`] names the entry or the operation, and the point.
pub fn enclose<S: Plant<IntervalDual>>(plant: &S, region: &Region) -> Result<JacobianEnclosure, EnclosureError> {
    subdivide::enclose(&Evaluation { plant, size: plant.dimensions() }, region)
}

/// What the search needs of a plant: the Jacobians over one box.
struct Evaluation<'a, S> {
    plant: &'a S,
    size: Dimensions,
}

/// Df row by row, then Dh row by row, over one box; and what is known of jumps where the box left a branch open.
struct Jacobians {
    entries: Vec<Interval>,
    gap: Option<branches::Gap>,
}

/// Why one box has no result.
enum Failure {
    Undefined(Undefined, &'static str),
    Wrong(EnclosureError),
}

impl<S: Plant<IntervalDual>> Evaluation<'_, S> {
    /// The Jacobians over one box; entries may be unbounded.
    fn jacobians(&self, cell: &[Interval]) -> Result<Jacobians, Failure> {
        let (n, m, p) = (self.size.states, self.size.inputs, self.size.outputs);
        let constant = |x: &Interval| IntervalDual::new(*x, Interval::zero());
        let u: Vec<IntervalDual> = cell[n..n + m].iter().map(constant).collect();
        let u = column::<S::Input>("inputs", &u, m)?;
        let t = constant(&cell[n + m]);
        let mut entries = vec![Interval::zero(); (n + p) * n];
        let mut branched = false;
        for j in 0..n {
            let x: Vec<IntervalDual> = (0..n)
                .map(|i| IntervalDual::new(cell[i], if i == j { Interval::ONE } else { Interval::zero() }))
                .collect();
            let x = column::<S::State>("states", &x, n)?;
            let f = paths::explore(|| self.plant.derivative(t, &x, &u).as_slice().to_vec());
            let h = paths::explore(|| self.plant.output(t, &x).as_slice().to_vec());
            branched |= [&f, &h].iter().any(|ways| ways.as_ref().is_ok_and(|ways| ways.len() > 1));
            let slopes = united("f", n, f)?.into_iter().chain(united("h", p, h)?);
            for (i, slope) in slopes.enumerate() {
                entries[i * n + j] = slope;
            }
        }
        let gap = if branched { Some(self.gap(cell)?) } else { None };
        Ok(Jacobians { entries, gap })
    }
}

/// The column that a plant asks for.
fn column<C: Column<IntervalDual>>(
    what: &'static str,
    entries: &[IntervalDual],
    expected: usize,
) -> Result<C, Failure> {
    let found = C::fixed_len().unwrap_or(expected);
    C::try_from_slice(entries).ok_or(Failure::Wrong(EnclosureError::Dimension { what, expected, found }))
}

/// The slopes on all branches, as long as the values of no two branches are apart.
fn united(
    side: &'static str,
    expected: usize,
    ways: Result<Vec<Vec<IntervalDual>>, Undefined>,
) -> Result<Vec<Interval>, Failure> {
    let ways = ways.map_err(|undefined| Failure::Undefined(undefined, side))?;
    let what = if side == "f" { "rows of f" } else { "rows of h" };
    if let Some(found) = ways.iter().map(Vec::len).find(|len| *len != expected) {
        return Err(Failure::Wrong(EnclosureError::Dimension { what, expected, found }));
    }
    let mut union: Vec<IntervalDual> = Vec::new();
    for way in ways {
        if union.is_empty() {
            union = way;
            continue;
        }
        for (all, one) in union.iter_mut().zip(&way) {
            if all.value().intersection(&one.value()).is_none() {
                return Err(Failure::Undefined(Undefined::Operation("the choice between two branches"), side));
            }
            *all = IntervalDual::new(all.value().hull(&one.value()), all.slope().hull(&one.slope()));
        }
    }
    Ok(union.iter().map(IntervalDual::slope).collect())
}
