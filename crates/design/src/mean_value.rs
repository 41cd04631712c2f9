//! The mean-value-theorem observer: what its design needs beyond what runs on the target.
//!
//! [`RepairedDesign`] finds the gain of the repaired observer, with the envelope of its error; [`LeastSquares`] is the paper's own way to beta. The
//! observer itself and the other means are in [`luenberger_observers::mean_value`]; what is true of it stands in `docs/theory-mvt.md`.

mod least_squares;
mod repaired;

pub use least_squares::{LeastSquares, LeastSquaresMean};
pub use repaired::RepairedDesign;
