//! The observers of a study as one type for simulation.

mod kkl;

use std::sync::Arc;

use luenberger_design::{DesignError, OperatingPoint, Periods};
use luenberger_export::moving_horizon::LONGEST_WINDOW;
use luenberger_observers::high_gain::{ChainPosition, HighGainMap};
use luenberger_observers::{
    CubicObserver, DeviationObserver, DiscreteLinearObserver, DiscreteNonlinearObserver, ExtendedKalmanFilter,
    FunctionalObserver, HighGainObserver, ImmersionInvarianceObserver, Integral, IntervalObserver, KklObserver,
    KklPebObserver, LinearInverse, LinearKkl, LinearObserver, MeanValueObserver, MovingHorizonEstimator,
    NonlinearLuenbergerObserver, Observer, ObserverDimensions, ProportionalIntegralObserver, SampledCubicObserver,
    SampledIntervalObserver, SampledObserver, SlidingModeObserver, StationaryKalmanFilter, UnknownInputObserver,
    UnscentedKalmanFilter, VaryingPeriodObserver,
};
use luenberger_plants::{Plant, state_jacobian};
use luenberger_sim::{AnyObserver, Continuous, Replay, SampleTimes, Sampled, Scenario};
use nalgebra::{DMatrix, DVector, Dyn};

use crate::maps::high_gain::place;
use crate::maps::{Estimator, HighGainMaps, ImmersionMaps, KklMaps, RegressionMaps};
use crate::model::Model;
use crate::study::{PrintedMean, SamplingSpec};
pub use kkl::Kkl;

/// An observer of the deviations from an operating point.
pub type At<O> = DeviationObserver<O, f64, Dyn, Dyn, Dyn>;

/// An observer of the state and of a disturbance.
pub type WithDisturbance<O> = ProportionalIntegralObserver<O, Dyn>;

/// An observer whose error does not depend on a disturbance.
pub type WithoutDisturbance<O> = UnknownInputObserver<O, f64, Dyn, Dyn, Dyn>;

/// An observer of what the outputs leave open.
pub(crate) type ReducedOrder = KklObserver<LinearKkl<f64, Dyn, Dyn, Dyn, Dyn, LinearInverse<f64, Dyn, Dyn, Dyn>>>;

/// An observer of upper and lower bounds.
pub(crate) type Enclosing = IntervalObserver<LinearObserver<f64, Dyn, Dyn, Dyn>, f64, Dyn, Dyn, Dyn>;

/// An observer at varying periods, ready to run; in deviations from an operating point, which is 0 for a linear plant.
#[derive(Debug, Clone)]
pub struct VaryingPeriods {
    /// The observer, which a simulation corrects at the samples that it draws, and a log at its rows.
    pub observer: Box<At<VaryingPeriodObserver<f64, Dyn, Dyn, Dyn>>>,
    /// The periods for which convergence is proved.
    pub periods: Periods,
}

impl VaryingPeriods {
    pub(crate) fn new(
        observer: VaryingPeriodObserver<f64, Dyn, Dyn, Dyn>,
        periods: Periods,
        point: [&DVector<f64>; 3],
    ) -> Result<Self, DesignError> {
        let [x, u, y] = point.map(DVector::clone);
        let observer = DeviationObserver::new(observer, x, u, y)?;
        Ok(Self { observer: Box::new(observer), periods })
    }

    /// The same observer in deviations from an operating point.
    pub(crate) fn at(&self, point: &OperatingPoint) -> Result<Self, DesignError> {
        Self::new(self.observer.inner().clone(), self.periods, [&point.x, &point.u, &point.y])
    }

    /// How the samples of a simulation are drawn.
    pub fn sample_times(&self, sampling: &SamplingSpec) -> SampleTimes {
        let (shortest, longest) = sampling.jitter.unwrap_or((self.periods.shortest, self.periods.longest));
        SampleTimes { shortest, longest, misses: sampling.misses.unwrap_or(self.periods.misses), seed: sampling.seed }
    }
}

/// An observer, ready to run.
#[derive(Debug, Clone)]
pub enum Runnable {
    /// Luenberger observer, or stationary Kalman filter.
    Linear(Box<LinearObserver<f64, Dyn, Dyn, Dyn>>),
    /// Cubic observer.
    Cubic(Box<CubicObserver<f64, Dyn, Dyn, Dyn>>),
    /// Observer of the state and of a disturbance, linear.
    ProportionalIntegral(Box<WithDisturbance<LinearObserver<f64, Dyn, Dyn, Dyn>>>),
    /// The same with a cubic term.
    ProportionalIntegralCubic(Box<WithDisturbance<CubicObserver<f64, Dyn, Dyn, Dyn>>>),
    /// Unknown-input observer, linear.
    UnknownInput(Box<WithoutDisturbance<LinearObserver<f64, Dyn, Dyn, Dyn>>>),
    /// The same with a cubic term.
    UnknownInputCubic(Box<WithoutDisturbance<CubicObserver<f64, Dyn, Dyn, Dyn>>>),
    /// Interval observer.
    Interval(Box<Enclosing>),
    /// The same for samples.
    SampledInterval(Box<SampledIntervalObserver<f64, Dyn, Dyn, Dyn, Dyn, Dyn>>),
    /// Sliding-mode observer.
    SlidingMode(Box<SlidingModeObserver<Model, f64, Dyn, Dyn, Dyn>>),
    /// Sampled cubic observer.
    SampledCubic(Box<SampledCubicObserver<f64, Dyn, Dyn, Dyn>>),
    /// Sampled cubic observer at varying periods.
    VaryingPeriods(Box<VaryingPeriods>),
    /// Luenberger observer, or stationary Kalman predictor, in discrete time.
    DiscreteLinear(Box<DiscreteLinearObserver<f64, Dyn, Dyn, Dyn>>),
    /// Stationary Kalman filter in discrete time, in filter form.
    StationaryKalman(Box<StationaryKalmanFilter<f64, Dyn, Dyn, Dyn>>),
    /// Copy of a plant in discrete time with output injection.
    DiscreteNonlinear(Box<DiscreteNonlinearObserver<Model, f64, Dyn, Dyn, Dyn>>),
    /// Luenberger observer of the linearisation at an operating point.
    LinearAt(Box<At<LinearObserver<f64, Dyn, Dyn, Dyn>>>),
    /// Cubic observer, likewise.
    CubicAt(Box<At<CubicObserver<f64, Dyn, Dyn, Dyn>>>),
    /// Sampled cubic observer, likewise.
    SampledCubicAt(Box<At<SampledCubicObserver<f64, Dyn, Dyn, Dyn>>>),
    /// Copy of the plant with output injection.
    NonlinearLuenberger(Box<NonlinearLuenbergerObserver<Model, f64, Dyn, Dyn, Dyn>>),
    /// Mean-value-theorem observer.
    MeanValue(Box<MeanValueObserver<Model, Integral, f64, Dyn, Dyn, Dyn>>),
    /// Mean-value-theorem observer as printed.
    PrintedMeanValue(Box<MeanValueObserver<Model, PrintedMean, f64, Dyn, Dyn, Dyn>>),
    /// High-gain observer for a plant of integrator chains.
    HighGain(Box<HighGainObserver<Chains, f64, Dyn>>),
    /// High-gain observer with given maps.
    HighGainMaps(Box<HighGainObserver<HighGainMaps, f64, Dyn>>),
    /// Extended Kalman filter.
    ExtendedKalman(Box<ExtendedKalmanFilter<Model, f64, Dyn, Dyn, Dyn>>),
    /// Unscented Kalman filter.
    Unscented(Box<UnscentedKalmanFilter<Model, f64, Dyn, Dyn, Dyn>>),
    /// Moving-horizon estimator.
    MovingHorizon(Box<MovingHorizonEstimator<Model, f64, Dyn, Dyn, Dyn, Dyn, LONGEST_WINDOW>>),
    /// Functional observer, with K of z = K x.
    Functional(Box<FunctionalObserver<f64, Dyn, Dyn, Dyn>>, DMatrix<f64>),
    /// Reduced-order observer.
    ReducedOrder(Box<ReducedOrder>),
    /// KKL observer with given maps.
    KklMaps(Box<KklObserver<KklMaps>>),
    /// PEBO or [KKL+PEB] observer with given maps.
    Peb(Box<KklPebObserver<RegressionMaps, Estimator, f64>>),
    /// Immersion-and-invariance observer with given maps.
    Immersion(Box<ImmersionInvarianceObserver<Model, ImmersionMaps>>),
    /// Numerical KKL observer.
    Kkl(Box<Kkl>),
}

fn continuous<'a>(observer: &'a (impl Observer<f64> + Sync)) -> Arc<dyn AnyObserver + 'a> {
    Arc::new(Continuous::new(observer))
}

fn sampled<'a>(observer: &'a (impl SampledObserver<f64> + Sync)) -> Arc<dyn AnyObserver + 'a> {
    Arc::new(Sampled(observer))
}

impl Runnable {
    /// The scenario with this observer added; the samples of one at varying periods are those of its design, with the
    /// seed 0.
    pub fn join<'a>(&'a self, scenario: Scenario<'a>, name: &str, initial: &[f64]) -> Scenario<'a> {
        self.join_sampled(scenario, name, initial, &SamplingSpec::default())
    }

    /// The same; an observer at varying periods has the samples of `sampling`.
    pub fn join_sampled<'a>(
        &'a self,
        scenario: Scenario<'a>,
        name: &str,
        initial: &[f64],
        sampling: &SamplingSpec,
    ) -> Scenario<'a> {
        if let Self::Functional(observer, k) = self {
            let first = k * DVector::from_column_slice(initial);
            return scenario.functional_observer(name, observer.as_ref(), first.as_slice(), k);
        }
        if let Self::VaryingPeriods(varying) = self {
            let times = varying.sample_times(sampling);
            return scenario.continuous_discrete_observer(name, varying.observer.as_ref(), times, initial);
        }
        scenario.any_observer(name, self.any(), initial)
    }

    /// The replay of a log with this observer added, one at varying periods at the times of its rows.
    pub fn replay<'a>(&'a self, replay: Replay<'a>, name: &str, initial: &[f64]) -> Replay<'a> {
        match self {
            // As filters they also record their covariances.
            Self::ExtendedKalman(filter) => replay.filter(name, filter.as_ref().clone(), initial),
            Self::Unscented(filter) => replay.filter(name, filter.as_ref().clone(), initial),
            Self::MovingHorizon(filter) => {
                // Rows that measure nothing are no samples of the window.
                let filter = filter.as_ref().clone();
                replay.filter(name, filter.clone().with_joined_predictions().unwrap_or(filter), initial)
            }
            Self::VaryingPeriods(varying) => replay.corrected_observer(name, varying.observer.as_ref(), initial),
            _ => replay.any_observer(name, self.any(), initial),
        }
    }

    /// The same, with smoothed estimates of an extended or unscented Kalman filter as well.
    pub fn replay_smoothed<'a>(&'a self, replay: Replay<'a>, name: &str, initial: &[f64]) -> Replay<'a> {
        match self {
            Self::ExtendedKalman(filter) => replay.smoothed_filter(name, filter.as_ref().clone(), initial),
            Self::Unscented(filter) => replay.smoothed_filter(name, filter.as_ref().clone(), initial),
            _ => self.replay(replay, name, initial),
        }
    }

    /// The sampling period; none in continuous time, and for an observer that predicts between its samples.
    pub fn period(&self) -> Option<f64> {
        self.any().period()
    }

    /// The entries of the state that gives this estimate at time `t`; none for slices of the wrong length.
    pub fn initial(&self, t: f64, estimate: &[f64], u: &[f64], y: &[f64]) -> Option<Vec<f64>> {
        let observer = self.any();
        let size = observer.dimensions();
        (estimate.len() == size.estimate && takes(size, u, y)).then(|| {
            let mut state = vec![0.0; size.state];
            observer.initial(t, estimate, u, y, &mut state);
            state
        })
    }

    /// The derivative of the state; for samples the next state. None for slices of the wrong length.
    ///
    /// ```
    /// use luenberger_study::{Format, Study, design::design, template};
    /// use std::sync::atomic::AtomicBool;
    /// let text = template::text("double-integrator").ok_or("a template")?;
    /// let study = Study::from_text("study.toml", text, Format::Toml, ".".as_ref())?;
    /// let designed = design(&study, &study.observers[0], &AtomicBool::new(false)).map_err(|why| format!("{why:?}"))?;
    /// // At rest, with the output that the estimate predicts.
    /// assert_eq!(designed.runnable.motion(0.0, &[1.0, 0.0], &[0.0], &[1.0]), Some(vec![0.0, 0.0]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn motion(&self, t: f64, state: &[f64], u: &[f64], y: &[f64]) -> Option<Vec<f64>> {
        let observer = self.any();
        let size = observer.dimensions();
        (state.len() == size.state && takes(size, u, y)).then(|| {
            let mut motion = state.to_vec();
            match observer.period() {
                None => observer.derivative(t, state, u, y, &mut motion),
                Some(_) => observer.step(t, &mut motion, u, y, &[]),
            }
            motion
        })
    }

    /// The estimate of a state; none for slices of the wrong length.
    pub fn estimate(&self, t: f64, state: &[f64], u: &[f64], y: &[f64]) -> Option<Vec<f64>> {
        let observer = self.any();
        let size = observer.dimensions();
        (state.len() == size.state && takes(size, u, y)).then(|| {
            let mut estimate = vec![0.0; size.estimate];
            observer.estimate(t, state, u, y, &mut estimate);
            estimate
        })
    }

    /// The estimates of the disturbance, of an observer that has some, from its states (a row for each time).
    pub fn disturbance(&self, states: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        match self {
            Self::ProportionalIntegral(_) | Self::ProportionalIntegralCubic(_) => {
                let first = self.dimensions().estimate;
                Some(states.columns(first, states.ncols().checked_sub(first)?).into_owned())
            }
            _ => None,
        }
    }

    /// The half-widths of the bounds of an interval observer, from its states (a row for each time).
    pub fn half_widths(&self, states: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let widths = |row: &[f64]| match self {
            Self::Interval(observer) => Some(observer.half_widths(row)),
            Self::SampledInterval(observer) => Some(observer.half_widths(row)),
            _ => None,
        };
        let rows: Option<Vec<_>> = states
            .row_iter()
            .map(|row| widths(&row.iter().copied().collect::<Vec<_>>()).map(|widths| widths.transpose()))
            .collect();
        let rows = rows?;
        if rows.is_empty() { None } else { Some(DMatrix::from_rows(&rows)) }
    }

    /// Lengths of its columns.
    pub fn dimensions(&self) -> ObserverDimensions {
        self.any().dimensions()
    }

    /// The observer as one that is simulated, whatever its kind.
    fn any(&self) -> Arc<dyn AnyObserver + '_> {
        match self {
            Self::Linear(observer) => continuous(observer.as_ref()),
            Self::Cubic(observer) => continuous(observer.as_ref()),
            Self::ProportionalIntegral(observer) => continuous(observer.as_ref()),
            Self::ProportionalIntegralCubic(observer) => continuous(observer.as_ref()),
            Self::UnknownInput(observer) => continuous(observer.as_ref()),
            Self::UnknownInputCubic(observer) => continuous(observer.as_ref()),
            Self::Interval(observer) => continuous(observer.as_ref()),
            Self::LinearAt(observer) => continuous(observer.as_ref()),
            Self::CubicAt(observer) => continuous(observer.as_ref()),
            Self::NonlinearLuenberger(observer) => continuous(observer.as_ref()),
            Self::MeanValue(observer) => continuous(observer.as_ref()),
            Self::PrintedMeanValue(observer) => continuous(observer.as_ref()),
            Self::HighGain(observer) => continuous(observer.as_ref()),
            Self::HighGainMaps(observer) => continuous(observer.as_ref()),
            Self::ReducedOrder(observer) => continuous(observer.as_ref()),
            Self::KklMaps(observer) => continuous(observer.as_ref()),
            Self::Peb(observer) => continuous(observer.as_ref()),
            Self::Immersion(observer) => continuous(observer.as_ref()),
            Self::Functional(observer, _) => continuous(observer.as_ref()),
            Self::VaryingPeriods(varying) => continuous(varying.observer.as_ref()),
            Self::Kkl(observer) => observer.any(),
            Self::SampledInterval(observer) => sampled(observer.as_ref()),
            Self::SlidingMode(observer) => sampled(observer.as_ref()),
            Self::SampledCubic(observer) => sampled(observer.as_ref()),
            Self::SampledCubicAt(observer) => sampled(observer.as_ref()),
            Self::DiscreteLinear(observer) => sampled(observer.as_ref()),
            Self::StationaryKalman(observer) => sampled(observer.as_ref()),
            Self::DiscreteNonlinear(observer) => sampled(observer.as_ref()),
            Self::ExtendedKalman(observer) => sampled(observer.as_ref()),
            Self::Unscented(observer) => sampled(observer.as_ref()),
            Self::MovingHorizon(observer) => sampled(observer.as_ref()),
        }
    }
}

/// Whether inputs and outputs have these lengths.
fn takes(size: ObserverDimensions, u: &[f64], y: &[f64]) -> bool {
    u.len() == size.inputs && y.len() == size.outputs
}

/// A plant in triangular form: chain k has `lengths[k]` consecutive states, the first of which is output k.
///
/// In a pure chain of integrators each state is the derivative of the one before it. Here it enters with the
/// coefficient `c_i = df_i/dx_(i+1)`, taken at the first estimate and the first input; the correction of a state is
/// divided by the product of the coefficients before it, so that the error has the poles of a pure chain there.
#[derive(Debug, Clone)]
pub struct Chains {
    pub(crate) model: Model,
    pub(crate) lengths: Vec<usize>,
    /// `1 / (c_1 ... c_(i-1))` within each chain.
    shape: DVector<f64>,
    /// Whether every c_i is a constant.
    constant: bool,
}

impl Chains {
    /// The chains with the coefficients at `estimate` and `input`.
    ///
    /// # Errors
    /// The state (from 0) whose coefficient is 0 or not finite there, with the coefficient.
    pub(crate) fn at(
        model: &Model,
        lengths: &[usize],
        estimate: &[f64],
        input: &DVector<f64>,
    ) -> Result<Self, (usize, f64)> {
        let x = DVector::from_column_slice(estimate);
        let jacobian = state_jacobian(model, 0.0, &x, input);
        let structure = model.structure();
        let mut shape = DVector::repeat(x.len(), 1.0);
        let mut constant = true;
        let mut head = 0;
        for length in lengths {
            for i in head..(head + length).saturating_sub(1) {
                let coefficient = jacobian[(i, i + 1)];
                let next = shape[i] / coefficient;
                if next == 0.0 || !next.is_finite() {
                    return Err((i, coefficient));
                }
                shape[i + 1] = next;
                constant &= structure.has_constant_factor(i, i + 1);
            }
            head += length;
        }
        Ok(Self { model: model.clone(), lengths: lengths.to_vec(), shape, constant })
    }

    /// Whether no coefficient depends on the state, the input or the time: then the factors are right everywhere.
    pub(crate) fn have_constant_coefficients(&self) -> bool {
        self.constant
    }

    /// The factors of the corrections.
    pub(crate) fn factors(&self) -> &DVector<f64> {
        &self.shape
    }
}

impl HighGainMap<f64> for Chains {
    type Xi = Dyn;
    type Inputs = Dyn;
    type Outputs = Dyn;
    type Estimate = Dyn;

    fn dimensions(&self) -> ObserverDimensions {
        let size = self.model.size();
        ObserverDimensions { state: size.states, inputs: size.inputs, outputs: size.outputs, estimate: size.states }
    }

    fn place(&self, i: usize) -> ChainPosition {
        place(&self.lengths, i)
    }

    fn drift(&self, t: f64, xi: &DVector<f64>, u: &DVector<f64>, _y: &DVector<f64>) -> DVector<f64> {
        self.model.derivative(t, xi, u)
    }

    fn shape(&self, _t: f64, _u: &DVector<f64>, _y: &DVector<f64>) -> DVector<f64> {
        self.shape.clone()
    }

    fn estimate(&self, _t: f64, xi: &DVector<f64>, _u: &DVector<f64>, _y: &DVector<f64>) -> DVector<f64> {
        xi.clone()
    }

    fn start(&self, _t: f64, estimate: &DVector<f64>, _u: &DVector<f64>, _y: &DVector<f64>) -> DVector<f64> {
        estimate.clone()
    }
}
