//! The kinds of observers of a study, with their specifications.

use super::keys::{optional, required};
use super::{Key, Kind, Range, Table, Variant, Variants};

/// `[[observer]]`.
pub(crate) const OBSERVER: Table = Table {
    name: "[[observer]]",
    about: "An observer and its specification.",
    keys: &[
        optional("name", Kind::Name, "Name in figures, tables and file names (default: its kind)."),
        optional(
            "initial",
            Kind::Numbers(Range::Any),
            "Initial estimate, n numbers (default: the operating point, if there is one, or else 0).",
        ),
    ],
    variants: Some(Variants { tag: "kind", of: KINDS }),
};

const POLES: Key = optional(
    "poles",
    Kind::Poles,
    "Eigenvalues of A - L C: n numbers, complex ones as [re, im] with their conjugates.",
);
const DECAY: Key = optional(
    "decay_rate",
    Kind::Number(Range::Positive),
    "Decay rate: every error decays at least as fast as exp(-decay_rate t). The gain is computed by a linear matrix inequality.",
);
const LMI: Key =
    optional("lmi", Kind::Switch, "true: the gain is that of the linear matrix inequality with the largest margin.");
const MAX_GAIN: Key = optional(
    "max_gain",
    Kind::Number(Range::Positive),
    "Where an inequality gives L (decay_rate, lmi, fastest, or a norm): upper bound of the spectral norm of L (default: none).",
);
const NOISE: Key = optional(
    "noise",
    Kind::Weight,
    "With decay_rate, lmi or fastest: intensity V of the measurement noise, p x p (sample variance times sampling period); among the gains with the rate, the one with the least noise gain is chosen.",
);
const KALMAN: Key =
    optional("kalman", Kind::Table(&NOISES), "Noise intensities; the gain is that of the stationary Kalman filter.");
const GAIN: Key = optional("gain", Kind::Rows, "A given gain L, n x p.");
const RHO: Key = optional(
    "rho",
    Kind::Number(Range::Positive),
    "Q = rho I in the Lyapunov equation (A - LC)'P + P(A - LC) + Q = 0 that certifies the gain (default 1).",
);
const Q: Key = optional("q", Kind::Rows, "Q of that equation, n x n, in place of rho.");
const THETA: Key = optional("theta", Kind::Weight, "Weight theta of the cubic term, p x p (default: the identity).");
const REGION: Key =
    optional("region", Kind::Table(&BOX), "Region of x and xhat for which the design holds (default: all states).");
const W: Key = required("w", Kind::Weight, "Intensity W of the process noise, n x n, per unit of time.");
const V: Key = required(
    "v",
    Kind::Weight,
    "Intensity V of the measurement noise, p x p; for extended-kalman, ukf and mhe its covariance at a sample.",
);
const PERIOD: Key = required("period", Kind::Number(Range::Positive), "Sampling period.");

const P0: Key = optional("p0", Kind::Weight, "Covariance of the initial error, n x n (default: the identity).");
const SUBSTEPS: Key = optional("substeps", Kind::Count(1), "Runge-Kutta steps per sampling period (default 4).");
const GATE: Key = optional(
    "gate",
    Kind::Number(Range::Positive),
    "An output whose innovation is beyond this many standard deviations is rejected as an outlier (default none; 5 is usual).",
);
const SMOOTH: Key = optional(
    "smooth",
    Kind::Switch,
    "true: on a log also the estimates from the whole log, by the fixed-interval smoother of Rauch, Tung and Striebel (default false).",
);

const ERROR_BOUNDS: Key = optional(
    "bounds",
    Kind::Table(&ACTING),
    "Bounds of noise and disturbances: the certificate states a bound of each error in the end, and how fast it is reached.",
);
const UNKNOWN: Key = required("e", Kind::Rows, "E, n x q: the disturbance d enters as x' = A x + B u + E d.");
pub(super) const UNKNOWN_OF_ADVICE: Key = optional(
    "e",
    Kind::Rows,
    "E, n x q, of an unknown disturbance d, x' = A x + B u + E d (default: that of the first observer of the study that has one, else no disturbance).",
);
const GAMMA: Key = optional(
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

const SECTOR: Table = Table {
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

const PHI: Key = required(
    "phi",
    Kind::Expressions,
    "phi(x), one expression of the states for each state xi1, xi2, .. of the observer: where they tend to.",
);
const LAMBDA: Key = required(
    "lambda",
    Kind::ExpressionRows,
    "Lambda, as rows or as the list of its diagonal: numbers, and expressions of the inputs, the outputs and the time.",
);
const B: Key = required(
    "b",
    Kind::Expressions,
    "B(y, u), one expression of inputs and outputs for each xi; row i may also use xi1 to xi(i-1).",
);
const LEFT_INVERSE: Key = required(
    "left_inverse",
    Kind::Expressions,
    "phi^L(xi, y), one expression of xi1, .. and the outputs for each state of the plant.",
);
const BOUNDED: Key = required(
    "region",
    Kind::Table(&BOX),
    "Region over which the maps are checked: bounds of every state and every input.",
);

const SIGNAL: Key =
    required("s", Kind::Expressions, "s(y) of the regression d s(y)/dt = g + m theta: expressions of the outputs.");
const KNOWN: Key =
    required("g", Kind::Expressions, "g(xi, u, y) of the regression, one expression for each entry of `s`.");
const REGRESSOR: Key = required(
    "m",
    Kind::ExpressionRows,
    "m(xi, u, y) of the regression, one row for each entry of `s`, one column for each parameter; or the list of its diagonal.",
);
const MISSING: Key = optional(
    "missing",
    Kind::Expressions,
    "What is missing in xi, phi(x) = xi + missing: one expression of theta1, .. for each xi (default: theta in the rows of zeros of Lambda, in their order).",
);
const THETA_REGION: Key = optional(
    "theta",
    Kind::Bounds,
    "Region of theta over which the regression is checked, one pair [lower, upper] for each parameter (default [-1, 1], or [theta_min, theta_min + 1]).",
);
const THETA_MIN: Key = optional(
    "theta_min",
    Kind::Numbers(Range::Any),
    "Least value of each parameter: the estimate is held there (default: none).",
);
const THETA_START: Key =
    optional("theta_start", Kind::Number(Range::Any), "First estimate of every parameter (default 0).");
const ALPHA: Key =
    required("alpha", Kind::Number(Range::Positive), "The filters of the regression are alpha/(p + alpha).");
const ESTIMATOR: Key = required("estimator", Kind::Table(&ESTIMATORS), "Estimator of theta in Y = M theta.");
const LEAKAGE: Key = optional(
    "leakage",
    Kind::Number(Range::NotNegative),
    "Leakage of the rows of zeros, xi' = B - leakage xi: xi stays bounded, and theta is no longer constant (default 0).",
);
const RESET: Key = optional(
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
const WINDOW: Key = optional(
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

const ENTERING: Key = required(
    "e",
    Kind::Rows,
    "E, n x q: disturbances and noises w enter as x' = A x + B u + E w (x+ in discrete time).",
);
const MEASURED_NOISE: Key = required("d", Kind::Rows, "D, p x q: the same w enters the outputs, y = C x + D w.");
const COUNTED: Key =
    optional("h", Kind::Rows, "H, r x n: the errors z = H e that count (default: those of all states).");
const BOUND_OF_NORM: Key = optional(
    "gamma",
    Kind::Number(Range::Positive),
    "Bound of the norm from w to z (default: the least; for h-infinity 1 % above it).",
);
const THIS_GAIN: Key = optional("gain", Kind::Rows, "In place of a design: the norm of a given gain L, n x p.");

const KINDS: &[Variant] = &[
    Variant {
        name: "luenberger",
        about: "Luenberger observer xhat' = A xhat + B u + L (y - C xhat - D u), for linear plants.",
        keys: &[POLES, DECAY, LMI, KALMAN, GAIN, RHO, Q, MAX_GAIN, NOISE, ERROR_BOUNDS],
    },
    Variant {
        name: "kalman",
        about: "Stationary Kalman filter, for linear plants.",
        keys: &[
            W,
            V,
            RHO,
            Q,
            optional(
                "form",
                Kind::Choice(&[
                    ("predictor", "The estimate before the measurement of its sample, xhat(k|k-1)."),
                    ("filter", "The estimate after it, xhat(k|k)."),
                ]),
                "Estimate at a sample, of plants in discrete time and in exported code (default predictor).",
            ),
        ],
    },
    Variant {
        name: "cubic",
        about: "Luenberger observer with a cubic term -(y~'theta y~) N y~, which preserves stability, for linear plants.",
        keys: &[
            POLES,
            DECAY,
            LMI,
            KALMAN,
            GAIN,
            RHO,
            Q,
            MAX_GAIN,
            NOISE,
            THETA,
            optional(
                "gamma",
                Kind::Number(Range::Positive),
                "Gain of the cubic term, N = -gamma P^-1 C' theta. Give one of gamma, radial and s.",
            ),
            optional("radial", Kind::Number(Range::Positive), "w of N = -w P^-1 C'(C P^-1 C')^-1."),
            optional("s", Kind::Rows, "S of N = -P^-1 C'S, p x p, S + S' >= 0."),
            ERROR_BOUNDS,
        ],
    },
    Variant {
        name: "optimal-cubic",
        about: "Cubic observer whose gains L, N and theta have the least cost for given noise and first errors, found by a search from the linear optimum, for linear plants.",
        keys: &[
            required(
                "first_errors",
                Kind::Numbers(Range::Positive),
                "Semi-axes of the ellipsoid of first errors x(0) - xhat(0), n numbers.",
            ),
            optional(
                "horizon",
                Kind::Number(Range::Positive),
                "Time of operation that follows a first error: the factor of the error under noise in the cost (default: the duration of the simulation).",
            ),
            optional(
                "noise_deviation",
                Kind::Numbers(Range::Positive),
                "Standard deviations of the measurement noise, p numbers, of a normal distribution (default: the noise of the simulation, with its distribution).",
            ),
            optional(
                "noise_period",
                Kind::Number(Range::Positive),
                "Time for which each value of the noise is held (default: that of the simulation).",
            ),
            optional(
                "process_noise",
                Kind::Weight,
                "Intensity of the process noise, n x n, per unit of time (default 0).",
            ),
            optional(
                "weight",
                Kind::Weight,
                "T of e'Te in the cost, n x n (default: each error in units of its first error).",
            ),
            ERROR_BOUNDS,
        ],
    },
    Variant {
        name: "proportional-integral",
        about: "Observer of the state and of a constant or slowly varying disturbance d, x' = A x + B u + E d, for linear plants. Poles and gains are those of the plant with d among its states, n + q of them.",
        keys: &[
            UNKNOWN,
            optional(
                "rate",
                Kind::Numbers(Range::NotNegative),
                "Bounds of |d'|, q numbers, for the bound of the error (default 0: constant).",
            ),
            POLES,
            DECAY,
            LMI,
            KALMAN,
            GAIN,
            RHO,
            Q,
            MAX_GAIN,
            NOISE,
            THETA,
            GAMMA,
            ERROR_BOUNDS,
        ],
    },
    Variant {
        name: "extended-state",
        about: "Extended-state observer (disturbance observer): the state and a disturbance d with some derivatives, x' = A x + B u + E d, for linear plants. Poles and gains are those of the plant with n + q order states.",
        keys: &[
            UNKNOWN,
            optional(
                "order",
                Kind::Count(1),
                "Number of integrators in the model of each disturbance: 1 for constant ones, 2 for ramps (default 1).",
            ),
            optional(
                "bandwidth",
                Kind::Number(Range::Positive),
                "omega_o: all poles at -omega_o; with p outputs from -0.8 to -1.25 omega_o, p of them equal.",
            ),
            optional(
                "rate",
                Kind::Numbers(Range::NotNegative),
                "Bounds of the derivative of this order of d, q numbers, for the bound of the error (default 0).",
            ),
            POLES,
            DECAY,
            LMI,
            KALMAN,
            GAIN,
            RHO,
            Q,
            MAX_GAIN,
            NOISE,
            ERROR_BOUNDS,
        ],
    },
    Variant {
        name: "unknown-input",
        about: "Observer whose error does not depend on a disturbance d of any form, x' = A x + B u + E d, for linear plants with rank(C E) = q and stable invariant zeros of (A, E, C).",
        keys: &[UNKNOWN, POLES, DECAY, LMI, KALMAN, GAIN, RHO, Q, MAX_GAIN, NOISE, THETA, GAMMA],
    },
    Variant {
        name: "interval",
        about: "Interval observer, for linear plants: a lower and an upper bound of each state under bounded noise and disturbances, proved to enclose it.",
        keys: &[
            required(
                "initial_bounds",
                Kind::Numbers(Range::NotNegative),
                "Bounds of |x(0) - initial|, n numbers: the box in which the first state lies.",
            ),
            POLES,
            DECAY,
            LMI,
            KALMAN,
            GAIN,
            optional(
                "least_width",
                Kind::Switch,
                "true: the gain for which the sum of the half-widths in the end is least, in the coordinates of the plant, by a linear program.",
            ),
            RHO,
            Q,
            MAX_GAIN,
            NOISE,
            optional(
                "coordinates",
                Kind::Choice(&[
                    ("modal", "Those of the eigenvectors of A - L C; the poles have to be distinct."),
                    ("plant", "The states themselves: for A - L C that are Metzler, or nearly so."),
                ]),
                "Coordinates in which the error is bounded (default modal; with least_width plant).",
            ),
            ERROR_BOUNDS,
        ],
    },
    Variant {
        name: "sliding-mode",
        about: "Super-twisting observer and robust exact differentiator, for chains of integrators x1' = x2, .., x_n' = f(x, u) + d with the output x1: exact after a finite time in continuous time, stepped at samples without chattering.",
        keys: &[
            required(
                "bound",
                Kind::Number(Range::Positive),
                "Bound of |d|: of what the plant's own f leaves open in the last derivative, model errors included.",
            ),
            optional(
                "k",
                Kind::Numbers(Range::Positive),
                "Gains k_i of |e|^((n-i)/n) sign(e), n numbers (default: from the bound D, for n = 2 2.1 D^(1/2) and 1.1 D).",
            ),
            PERIOD,
            optional(
                "discretisation",
                Kind::Choice(&[
                    ("implicit", "The implicit Euler method, which does not chatter."),
                    ("explicit", "The explicit Euler method, for comparison."),
                ]),
                "How the sign is discretised (default implicit).",
            ),
        ],
    },
    Variant {
        name: "functional",
        about: "Functional observer (Darouach): an estimate of z = K x alone, with as many states as K has rows; for linear plants whose outputs do not depend on the input. Its errors are K x - zhat, its first estimate is K initial.",
        keys: &[
            required("k", Kind::Rows, "K of z = K x, a row for each function."),
            required(
                "poles",
                Kind::Poles,
                "Eigenvalues of F: as many numbers as `k` has rows, complex ones as [re, im] with their conjugates.",
            ),
        ],
    },
    Variant {
        name: "reduced-order",
        about: "Reduced-order observer (Luenberger, Gopinath): n - p states, the outputs enter the estimate directly; for linear plants whose outputs do not depend on the input.",
        keys: &[required(
            "poles",
            Kind::Poles,
            "Eigenvalues of F: n - p numbers, complex ones as [re, im] with their conjugates.",
        )],
    },
    Variant {
        name: "h-infinity",
        about: "H-infinity filter: the energy of the errors z = H e is below gamma^2 times that of disturbances and noise, for linear plants.",
        keys: &[ENTERING, MEASURED_NOISE, COUNTED, BOUND_OF_NORM, THIS_GAIN, MAX_GAIN],
    },
    Variant {
        name: "h2",
        about: "H2 filter: the variance of the errors z = H e under white noise is below gamma^2, for linear plants.",
        keys: &[ENTERING, MEASURED_NOISE, COUNTED, BOUND_OF_NORM, THIS_GAIN, MAX_GAIN],
    },
    Variant {
        name: "sampled-cubic",
        about: "Sampled cubic observer, stable at every sampling period, for linear plants.",
        keys: &[
            POLES,
            DECAY,
            LMI,
            KALMAN,
            GAIN,
            RHO,
            Q,
            MAX_GAIN,
            NOISE,
            THETA,
            optional(
                "gamma",
                Kind::Number(Range::Positive),
                "w of the cubic term, N = -w P^-1 C'(C P^-1 C')^-1, whose flow has a closed form. Give one of gamma, weighted and s.",
            ),
            optional(
                "weighted",
                Kind::Number(Range::Positive),
                "gamma of N = -gamma P^-1 C' theta; the cubic term takes a semi-implicit step.",
            ),
            optional(
                "s",
                Kind::Rows,
                "S of N = -P^-1 C'S, p x p, S + S' >= 0; the cubic term takes a semi-implicit step.",
            ),
            PERIOD,
            optional(
                "jitter",
                Kind::Bound,
                "Bounds [shortest, longest] of the real period: convergence is proved for all between, and a simulation draws the periods between them (default: the period only).",
            ),
            optional(
                "misses",
                Kind::Count(0),
                "Number of samples that may be missed in a row, for which convergence is proved; a simulation misses as many (default 0).",
            ),
        ],
    },
    Variant {
        name: "lpv",
        about: "Copy of a nonlinear plant with one gain for all Jacobians over a region (polytopic design).",
        keys: &[
            REGION,
            optional("decay_rate", Kind::Number(Range::NotNegative), "Decay rate to be certified (default 0)."),
            optional(
                "fastest",
                Kind::Number(Range::Positive),
                "In place of decay_rate: the largest decay rate up to this bound is found and certified.",
            ),
            optional("gain", Kind::Rows, "In place of a design: a given gain L, n x p, is analysed."),
            MAX_GAIN,
            NOISE,
        ],
    },
    Variant {
        name: "lipschitz",
        about: "Copy of a nonlinear plant with a gain for all nonlinearities within sectors (Thau, Rajamani, circle criterion).",
        keys: &[
            optional(
                "a",
                Kind::Rows,
                "Linear part A, n x n; the sectors are the rest of f (default: both are computed from the Jacobians over the region).",
            ),
            optional("sectors", Kind::Tables(&SECTOR), "The nonlinearities."),
            REGION,
            optional("decay_rate", Kind::Number(Range::NotNegative), "Decay rate to be certified (default 0)."),
            optional("gain", Kind::Rows, "In place of a design: a given gain L, n x p, is analysed."),
            MAX_GAIN,
            NOISE,
        ],
    },
    Variant {
        name: "mean-value",
        about: "Mean-value-theorem observer, corrected or as printed, for plants whose outputs are the first states.",
        keys: &[
            REGION,
            optional("decay_rate", Kind::Number(Range::NotNegative), "Decay rate to be certified (default 0)."),
            optional("eta", Kind::Number(Range::Positive), "Gain eta of the internal error (default 1)."),
            optional(
                "internal_error",
                Kind::Numbers(Range::Any),
                "Initial internal error, an estimate of x(0) - xhat(0), n numbers (default 0).",
            ),
            optional(
                "as_printed",
                Kind::Choice(&[
                    ("least-squares", "beta by bounded nonlinear least squares, as the paper computes it."),
                    ("root", "beta by bracketing the root of each row."),
                    ("integral", "The integral of the Jacobian along the segment."),
                ]),
                "The observer as printed, with the mean Jacobian computed this way. It has no certificate, because its theorem is false (default: the corrected observer).",
            ),
            MAX_GAIN,
            NOISE,
        ],
    },
    Variant {
        name: "high-gain",
        about: "Copy of a plant in triangular form, or given maps, with the gains alpha_i / r^i along chains of integrators that begin at the outputs.",
        keys: &[
            required("r", Kind::Number(Range::Positive), "High-gain parameter: a small positive number."),
            optional(
                "chains",
                Kind::Numbers(Range::Positive),
                "Length of the chain of each output; they add to n, or to the number of rows of `drift` (default with one output: all).",
            ),
            optional(
                "alpha",
                Kind::Numbers(Range::Positive),
                "Coefficients alpha_i, one number for each state of the chains (default: those of (s + 1)^length for each chain).",
            ),
            optional(
                "drift",
                Kind::Expressions,
                "Right-hand side without corrections, one expression of xi1, .., inputs and outputs for each state of the chains (default: the plant at the estimate).",
            ),
            optional(
                "shape",
                Kind::Expressions,
                "With `drift`: factors of the corrections, expressions of inputs and outputs (default 1).",
            ),
            optional(
                "estimate",
                Kind::Expressions,
                "With `drift`: the estimate, one expression of xi1, .., inputs and outputs for each state of the plant (default: xi).",
            ),
            optional(
                "start",
                Kind::Expressions,
                "With `drift`: xi at the start, expressions of the states at the first estimate and the outputs (default: the first estimate).",
            ),
        ],
    },
    Variant {
        name: "extended-kalman",
        about: "Extended Kalman filter for a plant in continuous time with sampled measurements.",
        keys: &[W, V, P0, PERIOD, SUBSTEPS, GATE, SMOOTH],
    },
    Variant {
        name: "ukf",
        about: "Unscented Kalman filter in square-root form, for a plant in continuous time with sampled measurements, or in discrete time.",
        keys: &[
            W,
            V,
            P0,
            PERIOD,
            SUBSTEPS,
            GATE,
            SMOOTH,
            optional(
                "alpha",
                Kind::Number(Range::Positive),
                "Distance of the sigma points from the estimate, alpha sqrt(n + kappa) standard deviations (default 1).",
            ),
            optional(
                "beta",
                Kind::Number(Range::Any),
                "Weight of the central point in covariances (default 2, for Gaussian errors).",
            ),
            optional("kappa", Kind::Number(Range::Any), "Second parameter of the distance, above -n (default 0)."),
        ],
    },
    Variant {
        name: "mhe",
        about: "Moving-horizon estimator: the states of the last samples by least squares, with bounds, for a plant in continuous time with sampled measurements, or in discrete time.",
        keys: &[
            W,
            V,
            P0,
            PERIOD,
            SUBSTEPS,
            optional("window", Kind::Count(1), "Samples in the window, at most 32 (default 10)."),
            optional(
                "iterations",
                Kind::Count(1),
                "Gauss-Newton steps at each sample (default 2; one is exact for a linear plant).",
            ),
            optional(
                "state_bounds",
                Kind::Bounds,
                "Bounds of the states, n pairs [lower, upper]; they may be inf or -inf (default: none).",
            ),
        ],
    },
    Variant {
        name: "kkl",
        about: "KKL observer xi' = Lambda xi + B(y, u), xhat = phi^L(xi, y), with maps that are given.",
        keys: &[PHI, LAMBDA, B, LEFT_INVERSE, BOUNDED],
    },
    Variant {
        name: "pebo",
        about: "Parameter-estimation-based observer xi' = B(y, u), xhat = phi^L(xi + theta, y), with an estimator of the constant theta.",
        keys: &[
            PHI,
            B,
            LEFT_INVERSE,
            BOUNDED,
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
        ],
    },
    Variant {
        name: "kkl-peb",
        about: "[KKL+PEB] observer: a KKL observer whose Lambda has rows of zeros, with an estimator of the constant that they leave.",
        keys: &[
            PHI,
            LAMBDA,
            B,
            LEFT_INVERSE,
            BOUNDED,
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
        ],
    },
    Variant {
        name: "immersion-invariance",
        about: "Immersion-and-invariance observer: chi makes beta(y, chi) follow phi(x), xhat = phi^L(beta(y, chi), y).",
        keys: &[
            required("beta", Kind::Expressions, "beta(y, chi), one expression of chi1, .. and the outputs for each z."),
            required("phi", Kind::Expressions, "phi(x), one expression of the states for each z."),
            required(
                "left_inverse",
                Kind::Expressions,
                "phi^L(z, y), one expression of z1, .. and the outputs for each state of the plant.",
            ),
            BOUNDED,
            optional("order", Kind::Count(1), "Number of states chi (default: that of the rows of `beta`)."),
            optional(
                "start",
                Kind::Expressions,
                "chi for an estimate, expressions of the states and the outputs (default: phi(x) - beta(y, 0), for beta = chi + a function of y).",
            ),
            optional(
                "q",
                Kind::Expressions,
                "Q(y, chi, u): how chi moves in the directions that beta does not see (default 0).",
            ),
            optional("rho", Kind::Expressions, "rho(y, chi, u): how beta moves beside phi(xhat) (default 0)."),
        ],
    },
    Variant {
        name: "kkl-numerical",
        about: "Numerical KKL observer: z' = D z + B y with a left inverse of T computed by simulation, for plants with one output: of 2 to 4 states, or of 2 or 3 states with inputs that are held at constant values.",
        keys: &[
            required("domain", Kind::Bounds, "Region of the states, n finite pairs [lower, upper]."),
            optional(
                "inputs",
                Kind::Bounds,
                "Range of each input, m finite pairs [lower, upper]: the inputs are held at constant values of it (required for a plant with inputs).",
            ),
            optional(
                "nodes",
                Kind::Count(2),
                "Values of each input for which there is a table, up to 33; between them T is interpolated (default 5).",
            ),
            optional(
                "cutoff",
                Kind::Number(Range::Positive),
                "Cutoff frequency of the Bessel filter z (default: the slowest of six that is accurate on a coarse table).",
            ),
            optional(
                "escape",
                Kind::Number(Range::Positive),
                "Width of the layer around the region in which the plant is slowed down, for plants that are unbounded backward in time (default: one half-width if a trajectory escapes, else none).",
            ),
            optional(
                "points",
                Kind::Count(5),
                "Grid points of the table per axis (default: 33 to 97, three states 17 to 33, four states 9 to 17, until the table is accurate).",
            ),
            optional("leaves", Kind::Count(1), "Largest number of leaves of the tree of polynomials (default 32)."),
            optional("degree", Kind::Count(1), "Degree of the polynomials (default 4)."),
            optional("samples", Kind::Count(100), "Number of samples of the fit (default 8000)."),
            optional(
                "form",
                Kind::Choice(&[
                    ("interpolated", "Interpolation in the table: accurate."),
                    ("embedded", "Tree of polynomials: small enough for a microcontroller."),
                ]),
                "Left inverse to simulate (default interpolated).",
            ),
        ],
    },
];

/// Where the kinds come from: paper and equation.
const SOURCES: &[(&str, &str)] = &[
    ("luenberger", "Luenberger 1964"),
    ("kalman", "Kalman and Bucy 1961; in discrete time Kalman 1960"),
    ("cubic", "Share Pasand, Luenberger-type cubic observers, eq. (5)"),
    ("sampled-cubic", "the same paper's observer, eq. (5), with a step in closed form: docs/theory-cubic.md"),
    ("optimal-cubic", "open problem of Share Pasand, Luenberger-type cubic observers: docs/theory-cubic.md"),
    (
        "unknown-input",
        "open problem of Share Pasand, Luenberger-type cubic observers; Darouach, Zasadzinski and Xu 1994",
    ),
    (
        "sliding-mode",
        "Levant 2003; Davila, Fridman and Levant 2005; implicit step: Acary and Brogliato 2010, Mojallizadeh, Brogliato and Acary 2021",
    ),
    ("interval", "Gouze, Rapaport and Hadj-Sadok 2000; Mazenc and Bernard 2011; the least width after Briat 2013"),
    ("proportional-integral", "open problem of Share Pasand, Luenberger-type cubic observers; Wojciechowski 1978"),
    ("reduced-order", "Luenberger 1964, Gopinath 1971"),
    ("functional", "Luenberger 1966, Darouach 2000"),
    ("h-infinity", "Nagpal and Khargonekar 1991; as an inequality Boyd et al. 1994"),
    ("h2", "Kalman and Bucy 1961; as an inequality Scherer, Gahinet and Chilali 1997"),
    ("extended-state", "Han 2009; Gao 2003; as a disturbance observer Ohnishi, Shibata and Murakami 1996"),
    ("lpv", "Boyd et al., Linear Matrix Inequalities in System and Control Theory, 1994"),
    ("lipschitz", "Thau 1973, Rajamani 1998, Arcak and Kokotovic 2001"),
    ("mean-value", "Ben Messaoud and Hajji 2018, eq. (3)"),
    ("high-gain", "Yi, Ortega and Zhang 2018, Table I; Khalil and Praly 2014"),
    ("extended-kalman", "Gelb, Applied Optimal Estimation, 1974, section 6.1"),
    ("ukf", "Julier and Uhlmann 2004; Van der Merwe and Wan, ICASSP 2001"),
    ("mhe", "Rao, Rawlings and Mayne 2003; Bell, Burke and Pillonetto 2009"),
    ("kkl", "Yi, Ortega and Zhang 2018, eq. (6), Proposition 1"),
    ("pebo", "Yi, Ortega and Zhang 2018, eq. (8) to (12), Proposition 2"),
    ("kkl-peb", "Yi, Ortega and Zhang 2018, eq. (15), Propositions 3, 6 and 7"),
    ("immersion-invariance", "Yi, Ortega and Zhang 2018, eq. (18) and (19), Proposition 4"),
    ("kkl-numerical", "Kazantzis and Kravaris 1998, Andrieu and Praly 2006; computed by simulation"),
];

/// A kind of observer: its name in study files, what it is, and where it comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ObserverSource {
    /// Its name.
    pub kind: &'static str,
    /// What it is.
    pub about: &'static str,
    /// Paper and equation; empty if unknown.
    pub source: &'static str,
}

/// The kinds of observers that a study can ask for, in the order of the schema.
///
/// ```
/// let kinds: Vec<&str> = luenberger_study::schema::observer_sources().map(|source| source.kind).collect();
/// assert!(kinds.contains(&"cubic") && kinds.contains(&"kkl-peb"));
/// ```
pub fn observer_sources() -> impl Iterator<Item = ObserverSource> {
    KINDS.iter().map(|variant| {
        let source = SOURCES.iter().find(|(kind, _)| *kind == variant.name).map_or("", |(_, source)| source);
        ObserverSource { kind: variant.name, about: variant.about, source }
    })
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_kind_of_observer_says_where_it_comes_from() {
        for kind in super::observer_sources() {
            assert!(!kind.source.is_empty(), "{}: no entry in SOURCES", kind.kind);
        }
    }
}
