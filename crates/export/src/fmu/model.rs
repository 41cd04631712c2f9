//! `model.h` and `model.c`: the observer under the names that the wrapper uses, and the innovation.

use std::fmt::Write;

use crate::c;
use crate::number;
use crate::program::Scalar;
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
        "/* The observer under the names that the wrapper uses. */
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
/* y - C xhat - D u. */
void {name}_innovation(const {number} *xhat, const {number} *u, const {number} *y, {number} *innovation);

#endif
"
    );
    text
}

fn source(export: &Export) -> String {
    let (name, number, upper) = (&export.identifier, c::scalar(export), export.identifier.to_uppercase());
    let [n, m, p] = ["STATES", "INPUTS", "OUTPUTS"].map(|what| format!("{upper}_{what}"));
    let mut text = "#include \"model.h\"\n\n".to_owned();
    let matrices = export.matrices();
    let named = |wanted: &str| matrices.iter().find(|(name, values)| *name == wanted && values.ncols() > 0);
    for (name, values) in [named("C"), named("D")].into_iter().flatten() {
        c::matrix(&mut text, export, name, values);
    }
    _ = write!(
        text,
        "
void {name}_innovation(const {number} *xhat, const {number} *u, const {number} *y, {number} *innovation)
{{
    int i;
    int j;

"
    );
    c::product(&mut text, number, ("C", &p, &n), "xhat", "innovation[i] = y[i] - sum;");
    if named("D").is_some() {
        c::product(&mut text, number, ("D", &p, &m), "u", "innovation[i] = innovation[i] - sum;");
    } else {
        text.push_str("    (void)u;\n");
    }
    text.push_str("}\n");
    text
}
