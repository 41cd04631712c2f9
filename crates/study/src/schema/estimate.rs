//! The table [estimate]: parameters of the plant that filters estimate.

use crate::keys::{Range, Table, Type, optional, required};

pub(super) const ESTIMATE: Table = Table {
    name: "[estimate]",
    about: "Parameters of the plant that filters estimate with its state, as its last states: constants, or random walks.",
    variants: None,
    keys: &[
        required(
            "parameters",
            Type::Names(1),
            "Their names. Each has the value of [plant] as its first estimate; the simulated plant has that of [truth], if it has one there.",
        ),
        required(
            "p0",
            Type::Numbers(Range::NotNegative),
            "Variances of their first errors, one for each; those of the states are in `p0` of the observer.",
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
    ],
};
