//! A bound of the error under bounded noise and disturbances, as a part of a design.

use luenberger_design::{DisturbanceBounds, ErrorBound};
use luenberger_proof::wording::{at_least, at_most};

use super::{Designed, facts, number, upper_bound, verdict};
use crate::study::ActingBounds;

/// What acts on the plant, as the design takes it.
pub(super) fn acting(bounds: &ActingBounds) -> DisturbanceBounds {
    DisturbanceBounds::of_states_and_outputs(&bounds.e, &bounds.disturbance, &bounds.noise)
}

/// The design with a bound of the error, if that is proved; `names` are those of the components of the error.
pub(super) fn bounded(designed: Designed, bound: &ErrorBound, names: &[String], bounds: &ActingBounds) -> Designed {
    let Designed { runnable, mut report, certificate, .. } = designed;
    let certificate = certificate.unwrap_or_default().and(bound.certificate.clone());
    if bound.certificate.is_proved() {
        let limits: Vec<String> =
            names.iter().zip(&bound.limsup).map(|(name, limit)| format!("{name} {}", at_most(*limit, 4))).collect();
        report.statement = format!(
            "{} Under all noise and disturbances within `bounds`{} the error in the end is at most {}, approached like exp(-{} t).",
            report.statement,
            if bounds.uncertain.is_some() {
                ", for every deviation of A and while the states keep theirs,"
            } else {
                ""
            },
            limits.join(", "),
            at_least(bound.rate, 4)
        );
        for (name, limit) in names.iter().zip(&bound.limsup) {
            report.numbers.push(upper_bound(&format!("bound of the error of {name}"), *limit));
        }
        if bound.cubic_share > 0.0 {
            report.numbers.push(number("share of the cubic term in V", bound.cubic_share));
        }
    }
    report.facts = facts(&certificate, &[]);
    report.verdict = verdict(&certificate);
    Designed::new(runnable, report, Some(certificate))
}
