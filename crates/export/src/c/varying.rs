//! The step of an observer at varying periods: the prediction over the time that has passed, and the correction.

use std::fmt::Write;

use luenberger_observers::varying_period::DEGREE;

use super::{lengths, product, scalar};
use crate::{Export, number};

/// Prediction and step, with the operations of `luenberger_observers::VaryingPeriodStep` in their order.
pub(super) fn step(text: &mut String, export: &Export) {
    let (name, number) = (&export.identifier, scalar(export));
    let (upper, lengths) = lengths(export);
    let [n, m, p] = lengths.map(|(what, _)| format!("{upper}_{what}"));
    let (n, p) = (n.as_str(), p.as_str());
    let inputs = lengths[1].1;
    // The columns of B and D for the time are zero.
    let (known, copied) = (
        inputs + 1,
        if inputs > 0 {
            format!("    for (i = 0; i < {m}; ++i) {{\n        known[i] = u[i];\n    }}\n")
        } else {
            "    (void)u;\n".to_owned()
        },
    );
    let count = known.to_string();
    let substeps = export.observer.prediction_substeps(export.scalar);
    let literal = |x: f64| number::c(x, export.scalar);
    let (one, zero, parts) = (literal(1.0), literal(0.0), literal(substeps as f64));
    let indented = |matrix: (&str, &str, &str), vector: &str, after: &str| {
        let mut lines = String::new();
        product(&mut lines, number, matrix, vector, after);
        lines.lines().fold(String::new(), |text, line| text + "        " + line + "\n")
    };
    _ = write!(
        text,
        "
void {name}_predict({name}_state *state, const {number} *u, {number} dt)
{{
    const {number} tau = dt / {parts};
    {number} known[{count}];
    {number} driven[{n}];
    {number} term[{n}];
    {number} next[{n}];
    int i;
    int j;
    int part;

{copied}    known[{inputs}] = dt;
"
    );
    product(text, number, ("B", n, &count), "known", "driven[i] = sum;");
    _ = write!(
        text,
        "    for (part = 0; part < {substeps}; ++part) {{
        {number} degree = {zero};
        int k;
        for (i = 0; i < {n}; ++i) {{
            term[i] = state->xhat[i];
        }}
        for (k = 0; k < {DEGREE}; ++k) {{
            degree = degree + {one};
{slope}            for (i = 0; i < {n}; ++i) {{
                term[i] = ((next[i] * tau) / degree);
                state->xhat[i] = state->xhat[i] + term[i];
            }}
        }}
    }}
}}

void {name}_step({name}_state *state, const {number} *u, const {number} *y, {number} dt, {number} *xhat)
{{
    {number} innovation[{p}];
    {number} impulse[{p}];
",
        slope = indented(("A", n, n), "term", "next[i] = (k == 0) ? (sum + driven[i]) : sum;"),
    );
    let d = export.observer.feedthrough().is_some();
    if d {
        _ = writeln!(text, "    {number} known[{count}];");
    }
    _ = write!(text, "    int i;\n    int j;\n\n    {name}_predict(state, u, dt);\n");
    product(text, number, ("C", p, n), "state->xhat", "innovation[i] = y[i] - sum;");
    if d {
        _ = writeln!(text, "{copied}    known[{inputs}] = dt;");
        product(text, number, ("D", p, &count), "known", "innovation[i] = innovation[i] - sum;");
    }
    text.push_str("    flow(innovation, impulse, dt);\n");
    product(text, number, ("N", n, p), "impulse", "state->xhat[i] = state->xhat[i] - sum;");
    product(text, number, ("GAIN", n, p), "innovation", "state->xhat[i] = state->xhat[i] + sum;");
    _ = write!(
        text,
        "    if (xhat != NULL) {{
        for (i = 0; i < {n}; ++i) {{
            xhat[i] = state->xhat[i];
        }}
    }}
}}
"
    );
}

/// The declaration of the prediction and the comment of the step, in the header.
pub(super) fn declarations(export: &Export) -> String {
    let (name, number) = (&export.identifier, scalar(export));
    let upper = name.to_uppercase();
    let unread = if export.names.inputs.is_empty() { "; not read, may be a null pointer" } else { "" };
    let longest = export.observer.scalars().iter().find(|(name, _)| *name == "LONGEST").map_or(0.0, |(_, x)| *x);
    // Six digits: a product of bounds has rounding in the others.
    let longest = format!("{longest:.5e}").parse().unwrap_or(longest);
    format!(
        "
/**
 * A prediction alone, for an input that changes between two samples: the inputs u were applied for the time dt. The next
 * step then takes the time since this call.
 *
 * @param state  State, read and written.
 * @param u      Inputs applied for this time, {upper}_INPUTS entries{unread}.
 * @param dt     The time, from 0 to {longest}; more is predicted less accurately.
 */
void {name}_predict({name}_state *state, const {number} *u, {number} dt);

/**
 * One step, at a sample that has arrived: the prediction over the time that has passed, and the correction. For a sample
 * that is missed there is no call; the next one takes the longer time.
 *
 * @param state  State, read and written.
 * @param u      Inputs applied since the last call, {upper}_INPUTS entries{unread}.
 * @param y      Outputs measured at this sample, {upper}_OUTPUTS entries.
 * @param dt     The time since the last call, from 0 to {longest}; more is predicted less accurately.
 * @param xhat   Estimate at this sample, {upper}_STATES entries; may be a null pointer.
"
    )
}
