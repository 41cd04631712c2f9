//! The table [estimate]: parameters of the plant and coloured noises as its last states, for filters that estimate
//! them.
//!
//! A coloured noise is a parameter of the plant that varies about its value v: in continuous time the state q has
//! `q' = (v - q)/tau + w` with the intensity `2 deviation^2/tau` of w, in discrete time with the period h
//! `q+ = v + exp(-h/tau) (q - v) + w` with the variance `deviation^2 (1 - exp(-2 h/tau))`, which is the same process.
//!
//! Everything else in a study has the sizes of the plant as [plant] has it, and is read so. The plant with more states
//! is made here, and what has an entry for each state gets those of the parameters.

use std::ops::Range;

use luenberger_expression::nearest;
use luenberger_proof::wording::{counted, shortest};
use nalgebra::DMatrix;

use super::other_plant::{remove, set};
use super::plant;
use crate::diagnostic::Diagnostic;
use crate::keys::Range as Domain;
use crate::model::PlantModel;
use crate::reader::tree::{Entry, Node, Value};
use crate::reader::{Reader, check, region};
use crate::signal::Input;
use crate::study::{Estimated, GaussMarkov, Simulation, Truth};

/// The parameters that are estimated, with the coloured noises behind them; none without the table.
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
    if node.get("parameters").is_none() && node.get("noises").is_none() {
        reader.absent(check::head(node), "[estimate] names nothing", "expected `parameters`, `noises`, or both");
        return None;
    }
    let parameters = parameters(node, (own, plant), reader);
    let noises = noises(node, (own, plant), reader);
    let mut all = parameters?;
    all.extend(noises?);
    Some(all)
}

/// Those of the list `parameters`: constants and random walks.
fn parameters(node: &Node, (own, plant): (&Node, &PlantModel), reader: &mut Reader) -> Option<Vec<Estimated>> {
    let Some(list) = node.get("parameters") else {
        return match ["p0", "w", "bounds"].into_iter().find_map(|key| node.entry(key)) {
            None => Some(Vec::new()),
            Some(entry) => {
                let message = format!("`{}` is of `parameters`, of which there are none", entry.key);
                reader.refuse(entry.span.clone(), message, "expected `parameters`; a noise has its own `p0`")
            }
        };
    };
    let list = list.list()?;
    if node.get("p0").is_none() {
        let expected = "expected `p0`, the variances of their first errors";
        reader.absent(check::head(node), "[estimate] has `parameters` and no `p0`", expected);
        return None;
    }
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
            noise: None,
        };
        names.into_iter().enumerate().map(of).collect()
    })
}

/// Those of the table `noises`.
fn noises(node: &Node, (own, plant): (&Node, &PlantModel), reader: &mut Reader) -> Option<Vec<Estimated>> {
    let taken = node.get("parameters").and_then(Node::texts).unwrap_or_default();
    let read = |entry: &Entry| noise(entry, (own, plant), &taken, reader);
    let all: Vec<Option<Estimated>> =
        node.get("noises").map(Node::entries).unwrap_or_default().iter().map(read).collect();
    all.into_iter().collect()
}

fn noise(entry: &Entry, (own, plant): (&Node, &PlantModel), taken: &[&str], reader: &mut Reader) -> Option<Estimated> {
    let name = entry.key.as_str();
    let Some(value) = plant.parameters.get(name).copied() else {
        let message = format!("the noise {name:?} is no parameter of the plant");
        let expected = format!("expected `{name}` in f or h, and parameters = {{ {name} = 0 }} in [plant]");
        let near = nearest(name, plant.parameters.keys().map(String::as_str));
        let mistake = Diagnostic::new(entry.span.clone(), message, expected);
        reader.mistakes.push(match near {
            Some(near) => mistake.help(format!("the nearest parameter is {near:?}")),
            None => mistake,
        });
        return None;
    };
    if taken.contains(&name) {
        let message = format!("`{name}` is named twice, in `parameters` and in `noises`");
        return reader.refuse(entry.span.clone(), message, "expected each parameter once");
    }
    if let Some((message, expected)) = cannot_be_estimated(name, own) {
        return reader.refuse(entry.span.clone(), message, expected);
    }
    let number = |key: &str| entry.node.get(key)?.number();
    let noise = GaussMarkov { tau: number("tau")?, deviation: number("deviation")? };
    if ![noise.tau, noise.deviation].into_iter().all(|x| Domain::Positive.holds(x)) {
        // Said already.
        return None;
    }
    let (w, variance) = (noise.driving(plant.dt), noise.deviation * noise.deviation);
    if !(Domain::Positive.holds(w) && variance > 0.0) {
        let [tau, deviation] = [noise.tau, noise.deviation].map(shortest);
        let message = format!("tau = {tau} and deviation = {deviation} give w the intensity {w}");
        return reader.refuse(entry.node.span.clone(), message, "expected a positive finite intensity");
    }
    let p0 = match entry.node.get("p0") {
        Some(p0) => p0.number()?,
        None => variance,
    };
    let bounds = (f64::NEG_INFINITY, f64::INFINITY);
    Some(Estimated { name: name.to_owned(), value, p0, w, bounds, noise: Some(noise) })
}

impl Estimated {
    /// The right side of its equation.
    fn row(&self, dt: Option<f64>) -> String {
        let Self { name, value, .. } = self;
        match (self.noise, dt) {
            (None, None) => "0".to_owned(),
            (None, Some(_)) => name.clone(),
            (Some(noise), None) if *value == 0.0 => format!("-{name}/{}", noise.tau),
            (Some(noise), None) => format!("({value} - {name})/{}", noise.tau),
            (Some(noise), Some(dt)) if *value == 0.0 => format!("{}*{name}", noise.decay(dt)),
            (Some(noise), Some(dt)) => format!("{value} + {}*({name} - ({value}))", noise.decay(dt)),
        }
    }
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

/// The plant of `tree`, a table [plant], with parameters and noises as its last states: `q' = 0`, or `q+ = q` in
/// discrete time, of a parameter. `base` is the plant of the study without them.
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
    let rows = estimated.iter().map(|one| text(&one.row(base.dt)));
    let f = tree.get("f")?.list()?.iter().cloned().chain(rows).collect();
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
