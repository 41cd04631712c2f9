//! The step of an observer that is straight-line code as a whole.

use std::fmt::Write;

use super::plant;
use super::{feedback, lengths, scalar};
use crate::Export;
use crate::c_math;
use crate::exportable_observer::{Maps, tables};

pub(super) fn step(text: &mut String, export: &Export, maps: &Maps) {
    let number = scalar(export);
    let (upper, _) = lengths(export);
    let [n, m, p] = ["STATES", "INPUTS", "OUTPUTS"].map(|what| format!("{upper}_{what}"));
    let (next, size) = (&maps.motion, export.observer.dimensions());
    let prefix = format!("{}_", export.identifier);
    let dialect = plant::dialect(export.scalar, &prefix);
    let called = next.functions();
    if !called.is_empty() {
        _ = write!(text, "\n{}", c_math::source(&export.identifier, export.scalar, called));
    }
    for (index, table, used) in tables(&[next]) {
        _ = write!(text, "\n{}", table.source(index, &dialect, used));
    }
    plant::function(text, export, ("motion", "The next state; the inputs are (u, y)"), next, &dialect);
    let known = size.inputs + size.outputs;
    let inputs = if size.inputs > 0 {
        format!("    for (i = 0; i < {m}; ++i) {{\n        known[i] = u[i];\n    }}\n")
    } else {
        "    (void)u;\n".to_owned()
    };
    _ = write!(
        text,
        "
{head}
{{
    {number} known[{known}];
    {number} next[{n}];
{time}    int i;

{inputs}    for (i = 0; i < {p}; ++i) {{
        known[{m} + i] = y[i];
    }}
    motion(t, state->xhat, known, next);
    for (i = 0; i < {n}; ++i) {{
        state->xhat[i] = next[i];
        if (xhat != NULL) {{
            xhat[i] = next[i];
        }}
    }}
{tick}}}
",
        head = feedback::head(export),
        time = super::time::time(export),
        tick = super::time::tick(export),
    );
}
