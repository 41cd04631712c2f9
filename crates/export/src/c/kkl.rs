//! The numerical KKL observer: its left inverse by trees of polynomials, with or without tables and a search, and its
//! step.

use std::fmt::Write;

use luenberger_observers::numerical_kkl::least_squares::RESTARTS;
use luenberger_observers::numerical_kkl::{Node, Search};
use nalgebra::DMatrix;

use super::kernels::{self, Macros};
use super::scalar;
use crate::kkl::{Kkl, TableOf, Tree};
use crate::scalar::Scalar;
use crate::{Export, number};

/// Target states.
pub(super) fn targets(kkl: &Kkl<f64>) -> usize {
    kkl.dimensions().state
}

/// What the constants of the left inverse take, as a sentence.
pub(super) fn sizes(export: &Export, kkl: &Kkl<f64>) -> String {
    let bytes = |numbers: usize| format!("{numbers} numbers ({} bytes)", numbers * export.scalar.bytes());
    let table = kkl.table(export.scalar);
    let trees = kkl.trees().into_iter().filter(|(name, _)| is_emitted(name, table.as_ref()));
    let leaves: usize = trees.map(|(_, tree)| tree.leaves.len() + tree.nodes.len()).sum();
    let table = table.map_or_else(String::new, |table| {
        let numbers = bytes(table.coefficients.len());
        match table.tables() {
            1 => format!("; its table, {numbers}"),
            count => format!("; its {count} tables, one for each combination of inputs, {numbers}"),
        }
    });
    format!("Constants: trees of the left inverse, {}{table}.", bytes(leaves))
}

/// Whether a tree is used: a table is T itself.
fn is_emitted(tree: &str, table: Option<&TableOf>) -> bool {
    table.is_none() || tree == "inverse"
}

/// The left inverse, and the start, which needs it as well.
pub(super) fn start(text: &mut String, export: &Export, kkl: &Kkl<f64>) {
    let macros = macros(export, kkl);
    macros.write(text, kernels::BETWEEN);
    let table = kkl.table(export.scalar);
    let trees: Vec<_> = kkl.trees().into_iter().filter(|(name, _)| is_emitted(name, table.as_ref())).collect();
    horner(text, export, trees.iter().map(|(_, tree)| tree.inputs).max().unwrap_or_default());
    for (name, tree) in &trees {
        self::tree(text, export, name, tree);
    }
    if let Some(table) = &table {
        coefficients(text, export, table);
        macros.write(text, kernels::SPLINE_TABLE);
        if table.search.is_some() {
            macros.write(text, kernels::NEAREST);
        }
    }
    macros.write(text, kernels::KKL);
}

pub(super) fn step(text: &mut String, export: &Export, kkl: &Kkl<f64>) {
    let macros = macros(export, kkl);
    for kernel in [kernels::KKL_SLOPE, kernels::RUNGE_KUTTA, kernels::KKL_STEP] {
        macros.write(text, kernel);
    }
}

fn macros(export: &Export, kkl: &Kkl<f64>) -> Macros {
    let mut all = Macros::of(export);
    let (states, targets) = (export.observer.dimensions().estimate, targets(kkl));
    all.integer("TARGETS", targets);
    all.integer("LENGTH", targets + states);
    let table = kkl.table(export.scalar);
    all.option("HAS_TABLE", table.is_some());
    let Some(table) = table else { return all };
    all.option("LOW_RANK", !table.ranks.is_empty());
    all.integer("MOST_RANK", table.ranks.iter().copied().max().unwrap_or(1));
    all.integer("CORNERS", 4_usize.pow(states as u32 - 1));
    all.number("SIXTH", 1.0 / 6.0);
    all.number("TWO_THIRDS", 2.0 / 3.0);
    all.option("SEVERAL_TABLES", !table.nodes.is_empty());
    all.integer("TABLES", table.tables());
    all.integer("TABLE_SIZE", table.coefficients.len() / table.tables());
    all.integer("NODE_COUNT", table.nodes.first().map_or(0, Vec::len));
    all.option("HAS_SEARCH", table.search.is_some());
    let Some(Search { max_evaluations, tolerance, fallback }) = table.search else { return all };
    all.integer("MOST_EVALUATIONS", max_evaluations);
    all.option("HAS_RESTARTS", fallback > 0);
    all.integer("RESTARTS", RESTARTS);
    all.integer("GRID_POINTS", fallback);
    all.integer("GRID_CELLS", fallback.pow(states as u32));
    let epsilon = match export.scalar {
        Scalar::Binary32 => f64::from(f32::EPSILON),
        Scalar::Binary64 => f64::EPSILON,
    };
    for (name, x) in [
        ("TOLERANCE", tolerance),
        ("EPSILON", epsilon),
        ("RESOLUTION", 4.0 * epsilon),
        ("FIRST_DAMPING", 1e-4),
        ("LEAST_DAMPING", 1e-6),
        ("LESS_DAMPING", 0.1),
    ] {
        all.number(name, x);
    }
    all
}

/// A constant array of so many numbers a line.
fn list(text: &mut String, kind: &str, name: &str, entries: &[String]) {
    _ = writeln!(text, "static const {kind} {name}[{}] = {{", entries.len());
    for line in entries.chunks(6) {
        _ = writeln!(text, "    {},", line.join(", "));
    }
    text.push_str("};\n");
}

/// Polynomials in one variable, in two, and so on.
fn horner(text: &mut String, export: &Export, variables: usize) {
    let mut macros = Macros::of(export);
    macros.write(text, kernels::HORNER);
    for variable in 1..variables {
        macros.set("INNER", format!("horner_{variable}"));
        macros.set("HORNER", format!("horner_{}", variable + 1));
        macros.integer("VARIABLE", variable);
        macros.write(text, kernels::HORNER_NEXT);
    }
}

/// A tree of polynomials as constants and a function.
fn tree(text: &mut String, export: &Export, name: &str, tree: &Tree) {
    let literals = |numbers: &mut dyn Iterator<Item = f64>| -> Vec<String> {
        numbers.map(|x| number::c(export.scalar.round(x), export.scalar)).collect()
    };
    let mut macros = Macros::of(export);
    macros.set("TREE", name);
    macros.set("HORNER", format!("horner_{}", tree.inputs));
    let [axis, threshold, below, above, leaves] =
        ["AXIS", "THRESHOLD", "BELOW", "ABOVE", "LEAVES"].map(|what| format!("{}_{what}", name.to_uppercase()));
    text.push('\n');
    if !tree.nodes.is_empty() {
        let codes =
            |of: fn(&Node<f64>) -> i32| -> Vec<String> { tree.nodes.iter().map(|node| of(node).to_string()).collect() };
        list(text, "int", &axis, &codes(|node| i32::from(node.axis)));
        list(text, scalar(export), &threshold, &literals(&mut tree.nodes.iter().map(|node| node.threshold)));
        list(text, "int", &below, &codes(|node| Tree::code(node.below)));
        list(text, "int", &above, &codes(|node| Tree::code(node.above)));
    }
    list(text, scalar(export), &leaves, &literals(&mut tree.leaves.iter().copied()));
    macros.option("HAS_COMPARISONS", !tree.nodes.is_empty());
    let names = ["TREE_AXIS", "TREE_THRESHOLD", "TREE_BELOW", "TREE_ABOVE", "TREE_LEAVES"];
    for (macro_name, name) in names.into_iter().zip([axis, threshold, below, above, leaves]) {
        macros.set(macro_name, name);
    }
    for (name, value) in [
        ("VARIABLES", tree.inputs),
        ("RESULTS", tree.outputs),
        ("DEGREE", tree.degree),
        ("COEFFICIENTS", tree.coefficients()),
        ("LEAF_LENGTH", tree.stride()),
    ] {
        macros.integer(name, value);
    }
    macros.number("REACH", 1.125);
    macros.write(text, kernels::POLYNOMIAL_TREE);
}

/// The coefficients of the splines with their sizes, the starts of a search, and the inputs with a table.
fn coefficients(text: &mut String, export: &Export, table: &TableOf) {
    let literal = |x: f64| number::c(export.scalar.round(x), export.scalar);
    let order = if table.ranks.is_empty() { "the last axis fastest" } else { "axis by axis, a matrix for each" };
    _ = writeln!(text, "\n/* Coefficients of the splines, {order}. */");
    list(text, scalar(export), "TABLE", &table.coefficients.iter().map(|x| literal(*x)).collect::<Vec<_>>());
    let row = |text: &mut String, kind: &str, name: &str, entries: Vec<String>| {
        _ = writeln!(text, "static const {kind} {name}[{}] = {{ {} }};", entries.len(), entries.join(", "));
    };
    let axes = |of: &dyn Fn(usize) -> usize| table.points.iter().map(|count| of(*count).to_string()).collect();
    let n = table.points.len();
    row(text, "int", "CELLS", axes(&|count| count - 1));
    if table.ranks.is_empty() {
        row(text, "int", "STRIDE", axes(&|count| count + 2));
    } else {
        text.push_str("/* Rows of the matrices of each axis, and the columns of the last. */\n");
        row(text, "int", "RANK", table.ranks.iter().chain([&1]).map(usize::to_string).collect());
        let ends = (0..n).scan(0, |end, axis| {
            *end += (table.points[axis] + 2) * table.ranks[axis] * table.columns(axis);
            Some(end.to_string())
        });
        row(text, "int", "CORE", [String::from("0")].into_iter().chain(ends).take(n).collect());
    }
    if let Some(Search { fallback: count @ 1.., .. }) = table.search {
        let shares = (0..count).map(|k| literal((k as f64 + 0.5) / count as f64)).collect();
        row(text, scalar(export), "SHARE", shares);
    }
    if let Some(first) = table.nodes.first() {
        text.push_str("\n/* The values of each input with a table. */\n");
        let nodes = DMatrix::from_fn(table.nodes.len(), first.len(), |i, j| table.nodes[i][j]);
        super::matrix(text, export, "NODES", &nodes);
    }
}
