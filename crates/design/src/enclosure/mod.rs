//! Enclosures of the Jacobians of a plant over a box: they contain every mean value of Df and Dh.
//!
//! For f and h locally Lipschitz, `f(x) - f(xhat) = Fbar (x - xhat)` with `Fbar = int_0^1 Df(xhat + s (x - xhat)) ds`,
//! and where the segment stays in the box so does every Df on it: entry by entry, Fbar lies in the interval hull of Df
//! over the box. The hull is convex, which is all that is needed.
//!
//! Method: the plant, generic over the scalar, is evaluated with [`IntervalDual`], an interval with the interval of its
//! derivative (forward mode, one evaluation for each state), with outward rounding. Boxes without a finite result are
//! bisected until they have one, or until a point remains that is named in the error; then the boxes that contain the
//! extremes of an entry are bisected until samples of the Jacobian show that further bisection gains little. The union
//! over the parts is an enclosure at every stage.
//!
//! # What is enclosed
//! The Jacobians of f and h in real arithmetic, with the constants stored in the plant. Where a right-hand side
//! branches, all branches possible on the box are evaluated. Continuity of f and h where they change branches is a
//! hypothesis and not a result; see [`Branches`]. The difference of two branches is enclosed over every part on which
//! both are possible, in mean value form, so that common terms cancel. Parts are halved, the largest difference first:
//! a difference that cannot vanish leads to an error that names the point, and the largest remaining one bounds every
//! undetected jump. For the library's elementary functions see [`luenberger_proof::interval`].
//!
//! Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, SIAM 2009, chapters 5, 6 and
//! 11; A. Griewank and A. Walther, Evaluating Derivatives, SIAM 2008, ch. 3.

mod branches;
mod error;
mod evaluation;
mod linear;
pub(crate) mod paths;
mod place;
mod region;
mod scalar;
mod subdivide;

pub use branches::Branches;
pub use error::EnclosureError;
pub use paths::Undefined;
pub use place::{Axis, Entry, Place};
pub use region::Region;
pub use scalar::IntervalDual;
pub use subdivide::{JacobianEnclosure, enclose, output_bounds};
