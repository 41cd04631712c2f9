//! A filter with a covariance, of any kind: the bands that it states, and how consistent they are with the errors.

use luenberger_observers::{CovarianceFilter, tangential};
use luenberger_plants::Column;
use luenberger_sim::replay::{Consistency, NormalisedSquare};
use luenberger_sim::{Estimates, SimError, Trajectory};
use nalgebra::{DMatrix, DVector};

use crate::model::PlantModel;
use crate::results::FilterReport;
use crate::study::Simulation;

/// A filter with a covariance, of any kind.
pub trait Filter {
    /// The standard deviations that it states for the errors of its n states, from its states (a row for each time).
    fn deviation(&self, states: &DMatrix<f64>, n: usize) -> DMatrix<f64>;

    /// The covariance of the error of its n states; none of a state of another length.
    fn covariance(&self, state: &[f64], n: usize) -> Option<DMatrix<f64>>;

    /// The innovation of y at time t in the state before it, with the outputs that are finite; none where the update
    /// has no result.
    fn innovation(&self, t: f64, state: &[f64], u: &[f64], y: &[f64]) -> Option<Innovation>;

    /// NIS and NEES over all its samples in a run.
    ///
    /// # Errors
    /// [`SimError`] if the run does not have what they need.
    fn consistency(
        &self,
        of: (&str, &PlantModel),
        simulation: &Simulation,
        trajectory: &Trajectory,
    ) -> Result<FilterReport, SimError>;
}

/// What an update has of its innovation.
#[derive(Debug, Clone, PartialEq)]
pub struct Innovation {
    /// y less the output that the update expects; 0 for an output that was not measured.
    pub value: DVector<f64>,
    /// `y~' S^-1 y~` of the outputs that were measured.
    pub square: f64,
    /// `ln det S`, of an update with an S.
    pub log_determinant: Option<f64>,
    /// How many outputs were measured.
    pub used: usize,
}

impl<F> Filter for F
where
    F: CovarianceFilter<f64, Input = DVector<f64>, Output = DVector<f64>, Estimate = DVector<f64>>,
    F::State: Clone,
{
    fn deviation(&self, states: &DMatrix<f64>, n: usize) -> DMatrix<f64> {
        deviation_of(self, states, n)
    }

    fn covariance(&self, state: &[f64], n: usize) -> Option<DMatrix<f64>> {
        let mut p = vec![0.0; n * n];
        let state = F::State::try_from_slice(state)?;
        self.covariance_into(&state, &mut p).then(|| DMatrix::from_column_slice(n, n, &p))
    }

    fn innovation(&self, t: f64, state: &[f64], u: &[f64], y: &[f64]) -> Option<Innovation> {
        let mut state = F::State::try_from_slice(state)?;
        let (u, y) = (DVector::from_column_slice(u), DVector::from_column_slice(y));
        let measured: Vec<bool> = y.iter().map(|y| y.is_finite()).collect();
        let of = CovarianceFilter::innovation(self, t, &state, &u, &y);
        let value = DVector::from_fn(y.len(), |i, _| if measured[i] { of[i] } else { 0.0 });
        let used = measured.iter().filter(|is| **is).count();
        let (square, log_determinant) = self.measure_with_determinant(t, &mut state, &u, &y, &measured)?;
        Some(Innovation { value, square, log_determinant, used })
    }

    fn consistency(
        &self,
        of: (&str, &PlantModel),
        simulation: &Simulation,
        trajectory: &Trajectory,
    ) -> Result<FilterReport, SimError> {
        consistency_of(self, of, simulation, trajectory)
    }
}

fn deviation_of<F: CovarianceFilter<f64>>(filter: &F, states: &DMatrix<f64>, n: usize) -> DMatrix<f64> {
    let mut deviation = DMatrix::from_element(states.nrows(), n, f64::NAN);
    let mut p = vec![0.0; n * n];
    for k in 0..states.nrows() {
        let row: Vec<f64> = states.row(k).iter().copied().collect();
        if F::State::try_from_slice(&row).is_some_and(|state| filter.covariance_into(&state, &mut p)) {
            (0..n).for_each(|i| deviation[(k, i)] = p[i * n + i].max(0.0).sqrt());
        }
    }
    deviation
}

fn consistency_of<F: CovarianceFilter<f64, Input = DVector<f64>, Output = DVector<f64>, Estimate = DVector<f64>>>(
    filter: &F,
    (name, plant): (&str, &PlantModel),
    simulation: &Simulation,
    trajectory: &Trajectory,
) -> Result<FilterReport, SimError> {
    let (period, n) = (filter.period(), plant.states.len());
    let (mut nis, mut nees) = (Vec::new(), Vec::new());
    let samples = (simulation.duration / period - 1e-9).ceil() as u64;
    for sample in 0..samples {
        let t = sample as f64 * period;
        let x = trajectory.state_at(t)?;
        // The state before the sample is held from the sample to the next one.
        let held = trajectory.observer_state_at(name, f64::midpoint(t, (t + period).min(simulation.duration)))?;
        let Some(mut filter_state) = F::State::try_from_slice(&held) else { continue };
        // A held input has its value from the sample on.
        let at = simulation.hold.map_or(t, |hold| (t + 0.5 * hold.min(period)).min(simulation.duration));
        let u = DVector::from_vec(trajectory.input_at(at)?);
        let y = DVector::from_vec(trajectory.measured_at(t)?);
        let measured: Vec<bool> = (0..y.len()).map(|output| trajectory.is_measured(output, t)).collect();
        let before = filter_state.clone();
        let degrees =
            (0..y.len()).filter(|&j| measured[j] && !filter.rejects_output(t, &filter_state, &u, &y, j)).count();
        if degrees > 0 {
            let square = filter.measure(t, &mut filter_state, &u, &y, &measured);
            nis.push(square.map(|square| NormalisedSquare::of_innovation(square, degrees)));
        }
        let scored = if simulation.estimates == Estimates::Predicted { &before } else { &filter_state };
        let xhat = filter.estimate(scored);
        let mut error = DVector::from_fn(n, |i, _| plant.error(i, x[i], xhat[i]));
        tangential(error.as_mut_slice(), xhat.as_slice(), |i| filter.unit_vector_of(i));
        let mut p = DMatrix::zeros(n, n);
        let square = filter.covariance_into(scored, p.as_mut_slice());
        nees.push(square.then(|| NormalisedSquare::of_error(&error, &p, &xhat)).flatten());
    }
    let test = |squares: Vec<Option<NormalisedSquare>>| Consistency::of(squares).map(Into::into);
    Ok(FilterReport { observer: name.to_owned(), nis: test(nis), nees: test(nees), stationary: false })
}
