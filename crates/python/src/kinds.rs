//! The kinds of observers, from their registry.

use luenberger_study::kinds::{Declaration, registry};
use luenberger_study::schema::Key;
use pyo3::prelude::*;
use serde_json::{Value, json};

/// Name, sentence, source, plants and keys of each, as JSON.
#[pyfunction]
pub(crate) fn kinds() -> String {
    let key = |key: &Key| json!({ "name": key.name, "about": key.about, "required": key.required });
    let kind = |kind: &'static Declaration| {
        let keys: Vec<Value> = kind.keys.iter().copied().flatten().map(key).collect();
        json!({
            "name": kind.name, "about": kind.about, "source": kind.source, "plants": kind.plant.to_string(), "keys": keys,
        })
    };
    registry().into_iter().map(kind).collect::<Value>().to_string()
}
