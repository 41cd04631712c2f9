//! The step of a recorded observer, with an output predicted between samples.

use std::fmt::Write;

use super::plant;
use super::{feedback, lengths, scalar};
use crate::Export;
use crate::exportable_observer::Maps;
use crate::extension::{ExtensionMaps, SampledExtension};
use luenberger_expression::Routine;
use luenberger_observers::Observer;

/// States of the observer.
pub(super) fn order(observer: &SampledExtension<f64>) -> usize {
    Observer::<f64>::dimensions(observer.observer()).state
}

/// The functions of the observer; those of the plant are written before.
pub(super) fn functions(text: &mut String, export: &Export, maps: &ExtensionMaps) {
    let prefix = format!("{}_", export.identifier);
    let dialect = plant::dialect(export.scalar, &prefix);
    let all = [
        ("rate", "The right-hand side of the observer; its inputs are (u, y)", &maps.rate),
        ("estimate", "The estimate", &maps.estimate),
        ("start", "The state of the observer for an estimate; its inputs are y", &maps.start),
    ];
    for (name, what, routine) in all {
        plant::function(text, export, (name, what), routine, &dialect);
    }
    if let Some(jump) = &maps.jump {
        plant::function(
            text,
            export,
            ("jump", "The state after the jump at a sample; its inputs are (u, y)"),
            jump,
            &dialect,
        );
    }
}

/// The start: z from the first estimate and the output that it predicts.
pub(super) fn start(text: &mut String, export: &Export, (maps, own): (&Maps, &ExtensionMaps)) {
    let (name, number) = (&export.identifier, scalar(export));
    let (upper, _) = lengths(export);
    let n = format!("{upper}_STATES");
    let zero = crate::number::c(0.0, export.scalar);
    let needs_output = own.start.uses_inputs();
    let output = if needs_output {
        format!(
            "    {number} all[{}];\n{}",
            maps.measurement.len(),
            if maps.measurement.uses_inputs() {
                format!("    const {number} u[{upper}_INPUTS + 1] = {{ {zero} }};\n")
            } else {
                String::new()
            }
        )
    } else {
        String::new()
    };
    let inputs = if maps.measurement.uses_inputs() { "u" } else { "NULL" };
    let measure = if needs_output { format!("    measurement({zero}, xhat, {inputs}, all);\n") } else { String::new() };
    _ = write!(
        text,
        "
void {name}_init({name}_state *state, const {number} *xhat)
{{
{output}    int i;

{measure}    start({zero}, xhat, {all}, state->z);
    for (i = 0; i < {n}; ++i) {{
        state->xhat[i] = xhat[i];
    }}
{first}}}
",
        all = if needs_output { "all" } else { "NULL" },
        first = if export.observer.uses_time() { "    state->sample = 0;\n" } else { "" },
    );
}

pub(super) fn step(
    text: &mut String,
    export: &Export,
    observer: &SampledExtension<f64>,
    (maps, own): (&Maps, &ExtensionMaps),
) {
    let number = scalar(export);
    let (upper, _) = lengths(export);
    let [n, m, p] = ["STATES", "INPUTS", "OUTPUTS"].map(|what| format!("{upper}_{what}"));
    let order = order(observer);
    let size = export.observer.dimensions();
    let (all, known, measured) = (order + size.outputs, size.inputs + size.outputs, maps.measurement.len());
    // Unused parameters and variables are warnings.
    let (in_slope, at_end) = (own.rate.uses_inputs() || own.estimate.uses_inputs(), own.estimate.uses_inputs());
    let known_or = |is_used: bool| if is_used { "known" } else { "NULL" };
    let at_jump = own.jump.as_ref().is_some_and(Routine::uses_inputs);
    let gather = |is_used: bool| {
        if !is_used {
            return String::new();
        }
        let inputs = if size.inputs > 0 {
            format!("    for (i = 0; i < {m}; ++i) {{\n        known[i] = u[i];\n    }}\n")
        } else {
            String::new()
        };
        format!("{inputs}    for (i = 0; i < {p}; ++i) {{\n        known[{m} + i] = z[{order} + i];\n    }}\n")
    };
    let array = |is_used: bool| if is_used { format!("    {number} known[{known}];\n") } else { String::new() };
    _ = write!(
        text,
        "
/* The slopes of the state and of the predicted output, z = (state, w). */
static void slope({number} t, const {number} *z, const {number} *u, {number} *dz)
{{
{array}    {number} xhat[{n}];
    {number} f[{n}];
    {number} all[{measured}];
    int i;
    int j;

{gather}    estimate(t, z, {passed}, xhat);
    motion(t, xhat, u, f);
    measurement(t, xhat, u, all);
    rate(t, z, {passed}, dz);
    for (i = 0; i < {p}; ++i) {{
        {number} sum = all[{p} + (i * {n})] * f[0];
        for (j = 1; j < {n}; ++j) {{
            sum = sum + (all[{p} + (i * {n}) + j] * f[j]);
        }}
        dz[{order} + i] = sum;
    }}
}}
",
        array = array(in_slope),
        gather = gather(in_slope),
        passed = known_or(in_slope),
    );
    plant::runge_kutta(text, export, &all.to_string());
    let end = if own.estimate.uses_time() {
        let period = crate::number::c(export.scalar.round(export.observer.period()), export.scalar);
        format!("t + {period}")
    } else {
        "t".to_owned()
    };
    _ = write!(
        text,
        "
{head}
{{
{array}    {number} z[{all}];
{time}    int i;

    for (i = 0; i < {order}; ++i) {{
        z[i] = state->z[i];
    }}
    for (i = 0; i < {p}; ++i) {{
        z[{order} + i] = y[i];
    }}
",
        head = feedback::head(export),
        array = array(at_end || at_jump),
        time = super::time::time(export),
    );
    if let Some(jump) = &own.jump {
        let passed = known_or(jump.uses_inputs());
        _ = writeln!(text, "{}    jump(t, state->z, {passed}, z);", gather(at_jump));
    }
    _ = write!(
        text,
        "    move(t, u, z);
    for (i = 0; i < {order}; ++i) {{
        state->z[i] = z[i];
    }}
{gather}    estimate({end}, z, {passed}, state->xhat);
    if (xhat != NULL) {{
        for (i = 0; i < {n}; ++i) {{
            xhat[i] = state->xhat[i];
        }}
    }}
{tick}}}
",
        gather = gather(at_end),
        passed = known_or(at_end),
        tick = super::time::tick(export)
    );
}
