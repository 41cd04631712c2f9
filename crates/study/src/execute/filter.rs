//! Filters where the truth is known: standard deviations, NIS and NEES, and how often errors are within their bands.

use luenberger_sim::{Estimates, SimError, Trajectory};
use nalgebra::DMatrix;

use super::rows::Run;
use super::stationary::Stationary;
use crate::results::{CoverageReport, FilterReport};
use crate::study::{Simulation, Study};
use crate::trajectory::Member;

/// Whether an observer is a filter with a covariance.
pub(super) fn is_filter(member: &Member<'_>) -> bool {
    member.designed.runnable.filter().is_some()
}

/// The standard deviations that a filter states for the errors of these estimates, at the times of the run:
/// `sqrt(P_ii)`.
pub(super) fn deviation(trajectory: &Trajectory, member: &Member<'_>, estimates: Estimates) -> Option<DMatrix<f64>> {
    let state = states(trajectory, member, estimates)?;
    let filter = member.designed.runnable.filter()?;
    Some(filter.deviation(&state, member.requested.initial.len()))
}

/// The probabilities of the models of a filter that has several, at the times of the run.
pub(super) fn modes(trajectory: &Trajectory, member: &Member<'_>, estimates: Estimates) -> Option<DMatrix<f64>> {
    member.designed.runnable.modes(&states(trajectory, member, estimates)?)
}

/// The states of an observer at the times of the run, those of these estimates.
fn states(trajectory: &Trajectory, member: &Member<'_>, estimates: Estimates) -> Option<DMatrix<f64>> {
    let own = trajectory.observer(&member.requested.name).ok()?;
    let mut state = own.state.clone();
    if let (Some(at_samples), Estimates::Filtered) = (&own.at_samples, estimates) {
        for (k, t) in trajectory.t.iter().enumerate() {
            if let Some(sample) = at_samples.at(*t).filter(|_| at_samples.state.ncols() == state.ncols()) {
                state.set_row(k, &at_samples.state.row(sample));
            }
        }
    }
    Some(state)
}

/// Those of a stationary Kalman filter, in every row.
pub(super) fn stationary_deviation(member: &Member<'_>, rows: usize) -> Option<DMatrix<f64>> {
    let deviation = member.designed.report.stationary_deviation.as_ref()?;
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
        CoverageReport::of(run_of, &study.plant, (&run.x, estimate), deviation, first)
    };
    runs.iter().filter_map(of).collect()
}

/// NIS and NEES of a filter over all its samples in the run, of a stationary one over those of the second half: of each
/// innovation as it was computed, and of the error after the measurement, or before it where predictions are scored.
pub(super) fn consistency(
    (study, simulation): (&Study, &Simulation),
    trajectory: &Trajectory,
    member: &Member<'_>,
) -> Result<Option<FilterReport>, SimError> {
    let name = member.requested.name.as_str();
    match member.designed.runnable.filter() {
        Some(filter) => filter.consistency((name, &study.plant), simulation, trajectory).map(Some),
        None => match Stationary::of(study, member) {
            Some(stationary) => stationary.of_simulation(simulation, trajectory),
            None => Ok(None),
        },
    }
}
