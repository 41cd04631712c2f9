//! The moving-horizon estimator: the states of the last samples by least squares, with bounds.

use luenberger_export::ExportableObserver;
use luenberger_export::moving_horizon::{LONGEST_WINDOW, MovingHorizon};
use luenberger_expression::ExpressionPlant;
use luenberger_observers::{Horizon, MovingHorizonEstimator, NoiseModel, Prediction, SampledObserver};
use luenberger_proof::wording::counted;
use luenberger_sim::Replay;
use nalgebra::{DMatrix, DVector, Dyn};

use super::declaration::{Declaration, Information, Rule, Tuning};
use super::filter::{BOUNDED, Filter, STAGES, bounds_no_angle, bounds_with, matrices, state_bounds, turns, wrapped};
use super::{Kind, as_kind};
use crate::designed::{self, NonlinearStep, Running, StepOf};
use crate::model::{Model, PlantModel};
use crate::reader::{Given, Reader};
use crate::results::{DesignReport, NoObserver, Quantity, Statement};
use crate::steps::filter_step;
use crate::study::{Estimated, ObserverKind, PlantClass, Specification, Time};
use crate::synthesis::{Designed, Plan, number, without_certificate};
use crate::tuning::{self, Context, Keys, Value};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "mhe",
    about: "Moving-horizon estimator: the states of the last samples by least squares, with bounds, for a plant in continuous time with sampled measurements, or in discrete time.",
    source: "Rao, Rawlings and Mayne 2003; Bell, Burke and Pillonetto 2009",
    plant: PlantClass::Nonlinear(Time::ANY),
    keys: &[MovingHorizonSpec::KEYS],
    kind: as_kind::<MovingHorizonSpec>,
    read: |given, reader| Some(MovingHorizonSpec::read(given, reader)?.into()),
    takes_long: false,
    tuning: Tuning::Rules(&[Rule {
        name: "mhe",
        turn: 20,
        tuning: "the covariances of extended-kalman, ten samples, and the region as bounds of the states",
        source: "Rao, Rawlings and Mayne 2003",
        character: "it solves a least-squares problem over the last samples and keeps its estimate within the region",
        information: &[Information::Noise, Information::ProcessNoise, Information::FirstError, Information::Region],
        keys: tuned,
    }]),
};

crate::keys! {
    /// A moving-horizon estimator.
    #[derive(Debug, Clone, PartialEq)]
    pub struct MovingHorizonSpec {
        /// Its noises and its period.
        filter: Filter as [Filter::KEYS] => constant_noises,
        /// Samples in the window, and Gauss-Newton steps at each.
        horizon: Horizon as [Window::KEYS] => horizon,
        /// Bounds of the states, n pairs [lower, upper]; they may be inf or -inf (default: none).
        state_bounds: Option<Vec<(f64, f64)>> as Bounds => state_bounds,
    }
}

crate::keys! {
    struct Window {
        /// Samples in the window, at most 32 (default 10).
        window: usize as Count(1) = HORIZON.window,
        /// Gauss-Newton steps at each sample (default 2; one is exact for a linear plant).
        iterations: usize as Count(1) = HORIZON.iterations,
    }
}

/// The horizon, where none is given.
const HORIZON: Horizon = Horizon { window: 10, iterations: 2 };

fn horizon(given: &Given<'_>, reader: &mut Reader) -> Option<Horizon> {
    let Window { window, iterations } = Window::read(given, reader)?;
    match given.node.get("window").filter(|_| window > LONGEST_WINDOW) {
        Some(node) => {
            let expected = format!("expected at most {LONGEST_WINDOW} samples");
            reader.refuse(node.span.clone(), format!("`window` is {window}"), expected)
        }
        None => Some(Horizon { window, iterations }),
    }
}

/// The noises, which are constant over the window.
fn constant_noises(given: &Given<'_>, reader: &mut Reader) -> Option<Filter> {
    let filter = Filter::read(given, reader)?;
    let varying = [("w", filter.along.process.is_some()), ("v", filter.along.measurement.is_some())];
    if let Some((key, _)) = varying.into_iter().find(|(_, varies)| *varies) {
        let message = format!("`{key}` has expressions, and the kind mhe has the same noises in all of its window");
        let expected = "expected numbers, or another kind: extended-kalman, iterated-extended-kalman, ukf";
        return reader.refuse(given.node.get(key)?.span.clone(), message, expected);
    }
    Some(filter)
}

impl MovingHorizonSpec {
    /// The estimator for noise of intensity W and covariance V, with P(0) = I, a window of ten samples and no bounds.
    pub fn new(w: DMatrix<f64>, v: DMatrix<f64>, period: f64) -> Self {
        Self { filter: Filter::new(w, v, period), horizon: HORIZON, state_bounds: None }
    }
}

impl Specification for MovingHorizonSpec {
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

    fn noises(&self) -> Option<[&DMatrix<f64>; 2]> {
        self.filter.constant()
    }

    fn with_parameters(&self, parameters: &[Estimated]) -> Option<ObserverKind> {
        let state_bounds = bounds_with(self.state_bounds.as_deref(), self.filter.w.nrows(), parameters);
        Some(Self { filter: self.filter.with_parameters(parameters), state_bounds, ..self.clone() }.into())
    }

    // With active bounds the interior-point method adds steps.
    fn seconds_of_steps(&self, duration: f64) -> f64 {
        let (n, horizon) = (self.filter.w.nrows() as f64, self.horizon);
        let passes = horizon.iterations as f64 + self.state_bounds.as_ref().map_or(0.0, |_| 12.0);
        let stage = (STAGES + 8.0) * n * n * n;
        duration / self.filter.period * passes * horizon.window as f64 * stage * 8e-9
    }

    fn has_shorter_steps(&self) -> bool {
        true
    }
}

impl Kind for MovingHorizonSpec {
    filters!();
}

impl MovingHorizonSpec {
    /// The estimator of a plant in continuous or in discrete time.
    fn designed(&self, plant: &PlantModel, prediction: Prediction) -> Result<Designed, NoObserver> {
        let Self { filter: Filter { period, .. }, horizon, state_bounds } = self;
        let noises = self.filter.noises();
        let mut estimator = MovingHorizonEstimator::discrete(plant.model.clone(), noises, *horizon, *period)?
            .with_prediction(prediction)?;
        let mut bounded = String::new();
        if let Some(bounds) = state_bounds {
            let (lower, upper): (Vec<f64>, Vec<f64>) = bounds.iter().copied().unzip();
            estimator = estimator.with_bounds(DVector::from_vec(lower), DVector::from_vec(upper))?;
            bounds_no_angle(plant, bounds)?;
            BOUNDED.clone_into(&mut bounded);
        }
        if let Some((outputs, states)) = turns(plant) {
            estimator = estimator.with_angles(outputs, states)?;
        }
        let report = DesignReport {
            statement: Statement::of(format!(
                "One measurement every {}; the states of the last {} by least squares, {} at each.{bounded}{}",
                plant.time_in_words(*period),
                counted(horizon.window, "sample"),
                counted(horizon.iterations, "Gauss-Newton step"),
                wrapped(plant)
            )),
            matrices: matrices(&self.filter, None),
            numbers: vec![
                number(Quantity::Period, *period),
                number("window", horizon.window as f64),
                number("iterations", horizon.iterations as f64),
            ],
            ..without_certificate(plant, "no theorem of stability")
        };
        Ok(Designed::new(estimator.into(), report, None))
    }
}

impl Running for MovingHorizonEstimator<Model, f64, Dyn, Dyn, Dyn, Dyn, LONGEST_WINDOW> {
    runs!(sampled);

    // As a filter it also records its covariance. Rows that measure nothing are no samples of the window.
    fn replay<'a>(&'a self, replay: Replay<'a>, name: &str, initial: &[f64]) -> Replay<'a> {
        let filter = self.clone();
        replay.filter(name, filter.clone().with_joined_predictions().unwrap_or(filter), initial)
    }

    fn filter(&self) -> Option<&dyn designed::Filter> {
        Some(self)
    }

    fn step(&self, of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        let (noises, period) = (self.noise_model(), SampledObserver::<f64>::period(self));
        let made = |plant: ExpressionPlant, sampled: Option<DMatrix<f64>>| {
            let noises = NoiseModel { w: sampled.unwrap_or_else(|| noises.w.clone()), ..noises.clone() };
            let estimator = MovingHorizon::discrete(plant, noises, self.horizon(), period)?;
            let estimator = match self.angles() {
                Some((outputs, states)) => estimator.with_angles(outputs, states)?,
                None => estimator,
            };
            match self.bounds() {
                Some((lower, upper)) => estimator.with_bounds(lower.clone(), upper.clone()),
                None => Ok(estimator),
            }
        };
        let statement = "there is no theorem for this moving-horizon estimator.";
        let made_of = |estimator| NonlinearStep::uncertified(ExportableObserver::MovingHorizon(estimator), statement);
        let with = |estimator: &MovingHorizon<f64>, prediction| estimator.clone().with_prediction(prediction);
        filter_step(of, (self.prediction(), &noises.w), (made, with, made_of)).map(Some)
    }
}

/// A filter over a window, with the region as bounds of the states.
fn tuned(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    let mut keys = tuning::filter(context)?;
    keys.push(("state_bounds", Value::pairs(context.information.region.states())));
    Ok(vec![keys])
}
