//! The tables of a study file, except for those of the observers.

use super::advise::ADVISE;
use super::estimate::ESTIMATE;
use super::frequency::FREQUENCY;
use super::observers::OBSERVER;
use super::truth::TRUTH;
use super::tune::TUNE;
use crate::keys::{Range, Table, Type, optional, required};

/// The whole file.
pub const STUDY: Table = Table {
    name: "the study",
    about: "A plant, observers for it, and simulations or a measured log to compare them on.",
    variants: None,
    keys: &[
        optional("$schema", Type::Text, "The JSON Schema of this file, for editors."),
        optional("title", Type::Text, "Title of the report (default: the name of the file)."),
        optional("about", Type::Text, "A description, printed below the title of the report."),
        optional(
            "solver",
            Type::Choice(SOLVERS),
            "Solver of the linear matrix inequalities of the designs (default interior). Every solution is verified independently of the solver.",
        ),
        required("plant", Type::Table(&PLANT), "The plant."),
        optional(
            "operating_point",
            Type::Table(&OPERATING_POINT),
            "An equilibrium, at which kinds for linear plants are designed for the linearisation of a nonlinear one (`luenberger new --list` says which).",
        ),
        optional(
            "estimate",
            Type::Table(&ESTIMATE),
            "Parameters of the plant that filters with a covariance estimate with its state.",
        ),
        optional("input", Type::Table(&INPUT), "The input of the plant (default 0)."),
        optional("simulation", Type::Table(&SIMULATION), "The simulation of the plant and its observers."),
        optional(
            "truth",
            Type::Table(&TRUTH),
            "The plant as it is simulated, where it differs from the model that the observers are designed for.",
        ),
        optional("log", Type::Table(&LOG), "A measured log to run the observers on."),
        optional("observer", Type::Tables(&OBSERVER), "The observers, each with its specification."),
        optional("advise", Type::Table(&ADVISE), "What `luenberger advise` tells every kind of observer."),
        optional("tune", Type::Table(&TUNE), "What `luenberger tune` fits to the log."),
        optional(
            "frequency",
            Type::Table(&FREQUENCY),
            "Frequency responses of linear observers and of the loop, with margins (default: none).",
        ),
        optional("plot", Type::Table(&PLOT), "The figures (default: all)."),
        optional("sweep", Type::Table(&SWEEP), "A parameter sweep, with an ensemble of runs at each value."),
    ],
};

/// The solvers of matrix inequalities.
const SOLVERS: &[(&str, &str)] = &[
    ("interior", "The interior-point method of this project."),
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
    about: "The plant: matrices (a, b, c, d) for a linear one, expressions (f, h) for a nonlinear one, or the name of a built-in plant (builtin).",
    variants: None,
    keys: &[
        optional("a", Type::Rows, "A of x' = A x + B u, or of x+ = A x + B u with `dt`, n x n, as a list of rows."),
        optional("b", Type::Rows, "B, n x m (default: no inputs)."),
        optional("c", Type::Rows, "C of y = C x + D u, p x n."),
        optional("d", Type::Rows, "D, p x m (default 0)."),
        optional(
            "f",
            Type::Texts,
            "The right-hand sides of x' = f(t, x, u), one expression for each state; with `dt` the next states, x+ = f(t, x, u).",
        ),
        optional("h", Type::Texts, "The outputs y = h(t, x, u), one expression for each output."),
        optional(
            "parameters",
            Type::Named,
            "Named constants for the expressions: numbers, or expressions of other parameters, such as J = \"m*l^2/3\".",
        ),
        optional(
            "tables",
            Type::NamedTables(&LOOKUP),
            "Lookup tables, used in expressions as functions: torque(x1) for [plant.tables.torque].",
        ),
        optional(
            "dt",
            Type::Number(Range::Positive),
            "Sampling period of a plant in discrete time (default: continuous time).",
        ),
        optional("builtin", Type::Choice(BUILTIN), "A built-in plant."),
        optional(
            "states",
            Type::Names(1),
            "Names of the states in expressions, figures, tables and messages (default x1, x2, ...). Expressions may use x1, x2, ... in any case.",
        ),
        optional(
            "inputs",
            Type::Names(0),
            "Names of the inputs, likewise (default u1, u2, ..., as many as f and h use).",
        ),
        optional("outputs", Type::Names(1), "Names of the outputs (default y1, y2, ...)."),
        optional(
            "units",
            Type::Units,
            "Units for axes and tables: a table such as { speed = \"rad/s\", J = \"kg m2\" } for any of the states, inputs, outputs and parameters, or the list of the units of the states. No computation uses them, but for the full turn of `angles`.",
        ),
        optional(
            "angles",
            Type::Names(1),
            "States and outputs that are angles, in rad or in their `units` (rad, mrad, deg, gon, rev): differences of readings, sigma points and errors are taken modulo a full turn. A state that is measured itself and its output need to be named once.",
        ),
        optional(
            "delays",
            Type::Named,
            "Outputs that are measured late, with their delays: what is read at t was true at t less the delay. The simulated sensors are late by them, and filters take each measurement at its time.",
        ),
        optional(
            "time_unit",
            Type::Name,
            "Unit of the time t, for axes and tables (default: none). Decay rates and poles are per this unit.",
        ),
    ],
};

const LOOKUP: Table = Table {
    name: "[plant.tables.NAME]",
    about: "Lookup table: a function of one variable through the points (x, y), or of two through z at each x and y.",
    variants: None,
    keys: &[
        required("x", Type::Numbers(Range::Any), "Breakpoints: two or more increasing numbers."),
        required(
            "y",
            Type::Numbers(Range::Any),
            "Values at the breakpoints; with `z` the breakpoints of the second variable, increasing.",
        ),
        optional(
            "z",
            Type::Rows,
            "Values of a table of two variables, a row for each x and in it a number for each y: bilinear between them.",
        ),
        optional(
            "method",
            Type::Choice(&[
                ("linear", "Linear interpolation."),
                ("monotone-cubic", "Piecewise cubic, continuously differentiable, without overshoot (PCHIP)."),
            ]),
            "Interpolation between the breakpoints (default linear).",
        ),
        optional(
            "extrapolation",
            Type::Choice(&[
                ("hold", "Constant: the first and the last value."),
                ("linear", "Linear, with the slopes at the ends."),
            ]),
            "Extrapolation (default hold).",
        ),
    ],
};

const OPERATING_POINT: Table = Table {
    name: "[operating_point]",
    about: "An equilibrium: the plant rests under a constant input, f(x, u) = 0; found by Newton's method from a guess.",
    variants: None,
    keys: &[
        optional("x", Type::Numbers(Range::Any), "Guess of the state (default 0)."),
        optional("u", Type::Numbers(Range::Any), "The input (default 0)."),
    ],
};

const INPUT: Table = Table {
    name: "[input]",
    about: "The input of the plant: expressions of t, a table in a CSV file, state feedback from an observer, to which expressions are added, or a control law with the true states.",
    variants: None,
    keys: &[
        optional("expressions", Type::Texts, "One expression of t for each input; added to the feedback, if any."),
        optional(
            "table",
            Type::Text,
            "A CSV file with the column t and one column for each input, headed by its name.",
        ),
        optional(
            "interpolation",
            Type::Choice(&[("hold", "Zero-order hold."), ("linear", "Linear interpolation.")]),
            "Interpolation between the rows of the table (default hold).",
        ),
        optional(
            "feedback",
            Type::Table(&FEEDBACK),
            "State feedback u = -K xhat; with an [operating_point] u = u0 - K (xhat - x0).",
        ),
        optional(
            "law",
            Type::Texts,
            "A control law with the true states: one expression of t and the states for each input, in place of the others.",
        ),
        optional(
            "jumps",
            Type::Numbers(Range::NotNegative),
            "With `law`: the times at which it jumps, so that no step of the integration crosses them (default: none).",
        ),
    ],
};

const LQR: Table = Table {
    name: "lqr",
    about: "Weights of the cost int x'Q x + u'R u dt, or of its sum in discrete time.",
    variants: None,
    keys: &[
        required("q", Type::Weight, "Q, n x n, positive semidefinite."),
        required("r", Type::Weight, "R, m x m, positive definite."),
    ],
};

const FEEDBACK: Table = Table {
    name: "feedback",
    about: "State feedback u = -K xhat with the estimate of one of the observers; with an [operating_point] of the deviations from it, u = u0 - K (xhat - x0).",
    variants: None,
    keys: &[
        optional("k", Type::Rows, "The gain K, m x n. Give one of k, poles and lqr."),
        optional(
            "poles",
            Type::Poles,
            "Eigenvalues of A - B K: n numbers, complex ones as [re, im] with their conjugates; for linear plants.",
        ),
        optional(
            "lqr",
            Type::Table(&LQR),
            "Weights of the cost int x'Q x + u'R u dt (its sum in discrete time), which K makes least; for linear plants.",
        ),
        required("observer", Type::Text, "The name of the observer whose estimate is fed back."),
    ],
};

const SIMULATION: Table = Table {
    name: "[simulation]",
    about: "The simulation of the plant and its observers, from t = 0.",
    variants: None,
    keys: &[
        required("x0", Type::Numbers(Range::Any), "Initial state of the plant, n numbers."),
        required("duration", Type::Number(Range::Positive), "End time of the simulation."),
        optional(
            "samples",
            Type::Count(2),
            "Number of equally spaced output times, both ends included (default 501). A sampled observer has its rows at its samples, evenly thinned to at most this number.",
        ),
        optional(
            "integrator",
            Type::Choice(&[
                ("auto", "Explicit; implicit once the equations turn out to be stiff."),
                ("explicit", "DOP853, of order 8."),
                ("implicit", "Radau IIA, of order 5."),
            ]),
            "Integration method (default auto).",
        ),
        optional("rtol", Type::Number(Range::Positive), "Relative tolerance of the integration (default 1e-9)."),
        optional("atol", Type::Number(Range::Positive), "Absolute tolerance of the integration (default 1e-10)."),
        optional(
            "hold",
            Type::Number(Range::Positive),
            "Period of a zero-order hold of the input (default: no hold). Sampled observers and Kalman filters with a period assume a hold with that period.",
        ),
        optional(
            "band",
            Type::Number(Range::Positive),
            "Settling band as a fraction of the initial error (default 0.05).",
        ),
        optional(
            "scale",
            Type::Numbers(Range::Positive),
            "One positive number per state, in its unit, by which its error is divided in the norm |e| (default: the widths of the region of the designs, if it is finite and the same for all; otherwise no norm is computed).",
        ),
        optional("estimates", Type::Choice(ESTIMATES), ESTIMATES_ABOUT),
        optional(
            "interpolation",
            Type::Choice(&[
                ("predicted", "A measurement moves with the model until the next one."),
                ("held", "A measurement is held until the next one, late by half a period on average."),
            ]),
            "What observers in continuous time see between two measurements of a [[simulation.sensor]] (default predicted).",
        ),
        optional(
            "score_period",
            Type::Number(Range::Positive),
            "Errors are evaluated at multiples of this period, at least the longest sampling period (default: at the samples if any observer is sampled, otherwise in continuous time).",
        ),
        optional("noise", Type::Table(&NOISE), "Measurement noise (default: none)."),
        optional(
            "sensor",
            Type::Tables(&SENSOR),
            "Sensors with sampling periods of their own (default: outputs are read at all times).",
        ),
        optional(
            "sampling",
            Type::Table(&SAMPLING),
            "How the samples of observers with `jitter` or `misses` are drawn (default: within the bounds of each observer).",
        ),
    ],
};

const SAMPLING: Table = Table {
    name: "[simulation.sampling]",
    about: "The samples of observers with `jitter` or `misses`, from a seeded generator: each period is uniform between the bounds, and a sample is missed with probability 1/2 until as many as allowed have been missed in a row. Periods and misses beyond those of an observer show what happens outside of what is proved.",
    variants: None,
    keys: &[
        optional(
            "jitter",
            Type::Bound,
            "Bounds [shortest, longest] of the periods that are drawn (default: those of each observer).",
        ),
        optional(
            "misses",
            Type::Count(0),
            "The largest number of samples missed in a row (default: that of each observer).",
        ),
        optional("seed", Type::Count(0), "Seed of the generator (default that of simulation.noise, or 0)."),
    ],
};

const SENSOR: Table = Table {
    name: "[[simulation.sensor]]",
    about: "A sensor that measures one output at instants of its own: at the offset and every period after it. Between them, and where a measurement does not arrive, filters predict.",
    variants: None,
    keys: &[
        required("output", Type::Text, "The name of the output."),
        required("period", Type::Number(Range::Positive), "Time between two measurements."),
        optional("offset", Type::Number(Range::NotNegative), "Time of the first measurement (default 0)."),
        optional(
            "distribution",
            Type::Choice(DISTRIBUTIONS),
            "Distribution of its noise (default that of simulation.noise, or gaussian).",
        ),
        optional(
            "amplitude",
            Type::Number(Range::NotNegative),
            "Standard deviation (gaussian) or largest value (uniform) of its noise, drawn anew at each measurement (default that of simulation.noise, or 0).",
        ),
        optional("seed", Type::Count(0), "Seed of its noise (default that of simulation.noise, or 0)."),
    ],
};

/// The distributions of measurement noise.
const DISTRIBUTIONS: &[(&str, &str)] = &[
    ("gaussian", "Normal distribution with mean 0."),
    ("uniform", "Uniform distribution between -amplitude and amplitude."),
];

const NOISE: Table = Table {
    name: "noise",
    about: "Measurement noise, from a seeded generator: the same in every run.",
    variants: None,
    keys: &[
        optional("distribution", Type::Choice(DISTRIBUTIONS), "Distribution (default gaussian)."),
        required(
            "amplitude",
            Type::Numbers(Range::NotNegative),
            "Standard deviation (gaussian) or largest value (uniform), one number for each output.",
        ),
        required(
            "period",
            Type::Number(Range::Positive),
            "Sampling period of the noise; each value is held for this time.",
        ),
        optional("seed", Type::Count(0), "Seed of the generator (default 0)."),
    ],
};

/// Which estimates of a filter are scored.
const ESTIMATES: &[(&str, &str)] = &[
    ("filtered", "After the measurement of the sample (a posteriori)."),
    ("predicted", "Before the measurement of the sample (a priori)."),
];

const ESTIMATES_ABOUT: &str = "Which estimates of a filter at its samples are scored, drawn and written (default filtered). Other observers have only one.";

const LOG: Table = Table {
    name: "[log]",
    about: "A measured log. The observers run on it, and their innovations are reported. A blank cell is no measurement.",
    variants: None,
    keys: &[
        required("file", Type::Text, "A CSV file with a header; its path is relative to the folder of the study."),
        optional(
            "time",
            Type::Text,
            "The column of times: numbers, dates or times of day, or an expression such as \"stamp/1e6\" (default t).",
        ),
        optional(
            "inputs",
            Type::Columns,
            "The columns of the inputs, or expressions of columns (default: the names of the plant's inputs).",
        ),
        optional(
            "outputs",
            Type::Texts,
            "The columns of the outputs, or expressions of columns, such as \"acc_x/9.81\" (default: the names of the plant's outputs).",
        ),
        optional(
            "variances",
            Type::Texts,
            "The columns, or expressions of columns, of the variances of the measurements, one for each output, such as \"accuracy^2\"; \"-\" for an output with that of `v`. Where a row has one it takes the place of the entry of V (default: V).",
        ),
        optional(
            "repeats",
            Type::Choice(&[
                ("once", "A value that the logger repeats until the next measurement counts once."),
                ("measured", "Every row is a measurement."),
            ]),
            "What an output is that repeats its values in a rhythm (default once).",
        ),
        optional(
            "states",
            Type::Texts,
            "The columns of the true states, one for each state, \"-\" for an unknown one: the errors are reported (default none).",
        ),
        optional(
            "interpolation",
            Type::Choice(&[
                ("predicted", "A measurement moves with the model until the next one; only rows correct an estimate."),
                ("held", "A measurement is held until the next one, late by half a period on average."),
                ("linear", "Straight lines between rows, which know the future, but not across gaps and blank cells."),
            ]),
            "What observers in continuous time see of the outputs between the rows (default predicted). Observers at their own period predict there, or see the straight lines.",
        ),
        optional("estimates", Type::Choice(ESTIMATES), ESTIMATES_ABOUT),
    ],
};

/// The available plots.
pub(crate) const QUANTITIES: &[(&str, &str)] = &[
    ("states", "Each state with its estimates."),
    ("errors", "The error of each state."),
    ("error-norm", "The norm of the error on a logarithmic axis."),
    ("inputs", "The inputs."),
    ("outputs", "The outputs, with noise if there is any."),
    ("innovations", "The innovation of each observer, y - h(xhat)."),
];

const PLOT: Table = Table {
    name: "[plot]",
    about: "The figures.",
    variants: None,
    keys: &[
        optional(
            "show",
            Type::Choices(QUANTITIES),
            "Which figures (default: states, errors, error-norm and inputs; for a log, states and innovations).",
        ),
        optional("states", Type::Texts, "Only these states, by name."),
        optional("observers", Type::Texts, "Only these observers, by name."),
        optional("from", Type::Number(Range::NotNegative), "Start time of the figures (default: that of the data)."),
        optional("to", Type::Number(Range::Positive), "End time of the figures (default: that of the data)."),
    ],
};

/// The parameters of a sweep.
pub(crate) const SWEPT: &[(&str, &str)] = &[
    ("gamma", "Gain of the cubic term, gamma or radial, of the observers that have one."),
    ("poles", "Factor of the poles, decay rates and 1/r: 2 makes an observer twice as fast."),
    ("noise", "Factor of the amplitude of the measurement noise."),
    ("initial", "Factor of the initial error x(0) - xhat(0)."),
];

const SWEEP: Table = Table {
    name: "[sweep]",
    about: "A parameter sweep: at each value all observers are designed and run again, in parallel, in the simulation or on the log.",
    variants: None,
    keys: &[
        required(
            "parameter",
            Type::Text,
            "The parameter: gamma; a factor of the poles, of the noise or of the initial error; or a number of the study by its place, plant.NAME for a parameter of the plant, observer.NAME.KEY, simulation.KEY.",
        ),
        optional(
            "values",
            Type::Numbers(Range::Any),
            "Its values; factors are positive. Alternatively: from, to, count and spacing.",
        ),
        optional("from", Type::Number(Range::Any), "Smallest value."),
        optional("to", Type::Number(Range::Any), "Largest value."),
        optional("count", Type::Count(2), "Number of values (default 9)."),
        optional(
            "spacing",
            Type::Choice(&[("log", "Constant ratio."), ("linear", "Constant difference.")]),
            "Spacing of the values (default log).",
        ),
        optional(
            "ensemble",
            Type::Count(1),
            "Number of runs at each value, with different noise and different directions of the initial error (default 1).",
        ),
        optional("seed", Type::Count(0), "Seed of the ensemble (default 0)."),
        optional("observers", Type::Texts, "Only these observers, by name."),
        optional(
            "on",
            Type::Choice(&[
                ("simulation", "At each value the observers run in the simulation."),
                (
                    "log",
                    "They run on the log, once at each value, and are judged by their predictions of its last part.",
                ),
            ]),
            "What the observers run on (default simulation, or log in a study without one).",
        ),
        optional(
            "held_out",
            Type::Number(Range::Positive),
            "On a log: the share of it, its last part, by which observers are judged (default: that of [tune], else 0.3).",
        ),
    ],
};
