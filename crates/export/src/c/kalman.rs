//! The step of the extended Kalman filter: update in Joseph's form, then prediction.

use std::fmt::Write;

use super::plant::{self, Arguments, contraction, index};
use super::transition::Transition;
use super::{feedback, is_finite, lengths, root, scalar};
use crate::exportable_observer::Maps;
use crate::{Export, number};

pub(super) fn step(text: &mut String, export: &Export, maps: &Maps, (substeps, gated): (Option<usize>, bool)) {
    let number = scalar(export);
    let (upper, _) = lengths(export);
    let [n, p] = ["STATES", "OUTPUTS"].map(|what| format!("{upper}_{what}"));
    plant::functions(text, export, maps);
    symmetrise(text, export, &n);
    update(text, export, maps, (&n, &p), gated);
    let (forward, measured) = (Arguments::of(maps, false), arguments_of_measurement(maps));
    let transition = Transition::new(export, ("motion", &maps.motion), forward, &n);
    match substeps {
        Some(substeps) => transition.linearise(text, substeps),
        None => transition.linearise_discrete(text),
    }
    transition.spread(text);
    _ = write!(
        text,
        "
{head}
{{
    {number} z[{length}];
    {number} next[{n}][{n}];
{time}    int is_right = 1;
    int i;
    int j;

{unused}    update(state, {measured}y);
    linearise({forward}state->xhat, z);
    spread(&state->P[0][0], z, &next[0][0]);
    for (i = 0; i < {n}; ++i) {{
        if (!({finite_estimate})) {{
            is_right = 0;
        }}
        for (j = 0; j < {n}; ++j) {{
            if (!({finite_covariance})) {{
                is_right = 0;
            }}
        }}
    }}
    for (i = 0; i < {n}; ++i) {{
        state->xhat[i] = (is_right != 0) ? z[i] : ({number})NAN;
        for (j = 0; (j < {n}) && (is_right != 0); ++j) {{
            state->P[i][j] = next[i][j];
        }}
    }}
    if (xhat != NULL) {{
        for (i = 0; i < {n}; ++i) {{
            xhat[i] = state->xhat[i];
        }}
    }}
{tick}}}
",
        head = feedback::head(export),
        length = transition.length(),
        time = super::time::time(export),
        unused = if forward.inputs.or(measured.inputs).is_some() { "" } else { "    (void)u;\n" },
        measured = measured.arguments("t"),
        forward = forward.arguments("t"),
        finite_estimate = is_finite(export, "z[i]"),
        finite_covariance = is_finite(export, "next[i][j]"),
        tick = super::time::tick(export),
    );
}

fn arguments_of_measurement(maps: &Maps) -> Arguments {
    Arguments { time: maps.measurement.uses_time(), inputs: maps.measurement.uses_inputs().then_some("u") }
}

/// Parameters after others.
pub(super) fn trailing_parameters(arguments: Arguments, number: &str) -> String {
    let list = arguments.parameters(number);
    if list.is_empty() { list } else { format!(", {}", list.trim_end_matches(", ")) }
}

/// Arguments after others.
pub(super) fn trailing(arguments: Arguments, t: &str) -> String {
    let list = arguments.arguments(t);
    if list.is_empty() { list } else { format!(", {}", list.trim_end_matches(", ")) }
}

pub(super) fn symmetrise(text: &mut String, export: &Export, n: &str) {
    let number = scalar(export);
    let half = number::c(0.5, export.scalar);
    _ = write!(
        text,
        "
/* The symmetric part of P, by rows. */
static void symmetrise({number} *P)
{{
    int i;
    int j;
    for (i = 1; i < {n}; ++i) {{
        for (j = 0; j < i; ++j) {{
            const {number} mean = (P[(i * {n}) + j] + P[(j * {n}) + i]) * {half};
            P[(i * {n}) + j] = mean;
            P[(j * {n}) + i] = mean;
        }}
    }}
}}
"
    );
}

fn update(text: &mut String, export: &Export, maps: &Maps, (n, p): (&str, &str), gated: bool) {
    let (name, number) = (&export.identifier, scalar(export));
    let literal = |x: f64| number::c(x, export.scalar);
    let (zero, one) = (literal(0.0), literal(1.0));
    let v = if gated { "noise" } else { "V" };
    let entry = |row: &str, column: &str| format!("all[{}]", index(p, (row, column), n));
    let mut covariances = String::new();
    let hp = |k: &str| format!("{} * state->P[{k}][j]", entry("i", k));
    contraction(&mut covariances, number, (p, n, n), hp, "hp[i][j] = sum;");
    let s = |k: &str| format!("hp[i][{k}] * {}", entry("j", k));
    contraction(&mut covariances, number, (p, p, n), s, &format!("s[i][j] = sum + {v}[i][j];"));
    let arguments = arguments_of_measurement(maps);
    let measurement = plant::call("measurement", &maps.measurement, ("t", "state->xhat", "all"));
    _ = write!(
        text,
        "
/* The measurement update, in Joseph's form. The estimate stays as it is where there is no result: y is not finite, the
 * covariance of the innovation is not positive definite in floating point, or a number overflows. */
static void update({name}_state *state, {parameters}const {number} *y)
{{
    {number} all[{}];
    {number} innovation[{p}];
    {number} hp[{p}][{n}];
    {number} s[{p}][{p}];
    {number} keep[{n}][{n}];
    {number} kp[{n}][{n}];
    {number} next[{n}][{n}];
    {number} kv[{n}][{p}];
",
        maps.measurement.len(),
        parameters = arguments.parameters(number),
    );
    if gated {
        _ = writeln!(text, "    {number} noise[{p}][{p}];");
    }
    _ = write!(
        text,
        "    int definite = 1;
    int i;
    int j;
    int k;

    {measurement}
    for (i = 0; i < {p}; ++i) {{
        innovation[i] = y[i] - all[i];
    }}
"
    );
    if gated {
        gate(text, export, (n, p), &covariances);
    }
    text.push_str(&covariances);
    _ = write!(
        text,
        "    for (i = 0; i < {p}; ++i) {{
        for (j = 0; j < {p}; ++j) {{
            if (!({finite})) {{
                definite = 0;
            }}
        }}
    }}
    /* s = g g', the factor in place of the lower triangle. */
",
        finite = is_finite(export, "s[i][j]"),
    );
    factor(text, export, p);
    text.push_str("    if (definite != 0) {\n");
    let mut rest = String::new();
    _ = write!(
        rest,
        "    {number} gain[{p}][{n}]; /* transposed */
    {number} estimate[{n}];
    for (j = 0; j < {n}; ++j) {{
        for (i = 0; i < {p}; ++i) {{
            {number} entry = hp[i][j];
            for (k = 0; k < i; ++k) {{
                entry = entry - (s[i][k] * gain[k][j]);
            }}
            gain[i][j] = entry / s[i][i];
        }}
        for (i = {p} - 1; i >= 0; --i) {{
            {number} entry = gain[i][j];
            for (k = i + 1; k < {p}; ++k) {{
                entry = entry - (s[k][i] * gain[k][j]);
            }}
            gain[i][j] = entry / s[i][i];
        }}
    }}
"
    );
    let kh = |k: &str| format!("gain[{k}][i] * {}", entry(k, "j"));
    contraction(&mut rest, number, (n, n, p), kh, &format!("keep[i][j] = ((i == j) ? {one} : {zero}) - sum;"));
    _ = write!(
        rest,
        "    for (i = 0; i < {n}; ++i) {{
        {number} sum = gain[0][i] * innovation[0];
        for (k = 1; k < {p}; ++k) {{
            sum = sum + (gain[k][i] * innovation[k]);
        }}
        estimate[i] = state->xhat[i] + sum;
    }}
"
    );
    let product = |k: &str| format!("keep[i][{k}] * state->P[{k}][j]");
    contraction(&mut rest, number, (n, n, n), product, "kp[i][j] = sum;");
    let product = |k: &str| format!("kp[i][{k}] * keep[j][{k}]");
    contraction(&mut rest, number, (n, n, n), product, "next[i][j] = sum;");
    let product = |k: &str| format!("gain[{k}][i] * {v}[{k}][j]");
    contraction(&mut rest, number, (n, p, p), product, "kv[i][j] = sum;");
    let product = |k: &str| format!("kv[i][{k}] * gain[{k}][j]");
    contraction(&mut rest, number, (n, n, p), product, "next[i][j] = next[i][j] + sum;");
    _ = write!(
        rest,
        "    symmetrise(&next[0][0]);
    for (i = 0; i < {n}; ++i) {{
        if (!({finite_estimate})) {{
            definite = 0;
        }}
        for (j = 0; j < {n}; ++j) {{
            if (!({finite_covariance})) {{
                definite = 0;
            }}
        }}
    }}
    for (i = 0; (i < {n}) && (definite != 0); ++i) {{
        state->xhat[i] = estimate[i];
        for (j = 0; j < {n}; ++j) {{
            state->P[i][j] = next[i][j];
        }}
    }}
",
        finite_estimate = is_finite(export, "estimate[i]"),
        finite_covariance = is_finite(export, "next[i][j]"),
    );
    for line in rest.lines() {
        _ = writeln!(text, "    {line}");
    }
    text.push_str("    }\n}\n");
}

/// The factor of s in place of its lower triangle; `definite` becomes 0 where a pivot is not positive.
pub(super) fn factor(text: &mut String, export: &Export, p: &str) {
    let (number, root, zero) = (scalar(export), root(export), number::c(0.0, export.scalar));
    _ = write!(
        text,
        "    for (j = 0; (j < {p}) && (definite != 0); ++j) {{
        for (i = j; (i < {p}) && (definite != 0); ++i) {{
            {number} entry = s[i][j];
            for (k = 0; k < j; ++k) {{
                entry = entry - (s[i][k] * s[j][k]);
            }}
            if (i > j) {{
                s[i][j] = entry / s[j][j];
            }} else if (entry > {zero}) {{
                s[j][j] = {root}(entry);
            }} else {{
                definite = 0;
            }}
        }}
    }}
"
    );
}

/// Outputs whose innovation is beyond the gate, or NaN, count as not measured.
fn gate(text: &mut String, export: &Export, (n, p): (&str, &str), covariances: &str) {
    let literal = |x: f64| number::c(x, export.scalar);
    let (zero, one) = (literal(0.0), literal(1.0));
    let gate = export.scalars().iter().find(|(name, _)| *name == "GATE").map_or(0.0, |(_, gate)| *gate);
    let square = literal(export.scalar.multiply(gate, gate));
    _ = write!(
        text,
        "    for (i = 0; i < {p}; ++i) {{
        for (j = 0; j < {p}; ++j) {{
            noise[i][j] = V[i][j];
        }}
    }}
{covariances}    for (i = 0; i < {p}; ++i) {{
        if (!((innovation[i] * innovation[i]) <= ({square} * s[i][i]))) {{
            innovation[i] = {zero};
            for (j = 0; j < {n}; ++j) {{
                all[{p} + (i * {n}) + j] = {zero};
            }}
            for (j = 0; j < {p}; ++j) {{
                noise[i][j] = {zero};
                noise[j][i] = {zero};
            }}
            noise[i][i] = {one};
        }}
    }}
"
    );
}
