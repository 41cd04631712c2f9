//! The proportional-integral observer: the state and a constant or slowly varying disturbance.

use super::as_kind;
use super::declaration::{Declaration, Information, Rule, Tuning};
use super::disturbance::{self, CubicTerm, DisturbanceSpec};
use super::keys::{ERROR_BOUNDS, GAINS, OF_GAIN, UNKNOWN};
use crate::keys::{Range, Type, optional};
use crate::study::{PlantClass, Time};
use crate::tuning::{Context, Keys, Value, disturbance as unknown, poles as tuned_poles};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "proportional-integral",
    about: "Observer of the state and of a constant or slowly varying disturbance d, x' = A x + B u + E d (x+ in discrete time), for linear plants. Poles and gains are those of the plant with d among its states, n + q of them.",
    source: "open problem of Share Pasand, Luenberger-type cubic observers; Wojciechowski 1978",
    plant: PlantClass::Linear(Time::ANY),
    keys: &[
        &[
            UNKNOWN,
            optional(
                "rate",
                Type::Numbers(Range::NotNegative),
                "Bounds of |d'|, q numbers, for the bound of the error (default 0: constant).",
            ),
        ],
        GAINS,
        OF_GAIN,
        CubicTerm::KEYS,
        &[ERROR_BOUNDS],
    ],
    kind: as_kind::<DisturbanceSpec>,
    read: |given, reader| disturbance::read(given, false, reader),
    takes_long: false,
    tuning: Tuning::Rules(&[Rule {
        name: "proportional-integral",
        turn: 10,
        tuning: "as luenberger, with the disturbance among the modes that become Bessel poles",
        source: "luenberger poles --pattern bessel",
        character: "it estimates the disturbance with the state, which costs noise where there is no disturbance",
        information: &[Information::Settling, Information::Disturbance],
        keys: tuned,
    }]),
};

fn tuned(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    let e = unknown(context)?;
    let mut keys = vec![("e", Value::rows(e))];
    keys.extend(tuned_poles(context, e.ncols())?);
    Ok(vec![keys])
}
