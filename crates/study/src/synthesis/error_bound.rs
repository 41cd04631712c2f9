//! A bound of the error under bounded noise and disturbances, as a part of a design.

use luenberger_design::{DisturbanceBounds, ErrorBound};
use luenberger_proof::certificate::{Reading, Represented};

use super::{Designed, facts, number, upper_bound};
use crate::results::DesignVerdict;
use crate::study::ActingBounds;

/// What acts on the plant, as the design takes it.
pub(crate) fn acting(bounds: &ActingBounds) -> DisturbanceBounds {
    DisturbanceBounds::of_states_and_outputs(&bounds.e, &bounds.disturbance, &bounds.noise)
}

/// The design with a bound of the error, if that is proved; the plant may be uncertain.
pub(crate) fn bounded(
    designed: Designed,
    bound: &ErrorBound,
    reading: &Reading<'_>,
    bounds: &ActingBounds,
) -> Designed {
    let plant = if bounds.uncertain.is_some() { Represented::Uncertain } else { reading.plant };
    let reading = &Reading { plant, ..*reading };
    let Designed { runnable, mut report, certificate, origin } = designed;
    let certificate = certificate.unwrap_or_default().and(bound.certificate.clone());
    if bound.certificate.is_proved() {
        report.statement = report.statement.proved(bound.certificate.sentences(reading));
        for (name, limit) in reading.states.iter().zip(&bound.limsup) {
            report.numbers.push(upper_bound(&format!("bound of the error of {name}"), *limit));
        }
        if bound.cubic_share > 0.0 {
            report.numbers.push(number("share of the cubic term in V", bound.cubic_share));
        }
    }
    report.facts = facts(&certificate, &[]);
    report.verdict = DesignVerdict::of(&certificate);
    Designed { runnable, report, certificate: Some(certificate), origin }
}
