//! The tables of a study file, except for those of the observers.

use super::observers::OBSERVER;
use super::{Key, Kind, Range, Table};

const fn optional(name: &'static str, kind: Kind, about: &'static str) -> Key {
    Key { name, kind, required: false, about }
}

const fn required(name: &'static str, kind: Kind, about: &'static str) -> Key {
    Key { name, kind, required: true, about }
}

/// The whole file.
pub const STUDY: Table = Table {
    name: "the study",
    about: "A plant, the observers wanted of it, and how they are tried.",
    variants: None,
    keys: &[
        optional("$schema", Kind::Text, "The JSON Schema of this file, for editors."),
        optional("title", Kind::Text, "The title of the report; the name of the file without it."),
        optional("about", Kind::Text, "What the study is for; stands below the title."),
        optional(
            "solver",
            Kind::Choice(SOLVERS),
            "The solver that proposes solutions of the linear matrix inequalities of the designs (default interior). Every answer is verified independently of it.",
        ),
        required("plant", Kind::Table(&PLANT), "What is observed."),
        optional(
            "operating_point",
            Kind::Table(&OPERATING_POINT),
            "A rest position, at which the kinds luenberger, kalman, cubic and sampled-cubic are designed for a nonlinear plant.",
        ),
        optional("input", Kind::Table(&INPUT), "What drives the plant; without it the input is 0."),
        optional("simulation", Kind::Table(&SIMULATION), "How the plant and its observers are run."),
        optional("log", Kind::Table(&LOG), "A measured log on which the observers are run, instead of a simulation."),
        optional("observer", Kind::Tables(&OBSERVER), "The observers, each with its wishes."),
        optional("plot", Kind::Table(&PLOT), "What is drawn; everything without it."),
        optional("sweep", Kind::Table(&SWEEP), "A parameter that is varied, and an ensemble."),
    ],
};

/// The solvers of matrix inequalities.
const SOLVERS: &[(&str, &str)] = &[
    ("interior", "The solver of this project."),
    ("clarabel", "Clarabel, as a second opinion; in builds with the feature clarabel."),
];

/// The plants of the library, which need no equations.
pub(crate) const BUILTIN: &[(&str, &str)] = &[
    ("double-integrator", "x1' = x2, x2' = u, y = x1."),
    ("third-order", "The plant of Example 3 of the cubic-observer paper."),
    ("flexible-joint", "The robot link with a flexible joint, the motor measured: 4 states, 1 input, 2 outputs."),
    ("flexible-joint-printed", "The same as the mean-value-theorem paper prints it: unstable, 3 outputs."),
    ("chaotic", "Sprott's chaotic flow: 3 states, no input, 2 outputs."),
    ("cuk", "The averaged Cuk converter: 4 states, the duty cycle as input, 2 outputs."),
    ("reverse-duffing", "x1' = x2^3, x2' = -x1, y = x1."),
    ("van-der-pol", "Van der Pol's oscillator, x1 measured."),
    ("exponential-cascade", "The plant of Proposition 6 of the [KKL+PEB] paper."),
];

const PLANT: Table = Table {
    name: "[plant]",
    about: "The plant: linear by its matrices (a, b, c), nonlinear by expressions (f, h), or one that is built in (builtin).",
    variants: None,
    keys: &[
        optional("a", Kind::Rows, "A of x' = A x + B u, n x n, as a list of rows."),
        optional("b", Kind::Rows, "B, n x m; no inputs without it."),
        optional("c", Kind::Rows, "C of y = C x + D u, p x n."),
        optional("d", Kind::Rows, "D, p x m; zero without it."),
        optional("f", Kind::Texts, "The right-hand sides of x' = f(t, x, u), one expression for each state."),
        optional("h", Kind::Texts, "The outputs y = h(t, x, u), one expression for each."),
        optional(
            "parameters",
            Kind::Named,
            "Numbers that the expressions may use by name, and expressions of other parameters, such as J = \"m*l^2/3\".",
        ),
        optional(
            "tables",
            Kind::NamedTables(&LOOKUP),
            "Lookup tables, which the expressions use as functions: torque(x1) for [plant.tables.torque].",
        ),
        optional("builtin", Kind::Choice(BUILTIN), "A plant that is built in."),
        optional(
            "states",
            Kind::Names,
            "Names of the states in expressions, figures, tables and messages; x1, x2, ... without it, which expressions may always say as well.",
        ),
        optional(
            "inputs",
            Kind::Names,
            "Names of the inputs, likewise; u1, u2, ... without it, as far as f and h use them.",
        ),
        optional("outputs", Kind::Names, "Names of the outputs; y1, y2, ... without it."),
        optional("units", Kind::Names, "Units of the states, for axes and tables."),
        optional(
            "time_unit",
            Kind::Name,
            "The unit of the time t, for axes and tables; none is written without it. Rates and poles are then per this unit.",
        ),
    ],
};

const LOOKUP: Table = Table {
    name: "[plant.tables.NAME]",
    about: "A lookup table: a function of one variable through the points (x, y).",
    variants: None,
    keys: &[
        required("x", Kind::Numbers(Range::Any), "Two or more increasing numbers."),
        required("y", Kind::Numbers(Range::Any), "As many values."),
        optional(
            "method",
            Kind::Choice(&[
                ("linear", "Straight lines."),
                ("monotone-cubic", "Cubic polynomials, continuously differentiable and without overshoot (PCHIP)."),
            ]),
            "Between the points; linear without it.",
        ),
        optional(
            "extrapolation",
            Kind::Choice(&[
                ("hold", "The first and the last value."),
                ("linear", "Straight lines along the slopes at the ends."),
            ]),
            "Before the first point and after the last; hold without it.",
        ),
    ],
};

const OPERATING_POINT: Table = Table {
    name: "[operating_point]",
    about: "A state at which the plant rests under a constant input, f(x, u) = 0, found by Newton's method from a guess.",
    variants: None,
    keys: &[
        optional("x", Kind::Numbers(Range::Any), "A guess of the state; zeros without it."),
        optional("u", Kind::Numbers(Range::Any), "The input; zeros without it."),
    ],
};

const INPUT: Table = Table {
    name: "[input]",
    about: "What drives the plant: expressions of t, a table from a CSV file, or feedback from an estimate (plus expressions).",
    variants: None,
    keys: &[
        optional(
            "expressions",
            Kind::Texts,
            "One expression of t for each input; added to the feedback, if there is one.",
        ),
        optional("table", Kind::Text, "A CSV file with the columns t and one for each input, by its name."),
        optional(
            "interpolation",
            Kind::Choice(&[
                ("hold", "The last value holds until the next."),
                ("linear", "Straight lines between values."),
            ]),
            "Between the rows of the table; hold without it.",
        ),
        optional("feedback", Kind::Table(&FEEDBACK), "u = -K xhat."),
    ],
};

const FEEDBACK: Table = Table {
    name: "feedback",
    about: "u = -K xhat with the estimate of one of the observers.",
    variants: None,
    keys: &[
        required("k", Kind::Rows, "The gain K, m x n."),
        required("observer", Kind::Text, "The name of the observer whose estimate is fed back."),
    ],
};

const SIMULATION: Table = Table {
    name: "[simulation]",
    about: "How the plant and its observers are run, from t = 0.",
    variants: None,
    keys: &[
        required("x0", Kind::Numbers(Range::Any), "The state of the plant at t = 0, n numbers."),
        required("duration", Kind::Number(Range::Positive), "The end of the run."),
        optional(
            "samples",
            Kind::Count(2),
            "How many equally spaced times are written, both ends among them (default 501). A sampled observer has its rows at its samples, evenly thinned to at most this number.",
        ),
        optional(
            "integrator",
            Kind::Choice(&[
                ("auto", "Explicit until stiffness shows, then implicit."),
                ("explicit", "DOP853, of order 8."),
                ("implicit", "Radau IIA, of order 5."),
            ]),
            "The method; auto without it.",
        ),
        optional("rtol", Kind::Number(Range::Positive), "Relative tolerance; 1e-9 without it."),
        optional("atol", Kind::Number(Range::Positive), "Absolute tolerance; 1e-10 without it."),
        optional(
            "hold",
            Kind::Number(Range::Positive),
            "The input is evaluated once in this period and held; not held without it.",
        ),
        optional(
            "band",
            Kind::Number(Range::Positive),
            "The error has settled at this share of its first value; 0.05 without it.",
        ),
        optional(
            "scale",
            Kind::Numbers(Range::Positive),
            "One positive number per state, in its unit: the error of each state is divided by it in the norm |e|. Default: the widths of the region of the designs, if it is finite and the same for all; otherwise no norm is formed.",
        ),
        optional(
            "score_period",
            Kind::Number(Range::Positive),
            "Errors are scored at multiples of this period, at least the longest sampling period. Default: at the samples if any observer is sampled, otherwise in continuous time.",
        ),
        optional("noise", Kind::Table(&NOISE), "Noise on the outputs that the observers see; none without it."),
    ],
};

const NOISE: Table = Table {
    name: "noise",
    about: "Noise on the outputs, seeded: the same in every run.",
    variants: None,
    keys: &[
        optional(
            "distribution",
            Kind::Choice(&[
                ("gaussian", "Normal, of mean 0."),
                ("uniform", "Uniform, between minus and plus the amplitude."),
            ]),
            "The distribution; gaussian without it.",
        ),
        required(
            "amplitude",
            Kind::Numbers(Range::NotNegative),
            "Standard deviation or amplitude, one for each output.",
        ),
        required("period", Kind::Number(Range::Positive), "Each value holds for this time."),
        optional("seed", Kind::Count(0), "The seed; 0 without it."),
    ],
};

const LOG: Table = Table {
    name: "[log]",
    about: "A measured log: the observers are run on it, and their innovations reported. A blank cell is no measurement.",
    variants: None,
    keys: &[
        required("file", Kind::Text, "A CSV file with a header, beside the study."),
        optional("time", Kind::Text, "The column of times, which increase; t without it."),
        optional("inputs", Kind::Texts, "The columns of the inputs; the names of the plant's inputs without it."),
        optional("outputs", Kind::Texts, "The columns of the outputs; the names of the plant's outputs without it."),
        optional(
            "states",
            Kind::Texts,
            "The columns of the true states, one for each state, \"-\" for an unknown one: the errors are reported (default none).",
        ),
        optional(
            "interpolation",
            Kind::Choice(&[
                ("none", "Only rows correct an estimate."),
                ("linear", "Straight lines between rows, which know the future, but not across gaps and blank cells."),
            ]),
            "What observers in continuous time, and at their own period, see of the outputs between the rows (default none).",
        ),
    ],
};

/// The available plots.
pub(crate) const QUANTITIES: &[(&str, &str)] = &[
    ("states", "Each state with its estimates."),
    ("errors", "The error of each state."),
    ("error-norm", "The norm of the error on a logarithmic axis."),
    ("inputs", "The inputs."),
    ("outputs", "The outputs, with noise if there is any."),
    ("innovations", "What each observer did not expect of the outputs, y - h(xhat)."),
];

const PLOT: Table = Table {
    name: "[plot]",
    about: "What is drawn.",
    variants: None,
    keys: &[
        optional(
            "show",
            Kind::Choices(QUANTITIES),
            "The figures; states, errors, error-norm and inputs without it (innovations for a log).",
        ),
        optional("states", Kind::Texts, "Only these states, by name."),
        optional("observers", Kind::Texts, "Only these observers, by name."),
        optional("from", Kind::Number(Range::NotNegative), "The time at which the figures begin."),
        optional("to", Kind::Number(Range::Positive), "The time at which the figures end."),
    ],
};

/// The parameters of a sweep.
pub(crate) const SWEPT: &[(&str, &str)] = &[
    ("gamma", "gamma of the observers that have one."),
    ("poles", "A factor of the poles, decay rates and high gains: 2 makes an observer twice as fast."),
    ("noise", "A factor of the amplitude of the noise."),
    ("initial", "A factor of the first error x(0) - xhat(0)."),
];

const SWEEP: Table = Table {
    name: "[sweep]",
    about: "A parameter that is varied; at each value all observers are designed and run anew, in parallel.",
    variants: None,
    keys: &[
        required(
            "parameter",
            Kind::Text,
            "What is varied: gamma, a factor of the poles, of the noise or of the initial error, or a number of the study by its place: plant.NAME for a parameter of the plant, observer.NAME.KEY, simulation.KEY.",
        ),
        optional("values", Kind::Numbers(Range::Any), "Its values; factors are positive."),
        optional("from", Kind::Number(Range::Any), "The least value, where they are not listed."),
        optional("to", Kind::Number(Range::Any), "The greatest value."),
        optional("count", Kind::Count(2), "How many values; 9 without it."),
        optional(
            "spacing",
            Kind::Choice(&[("log", "Equal ratios."), ("linear", "Equal differences.")]),
            "How they are spaced; log without it.",
        ),
        optional(
            "ensemble",
            Kind::Count(1),
            "Runs at each value, with other seeds of the noise and other directions of the first error; 1 without it.",
        ),
        optional("seed", Kind::Count(0), "The seed of the ensemble; 0 without it."),
        optional("observers", Kind::Texts, "Only these observers, by name."),
    ],
};
