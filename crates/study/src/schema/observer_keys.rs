//! Keys and tables that kinds of observers share.

use super::table::{Key, Kind, Range, Table, Variant, Variants, optional, required};

pub(super) const POLES: Key = optional(
    "poles",
    Kind::Poles,
    "Eigenvalues of A - L C: n numbers, complex ones as [re, im] with their conjugates.",
);
pub(super) const DECAY: Key = optional(
    "decay_rate",
    Kind::Number(Range::Positive),
    "Decay rate: every error decays at least as fast as exp(-decay_rate t). The gain is computed by a linear matrix inequality.",
);
pub(super) const LMI: Key =
    optional("lmi", Kind::Switch, "true: the gain is that of the linear matrix inequality with the largest margin.");
pub(super) const MAX_GAIN: Key = optional(
    "max_gain",
    Kind::Number(Range::Positive),
    "Where an inequality gives L (decay_rate, lmi, fastest, or a norm): upper bound of the spectral norm of L (default: none).",
);
pub(super) const NOISE: Key = optional(
    "noise",
    Kind::Weight,
    "With decay_rate, lmi or fastest: intensity V of the measurement noise, p x p (sample variance times sampling period); among the gains with the rate, the one with the least noise gain is chosen.",
);
pub(super) const KALMAN: Key =
    optional("kalman", Kind::Table(&NOISES), "Noise intensities; the gain is that of the stationary Kalman filter.");
pub(super) const GAIN: Key = optional("gain", Kind::Rows, "A given gain L, n x p.");
pub(super) const RHO: Key = optional(
    "rho",
    Kind::Number(Range::Positive),
    "Q = rho I in the Lyapunov equation (A - LC)'P + P(A - LC) + Q = 0 that certifies the gain (default 1).",
);
pub(super) const Q: Key = optional("q", Kind::Rows, "Q of that equation, n x n, in place of rho.");
pub(super) const THETA: Key =
    optional("theta", Kind::Weight, "Weight theta of the cubic term, p x p (default: the identity).");
pub(super) const REGION: Key =
    optional("region", Kind::Table(&BOX), "Region of x and xhat for which the design holds (default: all states).");
pub(super) const W: Key = required("w", Kind::Weight, "Intensity W of the process noise, n x n, per unit of time.");
pub(super) const V: Key = required(
    "v",
    Kind::Weight,
    "Intensity V of the measurement noise, p x p; for extended-kalman, ukf and mhe its covariance at a sample.",
);
pub(super) const PERIOD: Key = required("period", Kind::Number(Range::Positive), "Sampling period.");

pub(super) const P0: Key =
    optional("p0", Kind::Weight, "Covariance of the initial error, n x n (default: the identity).");
pub(super) const SUBSTEPS: Key = optional(
    "substeps",
    Kind::Count(1),
    "Runge-Kutta steps per sampling period in exported code (default: as many as their error needs). Elsewhere the prediction controls its error.",
);
pub(super) const GATE: Key = optional(
    "gate",
    Kind::Number(Range::Positive),
    "An output whose innovation is beyond this many standard deviations is rejected as an outlier (default none; 5 is usual).",
);
pub(super) const SMOOTH: Key = optional(
    "smooth",
    Kind::Switch,
    "true: on a log also the estimates from the whole log, by the fixed-interval smoother of Rauch, Tung and Striebel (default false).",
);

pub(super) const ERROR_BOUNDS: Key = optional(
    "bounds",
    Kind::Table(&ACTING),
    "Bounds of noise and disturbances: the certificate states a bound of each error in the end, and how fast it is reached.",
);
pub(super) const UNKNOWN: Key =
    required("e", Kind::Rows, "E, n x q: the disturbance d enters as x' = A x + B u + E d.");
pub(super) const UNKNOWN_OF_ADVICE: Key = optional(
    "e",
    Kind::Rows,
    "E, n x q, of an unknown disturbance d, x' = A x + B u + E d (default: that of the first observer of the study that has one, else no disturbance).",
);
pub(super) const GAMMA: Key = optional(
    "gamma",
    Kind::Number(Range::Positive),
    "Gain of a cubic term, N = -gamma P^-1 C' theta (default: none, a linear observer).",
);

const ACTING: Table = Table {
    name: "bounds",
    about: "Bounds of noise and disturbances.",
    variants: None,
    keys: &[
        optional(
            "noise",
            Kind::Numbers(Range::NotNegative),
            "Bound of the measurement noise of each output, p numbers (default: the amplitudes of the uniform noise of the simulation, or else 0).",
        ),
        optional(
            "disturbance",
            Kind::Numbers(Range::NotNegative),
            "Bounds of disturbances w, x' = A x + B u + E w (default: none).",
        ),
        optional(
            "e",
            Kind::Rows,
            "E, with a row for each state and a column for each disturbance (default: the identity).",
        ),
        optional(
            "states",
            Kind::Numbers(Range::NotNegative),
            "With deviations, or m and h: bounds of the magnitudes of the states, n numbers.",
        ),
        optional(
            "deviations",
            Kind::Tables(&DEVIATION),
            "Uncertain plant: A(t) - A lies in the convex hull of these matrices (default: A is exact).",
        ),
        optional("m", Kind::Rows, "Uncertain plant: A(t) - A = M G(t) H with any G of norm 1 at most; M, n x q."),
        optional("h", Kind::Rows, "H, r x n."),
    ],
};

const DEVIATION: Table = Table {
    name: "deviations",
    about: "A deviation of the state matrix.",
    variants: None,
    keys: &[required("a", Kind::Rows, "A(t) - A, n x n.")],
};

const NOISES: Table = Table {
    name: "kalman",
    about: "Noise intensities.",
    variants: None,
    keys: &[
        required("w", Kind::Weight, "Intensity W of the process noise, n x n."),
        required("v", Kind::Weight, "Intensity V of the measurement noise, p x p."),
    ],
};

pub(super) const BOX: Table = Table {
    name: "region",
    about: "Bounds of the states, and of inputs and time if the equations depend on them.",
    variants: None,
    keys: &[
        optional("states", Kind::Bounds, "n pairs [lower, upper]; bounds may be inf or -inf (default: no bounds)."),
        optional("inputs", Kind::Bounds, "m pairs [lower, upper] (default: no bounds)."),
        optional("time", Kind::Bound, "A pair [lower, upper] (default: no bounds)."),
    ],
};

pub(super) const SECTOR: Table = Table {
    name: "sectors",
    about: "A nonlinearity G phi(t, H x, u) whose slope lies between low and high.",
    variants: None,
    keys: &[
        required("g", Kind::Rows, "G, n x q."),
        required("h", Kind::Rows, "H, q x n."),
        required("low", Kind::Number(Range::Any), "Smallest slope; -gamma for a Lipschitz constant gamma."),
        required("high", Kind::Number(Range::Any), "Largest slope; gamma for a Lipschitz constant gamma."),
    ],
};

pub(super) const PHI: Key = required(
    "phi",
    Kind::Expressions,
    "phi(x), one expression of the states for each state xi1, xi2, .. of the observer: where they tend to.",
);
pub(super) const LAMBDA: Key = required(
    "lambda",
    Kind::ExpressionRows,
    "Lambda, as rows or as the list of its diagonal: numbers, and expressions of the inputs, the outputs and the time.",
);
pub(super) const B: Key = required(
    "b",
    Kind::Expressions,
    "B(y, u), one expression of inputs and outputs for each xi; row i may also use xi1 to xi(i-1).",
);
pub(super) const LEFT_INVERSE: Key = required(
    "left_inverse",
    Kind::Expressions,
    "phi^L(xi, y), one expression of xi1, .. and the outputs for each state of the plant.",
);
pub(super) const BOUNDED: Key = required(
    "region",
    Kind::Table(&BOX),
    "Region over which the maps are checked: bounds of every state and every input.",
);

pub(super) const SIGNAL: Key =
    required("s", Kind::Expressions, "s(y) of the regression d s(y)/dt = g + m theta: expressions of the outputs.");
pub(super) const KNOWN: Key =
    required("g", Kind::Expressions, "g(xi, u, y) of the regression, one expression for each entry of `s`.");
pub(super) const REGRESSOR: Key = required(
    "m",
    Kind::ExpressionRows,
    "m(xi, u, y) of the regression, one row for each entry of `s`, one column for each parameter; or the list of its diagonal.",
);
pub(super) const MISSING: Key = optional(
    "missing",
    Kind::Expressions,
    "What is missing in xi, phi(x) = xi + missing: one expression of theta1, .. for each xi (default: theta in the rows of zeros of Lambda, in their order).",
);
pub(super) const THETA_REGION: Key = optional(
    "theta",
    Kind::Bounds,
    "Region of theta over which the regression is checked, one pair [lower, upper] for each parameter (default [-1, 1], or [theta_min, theta_min + 1]).",
);
pub(super) const THETA_MIN: Key = optional(
    "theta_min",
    Kind::Numbers(Range::Any),
    "Least value of each parameter: the estimate is held there (default: none).",
);
pub(super) const THETA_START: Key =
    optional("theta_start", Kind::Number(Range::Any), "First estimate of every parameter (default 0).");
pub(super) const ALPHA: Key =
    required("alpha", Kind::Number(Range::Positive), "The filters of the regression are alpha/(p + alpha).");
pub(super) const ESTIMATOR: Key = required("estimator", Kind::Table(&ESTIMATORS), "Estimator of theta in Y = M theta.");
pub(super) const LEAKAGE: Key = optional(
    "leakage",
    Kind::Number(Range::NotNegative),
    "Leakage of the rows of zeros, xi' = B - leakage xi: xi stays bounded, and theta is no longer constant (default 0).",
);
pub(super) const RESET: Key = optional(
    "reset",
    Kind::Table(&RESETS),
    "Resets of the rows of zeros: xi takes over theta_hat, which begins again at theta_start; the estimate is continuous (default: none).",
);
const RESETS: Table = Table {
    name: "reset",
    about: "Resets of the open integration.",
    variants: None,
    keys: &[
        required("period", Kind::Number(Range::Positive), "Time from one reset to the next."),
        optional(
            "above",
            Kind::Number(Range::Positive),
            "At these instants xi is reset only if one of its rows of zeros is larger than this in magnitude (default: always).",
        ),
    ],
};
pub(super) const WINDOW: Key = optional(
    "window",
    Kind::Number(Range::Positive),
    "Length of the windows in which the run of [simulation] has to excite the regression (default: the whole run).",
);

const GAIN_OF_ESTIMATOR: Key = required(
    "gain",
    Kind::Weight,
    "Gain: a number, one number for each parameter, or for gradient the matrix Gamma, q x q.",
);

const ESTIMATORS: Table = Table {
    name: "estimator",
    about: "Estimator of the parameters theta in Y = M theta.",
    keys: &[GAIN_OF_ESTIMATOR],
    variants: Some(Variants {
        tag: "kind",
        of: &[
            Variant { name: "gradient", about: "theta' = Gamma M'(Y - M theta).", keys: &[] },
            Variant {
                name: "drem",
                about: "Dynamic regressor extension and mixing: each parameter by its own equation.",
                keys: &[
                    optional(
                        "forgetting",
                        Kind::Number(Range::Positive),
                        "Extension by Kreisselmeier's filters Phi' = -a Phi + M'M with this rate a.",
                    ),
                    optional(
                        "filters",
                        Kind::Numbers(Range::Positive),
                        "Extension by filters beta/(p + beta) of the regression: q/r - 1 numbers beta.",
                    ),
                ],
            },
        ],
    }),
};

pub(super) const ENTERING: Key = required(
    "e",
    Kind::Rows,
    "E, n x q: disturbances and noises w enter as x' = A x + B u + E w (x+ in discrete time).",
);
pub(super) const MEASURED_NOISE: Key =
    required("d", Kind::Rows, "D, p x q: the same w enters the outputs, y = C x + D w.");
pub(super) const COUNTED: Key =
    optional("h", Kind::Rows, "H, r x n: the errors z = H e that count (default: those of all states).");
pub(super) const BOUND_OF_NORM: Key = optional(
    "gamma",
    Kind::Number(Range::Positive),
    "Bound of the norm from w to z (default: the least; for h-infinity 1 % above it).",
);
pub(super) const THIS_GAIN: Key =
    optional("gain", Kind::Rows, "In place of a design: the norm of a given gain L, n x p.");
