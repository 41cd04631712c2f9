//! The table [advise]: the prior information with which `luenberger advise` tunes every kind of observer.

use crate::keys::{Range, Table, Type, optional};
use crate::kinds::keys::{BOX, UNKNOWN_OF_ADVICE};

pub(super) const ADVISE: Table = Table {
    name: "[advise]",
    about: "The prior information with which `luenberger advise` tunes every kind of observer. What is not given is derived, and the output says from what.",
    variants: None,
    keys: &[
        optional(
            "settling",
            Type::Number(Range::Positive),
            "Settling time that the observers are tuned for, to the band of the simulation (default: a quarter of its duration).",
        ),
        optional(
            "region",
            Type::Table(&BOX),
            "Region of states, inputs and time (default: that of the first observer that has one, else the box around the run of the plant and the first estimate, widened by half its width on each side).",
        ),
        optional(
            "initial",
            Type::Numbers(Range::Any),
            "First estimate of all observers, n numbers (default: that of the first observer of the study, else the operating point, else 0).",
        ),
        optional(
            "w",
            Type::Weight,
            "Intensity W of the process noise, n x n, per unit of time (default: that of the process noise of [truth], else a multiple of the squared widths of the region for which the stationary Kalman filter settles in the settling time).",
        ),
        UNKNOWN_OF_ADVICE,
        optional(
            "disturbance",
            Type::Numbers(Range::NotNegative),
            "Bounds of |w| of this disturbance, x' = A x + B u + E w, q numbers (default: those of the first observer with `bounds` that has some, with its E).",
        ),
        optional(
            "period",
            Type::Number(Range::Positive),
            "Sampling period of sampled observers and of exported code (default: that of the first sampled observer of the study, else of the noise).",
        ),
        optional(
            "noise",
            Type::Numbers(Range::NotNegative),
            "Standard deviation of a measurement of each output of a log, p numbers (default: that of V of the first filter of the study, else from second differences of the measurements); in a simulation it is that of the simulation.",
        ),
        optional(
            "held_out",
            Type::Number(Range::Positive),
            "The share of a log, its last part, by which observers are ranked (default: that of [tune], else 0.3).",
        ),
        optional(
            "ensemble",
            Type::Count(1),
            "Runs of each observer, each with other noise and another first estimate (default 20).",
        ),
        optional("seed", Type::Count(0), "Seed of the first estimates (default 0)."),
    ],
};
