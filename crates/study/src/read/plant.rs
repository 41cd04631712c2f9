//! The table [plant].

use std::collections::BTreeMap;
use std::ops::Range;

use luenberger_expression::{
    Definition, DerivedError, Expression, ExpressionPlant, Extrapolation, Family, Interpolation, LookupTable,
    ParameterError, Parameters, Scope, Surface, Table, TableError, Tables, derived,
};
use luenberger_plants::{Dimensions, StateSpace};
use luenberger_proof::wording::counted;
use nalgebra::DMatrix;

use super::{angles, delays, units};
use crate::model::{Builtin, Model, PlantModel};
use crate::reader::tree::{Node, Value};
use crate::reader::{Reader, check, expression, rows_of, within};

/// The keys of each form of a plant.
const WAYS: [(&str, &[&str]); 3] = [
    ("matrices", &["a", "b", "c", "d"]),
    ("expressions", &["f", "h", "parameters", "tables"]),
    ("builtin", &["builtin"]),
];

pub(super) fn plant(node: &Node, reader: &mut Reader) -> Option<PlantModel> {
    let entries = node.entries();
    let way_of = |key: &str| WAYS.iter().position(|(_, keys)| keys.contains(&key));
    let Some((first, way)) = entries.iter().find_map(|entry| Some((entry, way_of(&entry.key)?))) else {
        let message = "[plant] does not define a plant";
        let expected = "expected matrices `a`, `c` (and `b`), expressions `f` and `h`, or `builtin`";
        reader.absent(check::head(node), message, expected);
        return None;
    };
    let mut mixed = false;
    for entry in entries {
        if way_of(&entry.key).is_some_and(|other| other != way) {
            let message = format!("`{}` conflicts with `{}`", entry.key, first.key);
            reader.wrong(entry.span.clone(), message, format!("expected only {}", WAYS[way].1.join(", ")));
            mixed = true;
        }
    }
    if mixed {
        return None;
    }
    let (model, names, parameters, tables) = match way {
        0 => named(matrices(node, reader)?, node, reader)?,
        1 => expressions(node, reader)?,
        _ => named(builtin(node)?, node, reader)?,
    };
    let time_unit = node.get("time_unit").and_then(Node::text).map(str::to_owned);
    let Names { states, inputs, outputs } = names;
    let dt = match node.entry("dt") {
        None => None,
        Some(entry) => Some(entry.node.number().filter(|dt| *dt > 0.0 && dt.is_finite())?),
    };
    if let (Some(entry), Model::Builtin(_)) = (node.entry("dt"), &model) {
        let message = "`dt` conflicts with `builtin`: the plants of the library are in continuous time";
        return reader.refuse(
            entry.span.clone(),
            message,
            "expected matrices or expressions for a plant in discrete time",
        );
    }
    reader.dt = dt;
    let units = units::units(node.get("units"), [&states, &inputs, &outputs], &parameters, reader)?;
    let turns = angles::angles(node.get("angles"), (&model, &states, &outputs), &units, reader)?;
    let delays = delays::delays(node.get("delays"), &outputs, dt, reader)?;
    Some(PlantModel { model, states, inputs, outputs, units, turns, delays, parameters, tables, time_unit, dt })
}

/// Names of states, inputs and outputs.
struct Names {
    states: Vec<String>,
    inputs: Vec<String>,
    outputs: Vec<String>,
}

/// A plant, its names, its parameters and its lookup tables.
type NamedPlant = (Model, Names, Parameters, Tables);

/// A plant whose sizes are known, with the names that the table gives.
fn named(model: Model, node: &Node, reader: &mut Reader) -> Option<NamedPlant> {
    let names = names(node, model.size(), reader)?;
    Some((model, names, Parameters::new(), Tables::new()))
}

fn names(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<Names> {
    let mut list = |key: &str, count: usize, letter: char, what: &str| {
        let Some(list) = node.get(key) else {
            return Some((1..=count).map(|k| format!("{letter}{k}")).collect::<Vec<_>>());
        };
        let names: Vec<String> = list.texts()?.into_iter().map(str::to_owned).collect();
        if names.len() != count {
            let message =
                format!("`{key}` has {}, and the plant has {}", counted(names.len(), "name"), counted(count, what));
            return reader.refuse(list.span.clone(), message, format!("expected {}", counted(count, "name")));
        }
        if let Some(i) = (0..count).find(|i| names[..*i].contains(&names[*i])) {
            let message = format!("the name {:?} occurs twice", names[i]);
            return reader.refuse(entry_of(list, i), message, "expected different names");
        }
        Some(names)
    };
    let (states, inputs, outputs) = (
        list("states", size.states, 'x', "state"),
        list("inputs", size.inputs, 'u', "input"),
        list("outputs", size.outputs, 'y', "output"),
    );
    Some(Names { states: states?, inputs: inputs?, outputs: outputs? })
}

/// The span of an entry of a list.
fn entry_of(node: &Node, index: usize) -> Range<usize> {
    node.list().and_then(|list| list.get(index)).map_or(node.span.clone(), |entry| entry.span.clone())
}

fn matrices(node: &Node, reader: &mut Reader) -> Option<Model> {
    let mut missing = |key: &str, what: &str| {
        if node.get(key).is_none() {
            let message = format!("[plant] has matrices but no `{key}`");
            reader.absent(check::head(node), message, format!("expected `{key}`, {what}"));
        }
    };
    missing("a", "n x n");
    missing("c", "p x n");
    let (a_node, c_node) = (node.get("a")?, node.get("c")?);
    let a = rows_of(a_node)?;
    let n = a.nrows();
    if a.ncols() != n {
        let message = format!("`a` is {n} x {}", a.ncols());
        return reader.refuse(a_node.span.clone(), message, "expected a square matrix");
    }
    let why = format!("`a` is {n} x {n}");
    let c = reader.matrix(c_node, "c", (None, Some(n)), &why);
    let b = match node.get("b") {
        Some(b) => reader.matrix(b, "b", (Some(n), None), &why),
        None => Some(DMatrix::zeros(n, 0)),
    };
    let (b, c) = (b?, c?);
    let d = match node.get("d") {
        None => None,
        Some(d) => {
            let size = (c.nrows(), b.ncols());
            let why = format!("`c` is {} x {n} and `b` {n} x {}", size.0, size.1);
            Some(reader.matrix(d, "d", (Some(size.0), Some(size.1)), &why)?)
        }
    };
    let plant = StateSpace::new(a, b, c).and_then(|plant| match d {
        // Zero is no feedthrough, and costs nothing.
        Some(d) if d.iter().any(|entry| *entry != 0.0) => plant.with_feedthrough(d),
        _ => Ok(plant),
    });
    match plant {
        Ok(plant) => Some(Model::Linear(plant)),
        Err(error) => {
            reader.absent(check::head(node), error.to_string(), "expected matrices of a plant");
            None
        }
    }
}

/// The plant, its names and its parameters, which its expressions may use.
fn expressions(node: &Node, reader: &mut Reader) -> Option<NamedPlant> {
    for (key, what) in [("f", "one expression for each state"), ("h", "one expression for each output")] {
        if node.get(key).is_none() {
            let message = format!("[plant] has expressions but no `{key}`");
            reader.absent(check::head(node), message, format!("expected `{key}`, {what}"));
        }
    }
    let (f, h) = (node.get("f")?, node.get("h")?);
    let states = f.list()?.len();
    let inputs = match node.get("inputs") {
        Some(names) => names.list()?.len(),
        None => f.texts()?.iter().chain(&h.texts()?).map(|text| greatest_input(text)).max().unwrap_or(0),
    };
    let size = Dimensions { states, inputs, outputs: h.list()?.len() };
    let names = names(node, size, reader)?;
    let scope = match Scope::plant(states, inputs).named(&names.states, &names.inputs) {
        Ok(scope) => scope,
        Err(error) => {
            let key = if error.family == Family::States { "states" } else { "inputs" };
            let span = node.get(key).map_or_else(|| check::head(node), |list| entry_of(list, error.index));
            return reader.refuse(span, error.to_string(), "expected a name that has no other meaning in expressions");
        }
    };
    let parameters = parameters(node.get("parameters"), &scope, reader)?;
    // Each was checked when it was read.
    let (scope, tables) = tables(node.get("tables"), scope.with(&parameters).ok()?, reader)?;
    let (rows, measured) = (list(f, &scope, reader), list(h, &scope, reader));
    rows.and(measured)?;
    match ExpressionPlant::within(&f.texts()?, &h.texts()?, &scope) {
        Ok(plant) => Some((Model::from(plant), names, parameters, tables)),
        Err(error) => {
            reader.absent(check::head(node), error.to_string(), "expected a plant");
            None
        }
    }
}

/// The number of inputs m: the largest index of a `um` in the texts.
fn greatest_input(text: &str) -> usize {
    let words = text.split(|c: char| !(c.is_alphanumeric() || c == '_'));
    let numbers = words.filter_map(|word| word.strip_prefix('u')?.parse::<usize>().ok());
    // Very large indices are typing errors, reported by the parser of the expression.
    numbers.filter(|number| *number <= 1000).max().unwrap_or(0)
}

fn parameters(node: Option<&Node>, scope: &Scope, reader: &mut Reader) -> Option<Parameters> {
    let Some(Value::Table(entries)) = node.map(|node| &node.value) else { return Some(Parameters::new()) };
    let mut definitions = BTreeMap::new();
    let mut sound = true;
    for entry in entries {
        let number = entry.node.number();
        // The name is checked with any value.
        let one = Parameters::from([(entry.key.clone(), number.unwrap_or(0.0))]);
        if let Err(error) = scope.clone().with(&one) {
            let span = if matches!(error, ParameterError::NotFinite { .. }) { &entry.node.span } else { &entry.span };
            reader.wrong(span.clone(), error.to_string(), "expected another name with a finite number");
            sound = false;
        }
        let definition = match number {
            Some(number) => Definition::Number(number),
            None => Definition::Text(entry.node.text()?.to_owned()),
        };
        definitions.insert(entry.key.clone(), definition);
    }
    if !sound {
        return None;
    }
    derived(&definitions)
        .map_err(|error| {
            let found = entries.iter().find(|entry| entry.key == error.name()).map(|entry| &entry.node);
            let (span, message, expected) = match (&error, found) {
                (DerivedError::Expression { error, .. }, Some(node)) => {
                    (within(node, error), error.kind().to_string(), "this expression cannot be read")
                }
                (_, Some(node)) => (node.span.clone(), error.to_string(), "expected a finite number"),
                (_, None) => (0..0, error.to_string(), "expected parameters"),
            };
            reader.wrong(span, message, expected);
        })
        .ok()
}

/// The scope with the lookup tables.
fn tables(node: Option<&Node>, mut scope: Scope, reader: &mut Reader) -> Option<(Scope, Tables)> {
    let mut sound = true;
    let mut all = Tables::new();
    for entry in node.map(Node::entries).unwrap_or_default() {
        match table(&entry.node, reader) {
            Some(table) => {
                let named = Tables::from([(entry.key.clone(), table)]);
                match scope.clone().tables(&named) {
                    Ok(more) => {
                        scope = more;
                        all.extend(named);
                    }
                    Err(error) => {
                        reader.wrong(entry.span.clone(), error.to_string(), "expected another name");
                        sound = false;
                    }
                }
            }
            None => sound = false,
        }
    }
    sound.then_some((scope, all))
}

fn table(node: &Node, reader: &mut Reader) -> Option<LookupTable> {
    let (x, y) = (node.get("x")?, node.get("y")?);
    let interpolation = match node.get("method").and_then(Node::text) {
        Some("monotone-cubic") => Interpolation::MonotoneCubic,
        _ => Interpolation::Linear,
    };
    let extrapolation = match node.get("extrapolation").and_then(Node::text) {
        Some("linear") => Extrapolation::Linear,
        _ => Extrapolation::Hold,
    };
    let (along_x, along_y) = (x.numbers()?, y.numbers()?);
    if let Some(z) = node.get("z") {
        if interpolation != Interpolation::Linear {
            let method = node.get("method").map_or_else(|| z.span.clone(), |method| method.span.clone());
            reader.wrong(
                method,
                "a table of two variables is linear along both",
                "expected no `method`, or \"linear\"",
            );
            return None;
        }
        let rows: Vec<Vec<f64>> = z.list()?.iter().map(Node::numbers).collect::<Option<_>>()?;
        return Surface::new(&along_x, &along_y, &rows, extrapolation)
            .map_err(|error| {
                let row = |k: usize| z.list().and_then(|rows| rows.get(k)).map_or(z, |row| row);
                let at = match &error {
                    TableError::Rows { .. } => z,
                    TableError::Row { row: k, .. } | TableError::Value { row: k, .. } => row(*k),
                    TableError::AlongY(_) => y,
                    _ => x,
                };
                let expected = "expected increasing x and y, and z with a row for each x and a number for each y";
                reader.wrong(at.span.clone(), error.to_string(), expected);
            })
            .map(LookupTable::from)
            .ok();
    }
    Table::new(&along_x, &along_y, interpolation, extrapolation)
        .map(LookupTable::from)
        .map_err(|error| {
            let at = if matches!(error, TableError::Length { .. }) { y } else { x };
            reader.wrong(at.span.clone(), error.to_string(), "expected increasing x, and as many y");
        })
        .ok()
}

/// The expressions of a list.
pub(super) fn list(node: &Node, scope: &Scope, reader: &mut Reader) -> Option<Vec<Expression>> {
    let parsed: Vec<Option<Expression>> = node.list()?.iter().map(|entry| expression(entry, scope, reader)).collect();
    parsed.into_iter().collect()
}

fn builtin(node: &Node) -> Option<Model> {
    Builtin::named(node.get("builtin")?.text()?).map(Model::Builtin)
}
