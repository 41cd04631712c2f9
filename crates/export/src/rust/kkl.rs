//! The numerical KKL observer as Rust: its trees are constants in flash.

use std::fmt::Write;

use luenberger_observers::numerical_kkl::Branch;

use super::{named, number};
use crate::Export;
use crate::kkl::Kkl;

/// What the source uses of the observers.
pub(super) const IMPORTS: &str = "use luenberger_observers::numerical_kkl::{
    Branch, Coordinates, Node, PolynomialInverse, PolynomialTree, SampledFilter, SampledKkl,
};";

/// The type of the observer.
pub(super) fn kind(export: &Export, kkl: &Kkl<f64>) -> String {
    let (scalar, size) = (export.scalar.name(), kkl.dimensions());
    format!(
        "SampledKkl<Model, {scalar}, &'static [Node<{scalar}>], &'static [{scalar}], {}, {}, {}, {}>",
        size.estimate, size.inputs, size.outputs, size.state
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
    SampledKkl::new(Model, filter, inverse)
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
}
