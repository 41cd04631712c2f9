//! The table [estimate]: parameters of the plant as its last states, for filters that estimate them.
//!
//! Everything else in a study has the sizes of the plant as [plant] has it, and is read so. The plant with more states
//! is made here, and what has an entry for each state gets those of the parameters.

use std::ops::Range;

use luenberger_proof::wording::counted;
use nalgebra::DMatrix;

use super::other_plant::{remove, set};
use super::plant;
use crate::diagnostic::Diagnostic;
use crate::model::PlantModel;
use crate::reader::tree::{Entry, Node, Value};
use crate::reader::{Reader, check, region};
use crate::signal::Input;
use crate::study::{Estimated, Simulation, Truth};

/// The parameters that are estimated; none without the table.
pub(super) fn estimated(root: &Node, plant: &PlantModel, reader: &mut Reader) -> Option<Vec<Estimated>> {
    let Some(node) = root.get("estimate") else { return Some(Vec::new()) };
    for (key, why) in [
        ("operating_point", "with a parameter as a state the plant rests at more than one point"),
        ("advise", "the observers that it compares are of the plant without more states"),
    ] {
        if let Some(entry) = root.entry(key) {
            let message = format!("[{key}] conflicts with [estimate]: {why}");
            return reader.refuse(entry.span.clone(), message, format!("expected no [{key}], or no [estimate]"));
        }
    }
    let own = root.get("plant")?;
    if own.get("f").is_none() {
        let message = "[estimate] is for plants of expressions, whose parameters have names";
        return reader.refuse(check::head(node), message, "expected `f`, `h` and `parameters` in [plant]");
    }
    let list = node.get("parameters")?.list()?;
    let known: Vec<String> = plant.parameters.keys().cloned().collect();
    let mut names: Vec<&str> = Vec::new();
    let mut sound = true;
    for entry in list {
        let name = entry.text()?;
        if reader.position(entry, "parameter", &known).is_none() {
            sound = false;
        } else if names.contains(&name) {
            reader.wrong(entry.span.clone(), format!("`{name}` is named twice"), "expected each parameter once");
            sound = false;
        } else if let Some((message, expected)) = cannot_be_estimated(name, own) {
            reader.wrong(entry.span.clone(), message, expected);
            sound = false;
        }
        names.push(name);
    }
    let mut variances = |key: &str| {
        let Some(entry) = node.get(key) else { return Some(vec![0.0; list.len()]) };
        let numbers = entry.numbers()?;
        if numbers.len() == list.len() {
            return Some(numbers);
        }
        let message = format!("`{key}` has length {}, and {} named", numbers.len(), of_parameters(list.len()));
        reader.refuse(entry.span.clone(), message, format!("expected length {}", list.len()))
    };
    let (p0, w) = (variances("p0"), variances("w"));
    let (p0, w) = (p0?, w?);
    let bounds = match node.get("bounds") {
        None => vec![(f64::NEG_INFINITY, f64::INFINITY); list.len()],
        Some(entry) => {
            let bounds = region::pairs(entry, "bounds", (list.len(), "name", "`parameters`"), reader)?;
            let values = names.iter().map(|name| plant.parameters.get(*name).copied().unwrap_or_default());
            let outside = bounds.iter().zip(values).position(|((low, high), x)| low >= high || x < *low || x > *high);
            if let Some(k) = outside {
                let message = format!("the bounds of {} do not enclose its value", names[k]);
                let expected = format!("expected lower < upper, and {} between them", plant.parameters.get(names[k])?);
                return reader.refuse(entry.span.clone(), message, expected);
            }
            bounds
        }
    };
    sound.then(|| {
        let of = |(k, name): (usize, &str)| Estimated {
            name: name.to_owned(),
            value: plant.parameters[name],
            p0: p0[k],
            w: w[k],
            bounds: bounds[k],
        };
        names.into_iter().enumerate().map(of).collect()
    })
}

fn of_parameters(count: usize) -> String {
    format!("{} {}", counted(count, "parameter"), if count == 1 { "is" } else { "are" })
}

/// Why a parameter of the plant cannot be a state of it, and what is expected.
fn cannot_be_estimated(name: &str, plant: &Node) -> Option<(String, &'static str)> {
    let rows = ["f", "h"].into_iter().filter_map(|key| plant.get(key)).flat_map(|list| list.list().unwrap_or(&[]));
    if !rows.filter_map(Node::text).any(|text| uses(text, name)) {
        let message = format!("no row of f or h has the parameter `{name}`");
        return Some((message, "expected a parameter on which the plant depends"));
    }
    let parameters = plant.get("parameters").map(Node::entries).unwrap_or_default();
    let other = parameters.iter().find(|entry| entry.node.text().is_some_and(|text| uses(text, name)))?;
    let message = format!("the parameter `{}` is an expression of `{name}`, which would be a state", other.key);
    Some((message, "expected that expression in f and h in the place of the parameter"))
}

/// Whether an expression has this name.
fn uses(text: &str, name: &str) -> bool {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_')).any(|word| word == name)
}

/// The plant of `tree`, a table [plant], with parameters as its last states: `q' = 0`, or `q+ = q` in discrete time.
/// `base` is the plant of the study without them.
pub(super) fn with_states(
    tree: &Node,
    base: &PlantModel,
    estimated: &[Estimated],
    reader: &mut Reader,
) -> Option<PlantModel> {
    let mut tree = tree.clone();
    let span = tree.get("f")?.span.clone();
    let text = |text: &str| Node { span: span.clone(), value: Value::Text(text.to_owned()) };
    let names = || estimated.iter().map(|one| one.name.as_str());
    let rests = names().map(|name| text(if base.dt.is_some() { name } else { "0" }));
    let f = tree.get("f")?.list()?.iter().cloned().chain(rests).collect();
    let states = base.states.iter().map(String::as_str).chain(names()).map(text).collect();
    let entries = tree.get("parameters").map(Node::entries).unwrap_or_default();
    let parameters = entries.iter().filter(|entry| !names().any(|name| name == entry.key)).cloned().collect();
    // Units and angles are those that the plant has already.
    remove(&mut tree, &["units", "angles"]);
    for (key, value) in
        [("f", Value::List(f)), ("states", Value::List(states)), ("parameters", Value::Table(parameters))]
    {
        set(&mut tree, entry(key, span.clone(), value));
    }
    let mut inner = reader.inner();
    let read = plant::plant(&tree, &mut inner);
    // The plant without more states has no mistakes.
    let mistake = inner.mistakes.into_iter().chain(inner.absences).next();
    if let (None, Some(Diagnostic { message, expected, .. })) = (&read, mistake) {
        reader.wrong(span, format!("with the parameters of [estimate] as states: {message}"), expected);
    }
    let (units, turns) = (base.units.clone(), base.turns.clone());
    Some(PlantModel { units, turns, ..read? })
}

fn entry(key: &str, span: Range<usize>, value: Value) -> Entry {
    Entry { key: key.to_owned(), span: span.clone(), node: Node { span, value } }
}

/// The simulation with the true values of the parameters in the first state, and in the norms with their first
/// standard deviations as scales.
pub(super) fn simulated(simulation: &mut Simulation, truth: Option<&Truth>, estimated: &[Estimated]) {
    let other = truth.and_then(|truth| truth.plant.as_ref());
    let values = estimated.iter().enumerate().map(|(k, one)| other.map_or(one.value, |other| other.estimated[k]));
    simulation.x0.extend(values);
    if let Some(scale) = &mut simulation.scale {
        scale.extend(estimated.iter().map(|one| if one.p0 > 0.0 { one.p0.sqrt() } else { 1.0 }));
    }
}

/// The truth whose events change the parameters as they change states.
pub(super) fn in_truth(truth: &mut Truth, n: usize, estimated: &[Estimated]) {
    if estimated.is_empty() {
        return;
    }
    let mut values: Vec<f64> = match &truth.plant {
        Some(other) => other.estimated.clone(),
        None => estimated.iter().map(|one| one.value).collect(),
    };
    for event in &mut truth.events {
        let after = event.plant.as_ref().map_or_else(|| values.clone(), |other| other.estimated.clone());
        let jumps = after.iter().zip(&values).map(|(after, before)| after - before);
        event.jump.resize(n, 0.0);
        event.jump.extend(jumps);
        values = after;
    }
}

/// The input, of a feedback that does not use the parameters.
pub(super) fn fed_back(input: Input, estimated: &[Estimated]) -> Input {
    match input {
        Input::Feedback { observer, gain, reference } => {
            let (m, n) = gain.shape();
            let gain = DMatrix::from_fn(m, n + estimated.len(), |i, j| if j < n { gain[(i, j)] } else { 0.0 });
            Input::Feedback { observer, gain, reference }
        }
        other => other,
    }
}
