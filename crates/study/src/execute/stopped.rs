//! Why a run ended early, with the names of the study.

use luenberger_observers::transition::MOST_STEPS;
use luenberger_proof::wording::significant;
use luenberger_sim::SimError;

use crate::study::Study;

/// The error as a sentence, in which entries of the state have the names of the states.
pub(super) fn why(study: &Study, error: &SimError) -> String {
    let states = &study.plant.states;
    // After the plant's states come those of observers in continuous time.
    let name = |index: usize| states.get(index).map_or_else(|| "an observer's state".to_owned(), Clone::clone);
    let short = |x: f64| significant(x, 5);
    match error {
        SimError::NotDefined { time, index, value, state } => {
            let at = states.iter().zip(state).map(|(name, x)| format!("{name} = {}", short(*x)));
            let at: Vec<String> = at.take(SHOWN).collect();
            let more = if states.len() > SHOWN { ", .." } else { "" };
            let (t, name) = (short(*time), name(*index));
            format!("stopped at t = {t}: the derivative of {name} is {value}, where {}{more}", at.join(", "))
        }
        SimError::Singular { time, index, value, slope } => format!(
            "stopped at t = {}: the derivative of {name} is unbounded there ({} at {name} = {}), as by a division by zero",
            short(*time),
            short(*slope),
            short(*value),
            name = name(*index)
        ),
        SimError::ObserverNotFinite { observer, time, value, .. } => {
            let kind = study.observer(observer).map(|requested| &requested.kind);
            let why = match kind
                .filter(|kind| kind.updates(None) && study.plant.dt.is_none())
                .and_then(|kind| kind.period())
            {
                Some(_) => format!(
                    ": on the way to the next one f or its Jacobian is not finite, or more than {MOST_STEPS} steps are needed. {REMEDIES}"
                ),
                None => String::new(),
            };
            let t = short(*time);
            format!("stopped at t = {t}: the estimate of {observer:?} becomes {value} with this sample{why}")
        }
        SimError::BlowUp { time, norm } => {
            format!("stopped at t = {}: the solution diverges (norm {})", short(*time), short(*norm))
        }
        SimError::TooManySteps { time, .. } => {
            format!("stopped at t = {}: step limit reached (stiff or diverging)", short(*time))
        }
        SimError::TimeLimit { time } => format!("stopped at t = {}: time limit reached", short(*time)),
        SimError::StepSize { time, step } => {
            let (t, step) = (short(*time), short(*step));
            format!("stopped at t = {t}: step size {step} below its limit (the right-hand side is not smooth there)")
        }
        SimError::OutputNotFinite { observer, time, row, output, value, is_measured } => {
            let row = row.map(|row| format!(" (row {} of the log)", row + 1)).unwrap_or_default();
            let name = study.plant.outputs.get(*output).map_or("an output", String::as_str);
            let t = short(*time);
            let why = if *is_measured {
                "which was measured there"
            } else {
                "which was not measured there, and which it predicts"
            };
            format!("stopped at t = {t}{row}: {name} is {value} at the estimate of {observer:?}, {why}")
        }
        other => other.to_string(),
    }
}

/// What may help a filter whose prediction has no result.
const REMEDIES: &str = "Its steps are as long as their error allows; `substeps` is for targets and changes none of them. What may help: a smaller `p0` or `w`, an `initial` nearer to the state, a shorter `period`, or an f that is defined beyond its region, as by max(x, 0)";

/// Maximal number of states that are quoted.
const SHOWN: usize = 8;
