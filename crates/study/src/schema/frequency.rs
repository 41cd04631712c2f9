//! The table [frequency]: frequency responses of observers and of the loop.

use crate::keys::{Range, Table, Type, optional};

pub(super) const FREQUENCY: Table = Table {
    name: "[frequency]",
    about: "Frequency responses of the linear observers of the study, of its feedback loop with the margins, and loop transfer recovery.",
    variants: None,
    keys: &[
        optional(
            "from",
            Type::Number(Range::Positive),
            "First frequency of the figures, in radians per unit of time (default: a decade below the slowest pole).",
        ),
        optional(
            "to",
            Type::Number(Range::Positive),
            "Last frequency (default: a decade above the fastest pole; in discrete time at most pi/dt, which is the default).",
        ),
        optional(
            "points",
            Type::Count(2),
            "Number of frequencies, equally spaced in their logarithm (default 400); those of lightly damped poles are added.",
        ),
        optional(
            "recovery",
            Type::Numbers(Range::NotNegative),
            "Values of q for a table of loop transfer recovery, of a loop in continuous time with a Kalman filter: the filter for W + q^2 B B' beside the loop of state feedback.",
        ),
    ],
};
