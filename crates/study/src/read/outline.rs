//! The keys of a study with their places in the text, for editors that change values where they stand.

use std::ops::Range;

use serde::Serialize;

use super::{json, toml};
use crate::reader::tree::{Node, Value};
use crate::study::Format;

/// A key of a text, or a table in a list, with the place of its value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outlined {
    /// The keys, and places in lists, that lead to it.
    pub path: Vec<OutlineStep>,
    /// The bytes of the value; of a table its header or its body, as the parser gives it.
    pub value: Range<usize>,
    /// The bytes of the key; none of a table in a list.
    pub key: Option<Range<usize>>,
    /// `string`, `number`, `bool`, `array`, `table`, or `other` for a type that studies do not use.
    pub kind: &'static str,
}

/// A step of a path.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum OutlineStep {
    /// A key of a table.
    Key(String),
    /// A place in a list, from 0.
    Entry(usize),
}

/// The keys of a text and the tables in its lists, in the order of the text. Of a text with syntax errors it has those
/// that could be read.
///
/// ```
/// use luenberger_study::read::outline;
/// use luenberger_study::Format;
/// let text = "[[observer]]\nkind = \"kalman\"\n";
/// let kind = outline(text, Format::Toml).pop().ok_or("a key")?;
/// assert_eq!((&text[kind.value], kind.kind, kind.path.len()), ("\"kalman\"", "string", 3));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn outline(text: &str, format: Format) -> Vec<Outlined> {
    let (root, _) = match format {
        Format::Toml => toml::tree(text),
        Format::Json => json::tree(text),
    };
    let mut found = Vec::new();
    add(&root, &[], &mut found);
    found
}

fn add(node: &Node, path: &[OutlineStep], found: &mut Vec<Outlined>) {
    let mut one = |step: OutlineStep, node: &Node, key: Option<Range<usize>>| {
        let path = [path, &[step]].concat();
        found.push(Outlined { path: path.clone(), value: node.span.clone(), key, kind: kind(node) });
        add(node, &path, found);
    };
    match &node.value {
        Value::Table(entries) => {
            for entry in entries {
                one(OutlineStep::Key(entry.key.clone()), &entry.node, Some(entry.span.clone()));
            }
        }
        Value::List(list) => {
            for (number, node) in list.iter().enumerate().filter(|(_, node)| matches!(node.value, Value::Table(_))) {
                one(OutlineStep::Entry(number), node, None);
            }
        }
        _ => {}
    }
}

fn kind(node: &Node) -> &'static str {
    match node.value {
        Value::Text(_) => "string",
        Value::Number(..) => "number",
        Value::Truth(_) => "bool",
        Value::List(_) => "array",
        Value::Table(_) => "table",
        Value::Other(_) => "other",
    }
}
