//! The step of the observer of a nonlinear plant with a constant gain.

use std::fmt::Write;

use super::plant;
use super::{feedback, lengths, product, scalar};
use crate::Export;
use crate::exportable_observer::Maps;

pub(super) fn step(text: &mut String, export: &Export, maps: &Maps) {
    let number = scalar(export);
    let (upper, _) = lengths(export);
    let [n, p] = ["STATES", "OUTPUTS"].map(|what| format!("{upper}_{what}"));
    plant::functions(text, export, maps);
    let size = export.observer.dimensions();
    let (measured, all) = (maps.measurement.len(), (size.estimate + size.outputs).to_string());
    _ = write!(
        text,
        "
/* The slopes of the estimate and of the predicted output, z = (xhat, w). */
static void slope({number} t, const {number} *z, const {number} *u, {number} *dz)
{{
    {number} all[{measured}];
    {number} innovation[{p}];
    int i;
    int j;

    motion(t, z, u, dz);
    measurement(t, z, u, all);
    for (i = 0; i < {p}; ++i) {{
        {number} sum = all[{p} + (i * {n})] * dz[0];
        for (j = 1; j < {n}; ++j) {{
            sum = sum + (all[{p} + (i * {n}) + j] * dz[j]);
        }}
        dz[{n} + i] = sum;
        innovation[i] = z[{n} + i] - all[i];
    }}
    for (i = 0; i < {n}; ++i) {{
        {number} sum = L[i][0] * innovation[0];
        for (j = 1; j < {p}; ++j) {{
            sum = sum + (L[i][j] * innovation[j]);
        }}
        dz[i] = dz[i] + sum;
    }}
}}
"
    );
    plant::runge_kutta(text, export, &all);
    _ = write!(
        text,
        "
{head}
{{
    {number} z[{all}];
{time}    int i;

    for (i = 0; i < {n}; ++i) {{
        z[i] = state->xhat[i];
    }}
    for (i = 0; i < {p}; ++i) {{
        z[{n} + i] = y[i];
    }}
",
        head = feedback::head(export),
        time = super::time::time(export),
    );
    _ = write!(
        text,
        "    move(t, u, z);
    for (i = 0; i < {n}; ++i) {{
        state->xhat[i] = z[i];
        if (xhat != NULL) {{
            xhat[i] = z[i];
        }}
    }}
{}}}
",
        super::time::tick(export)
    );
}

/// The step of the observer of a plant in discrete time: `xhat+ = f + L (y - h)`.
pub(super) fn discrete_step(text: &mut String, export: &Export, maps: &Maps) {
    let number = scalar(export);
    let (upper, _) = lengths(export);
    let [n, p] = ["STATES", "OUTPUTS"].map(|what| format!("{upper}_{what}"));
    plant::functions(text, export, maps);
    _ = write!(
        text,
        "
{head}
{{
    {number} innovation[{p}];
    {number} next[{n}];
{time}    int i;
    int j;

    measurement(t, state->xhat, u, innovation);
    motion(t, state->xhat, u, next);
    for (i = 0; i < {p}; ++i) {{
        innovation[i] = y[i] - innovation[i];
    }}
",
        head = feedback::head(export),
        time = super::time::time(export),
    );
    product(text, number, ("L", &n, &p), "innovation", "next[i] = next[i] + sum;");
    _ = write!(
        text,
        "    for (i = 0; i < {n}; ++i) {{
        state->xhat[i] = next[i];
        if (xhat != NULL) {{
            xhat[i] = next[i];
        }}
    }}
{}}}
",
        super::time::tick(export)
    );
}
