//! An observer of the comparison: its tuning, its design, its runs, and their scores.

use std::sync::atomic::AtomicBool;

use luenberger_clock::Instant;
use luenberger_observers::{DiscreteLinearObserver, LinearObserver};
use luenberger_proof::wording::counted;
use nalgebra::{DMatrix, Dyn};
use serde::Serialize;

use super::block::{Block, study_with};
use super::ranking::{Criterion, Ranked, UNPROVED_FACTOR};
use crate::deployment::{self, ExportOptions};
use crate::design::{Designed, attempt};
use crate::execute::Scored;
use crate::kinds::Rule;
use crate::results::PredictionReport;
use crate::statistics;
use crate::study::{ObserverSpec, Study};
use crate::tuning::{Context, Information, InformationKind};

/// An observer that has a design.
pub(super) struct Candidate {
    pub(super) spec: ObserverSpec,
    pub(super) designed: Designed,
    /// What is written into a study; none for an observer of the study itself.
    pub(super) block: Option<Block>,
    /// The candidate before it that is the same linear observer, with the same gain.
    pub(super) same_as: Option<String>,
    pub(super) rule: &'static str,
    pub(super) source: &'static str,
    pub(super) character: &'static str,
    pub(super) information: Vec<InformationKind>,
    /// Operations of a step of the exported program, or why there is none.
    pub(super) cost: Result<usize, String>,
    /// The runs, in their order, or why they ended early.
    pub(super) runs: Vec<Result<Score, String>>,
}

/// The scores of a run.
pub(super) enum Score {
    Simulated(Scored),
    /// Of a log, with the rows that are outside of the region of the design.
    OnLog(PredictionReport, usize),
}

impl Score {
    /// Whether the run left the region of the design.
    pub(super) fn left(&self) -> bool {
        match self {
            Self::Simulated(scored) => scored.left,
            Self::OnLog(_, outside) => *outside > 0,
        }
    }

    fn simulated(&self) -> Option<&Scored> {
        match self {
            Self::Simulated(scored) => Some(scored),
            Self::OnLog(..) => None,
        }
    }
}

/// What has become of a kind.
pub(super) enum Outcome {
    Designed(Box<Candidate>),
    /// The hypothesis that does not hold.
    Unfit(String),
    /// The time was over.
    Open,
}

/// Designs a kind by its rule: the first of its specifications that has a design.
pub(super) fn by_rule(
    study: &Study,
    information: &Information,
    (kind, rule): (&'static str, &'static Rule),
    (cancel, end): (&AtomicBool, Option<Instant>),
) -> Outcome {
    let keys = match (rule.keys)(&Context { study, information }) {
        Ok(keys) => keys,
        Err(why) => return Outcome::Unfit(why),
    };
    let mut why = None;
    for keys in keys {
        let block = Block {
            name: free_name(study, rule.name),
            kind,
            keys,
            initial: information.initial.clone(),
            comment: format!("luenberger advise: {}.", rule.tuning),
        };
        let with = match study_with(study, std::slice::from_ref(&block)) {
            Ok(with) => with,
            Err(error) => {
                why.get_or_insert(format!("its specification is not accepted: {error}"));
                continue;
            }
        };
        let Some(spec) = with.observer(&block.name).cloned() else { continue };
        match attempt(&with, &spec, cancel, end) {
            Ok(designed) => {
                let cost = cost(&with, &spec, &designed, (information.period, end));
                let (runs, information) = (Vec::new(), rule.information.to_vec());
                let Rule { tuning, source, character, .. } = *rule;
                let found = Candidate {
                    spec,
                    designed,
                    block: Some(block),
                    same_as: None,
                    rule: tuning,
                    source,
                    character,
                    information,
                    cost,
                    runs,
                };
                return Outcome::Designed(Box::new(found));
            }
            Err(none) if none.is_interrupted() => return Outcome::Open,
            Err(none) => {
                why.get_or_insert(none.hypothesis);
            }
        }
    }
    Outcome::Unfit(why.unwrap_or_else(|| "the rule has no specification for it".to_owned()))
}

/// Designs an observer of the study as the study has it.
pub(super) fn of_study(
    study: &Study,
    information: &Information,
    spec: &ObserverSpec,
    (cancel, end): (&AtomicBool, Option<Instant>),
) -> Outcome {
    if let Some((k, _)) = spec.kind.functions() {
        let functions = counted(k.nrows(), "function");
        return Outcome::Unfit(format!(
            "it estimates {functions} of the state, and the others are compared by the state"
        ));
    }
    // All start from one estimate.
    let spec = ObserverSpec { initial: information.initial.clone(), ..spec.clone() };
    match attempt(study, &spec, cancel, end) {
        Ok(designed) => {
            let cost = cost(study, &spec, &designed, (information.period, end));
            Outcome::Designed(Box::new(Candidate {
                spec,
                designed,
                block: None,
                same_as: None,
                rule: "as the study specifies it",
                source: "the study",
                character: "it is tuned in the study, not by a rule",
                information: vec![InformationKind::Study],
                cost,
                runs: Vec::new(),
            }))
        }
        Err(none) if none.is_interrupted() => Outcome::Open,
        Err(none) => Outcome::Unfit(none.hypothesis),
    }
}

/// A name that no observer of the study has.
fn free_name(study: &Study, name: &str) -> String {
    let is_taken = |name: &str| {
        study.observers.iter().any(|observer| crate::read::file_name(&observer.name).eq_ignore_ascii_case(name))
    };
    let mut free = name.to_owned();
    while is_taken(&free) {
        free += "-advised";
    }
    free
}

/// Operations of a step of the exported program; its design begins before the instant `end`, if there is one.
fn cost(
    study: &Study,
    spec: &ObserverSpec,
    designed: &Designed,
    (period, end): (f64, Option<Instant>),
) -> Result<usize, String> {
    const LATE: &str = "the design of its step was not reached within half of the budget";
    let is_over = || end.is_some_and(|end| Instant::now() >= end);
    if is_over() {
        return Err(LATE.to_owned());
    }
    let period = spec.kind.period().is_none().then_some(period);
    let options = ExportOptions { period, designed: Some(designed), ..ExportOptions::default() };
    let prepared = deployment::prepared((study, spec), &options, None, end);
    prepared
        .map(|prepared| prepared.export.operations())
        .map_err(|why| if is_over() { LATE.to_owned() } else { why.reason() })
}

/// The scores of an observer: medians over the runs, in which a run that ended early is infinite.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Medians {
    /// Root mean square of |e|.
    pub rms: Option<f64>,
    /// Its 5th and 95th percentile.
    pub rms_range: [Option<f64>; 2],
    /// Settling time; none if most runs do not settle.
    pub settling: Option<f64>,
    /// The largest |e|, relative to |e(0)|.
    pub peak: Option<f64>,
    /// Root mean square of |e| over the second half of the run.
    pub steady_rms: Option<f64>,
    /// Root mean square of the error of each state.
    pub states: Vec<Option<f64>>,
}

/// The percentile of the scores of runs; infinite without a run.
fn percentile(mut values: Vec<f64>, percent: u8) -> f64 {
    statistics::percentile(&mut values, percent).unwrap_or(f64::INFINITY)
}

/// How near two gains are that count as one, relative: the numbers of rules have four digits.
const SAME: f64 = 1e-3;

/// Says of each candidate whether one before it is the same linear observer.
pub(super) fn find_same(candidates: &mut [Candidate]) {
    for k in 1..candidates.len() {
        let gain = candidates[k].gain();
        let same = candidates[..k].iter().find(|other| {
            other.same_as.is_none()
                && matches!((other.gain(), gain), (Some(x), Some(y)) if x.shape() == y.shape() && near(x, y))
        });
        candidates[k].same_as = same.map(|other| other.spec.name.clone());
    }
}

/// Entry by entry, whatever the units of states and outputs.
fn near(x: &DMatrix<f64>, y: &DMatrix<f64>) -> bool {
    x.iter().zip(y.iter()).all(|(x, y)| (x - y).abs() <= SAME * x.abs().max(y.abs()))
}

impl Candidate {
    /// The gain of a linear observer whose state is the estimate.
    fn gain(&self) -> Option<&DMatrix<f64>> {
        let runs = &self.designed.runnable;
        let continuous = runs.of::<LinearObserver<f64, Dyn, Dyn, Dyn>>().map(LinearObserver::l);
        continuous.or_else(|| runs.of::<DiscreteLinearObserver<f64, Dyn, Dyn, Dyn>>().map(DiscreteLinearObserver::l))
    }

    pub(super) fn finished(&self) -> usize {
        self.runs.iter().filter(|run| run.is_ok()).count()
    }

    /// A score of each run.
    pub(super) fn scores(&self, of: impl Fn(&Scored) -> Option<f64>) -> Vec<f64> {
        let simulated = |run: &Score| run.simulated().and_then(&of);
        let one = |run: &Result<Score, String>| run.as_ref().ok().and_then(simulated).unwrap_or(f64::INFINITY);
        self.runs.iter().map(one).collect()
    }

    /// The scores on the part of a log that is held out.
    pub(super) fn on_log(&self) -> Option<&PredictionReport> {
        self.runs.iter().flatten().find_map(|run| match run {
            Score::OnLog(report, _) => Some(report),
            Score::Simulated(_) => None,
        })
    }

    /// The root mean square of the error of each run.
    pub(super) fn rms(&self) -> Vec<f64> {
        match self.on_log() {
            Some(report) => vec![report.error.unwrap_or(f64::INFINITY)],
            None => self.scores(|run| Some(run.merits.norm.as_ref()?.rms)),
        }
    }

    pub(super) fn settling(&self) -> Vec<f64> {
        self.scores(|run| run.merits.norm.as_ref()?.settling_last)
    }

    pub(super) fn peak(&self) -> Vec<f64> {
        self.scores(|run| {
            run.merits.norm.as_ref().map(|norm| if norm.initial > 0.0 { norm.peak / norm.initial } else { norm.peak })
        })
    }

    pub(super) fn steady(&self) -> Vec<f64> {
        self.scores(|run| Some(run.merits.norm.as_ref()?.steady_rms))
    }

    pub(super) fn is_proved(&self) -> bool {
        self.designed.report.verdict.is_proved()
    }

    pub(super) fn medians(&self) -> Medians {
        let known = |x: f64| x.is_finite().then_some(x);
        let median = |values: Vec<f64>| known(percentile(values, 50));
        let state = |i: usize| median(self.scores(|run| Some(run.merits.states.get(i)?.rmse)));
        let count = if self.on_log().is_some() { 0 } else { self.spec.initial.len() };
        Medians {
            rms: median(self.rms()),
            rms_range: [known(percentile(self.rms(), 5)), known(percentile(self.rms(), 95))],
            settling: median(self.settling()),
            peak: median(self.peak()),
            steady_rms: median(self.steady()),
            states: (0..count).map(state).collect(),
        }
    }
}

impl Ranked for Candidate {
    fn value(&self, criterion: Criterion) -> f64 {
        match criterion {
            Criterion::Innovations => self.on_log().map_or(f64::INFINITY, |report| report.relative),
            Criterion::Likelihood => {
                let mean = self.on_log().and_then(|report| report.log_likelihood);
                mean.map_or(f64::INFINITY, |mean| (-mean).exp())
            }
            Criterion::Error => percentile(self.rms(), 50),
            Criterion::Noise => percentile(self.steady(), 50),
            Criterion::Peak => percentile(self.peak(), 50),
            Criterion::Settling => percentile(self.settling(), 50),
            Criterion::Cost => self.cost.as_ref().map_or(f64::INFINITY, |cost| *cost as f64),
            Criterion::Proved => {
                if self.is_proved() {
                    1.0
                } else {
                    UNPROVED_FACTOR
                }
            }
        }
    }

    fn is_complete(&self) -> bool {
        self.finished() == self.runs.len()
    }
}
