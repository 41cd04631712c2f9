//! Design of the mean-value-theorem observer, beyond what runs on the target.
//!
//! [`MeanValueDesign`] computes the gain of the output injection, with the error bound; [`ContractingCoordinates`]
//! computes coordinates in which the observer converges as printed, [`OutputCoordinates`] those in which any linear
//! output is the first states; [`LeastSquares`] is the paper's computation of beta. The observer itself and the other
//! computations are in [`luenberger_observers::mean_value`]; its properties are in `docs/theory-mvt.md`.

mod contracting;
mod gain;
mod least_squares;
mod output_coordinates;

pub use contracting::{ContractingCoordinates, PrintedInCoordinates};
pub use gain::MeanValueDesign;
pub use least_squares::{LeastSquares, LeastSquaresMean};
pub use output_coordinates::OutputCoordinates;
