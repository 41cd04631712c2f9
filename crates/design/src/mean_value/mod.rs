//! The mean-value-theorem observer: what its design needs beyond what runs on the target.
//!
//! [`MeanValueDesign`] finds the gain of the repaired observer, with the envelope of its error;
//! [`ContractingCoordinates`] finds coordinates in which the observer converges as printed, [`OutputCoordinates`] those
//! in which any linear output is the first states; [`LeastSquares`] is the paper's own way to beta. The observer itself
//! and the other means are in [`luenberger_observers::mean_value`]; what is true of it stands in `docs/theory-mvt.md`.

mod contracting;
mod gain;
mod least_squares;
mod output_coordinates;

pub use contracting::{ContractingCoordinates, PrintedInCoordinates};
pub use gain::MeanValueDesign;
pub use least_squares::{LeastSquares, LeastSquaresMean};
pub use output_coordinates::OutputCoordinates;
