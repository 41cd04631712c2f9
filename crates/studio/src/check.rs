//! `check`: what is known of a study before it runs.

use luenberger_study::execute::{about, bytes};
use luenberger_study::read::{Outlined, outline};
use luenberger_study::{Step, Study, estimate_roughly};
use serde_json::{Value, json};

use crate::error::{StudioError, located};
use crate::export::LANGUAGES;
use crate::message::Message;
use crate::study::{Written, truth};

/// Mistakes, outline, observers, plant and estimated cost. Of a study with mistakes the last three are null.
pub(crate) fn check(request: Message) -> Result<Message, StudioError> {
    let (text, is_estimated) = (Written::of(&request)?, truth(&request, "estimate", true)?);
    let outline: Vec<Value> = outline(&text.text, text.format).iter().map(outlined).collect();
    let json = match text.study(request.files) {
        Ok(study) => known(&study, is_estimated, &outline),
        Err(StudioError::Study(error)) => {
            let Some(mistakes) = error.diagnostics() else { return Err(error.into()) };
            json!({
                "diagnostics": located(mistakes),
                "rendered": mistakes.render(false),
                "title": null,
                "outline": outline,
                "observers": null,
                "plant": null,
                "exports": null,
                "warnings": [],
                "estimate": null,
            })
        }
        Err(error) => return Err(error),
    };
    Ok(Message::new(json))
}

fn outlined(key: &Outlined) -> Value {
    json!({
        "path": key.path,
        "from": key.value.start,
        "to": key.value.end,
        "key_from": key.key.as_ref().map(|key| key.start),
        "key_to": key.key.as_ref().map(|key| key.end),
        "kind": key.kind,
    })
}

fn known(study: &Study, is_estimated: bool, outline: &[Value]) -> Value {
    let plant = &study.plant;
    let observers: Vec<Value> =
        study.observers.iter().map(|one| json!({ "name": one.name, "kind": one.kind.name() })).collect();
    let exports: Vec<Value> =
        study.observers.iter().map(|one| json!({ "observer": one.name, "languages": LANGUAGES })).collect();
    let suspicions = study.log.iter().flat_map(|log| &log.suspicions);
    let warnings: Vec<String> = suspicions.map(|one| one.in_words(plant.time_unit.as_deref())).collect();
    let cost = is_estimated.then(|| estimate_roughly(study, Step::Run, 1));
    let cost = cost.map(|cost| {
        let in_words = format!("{}, {} of memory", about(cost.seconds), bytes(cost.memory.bytes));
        json!({
            "seconds": cost.seconds,
            "memory_bytes": cost.memory.bytes,
            "runs": cost.runs,
            "mostly": cost.mostly,
            "in_words": in_words,
        })
    });
    json!({
        "diagnostics": [],
        "rendered": "",
        "title": study.title,
        "outline": outline,
        "observers": observers,
        "plant": {
            "states": plant.states,
            "inputs": plant.inputs,
            "outputs": plant.outputs,
            "units": {
                "states": plant.units_of(&plant.states),
                "inputs": plant.units_of(&plant.inputs),
                "outputs": plant.units_of(&plant.outputs),
                "time": plant.time_unit,
            },
            "dt": plant.dt,
        },
        "has": {
            "simulation": study.simulation.is_some(),
            "log": study.log.is_some(),
            "sweep": study.sweep.is_some(),
            "tune": study.tune.is_some(),
            "advise": study.advise.is_some(),
        },
        "exports": exports,
        "warnings": warnings,
        "estimate": cost,
    })
}
