//! The ranking in words: every number in them is in the table or in `runs.csv`.

use std::fmt::Write;

use luenberger_proof::wording::{capital, counted, significant};

use super::candidate::{Candidate, Score};
use super::ranking::{Criteria, Criterion, Ranked, SMALL, preferred, ratio, tied};
use crate::results::DesignVerdict;
use crate::study::Study;

/// Observers after this rank are in the table only.
const EXPLAINED: usize = 6;

fn short(x: f64) -> String {
    significant(x, 3)
}

/// A ratio: `3.02 times`, `0.98 times`.
fn times(x: f64) -> String {
    if x.is_finite() { format!("{} times", short(x)) } else { "far above".to_owned() }
}

/// The candidates in the order of the ranking, with their scores.
pub(super) struct Ranking<'a> {
    pub(super) study: &'a Study,
    pub(super) criteria: &'a Criteria,
    /// What is given beside the criteria: the error, or on a log the innovations.
    pub(super) accuracy: Criterion,
    pub(super) ordered: Vec<(&'a Candidate, f64)>,
    pub(super) runs: usize,
}

impl Ranking<'_> {
    pub(super) fn sentences(&self) -> Vec<String> {
        let Some((first, _)) = self.ordered.first() else { return Vec::new() };
        if self.ordered.iter().all(|(one, _)| one.finished() == 0) && first.runs.len() == 1 {
            let why = self.ordered.iter().map(|(one, _)| format!("{}{}", one.spec.name, self.ended(one)));
            return std::iter::once("No observer finished its run:".to_owned()).chain(why).collect();
        }
        let mut all = vec![self.winner(first)];
        for (rank, (other, score)) in self.ordered.iter().enumerate().skip(1).take(EXPLAINED - 1) {
            all.push(format!("{}. {}", rank + 1, self.behind(first, other, *score)));
        }
        all.extend(self.tie());
        all.push(self.proof(first));
        all.extend(self.cost(first));
        all
    }

    /// The name of one before it in the ranking that is the same observer.
    fn same(&self, other: &Candidate) -> Option<&str> {
        let before = self.ordered.iter().map(|(one, _)| *one).take_while(|one| one.spec.name != other.spec.name);
        let is_same = |one: &&Candidate| {
            let names = [Some(&one.spec.name), one.same_as.as_ref()];
            other
                .same_as
                .as_ref()
                .map_or_else(|| one.same_as.as_ref() == Some(&other.spec.name), |same| names.contains(&Some(same)))
        };
        before.filter(is_same).map(|one| one.spec.name.as_str()).next()
    }

    fn time(&self, settling: f64) -> String {
        let unit = self.study.plant.time_unit.as_ref().map(|unit| format!(" {unit}")).unwrap_or_default();
        format!("{}{unit}", short(settling))
    }

    fn settles(&self, one: &Candidate) -> String {
        let settling = one.value(Criterion::Settling);
        if settling.is_finite() {
            format!("settles in {}", self.time(settling))
        } else {
            "does not settle in most runs".to_owned()
        }
    }

    /// What is compared: the value of a single criterion, or the score of several.
    fn winner(&self, first: &Candidate) -> String {
        let name = &first.spec.name;
        let what = match &self.criteria.0[..] {
            [(Criterion::Proved, _)] if first.is_proved() => {
                format!("has a proof, and the least {} of those that have one", self.accuracy.quantity())
            }
            [(Criterion::Proved, _)] => format!("has the least {}; none has a proof", self.accuracy.quantity()),
            [(criterion, _)] => {
                let value = first.value(*criterion);
                format!("has the least {}, {}", criterion.quantity(), self.valued(*criterion, value))
            }
            _ => format!("has the least score, {}: {}", short(self.ordered[0].1), self.factors(first)),
        };
        let ended = if first.is_complete() { String::new() } else { format!(" It{}.", self.ended(first)) };
        format!("1. {name} {what}. {}.{ended}", capital(first.character))
    }

    fn valued(&self, criterion: Criterion, value: f64) -> String {
        match criterion {
            Criterion::Settling => self.time(value),
            Criterion::Peak => format!("{} times |e(0)|", short(value)),
            _ => short(value),
        }
    }

    /// The ratios that the score is made of.
    fn factors(&self, one: &Candidate) -> String {
        let total: f64 = self.criteria.0.iter().map(|(_, weight)| weight).sum();
        let factor = |(criterion, weight): &(Criterion, f64)| {
            let best = self.ordered.iter().filter(|other| other.0.is_complete()).map(|other| other.0.value(*criterion));
            let of = ratio(one.value(*criterion), best.fold(f64::INFINITY, f64::min));
            format!("({} {})^{}", criterion.name(), short(of), short(weight / total))
        };
        self.criteria.0.iter().map(factor).collect::<Vec<_>>().join(" x ")
    }

    fn behind(&self, first: &Candidate, other: &Candidate, score: f64) -> String {
        let (name, best) = (&other.spec.name, &first.spec.name);
        if let Some(same) = self.same(other) {
            return format!(
                "{name} is the same observer as {same}, with the same gain to three digits. {}.",
                capital(other.character)
            );
        }
        let mut text = match &self.criteria.0[..] {
            _ if !other.is_complete() => format!("{name}{}.{}", self.ended(other), self.otherwise(first, other)),
            [(Criterion::Proved, _)] if other.is_proved() == first.is_proved() => {
                let of = ratio(other.value(self.accuracy), first.value(self.accuracy));
                format!(
                    "{name} {} {} the {} of {best}.",
                    if other.is_proved() { "has a proof too, and" } else { "has no proof either, and" },
                    times(of),
                    self.accuracy.quantity()
                )
            }
            [(Criterion::Proved, _)] => format!("{name} has no proof."),
            [(criterion, _)] => {
                let (value, least) = (other.value(*criterion), first.value(*criterion));
                if value.is_finite() {
                    format!(
                        "{name}: {} the {} of {best} ({} against {}).",
                        times(ratio(value, least)),
                        criterion.quantity(),
                        self.valued(*criterion, value),
                        self.valued(*criterion, least)
                    )
                } else {
                    let why = other.cost.as_ref().err().map(|why| format!(": {why}")).unwrap_or_default();
                    format!("{name} has no {}{why}.", criterion.quantity())
                }
            }
            _ => format!("{name}: score {}, {}.", short(score), self.factors(other)),
        };
        if other.is_complete() && first.is_complete() && other.on_log().is_none() {
            text += &self.halves(first, other);
        }
        _ = write!(text, " {}.", capital(other.character));
        let left = other.runs.iter().flatten().filter(|run| run.left()).count();
        if let Some(Ok(Score::OnLog(_, rows @ 1..))) = other.runs.first() {
            _ = write!(
                text,
                " It left the region of its design at {}, which its proof does not cover.",
                counted(*rows, "row")
            );
        } else if left > 0 {
            _ = write!(
                text,
                " It left the region of its design in {left} of {}, which its proof does not cover.",
                counted(self.runs, "run")
            );
        }
        text
    }

    /// In how many runs it is worse, and in which half of the run.
    fn halves(&self, first: &Candidate, other: &Candidate) -> String {
        let larger = other.rms().iter().zip(first.rms()).filter(|(other, first)| **other > *first).count();
        let mean = |values: Vec<f64>| values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64;
        // The mean square of a run is the mean of those of its halves.
        let parts = |one: &Candidate| {
            let (all, late) = (mean(one.rms()), mean(one.steady()));
            ((2.0 * all - late).max(0.0).sqrt(), late.sqrt())
        };
        let ((early, late), (least_early, least_late)) = (parts(other), parts(first));
        let mut text = format!(
            " Its error is larger in {larger} of {}: {} that of {} in the first half of the run, {} in the second half, when mostly noise is left.",
            counted(self.runs, "run"),
            times(ratio(early, least_early)),
            first.spec.name,
            times(ratio(late, least_late)),
        );
        if self.criteria.0.iter().all(|(criterion, _)| *criterion != Criterion::Settling) {
            _ = write!(text, " It {}; {} {}.", self.settles(other), first.spec.name, self.settles(first));
        }
        text
    }

    fn ended(&self, one: &Candidate) -> String {
        let failed = self.runs - one.finished();
        let why = one.runs.iter().find_map(|run| run.as_ref().err());
        if let (Some(why), [_]) = (why, &one.runs[..]) {
            return format!(": {why}");
        }
        why.map(|why| format!(" ended early in {failed} of {}, first: {why}", counted(self.runs, "run")))
            .unwrap_or_default()
    }

    /// The error of one that did not finish all its runs, in the median.
    fn otherwise(&self, first: &Candidate, other: &Candidate) -> String {
        let (error, least) = (other.value(self.accuracy), first.value(self.accuracy));
        if !error.is_finite() {
            return String::new();
        }
        format!(
            " Its median {}, these runs counted as the largest, is {} that of {} ({} against {}).",
            self.accuracy.quantity(),
            times(ratio(error, least)),
            first.spec.name,
            short(error),
            short(least)
        )
    }

    /// The first ones are as good, and what decides between them.
    fn tie(&self) -> Option<String> {
        let different: Vec<_> = self.ordered.iter().filter(|(one, _)| self.same(one).is_none()).copied().collect();
        let tied = tied(&different);
        let (last, others) = tied.split_last()?;
        let chosen = preferred(&tied).filter(|_| !others.is_empty())?;
        let alike = |criterion: Criterion| tied.iter().all(|one| one.value(criterion) == chosen.value(criterion));
        let why = match (alike(Criterion::Proved), alike(Criterion::Cost)) {
            (true, true) => "the first of them",
            (true, false) => "which takes the fewest operations per step of them",
            (false, _) if tied.iter().filter(|one| one.is_proved()).count() == 1 => "which has a proof",
            (false, _) => "which takes the fewest operations per step of those with a proof",
        };
        let others: Vec<&str> = others.iter().map(|one| one.spec.name.as_str()).collect();
        Some(format!(
            "{} and {} differ by less than {} %: {} is recommended, {why}.",
            others.join(", "),
            last.spec.name,
            short(100.0 * SMALL),
            chosen.spec.name
        ))
    }

    fn proof(&self, first: &Candidate) -> String {
        let name = &first.spec.name;
        let statement = |one: &Candidate| one.designed.report.statement.trim_end_matches('.').to_owned();
        if first.is_proved() {
            return format!("{name} is proved: {}.", statement(first));
        }
        let has = if first.designed.report.verdict == DesignVerdict::MEASURED {
            "was checked by measurements, without a proof"
        } else {
            "has no stability certificate"
        };
        match self.ordered.iter().enumerate().find(|(_, (one, _))| one.is_proved() && one.is_complete()) {
            Some((rank, (proved, _))) => {
                let price = ratio(proved.value(self.accuracy), first.value(self.accuracy));
                format!(
                    "{name} {has}. The first with a proof is {} (rank {}), with {} the {}: {}.",
                    proved.spec.name,
                    rank + 1,
                    times(price),
                    self.accuracy.quantity(),
                    statement(proved)
                )
            }
            None => format!("{name} {has}, nor has any other that finished its runs a proof."),
        }
    }

    /// What a step of the first one costs, and the cheapest one.
    fn cost(&self, first: &Candidate) -> Option<String> {
        let complete = self.ordered.iter().map(|(one, _)| *one).filter(|one| one.is_complete() && one.cost.is_ok());
        let cheapest =
            complete.min_by(|one, other| one.value(Criterion::Cost).total_cmp(&other.value(Criterion::Cost)))?;
        let least = cheapest.value(Criterion::Cost);
        let rest = if cheapest.spec.name == first.spec.name {
            ", the fewest of all".to_owned()
        } else {
            let price = ratio(cheapest.value(self.accuracy), first.value(self.accuracy));
            let quantity = self.accuracy.quantity();
            format!("; the fewest are {least}, of {}, with {} the {quantity}", cheapest.spec.name, times(price))
        };
        Some(match &first.cost {
            Ok(cost) => {
                let most = if first.spec.kind.has_shorter_steps() { "at most " } else { "" };
                let name = &first.spec.name;
                format!("A step of {name} takes {most}{cost} floating-point operations on the target{rest}.")
            }
            Err(why) => format!(
                "{} has no step on a target: {why}{}.",
                first.spec.name,
                rest.replace(", the fewest of all", "")
            ),
        })
    }
}
