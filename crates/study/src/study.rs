//! A study as typed data.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use luenberger_design::{GainOptions, OperatingPoint};
use luenberger_lmi::Solver;
use luenberger_sim::{Recording, Samples};
use nalgebra::{Complex, DMatrix};

use crate::diagnostic::{Place, Source};
use crate::error::StudyError;
use crate::execute::FileDigest;
use crate::model::PlantModel;
use crate::read::{self, Format};
use crate::signal::Input;
use crate::table::Suspicion;

/// A study without mistakes: a plant, its observers and the experiments with them.
#[derive(Debug, Clone)]
pub struct Study {
    /// The title.
    pub title: String,
    /// Description of the study; may be empty.
    pub about: String,
    /// The plant.
    pub plant: PlantModel,
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
    /// What every kind of observer is told by `luenberger advise`, if specified.
    pub advise: Option<AdviseSpec>,
    /// The plots.
    pub plot: Plot,
    /// The sweep.
    pub sweep: Option<Sweep>,
    /// The folder that file names in the study are relative to.
    pub folder: PathBuf,
    /// The files of data that it reads.
    pub files: Vec<FileDigest>,
    /// The format of its text.
    pub format: Format,
    /// The file.
    pub source: Arc<Source>,
}

impl Study {
    /// Reads a study: JSON from `.json`, TOML from everything else.
    ///
    /// # Errors
    /// [`StudyError::Io`] for a file that cannot be read, [`StudyError::File`] with every mistake in it, by line and
    /// column.
    pub fn from_path(path: &Path) -> Result<Self, StudyError> {
        let text = std::fs::read_to_string(path).map_err(|error| StudyError::io(path, error))?;
        let json = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Self::from_text(&path.to_string_lossy(), &text, if json { Format::Json } else { Format::Toml }, folder)
    }

    /// Parses the study in `text`; `name` is used in messages, and file names in the study are relative to `folder`.
    /// A study without a title is titled by its file name, or "study" if `name` is "standard input".
    ///
    /// ```
    /// use luenberger_study::{Format, Study, template};
    /// let text = template::text("double-integrator").ok_or("a template")?;
    /// let study = Study::from_text("study.toml", text, Format::Toml, ".".as_ref())?;
    /// assert_eq!(study.plant.states.len(), 2);
    ///
    /// let wrong = text.replace("poles =", "pols =");
    /// let error = Study::from_text("study.toml", &wrong, Format::Toml, ".".as_ref()).unwrap_err();
    /// assert!(error.to_string().contains("the nearest key is `poles`"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`StudyError::File`] with every mistake.
    pub fn from_text(name: &str, text: &str, format: Format, folder: &Path) -> Result<Self, StudyError> {
        read::study(name, text, format, folder, BTreeMap::new())
    }

    /// The name of its file, without folders: results do not depend on where the study is.
    pub(crate) fn file_name(&self) -> String {
        let name = self.source.name();
        Path::new(name).file_name().map_or_else(|| name.to_owned(), |name| name.to_string_lossy().into())
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
    /// The scale of each state in norms, if specified.
    pub scale: Option<Vec<f64>>,
    /// Noise on the outputs.
    pub noise: Option<NoiseSpec>,
    /// Sensors with sampling periods of their own, which have the noise of their outputs.
    pub sensors: Vec<SensorSpec>,
    /// How the samples of observers at varying periods are drawn.
    pub sampling: SamplingSpec,
}

/// The samples of observers at varying periods, as a simulation draws them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SamplingSpec {
    /// The shortest and the longest period; none for those that each observer is designed for.
    pub jitter: Option<(f64, f64)>,
    /// The largest number of samples missed in a row; none for that of each observer.
    pub misses: Option<usize>,
    /// The seed.
    pub seed: u64,
}

impl Simulation {
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
    /// The sensor with the amplitude scaled by `factor` and `seed` added to its seed.
    pub fn sensor(&self, factor: f64, seed: u64) -> luenberger_sim::Sensor {
        let sensor = luenberger_sim::Sensor::new(self.output, self.period).offset(self.offset);
        let (amplitude, seed) = (factor * self.amplitude, self.seed.wrapping_add(seed));
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
    /// The noise with amplitudes scaled by `factor` and another seed.
    pub fn noise(&self, factor: f64, seed: u64) -> luenberger_sim::Noise {
        let amplitude: Vec<f64> = self.amplitude.iter().map(|amplitude| factor * amplitude).collect();
        if self.gaussian {
            luenberger_sim::Noise::gaussian(&amplitude, self.period, seed)
        } else {
            luenberger_sim::Noise::uniform(&amplitude, self.period, seed)
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

/// What every kind of observer is told by `luenberger advise`; what is none is derived.
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
    /// Runs of each observer.
    pub ensemble: usize,
    /// The seed of the first estimates.
    pub seed: u64,
}

impl Default for AdviseSpec {
    fn default() -> Self {
        let (settling, region, initial, w, e, disturbance, period) = (None, None, None, None, None, None, None);
        Self { settling, region, initial, w, e, disturbance, period, ensemble: 20, seed: 0 }
    }
}

/// A measured log.
#[derive(Debug, Clone)]
pub struct Log {
    /// Inputs and outputs at the times of the log.
    pub recording: Recording,
    /// The true states at these times, of which values may be missing; none if the log has no column of a state.
    pub truth: Option<Samples>,
    /// Suspicious data in the log, such as gaps.
    pub suspicions: Vec<Suspicion>,
}

/// An observer and its design specification.
#[derive(Debug, Clone, PartialEq)]
pub struct ObserverSpec {
    /// Its name.
    pub name: String,
    /// Its initial estimate.
    pub initial: Vec<f64>,
    /// Its kind.
    pub kind: ObserverKind,
    /// Limits of a gain that is designed by a matrix inequality.
    pub limits: GainLimits,
    /// Bounds of noise and disturbances for which the error is to be bounded, if specified.
    pub bounds: Option<ActingBounds>,
    /// Position of the observer in the file.
    pub place: Place,
}

/// Bounds of noise and disturbances, `x' = A x + B u + E w`, `y = C x + v`.
#[derive(Debug, Clone, PartialEq)]
pub struct ActingBounds {
    /// The bounds of v, one for each output.
    pub noise: Vec<f64>,
    /// The bounds of w.
    pub disturbance: Vec<f64>,
    /// E, n x q.
    pub e: DMatrix<f64>,
    /// Bounds of the states, and how the plant deviates from its A; none where A is exact.
    pub uncertain: Option<(Vec<f64>, luenberger_design::Uncertainty)>,
}

/// Limits of a gain that is designed by a matrix inequality, beside the decay rate; see
/// [`GainOptions`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GainLimits {
    /// An upper bound of the spectral norm of L.
    pub max_gain: Option<f64>,
    /// The intensity V of the measurement noise, p x p, for which the noise gain is to be the least.
    pub noise: Option<DMatrix<f64>>,
}

impl GainLimits {
    /// The options of the design, with this solver, which stops at the instant `end` if there is one.
    pub fn options(&self, solver: Solver, end: Option<Instant>) -> GainOptions {
        let settings = luenberger_lmi::Settings { solver, end, ..luenberger_lmi::Settings::default() };
        GainOptions { settings, max_gain: self.max_gain, noise: self.noise.clone() }
    }
}

/// Gain specification of a linear observer.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearSpec {
    /// How L is computed.
    pub gain: GainSpec,
    /// The right-hand side of the certifying Lyapunov equation, if given.
    pub weight: Option<luenberger_design::LyapunovWeight>,
    /// Of a Kalman filter: the estimate at a sample uses its measurement.
    pub is_filter: bool,
}

/// Specification of an H-infinity or H2 filter.
#[derive(Debug, Clone, PartialEq)]
pub struct NormFilterSpec {
    /// The norm.
    pub norm: luenberger_design::SystemNorm,
    /// What acts on the plant, and the errors that count.
    pub performance: luenberger_design::Performance,
    /// The least norm, a bound, or a given gain.
    pub goal: luenberger_design::NormTarget,
}

/// How the gain of a linear observer is computed.
#[derive(Debug, Clone, PartialEq)]
pub enum GainSpec {
    /// Pole placement: the eigenvalues of `A - L C`.
    Poles(Vec<Complex<f64>>),
    /// The stationary Kalman gain.
    Kalman {
        /// Intensity of the process noise, n x n.
        w: DMatrix<f64>,
        /// Intensity of the measurement noise, p x p.
        v: DMatrix<f64>,
    },
    /// A decay rate, by an LMI.
    DecayRate(f64),
    /// The gain with the largest margin of the LMI.
    Lmi,
    /// A given L, n x p.
    Given(DMatrix<f64>),
}

/// Gain specification of a copy of a nonlinear plant.
#[derive(Debug, Clone, PartialEq)]
pub enum RateSpec {
    /// A specified rate.
    Rate(f64),
    /// The largest rate up to this ceiling.
    Fastest(f64),
    /// Analysis of a given gain, with at least this rate if specified.
    Gain(DMatrix<f64>, f64),
}

/// The kinds of observers, with their specifications.
#[derive(Debug, Clone, PartialEq)]
pub enum ObserverKind {
    /// Luenberger observer.
    Luenberger(LinearSpec),
    /// Stationary Kalman filter: a Luenberger observer with the Kalman gain.
    Kalman(LinearSpec),
    /// Cubic observer.
    Cubic {
        /// Its linear part.
        linear: LinearSpec,
        /// theta, p x p.
        theta: DMatrix<f64>,
        /// N.
        correction: luenberger_design::CubicGain,
    },
    /// Cubic observer of least cost.
    OptimalCubic(Box<luenberger_design::EstimationProblem>),
    /// Observer of the state and of a slowly varying disturbance, linear or cubic.
    ProportionalIntegral {
        /// E, n x q.
        e: DMatrix<f64>,
        /// The number k of integrators in the model `d^(k) = 0` of each disturbance; none for the kind that has one.
        chain: Option<usize>,
        /// Bounds of the k-th derivative of the disturbance, one for each.
        rate: Vec<f64>,
        /// Its linear part, for the plant with the disturbance among its states.
        linear: LinearSpec,
        /// theta, p x p, and gamma of a cubic term.
        cubic: Option<(DMatrix<f64>, f64)>,
    },
    /// Observer whose error does not depend on a disturbance, linear or cubic.
    UnknownInput {
        /// E, n x q.
        e: DMatrix<f64>,
        /// Its linear part, for the plant without the disturbance.
        linear: LinearSpec,
        /// theta, p x p, and gamma of a cubic term.
        cubic: Option<(DMatrix<f64>, f64)>,
    },
    /// Reduced-order observer with these poles.
    ReducedOrder(Vec<Complex<f64>>),
    /// Functional observer of z = K x.
    Functional {
        /// K, r x n.
        k: DMatrix<f64>,
        /// The eigenvalues of F.
        poles: Vec<Complex<f64>>,
    },
    /// H-infinity or H2 filter.
    NormFilter(Box<NormFilterSpec>),
    /// Sampled cubic observer.
    SampledCubic {
        /// Its linear part.
        linear: LinearSpec,
        /// theta, p x p.
        theta: DMatrix<f64>,
        /// The gain of its cubic term: radial ones are in closed form, others take a semi-implicit step.
        correction: luenberger_design::CubicGain,
        /// The sampling period.
        period: f64,
        /// The periods and misses at which convergence is to be proved besides.
        varying: Option<luenberger_design::Periods>,
    },
    /// One gain for all Jacobians over a box (polytopic design).
    Lpv {
        /// The box of the states.
        region: luenberger_design::Region,
        /// The rate.
        rate: RateSpec,
    },
    /// One gain for all nonlinearities within given sectors.
    Lipschitz {
        /// A and the sectors, if given.
        split: Option<(DMatrix<f64>, Vec<luenberger_design::Sector>)>,
        /// The box for sectors derived from the Jacobians.
        region: luenberger_design::Region,
        /// The rate.
        rate: f64,
        /// A given gain.
        gain: Option<DMatrix<f64>>,
    },
    /// The mean-value-theorem observer, in its corrected form.
    MeanValue {
        /// The box.
        region: luenberger_design::Region,
        /// The rate.
        rate: f64,
        /// eta.
        eta: f64,
        /// e(0).
        internal_error: Vec<f64>,
        /// The mean of the Jacobian of the observer as printed; none for the corrected one.
        printed: Option<crate::design::PrintedMean>,
    },
    /// High-gain observer for integrator chains.
    HighGain {
        /// r.
        r: f64,
        /// The lengths of the chains.
        chains: Vec<usize>,
        /// The coefficients.
        alpha: Vec<f64>,
        /// Given maps; none for the copy of a plant in triangular form.
        maps: Option<Box<crate::maps::HighGainMaps>>,
    },
    /// Interval observer.
    Interval(Box<IntervalSpec>),
    /// Sliding-mode observer.
    SlidingMode(SlidingModeSpec),
    /// The extended Kalman filter.
    ExtendedKalman {
        /// W, n x n.
        w: DMatrix<f64>,
        /// V, p x p.
        v: DMatrix<f64>,
        /// P(0), n x n.
        p0: DMatrix<f64>,
        /// The sampling period.
        period: f64,
        /// Runge-Kutta steps per sampling period.
        substeps: usize,
        /// How many standard deviations an innovation may have; none for no limit.
        gate: Option<f64>,
        /// Whether estimates on a log are smoothed.
        smooth: bool,
    },
    /// The unscented Kalman filter.
    Unscented(Box<UnscentedSpec>),
    /// The moving-horizon estimator.
    MovingHorizon(Box<MovingHorizonSpec>),
    /// KKL observer with given maps.
    Kkl(Box<crate::maps::KklMapsSpec>),
    /// Parameter-estimation-based observer: Lambda is zero.
    Pebo(Box<crate::maps::PebSpec>),
    /// [KKL+PEB] observer.
    KklPeb(Box<crate::maps::PebSpec>),
    /// Immersion-and-invariance observer.
    ImmersionInvariance(Box<crate::maps::ImmersionSpec>),
    /// Numerical KKL observer.
    KklNumerical(KklSpec),
}

/// Specification of a sliding-mode observer.
#[derive(Debug, Clone, PartialEq)]
pub struct SlidingModeSpec {
    /// The bound of what the model leaves open in the last derivative.
    pub bound: f64,
    /// The gains, n of them; none for those that follow from the bound.
    pub gains: Option<Vec<f64>>,
    /// The sampling period.
    pub period: f64,
    /// Whether the explicit Euler method is used, for comparison.
    pub explicit: bool,
}

/// Specification of an interval observer.
#[derive(Debug, Clone, PartialEq)]
pub struct IntervalSpec {
    /// The gain; none for the one of the least width.
    pub gain: Option<LinearSpec>,
    /// The coordinates in which the error is bounded.
    pub coordinates: luenberger_design::ErrorCoordinates,
    /// Bounds of |x(0) - xhat(0)|, n numbers.
    pub first: Vec<f64>,
}

/// Specification of an unscented Kalman filter.
#[derive(Debug, Clone, PartialEq)]
pub struct UnscentedSpec {
    /// W, n x n.
    pub w: DMatrix<f64>,
    /// V, p x p.
    pub v: DMatrix<f64>,
    /// P(0), n x n.
    pub p0: DMatrix<f64>,
    /// The sigma points.
    pub sigma: luenberger_observers::SigmaPoints,
    /// The sampling period.
    pub period: f64,
    /// Runge-Kutta steps per sampling period.
    pub substeps: usize,
    /// How many standard deviations an innovation may have; none for no limit.
    pub gate: Option<f64>,
    /// Whether estimates on a log are smoothed.
    pub smooth: bool,
}

/// Specification of a moving-horizon estimator.
#[derive(Debug, Clone, PartialEq)]
pub struct MovingHorizonSpec {
    /// W, n x n.
    pub w: DMatrix<f64>,
    /// V, p x p.
    pub v: DMatrix<f64>,
    /// P(0), n x n.
    pub p0: DMatrix<f64>,
    /// The sampling period.
    pub period: f64,
    /// Runge-Kutta steps per sampling period.
    pub substeps: usize,
    /// Samples in the window, and Gauss-Newton steps at each.
    pub horizon: luenberger_observers::Horizon,
    /// Bounds of the states, if there are some; infinite ones are none.
    pub bounds: Option<Vec<(f64, f64)>>,
}

/// Specification of a numerical KKL observer.
#[derive(Debug, Clone, PartialEq)]
pub struct KklSpec {
    /// The box of the states.
    pub domain: Vec<(f64, f64)>,
    /// The cut-off frequency of the filter; none to search it.
    pub cutoff: Option<f64>,
    /// The margin around the box, outside of which the plant is slowed down; none to slow it down if it escapes.
    pub escape: Option<f64>,
    /// Grid points per axis; none to search them.
    pub points: Option<usize>,
    /// Maximal number of leaves of the tree.
    pub leaves: usize,
    /// Degree of the polynomials.
    pub degree: usize,
    /// Number of samples for the fit.
    pub samples: usize,
    /// Whether the embedded form is simulated.
    pub embedded: bool,
    /// Bounds of the inputs, which are held at constant values; empty for a plant without inputs.
    pub inputs: Vec<(f64, f64)>,
    /// Values of each input for which there is a table.
    pub nodes: usize,
}

impl KklSpec {
    /// Grid points per axis of all tables that the design may compute for a plant with so many states, those of the
    /// search included.
    pub fn tables(&self, states: usize) -> Vec<usize> {
        let mut tables = luenberger_design::numerical_kkl::searched_tables(self.cutoff, self.points, states);
        let last = tables.iter().copied().max().or(self.points);
        tables.extend(last.into_iter().flat_map(|points| core::iter::repeat_n(points, self.family())));
        tables
    }

    /// Values of the inputs for which there are tables; one without inputs.
    pub fn family(&self) -> usize {
        self.nodes.pow(self.inputs.len() as u32)
    }
}

impl ObserverKind {
    /// Whether the design solves a matrix inequality.
    pub fn poses_inequality(&self) -> bool {
        match self {
            Self::Luenberger(linear)
            | Self::Kalman(linear)
            | Self::Cubic { linear, .. }
            | Self::ProportionalIntegral { linear, .. }
            | Self::UnknownInput { linear, .. }
            | Self::SampledCubic { linear, varying: None, .. } => {
                matches!(linear.gain, GainSpec::DecayRate(_) | GainSpec::Lmi)
            }
            Self::Interval(spec) => {
                spec.gain.as_ref().is_none_or(|linear| matches!(linear.gain, GainSpec::DecayRate(_) | GainSpec::Lmi))
            }
            Self::SampledCubic { varying: Some(_), .. }
            | Self::NormFilter(_)
            | Self::Lpv { .. }
            | Self::Lipschitz { .. }
            | Self::MeanValue { .. } => true,
            Self::OptimalCubic(_)
            | Self::HighGain { .. }
            | Self::SlidingMode(_)
            | Self::ReducedOrder(_)
            | Self::Functional { .. }
            | Self::ExtendedKalman { .. }
            | Self::Unscented(_)
            | Self::MovingHorizon(_)
            | Self::Kkl(_)
            | Self::Pebo(_)
            | Self::KklPeb(_)
            | Self::ImmersionInvariance(_)
            | Self::KklNumerical(_) => false,
        }
    }

    /// The name of the kind in study files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Luenberger(_) => "luenberger",
            Self::Kalman(_) => "kalman",
            Self::Cubic { .. } => "cubic",
            Self::OptimalCubic(_) => "optimal-cubic",
            Self::ProportionalIntegral { chain: None, .. } => "proportional-integral",
            Self::ProportionalIntegral { chain: Some(_), .. } => "extended-state",
            Self::UnknownInput { .. } => "unknown-input",
            Self::Interval(_) => "interval",
            Self::SlidingMode(_) => "sliding-mode",
            Self::ReducedOrder(_) => "reduced-order",
            Self::Functional { .. } => "functional",
            Self::NormFilter(spec) => match spec.norm {
                luenberger_design::SystemNorm::HInfinity => "h-infinity",
                luenberger_design::SystemNorm::H2 => "h2",
            },
            Self::SampledCubic { .. } => "sampled-cubic",
            Self::Lpv { .. } => "lpv",
            Self::Lipschitz { .. } => "lipschitz",
            Self::MeanValue { .. } => "mean-value",
            Self::HighGain { .. } => "high-gain",
            Self::ExtendedKalman { .. } => "extended-kalman",
            Self::Unscented(_) => "ukf",
            Self::MovingHorizon(_) => "mhe",
            Self::Kkl(_) => "kkl",
            Self::Pebo(_) => "pebo",
            Self::KklPeb(_) => "kkl-peb",
            Self::ImmersionInvariance(_) => "immersion-invariance",
            Self::KklNumerical(_) => "kkl-numerical",
        }
    }

    /// The sampling period; none in continuous time.
    pub fn period(&self) -> Option<f64> {
        match self {
            Self::SampledCubic { period, .. } | Self::ExtendedKalman { period, .. } => Some(*period),
            Self::SlidingMode(spec) => Some(spec.period),
            Self::Unscented(spec) => Some(spec.period),
            Self::MovingHorizon(spec) => Some(spec.period),
            _ => None,
        }
    }

    /// The period between two multiples of which the estimate stands still in a simulation; none where the observer
    /// predicts between its samples.
    pub fn held_period(&self) -> Option<f64> {
        if self.varying_periods().is_some() { None } else { self.period() }
    }

    /// The periods for which convergence is proved, of an observer at varying periods.
    pub fn varying_periods(&self) -> Option<&luenberger_design::Periods> {
        match self {
            Self::SampledCubic { varying, .. } => varying.as_ref(),
            _ => None,
        }
    }

    /// Whether estimates on a log are smoothed.
    pub fn smooths(&self) -> bool {
        match self {
            Self::ExtendedKalman { smooth, .. } => *smooth,
            Self::Unscented(spec) => spec.smooth,
            _ => false,
        }
    }

    /// The names of the disturbances that are estimated with the state, and of their derivatives: `d1`, `d1_rate`,
    /// `d1_rate2`.
    pub fn estimated_disturbances(&self) -> Vec<String> {
        let Self::ProportionalIntegral { e, chain, .. } = self else { return Vec::new() };
        let suffix = |derivative: usize| match derivative {
            0 => String::new(),
            1 => "_rate".to_owned(),
            k => format!("_rate{k}"),
        };
        let of = |k: usize| (1..=e.ncols()).map(move |j| format!("d{j}{}", suffix(k)));
        (0..chain.unwrap_or(1)).flat_map(of).collect()
    }

    /// K of the functions `z = K x` that are estimated in place of the state, and their names `z1`, `z2`, ..
    pub fn functions(&self) -> Option<(&DMatrix<f64>, Vec<String>)> {
        let Self::Functional { k, .. } = self else { return None };
        Some((k, (1..=k.nrows()).map(|i| format!("z{i}")).collect()))
    }

    /// The region of the design, if it is bounded somewhere.
    pub fn region(&self) -> Option<luenberger_design::Region> {
        let region = match self {
            Self::Lpv { region, .. } | Self::MeanValue { region, .. } | Self::Lipschitz { region, split: None, .. } => {
                region.clone()
            }
            Self::Kkl(kkl) => kkl.region.clone(),
            Self::Pebo(peb) | Self::KklPeb(peb) => peb.region.clone(),
            Self::ImmersionInvariance(spec) => spec.region.clone(),
            Self::KklNumerical(kkl) => luenberger_design::Region::new(&kkl.domain).inputs(&kkl.inputs),
            _ => return None,
        };
        let bounded = |bounds: &(f64, f64)| bounds.0.is_finite() || bounds.1.is_finite();
        let (inputs, time) = (region.input_bounds().unwrap_or_default(), region.time_bounds());
        let bounded = region.states().iter().chain(inputs).chain([&time]).any(bounded);
        bounded.then_some(region)
    }

    /// The same specification with poles and rates scaled by `factor`.
    #[must_use]
    pub fn faster(&self, factor: f64) -> Self {
        let linear = |linear: &LinearSpec| LinearSpec {
            gain: match &linear.gain {
                GainSpec::Poles(poles) => GainSpec::Poles(poles.iter().map(|pole| pole * factor).collect()),
                GainSpec::DecayRate(rate) => GainSpec::DecayRate(rate * factor),
                other => other.clone(),
            },
            weight: linear.weight.clone(),
            is_filter: linear.is_filter,
        };
        let mut kind = self.clone();
        match &mut kind {
            Self::Luenberger(wish)
            | Self::Kalman(wish)
            | Self::Cubic { linear: wish, .. }
            | Self::ProportionalIntegral { linear: wish, .. }
            | Self::UnknownInput { linear: wish, .. }
            | Self::SampledCubic { linear: wish, .. } => *wish = linear(wish),
            Self::Lpv { rate: RateSpec::Rate(rate) | RateSpec::Fastest(rate), .. }
            | Self::Lipschitz { rate, .. }
            | Self::MeanValue { rate, .. } => *rate *= factor,
            Self::ReducedOrder(poles) | Self::Functional { poles, .. } => {
                for pole in poles.iter_mut() {
                    *pole *= factor;
                }
            }
            Self::HighGain { r, .. } => *r /= factor,
            // Gains as for a bound that is factor^n times as large: time in units of 1/factor.
            Self::SlidingMode(spec) => {
                if let Some(gains) = &mut spec.gains {
                    for (i, gain) in gains.iter_mut().enumerate() {
                        *gain *= factor.powi(i32::try_from(i + 1).unwrap_or(i32::MAX));
                    }
                }
            }
            Self::Interval(spec) => {
                if let Some(gain) = &mut spec.gain {
                    *gain = linear(gain);
                }
            }
            Self::KklNumerical(KklSpec { cutoff: Some(cutoff), .. }) => *cutoff *= factor,
            Self::OptimalCubic(_)
            | Self::Lpv { .. }
            | Self::NormFilter(_)
            | Self::ExtendedKalman { .. }
            | Self::Unscented(_)
            | Self::MovingHorizon(_)
            | Self::KklNumerical(_)
            | Self::Kkl(_)
            | Self::Pebo(_)
            | Self::KklPeb(_)
            | Self::ImmersionInvariance(_) => {}
        }
        kind
    }

    /// The same with cubic term of strength `gamma`; none for kinds without one.
    #[must_use]
    pub fn with_gamma(&self, gamma: f64) -> Option<Self> {
        use luenberger_design::CubicGain;
        let mut kind = self.clone();
        match &mut kind {
            Self::Cubic { correction: CubicGain::Gamma(value) | CubicGain::Radial(value), .. }
            | Self::SampledCubic { correction: CubicGain::Gamma(value) | CubicGain::Radial(value), .. } => {
                *value = gamma;
            }
            Self::ProportionalIntegral { cubic: Some((_, value)), .. }
            | Self::UnknownInput { cubic: Some((_, value)), .. } => *value = gamma,
            _ => return None,
        }
        Some(kind)
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
}
