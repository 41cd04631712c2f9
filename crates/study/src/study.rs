//! A study as typed data.

mod data;
mod kind;
mod observers;

use std::path::Path;
use std::sync::Arc;

use luenberger_design::OperatingPoint;
use luenberger_lmi::Solver;
use luenberger_sim::{Recording, Samples};
use nalgebra::DMatrix;

use crate::diagnostic::Source;
use crate::digest::FileDigest;
use crate::model::PlantModel;
use crate::signal::Input;
use crate::table::{LogColumns, Suspicion};

pub use data::DataFiles;
pub(crate) use kind::{NUMBER, unknowns};
pub use kind::{ObserverKind, PlantClass, Setting, Specification, Time};
pub use observers::{ActingBounds, GainLimits, GainSpec, LinearSpec, ObserverSpec, RateSpec, faster_poles};

/// A study without mistakes: a plant, its observers and the experiments with them.
#[derive(Debug, Clone)]
pub struct Study {
    /// The title.
    pub title: String,
    /// Description of the study; may be empty.
    pub about: String,
    /// The plant.
    pub plant: PlantModel,
    /// The parameters that filters estimate: the last states of `plant`, in this order.
    pub estimated: Vec<Estimated>,
    /// The operating point, with the linearisation there, if the study names one.
    pub operating_point: Option<OperatingPoint>,
    /// The input of the plant.
    pub input: Input,
    /// The simulation; none for a study with designs only, or with a log.
    pub simulation: Option<Simulation>,
    /// The plant as it is simulated, where it differs from the model.
    pub truth: Option<Truth>,
    /// The measured log, if there is one.
    pub log: Option<Log>,
    /// The observers.
    pub observers: Vec<ObserverSpec>,
    /// The solver for matrix inequalities of the designs.
    pub solver: Solver,
    /// The prior information with which `luenberger advise` tunes, if specified.
    pub advise: Option<AdviseSpec>,
    /// What `luenberger tune` fits, if specified.
    pub tune: Option<TuneSpec>,
    /// The frequency responses, if specified.
    pub frequency: Option<FrequencySpec>,
    /// The plots.
    pub plot: Plot,
    /// The sweep.
    pub sweep: Option<Sweep>,
    /// Where the files are that it names.
    pub data: DataFiles,
    /// The files of data that it reads.
    pub files: Vec<FileDigest>,
    /// The format of its text.
    pub format: Format,
    /// The file.
    pub source: Arc<Source>,
}

/// A parameter of the plant that filters estimate as one of its states: a constant, a random walk, or a coloured noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimated {
    /// Its name.
    pub name: String,
    /// Its value in the study, the first estimate.
    pub value: f64,
    /// Variance of the first error.
    pub p0: f64,
    /// Intensity of what drives it, in discrete time the variance per sample; 0 for a constant.
    pub w: f64,
    /// Its bounds, which may be infinite.
    pub bounds: (f64, f64),
    /// Of a coloured noise, how it varies about its value in the study.
    pub noise: Option<GaussMarkov>,
}

/// Stationary noise of first order, `n' = -n/tau + w`: its autocorrelation at the distance s is
/// `deviation^2 exp(-|s|/tau)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussMarkov {
    /// The correlation time.
    pub tau: f64,
    /// The standard deviation.
    pub deviation: f64,
}

impl GaussMarkov {
    /// What is left of n after the time h: `exp(-h/tau)`.
    pub(crate) fn decay(&self, h: f64) -> f64 {
        (-h / self.tau).exp()
    }

    /// The intensity `2 deviation^2 / tau` of w; with a period h the variance that it adds to n over it,
    /// `deviation^2 (1 - exp(-2 h/tau))`.
    pub(crate) fn driving(&self, period: Option<f64>) -> f64 {
        let variance = self.deviation * self.deviation;
        period.map_or(2.0 * variance / self.tau, |h| -variance * (-2.0 * h / self.tau).exp_m1())
    }

    /// The standard deviation of independent values of w, each held for `hold`, for which n has its own one after each;
    /// of a plant in discrete time those of its samples.
    pub(crate) fn held(&self, hold: f64, dt: Option<f64>) -> f64 {
        match dt {
            Some(dt) => self.driving(Some(dt)).sqrt(),
            // Over a hold n decays by a = exp(-hold/tau) and takes up tau (1 - a) w.
            None => self.deviation / self.tau / (0.5 * hold / self.tau).tanh().sqrt(),
        }
    }
}

/// The format of the text of a study.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// TOML.
    Toml,
    /// JSON.
    Json,
}

impl Study {
    /// The name of its file, without folders: results do not depend on where the study is.
    pub(crate) fn file_name(&self) -> String {
        let name = self.source.name();
        Path::new(name).file_name().map_or_else(|| name.to_owned(), |name| name.to_string_lossy().into())
    }

    /// Number of states of the plant, without the parameters that are estimated.
    pub(crate) fn order(&self) -> usize {
        self.plant.states.len() - self.estimated.len()
    }

    /// The observer of that name.
    pub fn observer(&self, name: &str) -> Option<&ObserverSpec> {
        self.observers.iter().find(|observer| observer.name == name)
    }
}

/// Simulation of the plant and its observers.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// The initial state x(0).
    pub x0: Vec<f64>,
    /// The end time.
    pub duration: f64,
    /// The number of output times.
    pub samples: usize,
    /// Method and tolerances.
    pub settings: luenberger_sim::Settings,
    /// The hold period of the input.
    pub hold: Option<f64>,
    /// The settling band as a fraction of the initial error.
    pub band: f64,
    /// The period of the scores, if specified.
    pub score_period: Option<f64>,
    /// Which estimates of filters are scored and shown.
    pub estimates: luenberger_sim::Estimates,
    /// The scale of each state in norms, if specified.
    pub scale: Option<Vec<f64>>,
    /// Noise on the outputs.
    pub noise: Option<NoiseSpec>,
    /// Sensors with sampling periods of their own, which have the noise of their outputs.
    pub sensors: Vec<SensorSpec>,
    /// Whether observers in continuous time hold the measurements of sensors, which otherwise move with the model.
    pub hold_measurements: bool,
    /// How the samples of observers at varying periods are drawn.
    pub sampling: SamplingSpec,
}

/// The samples of observers at varying periods, as a simulation draws them.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SamplingSpec {
    /// The shortest and the longest period; none for those that each observer is designed for.
    pub jitter: Option<(f64, f64)>,
    /// The largest number of samples missed in a row; none for that of each observer.
    pub misses: Option<usize>,
    /// The seed.
    pub seed: u64,
}

impl Simulation {
    /// A run from `x0` to the time `duration` without noise, with the defaults of a study.
    pub fn new(x0: &[f64], duration: f64) -> Self {
        Self {
            x0: x0.to_vec(),
            duration,
            samples: 501,
            settings: luenberger_sim::Settings { rtol: 1e-9, atol: 1e-10, ..luenberger_sim::Settings::default() },
            hold: None,
            band: 0.05,
            score_period: None,
            estimates: luenberger_sim::Estimates::Filtered,
            scale: None,
            noise: None,
            sensors: Vec::new(),
            hold_measurements: false,
            sampling: SamplingSpec::default(),
        }
    }

    /// The sensor of an output (from 0), if it has one of its own.
    pub fn sensor(&self, output: usize) -> Option<&SensorSpec> {
        self.sensors.iter().find(|sensor| sensor.output == output)
    }

    /// The noise of an output (from 0); none without noise.
    pub fn noise_of(&self, output: usize) -> Option<OutputNoise> {
        let found = match (self.sensor(output), &self.noise) {
            (Some(SensorSpec { gaussian, amplitude, period, .. }), _) => {
                OutputNoise { gaussian: *gaussian, amplitude: *amplitude, period: *period }
            }
            (None, Some(noise)) => {
                let amplitude = noise.amplitude.get(output).copied().unwrap_or(0.0);
                OutputNoise { gaussian: noise.gaussian, amplitude, period: noise.period }
            }
            (None, None) => return None,
        };
        (found.amplitude > 0.0).then_some(found)
    }

    /// Whether there is measurement noise.
    pub fn is_noisy(&self) -> bool {
        self.noise.is_some() || self.sensors.iter().any(|sensor| sensor.amplitude > 0.0)
    }
}

/// A sensor that measures an output at instants of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorSpec {
    /// The output, from 0.
    pub output: usize,
    /// Time between two measurements.
    pub period: f64,
    /// Time of the first one.
    pub offset: f64,
    /// Gaussian noise if true, otherwise uniform.
    pub gaussian: bool,
    /// Standard deviation or amplitude of the noise.
    pub amplitude: f64,
    /// The seed.
    pub seed: u64,
}

impl SensorSpec {
    /// The sensor with the amplitude scaled by `factor`.
    pub fn sensor(&self, factor: f64) -> luenberger_sim::Sensor {
        let sensor = luenberger_sim::Sensor::new(self.output, self.period).offset(self.offset);
        let (amplitude, seed) = (factor * self.amplitude, self.seed);
        if self.gaussian { sensor.gaussian(amplitude, seed) } else { sensor.uniform(amplitude, seed) }
    }
}

/// Measurement noise of one output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputNoise {
    /// Gaussian if true, otherwise uniform.
    pub gaussian: bool,
    /// Standard deviation or amplitude.
    pub amplitude: f64,
    /// Hold time of each value.
    pub period: f64,
}

impl OutputNoise {
    /// The variance; that of uniform noise of amplitude a is a^2/3.
    pub fn variance(&self) -> f64 {
        self.amplitude * self.amplitude * if self.gaussian { 1.0 } else { 1.0 / 3.0 }
    }
}

/// Noise on the outputs.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseSpec {
    /// Gaussian if true, otherwise uniform.
    pub gaussian: bool,
    /// Standard deviations or amplitudes, one for each output.
    pub amplitude: Vec<f64>,
    /// Hold time of each noise value.
    pub period: f64,
    /// The seed.
    pub seed: u64,
}

impl NoiseSpec {
    /// The noise with amplitudes scaled by `factor`.
    pub fn noise(&self, factor: f64) -> luenberger_sim::Noise {
        let amplitude: Vec<f64> = self.amplitude.iter().map(|amplitude| factor * amplitude).collect();
        if self.gaussian {
            luenberger_sim::Noise::gaussian(&amplitude, self.period, self.seed)
        } else {
            luenberger_sim::Noise::uniform(&amplitude, self.period, self.seed)
        }
    }
}

/// The plant as it is simulated, where it differs from the model that the observers are designed for.
#[derive(Debug, Clone)]
pub struct Truth {
    /// The plant with its own parameters or equations; none if they are those of the model.
    pub plant: Option<OtherPlant>,
    /// Changes of the plant, in the order of the study.
    pub events: Vec<Event>,
    /// Process noise, delays, faults, quantisation, dropouts, outliers.
    pub disturbances: luenberger_sim::Disturbances,
    /// The same as a sentence.
    pub words: String,
}

/// The plant with other parameters, matrices or equations.
#[derive(Debug, Clone)]
pub struct OtherPlant {
    /// The plant.
    pub model: crate::model::Model,
    /// The parameters of its equations.
    pub parameters: luenberger_expression::Parameters,
    /// Its values of the parameters that are estimated, which are states of `model`.
    pub estimated: Vec<f64>,
}

/// A change of the simulated plant.
#[derive(Debug, Clone)]
pub struct Event {
    /// When.
    pub at: f64,
    /// The plant from then on, if it changes.
    pub plant: Option<OtherPlant>,
    /// Added to the state; empty for nothing.
    pub jump: Vec<f64>,
}

/// The prior information with which `luenberger advise` tunes; what is none is derived.
#[derive(Debug, Clone, PartialEq)]
pub struct AdviseSpec {
    /// The settling time.
    pub settling: Option<f64>,
    /// The region.
    pub region: Option<luenberger_design::Region>,
    /// The first estimate.
    pub initial: Option<Vec<f64>>,
    /// The intensity of the process noise, n x n.
    pub w: Option<DMatrix<f64>>,
    /// E of an unknown disturbance, n x q.
    pub e: Option<DMatrix<f64>>,
    /// Bounds of its components, q numbers.
    pub disturbance: Option<Vec<f64>>,
    /// The sampling period.
    pub period: Option<f64>,
    /// Standard deviation of a measurement of each output of a log.
    pub noise: Option<Vec<f64>>,
    /// The share of a log, its last part, by which observers are ranked.
    pub held_out: Option<f64>,
    /// Runs of each observer.
    pub ensemble: usize,
    /// The seed of the first estimates.
    pub seed: u64,
}

impl Default for AdviseSpec {
    fn default() -> Self {
        Self {
            settling: None,
            region: None,
            initial: None,
            w: None,
            e: None,
            disturbance: None,
            period: None,
            noise: None,
            held_out: None,
            ensemble: 20,
            seed: 0,
        }
    }
}

/// What `luenberger tune` fits, and to which logs.
#[derive(Debug, Clone)]
pub struct TuneSpec {
    /// The observer, by its name.
    pub observer: String,
    /// What the best values are best for.
    pub criterion: TuneCriterion,
    /// What is fitted.
    pub parameters: Vec<Tuned>,
    /// The logs with the names of their files; the first is that of the study.
    pub logs: Vec<(String, Log)>,
    /// The share of each log, its last part, that is not fitted.
    pub held_out: f64,
    /// Number of searches.
    pub starts: usize,
    /// The seed of their starts.
    pub seed: u64,
    /// Points to either side in the figure of a profile likelihood.
    pub profile: usize,
}

/// What a fit minimises or maximises.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TuneCriterion {
    /// The likelihood of the innovations of a filter that computes their covariance.
    Likelihood,
    /// The mean squares of the one-step prediction errors of the outputs.
    Innovations,
    /// The mean squares of the errors of the states that the log knows.
    Errors,
}

impl TuneCriterion {
    /// The names, each with its sentence.
    pub(crate) const WORDS: &'static [(&'static str, &'static str)] = &[
        ("likelihood", "The likelihood of the innovations of a filter that computes their covariance."),
        ("innovations", "The mean squares of the errors of one-step predictions of the outputs, for any observer."),
        (
            "errors",
            "The mean squares of the errors of the states that the log knows (`states` in [log]), for any observer.",
        ),
    ];

    /// Its name in studies.
    pub fn name(self) -> &'static str {
        match self {
            Self::Likelihood => "likelihood",
            Self::Innovations => "innovations",
            Self::Errors => "errors",
        }
    }

    /// The criterion of this name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        [Self::Likelihood, Self::Innovations, Self::Errors].into_iter().find(|one| one.name() == name)
    }
}

/// A number that is fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Tuned {
    /// Which one.
    pub what: Tunable,
    /// Its name, such as `w[soc]`.
    pub name: String,
    /// Its value in the study.
    pub value: f64,
    /// Its bounds, if the study has some.
    pub bounds: Option<(f64, f64)>,
}

/// A number of a study that can be fitted to a log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Tunable {
    /// An entry of the diagonal of W.
    W(usize),
    /// An entry of the diagonal of V.
    V(usize),
    /// An entry of the diagonal of P(0).
    P0(usize),
    /// A parameter of the plant.
    Parameter(String),
    /// The standard deviation of a coloured noise, by its name.
    Deviation(String),
    /// The correlation time of a coloured noise, by its name.
    CorrelationTime(String),
    /// What the sensor of an output adds to it.
    Bias(usize),
    /// How late an output is measured.
    Delay(usize),
    /// A number of a key of the observer.
    Own(String, Part),
}

/// Which number of a key it is.
///
/// Poles are fitted by numbers that are positive for stable ones, and for no others: two of them by the natural
/// frequency and the damping ratio of `s^2 + 2 damping frequency s + frequency^2`, so that a pair of conjugates may
/// become two real poles and back, a single one by its rate `-s`. In discrete time s is `2/dt (z - 1)/(z + 1)`, which
/// has the left half plane for the unit disc.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The number.
    Whole,
    /// An entry of a list, from 0.
    Entry(usize),
    /// An entry of a matrix, by row and column from 0.
    Cell(usize, usize),
    /// The rate of a real pole.
    Rate(usize),
    /// The natural frequency of two poles.
    Frequency(usize, usize),
    /// Their damping ratio.
    Damping(usize, usize),
}

impl Tunable {
    /// Whether it is a variance or a standard deviation.
    pub fn is_variance(&self) -> bool {
        matches!(self, Self::W(_) | Self::V(_) | Self::P0(_) | Self::Deviation(_))
    }

    /// Whether no other number than a positive one has a meaning.
    pub fn is_positive(&self) -> bool {
        self.is_variance() || matches!(self, Self::CorrelationTime(_))
    }
}

/// A measured log.
#[derive(Debug, Clone)]
pub struct Log {
    /// Its columns.
    pub columns: LogColumns,
    /// Inputs and outputs at the times of the log.
    pub recording: Recording,
    /// The variances of the measurements at these times, of which values may be missing; none if the log has none.
    pub variances: Option<Samples>,
    /// The true states at these times, of which values may be missing; none if the log has no column of a state.
    pub truth: Option<Samples>,
    /// Which estimates of filters are scored and shown.
    pub estimates: luenberger_sim::Estimates,
    /// Suspicious data in the log, such as gaps.
    pub suspicions: Vec<Suspicion>,
}

impl Log {
    /// How many of its first rows are fitted where this share of them, the last ones, is held out.
    pub(crate) fn fitted(&self, held_out: f64) -> usize {
        let rows = self.recording.times().len();
        (((1.0 - held_out) * rows as f64).ceil() as usize).clamp(2.min(rows), rows)
    }
}

/// Frequency responses of linear observers and of the loop; frequencies in radians per unit of time.
#[derive(Debug, Clone, PartialEq)]
pub struct FrequencySpec {
    /// The first one, if specified.
    pub from: Option<f64>,
    /// The last one, if specified.
    pub to: Option<f64>,
    /// Their number.
    pub points: usize,
    /// Values of q of loop transfer recovery.
    pub recovery: Vec<f64>,
}

impl Default for FrequencySpec {
    fn default() -> Self {
        Self { from: None, to: None, points: 400, recovery: Vec::new() }
    }
}

/// The available plots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Each state with its estimates.
    States,
    /// The error of each state.
    Errors,
    /// The norm of the error.
    ErrorNorm,
    /// The inputs.
    Inputs,
    /// The outputs.
    Outputs,
    /// The innovation y - h(xhat).
    Innovations,
}

/// The requested plots.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Plot {
    /// The plots, if specified.
    pub show: Option<Vec<Quantity>>,
    /// Indices of the states, from 0.
    pub states: Option<Vec<usize>>,
    /// The observers, by their names.
    pub observers: Option<Vec<String>>,
    /// First time.
    pub from: Option<f64>,
    /// Last time.
    pub to: Option<f64>,
}

/// The parameter of a sweep.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Swept {
    /// gamma of the observers that have one.
    Gamma,
    /// A factor of poles and rates.
    Poles,
    /// A factor of the noise amplitude.
    Noise,
    /// A factor of the initial error.
    Initial,
    /// A number of the study, by its place: `plant.k1`, `observer.filter.v`, `simulation.hold`.
    Number(String),
}

impl Swept {
    /// The name in study files.
    pub fn name(&self) -> &str {
        match self {
            Self::Gamma => "gamma",
            Self::Poles => "poles",
            Self::Noise => "noise",
            Self::Initial => "initial",
            Self::Number(path) => path,
        }
    }

    /// Whether observers are designed anew at each value.
    pub fn redesigns(&self) -> bool {
        match self {
            Self::Gamma | Self::Poles => true,
            Self::Noise | Self::Initial => false,
            Self::Number(path) => path.starts_with("plant.") || path.starts_with("observer."),
        }
    }
}

/// A sweep.
#[derive(Debug, Clone)]
pub struct Sweep {
    /// The swept parameter.
    pub parameter: Swept,
    /// Its values.
    pub values: Vec<f64>,
    /// The study with each value, if the parameter is a number of it.
    pub variants: Vec<Study>,
    /// Runs at each value.
    pub ensemble: usize,
    /// The seed of the ensemble.
    pub seed: u64,
    /// The observers, by their names; all if none are named.
    pub observers: Option<Vec<String>>,
    /// Whether the observers run on the log, and not in the simulation.
    pub on_log: bool,
    /// The share of the log, its last part, by which they are judged.
    pub held_out: Option<f64>,
}
