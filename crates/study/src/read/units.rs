//! The units of a plant: `units` in [plant].

use std::collections::BTreeMap;

use luenberger_expression::{Parameters, nearest};
use luenberger_proof::wording::counted;

use crate::diagnostic::Diagnostic;
use crate::reader::Reader;
use crate::reader::tree::Node;

/// The units by names. A name is that of a state, an input, an output or a parameter; in the form of a list the units
/// are those of the states.
pub(super) fn units(
    node: Option<&Node>,
    columns: [&Vec<String>; 3],
    parameters: &Parameters,
    reader: &mut Reader,
) -> Option<BTreeMap<String, String>> {
    let Some(node) = node else { return Some(BTreeMap::new()) };
    let [states, ..] = columns;
    if let Some(list) = node.texts() {
        if list.len() != states.len() {
            let message =
                format!("`units` has length {}, and the plant has {}", list.len(), counted(states.len(), "state"));
            return reader.refuse(node.span.clone(), message, format!("expected length {}", states.len()));
        }
        return Some(states.iter().cloned().zip(list.into_iter().map(str::to_owned)).collect());
    }
    let known: Vec<&str> = columns.into_iter().flatten().chain(parameters.keys()).map(String::as_str).collect();
    let mut units = BTreeMap::new();
    let mut sound = true;
    for entry in node.entries() {
        let name = entry.key.as_str();
        if known.contains(&name) {
            units.insert(name.to_owned(), entry.node.text()?.to_owned());
            continue;
        }
        let message = format!("the plant has no state, input, output or parameter `{name}`");
        let mistake = Diagnostic::new(entry.span.clone(), message, format!("expected one of {}", known.join(", ")));
        let help = match (name, nearest(name, known.iter().copied())) {
            ("t" | "time", _) => Some("`time_unit` in [plant] is the unit of the time".to_owned()),
            (_, Some(near)) => Some(format!("the nearest is `{near}`")),
            _ => None,
        };
        reader.mistakes.push(match help {
            Some(help) => mistake.help(help),
            None => mistake,
        });
        sound = false;
    }
    sound.then_some(units)
}
