//! The observers of a study and their design specifications.

use std::time::Instant;

use luenberger_design::GainOptions;
use luenberger_design::numerical_kkl::{low_rank_trajectories, searched_tables};
use luenberger_lmi::Solver;
use nalgebra::{Complex, DMatrix};

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
    /// use luenberger_study::study::{GainSpec, ObserverKind, ObserverSpec};
    /// use luenberger_study::{Format, RunOptions, Step, Study, execute, template};
    ///
    /// // The plant and the run of a file, with an observer in the place of its own ones.
    /// let text = template::template("double-integrator")?.text;
    /// let study = Study::from_text("study.toml", text, Format::Toml, ".".as_ref())?;
    /// let gain = GainSpec::Poles(vec![(-3.0).into(), (-4.0).into()]);
    /// let observer = ObserverSpec::new("calm", ObserverKind::Luenberger(gain.into()), &[0.0, 0.0]);
    /// let study = Study { observers: vec![observer], sweep: None, ..study };
    /// let results = execute(&study, Step::Design, &RunOptions::default())?;
    /// assert!(results.observers[0].name == "calm" && results.failures().is_empty());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(name: impl Into<String>, kind: ObserverKind, initial: &[f64]) -> Self {
        let (limits, place) = (GainLimits::default(), Place::default());
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

/// Specification of an H-infinity or H2 filter.
#[derive(Debug, Clone, PartialEq)]
pub struct NormFilterSpec {
    /// The norm.
    pub norm: luenberger_design::SystemNorm,
    /// What acts on the plant, and the errors that count.
    pub performance: luenberger_design::GeneralizedPlant,
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
    /// The mean-value-theorem observer, with output injection or as printed.
    MeanValue {
        /// The box.
        region: luenberger_design::Region,
        /// The rate.
        rate: f64,
        /// eta.
        eta: f64,
        /// e(0).
        internal_error: Vec<f64>,
        /// The mean of the Jacobian of the observer as printed; none with output injection.
        printed: Option<PrintedMean>,
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
        /// Runge-Kutta steps per sampling period on a target; none for as many as their error needs.
        substeps: Option<usize>,
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

/// How the mean of the Jacobian over the segment from xhat to xhat + e is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PrintedMean {
    /// beta by bounded nonlinear least squares, as in the paper.
    LeastSquares,
    /// beta by bracketing.
    Root,
    /// The integral.
    Integral,
}

/// Specification of a sliding-mode observer.
#[derive(Debug, Clone, PartialEq)]
pub struct SlidingModeSpec {
    /// The bound of |d|, the disturbance and the model error in the equation of x_n.
    pub bound: f64,
    /// The gains, n of them; none for those that follow from the bound.
    pub gains: Option<Vec<f64>>,
    /// The sampling period.
    pub period: f64,
    /// Whether the explicit Euler method is used, for comparison.
    pub explicit: bool,
}

impl SlidingModeSpec {
    /// The gains that follow from the bound, and the implicit discretisation.
    pub fn new(bound: f64, period: f64) -> Self {
        Self { bound, gains: None, period, explicit: false }
    }
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
    /// Runge-Kutta steps per sampling period on a target; none for as many as their error needs.
    pub substeps: Option<usize>,
    /// How many standard deviations an innovation may have; none for no limit.
    pub gate: Option<f64>,
    /// Whether estimates on a log are smoothed.
    pub smooth: bool,
}

impl UnscentedSpec {
    /// The filter for noise of intensity W and covariance V, with P(0) = I and the usual sigma points.
    pub fn new(w: DMatrix<f64>, v: DMatrix<f64>, period: f64) -> Self {
        let (p0, sigma) = (DMatrix::identity(w.nrows(), w.nrows()), luenberger_observers::SigmaPoints::default());
        Self { w, v, p0, sigma, period, substeps: None, gate: None, smooth: false }
    }
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
    /// Runge-Kutta steps per sampling period on a target; none for as many as their error needs.
    pub substeps: Option<usize>,
    /// Samples in the window, and Gauss-Newton steps at each.
    pub horizon: luenberger_observers::Horizon,
    /// Bounds of the states, if there are some; infinite ones are none.
    pub bounds: Option<Vec<(f64, f64)>>,
}

/// The horizon, where none is given.
pub(crate) const HORIZON: luenberger_observers::Horizon = luenberger_observers::Horizon { window: 10, iterations: 2 };

impl MovingHorizonSpec {
    /// The estimator for noise of intensity W and covariance V, with P(0) = I, a window of ten samples and no bounds.
    pub fn new(w: DMatrix<f64>, v: DMatrix<f64>, period: f64) -> Self {
        let p0 = DMatrix::identity(w.nrows(), w.nrows());
        Self { w, v, p0, period, substeps: None, horizon: HORIZON, bounds: None }
    }
}

/// With more states the table of a numerical KKL observer is of low rank.
pub(crate) const MOST_STATES_OF_A_FULL_TABLE: usize = 4;

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
    /// Largest rank of the table, for more states than a full table can have.
    pub rank: usize,
    /// Whether the embedded form is simulated.
    pub embedded: bool,
    /// Bounds of the inputs, which are held at constant values; empty for a plant without inputs.
    pub inputs: Vec<(f64, f64)>,
    /// Values of each input for which there is a table.
    pub nodes: usize,
}

impl KklSpec {
    /// The observer of a plant without inputs on this box of its states, with the defaults of a study.
    pub fn new(domain: Vec<(f64, f64)>) -> Self {
        let degree = if domain.len() > MOST_STATES_OF_A_FULL_TABLE { 3 } else { 4 };
        Self {
            domain,
            cutoff: None,
            escape: None,
            points: None,
            leaves: 32,
            degree,
            samples: 8000,
            rank: 24,
            embedded: false,
            inputs: Vec::new(),
            nodes: 5,
        }
    }

    /// Grid points per axis of all tables that the design may compute for a plant with so many states, those of the
    /// search included.
    pub fn tables(&self, states: usize) -> Vec<usize> {
        let mut tables = searched_tables(self.cutoff, self.points, states);
        let last = tables.iter().copied().max().or(self.points);
        tables.extend(last.into_iter().flat_map(|points| core::iter::repeat_n(points, self.family())));
        tables
    }

    /// Trajectories backward in time that a table with so many points per axis takes.
    pub fn trajectories(&self, states: usize, points: usize) -> f64 {
        if states > MOST_STATES_OF_A_FULL_TABLE {
            low_rank_trajectories(states, points, self.rank)
        } else {
            (points as f64).powf(states as f64)
        }
    }

    /// Values of the inputs for which there are tables; one without inputs.
    pub fn family(&self) -> usize {
        self.nodes.pow(self.inputs.len() as u32)
    }
}
