//! Keys and tables that kinds of observers share.

use crate::keys::{Key, Range, Table, Type, Variant, Variants, optional, required};

pub(crate) const POLES: Key = optional(
    "poles",
    Type::Poles,
    "Eigenvalues of A - L C: n numbers, complex ones as [re, im] with their conjugates.",
);
pub(crate) const DECAY: Key = optional(
    "decay_rate",
    Type::Number(Range::Positive),
    "Decay rate: every error decays at least as fast as exp(-decay_rate t), in discrete time by exp(-decay_rate dt) at each step. The gain is computed by a linear matrix inequality.",
);
pub(crate) const LMI: Key =
    optional("lmi", Type::Switch, "true: the gain is that of the linear matrix inequality with the largest margin.");
pub(crate) const MAX_GAIN: Key = optional(
    "max_gain",
    Type::Number(Range::Positive),
    "Where an inequality gives L (decay_rate, lmi, fastest, or a norm): upper bound of the spectral norm of L (default: none).",
);
pub(crate) const NOISE: Key = optional(
    "noise",
    Type::Weight,
    "With decay_rate, lmi or fastest: intensity V of the measurement noise, p x p (sample variance times sampling period), in discrete time its covariance at a sample; among the gains with the rate, the one with the least noise gain is chosen.",
);
pub(crate) const KALMAN: Key =
    optional("kalman", Type::Table(&NOISES), "Noise intensities; the gain is that of the stationary Kalman filter.");
pub(crate) const GAIN: Key = optional("gain", Type::Rows, "A given gain L, n x p.");
pub(crate) const RHO: Key = optional(
    "rho",
    Type::Number(Range::Positive),
    "Q = rho I in the Lyapunov equation (A - LC)'P + P(A - LC) + Q = 0 that certifies the gain (default 1).",
);
pub(crate) const Q: Key = optional("q", Type::Rows, "Q of that equation, n x n, in place of rho.");
/// The ways to the gain of an observer of a linear plant.
pub(super) const GAINS: &[Key] = &[POLES, DECAY, LMI, KALMAN, GAIN];
/// What certifies that gain, and limits it.
pub(super) const OF_GAIN: &[Key] = &[RHO, Q, MAX_GAIN, NOISE];
/// The maps of a KKL observer, behind phi and Lambda.
pub(super) const MAPS: &[Key] = &[B, LEFT_INVERSE, BOUNDED];
/// The regression and the estimator of a PEBO.
pub(super) const REGRESSION: &[Key] = &[
    SIGNAL,
    KNOWN,
    REGRESSOR,
    MISSING,
    THETA_REGION,
    THETA_MIN,
    THETA_START,
    ALPHA,
    ESTIMATOR,
    LEAKAGE,
    RESET,
    WINDOW,
];
pub(crate) const THETA: Key =
    optional("theta", Type::Weight, "Weight theta of the cubic term, p x p (default: the identity).");
pub(crate) const REGION: Key =
    optional("region", Type::Table(&BOX), "Region of x and xhat for which the design holds (default: all states).");
pub(crate) const W: Key = required("w", Type::Weight, "Intensity W of the process noise, n x n, per unit of time.");
pub(crate) const V: Key = required(
    "v",
    Type::Weight,
    "Intensity V of the measurement noise, p x p; with `period` its covariance at a sample.",
);
pub(crate) const NOISE_ENTERING: Key = optional(
    "g",
    Type::Rows,
    "G, n x q, of process noise that enters as x' = A x + B u + G w; W is then q x q (default: the identity).",
);
pub(crate) const CROSS_INTENSITY: Key = optional(
    "s",
    Type::Rows,
    "Cross-intensity S = E w v' of process and measurement noise, n x p, with g q x p (default: 0).",
);
pub(crate) const RECOVERY: Key = optional(
    "recovery",
    Type::Number(Range::NotNegative),
    "q of loop transfer recovery at the inputs, for plants in continuous time: q^2 B B' is added to the process noise of the states, so that the loop of a feedback tends to that of state feedback as q grows (default 0).",
);
pub(crate) const PERIOD: Key = required("period", Type::Number(Range::Positive), "Sampling period.");
pub(crate) const GATE: Key = optional(
    "gate",
    Type::Number(Range::Positive),
    "An output whose innovation is beyond this many standard deviations is rejected as an outlier (default none; 5 is usual).",
);
pub(crate) const SMOOTH: Key = optional(
    "smooth",
    Type::Switch,
    "true: on a log also the estimates from the whole log, by the fixed-interval smoother of Rauch, Tung and Striebel (default false).",
);

pub(crate) const ERROR_BOUNDS: Key = optional(
    "bounds",
    Type::Table(&ACTING),
    "Bounds of noise and disturbances: the certificate states a bound of each error in the end, and how fast it is reached.",
);
pub(crate) const UNKNOWN: Key =
    required("e", Type::Rows, "E, n x q: the disturbance d enters as x' = A x + B u + E d (x+ in discrete time).");
pub(crate) const UNKNOWN_OF_ADVICE: Key = optional(
    "e",
    Type::Rows,
    "E, n x q, of an unknown disturbance d, x' = A x + B u + E d (default: that of the first observer of the study that has one, else no disturbance).",
);
pub(crate) const GAMMA: Key = optional(
    "gamma",
    Type::Number(Range::Positive),
    "Gain of a cubic term, N = -gamma P^-1 C' theta (default: none, a linear observer).",
);

const ACTING: Table = Table {
    name: "bounds",
    about: "Bounds of noise and disturbances.",
    variants: None,
    keys: &[
        optional(
            "noise",
            Type::Numbers(Range::NotNegative),
            "Bound of the measurement noise of each output, p numbers (default: the amplitudes of the uniform noise of the simulation, or else 0).",
        ),
        optional(
            "disturbance",
            Type::Numbers(Range::NotNegative),
            "Bounds of disturbances w, x' = A x + B u + E w, x+ in discrete time (default: none).",
        ),
        optional(
            "e",
            Type::Rows,
            "E, with a row for each state and a column for each disturbance (default: the identity).",
        ),
        optional(
            "states",
            Type::Numbers(Range::NotNegative),
            "With deviations, or m and h: bounds of the magnitudes of the states, n numbers.",
        ),
        optional(
            "deviations",
            Type::Tables(&DEVIATION),
            "Uncertain plant: A(t) - A lies in the convex hull of these matrices (default: A is exact).",
        ),
        optional("m", Type::Rows, "Uncertain plant: A(t) - A = M G(t) H with any G of norm 1 at most; M, n x q."),
        optional("h", Type::Rows, "H, r x n."),
    ],
};

const DEVIATION: Table = Table {
    name: "deviations",
    about: "A deviation of the state matrix.",
    variants: None,
    keys: &[required("a", Type::Rows, "A(t) - A, n x n.")],
};

const NOISES: Table = Table {
    name: "kalman",
    about: "Noise intensities.",
    variants: None,
    keys: &[
        required("w", Type::Weight, "Intensity W of the process noise, n x n."),
        required("v", Type::Weight, "Intensity V of the measurement noise, p x p."),
        NOISE_ENTERING,
        CROSS_INTENSITY,
        RECOVERY,
    ],
};

pub(crate) const BOX: Table = Table {
    name: "region",
    about: "Bounds of the states, and of inputs and time if the equations depend on them.",
    variants: None,
    keys: &[
        optional("states", Type::Bounds, "n pairs [lower, upper]; bounds may be inf or -inf (default: no bounds)."),
        optional("inputs", Type::Bounds, "m pairs [lower, upper] (default: no bounds)."),
        optional("time", Type::Bound, "A pair [lower, upper] (default: no bounds)."),
    ],
};

pub(crate) const PHI: Key = required(
    "phi",
    Type::Expressions,
    "phi(x), one expression of the states for each state xi1, xi2, .. of the observer: where they tend to.",
);
pub(crate) const LAMBDA: Key = required(
    "lambda",
    Type::ExpressionRows,
    "Lambda, as rows or as the list of its diagonal: numbers, and expressions of the inputs, the outputs and the time.",
);
pub(crate) const B: Key = required(
    "b",
    Type::Expressions,
    "B(y, u), one expression of inputs and outputs for each xi; row i may also use xi1 to xi(i-1).",
);
pub(crate) const LEFT_INVERSE: Key = required(
    "left_inverse",
    Type::Expressions,
    "phi^L(xi, y), one expression of xi1, .. and the outputs for each state of the plant.",
);
pub(crate) const BOUNDED: Key = required(
    "region",
    Type::Table(&BOX),
    "Region over which the maps are checked: bounds of every state and every input.",
);

pub(crate) const SIGNAL: Key =
    required("s", Type::Expressions, "s(y) of the regression d s(y)/dt = g + m theta: expressions of the outputs.");
pub(crate) const KNOWN: Key =
    required("g", Type::Expressions, "g(xi, u, y) of the regression, one expression for each entry of `s`.");
pub(crate) const REGRESSOR: Key = required(
    "m",
    Type::ExpressionRows,
    "m(xi, u, y) of the regression, one row for each entry of `s`, one column for each parameter; or the list of its diagonal.",
);
pub(crate) const MISSING: Key = optional(
    "missing",
    Type::Expressions,
    "What is missing in xi, phi(x) = xi + missing: one expression of theta1, .. for each xi (default: theta in the rows of zeros of Lambda, in their order).",
);
pub(crate) const THETA_REGION: Key = optional(
    "theta",
    Type::Bounds,
    "Region of theta over which the regression is checked, one pair [lower, upper] for each parameter (default [-1, 1], or [theta_min, theta_min + 1]).",
);
pub(crate) const THETA_MIN: Key = optional(
    "theta_min",
    Type::Numbers(Range::Any),
    "Least value of each parameter: the estimate is held there (default: none).",
);
pub(crate) const THETA_START: Key =
    optional("theta_start", Type::Number(Range::Any), "First estimate of every parameter (default 0).");
pub(crate) const ALPHA: Key =
    required("alpha", Type::Number(Range::Positive), "The filters of the regression are alpha/(p + alpha).");
pub(crate) const ESTIMATOR: Key = required("estimator", Type::Table(&ESTIMATORS), "Estimator of theta in Y = M theta.");
pub(crate) const LEAKAGE: Key = optional(
    "leakage",
    Type::Number(Range::NotNegative),
    "Leakage of the rows of zeros, xi' = B - leakage xi: xi stays bounded, and theta is no longer constant (default 0).",
);
pub(crate) const RESET: Key = optional(
    "reset",
    Type::Table(&RESETS),
    "Resets of the rows of zeros: xi takes over theta_hat, which begins again at theta_start; the estimate is continuous (default: none).",
);
const RESETS: Table = Table {
    name: "reset",
    about: "Resets of the open integration.",
    variants: None,
    keys: &[
        required("period", Type::Number(Range::Positive), "Time from one reset to the next."),
        optional(
            "above",
            Type::Number(Range::Positive),
            "At these instants xi is reset only if one of its rows of zeros is larger than this in magnitude (default: always).",
        ),
    ],
};
pub(crate) const WINDOW: Key = optional(
    "window",
    Type::Number(Range::Positive),
    "Length of the windows in which the run of [simulation] has to excite the regression (default: the whole run).",
);

const GAIN_OF_ESTIMATOR: Key = required(
    "gain",
    Type::Weight,
    "Gain: a number, one number for each parameter, or for gradient the matrix Gamma, q x q.",
);

const ESTIMATORS: Table = Table {
    name: "estimator",
    about: "Estimator of the parameters theta in Y = M theta.",
    keys: &[GAIN_OF_ESTIMATOR],
    variants: Some(Variants { tag: "kind", of: || vec![GRADIENT, DREM] }),
};

const GRADIENT: Variant = Variant { name: "gradient", about: "theta' = Gamma M'(Y - M theta).", keys: &[] };

const DREM: Variant = Variant {
    name: "drem",
    about: "Dynamic regressor extension and mixing: each parameter by its own equation.",
    keys: &[&[
        optional(
            "forgetting",
            Type::Number(Range::Positive),
            "Extension by Kreisselmeier's filters Phi' = -a Phi + M'M with this rate a.",
        ),
        optional(
            "filters",
            Type::Numbers(Range::Positive),
            "Extension by filters beta/(p + beta) of the regression: q/r - 1 numbers beta.",
        ),
    ]],
};
