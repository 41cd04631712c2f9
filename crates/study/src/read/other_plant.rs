//! The plant with other parameters, matrices or equations, as [truth] and its events have it.

use luenberger_plants::Dimensions;
use luenberger_proof::wording::counted;

use super::{Reported, estimate, plant};
use crate::model::PlantModel;
use crate::reader::Reader;
use crate::reader::tree::{Entry, Node, Value};
use crate::study::{Estimated, OtherPlant};

/// The keys of a plant of matrices.
const MATRICES: [&str; 4] = ["a", "b", "c", "d"];

/// The keys of a plant of expressions.
const EQUATIONS: [&str; 2] = ["f", "h"];

/// Whose plant it is, in messages.
#[derive(Debug, Clone, Copy)]
pub(super) enum Whose {
    /// The simulated one.
    Truth,
    /// A model of an observer.
    Model,
}

/// The plant of `tree`, the table [plant] or what an earlier change has made of it, with what `change` says of it; none
/// if it says nothing.
pub(super) fn changed(
    tree: &mut Node,
    change: &Node,
    (known, estimated): (&PlantModel, &[Estimated]),
    whose: Whose,
    reader: &mut Reader,
) -> Result<Option<OtherPlant>, Reported> {
    let said = |keys: &[&str]| keys.iter().copied().find_map(|key| change.entry(key));
    let (matrix, equation) = (said(&MATRICES), said(&EQUATIONS));
    let Some(first) = matrix.or(equation).or(change.entry("parameters")) else { return Ok(None) };
    let is = |keys: &[&str]| keys.iter().any(|key| tree.get(key).is_some());
    let (of_matrices, of_equations) = (is(&["a"]), is(&EQUATIONS));
    if let (Some(matrix), false) = (matrix, of_matrices) {
        let message = format!("`{}` is a matrix, and the plant has no matrices", matrix.key);
        let expected = if of_equations { "expected `parameters`, `f` or `h`" } else { "expected `f` and `h`" };
        return refuse(reader, matrix, message, expected);
    }
    if let (Some(matrix), Some(equation)) = (matrix, equation) {
        let message = format!("`{}` conflicts with `{}`", equation.key, matrix.key);
        return refuse(reader, equation, message, "expected matrices, or `f` and `h`");
    }
    if let (Some(equation), false) = (equation, of_equations)
        && let Some(missing) = EQUATIONS.into_iter().find(|key| change.get(key).is_none())
    {
        let message = format!("`{}` without `{missing}`, which the plant does not have as expressions", equation.key);
        return refuse(reader, equation, message, "expected both `f` and `h`");
    }
    if let Some(entry) = change.entry("parameters") {
        parameters(tree, entry, equation.is_some(), reader)?;
    }
    if matrix.is_some() || equation.is_some() {
        let keys: &[&str] = if matrix.is_some() { &MATRICES } else { &EQUATIONS };
        for entry in keys.iter().filter_map(|key| change.entry(key)) {
            set(tree, entry.clone());
        }
    }
    if let Some(equation) = equation {
        remove(tree, &["a", "b", "c", "d", "builtin"]);
        // The same states, inputs and outputs, whatever the expressions use of them.
        let span = &equation.span;
        for (key, names) in [("states", &known.states), ("inputs", &known.inputs), ("outputs", &known.outputs)] {
            let name = |name: &String| Node { span: span.clone(), value: Value::Text(name.clone()) };
            let list = Node { span: span.clone(), value: Value::List(names.iter().map(name).collect()) };
            set(tree, Entry { key: key.to_owned(), span: span.clone(), node: list });
        }
        for (key, count, what) in [("f", known.states.len(), "state"), ("h", known.outputs.len(), "output")] {
            let length = change.get(key).and_then(Node::list).map(<[Node]>::len);
            if let (Some(entry), Some(length)) = (change.entry(key), length.filter(|length| *length != count)) {
                let message = format!("`{key}` has length {length}");
                return refuse(reader, entry, message, &format!("expected one expression for each {what}, {count}"));
            }
        }
    }
    let mut inner = reader.inner();
    let read = plant::plant(tree, &mut inner);
    let size = known.model.size();
    match read {
        Some(other) if other.model.size() == size => {
            let values = estimated.iter().map(|one| other.parameters.get(&one.name).copied().unwrap_or(one.value));
            let values = values.collect();
            let other =
                if estimated.is_empty() { Some(other) } else { estimate::with_states(tree, known, estimated, reader) };
            let PlantModel { model, parameters, .. } = other.ok_or(Reported)?;
            Ok(Some(OtherPlant { model, parameters, estimated: values }))
        }
        Some(other) => {
            let of = |size: Dimensions| {
                let (n, m) = (counted(size.states, "state"), counted(size.inputs, "input"));
                format!("{n}, {m} and {}", counted(size.outputs, "output"))
            };
            let message = format!("the plant has {} with `{}`", of(other.model.size()), first.key);
            refuse(reader, first, message, &format!("expected {}", of(size)))
        }
        None => {
            let why = inner.mistakes.into_iter().chain(inner.absences).next();
            let (message, expected) = why.map_or_else(Default::default, |mistake| (mistake.message, mistake.expected));
            let whose = match whose {
                Whose::Truth => "the simulated plant",
                Whose::Model => "a model",
            };
            refuse(reader, first, format!("with `{}` of {whose}: {message}", first.key), &expected)
        }
    }
}

fn refuse<T>(reader: &mut Reader, entry: &Entry, message: String, expected: &str) -> Result<T, Reported> {
    reader.wrong(entry.node.span.clone(), message, expected);
    Err(Reported)
}

/// The tree with other values of parameters, and if `anew` with parameters that the plant does not have.
fn parameters(tree: &mut Node, entry: &Entry, anew: bool, reader: &mut Reader) -> Result<(), Reported> {
    let known: Vec<String> = match tree.get("parameters") {
        Some(node) => node.entries().iter().map(|entry| entry.key.clone()).collect(),
        None => Vec::new(),
    };
    let mut sound = true;
    for given in entry.node.entries().iter().filter(|given| !anew && !known.contains(&given.key)) {
        let expected = match (known.is_empty(), tree.get("a").is_some(), tree.get("builtin").is_some()) {
            (false, ..) => format!("expected one of {}", known.join(", ")),
            (_, true, _) => {
                "a plant of matrices has no parameters: expected another `a`, `b`, `c` or `d`, or `f` and `h`"
                    .to_owned()
            }
            (.., true) => {
                "a plant of the library has fixed constants: expected other equations, `f` and `h`".to_owned()
            }
            _ => "expected a [plant] of expressions with `parameters`, or other equations `f` and `h`".to_owned(),
        };
        reader.wrong(given.span.clone(), format!("the plant has no parameter `{}`", given.key), expected);
        sound = false;
    }
    if !sound {
        return Err(Reported);
    }
    let mut all = tree.get("parameters").map(|node| node.entries().to_vec()).unwrap_or_default();
    for given in entry.node.entries() {
        match all.iter_mut().find(|one| one.key == given.key) {
            Some(one) => one.node = given.node.clone(),
            None => all.push(given.clone()),
        }
    }
    set(tree, Entry { node: Node { span: entry.node.span.clone(), value: Value::Table(all) }, ..entry.clone() });
    Ok(())
}

/// The table with this entry, in place of one with the same key.
pub(super) fn set(table: &mut Node, entry: Entry) {
    let Value::Table(entries) = &mut table.value else { return };
    match entries.iter_mut().find(|other| other.key == entry.key) {
        Some(other) => other.node = entry.node,
        None => entries.push(entry),
    }
}

/// The table without these keys.
pub(super) fn remove(table: &mut Node, keys: &[&str]) {
    if let Value::Table(entries) = &mut table.value {
        entries.retain(|entry| !keys.contains(&entry.key.as_str()));
    }
}
