//! The step of an observer of a linear plant, with or without a cubic part.

use std::fmt::Write;

use super::{feedback, lengths, product, scalar};
use crate::Export;
use crate::exportable_observer::ExportableObserver;

pub(super) fn step(text: &mut String, export: &Export) {
    let number = scalar(export);
    let (upper, lengths) = lengths(export);
    let [n, m, p] = lengths.map(|(what, _)| format!("{upper}_{what}"));
    let (n, m, p) = (n.as_str(), m.as_str(), p.as_str());
    let (inputs, fed) = (lengths[1].1 > 0, export.observer.feedthrough().is_some());
    let cubic = matches!(export.observer, ExportableObserver::Cubic(_));
    _ = write!(
        text,
        "
{}
{{
    {number} innovation[{p}];
    {number} next[{n}];
",
        feedback::head(export)
    );
    if cubic {
        _ = writeln!(text, "    {number} impulse[{p}];\n    {number} moved[{n}];");
    }
    text.push_str("    int i;\n    int j;\n\n");
    if !inputs {
        text.push_str("    (void)u;\n");
    }
    let xhat = if export.is_filter() { "state->prediction" } else { "state->xhat" };
    product(text, number, ("C", p, n), xhat, "innovation[i] = y[i] - sum;");
    if fed {
        product(text, number, ("D", p, m), "u", "innovation[i] = innovation[i] - sum;");
    }
    if export.is_filter() {
        product(text, number, ("UPDATE", n, p), "innovation", "state->xhat[i] = state->prediction[i] + sum;");
    }
    let moved = if cubic {
        text.push_str("    flow(innovation, impulse);\n");
        product(text, number, ("N", n, p), "impulse", "moved[i] = state->xhat[i] - sum;");
        "moved"
    } else {
        xhat
    };
    product(text, number, ("A", n, n), moved, "next[i] = sum;");
    if inputs {
        product(text, number, ("B", n, m), "u", "next[i] = next[i] + sum;");
    }
    product(text, number, ("L", n, p), "innovation", "next[i] = next[i] + sum;");
    _ = write!(
        text,
        "    for (i = 0; i < {n}; ++i) {{
        {xhat}[i] = next[i];
        if (xhat != NULL) {{
            xhat[i] = {};
        }}
    }}
}}
",
        if export.is_filter() { "state->xhat[i]" } else { "next[i]" }
    );
}
