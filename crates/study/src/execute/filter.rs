//! Filters where the truth is known: standard deviations, NIS and NEES, and how often errors are within their bands.

use luenberger_observers::CovarianceFilter;
use luenberger_plants::Column;
use luenberger_sim::replay::{Consistency, NormalisedSquare};
use luenberger_sim::{Estimates, SimError, Trajectory};
use nalgebra::{DMatrix, DVector};

use super::rows::Run;
use crate::results::{CoverageReport, FilterReport};
use crate::study::{Simulation, Study};
use crate::trajectory::Member;

/// A filter with a covariance, of any kind.
pub trait Filter {
    /// The standard deviations that it states for the errors of its n states, from its states (a row for each time).
    fn deviation(&self, states: &DMatrix<f64>, n: usize) -> DMatrix<f64>;

    /// NIS and NEES over all its samples in a run.
    ///
    /// # Errors
    /// [`SimError`] if the run does not have what they need.
    fn consistency(
        &self,
        of: (&str, usize),
        simulation: &Simulation,
        trajectory: &Trajectory,
    ) -> Result<FilterReport, SimError>;
}

impl<F> Filter for F
where
    F: CovarianceFilter<f64, Input = DVector<f64>, Output = DVector<f64>, Estimate = DVector<f64>>,
    F::State: Clone,
{
    fn deviation(&self, states: &DMatrix<f64>, n: usize) -> DMatrix<f64> {
        deviation_of(self, states, n)
    }

    fn consistency(
        &self,
        of: (&str, usize),
        simulation: &Simulation,
        trajectory: &Trajectory,
    ) -> Result<FilterReport, SimError> {
        consistency_of(self, of, simulation, trajectory)
    }
}

/// Whether an observer is a filter with a covariance.
pub(super) fn is_filter(member: &Member<'_>) -> bool {
    member.designed.runnable.filter().is_some()
}

/// The standard deviations that a filter states for the errors of these estimates, at the times of the run:
/// `sqrt(P_ii)`.
pub(super) fn deviation(trajectory: &Trajectory, member: &Member<'_>, estimates: Estimates) -> Option<DMatrix<f64>> {
    let own = trajectory.observer(&member.requested.name).ok()?;
    let mut state = own.state.clone();
    if let (Some(at_samples), Estimates::Filtered) = (&own.at_samples, estimates) {
        for (k, t) in trajectory.t.iter().enumerate() {
            if let Some(sample) = at_samples.at(*t).filter(|_| at_samples.state.ncols() == state.ncols()) {
                state.set_row(k, &at_samples.state.row(sample));
            }
        }
    }
    let filter = member.designed.runnable.filter()?;
    Some(filter.deviation(&state, member.requested.initial.len()))
}

/// Those of a stationary Kalman filter, in every row.
pub(super) fn stationary_deviation(member: &Member<'_>, rows: usize) -> Option<DMatrix<f64>> {
    let deviation = member.designed.report.stationary_deviation()?;
    Some(DMatrix::from_fn(rows, deviation.len(), |_, i| deviation[i]))
}

/// How often the errors of each filter were within two standard deviations: over all rows of a simulation, over the
/// second half of a log.
pub(super) fn coverage(study: &Study, runs: &[(&Member<'_>, &Run)], on_log: bool) -> Vec<CoverageReport> {
    let of = |(member, run): &(&Member<'_>, &Run)| {
        let (estimate, deviation) = (run.estimate.as_ref()?, run.deviation.as_ref()?);
        let middle = match &study.log {
            Some(log) if on_log => log.recording.times()[log.recording.times().len() / 2],
            _ => f64::NEG_INFINITY,
        };
        let first = run.t.iter().position(|t| *t >= middle)?;
        let run_of = (member.requested.name.as_str(), on_log, !is_filter(member));
        CoverageReport::of(run_of, &study.plant.states, (&run.x, estimate), deviation, first)
    };
    runs.iter().filter_map(of).collect()
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

/// NIS and NEES of a filter over all its samples in the run: of each innovation as it was computed, and of the error
/// after the measurement, or before it where predictions are scored.
pub(super) fn consistency(
    simulation: &Simulation,
    trajectory: &Trajectory,
    member: &Member<'_>,
) -> Result<Option<FilterReport>, SimError> {
    let (name, n) = (&member.requested.name, member.requested.initial.len());
    let filter = member.designed.runnable.filter();
    filter.map(|filter| filter.consistency((name, n), simulation, trajectory)).transpose()
}

fn consistency_of<F: CovarianceFilter<f64, Input = DVector<f64>, Output = DVector<f64>, Estimate = DVector<f64>>>(
    filter: &F,
    (name, n): (&str, usize),
    simulation: &Simulation,
    trajectory: &Trajectory,
) -> Result<FilterReport, SimError> {
    let period = filter.period();
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
        let (x, xhat) = (DVector::from_column_slice(&x), filter.estimate(scored));
        let mut p = DMatrix::zeros(n, n);
        let square = filter.covariance_into(scored, p.as_mut_slice());
        nees.push(square.then(|| NormalisedSquare::of_error(&(x - &xhat), &p, &xhat)).flatten());
    }
    let test = |squares: Vec<Option<NormalisedSquare>>| Consistency::of(squares).map(Into::into);
    Ok(FilterReport { observer: name.to_owned(), nis: test(nis), nees: test(nees) })
}
