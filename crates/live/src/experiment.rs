//! What a report embeds: a plant, an experiment with it, and observers as designed.

use std::collections::BTreeMap;

use luenberger_expression::{Extrapolation, LookupTable};
use luenberger_observers::{
    CubicObserver, DiscreteLinearObserver, LinearObserver, SampledCubicObserver, SampledObserver,
    StationaryKalmanFilter,
};
use nalgebra::{DMatrix, Dyn};
use serde::{Deserialize, Serialize};

use crate::noise::StoredNoise;
use crate::plant::StoredPlant;
use crate::rows::{Rows, rows};
use crate::truth::Truth;

/// A plant, an experiment with it, and observers as designed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// The plant.
    pub plant: StoredPlant,
    /// Names of the states, for the page.
    pub states: Vec<String>,
    /// The units of the states; empty if unknown.
    pub units: Vec<String>,
    /// The unit of the time, if it is known.
    pub time_unit: Option<String>,
    /// An expression of t for each input; empty for u = 0, or with a table.
    pub input: Vec<String>,
    /// The inputs as samples, in the place of expressions.
    pub table: Option<Table>,
    /// A law of the time and the true state, in the place of expressions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<Law>,
    /// What is subtracted from the input; none for an input that is a function of time.
    pub feedback: Option<Feedback>,
    /// The parameters that the expressions use by name.
    pub parameters: BTreeMap<String, f64>,
    /// The lookup tables that the expressions of plants use as functions.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub tables: BTreeMap<String, Lookup>,
    /// The period of a plant in discrete time, `x+ = f(x, u)`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dt: Option<f64>,
    /// The plant as it is simulated, where it differs from the one that the observers are designed for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub truth: Option<Box<Truth>>,
    /// The hold period of the input.
    pub hold: Option<f64>,
    /// x(0).
    pub x0: Vec<f64>,
    /// The end time.
    pub duration: f64,
    /// The number of times that are shown.
    pub samples: usize,
    /// The relative and the absolute tolerance of the integrator.
    pub tolerances: [f64; 2],
    /// The method of integration.
    #[serde(default)]
    pub integrator: Method,
    /// The noise of the outputs.
    pub noise: Option<StoredNoise>,
    /// Sensors with sampling periods of their own, which have the noise of their outputs.
    pub sensors: Vec<Sensor>,
    /// The unit of each state in the norm of the error; none for states that have no norm in common, as metres and
    /// pascals.
    pub scale: Option<Vec<f64>>,
    /// Settled is within this share of the error at the start.
    pub band: f64,
    /// The period of the scores, if it is not that of the observers.
    pub score_period: Option<f64>,
    /// Whether observers in continuous time hold the measurements of sensors, which otherwise move with the model.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub hold_measurements: bool,
    /// Which estimates of filters are scored and shown.
    #[serde(default, skip_serializing_if = "Estimates::are_filtered")]
    pub estimates: Estimates,
    /// The observers.
    pub observers: Vec<StoredObserver>,
}

/// Which estimates of a filter at its samples are meant.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Estimates {
    /// After the measurement of the sample.
    #[default]
    Filtered,
    /// Before the measurement of the sample.
    Predicted,
}

impl Estimates {
    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
    fn are_filtered(&self) -> bool {
        *self == Self::Filtered
    }
}

/// How a run is integrated.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Explicit, implicit once the equations turn out to be stiff.
    #[default]
    Auto,
    /// DOP853.
    Explicit,
    /// Radau IIA.
    Implicit,
}

/// A lookup table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lookup {
    /// Breakpoints.
    pub x: Vec<f64>,
    /// Values; of a table of two variables the breakpoints of the second.
    pub y: Vec<f64>,
    /// Values of a table of two variables, a row for each x; otherwise empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub z: Rows,
    /// Whether it is a monotone cubic; otherwise lines join the points.
    pub cubic: bool,
    /// Whether it goes on along the slopes at the ends; otherwise it holds their values.
    pub extrapolates: bool,
}

impl Lookup {
    /// The table with these points.
    pub fn of(table: &LookupTable) -> Self {
        match table {
            LookupTable::Curve(curve) => {
                let (x, y, slopes) = curve.points();
                let extrapolates = curve.extrapolation() == Extrapolation::Linear;
                Self { x: x.to_vec(), y: y.to_vec(), z: Rows::new(), cubic: slopes.is_some(), extrapolates }
            }
            LookupTable::Surface(surface) => {
                let (x, y, z) = surface.points();
                let z = z.into_iter().map(<[f64]>::to_vec).collect();
                let extrapolates = surface.extrapolation() == Extrapolation::Linear;
                Self { x: x.to_vec(), y: y.to_vec(), z, cubic: false, extrapolates }
            }
        }
    }
}

/// A law of the time and the true state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Law {
    /// An expression for each input.
    pub rows: Vec<String>,
    /// The times at which it jumps.
    pub jumps: Vec<f64>,
}

/// A function of time as samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// The times, increasing.
    pub t: Vec<f64>,
    /// The values, a row for each time.
    pub rows: Rows,
    /// Whether the values between two times are on the line from one to the next; otherwise the earlier one is held.
    pub line: bool,
}

/// Feedback `-K z`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Feedback {
    /// K.
    pub gain: Rows,
    /// Which z.
    pub of: FeedbackSignal,
    /// Added to the input: `u0 + K x0` of an operating point. Empty for nothing.
    pub shift: Vec<f64>,
}

impl Feedback {
    /// `-K xhat` with the estimate of each observer in its own run.
    pub fn of_each_estimate(gain: &DMatrix<f64>) -> Self {
        Self { gain: rows(gain), of: FeedbackSignal::EachEstimate, shift: Vec::new() }
    }
}

/// What is fed back.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum FeedbackSignal {
    /// The estimate of the observer whose run it is.
    EachEstimate,
    /// The estimate of this observer, which takes part in every run.
    Estimate(String),
    /// The state.
    State,
}

/// A sensor that measures an output at instants of its own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sensor {
    /// The output, from 0.
    pub output: usize,
    /// Time between two measurements.
    pub period: f64,
    /// Time of the first one.
    pub offset: f64,
    /// Gaussian if true, otherwise uniform.
    pub gaussian: bool,
    /// Standard deviation or amplitude of the noise.
    pub amplitude: f64,
    /// The seed.
    pub seed: u64,
}

/// An observer as designed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredObserver {
    /// Its name.
    pub name: String,
    /// The initial estimate.
    pub initial: Vec<f64>,
    /// What runs.
    pub kind: ObserverKind,
    /// The operating point of an observer of deviations.
    pub point: Option<OperatingPoint>,
    /// Its certificate files; empty without a certificate, none if a page does not verify them.
    pub certificates: Option<Vec<String>>,
    /// What such a certificate supposes of a run, if sliders change it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hypotheses: Option<Hypotheses>,
}

impl StoredObserver {
    /// An observer without certificate.
    pub fn new(name: &str, kind: ObserverKind, initial: &[f64]) -> Self {
        Self {
            name: name.to_owned(),
            initial: initial.to_vec(),
            kind,
            point: None,
            certificates: Some(Vec::new()),
            hypotheses: None,
        }
    }
}

/// The noise and the first errors that a certificate is for: `|v_i| <= noise_i`, and for the blocks z_k of `z = T(x -
/// xhat)` at the start `|z_k| <= start_k`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hypotheses {
    /// A bound of the noise of each output.
    pub noise: Vec<f64>,
    /// T.
    pub t: Rows,
    /// The numbers of entries of the blocks.
    pub blocks: Vec<usize>,
    /// A bound of the Euclidean norm of each block.
    pub start: Vec<f64>,
}

/// The point of which an observer has the deviations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OperatingPoint {
    /// The state.
    pub x: Vec<f64>,
    /// The input.
    pub u: Vec<f64>,
    /// The output.
    pub y: Vec<f64>,
}

/// What runs as an observer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum ObserverKind {
    /// Luenberger's observer of a linear plant.
    Linear(Box<LinearObserver<f64, Dyn, Dyn, Dyn>>),
    /// The cubic observer.
    Cubic(Box<CubicObserver<f64, Dyn, Dyn, Dyn>>),
    /// The sampled cubic observer, with the matrices A and B of the plant in continuous time.
    SampledCubic {
        /// The observer.
        observer: Box<SampledCubicObserver<f64, Dyn, Dyn, Dyn>>,
        /// A.
        a: Rows,
        /// B.
        b: Rows,
    },
    /// The observer of the state and of a disturbance, linear: of the plant with both as its state.
    ProportionalIntegral {
        /// The observer.
        observer: Box<LinearObserver<f64, Dyn, Dyn, Dyn>>,
    },
    /// The same with a cubic term.
    ProportionalIntegralCubic {
        /// The observer.
        observer: Box<CubicObserver<f64, Dyn, Dyn, Dyn>>,
    },
    /// The same in discrete time, linear.
    ProportionalIntegralDiscrete {
        /// The observer.
        observer: Box<DiscreteLinearObserver<f64, Dyn, Dyn, Dyn>>,
    },
    /// The unknown-input observer, linear.
    UnknownInput {
        /// The observer of the plant (TA, TB, C).
        observer: Box<LinearObserver<f64, Dyn, Dyn, Dyn>>,
        /// H.
        h: Rows,
        /// D, if it is not 0.
        d: Option<Rows>,
    },
    /// The same with a cubic term.
    UnknownInputCubic {
        /// The observer of the plant (TA, TB, C).
        observer: Box<CubicObserver<f64, Dyn, Dyn, Dyn>>,
        /// H.
        h: Rows,
        /// D, if it is not 0.
        d: Option<Rows>,
    },
    /// The interval observer.
    Interval {
        /// The observer of the state.
        observer: Box<LinearObserver<f64, Dyn, Dyn, Dyn>>,
        /// K of the comparison system `rho' = K rho + g`, `|x - xhat| <= H rho`.
        k: Rows,
        /// g.
        g: Vec<f64>,
        /// H.
        h: Rows,
        /// rho at the start.
        start: Vec<f64>,
    },
    /// The sliding-mode observer of a chain of integrators.
    SlidingMode {
        /// The gains k.
        gains: Vec<f64>,
        /// The sampling period.
        period: f64,
        /// Whether the correction is discretised by the explicit Euler method.
        explicit: bool,
    },
    /// Luenberger's observer of a linear plant in discrete time.
    DiscreteLinear(Box<DiscreteLinearObserver<f64, Dyn, Dyn, Dyn>>),
    /// The stationary Kalman filter in discrete time, in filter form.
    StationaryKalman(Box<StationaryKalmanFilter<f64, Dyn, Dyn, Dyn>>),
    /// Luenberger's observer of a nonlinear plant in discrete time.
    #[serde(rename = "discrete-copy")]
    DiscreteNonlinear {
        /// L.
        l: Rows,
        /// The sampling period.
        period: f64,
    },
    /// Luenberger's observer of a nonlinear plant.
    #[serde(rename = "copy")]
    NonlinearLuenberger {
        /// L.
        l: Rows,
    },
    /// The extended Kalman filter; of a linear plant the Kalman filter.
    Kalman {
        /// The intensity W of the process noise.
        w: Rows,
        /// The covariance V of the measurement noise.
        v: Rows,
        /// P(0).
        p0: Rows,
        /// The sampling period.
        period: f64,
        /// Whether the plant is in discrete time; otherwise the prediction controls its error.
        discrete: bool,
        /// Outputs whose innovation is beyond so many standard deviations are rejected.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        gate: Option<f64>,
    },
}

impl ObserverKind {
    /// Whether it has a cubic gain.
    pub(crate) fn is_cubic(&self) -> bool {
        matches!(
            self,
            Self::Cubic(_)
                | Self::SampledCubic { .. }
                | Self::ProportionalIntegralCubic { .. }
                | Self::UnknownInputCubic { .. }
        )
    }

    /// The sampling period of one that is stepped at samples.
    pub(crate) fn period(&self) -> Option<f64> {
        match self {
            Self::SampledCubic { observer, .. } => Some(SampledObserver::<f64>::period(observer.as_ref())),
            Self::DiscreteLinear(observer) | Self::ProportionalIntegralDiscrete { observer } => {
                Some(SampledObserver::<f64>::period(observer.as_ref()))
            }
            Self::StationaryKalman(filter) => Some(SampledObserver::<f64>::period(filter.as_ref())),
            Self::SlidingMode { period, .. } | Self::DiscreteNonlinear { period, .. } | Self::Kalman { period, .. } => {
                Some(*period)
            }
            Self::Linear(_)
            | Self::Cubic(_)
            | Self::ProportionalIntegral { .. }
            | Self::ProportionalIntegralCubic { .. }
            | Self::UnknownInput { .. }
            | Self::UnknownInputCubic { .. }
            | Self::Interval { .. }
            | Self::NonlinearLuenberger { .. } => None,
        }
    }
}

/// The positions of the sliders, as factors of what the report has.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sliders {
    /// Of the linear gain L; of W of a filter.
    pub gain: f64,
    /// Of the cubic gain N.
    pub cubic: f64,
    /// Of the amplitude of the noise.
    pub noise: f64,
    /// Of `xhat(0) - x(0)`.
    pub error: f64,
    /// Of the sampling period.
    pub period: f64,
}

impl Sliders {
    /// The report as it is.
    pub const NEUTRAL: Self = Self { gain: 1.0, cubic: 1.0, noise: 1.0, error: 1.0, period: 1.0 };
}

impl Experiment {
    /// An experiment without input, noise and observers, with tolerances of 1e-9, the Euclidean norm and a band of 5 %.
    pub fn new(plant: StoredPlant, x0: &[f64], duration: f64, samples: usize) -> Self {
        let states = match &plant {
            StoredPlant::Expressions { states, .. } => states.clone(),
            StoredPlant::Linear { .. } => (1..=x0.len()).map(|i| format!("x{i}")).collect(),
        };
        Self {
            plant,
            states,
            units: Vec::new(),
            time_unit: None,
            input: Vec::new(),
            table: None,
            law: None,
            feedback: None,
            parameters: BTreeMap::new(),
            tables: BTreeMap::new(),
            dt: None,
            truth: None,
            hold: None,
            x0: x0.to_vec(),
            duration,
            samples,
            tolerances: [1e-9, 1e-9],
            integrator: Method::Auto,
            noise: None,
            sensors: Vec::new(),
            scale: Some(vec![1.0; x0.len()]),
            band: 0.05,
            score_period: None,
            hold_measurements: false,
            estimates: Estimates::Filtered,
            observers: Vec::new(),
        }
    }

    /// The sliders as the experiment has them: a plant in discrete time has its period.
    pub(crate) fn fitted(&self, sliders: &Sliders) -> Sliders {
        let period = if self.dt.is_some() { 1.0 } else { sliders.period };
        Sliders { period, ..*sliders }
    }

    /// The same with one more observer.
    #[must_use]
    pub fn observer(mut self, observer: StoredObserver) -> Self {
        self.observers.push(observer);
        self
    }
}
