//! What a report embeds: a plant, an experiment with it, and observers as designed.

use std::collections::BTreeMap;

use luenberger_observers::{CubicObserver, LinearObserver, SampledCubicObserver};
use luenberger_plants::StateSpace;
use nalgebra::{DMatrix, Dyn};
use serde::{Deserialize, Serialize};

/// A matrix as an array of its rows.
pub type Rows = Vec<Vec<f64>>;

pub(crate) fn rows(m: &DMatrix<f64>) -> Rows {
    m.row_iter().map(|row| row.iter().copied().collect()).collect()
}

/// A plant, an experiment with it, and observers as designed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// The plant.
    pub plant: Plant,
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
    /// What is subtracted from the input; none for an input that is a function of time.
    pub feedback: Option<Feedback>,
    /// The parameters that the expressions use by name.
    pub parameters: BTreeMap<String, f64>,
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
    /// The noise of the outputs.
    pub noise: Option<Noise>,
    /// Sensors with sampling periods of their own, which have the noise of their outputs.
    pub sensors: Vec<Sensor>,
    /// The unit of each state in the norm of the error; none for the Euclidean norm.
    pub scale: Option<Vec<f64>>,
    /// Settled is within this share of the error at the start.
    pub band: f64,
    /// The period of the scores, if it is not that of the observers.
    pub score_period: Option<f64>,
    /// The observers.
    pub observers: Vec<Observer>,
}

/// A plant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum Plant {
    /// `x' = f`, `y = h` as expressions.
    Expressions {
        /// Names of the states.
        states: Vec<String>,
        /// Names of the inputs.
        inputs: Vec<String>,
        /// The right-hand sides.
        f: Vec<String>,
        /// The outputs.
        h: Vec<String>,
    },
    /// `x' = A x + B u`, `y = C x + D u`.
    Linear {
        /// A.
        a: Rows,
        /// B.
        b: Rows,
        /// C.
        c: Rows,
        /// D, if it is not 0.
        d: Option<Rows>,
    },
}

impl Plant {
    /// A linear plant.
    pub fn linear(plant: &StateSpace) -> Self {
        let [a, b, c] = [&plant.a, &plant.b, &plant.c].map(rows);
        Self::Linear { a, b, c, d: plant.d.as_ref().map(rows) }
    }

    /// The number of inputs.
    pub(crate) fn inputs(&self) -> usize {
        match self {
            Self::Expressions { inputs, .. } => inputs.len(),
            Self::Linear { b, .. } => b.first().map_or(0, Vec::len),
        }
    }
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
    pub of: FeedbackOf,
    /// Added to the input: `u0 + K x0` of an operating point. Empty for nothing.
    pub shift: Vec<f64>,
}

impl Feedback {
    /// `-K xhat` with the estimate of each observer in its own run.
    pub fn of_each(gain: &DMatrix<f64>) -> Self {
        Self { gain: rows(gain), of: FeedbackOf::EachEstimate, shift: Vec::new() }
    }
}

/// What is fed back.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum FeedbackOf {
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

/// Noise of the outputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Noise {
    /// Gaussian if true, otherwise uniform.
    pub gaussian: bool,
    /// Standard deviations or amplitudes, one for each output.
    pub amplitude: Vec<f64>,
    /// The hold time of each value.
    pub period: f64,
    /// The seed.
    pub seed: u64,
}

/// An observer as designed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Observer {
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
}

impl Observer {
    /// An observer without certificate.
    pub fn new(name: &str, kind: ObserverKind, initial: &[f64]) -> Self {
        Self { name: name.to_owned(), initial: initial.to_vec(), kind, point: None, certificates: Some(Vec::new()) }
    }
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
    /// The copy of the plant with the gain L.
    Copy {
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
        /// Runge-Kutta steps in a period.
        substeps: usize,
    },
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
    /// An experiment without input, noise and observers, with tolerances of 1e-9 and a band of 5 %.
    pub fn new(plant: Plant, x0: &[f64], duration: f64, samples: usize) -> Self {
        let states = match &plant {
            Plant::Expressions { states, .. } => states.clone(),
            Plant::Linear { .. } => (1..=x0.len()).map(|i| format!("x{i}")).collect(),
        };
        Self {
            plant,
            states,
            units: Vec::new(),
            time_unit: None,
            input: Vec::new(),
            table: None,
            feedback: None,
            parameters: BTreeMap::new(),
            hold: None,
            x0: x0.to_vec(),
            duration,
            samples,
            tolerances: [1e-9, 1e-9],
            noise: None,
            sensors: Vec::new(),
            scale: None,
            band: 0.05,
            score_period: None,
            observers: Vec::new(),
        }
    }

    /// The same with one more observer.
    #[must_use]
    pub fn observer(mut self, observer: Observer) -> Self {
        self.observers.push(observer);
        self
    }
}
