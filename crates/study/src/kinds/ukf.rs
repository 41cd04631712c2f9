//! The unscented Kalman filter in square-root form.

use std::sync::Arc;

use luenberger_export::ExportableObserver;
use luenberger_expression::ExpressionPlant;
use luenberger_observers::{
    NoiseModel, ObserverError, Prediction, SampledObserver, SigmaPoints, UnscentedKalmanFilter,
};
use luenberger_plants::Differentiable;
use luenberger_proof::wording::counted;
use nalgebra::{DMatrix, DVector, Dyn};

use super::declaration::{Declaration, Information, Rule, Tuning};
use super::filter::{
    BOUNDED, CORRELATED, CROSS_COVARIANCE, Filter, STAGES, STATE_BOUNDS, bounds_no_angle, bounds_with,
    cross_covariance, cross_with, late, matrices, state_bounds, turns, wrapped,
};
use super::keys::{GATE, SMOOTH};
use super::{Kind, as_kind};
use crate::designed::{
    NonlinearStep, RowVariances, Runnable, Running, StepOf, adapted, correlated, decorrelated, runs_as_filter,
    with_variances,
};
use crate::model::{Model, PlantModel};
use crate::reader::{Given, Reader};
use crate::results::{DesignReport, NoObserver, Quantity, Statement};
use crate::steps::filter_step;
use crate::study::{Estimated, ObserverKind, PlantClass, Specification, Time};
use crate::synthesis::{Designed, Plan, number, without_certificate};
use crate::tuning;

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "ukf",
    about: "Unscented Kalman filter in square-root form, for a plant in continuous time with sampled measurements, or in discrete time.",
    source: "Julier and Uhlmann 2004; Van der Merwe and Wan, ICASSP 2001",
    plant: PlantClass::Nonlinear(Time::ANY),
    keys: &[UnscentedSpec::KEYS],
    kind: as_kind::<UnscentedSpec>,
    read: |given, reader| Some(UnscentedSpec::read(given, reader)?.into()),
    takes_long: false,
    tuning: Tuning::Rules(&[Rule {
        name: "ukf",
        turn: 19,
        tuning: "the covariances of extended-kalman",
        source: "Van der Merwe and Wan 2001",
        character: "as extended-kalman, with the curvature of the plant between its sigma points in place of derivatives",
        information: &[Information::Noise, Information::ProcessNoise, Information::FirstError],
        keys: |context| Ok(vec![tuning::filter(context)?]),
    }]),
};

crate::keys! {
    /// An unscented Kalman filter.
    #[derive(Debug, Clone, PartialEq)]
    pub struct UnscentedSpec {
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
        /// The sigma points.
        sigma: SigmaPoints as [Sigma::KEYS] => sigma,
    }
}

crate::keys! {
    struct Sigma {
        /// Distance of the sigma points from the estimate, alpha sqrt(n + kappa) standard deviations (default 1).
        alpha: f64 as Number(Positive) = SigmaPoints::default().alpha,
        /// Weight of the central point in covariances (default 2, for Gaussian errors).
        beta: f64 as Number(Any) = SigmaPoints::default().beta,
        /// Second parameter of the distance, above -n (default 0).
        kappa: f64 as Number(Any) = SigmaPoints::default().kappa,
    }
}

/// Sigma points with weights.
fn sigma(given: &Given<'_>, reader: &mut Reader) -> Option<SigmaPoints> {
    let Sigma { alpha, beta, kappa } = Sigma::read(given, reader)?;
    let (sigma, n) = (SigmaPoints { alpha, beta, kappa }, given.size().states);
    if sigma.weights::<f64>(n).is_ok() {
        return Some(sigma);
    }
    let key = given.node.entry("kappa").or_else(|| given.node.entry("alpha"))?;
    let message = format!(
        "`{}` leaves no sigma points: alpha = {alpha}, kappa = {kappa}, and the plant has {}",
        key.key,
        counted(n, "state")
    );
    reader.refuse(key.span.clone(), message, format!("expected kappa > -{n} and an alpha of about 1e-3 to 1"))
}

impl UnscentedSpec {
    /// The filter for noise of intensity W and covariance V, with P(0) = I and the usual sigma points.
    pub fn new(w: DMatrix<f64>, v: DMatrix<f64>, period: f64) -> Self {
        let (filter, sigma) = (Filter::new(w, v, period), SigmaPoints::default());
        Self { filter, gate: None, smooth: false, state_bounds: None, s: None, sigma }
    }
}

impl Specification for UnscentedSpec {
    declared!();

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
        Some(Self { filter: self.filter.with_parameters(parameters), state_bounds, s, ..self.clone() }.into())
    }

    fn smooths(&self) -> bool {
        self.smooth
    }

    fn seconds_of_steps(&self, duration: f64) -> f64 {
        let n = self.filter.w.nrows() as f64;
        duration / self.filter.period * (2.0 * STAGES * n * n + 15.0 * n * n * n) * 8e-9
    }
}

impl Kind for UnscentedSpec {
    filters!();

    fn takes_delays(&self) -> bool {
        true
    }
}

impl UnscentedSpec {
    /// The filter of the plant in this form.
    fn of<S: Differentiable<f64, Dyn, Dyn, Dyn>>(
        &self,
        plant: S,
        prediction: Prediction,
        turns: Option<(DVector<f64>, DVector<f64>)>,
    ) -> Result<UnscentedKalmanFilter<S, f64, Dyn, Dyn, Dyn>, ObserverError> {
        let filter = UnscentedKalmanFilter::discrete(plant, self.filter.noises(), self.sigma, self.filter.period)?
            .with_prediction(prediction)?;
        let filter = match self.gate {
            Some(gate) => filter.with_gate(gate)?,
            None => filter,
        };
        match turns {
            Some((outputs, states)) => filter.with_angles(outputs, states),
            None => Ok(filter),
        }
    }

    /// The filter of a plant in continuous or in discrete time.
    fn designed(&self, plant: &PlantModel, prediction: Prediction) -> Result<Designed, NoObserver> {
        let Self { filter: Filter { w, period, along, .. }, sigma, gate, state_bounds, s, .. } = self;
        let gated = gate
            .map_or_else(String::new, |gate| format!(" Innovations beyond {gate} standard deviations are rejected."));
        let turns = turns(plant);
        if let Some(bounds) = state_bounds {
            bounds_no_angle(plant, bounds)?;
        }
        let bounded = if state_bounds.is_some() { BOUNDED } else { "" };
        let correlation = if s.is_some() { CORRELATED } else { "" };
        let late = late(plant, self.smooth)?;
        let points = 2 * w.nrows() + 1;
        let report = DesignReport {
            statement: Statement::of(format!(
                "One measurement every {}; mean and covariance from {points} sigma points, the covariance by its factor.{gated}{}{correlation}{bounded}{late}{}",
                plant.time_in_words(*period),
                along.words(),
                wrapped(plant)
            )),
            matrices: matrices(&self.filter, s.as_ref()),
            numbers: vec![
                number(Quantity::Period, *period),
                number("alpha", sigma.alpha),
                number("beta", sigma.beta),
                number("kappa", sigma.kappa),
            ],
            ..without_certificate(plant, "no theorem of stability")
        };
        let (model, bounds) = (plant.model.clone(), state_bounds.as_deref());
        let runnable = match s {
            None => adapted(self.of(model, prediction, turns)?, along, bounds, &plant.delays)?,
            Some(s) => {
                let decorrelated = decorrelated(model, turns.as_ref().map(|(outputs, _)| outputs.clone()))?;
                correlated(self.of(decorrelated, prediction, turns)?, bounds, s)?
            }
        };
        Ok(Designed::new(runnable, report, None))
    }
}

impl Running for UnscentedKalmanFilter<Model, f64, Dyn, Dyn, Dyn> {
    runs_as_filter!();

    fn with_variances(&self, rows: &Arc<RowVariances>) -> Option<Runnable> {
        Some(with_variances(self, rows))
    }

    fn step(&self, of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        let (factors, sigma, period) = (self.factors(), self.sigma_points(), SampledObserver::<f64>::period(self));
        let covariance = |factor: &DMatrix<f64>| factor * factor.transpose();
        let made = |plant: ExpressionPlant, sampled: Option<DMatrix<f64>>| {
            let filter = match sampled {
                Some(w) => {
                    let noises = NoiseModel { w, v: covariance(&factors.v), p0: covariance(&factors.p0) };
                    UnscentedKalmanFilter::discrete(plant, noises, sigma, period)
                }
                // Without a change of the factors.
                None => {
                    UnscentedKalmanFilter::from_factors(plant, factors.clone(), sigma, period, Prediction::Discrete)
                }
            }?;
            let filter = match self.angles() {
                Some((outputs, states)) => filter.with_angles(outputs, states)?,
                None => filter,
            };
            match self.gate() {
                Some(gate) => filter.with_gate(gate),
                None => Ok(filter),
            }
        };
        let statement = "there is no theorem for an unscented Kalman filter.";
        let made_of = |filter| NonlinearStep::uncertified(ExportableObserver::Unscented(filter), statement);
        let with = |filter: &UnscentedKalmanFilter<_, f64, Dyn, Dyn, Dyn>, prediction| {
            filter.clone().with_prediction(prediction)
        };
        let w = covariance(&factors.w);
        filter_step(of, (self.prediction(), &w), (made, with, made_of)).map(Some)
    }
}
