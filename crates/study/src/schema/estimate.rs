//! The table [estimate]: parameters of the plant that filters estimate, and coloured noises.

use crate::keys::{Range, Table, Type, optional, required};

pub(super) const ESTIMATE: Table = Table {
    name: "[estimate]",
    about: "Parameters of the plant that filters estimate with its state, as its last states: constants, random walks, or coloured noises.",
    variants: None,
    keys: &[
        optional(
            "parameters",
            Type::Names(1),
            "Their names. Each has the value of [plant] as its first estimate; the simulated plant has that of [truth], if it has one there.",
        ),
        optional(
            "p0",
            Type::Numbers(Range::NotNegative),
            "Variances of their first errors, one for each, needed with `parameters`; those of the states are in `p0` of the observer.",
        ),
        optional(
            "w",
            Type::Numbers(Range::NotNegative),
            "Intensities of their random walks per unit of time, in discrete time their variances per sample, one for each (default 0: constants).",
        ),
        optional(
            "bounds",
            Type::Bounds,
            "Their bounds, a pair [lower, upper] for each; they may be inf or -inf (default: none). As `state_bounds` of an observer, for the parameters.",
        ),
        optional(
            "noises",
            Type::NamedTables(&NOISE),
            "Coloured noises: parameters of the plant that vary about their values in [plant] as Gauss-Markov processes of first order; as states they follow those of `parameters`.",
        ),
    ],
};

const NOISE: Table = Table {
    name: "[estimate.noises.NAME]",
    about: "A coloured noise n: n' = -n/tau + w with E n^2 = deviation^2, to which the value of the parameter in [plant] is added.",
    variants: None,
    keys: &[
        required(
            "tau",
            Type::Number(Range::Positive),
            "Correlation time, after which the autocorrelation has fallen to 1/e.",
        ),
        required("deviation", Type::Number(Range::Positive), "Standard deviation of the noise."),
        optional(
            "p0",
            Type::Number(Range::NotNegative),
            "Variance of the first error (default deviation^2, of a noise that has always run).",
        ),
    ],
};
