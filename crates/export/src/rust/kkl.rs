//! The numerical KKL observer as Rust: its trees are constants in flash.

use std::fmt::Write;

use luenberger_observers::numerical_kkl::Branch;

use super::{named, number};
use crate::Export;
use crate::kkl::Kkl;
use crate::program::Scalar;

/// What the source uses of the observers.
pub(super) fn imports(kkl: &Kkl<f64>) -> String {
    let interpolated = if kkl.table(Scalar::Binary64).is_some() { "InterpolatedInverse, " } else { "" };
    let more = if interpolated.is_empty() { "" } else { "Search, TensorSpline, " };
    let list = format!(
        "Branch, Coordinates, {interpolated}Node, PolynomialInverse, PolynomialTree, SampledFilter, SampledKkl, {more}"
    );
    format!("use luenberger_observers::numerical_kkl::{{\n    {},\n}};", list.trim_end_matches(", "))
}

/// The type of the observer.
pub(super) fn kind(export: &Export, kkl: &Kkl<f64>) -> String {
    let (scalar, size) = (export.scalar.name(), kkl.dimensions());
    let (n, z) = (size.estimate, size.state);
    let inverse = if kkl.table(export.scalar).is_some() { "InterpolatedInverse" } else { "PolynomialInverse" };
    format!(
        "SampledKkl<Model, {scalar}, {inverse}<{scalar}, &'static [Node<{scalar}>], &'static [{scalar}], {n}, {z}>, {n}, {}, {}, {z}>",
        size.inputs, size.outputs
    )
}

/// The body of `observer()`.
pub(super) fn observer(text: &mut String, export: &Export, kkl: &Kkl<f64>) {
    let of = |name: &str| named(export, name).unwrap_or_default();
    let literal = |x: f64| number::rust(export.scalar.round(x), export.scalar);
    let [(_, inverse), (_, forward)] = kkl.trees();
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
    let inverse = PolynomialTree::new({}, INVERSE_NODES, INVERSE_LEAVES)?;
    let forward = PolynomialTree::new({}, FORWARD_NODES, FORWARD_LEAVES)?;
    let inverse = PolynomialInverse::new(coordinates, (lower, upper), inverse, forward)?;
",
        of("FILTER"),
        of("B"),
        literal(kkl.period()),
        kkl.substeps(),
        of("MEAN"),
        of("WHITEN"),
        of("COLOUR"),
        of("LOWER"),
        of("UPPER"),
        inverse.degree,
        forward.degree,
    );
    if let Some(table) = kkl.table(export.scalar) {
        _ = write!(
            text,
            "    let spline = TensorSpline::new(lower, upper, {:?}, TABLE)?;
    let search = Search {{ max_evaluations: {}, tolerance: {}, fallback: {} }};
    let inverse = InterpolatedInverse::new(spline, inverse, search)?;
",
            table.points,
            table.max_evaluations,
            literal(table.tolerance),
            table.fallback
        );
    }
    text.push_str("    SampledKkl::new(Model, filter, inverse)\n");
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
    if let Some(table) = kkl.table(export.scalar) {
        _ = writeln!(text, "\nconst TABLE: &[{scalar}] = &[");
        for line in table.coefficients.chunks(6) {
            let line: Vec<String> = line.iter().map(|x| literal(*x)).collect();
            _ = writeln!(text, "    {},", line.join(", "));
        }
        text.push_str("];\n");
    }
}
