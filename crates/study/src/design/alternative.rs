//! The alternatives of a refusal that have a design, on this plant.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use luenberger_clock::Instant;
use luenberger_design::{OperatingPoint, operating_point};
use nalgebra::DVector;

use super::attempt;
use crate::read::varied;
use crate::results::{Alternative, NoObserver, Proposal};
use crate::study::{ObserverSpec, Study};
use crate::synthesis::alternative::list;

/// A matrix inequality is tried for at most so many states.
const MOST_STATES: usize = 20;

/// An operating point that the study could name, and its keys: near 0, or near the start of the simulation.
fn a_point(study: &Study) -> Option<(OperatingPoint, String)> {
    let size = study.plant.model.size();
    let zero = vec![0.0; size.states];
    let starts = [Some(&zero), study.simulation.as_ref().map(|simulation| &simulation.x0)];
    let input = DVector::zeros(size.inputs);
    starts.into_iter().flatten().find_map(|x| {
        let point = operating_point(&study.plant.model, &DVector::from_column_slice(x), &input).ok()?;
        let u = if input.is_empty() { String::new() } else { format!(", u = {}", list(input.iter().copied())) };
        Some((point, format!("[operating_point] with x = {}{u}", list(x.iter().copied()))))
    })
}

/// Whether they are one observer: the kinds luenberger and kalman are, with the same gain.
fn is_same(known: &ObserverSpec, other: &ObserverSpec) -> bool {
    let kinds = match (known.kind.whole_gain(), other.kind.whole_gain()) {
        (Some(known), Some(other)) => known == other,
        _ => known.kind == other.kind,
    };
    kinds && (&known.limits, &known.bounds) == (&other.limits, &other.bounds)
}

/// The observer, and how its keys are printed.
fn read(proposal: &Proposal, study: &Study, requested: &ObserverSpec) -> Option<(ObserverSpec, String)> {
    let (spec, replaced) = varied(study, requested, &proposal.keys.join("\n"), proposal.instead)?;
    let (keys, replaced) = (proposal.keys.join(", "), replaced.join(", "));
    let words = match (keys.is_empty(), replaced.is_empty()) {
        (true, true) => String::new(),
        (true, false) => format!("without {replaced}"),
        (false, true) => keys,
        (false, false) => format!("{keys} in place of {replaced}"),
    };
    Some((spec, words))
}

/// The refusal with those of its proposals that have a design within so many seconds, those of all together.
pub(super) fn tried(
    study: &Study,
    requested: &ObserverSpec,
    mut refusal: NoObserver,
    (cancel, end): (&AtomicBool, Option<Instant>),
    seconds: f64,
) -> NoObserver {
    let deadline = Duration::try_from_secs_f64(seconds).ok().and_then(|time| Instant::now().checked_add(time));
    let end = end.into_iter().chain(deadline).min();
    let (mut designed, mut left): (Vec<ObserverSpec>, _) = (vec![requested.clone()], Vec::new());
    let mut reasons = Vec::new();
    for proposal in std::mem::take(&mut refusal.proposals) {
        // One alternative for each reason: the first of several rates.
        if reasons.contains(&proposal.why) {
            continue;
        }
        let Some((spec, mut words)) = read(&proposal, study, requested) else { continue };
        let at_point;
        let mut within = study;
        if proposal.at_point {
            let Some((point, place)) = a_point(study) else { continue };
            words = if words.is_empty() { place } else { format!("{words} and {place}") };
            at_point = Study { operating_point: Some(point), ..study.clone() };
            within = &at_point;
        } else if designed.iter().any(|known| is_same(known, &spec)) {
            continue;
        }
        let is_large = spec.kind.poses_inequality() && study.plant.states.len() > MOST_STATES;
        if is_large || end.is_some_and(|end| Instant::now() >= end) || cancel.load(Ordering::Relaxed) {
            left.push(words);
            continue;
        }
        match attempt(within, &spec, cancel, end) {
            Ok(found) if found.report.facts.iter().all(|fact| fact.verdict.is_proved()) => {
                refusal.alternatives.push(Alternative::designed(format!("{words}: {}", proposal.why)));
                reasons.push(proposal.why);
                if !proposal.at_point {
                    designed.push(spec);
                }
            }
            Err(none) if none.is_interrupted() => left.push(words),
            Ok(_) | Err(_) => refusal.hints.extend(proposal.otherwise.map(str::to_owned)),
        }
    }
    if !left.is_empty() {
        refusal.hints.push(format!("not tried, since the design takes long: {}", left.join("; ")));
    }
    refusal
}
