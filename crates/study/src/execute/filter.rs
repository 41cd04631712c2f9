//! Filters in the simulation, where the truth is known: standard deviations, NIS and NEES.

use luenberger_observers::kalman::GaussianEstimate;
use luenberger_observers::{ExtendedKalmanFilter, SampledObserver};
use luenberger_plants::Column;
use luenberger_sim::replay::{Consistency, NormalisedSquare};
use luenberger_sim::{SimError, Trajectory};
use nalgebra::{DMatrix, DVector, Dyn};

use super::Member;
use crate::design::Runnable;
use crate::model::Model;
use crate::results::FilterReport;
use crate::study::Simulation;

type Filter = ExtendedKalmanFilter<Model, f64, Dyn, Dyn, Dyn>;

fn filter<'a>(member: &Member<'a>) -> Option<&'a Filter> {
    match &member.designed.runnable {
        Runnable::ExtendedKalman(filter) => Some(filter),
        _ => None,
    }
}

/// Whether an observer is a filter with a covariance.
pub(super) fn is_filter(member: &Member<'_>) -> bool {
    filter(member).is_some()
}

/// The standard deviations that a filter states for its errors, at the times of the run: `sqrt(P_ii)`.
pub(super) fn deviation(trajectory: &Trajectory, member: &Member<'_>) -> Option<DMatrix<f64>> {
    filter(member)?;
    let state = &trajectory.observer(&member.wish.name).ok()?.state;
    let n = member.wish.initial.len();
    Some(DMatrix::from_fn(state.nrows(), n, |k, i| state[(k, n + i * n + i)].max(0.0).sqrt()))
}

/// NIS and NEES of a filter over all its samples in the run: of each innovation as it was computed, and of the error
/// after the measurement.
pub(super) fn consistency(
    simulation: &Simulation,
    trajectory: &Trajectory,
    member: &Member<'_>,
) -> Result<Option<FilterReport>, SimError> {
    let Some(filter) = filter(member) else { return Ok(None) };
    let (n, name, period) = (member.wish.initial.len(), &member.wish.name, filter.period());
    let (mut nis, mut nees) = (Vec::new(), Vec::new());
    let samples = (simulation.duration / period - 1e-9).ceil() as u64;
    for sample in 0..samples {
        let t = sample as f64 * period;
        let x = trajectory.state_at(t)?;
        // The belief before the sample stands from the sample to the next one.
        let held = trajectory.observer_state_at(name, f64::midpoint(t, (t + period).min(simulation.duration)))?;
        let Some(mut belief) = GaussianEstimate::try_from_slice(&held) else { continue };
        // A held input is the one that stands from the sample on.
        let at = simulation.hold.map_or(t, |hold| (t + 0.5 * hold.min(period)).min(simulation.duration));
        let u = DVector::from_vec(trajectory.input_at(at)?);
        let y = DVector::from_vec(trajectory.measured_at(t)?);
        let measured: Vec<bool> = (0..y.len()).map(|output| trajectory.is_measured(output, t)).collect();
        let degrees = (0..y.len()).filter(|&j| measured[j] && !filter.rejects(t, &belief, &u, &y, j)).count();
        if degrees > 0 {
            let Some(innovation) = filter.update_partial(t, &mut belief, &u, &y, |output| measured[output]) else {
                continue;
            };
            nis.push(NormalisedSquare { square: innovation.normalized_square, degrees });
        }
        let e = DVector::from_column_slice(&x) - belief.estimate();
        if let Some(factor) = belief.covariance().cholesky() {
            nees.push(NormalisedSquare { square: e.dot(&factor.solve(&e)), degrees: n });
        }
    }
    let test = |squares: Vec<NormalisedSquare>| Consistency::of(squares).map(Into::into);
    Ok(Some(FilterReport { observer: name.clone(), nis: test(nis), nees: test(nees) }))
}
