//! The angles of a plant: `angles` in [plant].

use std::collections::BTreeMap;

use crate::model::{Model, full_turn};
use crate::reader::Reader;
use crate::reader::tree::Node;

/// The full turns of the states and outputs that `angles` names, by their units. An output that is one of these states,
/// or the state that one of these outputs is, is an angle too.
pub(super) fn angles(
    node: Option<&Node>,
    (model, states, outputs): (&Model, &[String], &[String]),
    units: &BTreeMap<String, String>,
    reader: &mut Reader,
) -> Option<BTreeMap<String, f64>> {
    let Some(node) = node else { return Some(BTreeMap::new()) };
    let mut turns = BTreeMap::new();
    let mut sound = true;
    for entry in node.list()? {
        let name = entry.text()?;
        if !states.iter().chain(outputs).any(|known| known == name) {
            let known = states.iter().chain(outputs).map(String::as_str).collect::<Vec<_>>().join(", ");
            let message = format!("the plant has no state or output `{name}`");
            reader.wrong(entry.span.clone(), message, format!("expected one of {known}"));
            sound = false;
            continue;
        }
        let unit = units.get(name).map_or("", String::as_str);
        if let Some(turn) = full_turn(unit) {
            turns.insert(name.to_owned(), turn);
        } else {
            let message = format!("`{name}` has the unit {unit}, which is none of an angle");
            reader.wrong(entry.span.clone(), message, "expected the unit rad, mrad, deg, gon or rev, or none");
            sound = false;
        }
    }
    let structure = model.structure();
    for (k, output) in outputs.iter().enumerate() {
        let Some(state) = structure.output_state(k).map(|i| &states[i]) else { continue };
        let (of_output, of_state) = (turns.get(output).copied(), turns.get(state).copied());
        match (of_output, of_state) {
            (Some(turn), None) => _ = turns.insert(state.clone(), turn),
            (None, Some(turn)) => _ = turns.insert(output.clone(), turn),
            (Some(first), Some(second)) if first.to_bits() != second.to_bits() => {
                let message = format!("`{output}` is `{state}`, and their units are those of other angles");
                reader.wrong(node.span.clone(), message, "expected the same unit for both");
                sound = false;
            }
            _ => {}
        }
    }
    sound.then_some(turns)
}
