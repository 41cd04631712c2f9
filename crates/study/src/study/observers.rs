//! The observers of a study and their design specifications.

use luenberger_clock::Instant;
use luenberger_design::{GainOptions, KalmanNoise};
use luenberger_lmi::Solver;
use nalgebra::{Complex, DMatrix};

use super::kind::ObserverKind;
use crate::diagnostic::Place;

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

impl ObserverSpec {
    /// An observer of this kind, without limits of its gain and without bounds of noise and disturbances.
    ///
    /// ```
    /// use luenberger_study::kinds::Luenberger;
    /// use luenberger_study::study::{GainSpec, ObserverSpec};
    /// use luenberger_study::{Format, RunOptions, Step, Study, execute, template};
    ///
    /// // The plant and the run of a file, with an observer in the place of its own ones.
    /// let text = template::template("double-integrator")?.text;
    /// let study = Study::from_text("study.toml", text, Format::Toml, ".".as_ref())?;
    /// let gain = GainSpec::Poles(vec![(-3.0).into(), (-4.0).into()]);
    /// let observer = ObserverSpec::new("calm", Luenberger(gain.into()), &[0.0, 0.0]);
    /// let study = Study { observers: vec![observer], sweep: None, ..study };
    /// let results = execute(&study, Step::Design, &RunOptions::default())?;
    /// assert!(results.observers[0].name == "calm" && results.failures().is_empty());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(name: impl Into<String>, kind: impl Into<ObserverKind>, initial: &[f64]) -> Self {
        let (kind, limits, place) = (kind.into(), GainLimits::default(), Place::default());
        Self { name: name.into(), initial: initial.to_vec(), kind, limits, bounds: None, place }
    }
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

impl From<GainSpec> for LinearSpec {
    fn from(gain: GainSpec) -> Self {
        Self { gain, weight: None, is_filter: false }
    }
}

/// How the gain of a linear observer is computed.
#[derive(Debug, Clone, PartialEq)]
pub enum GainSpec {
    /// Pole placement: the eigenvalues of `A - L C`.
    Poles(Vec<Complex<f64>>),
    /// The stationary Kalman gain for this noise.
    Kalman(KalmanNoise),
    /// A decay rate, by an LMI.
    DecayRate(f64),
    /// The gain with the largest margin of the LMI.
    Lmi,
    /// A given L, n x p.
    Given(DMatrix<f64>),
}

/// Poles that are `factor` times as fast: `factor s` in continuous time, and `z^factor` in discrete time with the
/// period `dt`, where `z = exp(s dt)`.
///
/// A real pole stays real with its sign, and conjugates stay conjugates: a negative z is no `exp(s dt)` of a real s.
///
/// ```
/// use luenberger_study::study::faster_poles;
/// // exp(-1 dt) becomes exp(-2 dt).
/// let z = |s: f64| (0.1 * s).exp();
/// let faster = faster_poles(&[z(-1.0).into()], 2.0, Some(0.1));
/// assert!((faster[0].re - z(-2.0)).abs() < 1e-15);
/// assert_eq!(faster_poles(&[(-1.0).into()], 2.0, None)[0].re, -2.0);
/// ```
pub fn faster_poles(poles: &[Complex<f64>], factor: f64, dt: Option<f64>) -> Vec<Complex<f64>> {
    let faster = |pole: &Complex<f64>| match dt {
        None => pole * factor,
        Some(_) if pole.im == 0.0 => Complex::from(pole.re.abs().powf(factor).copysign(pole.re)),
        Some(_) => pole.powf(factor),
    };
    poles.iter().map(faster).collect()
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

impl LinearSpec {
    /// Whether the gain is that of a matrix inequality.
    pub fn poses_inequality(&self) -> bool {
        matches!(self.gain, GainSpec::DecayRate(_) | GainSpec::Lmi)
    }

    /// The same `factor` times as fast, for a plant in continuous time, or in discrete time with the period `dt`: poles
    /// by [`faster_poles`], and rates times the factor, since they are per unit of time in both.
    #[must_use]
    pub fn faster(&self, factor: f64, dt: Option<f64>) -> Self {
        let gain = match &self.gain {
            GainSpec::Poles(poles) => GainSpec::Poles(faster_poles(poles, factor, dt)),
            GainSpec::DecayRate(rate) => GainSpec::DecayRate(rate * factor),
            other => other.clone(),
        };
        Self { gain, weight: self.weight.clone(), is_filter: self.is_filter }
    }
}
