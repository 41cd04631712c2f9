//! The observers that can be exported, and their steps in the format of the target.

use luenberger_expression::{ExpressionPlant, Lookups, Routine, Routines, Table};
use luenberger_observers::{
    DiscreteLinearObserver, DiscreteNonlinearObserver, ExtendedKalmanFilter, GaussianEstimate, InterSampleObserver,
    NoiseModel, Observer, ObserverDimensions, ObserverError, SampledCubicGains, SampledCubicObserver,
    SampledNonlinearObserver, SampledObserver, SquareRootEstimate, UnscentedKalmanFilter, VaryingPeriodObserver,
    VaryingPeriodStep,
};
use luenberger_plants::{Column, LinearPlant};
use nalgebra::{DMatrix, DVector, Dyn, RealField};

use crate::error::ExportError;
use crate::extension::{ExtensionMaps, SampledExtension};
use crate::kkl::Kkl;
use crate::moving_horizon::{self, MovingHorizon, bounds};
use crate::scalar::Scalar;
use crate::step::ExpressionStep;

/// An observer that is stepped once per sample, with numbers as designed.
#[derive(Debug, Clone, PartialEq)]
pub enum ExportableObserver {
    /// `xhat+ = Ad xhat + Bd u + Ld (y - C xhat)`.
    Linear(DiscreteLinearObserver<f64, Dyn, Dyn, Dyn>),
    /// The sampled cubic observer.
    Cubic(SampledCubicObserver<f64, Dyn, Dyn, Dyn>),
    /// The sampled cubic observer at varying periods; the last input is the time since the last step.
    Varying(VaryingPeriodStep<f64, Dyn, Dyn, Dyn>),
    /// The extended Kalman filter.
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
    /// An observer of expressions.
    Extension(SampledExtension<f64>),
    /// An observer whose step is given by expressions.
    Step(ExpressionStep<f64>),
}

/// The right-hand sides of a nonlinear plant in the form in which an observer needs them.
#[derive(Debug, Clone)]
pub(crate) struct Maps {
    /// f, for the extended Kalman filter with Df after it, row by row.
    pub(crate) motion: Routine,
    /// h, and Dh after it, row by row, but for the copy in discrete time.
    pub(crate) measurement: Routine,
    /// The observer itself, where it is of expressions.
    pub(crate) extension: Option<ExtensionMaps>,
}

impl Maps {
    /// Whether they call elementary functions.
    pub(crate) fn calls_functions(&self) -> bool {
        self.routines().any(|routine| !routine.functions().is_empty())
    }

    /// All of them.
    pub(crate) fn routines(&self) -> impl Iterator<Item = &Routine> + Clone {
        let own = self.extension.iter().flat_map(ExtensionMaps::all);
        [&self.motion, &self.measurement].into_iter().chain(own)
    }
}

fn has_tables(routine: &Routine) -> bool {
    routine.used_tables().next().is_some()
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
        match self {
            Self::Linear(observer) => observer.dimensions(),
            Self::Cubic(observer) => observer.dimensions(),
            Self::Varying(step) => step.dimensions(),
            Self::Kalman(observer) => observer.dimensions(),
            Self::Unscented(observer) => observer.dimensions(),
            Self::MovingHorizon(estimator) => estimator.dimensions(),
            Self::SampledNonlinear(observer) => observer.dimensions(),
            Self::Discrete(observer) => observer.dimensions(),
            Self::Kkl(observer) => observer.dimensions(),
            Self::Extension(observer) => observer.dimensions(),
            Self::Step(observer) => observer.dimensions(),
        }
    }

    /// The observer itself as straight-line code, where it is of expressions.
    pub(crate) fn extension(&self) -> Option<ExtensionMaps> {
        if let Self::Extension(observer) = self { Some(observer.observer().routines()) } else { None }
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
            Self::Step(observer) => Some(observer.flow().routines()),
        }
    }

    /// Those that the step needs.
    pub(crate) fn maps(&self) -> Option<Maps> {
        let all = self.routines()?;
        let (motion, measurement) = match self {
            Self::Kalman(_) | Self::MovingHorizon(_) => (all.motion, all.measurement),
            Self::Discrete(_) | Self::Kkl(_) | Self::Unscented(_) | Self::Step(_) => (all.f, all.h),
            _ => (all.f, all.measurement),
        };
        Some(Maps { motion, measurement, extension: self.extension() })
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

    /// Runge-Kutta steps between two samples, if there are any.
    pub(crate) fn substeps(&self) -> Option<usize> {
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
        match self {
            Self::Linear(observer) => observer.period(),
            Self::Cubic(observer) => observer.period(),
            Self::Varying(step) => step.period(),
            Self::Kalman(filter) => filter.period(),
            Self::Unscented(filter) => filter.period(),
            Self::MovingHorizon(estimator) => estimator.period(),
            Self::SampledNonlinear(observer) => observer.period(),
            Self::Discrete(observer) => observer.period(),
            Self::Kkl(observer) => observer.period(),
            Self::Extension(observer) => observer.period(),
            Self::Step(observer) => observer.period(),
        }
    }

    /// Samples in the window of a moving-horizon estimator; 0 of the others.
    pub(crate) fn window(&self) -> usize {
        if let Self::MovingHorizon(estimator) = self { estimator.horizon().window } else { 0 }
    }

    /// The factor of the process noise that enters before and after a motion in continuous time, as it is computed in
    /// the format; of an unscented filter.
    pub(crate) fn half_step_factor(&self, scalar: Scalar) -> f64 {
        match scalar {
            Scalar::Binary32 => f64::from((self.period() as f32 * 0.5).sqrt()),
            Scalar::Binary64 => (self.period() * 0.5).sqrt(),
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

    /// The matrices that the step uses, by the names they have in the emitted code.
    pub fn matrices(&self) -> Vec<(&'static str, DMatrix<f64>)> {
        let mut all = match self {
            Self::Linear(observer) => {
                let plant = observer.plant();
                vec![("A", &plant.a), ("B", &plant.b), ("C", &plant.c), ("L", observer.l())]
            }
            Self::Cubic(observer) => vec![
                ("A", observer.ad()),
                ("B", observer.bd()),
                ("C", observer.c()),
                ("L", observer.ld()),
                ("N", observer.n()),
                ("THETA", observer.theta()),
            ]
            .into_iter()
            .chain(observer.coupling().map(|coupling| ("G", coupling)))
            .collect(),
            Self::Varying(step) => {
                let (observer, nominal) = (step.observer(), step.observer().nominal());
                let gains = [("GAIN", observer.k()), ("N", nominal.n()), ("THETA", nominal.theta())];
                [("A", observer.a()), ("B", observer.b()), ("C", nominal.c())]
                    .into_iter()
                    .chain(gains)
                    .chain(nominal.coupling().map(|coupling| ("G", coupling)))
                    .collect()
            }
            Self::Kalman(filter) => {
                let NoiseModel { w, v, p0 } = filter.noise_model();
                vec![("W", w), ("V", v), ("P0", p0)]
            }
            Self::Unscented(filter) => {
                let NoiseModel { w, v, p0 } = filter.factors();
                vec![("ROOT_W", w), ("ROOT_V", v), ("ROOT_P0", p0)]
            }
            Self::MovingHorizon(estimator) => {
                let NoiseModel { w, v, p0 } = estimator.noise_model();
                let bounds = bounds(estimator);
                let list = DMatrix::from_fn(1, bounds.len(), |_, k| bounds[k].value);
                let all = [("W", w.clone()), ("V", v.clone()), ("P0", p0.clone())];
                return all.into_iter().chain((!bounds.is_empty()).then_some(("BOUNDS", list))).collect();
            }
            Self::SampledNonlinear(observer) => vec![("L", observer.l())],
            Self::Discrete(observer) => vec![("L", observer.l())],
            Self::Kkl(observer) => return observer.matrices(),
            Self::Extension(_) | Self::Step(_) => Vec::new(),
        };
        all.extend(self.feedthrough().map(|d| ("D", d)));
        all.into_iter().map(|(name, matrix)| (name, matrix.clone())).collect()
    }

    /// A, B and C of a linear plant.
    pub(crate) fn plant(&self) -> Option<(&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>)> {
        Some(match self {
            Self::Linear(observer) => (&observer.plant().a, &observer.plant().b, &observer.plant().c),
            Self::Cubic(observer) => (observer.ad(), observer.bd(), observer.c()),
            Self::Varying(_)
            | Self::Kalman(_)
            | Self::Unscented(_)
            | Self::MovingHorizon(_)
            | Self::SampledNonlinear(_)
            | Self::Discrete(_)
            | Self::Kkl(_)
            | Self::Extension(_)
            | Self::Step(_) => return None,
        })
    }

    /// Feedthrough, if there is one.
    pub fn feedthrough(&self) -> Option<&DMatrix<f64>> {
        match self {
            Self::Linear(observer) => observer.plant().d.as_ref(),
            Self::Cubic(observer) => observer.d(),
            Self::Varying(step) => step.observer().nominal().d(),
            Self::Kalman(_)
            | Self::Unscented(_)
            | Self::MovingHorizon(_)
            | Self::SampledNonlinear(_)
            | Self::Discrete(_)
            | Self::Kkl(_)
            | Self::Extension(_)
            | Self::Step(_) => None,
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
        let with_time = |m: DMatrix<f64>| {
            let columns = m.ncols();
            m.insert_column(columns, 0.0)
        };
        let same = cast_cubic(observer.nominal(), with_time)?;
        let (a, b, k) = (observer.a().clone(), with_time(observer.b().clone()), observer.k().clone());
        let observer = VaryingPeriodObserver::new(same, a, b, k, observer.longest())?;
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
        let substeps = match scalar {
            Scalar::Binary32 => self.cast::<f32>().map(|cast| cast.substeps()),
            Scalar::Binary64 => self.cast::<f64>().map(|cast| cast.substeps()),
        };
        // The cast has been checked.
        substeps.ok().flatten().unwrap_or(1)
    }

    /// Checks that the format can store every number, and that the rounded ones still make an observer.
    pub(crate) fn check(&self, scalar: Scalar) -> Result<(), ExportError> {
        for (name, matrix) in self.matrices() {
            if let Some(k) = matrix.iter().position(|x| !scalar.round(*x).is_finite()) {
                let (row, column) = (k % matrix.nrows(), k / matrix.nrows());
                let what = format!("{name}({}, {}) = {}", row + 1, column + 1, matrix[(row, column)]);
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
            // Tables are numbered within a plant.
            if maps.extension.iter().flat_map(ExtensionMaps::all).any(has_tables) {
                return Err(ExportError::Tables);
            }
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
        let cast = |m: &DMatrix<f64>| m.map(nalgebra::convert::<f64, T>);
        Ok(match self {
            Self::Linear(observer) => {
                let LinearPlant { a, b, c, d } = observer.plant();
                let plant = LinearPlant::new(cast(a), cast(b), cast(c))?;
                let plant = match d {
                    Some(d) => plant.with_feedthrough(cast(d))?,
                    None => plant,
                };
                let period = nalgebra::convert(observer.period());
                Cast::Linear(DiscreteLinearObserver::new(plant, cast(observer.l()), period)?)
            }
            Self::Cubic(observer) => Cast::Cubic(cast_cubic(observer, |m| m)?),
            Self::Varying(step) => {
                let observer = step.observer();
                let (nominal, longest) =
                    (cast_cubic(observer.nominal(), |m| m)?, nalgebra::convert(observer.longest()));
                let (a, b, k) = (cast(observer.a()), cast(observer.b()), cast(observer.k()));
                Cast::Varying(VaryingPeriodStep::new(VaryingPeriodObserver::new(nominal, a, b, k, longest)?)?)
            }
            Self::Kalman(filter) => {
                let (plant, NoiseModel { w, v, p0 }) = (filter.plant().clone(), filter.noise_model());
                let noises = NoiseModel { w: cast(w), v: cast(v), p0: cast(p0) };
                let period = nalgebra::convert(filter.period());
                let same = match filter.substeps() {
                    Some(substeps) => ExtendedKalmanFilter::new(plant, noises, period, substeps)?,
                    None => ExtendedKalmanFilter::discrete(plant, noises, period)?,
                };
                Cast::Kalman(match filter.gate() {
                    Some(gate) => same.with_gate(nalgebra::convert(gate))?,
                    None => same,
                })
            }
            Self::Unscented(filter) => {
                let (plant, NoiseModel { w, v, p0 }) = (filter.plant().clone(), filter.factors());
                let factors = NoiseModel { w: cast(w), v: cast(v), p0: cast(p0) };
                let period = nalgebra::convert(filter.period());
                let (sigma, substeps) = (filter.sigma_points(), filter.substeps());
                let same = UnscentedKalmanFilter::from_factors(plant, factors, sigma, period, substeps)?;
                Cast::Unscented(match filter.gate() {
                    Some(gate) => same.with_gate(nalgebra::convert(gate))?,
                    None => same,
                })
            }
            Self::MovingHorizon(estimator) => Cast::MovingHorizon(moving_horizon::cast(estimator)?),
            Self::SampledNonlinear(observer) => {
                let (plant, l) = (observer.plant().clone(), cast(observer.l()));
                let period = nalgebra::convert(observer.period());
                Cast::SampledNonlinear(SampledNonlinearObserver::new(plant, l, period, observer.substeps())?)
            }
            Self::Kkl(observer) => Cast::Kkl(observer.cast()?),
            Self::Extension(observer) => {
                let (plant, own) = (observer.plant().clone(), observer.observer().clone());
                let period = nalgebra::convert(observer.period());
                Cast::Extension(InterSampleObserver::new(plant, own, period, observer.substeps())?)
            }
            Self::Step(observer) => Cast::Step(observer.cast(nalgebra::convert(observer.period()))?),
            Self::Discrete(observer) => {
                let (plant, l) = (observer.plant().clone(), cast(observer.l()));
                Cast::Discrete(DiscreteNonlinearObserver::new(plant, l, nalgebra::convert(observer.period()))?)
            }
        })
    }
}

/// A sampled cubic observer over the scalar `T`, with other columns for the inputs.
fn cast_cubic<T: RealField + Copy>(
    observer: &SampledCubicObserver<f64, Dyn, Dyn, Dyn>,
    of_inputs: impl Fn(DMatrix<T>) -> DMatrix<T>,
) -> Result<SampledCubicObserver<T, Dyn, Dyn, Dyn>, ObserverError> {
    let cast = |m: &DMatrix<f64>| m.map(nalgebra::convert::<f64, T>);
    let gains = SampledCubicGains {
        ad: cast(observer.ad()),
        bd: of_inputs(cast(observer.bd())),
        c: cast(observer.c()),
        ld: cast(observer.ld()),
        n: cast(observer.n()),
        theta: cast(observer.theta()),
        w: nalgebra::convert(observer.w()),
        period: nalgebra::convert(observer.period()),
    };
    let same = match observer.coupling() {
        Some(coupling) => SampledCubicObserver::semi_implicit(gains, cast(coupling))?,
        None => SampledCubicObserver::new(gains)?,
    };
    match observer.d() {
        Some(d) => same.with_feedthrough(of_inputs(cast(d))),
        None => Ok(same),
    }
}

/// An observer over the scalar of the target.
#[derive(Debug, Clone)]
pub(crate) enum Cast<T: RealField + Copy> {
    Linear(DiscreteLinearObserver<T, Dyn, Dyn, Dyn>),
    Cubic(SampledCubicObserver<T, Dyn, Dyn, Dyn>),
    Varying(VaryingPeriodStep<T, Dyn, Dyn, Dyn>),
    Kalman(ExtendedKalmanFilter<ExpressionPlant, T, Dyn, Dyn, Dyn>),
    Unscented(UnscentedKalmanFilter<ExpressionPlant, T, Dyn, Dyn, Dyn>),
    MovingHorizon(MovingHorizon<T>),
    SampledNonlinear(SampledNonlinearObserver<ExpressionPlant, T, Dyn, Dyn, Dyn>),
    Discrete(DiscreteNonlinearObserver<ExpressionPlant, T, Dyn, Dyn, Dyn>),
    Kkl(Kkl<T>),
    Extension(SampledExtension<T>),
    Step(ExpressionStep<T>),
}

impl<T: RealField + Copy> Cast<T> {
    /// Substeps of the prediction over a varying time.
    pub(crate) fn substeps(&self) -> Option<usize> {
        if let Self::Varying(step) = self { Some(step.observer().substeps()) } else { None }
    }

    /// The state with this estimate.
    pub(crate) fn start(&self, estimate: DVector<T>) -> State<T> {
        match self {
            Self::Linear(_)
            | Self::Cubic(_)
            | Self::Varying(_)
            | Self::SampledNonlinear(_)
            | Self::Discrete(_)
            | Self::Step(_) => State::Estimate(estimate),
            Self::Kkl(observer) => {
                let (z, xhat) = observer.start(&estimate);
                State::Target { z, xhat }
            }
            Self::Extension(observer) => {
                let (u, y) = (DVector::zeros(observer.dimensions().inputs), DVector::zeros(0));
                let joined = observer.initial(T::zero(), &estimate, &u, &y);
                State::Joined { joined, order: Observer::<T>::dimensions(observer.observer()).state }
            }
            Self::Kalman(filter) => State::Gaussian(GaussianEstimate::new(&estimate, &filter.noise_model().p0)),
            Self::Unscented(filter) => State::Root(SquareRootEstimate::new(&estimate, &filter.factors().p0)),
            Self::MovingHorizon(estimator) => {
                let size = estimator.dimensions();
                let (u, y) = (DVector::zeros(size.inputs), DVector::zeros(size.outputs));
                State::Window { column: estimator.initial(T::zero(), &estimate, &u, &y), order: size.estimate }
            }
        }
    }

    /// One step from the sample number `sample`, from 0; its time is that many periods.
    pub(crate) fn step(&self, sample: usize, state: &mut State<T>, u: &DVector<T>, y: &DVector<T>) {
        let t = |period: T| nalgebra::convert::<f64, T>(sample as f64) * period;
        match (self, state) {
            (Self::Linear(observer), State::Estimate(xhat)) => observer.step(T::zero(), xhat, u, y),
            (Self::Cubic(observer), State::Estimate(xhat)) => observer.step(T::zero(), xhat, u, y),
            (Self::Varying(step), State::Estimate(xhat)) => step.step(T::zero(), xhat, u, y),
            (Self::SampledNonlinear(observer), State::Estimate(xhat)) => {
                observer.step(t(observer.period()), xhat, u, y);
            }
            (Self::Discrete(observer), State::Estimate(xhat)) => observer.step(t(observer.period()), xhat, u, y),
            (Self::Step(observer), State::Estimate(z)) => observer.step(t(observer.period()), z, u, y),
            (Self::Kkl(observer), State::Target { z, xhat }) => {
                observer.step(t(observer.period_in_format()), (z, xhat), u, y);
            }
            (Self::Extension(observer), State::Joined { joined, .. }) => {
                observer.step(t(observer.period()), joined, u, y);
            }
            (Self::Kalman(filter), State::Gaussian(filtered)) => filter.step(t(filter.period()), filtered, u, y),
            (Self::Unscented(filter), State::Root(filtered)) => filter.step(t(filter.period()), filtered, u, y),
            (Self::MovingHorizon(estimator), State::Window { column, .. }) => {
                estimator.step(t(estimator.period()), column, u, y);
            }
            // `start` made the state.
            _ => {}
        }
    }

    /// h at the estimate, of a nonlinear plant.
    pub(crate) fn output(&self, sample: usize, state: &State<T>, u: &DVector<T>) -> Option<DVector<T>> {
        use luenberger_plants::Plant;
        let (plant, period) = match self {
            Self::Linear(_) | Self::Cubic(_) | Self::Varying(_) => return None,
            Self::Step(observer) => {
                let t = nalgebra::convert::<f64, T>(sample as f64) * observer.period();
                return Some(observer.output(t, &state.estimate()));
            }
            Self::Kalman(filter) => (filter.plant(), filter.period()),
            Self::Unscented(filter) => (filter.plant(), filter.period()),
            Self::MovingHorizon(estimator) => (estimator.plant(), estimator.period()),
            Self::SampledNonlinear(observer) => (observer.plant(), observer.period()),
            Self::Discrete(observer) => (observer.plant(), observer.period()),
            Self::Kkl(observer) => (observer.plant_in_format(), observer.period_in_format()),
            Self::Extension(observer) => (observer.plant(), observer.period()),
        };
        let t = nalgebra::convert::<f64, T>(sample as f64) * period;
        Some(plant.output(t, &state.estimate(), u))
    }
}

/// The state of an observer.
#[derive(Debug, Clone)]
pub(crate) enum State<T: RealField + Copy> {
    Estimate(DVector<T>),
    Gaussian(GaussianEstimate<T, Dyn>),
    Root(SquareRootEstimate<T, Dyn>),
    /// Of a KKL observer, with its estimate.
    Target {
        z: DVector<T>,
        xhat: DVector<T>,
    },
    /// Of a moving-horizon estimator: its estimate of this length, and the window.
    Window {
        column: DVector<T>,
        order: usize,
    },
    /// Of an observer of expressions: its own state of this length, with its estimate behind it.
    Joined {
        joined: DVector<T>,
        order: usize,
    },
}

impl<T: RealField + Copy> State<T> {
    pub(crate) fn estimate(&self) -> DVector<T> {
        match self {
            Self::Estimate(xhat) | Self::Target { xhat, .. } => xhat.clone(),
            Self::Gaussian(filtered) => filtered.estimate(),
            Self::Root(filtered) => filtered.estimate(),
            Self::Window { column, order } => column.rows(0, *order).into_owned(),
            Self::Joined { joined, order } => joined.rows(*order, joined.len() - order).into_owned(),
        }
    }

    /// All numbers.
    pub(crate) fn entries(&self) -> &[T] {
        match self {
            Self::Estimate(xhat) => xhat.as_slice(),
            Self::Gaussian(filtered) => filtered.as_slice(),
            Self::Root(filtered) => filtered.as_slice(),
            Self::Target { z, .. } => z.as_slice(),
            Self::Window { column, .. } => column.as_slice(),
            Self::Joined { joined, .. } => joined.as_slice(),
        }
    }
}
