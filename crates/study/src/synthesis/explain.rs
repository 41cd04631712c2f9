//! Diagnosis of an observer that is not applicable: the violated hypothesis with its numbers, alternatives to be tried,
//! and hints. What one kind alone says of its own errors is in its module.

use luenberger_design::{DesignError, LpvError, Pair, UnseenModes};
use luenberger_expression::Row;
use luenberger_linalg::{LinalgError, Mode, Observability, observability};
use luenberger_proof::wording::{shortest, significant};

use super::Plan;
use super::alternative::{another_gain, other_kinds, slower};
use crate::model::{Model, PlantModel};
use crate::results::eigenvalue;
use crate::results::{Advice, Cause, NoObserver, Proposal};
use crate::structure::Structure;
use crate::study::{ObserverSpec, Study};

pub(crate) fn not_linear(study: &Study, requested: &ObserverSpec) -> NoObserver {
    let parts = study.plant.model.nonlinearities();
    let what = match (&study.plant.model, parts.is_empty()) {
        (Model::Builtin(builtin), _) => format!("`{}` is nonlinear", builtin.name()),
        (_, false) => format!("this one is nonlinear: {}", parts.join(" and ")),
        (_, true) => "this one has a constant term".to_owned(),
    };
    let kind = requested.kind.name();
    NoObserver::new(format!("the kind {kind} needs a linear plant, x' = A x + B u and y = C x + D u, and {what}"))
        .because(Cause::NotLinear)
        .advise(other_kinds(study, requested))
}

/// The error of a design with the names of the study and with what to do instead, which is `own` where the kind has its
/// own advice.
pub(crate) fn explained(plan: &Plan<'_>, none: NoObserver, own: Option<Advice>) -> NoObserver {
    let Plan { study, requested, .. } = *plan;
    let others = || other_kinds(study, requested);
    let advice = match none.cause.as_deref() {
        Some(Cause::Design(DesignError::VaryingOutput { output, state, low, high })) => {
            let hypothesis = format!(
                "the kind {} needs outputs that are linear in the state, and the derivative of {} by {} is between {} and {}",
                requested.kind.name(),
                study.plant.outputs[*output],
                study.plant.states[*state],
                shortest(*low),
                shortest(*high)
            );
            return NoObserver { hypothesis, ..none }.advise(others());
        }
        Some(Cause::Design(error)) if is_of_modes(error) => {
            let (hypothesis, advice) = hidden(study, requested, error, own);
            return NoObserver { hypothesis, ..none }.advise(advice);
        }
        Some(Cause::Enclosure(error)) => {
            let hypothesis = format!("{error}; the derivatives must be bounded over the region");
            let smaller = Advice::hint("a smaller, bounded `region` in which the state is known to stay");
            return NoObserver { hypothesis, ..none }.advise(others().and(smaller));
        }
        Some(cause) => own.unwrap_or_else(|| advice(study, requested, cause)),
        None => return none,
    };
    none.advise(advice)
}

/// What to do where a design of any kind fails.
fn advice(study: &Study, requested: &ObserverSpec, cause: &Cause) -> Advice {
    let others = || other_kinds(study, requested);
    match cause {
        Cause::Design(DesignError::Infeasible { .. }) | Cause::Lpv(LpvError::HiddenMode(_) | LpvError::Conflict(_)) => {
            with_smaller_rate(study, requested)
        }
        Cause::Design(DesignError::Undecided { .. } | DesignError::RefutedAsRounded { .. }) => {
            slower(requested).and(others()).and(Advice::hint("a smaller `decay_rate` or `region`"))
        }
        Cause::Design(
            DesignError::NotHurwitz { .. } | DesignError::NotSchur { .. } | DesignError::StabilityUndecided { .. },
        )
        | Cause::Lpv(LpvError::UnstableVertex { .. }) => match undetectable(&study.plant) {
            Some(modes) => Advice::hint(format!(
                "the plant is not detectable, no observer exists: add an output that depends on its unobservable modes, {}",
                modes.join(", ")
            )),
            None => another_gain(requested),
        },
        Cause::Design(DesignError::NothingReachesTheError) => {
            Advice::of([Proposal::keys([], &["bounds"], "nothing acts that would have to be bounded")])
        }
        Cause::Lpv(LpvError::TooManyVertices { .. }) => {
            others().and(Advice::hint("a smaller `region`, in which fewer entries vary"))
        }
        _ => Advice::default(),
    }
}

/// Whether the error is that no gain moves a mode of a pair.
fn is_of_modes(error: &DesignError) -> bool {
    matches!(
        error,
        DesignError::NotDetectable { .. }
            | DesignError::OfPair { .. }
            | DesignError::Linalg(
                LinalgError::Unobservable { .. }
                    | LinalgError::NotDetectable { .. }
                    | LinalgError::PoleMultiplicity { .. },
            )
    )
}

fn with_smaller_rate(study: &Study, requested: &ObserverSpec) -> Advice {
    let hint = if requested.kind.takes_region() { Advice::hint("a smaller `region`") } else { Advice::default() };
    slower(requested).and(other_kinds(study, requested)).and(hint)
}

/// A plant with an unobservable mode, or a pair made of it: the mode, its direction, and which observers still exist.
fn hidden(study: &Study, requested: &ObserverSpec, error: &DesignError, own: Option<Advice>) -> (String, Advice) {
    let plant =
        study.plant.model.linear().filter(|_| !matches!(error, DesignError::OfPair { pair: Pair::Decoupled, .. }));
    let seen = plant.and_then(|plant| observability(&plant.a, &plant.c).ok().map(|seen| (plant, seen)));
    let Some((plant, seen)) = seen.filter(|(_, seen)| !seen.unobservable.is_empty()) else {
        let advice = own.unwrap_or_else(|| instead_of(study, requested, error));
        return (error.to_string(), advice);
    };
    let unseen = UnseenModes::of(&plant.a, &plant.c, study.plant.time());
    let modes = modes(&study.plant, &seen);
    // Beside the modes that no output sees there may be others that floating point cannot tell from them.
    let are_all = UnseenModes::count(&plant.a, &plant.c) == Some(modes.len());
    let how = match unseen {
        UnseenModes::Decay | UnseenModes::Remain if are_all => ": unobservable modes at",
        UnseenModes::Decay | UnseenModes::Remain => ", and to working precision its unobservable modes are at",
        UnseenModes::None | UnseenModes::Undecided => " to working precision: unobservable modes at",
    };
    let others = || another_gain(requested).and(other_kinds(study, requested));
    let advice = match unseen {
        UnseenModes::Decay if !are_all => others().and(Advice::hint(
            "an observer exists, since the plant as stored is detectable, and its gain is large: other units, or an output that depends more on these directions",
        )),
        UnseenModes::Decay => {
            others().and(Advice::hint("the unobservable modes are stable (the plant is detectable): no gain changes them"))
        }
        UnseenModes::Remain => Advice::hint(
            "the plant is not detectable, no observer exists: add an output that depends on this direction",
        ),
        UnseenModes::None => others().and(Advice::hint(
            "an observer exists, since the plant as stored is observable, and its gain is large: other units, or an output that depends more on this direction",
        )),
        UnseenModes::Undecided => others().and(Advice::hint("an output that depends on this direction")),
    };
    let hypothesis = format!("the plant is not observable{how} {}", modes.join(", "));
    (hypothesis, advice)
}

/// The unobservable modes with their directions.
fn modes(plant: &PlantModel, seen: &Observability) -> Vec<String> {
    let mode = |mode: &Mode| {
        let direction: Vec<f64> = mode.direction.iter().map(|x| x.re).collect();
        format!(
            "{} along {} (margin {})",
            eigenvalue([mode.eigenvalue.re, mode.eigenvalue.im]),
            plant.direction_in_words(&direction),
            significant(mode.margin, 2)
        )
    };
    seen.unobservable.iter().map(mode).collect()
}

/// The unobservable modes of a linear plant for which no observer exists, decided exactly; none for any other.
pub(crate) fn undetectable(plant: &PlantModel) -> Option<Vec<String>> {
    let linear = plant.model.linear()?;
    let seen = observability(&linear.a, &linear.c).ok().filter(|seen| !seen.unobservable.is_empty())?;
    let unseen = UnseenModes::of(&linear.a, &linear.c, plant.time());
    (unseen == UnseenModes::Remain).then(|| modes(plant, &seen))
}

/// What to do about a hidden mode of a pair that is not hidden in the plant.
fn instead_of(study: &Study, requested: &ObserverSpec, error: &DesignError) -> Advice {
    // The other kinds do not estimate a disturbance.
    let others = if requested.kind.unknown_disturbance().is_some() {
        another_gain(requested)
    } else {
        another_gain(requested).and(other_kinds(study, requested))
    };
    let hint = match error {
        DesignError::Linalg(LinalgError::PoleMultiplicity { .. }) => "fewer repeated poles",
        DesignError::OfPair { pair: Pair::Sampled, .. } => "a shorter `period`",
        DesignError::NotDetectable { .. } => "an output that depends on this mode",
        DesignError::OfPair { error, .. } => return instead_of(study, requested, error),
        _ => "other units, or an output that depends more on this mode",
    };
    others.and(Advice::hint(hint))
}

/// Observers whose theory is for outputs without the input.
pub(crate) fn output_of_the_state(study: &Study, requested: &ObserverSpec) -> Result<(), NoObserver> {
    let Some(k) = study.plant.model.structure().feedthrough() else { return Ok(()) };
    let (kind, output) = (requested.kind.name(), &study.plant.outputs[k]);
    let hypothesis =
        format!("the kind {kind} is for outputs of the state alone, y = h(t, x): {output} depends on the input");
    Err(NoObserver::new(hypothesis).because(Cause::Feedthrough { output: k }).advise(other_kinds(study, requested)))
}

/// That a row is not the state that it should be, or is not shown to be it.
pub(crate) fn other_than(study: &Study, structure: &Structure, row: Row, state: usize) -> String {
    let differs = structure.differs(row, state);
    let (name, state) = (study.plant.row(row), &study.plant.states[state]);
    if differs {
        format!("{name} is not {state}")
    } else {
        format!("{name} is not shown to be {state} for all states, inputs and times")
    }
}

/// What output k is, where it should be state i.
pub(crate) fn measured_in_place_of(study: &Study, structure: &Structure, k: usize, i: usize) -> String {
    let (states, output) = (&study.plant.states, &study.plant.outputs[k]);
    match structure.output_state(k) {
        Some(j) => format!("{output} measures {}, not {}; reorder the states", states[j], states[i]),
        None => other_than(study, structure, Row::Output(k), i),
    }
}

/// Why the plant has no chains of these lengths: each begins at its output, and each equation of a chain depends on the
/// next state and on no later one.
pub(crate) fn no_chains(study: &Study, structure: &Structure, kind: &str, lengths: &[usize]) -> Option<String> {
    let states = &study.plant.states;
    let heads = lengths.iter().scan(0, |next, length| Some(std::mem::replace(next, *next + length)));
    for (k, (head, length)) in heads.zip(lengths).enumerate() {
        if structure.output_state(k) != Some(head) {
            let why = measured_in_place_of(study, structure, k, head);
            return Some(format!("the kind {kind} needs chains that begin at the outputs: {why}"));
        }
        for i in head..(head + length).saturating_sub(1) {
            if !structure.depends_on(i, i + 1) {
                return Some(format!(
                    "the kind {kind} needs a chain: {}' does not depend on {}",
                    states[i],
                    states[i + 1]
                ));
            }
            if let Some(j) = (i + 2..head + length).find(|&j| structure.depends_on(i, j)) {
                return Some(format!(
                    "the kind {kind} needs a triangular plant: {}' depends on {}, which is further down its chain than the next state",
                    states[i], states[j]
                ));
            }
        }
    }
    None
}
