//! The table [truth] of a study file.

use crate::keys::{Key, Range, Table, Type, optional, required};

pub(super) const TRUTH: Table = Table {
    name: "[truth]",
    about: "The plant as it is simulated, where it differs from the model that the observers are designed for.",
    variants: None,
    keys: &[
        PARAMETERS,
        A,
        B,
        C,
        D,
        F,
        H,
        optional("event", Type::Tables(&EVENT), "Changes of the plant at a time."),
        optional(
            "process_noise",
            Type::Table(&PROCESS_NOISE),
            "Noise added to the derivatives of the states. White noise of intensity W has the standard deviation sqrt(W / period).",
        ),
        optional(
            "input_delay",
            Type::Number(Range::NotNegative),
            "The input reaches the plant this much later (default 0).",
        ),
        optional(
            "measurement_delay",
            Type::Number(Range::NotNegative),
            "The outputs are read this much later (default 0).",
        ),
        optional("actuator", Type::Table(&FAULT), "The plant gets gain u + bias; observers are given u."),
        optional("sensor", Type::Table(&FAULT), "The observers read gain y + bias, and the noise."),
        optional(
            "quantisation",
            Type::Numbers(Range::NotNegative),
            "Measurements are multiples of these steps, one for each output; 0 for none.",
        ),
        optional(
            "dropout",
            Type::Number(Range::NotNegative),
            "Probability that a measurement does not arrive: it is no measurement, and filters predict.",
        ),
        optional("outliers", Type::Table(&OUTLIERS), "Measurements that are far off."),
        optional(
            "period",
            Type::Number(Range::Positive),
            "Dropouts and outliers are drawn anew in this period (default that of simulation.noise), and for each measurement of a [[simulation.sensor]].",
        ),
        optional("seed", Type::Count(0), "The seed of dropouts and outliers (default 0)."),
    ],
};

const PARAMETERS: Key =
    optional("parameters", Type::Named, "Other values of parameters of the plant; with `f` or `h` new parameters too.");
const A: Key = optional("a", Type::Rows, "Another A of a plant of matrices.");
const B: Key = optional("b", Type::Rows, "Another B, likewise.");
const C: Key = optional("c", Type::Rows, "Another C, likewise.");
const D: Key = optional("d", Type::Rows, "Another D, likewise.");
const F: Key = optional(
    "f",
    Type::Texts,
    "Other right-hand sides, for plants of any form: expressions with the names of the plant.",
);
const H: Key = optional("h", Type::Texts, "Other outputs, likewise. A plant of matrices or of the library needs both.");

const EVENT: Table = Table {
    name: "[[truth.event]]",
    about: "A change of the simulated plant at a time: other parameters, matrices or equations from there on, a jump of the state. The model of the observers does not change.",
    variants: None,
    keys: &[
        required("at", Type::Number(Range::Positive), "When the plant changes."),
        optional("jump", Type::Numbers(Range::Any), "Added to the state, one number for each state."),
        PARAMETERS,
        A,
        B,
        C,
        D,
        F,
        H,
    ],
};

const PROCESS_NOISE: Table = Table {
    name: "process_noise",
    about: "Noise added to the derivatives of the states, seeded: the same in every run.",
    variants: None,
    keys: &[
        optional(
            "distribution",
            Type::Choice(&[
                ("gaussian", "Normal, of mean 0."),
                ("uniform", "Uniform, between minus and plus the amplitude."),
            ]),
            "The distribution (default gaussian).",
        ),
        required(
            "amplitude",
            Type::Numbers(Range::NotNegative),
            "Standard deviation or amplitude, one for each state.",
        ),
        required("period", Type::Number(Range::Positive), "Each value holds for this time."),
        optional("seed", Type::Count(0), "The seed (default 0)."),
        optional(
            "noises",
            Type::Switch,
            "Whether the noises of [estimate.noises] vary in the simulated plant, with their standard deviations and correlation times (default false: they stay at their values).",
        ),
    ],
};

const FAULT: Table = Table {
    name: "actuator or sensor",
    about: "Gain and bias from a time on.",
    variants: None,
    keys: &[
        optional("gain", Type::Numbers(Range::Any), "Factor of each entry (default 1)."),
        optional("bias", Type::Numbers(Range::Any), "Added to each entry (default 0)."),
        optional("from", Type::Number(Range::NotNegative), "When it begins (default 0)."),
    ],
};

const OUTLIERS: Table = Table {
    name: "outliers",
    about: "Measurements that are off by plus or minus a size.",
    variants: None,
    keys: &[
        required("probability", Type::Number(Range::NotNegative), "Probability of each measurement to be one."),
        required("size", Type::Numbers(Range::NotNegative), "How far off, one for each output."),
    ],
};
