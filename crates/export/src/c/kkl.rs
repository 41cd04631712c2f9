//! The step of the numerical KKL observer, and its left inverse by trees of polynomials.

use std::fmt::Write;

use super::plant;
use super::{feedback, is_finite, lengths, product, scalar, table};
use crate::kkl::{Kkl, TableOf, Tree};
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

/// The trees and the left inverse, which the start needs as well.
pub(super) fn inverse(text: &mut String, export: &Export, kkl: &Kkl<f64>) {
    let number = scalar(export);
    let (upper, _) = lengths(export);
    let (n, z) = (format!("{upper}_STATES"), targets(kkl).to_string());
    let zero = number::c(0.0, export.scalar);
    _ = write!(
        text,
        "
/* The number of [low, high] nearest to x. */
static {number} between({number} x, {number} low, {number} high)
{{
    const {number} raised = (x > low) ? x : low;
    return (raised < high) ? raised : high;
}}
"
    );
    let table = kkl.table(export.scalar);
    for (name, tree) in kkl.trees() {
        if is_emitted(name, table.as_ref()) {
            self::tree(text, export, name, &tree);
        }
    }
    if let Some(table) = &table {
        table::functions(text, export, table);
    }
    let (m, held) = (kkl.held_inputs(), kkl.held_inputs() > 0);
    let searched = table.as_ref().filter(|table| table.search.is_some());
    _ = write!(
        text,
        "
/* The estimate: the state whose image {}is z, in its box. */
static void estimate(const {number} *z, {}{number} *xhat)
{{
    {number} shifted[{z}];
    {number} w[{}];
{}    int i;
    int j;

    for (i = 0; i < {z}; ++i) {{
        shifted[i] = z[i] - MEAN[i][0];
    }}
",
        if held { "at the input u " } else { "" },
        if held { format!("const {number} *u, ") } else { String::new() },
        targets(kkl) + m,
        searched.map_or_else(String::new, |table| table::shares(export, table)),
    );
    product(
        text,
        number,
        ("WHITEN", &z, &z),
        "shifted",
        &format!("w[i] = ({}) ? sum : {zero};", is_finite(export, "sum")),
    );
    if held {
        text.push_str(&into_family(m, "u[i]", &format!("w[{z} + i]")));
    }
    _ = write!(
        text,
        "    inverse(w, xhat);
    for (i = 0; i < {n}; ++i) {{
        xhat[i] = between(xhat[i], LOWER[i][0], UPPER[i][0]);
    }}
{}}}
",
        searched.map_or_else(String::new, |table| table::call(table, &format!("&w[{z}]")))
    );
}

/// The inputs `from` taken into their family, as `to`.
fn into_family(m: usize, from: &str, to: &str) -> String {
    format!(
        "    for (i = 0; i < {m}; ++i) {{\n        {to} = between({from}, LEAST_INPUT[i][0], MOST_INPUT[i][0]);\n    }}\n"
    )
}

/// A tree of polynomials as a function.
fn tree(text: &mut String, export: &Export, name: &str, tree: &Tree) {
    let number = scalar(export);
    let literal = |x: f64| number::c(export.scalar.round(x), export.scalar);
    let list = |text: &mut String, kind: &str, what: &str, entries: Vec<String>| {
        _ = writeln!(text, "static const {kind} {what}[{}] = {{", entries.len());
        for line in entries.chunks(6) {
            _ = writeln!(text, "    {},", line.join(", "));
        }
        text.push_str("};\n");
    };
    let upper = name.to_uppercase();
    text.push('\n');
    let has_nodes = !tree.nodes.is_empty();
    if has_nodes {
        let codes = |of: fn(&luenberger_observers::numerical_kkl::Node<f64>) -> i32| -> Vec<String> {
            tree.nodes.iter().map(|node| of(node).to_string()).collect()
        };
        list(text, "int", &format!("{upper}_AXIS"), codes(|node| i32::from(node.axis)));
        let thresholds = tree.nodes.iter().map(|node| literal(node.threshold)).collect();
        list(text, number, &format!("{upper}_THRESHOLD"), thresholds);
        list(text, "int", &format!("{upper}_BELOW"), codes(|node| Tree::code(node.below)));
        list(text, "int", &format!("{upper}_ABOVE"), codes(|node| Tree::code(node.above)));
    }
    list(text, number, &format!("{upper}_LEAVES"), tree.leaves.iter().map(|x| literal(*x)).collect());
    let Tree { inputs, outputs, degree, .. } = tree;
    let (stride, coefficients) = (tree.stride(), tree.coefficients());
    let zero = literal(0.0);
    // Nested Horner: the last variable outside, the degree that is left for the others grows.
    let mut horner = String::new();
    for depth in (0..*inputs).rev() {
        let indent = "    ".repeat(inputs - depth + 1);
        let bound = if depth + 1 == *inputs { degree.to_string() } else { format!("d{}", depth + 1) };
        _ = writeln!(
            horner,
            "{indent}{number} s{depth} = {zero};\n{indent}int d{depth};\n{indent}for (d{depth} = 0; d{depth} <= {bound}; ++d{depth}) {{"
        );
    }
    let indent = "    ".repeat(inputs + 2);
    _ = writeln!(horner, "{indent}s0 = (s0 * local[0]) + leaf[k];\n{indent}++k;");
    for depth in 0..*inputs {
        let indent = "    ".repeat(inputs - depth + 1);
        _ = writeln!(horner, "{indent}}}");
        if depth + 1 < *inputs {
            _ = writeln!(horner, "{indent}s{} = (s{} * local[{}]) + s{depth};", depth + 1, depth + 1, depth + 1);
        }
    }
    let walk = if has_nodes {
        format!(
            "    int branch = 0;
    const {number} *leaf;
    int i;
    int k = {first};

    while (branch >= 0) {{
        branch = (point[{upper}_AXIS[branch]] < {upper}_THRESHOLD[branch]) ? {upper}_BELOW[branch] : {upper}_ABOVE[branch];
    }}
    leaf = &{upper}_LEAVES[(-1 - branch) * {stride}];
",
            first = 2 * (inputs + outputs),
        )
    } else {
        format!("    const {number} *leaf = {upper}_LEAVES;\n    int i;\n    int k = {};\n\n", 2 * (inputs + outputs))
    };
    _ = write!(
        text,
        "
/* Polynomials of total degree {degree}, {coefficients} coefficients each, on the cells of a tree. */
static void {name}(const {number} *point, {number} *out)
{{
    {number} local[{inputs}];
{walk}    for (i = 0; i < {inputs}; ++i) {{
        local[i] = between((point[i] - leaf[i]) * leaf[{inputs} + i], {low}, {high});
    }}
    for (i = 0; i < {outputs}; ++i) {{
{horner}        out[i] = between(s{last}, leaf[{least} + i], leaf[{most} + i]);
    }}
}}
",
        low = literal(-1.125),
        high = literal(1.125),
        last = inputs - 1,
        least = 2 * inputs,
        most = 2 * inputs + outputs,
    );
}

/// The start: z from the first estimate, at the first input.
pub(super) fn start(text: &mut String, export: &Export, kkl: &Kkl<f64>) {
    let (name, number) = (&export.identifier, scalar(export));
    let (upper, _) = lengths(export);
    let (n, z) = (format!("{upper}_STATES"), targets(kkl).to_string());
    let (states, m) = (export.observer.dimensions().estimate, kkl.held_inputs());
    let (forward, variables) = match kkl.table(export.scalar) {
        Some(table) => {
            let all = targets(kkl) * states;
            let inputs = if m > 0 { format!("    {number} u[{m}];\n") } else { String::new() };
            let variables = format!("{inputs}    {number} jacobian[{all}];\n{}", table::shares(export, &table));
            (table::start(&table), variables)
        }
        None => ("    forward(x, w);\n".to_owned(), String::new()),
    };
    let is_tree = kkl.table(export.scalar).is_none();
    let (length, inputs) = match (m, is_tree) {
        (0, _) => (n.clone(), String::new()),
        (m, true) => (format!("{n} + {m}"), into_family(m, "FIRST_INPUT[i][0]", &format!("x[{n} + i]"))),
        (m, false) => (n.clone(), into_family(m, "FIRST_INPUT[i][0]", "u[i]")),
    };
    _ = write!(
        text,
        "
void {name}_init({name}_state *state, const {number} *xhat)
{{
    {number} x[{length}];
    {number} w[{z}];
{variables}    int i;
    int j;

    for (i = 0; i < {n}; ++i) {{
        x[i] = between(xhat[i], LOWER[i][0], UPPER[i][0]);
    }}
{inputs}{forward}"
    );
    product(text, number, ("COLOUR", &z, &z), "w", "state->z[i] = MEAN[i][0] + sum;");
    let first = if export.observer.uses_time() { "    state->sample = 0;\n" } else { "" };
    let input = if m > 0 { "&FIRST_INPUT[0][0], " } else { "" };
    _ = write!(text, "    estimate(state->z, {input}state->xhat);\n{first}}}\n");
}

pub(super) fn step(text: &mut String, export: &Export, kkl: &Kkl<f64>) {
    let number = scalar(export);
    let (upper, _) = lengths(export);
    let ([n, p], z) = (["STATES", "OUTPUTS"].map(|what| format!("{upper}_{what}")), targets(kkl).to_string());
    // Held inputs stand behind the offset.
    let (m, size) = (kkl.held_inputs(), export.observer.dimensions().outputs);
    let (also, held) =
        if m > 0 { ("; held inputs follow it", format!("&offset[{size}]")) } else { ("", "offset".to_owned()) };
    _ = write!(
        text,
        "
/* The slopes of the target states and of the copy of the plant, v = (z, x); offset + h(x) is the predicted output{also}. */
static void slope({number} t, const {number} *v, const {number} *offset, {number} *dv)
{{
    {number} w[{p}];
    int i;
    int j;

    measurement(t, &v[{z}], {held}, w);
    motion(t, &v[{z}], {held}, &dv[{z}]);
    for (i = 0; i < {p}; ++i) {{
        w[i] = offset[i] + w[i];
    }}
"
    );
    product(text, number, ("FILTER", &z, &z), "v", "dv[i] = sum;");
    product(text, number, ("B", &z, &p), "w", "dv[i] = dv[i] + sum;");
    text.push_str("}\n");
    let length = (targets(kkl) + export.observer.dimensions().estimate).to_string();
    plant::runge_kutta(text, export, &length);
    _ = write!(
        text,
        "
{head}
{{
    {number} offset[{all}];
    {number} z[{length}];
{time}    int i;

    measurement(t, state->xhat, u, offset);
    for (i = 0; i < {p}; ++i) {{
        offset[i] = y[i] - offset[i];
    }}
{copied}    for (i = 0; i < {z}; ++i) {{
        z[i] = state->z[i];
    }}
    for (i = 0; i < {n}; ++i) {{
        z[{z} + i] = state->xhat[i];
    }}
",
        head = feedback::head(export),
        all = if m > 0 { format!("{p} + {m}") } else { p.clone() },
        copied = if m > 0 {
            format!("    for (i = 0; i < {m}; ++i) {{\n        offset[{p} + i] = u[i];\n    }}\n")
        } else {
            String::new()
        },
        time = super::time::time(export),
    );
    _ = write!(
        text,
        "    move(t, offset, z);
    for (i = 0; i < {z}; ++i) {{
        state->z[i] = z[i];
    }}
    estimate(state->z, {}state->xhat);
    if (xhat != NULL) {{
        for (i = 0; i < {n}; ++i) {{
            xhat[i] = state->xhat[i];
        }}
    }}
{}}}
",
        if m > 0 { "u, " } else { "" },
        super::time::tick(export)
    );
}
