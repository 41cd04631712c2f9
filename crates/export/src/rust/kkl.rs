//! The numerical KKL observer as Rust: its trees are constants in flash.

use std::fmt::Write;

use luenberger_observers::MatrixName;
use luenberger_observers::numerical_kkl::{Branch, Search};

use super::{number, of};
use crate::kkl::{Kkl, TableOf};
use crate::scalar::Scalar;
use crate::{Export, ExportedMatrix};

/// What the source uses of the observers.
pub(super) fn imports(kkl: &Kkl<f64>) -> String {
    let (left, sampled) = (inverse_name(kkl), if kkl.held_inputs() > 0 { "SampledHeldKkl" } else { "SampledKkl" });
    let mut list = vec!["Coordinates", "Node", "PolynomialTree", "SampledFilter", left, sampled];
    if let Some(table) = kkl.table(Scalar::Binary64) {
        list.extend(["Search", table_name(&table)]);
        list.extend((left == "InterpolatedInverse").then_some("PolynomialInverse"));
        list.extend((left == "HeldInputInverse").then_some("HeldInputTables"));
    }
    list.extend(kkl.trees().iter().any(|(_, tree)| !tree.nodes.is_empty()).then_some("Branch"));
    list.sort_unstable();
    format!("use luenberger_observers::numerical_kkl::{{\n    {},\n}};", list.join(", "))
}

fn inverse_name(kkl: &Kkl<f64>) -> &'static str {
    match (kkl.held_inputs(), kkl.table(Scalar::Binary64)) {
        (0, None) => "PolynomialInverse",
        (0, Some(_)) => "InterpolatedInverse",
        (_, None) => "HeldInputTrees",
        (_, Some(_)) => "HeldInputInverse",
    }
}

/// The type of a table.
fn table_name(table: &TableOf) -> &'static str {
    if table.ranks.is_empty() { "TensorSpline" } else { "TensorTrain" }
}

/// The type of the observer.
pub(super) fn kind(export: &Export, kkl: &Kkl<f64>) -> String {
    let (scalar, size) = (export.scalar.name(), kkl.dimensions());
    let (n, m, p, z) = (size.estimate, size.inputs, size.outputs, size.state);
    let lent = format!("{scalar}, &'static [Node<{scalar}>], &'static [{scalar}]");
    let left = inverse_name(kkl);
    if m == 0 {
        let low_rank = kkl.table(export.scalar).filter(|table| !table.ranks.is_empty());
        let table =
            low_rank.map_or_else(String::new, |_| format!(", TensorTrain<{scalar}, &'static [{scalar}], {n}, {z}>"));
        return format!("SampledKkl<Model, {scalar}, {left}<{lent}, {n}, {z}{table}>, {n}, {m}, {p}, {z}>");
    }
    let inverse = match kkl.table(export.scalar) {
        Some(table) => format!(
            "{left}<{lent}, [TensorSpline<{scalar}, &'static [{scalar}], {n}, {z}>; {}], {n}, {m}, {z}, {}>",
            table.tables(),
            z + m
        ),
        None => format!("{left}<{lent}, {n}, {m}, {z}, {}, {}>", z + m, n + m),
    };
    format!("SampledHeldKkl<Model, {scalar}, {inverse}, {n}, {m}, {p}, {z}, {}>", z + n)
}

/// The body of `observer()`.
pub(super) fn observer(text: &mut String, export: &Export, kkl: &Kkl<f64>) {
    let matrix = |which: ExportedMatrix| of(export, which).unwrap_or_default();
    let literal = |x: f64| number::rust(export.scalar.round(x), export.scalar);
    _ = write!(
        text,
        "    let filter = SampledFilter {{
        d: {},
        b: {},
        period: {},
        substeps: {},
    }};
    let mean = {};
    let whiten = {};
    let colour = {};
    let coordinates = Coordinates::new(mean, whiten, colour)?;
    let lower = {};
    let upper = {};
",
        matrix(ExportedMatrix::Filter),
        matrix(MatrixName::B.into()),
        literal(kkl.period()),
        kkl.substeps(),
        matrix(ExportedMatrix::Mean),
        matrix(ExportedMatrix::Whiten),
        matrix(ExportedMatrix::Colour),
        matrix(ExportedMatrix::Lower),
        matrix(ExportedMatrix::Upper),
    );
    for (name, tree) in kkl.trees() {
        let upper = name.to_uppercase();
        let degree = tree.degree;
        _ = writeln!(text, "    let {name} = PolynomialTree::new({degree}, {upper}_NODES, {upper}_LEAVES)?;");
    }
    let is_held = kkl.held_inputs() > 0;
    let table = kkl.table(export.scalar);
    match (&table, is_held) {
        (_, false) => {
            text.push_str(
                "    let inverse = PolynomialInverse::new(coordinates, (lower, upper), inverse, forward)?;\n",
            );
        }
        (None, true) => {
            _ = write!(
                text,
                "    let family = ({}, {});
    let inverse = HeldInputTrees::new(coordinates, (lower, upper), family, (inverse, forward))?;
",
                matrix(ExportedMatrix::LeastInput),
                matrix(ExportedMatrix::MostInput)
            );
        }
        (Some(table), true) => {
            let spline = |k| format!("        TensorSpline::new(lower, upper, {:?}, TABLES[{k}])?,\n", table.points);
            let splines = (0..table.tables()).map(spline).collect::<Vec<_>>().concat();
            _ = write!(
                text,
                "    let splines = [\n{splines}    ];
    let tables = HeldInputTables::new(coordinates, NODES, splines)?;
"
            );
        }
    }
    if let Some(table) = &table {
        let search = table.search.as_ref().map(|search| {
            let Search { max_evaluations, tolerance, fallback } = search;
            let tolerance = literal(*tolerance);
            format!("Search {{ max_evaluations: {max_evaluations}, tolerance: {tolerance}, fallback: {fallback} }}")
        });
        if is_held {
            let search = search.map_or_else(|| "None".to_owned(), |search| format!("Some({search})"));
            _ = write!(
                text,
                "    let search = {search};
    let inverse = HeldInputInverse::new(tables, inverse, search)?;
"
            );
        } else {
            _ = write!(
                text,
                "    let spline = {}::new(lower, upper, {:?}, {}TABLE)?;
    let search = {};
    let inverse = InterpolatedInverse::new(spline, inverse, search)?;
",
                table_name(table),
                table.points,
                if table.ranks.is_empty() { String::new() } else { format!("{:?}, ", table.ranks) },
                search.unwrap_or_default()
            );
        }
    }
    _ = writeln!(text, "    {}::new(Model, filter, inverse)", if is_held { "SampledHeldKkl" } else { "SampledKkl" });
}

/// The input at the start, as a function.
pub(super) fn first_input(text: &mut String, export: &Export, kkl: &Kkl<f64>) {
    let Some(first) = of(export, ExportedMatrix::FirstInput) else { return };
    _ = write!(
        text,
        "
/// The input at which z starts.
pub fn first_input() -> SVector<{}, {}> {{
    {first}
}}
",
        export.scalar.name(),
        kkl.held_inputs()
    );
}

/// The trees as constants.
pub(super) fn trees(text: &mut String, export: &Export, kkl: &Kkl<f64>) {
    let literal = |x: f64| number::rust(export.scalar.round(x), export.scalar);
    let scalar = export.scalar.name();
    for (name, tree) in kkl.trees() {
        let name = name.to_uppercase();
        _ = writeln!(text, "\nconst {name}_NODES: &[Node<{scalar}>] = &[");
        for node in &tree.nodes {
            let branch = |branch: Branch| match branch {
                Branch::Node(index) => format!("Branch::Node({index})"),
                Branch::Leaf(index) => format!("Branch::Leaf({index})"),
            };
            let (below, above) = (branch(node.below), branch(node.above));
            let (axis, threshold) = (node.axis, literal(node.threshold));
            _ = writeln!(text, "    Node {{ axis: {axis}, threshold: {threshold}, below: {below}, above: {above} }},");
        }
        _ = writeln!(text, "];\n\nconst {name}_LEAVES: &[{scalar}] = &[");
        for line in tree.leaves.chunks(6) {
            let line: Vec<String> = line.iter().map(|x| literal(*x)).collect();
            _ = writeln!(text, "    {},", line.join(", "));
        }
        text.push_str("];\n");
    }
    let Some(table) = kkl.table(export.scalar) else { return };
    let numbers = |text: &mut String, indent: &str, values: &[f64]| {
        for line in values.chunks(6) {
            let line: Vec<String> = line.iter().map(|x| literal(*x)).collect();
            _ = writeln!(text, "{indent}{},", line.join(", "));
        }
    };
    if table.nodes.is_empty() {
        _ = writeln!(text, "\nconst TABLE: &[{scalar}] = &[");
        numbers(text, "    ", &table.coefficients);
        text.push_str("];\n");
        return;
    }
    _ = writeln!(text, "\nconst NODES: &[{scalar}] = &[");
    numbers(text, "    ", &table.nodes.concat());
    _ = writeln!(text, "];\n\nconst TABLES: [&[{scalar}]; {}] = [", table.tables());
    for part in table.coefficients.chunks(table.coefficients.len() / table.tables()) {
        text.push_str("    &[\n");
        numbers(text, "        ", part);
        text.push_str("    ],\n");
    }
    text.push_str("];\n");
}
