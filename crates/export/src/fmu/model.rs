//! `model.h` and `model.c`: the observer under the names that the wrapper uses, and the innovation.

use std::fmt::Write;

use crate::c;
use crate::number;
use crate::scalar::Scalar;
use crate::{Export, File};

pub(super) fn files(export: &Export, token: &str, period: f64) -> Vec<File> {
    let file = |name: &str, text| File { name: name.to_owned(), text };
    vec![file("model.h", header(export, token, period)), file("model.c", source(export))]
}

fn header(export: &Export, token: &str, period: f64) -> String {
    let (name, number, upper) = (&export.identifier, c::scalar(export), export.identifier.to_uppercase());
    let initial: Vec<String> = export.initial.iter().map(|x| number::c(*x, Scalar::Binary64)).collect();
    let fed = export.feedback.is_some();
    let mut text = format!(
        "/* The observer under the names that the wrapper uses. This file belongs to whoever generated it. */
#ifndef MODEL_H
#define MODEL_H

#include \"{name}.h\"

#define MODEL_TOKEN \"{token}\"
#define MODEL_PERIOD {} /* seconds */
#define MODEL_STATES {upper}_STATES
#define MODEL_INPUTS {upper}_INPUTS
#define MODEL_OUTPUTS {upper}_OUTPUTS
#define MODEL_FEEDBACK {}
#define MODEL_INITIAL {{ {} }}

typedef {number} model_number;
typedef {name}_state model_state;

#define model_init {name}_init
#define model_step {name}_step
#define model_innovation {name}_innovation
",
        number::c(period, Scalar::Binary64),
        u8::from(fed),
        initial.join(", "),
    );
    if fed {
        _ = writeln!(text, "#define model_input {name}_input");
    }
    _ = write!(
        text,
        "
/* Measured minus expected output. */
void {name}_innovation(const {name}_state *state, const {number} *u, const {number} *y, {number} *innovation);

#endif
"
    );
    text
}

fn source(export: &Export) -> String {
    let (name, number, upper) = (&export.identifier, c::scalar(export), export.identifier.to_uppercase());
    let [n, m, p] = ["STATES", "INPUTS", "OUTPUTS"].map(|what| format!("{upper}_{what}"));
    let mut text = "#include \"model.h\"\n\n".to_owned();
    let head = format!(
        "
void {name}_innovation(const {name}_state *state, const {number} *u, const {number} *y, {number} *innovation)
{{
"
    );
    if let Some(maps) = export.observer.maps() {
        text.push_str(
            "#include <math.h>\n#include <stdbool.h>\n#include <stddef.h>\n#include <stdint.h>\n#include <string.h>\n",
        );
        c::plant::measurement(&mut text, export, &maps);
        let time = c::time::time(export);
        _ = write!(
            text,
            "{head}    {number} all[{}];
{time}    int i;

    measurement(t, state->xhat, u, all);
    for (i = 0; i < {p}; ++i) {{
        innovation[i] = y[i] - all[i];
    }}
}}
",
            maps.measurement.len(),
        );
        return text;
    }
    let matrices = export.matrices();
    let named = |wanted: &str| matrices.iter().find(|(name, values)| *name == wanted && values.ncols() > 0);
    for (name, values) in [named("C"), named("D")].into_iter().flatten() {
        c::matrix(&mut text, export, name, values);
    }
    _ = write!(text, "{head}    int i;\n    int j;\n\n");
    let xhat = if export.is_filter() { "state->prediction" } else { "state->xhat" };
    c::product(&mut text, number, ("C", &p, &n), xhat, "innovation[i] = y[i] - sum;");
    if named("D").is_some() {
        c::product(&mut text, number, ("D", &p, &m), "u", "innovation[i] = innovation[i] - sum;");
    } else {
        text.push_str("    (void)u;\n");
    }
    text.push_str("}\n");
    text
}
