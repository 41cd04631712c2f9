//! An observer of a study under other keys.

use super::{json, observer, plant, toml};
use crate::reader::tree::{Node, Value};
use crate::reader::{Reader, check};
use crate::schema::OBSERVER;
use crate::study::{Format, ObserverSpec, Study};

/// The observer `requested` with `keys`, lines of TOML, in place of those of its own that are in `instead`, and which
/// of them it has; with `None` in place of all.
///
/// None if the keys do not make an observer, and if some are to be kept and the text of the study does not have them.
pub(crate) fn varied(
    study: &Study,
    requested: &ObserverSpec,
    keys: &str,
    instead: Option<&[&str]>,
) -> Option<(ObserverSpec, Vec<String>)> {
    let text = study.source.text();
    let (root, _) = match study.format {
        Format::Toml => toml::tree(text),
        Format::Json => json::tree(text),
    };
    let (new, mistakes) = toml::tree(keys);
    if !mistakes.is_empty() {
        return None;
    }
    let read = |node: &Node| {
        let mut mistakes = Vec::new();
        check::table(node, &OBSERVER, &mut mistakes);
        let mut reader = Reader { dt: study.plant.dt, ..Reader::new(&study.data) };
        // What the text has is of the plant without the parameters that are estimated.
        let start = &requested.initial[..study.order()];
        let base = match study.estimated.as_slice() {
            [] => None,
            _ => Some(plant::plant(root.get("plant")?, &mut reader)?),
        };
        let plant = (base.as_ref().unwrap_or(&study.plant), study.estimated.as_slice());
        let found = observer::observer(node, plant, start, (&root, &study.source), &mut reader)?;
        let is_sound = mistakes.is_empty() && reader.mistakes.is_empty() && reader.absences.is_empty();
        is_sound.then_some(found)
    };
    let mut entries = new.entries().to_vec();
    let mut replaced = Vec::new();
    if let Some(instead) = instead {
        let named = |node: &&Node| {
            node.get("name").or_else(|| node.get("kind")).and_then(Node::text) == Some(requested.name.as_str())
        };
        let own = root.get("observer")?.list()?.iter().find(named)?;
        // A study that was changed since it was read has another observer of that name.
        let as_read = read(own)?;
        if (&as_read.kind, &as_read.limits, &as_read.bounds) != (&requested.kind, &requested.limits, &requested.bounds)
        {
            return None;
        }
        for entry in own.entries() {
            if instead.contains(&entry.key.as_str()) {
                replaced.push(entry.key.clone());
            } else if new.get(&entry.key).is_none() {
                entries.push(entry.clone());
            }
        }
    }
    let found = read(&Node { span: 0..0, value: Value::Table(entries) })?;
    let (name, initial, place) = (requested.name.clone(), requested.initial.clone(), requested.place);
    Some((ObserverSpec { name, initial, place, ..found }, replaced))
}
