//! NIS and NEES of stationary Kalman filters of plants in discrete time, over the second half of a run.
//!
//! With the stationary covariance P of the prediction error, the solution of the Riccati equation, an innovation has
//! the covariance `S = C P C' + V`, and the error of the estimate P, or `(I - K C) P` after the measurement. A filter
//! has them after its transient, and as long as every output is measured at every sample: samples at which one is
//! missing have no square, and what a missing one leaves in those after it is not in P.

use luenberger_sim::replay::{Consistency, NormalisedSquare, ReplayedObserver};
use luenberger_sim::{Estimates, SimError, Trajectory};
use nalgebra::{DMatrix, DVector};

use crate::designed::{Origin, SampledDesign};
use crate::results::{ConsistencyReport, FilterReport};
use crate::study::{GainSpec, Log, Simulation, Study};
use crate::trajectory::Member;

/// A stationary filter with its covariances.
pub(super) struct Stationary<'a> {
    study: &'a Study,
    name: &'a str,
    /// The inverse of S.
    information: DMatrix<f64>,
    predicted: DMatrix<f64>,
    /// Of an estimate after its measurement, and the gain K of that; none of a predictor.
    filtered: Option<(DMatrix<f64>, DMatrix<f64>)>,
}

impl<'a> Stationary<'a> {
    /// None of an observer that is no such filter.
    pub(super) fn of(study: &'a Study, member: &Member<'a>) -> Option<Self> {
        let spec = member.requested.kind.whole_gain()?;
        let GainSpec::Kalman(noise) = &spec.gain else { return None };
        let Origin::Sampled(SampledDesign::Linear(design)) = &member.designed.origin else { return None };
        let (plant, predicted) = (study.plant.model.linear()?, design.covariance()?.clone());
        let s = &plant.c * &predicted * plant.c.transpose() + &noise.v;
        let filtered =
            if spec.is_filter { design.filter_covariance().zip(design.update_gain().cloned()) } else { None };
        let information = s.cholesky()?.inverse();
        Some(Self { study, name: &member.requested.name, information, predicted, filtered })
    }

    fn nis(&self, innovation: &DVector<f64>) -> NormalisedSquare {
        NormalisedSquare::of_innovation(innovation.dot(&(&self.information * innovation)), innovation.len())
    }

    fn report(&self, nis: Vec<Option<NormalisedSquare>>, nees: Vec<Option<NormalisedSquare>>) -> Option<FilterReport> {
        let test = |squares: Vec<Option<NormalisedSquare>>| Consistency::of(squares).map(ConsistencyReport::from);
        let (nis, nees) = (test(nis), test(nees));
        let is_any = nis.is_some() || nees.is_some();
        is_any.then(|| FilterReport { observer: self.name.to_owned(), nis, nees, stationary: true })
    }

    /// Of its samples in a simulation.
    pub(super) fn of_simulation(
        &self,
        simulation: &Simulation,
        trajectory: &Trajectory,
    ) -> Result<Option<FilterReport>, SimError> {
        let plant = &self.study.plant;
        let (Some(model), Some(period)) = (plant.model.linear(), plant.dt) else { return Ok(None) };
        let samples = (simulation.duration / period - 1e-9).ceil() as u64;
        let (mut nis, mut nees) = (Vec::new(), Vec::new());
        for sample in samples / 2..samples {
            let t = sample as f64 * period;
            let middle = f64::midpoint(t, (t + period).min(simulation.duration));
            // The prediction for a sample is held from it to the next one, and so is the input.
            let prediction = DVector::from_vec(trajectory.observer_state_at(self.name, middle)?);
            let y = DVector::from_vec(trajectory.measured_at(t)?);
            let is_complete = (0..y.len()).all(|output| trajectory.is_measured(output, t));
            if !is_complete || prediction.len() != plant.states.len() {
                continue;
            }
            let mut innovation = y - &model.c * &prediction;
            if let Some(d) = &model.d {
                innovation -= d * DVector::from_vec(trajectory.input_at(middle)?);
            }
            nis.push(Some(self.nis(&innovation)));
            let (xhat, p) = match &self.filtered {
                Some((p, k)) if simulation.estimates == Estimates::Filtered => (prediction + k * innovation, p),
                _ => (prediction, &self.predicted),
            };
            let x = trajectory.state_at(t)?;
            let error = DVector::from_fn(xhat.len(), |i, _| plant.error(i, x[i], xhat[i]));
            nees.push(NormalisedSquare::of_error(&error, p, &xhat));
        }
        Ok(self.report(nis, nees))
    }

    /// Of the rows of a log from a time on.
    pub(super) fn of_log(
        &self,
        log: &Log,
        replayed: &ReplayedObserver,
        from: f64,
    ) -> Result<Option<FilterReport>, SimError> {
        let rows = || (0..replayed.t.len()).filter(|&k| replayed.t[k] >= from);
        let whole = |values: &DMatrix<Option<f64>>, k: usize| {
            let row: Option<Vec<f64>> = values.row(k).iter().copied().collect();
            row.map(DVector::from_vec)
        };
        let innovations = replayed.innovation.iter().flat_map(|all| rows().filter_map(|k| whole(all, k)));
        let nis = innovations.map(|innovation| Some(self.nis(&innovation))).collect();
        let mut nees = Vec::new();
        if let Some(truth) = &log.truth {
            let errors = replayed.errors(truth)?;
            let p = match &self.filtered {
                Some((p, _)) if log.estimates == Estimates::Filtered => p,
                _ => &self.predicted,
            };
            // After a measurement of every output.
            let is_complete = |k: &usize| replayed.innovation.as_ref().is_some_and(|all| whole(all, *k).is_some());
            for k in rows().filter(is_complete) {
                if let Some(error) = whole(&errors, k) {
                    nees.push(NormalisedSquare::of_error(&error, p, &replayed.estimate.row(k).transpose()));
                }
            }
        }
        Ok(self.report(nis, nees))
    }
}
