//! How often the errors of a filter were within the band that its covariance gives.

use nalgebra::DMatrix;
use serde::Serialize;

use crate::model::PlantModel;

/// A filter and the share of its errors within two standard deviations.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CoverageReport {
    /// The observer.
    pub observer: String,
    /// Whether its run is that on the log; there the second half is counted, as for NIS and NEES.
    pub on_log: bool,
    /// Whether its band is that of the stationary covariance, which does not include the initial error.
    pub stationary: bool,
    /// One for each state whose true value is known.
    pub states: Vec<StateCoverage>,
}

/// The share of the errors of one state within two standard deviations.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StateCoverage {
    /// The state.
    pub state: String,
    /// From 0 to 1; 0.954 for Gaussian errors of this standard deviation.
    pub within: f64,
    /// Over how many rows of the run.
    pub samples: usize,
}

impl CoverageReport {
    /// The probability that a Gaussian error is within two standard deviations: `erf(sqrt(2))`.
    pub const EXPECTED: f64 = 0.954_499_736_103_641_6;

    /// Over the rows of a run from the row `first` on, with NaN where the state is not known; none if it never is.
    pub(crate) fn of(
        (observer, on_log, stationary): (&str, bool, bool),
        plant: &PlantModel,
        (x, xhat): (&DMatrix<f64>, &DMatrix<f64>),
        deviation: &DMatrix<f64>,
        first: usize,
    ) -> Option<Self> {
        let of = |(i, state): (usize, &String)| {
            let error = |k: usize| plant.error(i, x[(k, i)], xhat[(k, i)]).abs() / deviation[(k, i)];
            let ratios: Vec<f64> = (first..x.nrows()).map(error).filter(|ratio| !ratio.is_nan()).collect();
            let within = ratios.iter().filter(|ratio| **ratio <= 2.0).count();
            let samples = ratios.len();
            (samples > 0).then(|| StateCoverage {
                state: state.clone(),
                within: within as f64 / samples as f64,
                samples,
            })
        };
        let states: Vec<StateCoverage> = plant.states.iter().take(x.ncols()).enumerate().filter_map(of).collect();
        (!states.is_empty()).then(|| Self { observer: observer.to_owned(), on_log, stationary, states })
    }
}
