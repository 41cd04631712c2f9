//! What the designs of all kinds share: hypotheses in words, reports, linear gains, bounds of the error.

pub(crate) mod alternative;
pub(crate) mod discrete;
pub(crate) mod error_bound;
pub(crate) mod explain;
pub(crate) mod feedback;
pub(crate) mod kkl_maps;
pub(crate) mod linear;
pub(crate) mod noise_gain;
pub(crate) mod operating_point;
pub(crate) mod plan;

pub(crate) use alternative::other_kinds;
pub use plan::{Plan, Sampling};

use luenberger_design::{Certificate, Fact};
use luenberger_plants::serialization::rows;
use luenberger_proof::Verdict;
use luenberger_proof::certificate::Reading;
use luenberger_proof::wording::{at_least, significant};
use nalgebra::{Complex, DMatrix};

pub(crate) use crate::designed::Designed;
use crate::model::PlantModel;
use crate::results::{DesignReport, DesignVerdict, FactReport, Label, NamedMatrix, NamedNumber, Rounding, Statement};

pub(crate) fn matrix(name: &str, m: &DMatrix<f64>) -> NamedMatrix {
    NamedMatrix { name: name.to_owned(), rows: rows(m), is_of_proof: false }
}

/// A matrix of the proof.
pub(crate) fn proof_matrix(name: &str, m: &DMatrix<f64>) -> NamedMatrix {
    NamedMatrix { is_of_proof: true, ..matrix(name, m) }
}

/// A computed number.
pub(crate) fn number(name: impl Into<Label>, value: f64) -> NamedNumber {
    let Label { name, quantity } = name.into();
    NamedNumber { name, quantity, value: value.is_finite().then_some(value), rounding: Rounding::Nearest }
}

/// A number that is proved to be at least this.
pub(crate) fn lower_bound(name: impl Into<Label>, value: f64) -> NamedNumber {
    NamedNumber { rounding: Rounding::Down, ..number(name, value) }
}

/// A number that is proved to be at most this.
pub(crate) fn upper_bound(name: impl Into<Label>, value: f64) -> NamedNumber {
    NamedNumber { rounding: Rounding::Up, ..number(name, value) }
}

pub(crate) fn poles(poles: &[Complex<f64>]) -> Vec<[f64; 2]> {
    let mut poles: Vec<[f64; 2]> = poles.iter().map(|pole| [pole.re, pole.im]).collect();
    poles.sort_by(|x, y| x[0].total_cmp(&y[0]).then(x[1].total_cmp(&y[1])));
    poles
}

/// The facts of a certificate, each with its verdict in words: those that are not verified first, then by margin, the
/// smallest first, and at the end those without a margin.
pub(crate) fn facts(certificate: &Certificate, vertices: &[String]) -> Vec<FactReport> {
    let mut facts: Vec<FactReport> = certificate.facts().map(|each| fact(each, vertices)).collect();
    let order = |fact: &FactReport| match (fact.verdict.is_proved(), fact.margin) {
        (true, Some(margin)) if margin > 0.0 => margin,
        (true, _) => f64::INFINITY,
        _ => f64::NEG_INFINITY,
    };
    facts.sort_by(|x, y| order(x).total_cmp(&order(y)));
    facts
}

fn fact(fact: &Fact, vertices: &[String]) -> FactReport {
    let words = match &fact.verdict {
        Verdict::Proved { margin } if *margin > 0.0 => {
            format!("verified; margin >= {}", at_least(*margin, 4))
        }
        Verdict::Proved { .. } => "verified; no margin".to_owned(),
        Verdict::Refuted { witness } => format!("false for these numbers: {witness}"),
        Verdict::Undecided { why, best } if best.is_nan() => format!("undecided: {why}"),
        Verdict::Undecided { why, best } => {
            format!("undecided: {why} (margin in floating point: {})", significant(*best, 4))
        }
    };
    FactReport {
        statement: fact.inequality_naming(vertices),
        verdict: DesignVerdict::of_fact(&fact.verdict),
        margin: fact.verdict.margin(),
        words,
        is_at_vertex: fact.vertex.is_some(),
        names_margin: match &fact.verdict {
            Verdict::Proved { .. } => true,
            Verdict::Refuted { .. } => false,
            Verdict::Undecided { best, .. } => !best.is_nan(),
        },
        equation: equation(&fact.inequality).map(str::to_owned),
    }
}

/// The number of an inequality in its paper, `(13')`, in its label.
fn equation(label: &str) -> Option<&str> {
    let is_number = |word: &&str| {
        word.strip_prefix('(').is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()) && rest.ends_with(')'))
    };
    label.split_whitespace().find(is_number)
}

/// The standard deviations of an error of this covariance.
pub(crate) fn deviations(covariance: &DMatrix<f64>) -> Vec<f64> {
    covariance.diagonal().iter().map(|variance| variance.max(0.0).sqrt()).collect()
}

/// What a certificate proves of the plant that it is read as; that nothing is proved, where that is so.
pub(crate) fn proved_of(certificate: &Certificate, reading: &Reading<'_>) -> Statement {
    Statement::of_proved(certificate.sentences(reading))
}

/// The rate at which errors decay in the end, by the poles in floating point.
pub(crate) fn asymptotic_rate(rate: f64) -> String {
    format!("Computed: asymptotic rate exp(-{} t).", significant(rate, 5))
}

/// The same from sample to sample.
pub(crate) fn asymptotic_factor(radius: f64) -> String {
    format!("Computed: asymptotic factor {} at each sample.", significant(radius, 5))
}

/// The part of a report that is the certificate's; the rest is empty.
pub(crate) fn certified(certificate: &Certificate, vertices: &[String]) -> DesignReport {
    DesignReport {
        facts: facts(certificate, vertices),
        verdict: DesignVerdict::of(certificate),
        ..DesignReport::default()
    }
}

/// That of a filter of which nothing is proved: `why`, unless the plant is one for which no observer exists.
pub(crate) fn without_certificate(plant: &PlantModel, why: &str) -> DesignReport {
    let is_hidden = explain::undetectable(plant).is_some();
    uncertified(if is_hidden { "the plant is not detectable, no observer exists" } else { why })
}

/// That of a design without a certificate, for this reason.
pub(crate) fn uncertified(why: &str) -> DesignReport {
    DesignReport {
        verdict: DesignVerdict::NONE,
        evidence: Some(format!("no certificate: {why}")),
        ..DesignReport::default()
    }
}
