//! The observers that can be exported, and their steps in the format of the target.

use std::collections::BTreeSet;

use luenberger_expression::{ExpressionPlant, Lookups, MathFunction, Routine, Routines, Table};
use luenberger_observers::{
    DiscreteLinearObserver, DiscreteNonlinearObserver, ExtendedKalmanFilter, MatrixName, NoiseModel,
    ObserverDimensions, ObserverError, Prediction, SampledCubicObserver, SampledNonlinearObserver, SampledObserver,
    UnscentedKalmanFilter, VaryingPeriodObserver, VaryingPeriodStep,
};
use nalgebra::{DMatrix, DVector, Dyn, RealField};

use crate::cast::{Cast, Sampled};
use crate::error::ExportError;
use crate::extension::{ExtensionMaps, SampledExtension};
use crate::kkl::Kkl;
use crate::matrix::ExportedMatrix;
use crate::moving_horizon::{self, MovingHorizon, bounds};
use crate::scalar::Scalar;
use crate::step::RecordedStep;

/// An observer that is stepped once per sample, with numbers as designed.
#[derive(Debug, Clone, PartialEq)]
pub enum ExportableObserver {
    /// `xhat+ = Ad xhat + Bd u + Ld (y - C xhat)`.
    Linear(DiscreteLinearObserver<f64, Dyn, Dyn, Dyn>),
    /// The sampled cubic observer.
    Cubic(SampledCubicObserver<f64, Dyn, Dyn, Dyn>),
    /// The sampled cubic observer at varying periods; the last input is the time since the last step.
    Varying(VaryingPeriodStep<f64, Dyn, Dyn, Dyn>),
    /// The extended Kalman filter, iterated or not.
    Kalman(ExtendedKalmanFilter<ExpressionPlant, f64, Dyn, Dyn, Dyn>),
    /// The unscented Kalman filter in square-root form.
    Unscented(UnscentedKalmanFilter<ExpressionPlant, f64, Dyn, Dyn, Dyn>),
    /// The moving-horizon estimator.
    MovingHorizon(MovingHorizon<f64>),
    /// The copy of a nonlinear plant with a constant gain.
    SampledNonlinear(SampledNonlinearObserver<ExpressionPlant, f64, Dyn, Dyn, Dyn>),
    /// The copy of a plant in discrete time with a constant gain.
    Discrete(DiscreteNonlinearObserver<ExpressionPlant, f64, Dyn, Dyn, Dyn>),
    /// The numerical KKL observer.
    Kkl(Kkl<f64>),
    /// A recorded observer in continuous time.
    Extension(SampledExtension<f64>),
    /// An observer whose step is recorded.
    Step(RecordedStep<f64>),
}

/// The same of every observer.
macro_rules! each {
    ($of:expr, $observer:ident => $what:expr) => {
        match $of {
            ExportableObserver::Linear($observer) => $what,
            ExportableObserver::Cubic($observer) => $what,
            ExportableObserver::Varying($observer) => $what,
            ExportableObserver::Kalman($observer) => $what,
            ExportableObserver::Unscented($observer) => $what,
            ExportableObserver::MovingHorizon($observer) => $what,
            ExportableObserver::SampledNonlinear($observer) => $what,
            ExportableObserver::Discrete($observer) => $what,
            ExportableObserver::Kkl($observer) => $what,
            ExportableObserver::Extension($observer) => $what,
            ExportableObserver::Step($observer) => $what,
        }
    };
}

/// The right-hand sides of a nonlinear plant in the form in which an observer needs them.
#[derive(Debug, Clone)]
pub(crate) struct Maps {
    /// f, for the extended Kalman filter with Df after it, row by row.
    pub(crate) motion: Routine,
    /// h, and Dh after it, row by row, but for the copy in discrete time.
    pub(crate) measurement: Routine,
    /// f and Df after it, row by row, where an unscented Kalman filter in continuous time needs them along its centre.
    pub(crate) centre: Option<Routine>,
    /// The observer itself, where it is recorded.
    pub(crate) extension: Option<ExtensionMaps>,
}

impl Maps {
    /// The elementary functions that they call.
    pub(crate) fn functions(&self) -> BTreeSet<MathFunction> {
        self.routines().flat_map(Routine::functions).collect()
    }

    /// All of them.
    pub(crate) fn routines(&self) -> impl Iterator<Item = &Routine> + Clone {
        let own = self.extension.iter().flat_map(ExtensionMaps::all);
        [&self.motion, &self.measurement].into_iter().chain(&self.centre).chain(own)
    }
}

/// The tables that some routines use, each once.
pub(crate) fn tables<'a>(routines: &[&'a Routine]) -> Vec<(usize, &'a Table, Lookups)> {
    let mut all: Vec<(usize, &Table, Lookups)> = Vec::new();
    for (number, table, used) in routines.iter().flat_map(|routine| routine.used_tables()) {
        match all.iter_mut().find(|(other, ..)| *other == number) {
            Some((_, _, also)) => {
                *also = Lookups { value: also.value || used.value, slope: also.slope || used.slope };
            }
            None => all.push((number, table, used)),
        }
    }
    all
}

impl ExportableObserver {
    /// Lengths of the columns.
    pub fn dimensions(&self) -> ObserverDimensions {
        each!(self, observer => observer.dimensions())
    }

    /// The observer itself as straight-line code, where it is recorded.
    pub(crate) fn extension(&self) -> Option<ExtensionMaps> {
        if let Self::Extension(observer) = self { Some(observer.observer().routines().clone()) } else { None }
    }

    /// The right-hand sides of a nonlinear plant; none for a linear one, whose matrices are
    /// [`matrices`](Self::matrices).
    pub(crate) fn routines(&self) -> Option<Routines> {
        match self {
            Self::Linear(_) | Self::Cubic(_) | Self::Varying(_) => None,
            Self::Kalman(filter) => Some(filter.plant().routines()),
            Self::Unscented(filter) => Some(filter.plant().routines()),
            Self::MovingHorizon(estimator) => Some(estimator.plant().routines()),
            Self::SampledNonlinear(observer) => Some(observer.plant().routines()),
            Self::Discrete(observer) => Some(observer.plant().routines()),
            Self::Kkl(observer) => Some(observer.plant().routines()),
            Self::Extension(observer) => Some(observer.plant().routines()),
            Self::Step(observer) => {
                let (f, h) = observer.routines();
                Some(Routines { motion: f.clone(), measurement: h.clone(), f, h })
            }
        }
    }

    /// Those that the step needs.
    pub(crate) fn maps(&self) -> Option<Maps> {
        let all = self.routines()?;
        let centre = match self {
            Self::Unscented(filter) => filter.substeps().map(|_| all.motion.clone()),
            _ => None,
        };
        let (motion, measurement) = match self {
            Self::Kalman(_) | Self::MovingHorizon(_) => (all.motion, all.measurement),
            Self::Discrete(_) | Self::Kkl(_) | Self::Unscented(_) | Self::Step(_) => (all.f, all.h),
            _ => (all.f, all.measurement),
        };
        Some(Maps { motion, measurement, centre, extension: self.extension() })
    }

    /// Whether the plant depends on the time.
    pub(crate) fn uses_time(&self) -> bool {
        let Some(maps) = self.maps() else { return false };
        // The start is at t = 0.
        let own = maps.extension.iter().flat_map(|own| [&own.rate, &own.estimate].into_iter().chain(&own.jump));
        [&maps.motion, &maps.measurement].into_iter().chain(own).any(Routine::uses_time)
    }

    /// The step tau of the Runge-Kutta method, tau/2 and tau/6, as they are computed in the format.
    pub(crate) fn increments(&self, scalar: Scalar) -> [f64; 3] {
        let (period, count) = (self.period(), self.substeps().unwrap_or(1) as f64);
        match scalar {
            Scalar::Binary32 => {
                let tau = period as f32 / count as f32;
                [tau, tau * 0.5, tau * (1.0_f64 / 6.0) as f32].map(f64::from)
            }
            Scalar::Binary64 => {
                let tau = period / count;
                [tau, tau * 0.5, tau * (1.0 / 6.0)]
            }
        }
    }

    /// Whether its step leaves out of its correction the outputs that are not finite, such as NaN, and takes the
    /// others.
    pub fn leaves_out_missing(&self) -> bool {
        match self {
            Self::Linear(_)
            | Self::Cubic(_)
            | Self::Varying(_)
            | Self::Kalman(_)
            | Self::Unscented(_)
            | Self::MovingHorizon(_)
            | Self::SampledNonlinear(_)
            | Self::Discrete(_) => true,
            Self::Kkl(_) | Self::Extension(_) | Self::Step(_) => false,
        }
    }

    /// Runge-Kutta steps between two samples, if there are any.
    pub fn substeps(&self) -> Option<usize> {
        match self {
            Self::Linear(_) | Self::Cubic(_) | Self::Varying(_) | Self::Discrete(_) | Self::Step(_) => None,
            Self::Kkl(observer) => Some(observer.substeps()),
            Self::Kalman(filter) => filter.substeps(),
            Self::Unscented(filter) => filter.substeps(),
            Self::MovingHorizon(estimator) => estimator.substeps(),
            Self::SampledNonlinear(observer) => Some(observer.substeps()),
            Self::Extension(observer) => Some(observer.substeps()),
        }
    }

    /// The sampling period.
    pub fn period(&self) -> f64 {
        each!(self, observer => observer.period())
    }

    /// Samples in the window of a moving-horizon estimator; 0 of the others.
    pub(crate) fn window(&self) -> usize {
        if let Self::MovingHorizon(estimator) = self { estimator.horizon().window } else { 0 }
    }

    /// The root of tau/6, by which the columns of the process noise enter an unscented filter, as it is computed in the
    /// format.
    pub(crate) fn noise_weight(&self, scalar: Scalar) -> f64 {
        let [_, _, sixth] = self.increments(scalar);
        match scalar {
            Scalar::Binary32 => f64::from((sixth as f32).sqrt()),
            Scalar::Binary64 => sixth.sqrt(),
        }
    }

    /// The lower triangular factor of V, as it is computed in the format; of a moving-horizon estimator.
    pub(crate) fn root_of_v(&self, scalar: Scalar) -> DMatrix<f64> {
        let Self::MovingHorizon(estimator) = self else { return DMatrix::zeros(0, 0) };
        let root = match scalar {
            Scalar::Binary32 => moving_horizon::cast::<f32>(estimator).map(|same| same.root().map(f64::from)),
            Scalar::Binary64 => Ok(estimator.root().clone()),
        };
        // The cast has been checked.
        root.map(|root| root.lower_triangle()).unwrap_or_default()
    }

    /// The matrices that the step uses.
    pub fn matrices(&self) -> Vec<(ExportedMatrix, DMatrix<f64>)> {
        let mut all = match self {
            Self::Linear(observer) => {
                let plant = observer.plant();
                vec![
                    (MatrixName::A, &plant.a),
                    (MatrixName::B, &plant.b),
                    (MatrixName::C, &plant.c),
                    (MatrixName::L, observer.l()),
                ]
            }
            Self::Cubic(observer) => vec![
                (MatrixName::Ad, observer.ad()),
                (MatrixName::Bd, observer.bd()),
                (MatrixName::C, observer.c()),
                (MatrixName::Ld, observer.ld()),
                (MatrixName::N, observer.n()),
                (MatrixName::Theta, observer.theta()),
            ]
            .into_iter()
            .chain(observer.coupling().map(|coupling| (MatrixName::Coupling, coupling)))
            .collect(),
            Self::Varying(step) => {
                let (observer, nominal) = (step.observer(), step.observer().nominal());
                let gains =
                    [(MatrixName::K, observer.k()), (MatrixName::N, nominal.n()), (MatrixName::Theta, nominal.theta())];
                [(MatrixName::A, observer.a()), (MatrixName::B, observer.b()), (MatrixName::C, nominal.c())]
                    .into_iter()
                    .chain(gains)
                    .chain(nominal.coupling().map(|coupling| (MatrixName::Coupling, coupling)))
                    .collect()
            }
            Self::Kalman(filter) => {
                let NoiseModel { w, v, p0 } = filter.noise_model();
                let all = [(MatrixName::W, w), (MatrixName::V, v), (MatrixName::P0, p0)];
                let all = all.into_iter().map(|(which, matrix)| (which.into(), matrix.clone()));
                let row = |vectors: &DVector<f64>| DMatrix::from_row_slice(1, vectors.len(), vectors.as_slice());
                let vectors = filter.unit_vectors().map(|vectors| (MatrixName::UnitVectors.into(), row(vectors)));
                return all.chain(self.turn_matrices()).chain(vectors).collect();
            }
            Self::Unscented(filter) => {
                let NoiseModel { w, v, p0 } = filter.factors();
                let all = [(MatrixName::RootW, w), (MatrixName::RootV, v), (MatrixName::RootP0, p0)];
                let all = all.into_iter().map(|(which, matrix)| (which.into(), matrix.clone()));
                return all.chain(self.turn_matrices()).collect();
            }
            Self::MovingHorizon(estimator) => {
                let NoiseModel { w, v, p0 } = estimator.noise_model();
                let bounds = bounds(estimator);
                let list = DMatrix::from_fn(1, bounds.len(), |_, k| bounds[k].value);
                let all = [(MatrixName::W, w), (MatrixName::V, v), (MatrixName::P0, p0)];
                let all = all.into_iter().map(|(which, matrix)| (which.into(), matrix.clone()));
                let bounds = (!bounds.is_empty()).then_some((ExportedMatrix::Bounds, list));
                return all.chain(bounds).chain(self.turn_matrices()).collect();
            }
            Self::SampledNonlinear(observer) => vec![(MatrixName::L, observer.l())],
            Self::Discrete(observer) => vec![(MatrixName::L, observer.l())],
            Self::Kkl(observer) => return observer.matrices(),
            Self::Extension(_) | Self::Step(_) => Vec::new(),
        };
        all.extend(self.feedthrough().map(|d| (MatrixName::D, d)));
        all.into_iter().map(|(which, matrix)| (which.into(), matrix.clone())).collect()
    }

    /// The full turns of the outputs, and of the states where they matter; none without angles.
    pub(crate) fn turns(&self) -> Option<(DVector<f64>, Option<DVector<f64>>)> {
        match self {
            Self::Kalman(filter) => filter.turns().map(|turns| (turns.clone(), None)),
            Self::Unscented(filter) => filter.angles().map(|(outputs, states)| (outputs, Some(states))),
            Self::MovingHorizon(estimator) => estimator.angles().map(|(outputs, states)| (outputs, Some(states))),
            _ => None,
        }
    }

    /// The numbers of the unit vectors that states form; none without.
    pub(crate) fn unit_vectors(&self) -> Option<&DVector<f64>> {
        match self {
            Self::Kalman(filter) => filter.unit_vectors(),
            _ => None,
        }
    }

    /// The turns as matrices of one row.
    fn turn_matrices(&self) -> impl Iterator<Item = (ExportedMatrix, DMatrix<f64>)> {
        let row = |turns: DVector<f64>| DMatrix::from_row_slice(1, turns.len(), turns.as_slice());
        let (outputs, states) = self.turns().map_or((None, None), |(outputs, states)| (Some(outputs), states));
        let outputs = outputs.map(|turns| (MatrixName::Turns.into(), row(turns)));
        outputs.into_iter().chain(states.map(|turns| (MatrixName::StateTurns.into(), row(turns))))
    }

    /// A, B and C of a linear plant.
    pub(crate) fn plant(&self) -> Option<(&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>)> {
        Some(match self {
            Self::Linear(observer) => (&observer.plant().a, &observer.plant().b, &observer.plant().c),
            Self::Cubic(observer) => (observer.ad(), observer.bd(), observer.c()),
            _ => return None,
        })
    }

    /// Feedthrough, if there is one.
    pub fn feedthrough(&self) -> Option<&DMatrix<f64>> {
        match self {
            Self::Linear(observer) => observer.plant().d.as_ref(),
            Self::Cubic(observer) => observer.d(),
            Self::Varying(step) => step.observer().nominal().d(),
            _ => None,
        }
    }

    /// The scalars that the step uses, by the names they have in the emitted code; the period is one of them.
    pub fn scalars(&self) -> Vec<(&'static str, f64)> {
        match self {
            Self::Linear(observer) => vec![("PERIOD", observer.period())],
            Self::Cubic(observer) if observer.coupling().is_some() => vec![("PERIOD", observer.period())],
            Self::Cubic(observer) => vec![("PERIOD", observer.period()), ("W", observer.w())],
            Self::Varying(step) => {
                let nominal = step.observer().nominal();
                let w = nominal.coupling().is_none().then(|| ("W", nominal.w()));
                [("PERIOD", step.period()), ("LONGEST", step.observer().longest())].into_iter().chain(w).collect()
            }
            Self::Kalman(filter) => {
                let gate = filter.gate().map(|gate| ("GATE", gate));
                [("PERIOD", filter.period())].into_iter().chain(gate).collect()
            }
            Self::Unscented(filter) => {
                let weights = filter.weights();
                let numbers = [
                    ("PERIOD", filter.period()),
                    ("DISTANCE", weights.distance),
                    ("OUTER", weights.outer),
                    ("HALF", weights.half),
                    ("CENTRE", weights.centre),
                ];
                numbers.into_iter().chain(filter.gate().map(|gate| ("GATE", gate))).collect()
            }
            Self::MovingHorizon(estimator) => vec![("PERIOD", estimator.period())],
            Self::SampledNonlinear(observer) => vec![("PERIOD", observer.period())],
            Self::Discrete(observer) => vec![("PERIOD", observer.period())],
            Self::Kkl(observer) => vec![("PERIOD", observer.period())],
            Self::Extension(observer) => vec![("PERIOD", observer.period())],
            Self::Step(observer) => vec![("PERIOD", observer.period())],
        }
    }

    /// The step of an observer at varying periods, with the time as a further input.
    ///
    /// # Errors
    /// [`ObserverError`] is not expected of an observer that was made.
    pub fn varying(observer: &VaryingPeriodObserver<f64, Dyn, Dyn, Dyn>) -> Result<Self, ObserverError> {
        let with_time = |name: MatrixName, m: &DMatrix<f64>| {
            if name.is_of_inputs() { m.clone().insert_column(m.ncols(), 0.0) } else { m.clone() }
        };
        let observer: VaryingPeriodObserver<f64, Dyn, Dyn, Dyn> = observer.map(with_time)?;
        Ok(Self::Varying(VaryingPeriodStep::new(observer)?))
    }

    /// Whether the time since the last step is the last input.
    pub fn takes_time(&self) -> bool {
        matches!(self, Self::Varying(_))
    }

    /// The number of inputs of the plant.
    pub fn plant_inputs(&self) -> usize {
        self.dimensions().inputs - usize::from(self.takes_time())
    }

    /// Substeps of the prediction over a varying time, as the format computes them.
    pub(crate) fn prediction_substeps(&self, scalar: Scalar) -> usize {
        let Self::Varying(step) = self else { return 1 };
        let substeps = match scalar {
            Scalar::Binary32 => step.observer().cast::<f32>().map(|same| same.substeps()),
            Scalar::Binary64 => Ok(step.observer().substeps()),
        };
        // The cast has been checked.
        substeps.unwrap_or(1)
    }

    /// Checks that the format can store every number, and that the rounded ones still make an observer.
    pub(crate) fn check(&self, scalar: Scalar) -> Result<(), ExportError> {
        let prediction = match self {
            Self::Kalman(filter) => Some(filter.prediction()),
            Self::Unscented(filter) => Some(filter.prediction()),
            Self::MovingHorizon(estimator) => Some(estimator.prediction()),
            _ => None,
        };
        if prediction == Some(Prediction::ErrorControlled) {
            return Err(ExportError::ErrorControlled);
        }
        for (which, matrix) in self.matrices() {
            if let Some(k) = matrix.iter().position(|x| !scalar.round(*x).is_finite()) {
                let (row, column) = (k % matrix.nrows(), k / matrix.nrows());
                let what = format!("{}({}, {}) = {}", which.name(), row + 1, column + 1, matrix[(row, column)]);
                return Err(ExportError::Format { what, format: scalar.name() });
            }
        }
        for (name, x) in self.scalars() {
            if !scalar.round(x).is_finite() {
                return Err(ExportError::Format { what: format!("{name} = {x}"), format: scalar.name() });
            }
        }
        if let Self::Kkl(observer) = self {
            for (name, tree) in observer.trees() {
                if tree.numbers(scalar).any(|x| !x.is_finite()) {
                    let what = format!("a number of the tree {name:?}");
                    return Err(ExportError::Format { what, format: scalar.name() });
                }
            }
            let coefficients = observer.table(scalar).map(|table| table.coefficients);
            if coefficients.iter().flatten().any(|x| !scalar.round(*x).is_finite()) {
                let what = "a number of the table of the left inverse".to_owned();
                return Err(ExportError::Format { what, format: scalar.name() });
            }
        }
        if let Some(maps) = self.maps() {
            if let Some(x) = maps.routines().flat_map(Routine::constants).find(|x| !scalar.round(*x).is_finite()) {
                let what = format!("the constant {x} of the plant");
                return Err(ExportError::Format { what, format: scalar.name() });
            }
            for (_, table, _) in maps.routines().flat_map(Routine::used_tables) {
                let (x, ..) = table.points();
                if let Some((a, b)) =
                    x.iter().zip(x.iter().skip(1)).find(|(a, b)| scalar.round(**a) >= scalar.round(**b))
                {
                    let what = format!("the distance of the points {a} and {b} of a lookup table");
                    return Err(ExportError::Format { what, format: scalar.name() });
                }
            }
        }
        let checked = match scalar {
            Scalar::Binary32 => self.cast::<f32>().map(|_| ()),
            Scalar::Binary64 => Ok(()),
        };
        checked.map_err(|error| ExportError::Rounded { format: scalar.name(), error })
    }

    /// The observer over the scalar `T`.
    pub(crate) fn cast<T: RealField + Copy>(&self) -> Result<Cast<T>, ObserverError> {
        Ok(match self {
            Self::Linear(observer) => Cast::new(Sampled(observer.cast::<T>()?), None),
            Self::Cubic(observer) => Cast::new(Sampled(observer.cast::<T>()?), None),
            Self::Varying(step) => Cast::new(Sampled(VaryingPeriodStep::new(step.observer().cast::<T>()?)?), None),
            Self::Kalman(filter) => {
                let plant = filter.plant();
                Cast::filter(filter.cast::<T, _>(plant.clone())?, plant.routines().h)
            }
            Self::Unscented(filter) => {
                let plant = filter.plant();
                Cast::filter(filter.cast::<T, _>(plant.clone())?, plant.routines().h)
            }
            Self::MovingHorizon(estimator) => {
                Cast::new(Sampled(moving_horizon::cast(estimator)?), Some(estimator.plant().routines().h))
            }
            Self::SampledNonlinear(observer) => {
                let plant = observer.plant();
                Cast::new(Sampled(observer.cast::<T, _>(plant.clone())?), Some(plant.routines().h))
            }
            Self::Discrete(observer) => {
                let plant = observer.plant();
                Cast::new(Sampled(observer.cast::<T, _>(plant.clone())?), Some(plant.routines().h))
            }
            Self::Kkl(observer) => Cast::new(observer.cast()?, Some(observer.plant().routines().h)),
            Self::Extension(observer) => {
                let (plant, own) = (observer.plant().clone(), observer.observer().clone());
                let period = nalgebra::convert(observer.period());
                let same = SampledExtension::new(plant, own, period, observer.substeps())?;
                Cast::new(Sampled(same), Some(observer.plant().routines().h))
            }
            Self::Step(observer) => {
                let (_, output) = observer.routines();
                Cast::new(Sampled(observer.cast(nalgebra::convert(observer.period()))?), Some(output))
            }
        })
    }
}
