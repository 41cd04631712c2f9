//! Kalman filters without their sizes: measurement update and prediction apart, and the covariance in between.

use luenberger_observers::{CovarianceFilter, ObserverDimensions};
use luenberger_plants::Column;

use super::innovation::NormalisedSquare;
use super::smoother::Record;
use crate::erased::sized;
use crate::error::SimError;

/// A filter of any size. Its state is a slice as that of any observer.
pub(super) trait AnyFilter {
    fn dimensions(&self) -> ObserverDimensions;
    fn check(&self) -> Result<(), SimError>;
    /// The period at which it has to be predicted, of a filter in discrete time.
    fn grid(&self) -> Option<f64>;
    fn initial(&self, t: f64, estimate: &[f64], u: &[f64], y: &[f64], state: &mut [f64]);
    fn estimate(&self, state: &[f64]) -> Vec<f64>;
    /// The number of the unit vector that a state belongs to; 0 for none.
    fn unit_vector_of(&self, state: usize) -> usize;
    /// The covariance of the error, by columns.
    fn covariance(&self, state: &[f64]) -> Vec<f64>;
    /// Whether the gate of the filter rejects an output that was measured.
    fn rejects(&self, t: f64, state: &[f64], u: &[f64], y: &[f64], output: usize) -> bool;
    /// The innovation of y as the update has it, of every output.
    fn innovation(&self, t: f64, state: &[f64], u: &[f64], y: &[f64]) -> Vec<f64>;
    /// The update by the outputs that were measured under the input u; none if the innovation covariance is not
    /// positive definite.
    fn update(&self, t: f64, state: &mut [f64], u: &[f64], y: &[f64], measured: &[bool]) -> Option<Updated>;
    /// How many steps take it over a duration.
    fn pieces(&self, duration: f64) -> f64;
    /// The prediction; NaN where it has no result. With `record`, its steps are recorded.
    fn predict(&self, t: f64, state: &mut [f64], u: &[f64], duration: f64, record: Option<&mut Record>);
}

/// What an update has of its innovation.
#[derive(Clone, Copy)]
pub(super) struct Updated {
    pub(super) square: NormalisedSquare,
    /// `ln det S`, of an update with an S.
    pub(super) log_determinant: Option<f64>,
}

impl Updated {
    /// The log-likelihood of the measurement, given those before it.
    pub(super) fn log_likelihood(&self) -> Option<f64> {
        let constant = self.square.entries as f64 * std::f64::consts::TAU.ln();
        self.log_determinant.map(|determinant| -0.5 * (constant + determinant + self.square.square))
    }
}

/// A filter, with its sizes erased.
pub(super) struct Any<F>(pub(super) F);

impl<F: CovarianceFilter<f64>> AnyFilter for Any<F> {
    fn unit_vector_of(&self, state: usize) -> usize {
        self.0.unit_vector_of(state)
    }

    fn dimensions(&self) -> ObserverDimensions {
        self.0.dimensions()
    }

    fn check(&self) -> Result<(), SimError> {
        sized::<F::State, F::Input, F::Output, F::Estimate>(self.0.dimensions())
    }

    fn grid(&self) -> Option<f64> {
        self.0.is_discrete().then(|| self.0.period())
    }

    fn initial(&self, t: f64, estimate: &[f64], u: &[f64], y: &[f64], state: &mut [f64]) {
        let columns = (Column::try_from_slice(estimate), Column::try_from_slice(u), Column::try_from_slice(y));
        if let (Some(estimate), Some(u), Some(y)) = columns {
            state.copy_from_slice(self.0.initial(t, &estimate, &u, &y).as_slice());
        }
    }

    fn estimate(&self, state: &[f64]) -> Vec<f64> {
        F::State::try_from_slice(state).map_or_else(Vec::new, |state| self.0.estimate(&state).as_slice().to_vec())
    }

    fn covariance(&self, state: &[f64]) -> Vec<f64> {
        let n = self.0.dimensions().estimate;
        let mut p = vec![f64::NAN; n * n];
        if let Some(state) = F::State::try_from_slice(state) {
            self.0.covariance_into(&state, &mut p);
        }
        p
    }

    fn rejects(&self, t: f64, state: &[f64], u: &[f64], y: &[f64], output: usize) -> bool {
        let columns = (F::State::try_from_slice(state), Column::try_from_slice(u), Column::try_from_slice(y));
        let (Some(state), Some(u), Some(y)) = columns else { return false };
        self.0.rejects_output(t, &state, &u, &y, output)
    }

    fn innovation(&self, t: f64, state: &[f64], u: &[f64], y: &[f64]) -> Vec<f64> {
        let columns = (F::State::try_from_slice(state), Column::try_from_slice(u), Column::try_from_slice(y));
        let (Some(state), Some(u), Some(measurement)) = columns else { return vec![f64::NAN; y.len()] };
        self.0.innovation(t, &state, &u, &measurement).as_slice().to_vec()
    }

    fn update(&self, t: f64, state: &mut [f64], u: &[f64], y: &[f64], measured: &[bool]) -> Option<Updated> {
        let mut filter_state = F::State::try_from_slice(state)?;
        let (u, y) = (Column::try_from_slice(u)?, Column::try_from_slice(y)?);
        let (square, log_determinant) = self.0.measure_with_determinant(t, &mut filter_state, &u, &y, measured)?;
        state.copy_from_slice(filter_state.as_slice());
        let square = NormalisedSquare::of_innovation(square, measured.iter().filter(|measured| **measured).count());
        Some(Updated { square, log_determinant })
    }

    fn pieces(&self, duration: f64) -> f64 {
        if self.0.is_discrete() { 1.0 } else { (duration / self.0.period() - 1e-9).ceil().max(1.0) }
    }

    fn predict(&self, t: f64, state: &mut [f64], u: &[f64], duration: f64, record: Option<&mut Record>) {
        let pieces = self.pieces(duration);
        let (Some(mut filter_state), Some(u)) = (F::State::try_from_slice(state), Column::try_from_slice(u)) else {
            return;
        };
        let tau = duration / pieces;
        let mut record = record;
        for k in 0..pieces as u64 {
            let now = t + tau * k as f64;
            let is_right = match &mut record {
                None => self.0.advance(now, &mut filter_state, &u, tau),
                Some(record) => {
                    let n = self.0.dimensions().estimate;
                    let mut cross = vec![f64::NAN; n * n];
                    record.add(self.0.estimate(&filter_state).as_slice());
                    record.add(&self.covariance(filter_state.as_slice()));
                    let is_right = self.0.advance_across(now, &mut filter_state, &u, tau, &mut cross);
                    record.add(self.0.estimate(&filter_state).as_slice());
                    record.add(&self.covariance(filter_state.as_slice()));
                    record.add(&cross);
                    is_right
                }
            };
            if !is_right {
                state.fill(f64::NAN);
                return;
            }
        }
        state.copy_from_slice(filter_state.as_slice());
    }
}
