//! Results of the comparison as data.

use serde::Serialize;

use super::candidate::Medians;
use super::ranking::{Criteria, Criterion};
use crate::results::{DesignVerdict, PlantSummary, PredictionReport, ScoringReport, Statement};
use crate::tuning::{InformationKind, PriorInformation};

/// Which observer to use for a study, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Advice {
    /// The title of the study.
    pub title: String,
    /// The plant.
    pub plant: PlantSummary,
    /// Observability as a sentence, where it limits what any observer can do.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub observability: Option<String>,
    /// The prior information of every kind.
    pub information: Vec<PriorInformation>,
    /// The criteria.
    pub criteria: Criteria,
    /// Runs of each observer.
    pub runs: usize,
    /// Runs that were asked for.
    pub ensemble: usize,
    /// Where and in which units errors are scored; none if no run was reached.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scoring: Option<ScoringReport>,
    /// On a log: which rows the observers are judged on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held_out: Option<String>,
    /// The observers, the best first.
    pub ranking: Vec<RankedObserver>,
    /// Names of those that no other is better than in error and cost.
    pub pareto_cost: Vec<String>,
    /// Likewise in error and peak.
    pub pareto_peak: Vec<String>,
    /// The ranking in words.
    pub explanation: Vec<String>,
    /// The kinds that do not apply.
    pub not_applicable: Vec<NotApplicable>,
    /// What the budget did not reach, and why.
    pub not_reached: Vec<String>,
    /// Observers that are recommended: the best one, or of those within 5 % of it one with a proof, then the
    /// cheapest; and the best one with a proof.
    pub recommended: Vec<String>,
    /// The files that were written.
    pub files: Vec<String>,
    /// Files that stood in the way: their names, and the names they have now.
    #[serde(skip)]
    pub renamed: Vec<(String, String)>,
    /// The study with the recommended observers.
    #[serde(skip)]
    pub study: String,
}

impl Advice {
    /// What tells beside the criteria how good an estimate is: the error, or on a log the innovations.
    pub(super) fn accuracy(&self) -> Criterion {
        let is_by_error = self.criteria.0.iter().any(|(criterion, _)| *criterion == Criterion::Error);
        if is_by_error || self.held_out.is_none() { Criterion::Error } else { Criterion::Innovations }
    }
}

/// An observer of the ranking.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RankedObserver {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: String,
    /// Weighted geometric mean of its values relative to the best ones; none if a value does not exist.
    pub score: Option<f64>,
    /// Runs that finished.
    pub finished: usize,
    /// Why others ended early, the first reason.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ended: Option<String>,
    /// Runs that left the region of the design.
    pub left_region: usize,
    /// Its scores.
    #[serde(flatten)]
    pub medians: Medians,
    /// Its scores on the part of a log that is held out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on_log: Option<PredictionReport>,
    /// Floating-point operations of a step on the target.
    pub operations: Option<usize>,
    /// Why it has no step on a target.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_exported: Option<String>,
    /// Noise gain of its design for white noise, where it has a constant gain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise_gain: Option<f64>,
    /// `proved`, `measured`, `none`, ..
    pub verdict: DesignVerdict,
    /// What is claimed of it.
    pub statement: Statement,
    /// The other of the ranking that is the same observer, with the same gain to three digits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub same_as: Option<String>,
    /// Its tuning rule.
    pub rule: String,
    /// Where the rule is from.
    pub source: String,
    /// What it uses of the information.
    pub information: Vec<InformationKind>,
}

/// A kind that does not apply.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NotApplicable {
    /// The row of the table of rules, or the observer of the study.
    pub name: String,
    /// The hypothesis that does not hold.
    pub hypothesis: String,
}
