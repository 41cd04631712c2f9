//! The mean-value-theorem observer: what its design needs beyond what runs on the target.
//!
//! [`RepairedDesign`] finds the gain of the repaired observer, with the envelope of its error; [`ContractingCoordinates`] finds
//! coordinates in which the observer converges as printed, [`MeasuredFirst`] those in which any linear output is the first states; [`LeastSquares`] is the paper's own way to beta. The
//! observer itself and the other means are in [`luenberger_observers::mean_value`]; what is true of it stands in `docs/theory-mvt.md`.

mod contracting;
mod least_squares;
mod measured_first;
mod repaired;

pub use contracting::{ContractingCoordinates, PrintedInCoordinates};
pub use least_squares::{LeastSquares, LeastSquaresMean};
pub use measured_first::MeasuredFirst;
pub use repaired::RepairedDesign;
