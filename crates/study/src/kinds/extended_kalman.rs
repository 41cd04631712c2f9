//! The extended Kalman filter, and what it shares with its variants: the kinds `extended-kalman`,
//! `iterated-extended-kalman` and `error-state-kalman`.

use std::sync::Arc;

use luenberger_export::ExportableObserver;
use luenberger_expression::ExpressionPlant;
use luenberger_live as live;
use luenberger_observers::{ExtendedKalmanFilter, NoiseModel, ObserverError, Prediction, SampledObserver};
use luenberger_plants::Differentiable;
use luenberger_proof::wording::counted;
use nalgebra::{DMatrix, DVector, Dyn};

use super::declaration::{Declaration, Information, Rule, Tuning};
use super::filter::{
    BOUNDED, CORRELATED, CROSS_COVARIANCE, Filter, STAGES, STATE_BOUNDS, bounds_no_angle, bounds_with,
    cross_covariance, cross_with, late, matrices, state_bounds, wrapped,
};
use super::keys::{GATE, SMOOTH};
use super::{Kind, as_kind, error_state_kalman, iterated_extended_kalman};
use crate::designed::{
    NonlinearStep, RowVariances, Runnable, Running, StepOf, adapted, correlated, decorrelated, rows, runs_as_filter,
    with_variances,
};
use crate::model::{Model, PlantModel};
use crate::results::{DesignReport, NoObserver, Quantity, Statement};
use crate::steps::filter_step;
use crate::study::{Estimated, ObserverKind, PlantClass, Specification, Study, Time};
use crate::synthesis::{Designed, Plan, number, without_certificate};
use crate::tuning;

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "extended-kalman",
    about: "Extended Kalman filter for a plant in continuous time with sampled measurements.",
    source: "Gelb, Applied Optimal Estimation, 1974, section 6.1",
    plant: PlantClass::Nonlinear(Time::ANY),
    keys: &[ExtendedKalman::KEYS],
    kind: as_kind::<ExtendedKalman>,
    read: |given, reader| Some(ExtendedKalman::read(given, reader)?.into()),
    takes_long: false,
    tuning: Tuning::Rules(&[Rule {
        name: "extended-kalman",
        turn: 18,
        tuning: "covariances of process noise, of a sample and of the first error",
        source: "Gelb 1974, section 6.1",
        character: "its gain is large while its covariance is, after the start, and small later: a constant gain is one for both",
        information: &[Information::Noise, Information::ProcessNoise, Information::FirstError],
        keys: |context| Ok(vec![tuning::filter(context)?]),
    }]),
};

crate::keys! {
    /// An extended Kalman filter, an iterated one, or one of unit vectors.
    #[derive(Debug, Clone, PartialEq)]
    pub struct ExtendedKalman {
        /// Its noises and its period.
        filter: Filter as [Filter::KEYS] => Filter::read,
        /// How many standard deviations an innovation may have; none for no limit.
        gate: Option<f64> as &GATE,
        /// Whether estimates on a log are smoothed.
        smooth: bool as &SMOOTH = false,
        /// Bounds of the states; none for no bounds.
        state_bounds: Option<Vec<(f64, f64)>> as &STATE_BOUNDS => state_bounds,
        /// S of noises that are correlated, n x p; none for none.
        s: Option<DMatrix<f64>> as &CROSS_COVARIANCE => cross_covariance,
        /// How often an iterated filter linearises each measurement; none for the other kind, which has no such key.
        iterations: Option<usize> as [&[]] => |_, _| Some(None),
        /// The number of the unit vector of each state of an error-state filter, from 1 on, and 0 for the others; none
        /// for the other kinds.
        unit_vectors: Option<Vec<usize>> as [&[]] => |_, _| Some(None),
    }
}

impl Specification for ExtendedKalman {
    fn name(&self) -> &'static str {
        self.declaration().name
    }

    fn plant(&self) -> PlantClass {
        self.declaration().plant
    }

    fn period(&self) -> Option<f64> {
        Some(self.filter.period)
    }

    fn substeps(&self) -> Option<usize> {
        self.filter.substeps
    }

    fn updates(&self, _dt: Option<f64>) -> bool {
        true
    }

    fn has_likelihood(&self, _dt: Option<f64>) -> bool {
        true
    }

    fn noises(&self) -> Option<[&DMatrix<f64>; 2]> {
        self.filter.constant()
    }

    fn with_parameters(&self, parameters: &[Estimated]) -> Option<ObserverKind> {
        let state_bounds = bounds_with(self.state_bounds.as_deref(), self.filter.w.nrows(), parameters);
        let s = cross_with(self.s.as_ref(), parameters);
        let unit_vectors = self.unit_vectors.clone().map(|mut numbers| {
            numbers.resize(numbers.len() + parameters.len(), 0);
            numbers
        });
        let filter = self.filter.with_parameters(parameters);
        Some(Self { filter, state_bounds, s, unit_vectors, ..self.clone() }.into())
    }

    fn smooths(&self) -> bool {
        self.smooth
    }

    fn seconds_of_steps(&self, duration: f64) -> f64 {
        let (n, p) = (self.filter.w.nrows() as f64, self.filter.v.nrows() as f64);
        let again = self.iterations.map_or(0.0, |iterations| iterations as f64 - 1.0);
        duration / self.filter.period * (STAGES * n + 4.0 * again * p) * n * n * 4e-9
    }
}

impl Kind for ExtendedKalman {
    filters!();

    fn takes_delays(&self) -> bool {
        true
    }
}

impl ExtendedKalman {
    fn declaration(&self) -> &'static Declaration {
        match (&self.unit_vectors, self.iterations) {
            (Some(_), _) => &error_state_kalman::DECLARATION,
            (None, Some(_)) => &iterated_extended_kalman::DECLARATION,
            (None, None) => &DECLARATION,
        }
    }

    /// The filter of the plant in this form.
    fn of<S: Differentiable<f64, Dyn, Dyn, Dyn>>(
        &self,
        plant: S,
        prediction: Prediction,
        turns: Option<DVector<f64>>,
    ) -> Result<ExtendedKalmanFilter<S, f64, Dyn, Dyn, Dyn>, ObserverError> {
        let filter = ExtendedKalmanFilter::discrete(plant, self.filter.noises(), self.filter.period)?
            .with_prediction(prediction)?
            .with_iterations(self.iterations.unwrap_or(1))?;
        let filter = match self.gate {
            Some(gate) => filter.with_gate(gate)?,
            None => filter,
        };
        let filter = match &self.unit_vectors {
            Some(numbers) => filter.with_unit_vectors(DVector::from_iterator(
                numbers.len(),
                numbers.iter().map(|number| *number as f64),
            ))?,
            None => filter,
        };
        match turns {
            Some(turns) => filter.with_angles(turns),
            None => Ok(filter),
        }
    }

    fn designed(&self, plant: &PlantModel, prediction: Prediction) -> Result<Designed, NoObserver> {
        let Self { filter: Filter { period, along, .. }, gate, iterations, state_bounds, s, unit_vectors, .. } = self;
        let gated = gate
            .map_or_else(String::new, |gate| format!(" Innovations beyond {gate} standard deviations are rejected."));
        let turns = plant.turns_of(&plant.outputs).map(DVector::from_vec);
        if let Some(bounds) = state_bounds {
            bounds_no_angle(plant, bounds)?;
        }
        let bounded = if state_bounds.is_some() { BOUNDED } else { "" };
        let correlation = if s.is_some() { CORRELATED } else { "" };
        let late = late(plant, self.smooth)?;
        let linearised = iterations
            .map_or_else(String::new, |iterations| format!(", each update linearised {}", counted(iterations, "time")));
        let of_unit_norm = unit_vectors.as_deref().map_or_else(String::new, |numbers| of_unit_norm(plant, numbers));
        let mut numbers = vec![number(Quantity::Period, *period)];
        numbers.extend(iterations.map(|iterations| number("iterations", iterations as f64)));
        let report = DesignReport {
            statement: Statement::of(format!(
                "One measurement every {}; the gain is computed from the covariance along the estimate{linearised}.{of_unit_norm}{gated}{}{correlation}{bounded}{late}{}",
                plant.time_in_words(*period),
                along.words(),
                wrapped(plant)
            )),
            matrices: matrices(&self.filter, s.as_ref()),
            numbers,
            ..without_certificate(plant, "local convergence only")
        };
        let (model, bounds) = (plant.model.clone(), state_bounds.as_deref());
        let runnable = match s {
            None => adapted(self.of(model, prediction, turns)?, along, bounds, &plant.delays)?,
            Some(s) => {
                let decorrelated = decorrelated(model, turns.clone())?;
                correlated(self.of(decorrelated, prediction, turns)?, bounds, s)?
            }
        };
        Ok(Designed::new(runnable, report, None))
    }
}

/// What is said of unit vectors.
fn of_unit_norm(plant: &PlantModel, numbers: &[usize]) -> String {
    let named = |vector: usize| {
        let names = plant.states.iter().zip(numbers).filter(|(_, number)| **number == vector);
        format!("({})", names.map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", "))
    };
    let last = numbers.iter().copied().max().unwrap_or_default();
    let all: Vec<String> = (1..=last).map(named).collect();
    format!(" The norm of {} is 1 after each update and prediction, and P has no part along it.", all.join(" and of "))
}

impl Running for ExtendedKalmanFilter<Model, f64, Dyn, Dyn, Dyn> {
    runs_as_filter!();

    fn with_variances(&self, rows: &Arc<RowVariances>) -> Option<Runnable> {
        Some(with_variances(self, rows))
    }

    // The page has no iterated updates, no angles and no unit vectors.
    fn live(&self, _study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        if self.iterations() > 1 || self.turns().is_some() || self.unit_vectors().is_some() {
            return None;
        }
        let noises = self.noise_model();
        let period = SampledObserver::<f64>::period(self);
        let [w, v, p0] = [&noises.w, &noises.v, &noises.p0].map(rows);
        let (discrete, gate) = (self.prediction() == Prediction::Discrete, self.gate());
        Some((live::ObserverKind::Kalman { w, v, p0, period, discrete, gate }, None))
    }

    fn step(&self, of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        let noises = self.noise_model();
        let made = |plant: ExpressionPlant, sampled: Option<DMatrix<f64>>| {
            let noises = NoiseModel { w: sampled.unwrap_or_else(|| noises.w.clone()), ..noises.clone() };
            let period = SampledObserver::<f64>::period(self);
            let filter = ExtendedKalmanFilter::discrete(plant, noises, period)?.with_options_of(self)?;
            filter.with_prediction(Prediction::Discrete)
        };
        let statement = "no theorem certifies an extended Kalman filter here.";
        let made_of = |filter| NonlinearStep::uncertified(ExportableObserver::Kalman(filter), statement);
        let with = |filter: &ExtendedKalmanFilter<_, f64, Dyn, Dyn, Dyn>, prediction| {
            filter.clone().with_prediction(prediction)
        };
        filter_step(of, (self.prediction(), &noises.w), (made, with, made_of)).map(Some)
    }
}
