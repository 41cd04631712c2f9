//! The table [tune]: what `luenberger tune` fits to the log.

use crate::keys::{Range, Table, Type, optional, required};
use crate::study::TuneCriterion;

pub(super) const TUNE: Table = Table {
    name: "[tune]",
    about: "What `luenberger tune` fits to the log: a filter by the maximum likelihood of its innovations, any other observer by the errors of its estimates or of its predictions.",
    variants: None,
    keys: &[
        required("observer", Type::Text, "The observer, by its name."),
        optional(
            "criterion",
            Type::Choice(TuneCriterion::WORDS),
            "What is minimised or maximised (default: the likelihood of kalman of a plant in discrete time, extended-kalman, iterated-extended-kalman and ukf; of others the errors where the log has true states, else the innovations).",
        ),
        required(
            "parameters",
            Type::Texts,
            "What is fitted: \"w\", \"v\", \"p0\" for all variances of the diagonal, \"w[soc]\", \"v[voltage]\" for one, the name of a parameter of the plant, \"bias[voltage]\" for the bias of a sensor, \"delay[voltage]\" for its delay, and keys of the observer: \"poles\", \"gain\", \"decay_rate\", \"bandwidth\" and the like. What is positive in the study stays so: it is fitted by its logarithm.",
        ),
        optional(
            "bounds",
            Type::NamedBounds,
            "Bounds of parameters by their names; positive ones keep the logarithm (default: a millionth to a million times the value of the study, a thousandth to a thousand times that of a key of the observer, 100 times its magnitude to either side for a negative one, 100 standard deviations of the measurement for a bias).",
        ),
        optional("files", Type::Texts, "More logs, with the columns of the first."),
        optional(
            "held_out",
            Type::Number(Range::NotNegative),
            "Share of each log, its last part, that is not fitted, on which the filter is judged (default 0.3; 0 for none).",
        ),
        optional(
            "starts",
            Type::Count(1),
            "Searches: one from the values of the study, the others from random ones within a factor of 10 (default 3).",
        ),
        optional("seed", Type::Count(0), "Seed of their starts (default 0)."),
        optional(
            "profile",
            Type::Count(0),
            "Points to either side in the figure of each profile likelihood (default 4; 0 for no figures).",
        ),
    ],
};
