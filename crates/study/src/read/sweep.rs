//! The table [sweep]. A parameter that is a number of the study is varied in the text itself: the study is read anew
//! with each value, so that everything that depends on the number follows.

use std::sync::Arc;

use luenberger_expression::nearest;

use super::advise::MOST_HELD_OUT;
use super::assemble;
use super::simulation_settings::named;
use crate::diagnostic::{Diagnostic, Source};
use crate::reader::tree::{Node, Step, Value};
use crate::reader::{Reader, check};
use crate::schema::{STUDY, SWEPT};
use crate::study::{ObserverSpec, Simulation, Study, Sweep, Swept};

pub(super) fn sweep(
    (root, node): (&Node, &Node),
    observers: Option<&[ObserverSpec]>,
    simulation: Option<&Simulation>,
    source: &Arc<Source>,
    reader: &mut Reader,
) -> Option<Sweep> {
    let at = node.get("parameter")?;
    let parameter = parameter(root, at, reader)?;
    let on_log = match node.get("on").and_then(Node::text) {
        Some(on) => on == "log",
        None => root.get("simulation").is_none() && root.get("log").is_some(),
    };
    let table = if on_log { "log" } else { "simulation" };
    if root.get(table).is_none() {
        let message = format!("[sweep] without a [{table}]");
        return reader.refuse(
            node.span.clone(),
            message,
            format!("expected a [{table}] to vary, or [log] and `on = \"log\"`"),
        );
    }
    if on_log {
        of_log(node, (at, &parameter), reader)?;
    }
    let held_out = node.get("held_out").and_then(Node::number);
    if let (Some(share), Some(entry)) = (held_out.filter(|share| *share > MOST_HELD_OUT), node.get("held_out")) {
        let expected = format!("expected a share up to {MOST_HELD_OUT}");
        return reader.refuse(entry.span.clone(), format!("`held_out` is {share}"), expected);
    }
    let observers_named = named(node, observers, reader).ok()?;
    let chosen = |observer: &&ObserverSpec| observers_named.as_ref().is_none_or(|names| names.contains(&observer.name));
    let swept: Vec<&ObserverSpec> = observers?.iter().filter(chosen).collect();
    if swept.is_empty() {
        reader.absent(check::head(node), "[sweep] without an [[observer]]", "expected at least one observer");
        return None;
    }
    if parameter == Swept::Gamma && swept.iter().all(|observer| observer.kind.with_gamma(1.0).is_none()) {
        let message = "`parameter` is gamma, and none of the observers has one";
        return reader.refuse(at.span.clone(), message, "expected an observer of the kind cubic or sampled-cubic");
    }
    if parameter == Swept::Noise && simulation.is_some_and(|simulation| !simulation.is_noisy()) {
        let message = "`parameter` is noise, and [simulation] has none";
        return reader.refuse(
            at.span.clone(),
            message,
            "expected simulation.noise or a sensor with noise, whose amplitude is multiplied",
        );
    }
    let values = values(node, &parameter, reader)?;
    let variants = match &parameter {
        Swept::Number(path) => variants(root, path, &values, source, (node, reader))?,
        _ => Vec::new(),
    };
    Some(Sweep {
        parameter,
        values,
        variants,
        ensemble: node.get("ensemble").map_or(Some(1), Node::count)?,
        seed: node.get("seed").map_or(Some(0), Node::count)? as u64,
        observers: observers_named,
        on_log,
        held_out,
    })
}

/// What a log can be swept over: what observers are designed by.
fn of_log(node: &Node, (at, parameter): (&Node, &Swept), reader: &mut Reader) -> Option<()> {
    if !parameter.redesigns() {
        let message = format!("`parameter` is {}, which no log depends on", parameter.name());
        let expected =
            "expected gamma, poles, or a number of the plant or of an observer: a log has its noise and its states";
        return reader.refuse(at.span.clone(), message, expected);
    }
    if let Some((ensemble, runs)) =
        node.get("ensemble").and_then(|at| Some((at, at.count()?))).filter(|(_, runs)| *runs > 1)
    {
        let message = format!("`ensemble` is {runs}, and on a log there is one run at each value");
        return reader.refuse(
            ensemble.span.clone(),
            message,
            "expected no ensemble: runs differ by random noise, and a log has none to draw",
        );
    }
    Some(())
}

fn parameter(root: &Node, at: &Node, reader: &mut Reader) -> Option<Swept> {
    let name = at.text()?;
    match name {
        "gamma" => return Some(Swept::Gamma),
        "poles" => return Some(Swept::Poles),
        "noise" => return Some(Swept::Noise),
        "initial" => return Some(Swept::Initial),
        _ => {}
    }
    let numbers = numbers(root);
    if numbers.iter().any(|(path, _)| path == name) {
        return Some(Swept::Number(name.to_owned()));
    }
    let factors = SWEPT.iter().map(|(name, _)| *name);
    let known: Vec<&str> = factors.chain(numbers.iter().map(|(path, _)| path.as_str())).collect();
    let message = format!("`parameter` is {name:?}, which is no number of the study");
    let mut mistake = Diagnostic::new(at.span.clone(), message, format!("expected one of {}", known.join(", ")));
    if let Some(near) = nearest(name, known.iter().copied()) {
        mistake = mistake.help(format!("the nearest is {near:?}"));
    }
    reader.mistakes.push(mistake);
    None
}

/// The numbers that a sweep may vary, by their names, each with its place.
fn numbers(root: &Node) -> Vec<(String, Vec<Step>)> {
    let mut found = Vec::new();
    for table in ["plant", "truth", "simulation"] {
        let Some(node) = root.get(table) else { continue };
        let start = [Step::Key(table.to_owned())];
        // Parameters of a plant need no further name.
        if let Some(parameters) = node.get("parameters") {
            let inner = start.iter().cloned().chain([Step::Key("parameters".to_owned())]).collect();
            collect(parameters, table, inner, &mut found);
        }
        let others = node.entries().iter().filter(|entry| entry.key != "parameters" && entry.key != "samples");
        for entry in others {
            let inner = start.iter().cloned().chain([Step::Key(entry.key.clone())]).collect();
            collect(&entry.node, &format!("{table}.{}", entry.key), inner, &mut found);
        }
    }
    for (k, node) in root.get("observer").and_then(Node::list).unwrap_or(&[]).iter().enumerate() {
        let Some(name) = node.get("name").or(node.get("kind")).and_then(Node::text) else { continue };
        collect(node, &format!("observer.{name}"), vec![Step::Key("observer".to_owned()), Step::Entry(k)], &mut found);
    }
    found
}

fn collect(node: &Node, path: &str, steps: Vec<Step>, found: &mut Vec<(String, Vec<Step>)>) {
    match &node.value {
        Value::Number(..) => found.push((path.to_owned(), steps)),
        Value::Table(entries) => {
            for entry in entries {
                let inner = steps.iter().cloned().chain([Step::Key(entry.key.clone())]).collect();
                collect(&entry.node, &format!("{path}.{}", entry.key), inner, found);
            }
        }
        // The bounds of sampling periods.
        Value::List(bounds) if path.ends_with(".jitter") && bounds.len() == 2 => {
            for (k, (name, bound)) in ["shortest", "longest"].into_iter().zip(bounds).enumerate() {
                let inner = steps.iter().cloned().chain([Step::Entry(k)]).collect();
                collect(bound, &format!("{path}.{name}"), inner, found);
            }
        }
        _ => {}
    }
}

/// The study with each value of the number.
fn variants(
    root: &Node,
    path: &str,
    values: &[f64],
    source: &Arc<Source>,
    (node, reader): (&Node, &mut Reader),
) -> Option<Vec<Study>> {
    let steps = numbers(root).into_iter().find(|(name, _)| name == path)?.1;
    let mut plain = root.clone();
    if let Value::Table(entries) = &mut plain.value {
        entries.retain(|entry| !["sweep", "log", "plot"].contains(&entry.key.as_str()));
    }
    let mut variants = Vec::new();
    for (k, value) in values.iter().enumerate() {
        let mut tree = plain.clone();
        if let Some(place) = tree.at_mut(&steps) {
            place.value = Value::Number(*value, value.fract() == 0.0);
        }
        let mut inner = reader.inner();
        check::table(&tree, &STUDY, &mut inner.mistakes);
        let study = assemble(&tree, source, &mut inner);
        match (study, inner.mistakes.into_iter().chain(inner.absences).next()) {
            (Some(study), None) => variants.push(study),
            (_, mistake) => {
                let list = node.get("values");
                let entry = list.and_then(|list| list.list()?.get(k));
                let at = entry.or(list).or(node.get("from")).unwrap_or(node);
                let why = mistake.map_or_else(|| ("no study".to_owned(), String::new()), |m| (m.message, m.expected));
                return reader.refuse(at.span.clone(), format!("with {path} = {value}: {}", why.0), why.1);
            }
        }
    }
    Some(variants)
}

const FACTOR: &str = "expected a positive finite number";

fn values(node: &Node, parameter: &Swept, reader: &mut Reader) -> Option<Vec<f64>> {
    let factor = !matches!(parameter, Swept::Number(_));
    let log = node.get("spacing").and_then(Node::text) != Some("linear");
    let mut positive = |at: &Node, what: String, expected: &str| {
        let x = at.number()?;
        if x > 0.0 {
            return Some(x);
        }
        reader.refuse(at.span.clone(), format!("{what} is {x}"), expected)
    };
    match (node.entry("values"), node.get("from"), node.get("to")) {
        (Some(values), None, None) => {
            let list = values.node.list()?;
            let entry = |(i, x): (usize, &Node)| {
                if factor { positive(x, format!("entry {} of `values`", i + 1), FACTOR) } else { x.number() }
            };
            list.iter().enumerate().map(entry).collect()
        }
        (Some(values), ..) => {
            reader.refuse(values.span.clone(), "`values` conflicts with `from` and `to`", "expected one of the two")
        }
        (None, Some(from), Some(to)) => {
            let mut end = |at: &Node, key: &str| match (factor, log) {
                (true, _) => positive(at, format!("`{key}`"), FACTOR),
                (false, true) => {
                    positive(at, format!("`{key}`"), "expected a positive number, or spacing = \"linear\"")
                }
                (false, false) => at.number(),
            };
            let (first, last) = (end(from, "from")?, end(to, "to")?);
            if first >= last {
                return reader.refuse(
                    to.span.clone(),
                    format!("the values go from {first} to {last}"),
                    "expected from < to",
                );
            }
            let count = node.get("count").map_or(Some(9), Node::count)?;
            let value = |k: usize| {
                let share = k as f64 / (count - 1) as f64;
                match k {
                    0 => first,
                    k if k + 1 == count => last,
                    _ if log => first * (last / first).powf(share),
                    _ => first + (last - first) * share,
                }
            };
            Some((0..count).map(value).collect())
        }
        (None, ..) => {
            reader.absent(check::head(node), "[sweep] has no values", "expected `values`, or `from` and `to`");
            None
        }
    }
}
