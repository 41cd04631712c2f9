//! Matrix commands: an equation from JSON, its solution as JSON or as aligned matrices.

pub(crate) mod bode;
pub(crate) mod conversion;
mod json_output;
pub(crate) mod lyapunov;
pub(crate) mod noise;
pub(crate) mod observability;
pub(crate) mod placement;
pub(crate) mod poles;
pub(crate) mod riccati;
pub(crate) mod spectrum;
pub(crate) mod sylvester;

use crate::failure::Failure;
use crate::input::given::Given;
use luenberger_linalg::LinalgError;

/// The error of the library, with the source of its matrices.
fn from(source: &Given) -> impl Fn(LinalgError) -> Failure {
    move |error| Failure::Matrix { origin: source.to_string(), error }
}
