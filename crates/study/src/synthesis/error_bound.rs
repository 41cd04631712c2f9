//! A bound of the error under bounded noise and disturbances, as a part of a design.

use luenberger_design::{DisturbanceBounds, ErrorBound};
use luenberger_proof::certificate::{Reading, Represented, is_useful};

use super::{Designed, facts, number, upper_bound};
use crate::results::DesignVerdict;
use crate::study::ActingBounds;

/// What acts on the plant, as the design takes it.
pub(crate) fn acting(bounds: &ActingBounds) -> DisturbanceBounds {
    DisturbanceBounds::of_states_and_outputs(&bounds.e, &bounds.disturbance, &bounds.noise)
}

/// That the bounds of these errors are not useful, and why.
pub(crate) fn no_useful_bound(states: &[&str]) -> String {
    format!(
        "No useful bound of {}: along the study's simulation a constant estimate has a smaller error than the bound that is proved.",
        states.join(", ")
    )
}

/// The design with a bound of the error, if that is proved; the plant may be uncertain. Entries that are not useful by
/// the scales of the reading are no numbers of the report; their names are in a remark with what may help.
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
        let mut without = Vec::new();
        for (k, (name, limit)) in reading.states.iter().zip(&bound.limsup).enumerate() {
            if is_useful(*limit, reading.scales.get(k).copied().unwrap_or(0.0)) {
                report.numbers.push(upper_bound(&format!("bound of the error of {name}"), *limit));
            } else {
                without.push(name.as_str());
            }
        }
        if !without.is_empty() {
            let remedy = "What may give one: tighter `bounds`, or another gain, a slower one where the noise makes most of it, a faster one where the disturbances do.";
            report.statement = report.statement.remark(no_useful_bound(&without)).remark(remedy);
        }
        if bound.cubic_share > 0.0 {
            report.numbers.push(number("share of the cubic term in V", bound.cubic_share));
        }
    }
    report.facts = facts(&certificate, &[]);
    report.verdict = DesignVerdict::of(&certificate);
    Designed { runnable, report, certificate: Some(certificate), origin }
}
