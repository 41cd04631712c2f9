//! The kinds of observers of a study, with their specifications.

use super::{Key, Kind, Range, Table, Variant, Variants};

const fn optional(name: &'static str, kind: Kind, about: &'static str) -> Key {
    Key { name, kind, required: false, about }
}

const fn required(name: &'static str, kind: Kind, about: &'static str) -> Key {
    Key { name, kind, required: true, about }
}

/// `[[observer]]`.
pub(crate) const OBSERVER: Table = Table {
    name: "[[observer]]",
    about: "An observer and what is wished of it.",
    keys: &[
        optional("name", Kind::Name, "Its name in figures and tables; its kind without it."),
        optional(
            "initial",
            Kind::Numbers(Range::Any),
            "Its estimate at t = 0, n numbers; without it the operating point, if there is one, or else zeros.",
        ),
    ],
    variants: Some(Variants { tag: "kind", of: KINDS }),
};

const POLES: Key = optional(
    "poles",
    Kind::Poles,
    "The eigenvalues of A - L C: n numbers, complex ones as [re, im] with their conjugates.",
);
const DECAY: Key =
    optional("decay_rate", Kind::Number(Range::Positive), "Every error decays at least like exp(-decay_rate t).");
const LMI: Key =
    optional("lmi", Kind::Switch, "true: a matrix inequality with the largest margin decides on the gain.");
const MAX_GAIN: Key = optional(
    "max_gain",
    Kind::Number(Range::Positive),
    "With decay_rate, lmi or fastest: an upper bound of the spectral norm of L.",
);
const NOISE: Key = optional(
    "noise",
    Kind::Weight,
    "With decay_rate, lmi or fastest: intensity V of the measurement noise, p x p (sample variance times sampling period); among the gains with the rate, the one with the least noise gain is chosen.",
);
const KALMAN: Key = optional("kalman", Kind::Table(&NOISES), "The stationary Kalman gain for these intensities.");
const GAIN: Key = optional("gain", Kind::Rows, "A given gain L, n x p.");
const RHO: Key = optional(
    "rho",
    Kind::Number(Range::Positive),
    "Q = rho I in the Lyapunov equation that certifies the gain; 1 without it.",
);
const Q: Key = optional("q", Kind::Rows, "Q of that equation, n x n, instead of rho.");
const THETA: Key = optional("theta", Kind::Weight, "The weight theta of the cubic term, p x p; 1 without it.");
const REGION: Key = optional("region", Kind::Table(&BOX), "The box in which x and xhat live; everywhere without it.");
const W: Key = required("w", Kind::Weight, "Intensity W of the process noise, n x n, per unit of time.");
const V: Key = required(
    "v",
    Kind::Weight,
    "Intensity V of the measurement noise, p x p; for extended-kalman its covariance at a sample.",
);
const PERIOD: Key = required("period", Kind::Number(Range::Positive), "The sampling period.");

const NOISES: Table = Table {
    name: "kalman",
    about: "Intensities of the noise.",
    variants: None,
    keys: &[
        required("w", Kind::Weight, "Intensity W of the process noise, n x n."),
        required("v", Kind::Weight, "Intensity V of the measurement noise, p x p."),
    ],
};

const BOX: Table = Table {
    name: "region",
    about: "A box of states, and of inputs and times where they matter.",
    variants: None,
    keys: &[
        optional("states", Kind::Bounds, "n pairs [lower, upper]; ends may be inf."),
        optional("inputs", Kind::Bounds, "m pairs; any input without it."),
        optional("time", Kind::Bound, "Any time without it."),
    ],
};

const SECTOR: Table = Table {
    name: "sectors",
    about: "A nonlinearity G phi(t, H x, u) whose slope lies between low and high.",
    variants: None,
    keys: &[
        required("g", Kind::Rows, "Where it acts, n x q."),
        required("h", Kind::Rows, "What it depends on, q x n."),
        required("low", Kind::Number(Range::Any), "The least slope; for a Lipschitz constant gamma, -gamma."),
        required("high", Kind::Number(Range::Any), "The greatest slope."),
    ],
};

const KINDS: &[Variant] = &[
    Variant {
        name: "luenberger",
        about: "xhat' = A xhat + B u + L (y - C xhat), for linear plants.",
        keys: &[POLES, DECAY, LMI, KALMAN, GAIN, RHO, Q, MAX_GAIN, NOISE],
    },
    Variant {
        name: "kalman",
        about: "The stationary Kalman filter in continuous time, for linear plants.",
        keys: &[W, V, RHO, Q],
    },
    Variant {
        name: "cubic",
        about: "Luenberger's observer with a cubic term -(y~'theta y~) N y~ that never costs stability, for linear plants.",
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
                "N = -gamma P^-1 C' theta. One of gamma, radial and s must be there.",
            ),
            optional("radial", Kind::Number(Range::Positive), "N = -w P^-1 C'(C P^-1 C')^-1 with this w."),
            optional("s", Kind::Rows, "N = -P^-1 C'S with this S, p x p, S + S' >= 0."),
        ],
    },
    Variant {
        name: "sampled-cubic",
        about: "The cubic observer in sampled data, stable at every period, for linear plants.",
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
            required(
                "gamma",
                Kind::Number(Range::Positive),
                "The strength w of the cubic term, N = -w P^-1 C'(C P^-1 C')^-1.",
            ),
            PERIOD,
        ],
    },
    Variant {
        name: "lpv",
        about: "The copy of a nonlinear plant with one gain for all Jacobians over a box.",
        keys: &[
            REGION,
            optional("decay_rate", Kind::Number(Range::NotNegative), "The rate that is proved; 0 without it."),
            optional(
                "fastest",
                Kind::Number(Range::Positive),
                "Instead: the greatest rate that can be proved up to this ceiling.",
            ),
            optional("gain", Kind::Rows, "Instead: what can be proved of this gain L, n x p."),
            MAX_GAIN,
            NOISE,
        ],
    },
    Variant {
        name: "lipschitz",
        about: "The copy of a nonlinear plant with a gain for all nonlinearities within sectors (Thau, Rajamani, circle criterion).",
        keys: &[
            optional(
                "a",
                Kind::Rows,
                "The linear part A, n x n, that the sectors are the rest of. Without a and sectors, both are read off the Jacobians over the region.",
            ),
            optional("sectors", Kind::Tables(&SECTOR), "The nonlinearities."),
            REGION,
            optional("decay_rate", Kind::Number(Range::NotNegative), "The rate that is proved; 0 without it."),
            optional("gain", Kind::Rows, "Instead of a gain that is designed: what is proved of this L, n x p."),
            MAX_GAIN,
            NOISE,
        ],
    },
    Variant {
        name: "mean-value",
        about: "The mean-value-theorem observer, repaired, for plants that measure their first states.",
        keys: &[
            REGION,
            optional("decay_rate", Kind::Number(Range::NotNegative), "The rate that is proved; 0 without it."),
            optional("eta", Kind::Number(Range::Positive), "The gain eta of its internal error; 1 without it."),
            optional(
                "internal_error",
                Kind::Numbers(Range::Any),
                "Its belief about x(0) - xhat(0), n numbers; zeros without it.",
            ),
            MAX_GAIN,
            NOISE,
        ],
    },
    Variant {
        name: "high-gain",
        about: "The copy of a plant in triangular form with the gains alpha_i / r^i along chains that begin at the outputs.",
        keys: &[
            required("r", Kind::Number(Range::Positive), "The small number r."),
            optional(
                "chains",
                Kind::Numbers(Range::Positive),
                "The length of the chain of each output, n altogether; one chain of n for one output without it.",
            ),
            optional(
                "alpha",
                Kind::Numbers(Range::Positive),
                "The coefficients, n of them; those of (s + 1)^length for each chain without it.",
            ),
        ],
    },
    Variant {
        name: "extended-kalman",
        about: "The extended Kalman filter, plant in continuous time and measurements in samples.",
        keys: &[
            W,
            V,
            optional("p0", Kind::Weight, "Covariance of the first error, n x n; 1 without it."),
            PERIOD,
            optional("substeps", Kind::Count(1), "Runge-Kutta steps between samples; 4 without it."),
            optional(
                "gate",
                Kind::Number(Range::Positive),
                "An output whose innovation is beyond this many standard deviations is rejected as an outlier (default none; 5 is usual).",
            ),
        ],
    },
    Variant {
        name: "kkl-numerical",
        about: "z' = D z + B y with a left inverse of T computed by simulation, for plants of 2 or 3 states with one output and no input that varies.",
        keys: &[
            required("domain", Kind::Bounds, "The box of states, n finite pairs [lower, upper]."),
            required("cutoff", Kind::Number(Range::Positive), "The cut-off of the Bessel filter that z is."),
            optional(
                "escape",
                Kind::Number(Range::Positive),
                "The plant is slowed outside of the box within this margin, for plants whose past is unbounded; free without it.",
            ),
            optional("points", Kind::Count(5), "Points of the table per axis; 33 without it."),
            optional("leaves", Kind::Count(1), "Leaves of the tree of polynomials; 32 without it."),
            optional("degree", Kind::Count(1), "Degree of the polynomials; 4 without it."),
            optional("samples", Kind::Count(100), "Samples of the fit; 8000 without it."),
            optional(
                "form",
                Kind::Choice(&[("interpolated", "The accurate one."), ("embedded", "The one for a microcontroller.")]),
                "Which left inverse runs; interpolated without it.",
            ),
        ],
    },
];
