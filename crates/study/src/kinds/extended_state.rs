//! The extended-state observer: the state and a disturbance with some of its derivatives.

use super::as_kind;
use super::declaration::{Declaration, Information, Rule, Tuning};
use super::disturbance::{self, DisturbanceSpec};
use super::keys::{ERROR_BOUNDS, GAINS, OF_GAIN, UNKNOWN};
use crate::keys::{Range, Type, optional};
use crate::study::{PlantClass, Time};
use crate::tuning::{Context, Keys, Value, chain_settling, disturbance as unknown, linear as is_linear, short};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "extended-state",
    about: "Extended-state observer (disturbance observer): the state and a disturbance d with some derivatives, x' = A x + B u + E d (x+ in discrete time), for linear plants. Poles and gains are those of the plant with n + q order states.",
    source: "Han 2009; Gao 2003; in discrete time Miklosovic, Radke and Gao 2006; as a disturbance observer Ohnishi, Shibata and Murakami 1996",
    plant: PlantClass::Linear(Time::ANY),
    keys: &[
        &[
            UNKNOWN,
            optional(
                "order",
                Type::Count(1),
                "Number of integrators in the model of each disturbance: 1 for constant ones, 2 for ramps (default 1).",
            ),
            optional(
                "bandwidth",
                Type::Number(Range::Positive),
                "omega_o: all poles at -omega_o; with p outputs from -0.8 to -1.25 omega_o, p of them equal. In discrete time at exp(s dt) for these s.",
            ),
            optional(
                "rate",
                Type::Numbers(Range::NotNegative),
                "Bounds of the derivative of this order of d, q numbers, for the bound of the error (default 0).",
            ),
        ],
        GAINS,
        OF_GAIN,
        &[ERROR_BOUNDS],
    ],
    kind: as_kind::<DisturbanceSpec>,
    read: |given, reader| disturbance::read(given, true, reader),
    takes_long: false,
    tuning: Tuning::Rules(&[Rule {
        name: "extended-state",
        turn: 11,
        tuning: "the bandwidth with which a chain of the order of plant and disturbance settles in the settling time",
        source: "Gao 2003",
        character: "it estimates the disturbance with the state, which costs noise where there is no disturbance",
        information: &[Information::Settling, Information::Disturbance],
        keys: tuned,
    }]),
};

/// Order 1: a constant disturbance.
fn tuned(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    let e = unknown(context)?;
    is_linear(context)?;
    let settling = -context.information.band.ln() / context.information.linear_rate;
    let order = context.study.plant.states.len() + e.ncols();
    let bandwidth = chain_settling(order, context.information.band) / settling;
    Ok(vec![vec![("e", Value::rows(e)), ("bandwidth", Value::Number(short(bandwidth)))]])
}
