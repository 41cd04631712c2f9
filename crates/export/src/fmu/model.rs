//! `model.h` and `model.c`: the observer under the names that the wrapper uses, and the innovation.

use std::fmt::Write;

use luenberger_expression::Columns;
use luenberger_observers::MatrixName;

use crate::c;
use crate::c::kernels::{self, Macros};
use crate::error::ExportError;
use crate::scalar::Scalar;
use crate::{Export, ExportedMatrix, File, number, program};

pub(super) fn files(export: &Export, token: &str, period: f64) -> Result<Vec<File>, ExportError> {
    let file = |name: &str, text| File { name: name.to_owned(), text };
    Ok(vec![file("model.h", header(export, token, period)), file("model.c", source(export)?)])
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
#define MODEL_TIMED {}
#define MODEL_INITIAL {{ {} }}

typedef {number} model_number;
typedef {name}_state model_state;

#define model_init {name}_init
#define model_step {name}_step
#define model_innovation {name}_innovation
",
        number::c(period, Scalar::Binary64),
        u8::from(fed),
        u8::from(export.observer.uses_time()),
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

fn source(export: &Export) -> Result<String, ExportError> {
    let includes =
        "#include <math.h>\n#include <stdbool.h>\n#include <stddef.h>\n#include <stdint.h>\n#include <string.h>\n";
    let mut text = format!("#include \"model.h\"\n\n{includes}\n");
    for (which, values) in export.matrices() {
        let is_of_output = [MatrixName::C, MatrixName::D].map(ExportedMatrix::from).contains(&which);
        if is_of_output && values.ncols() > 0 {
            c::matrix(&mut text, export, which.name(), &values);
        }
    }
    let program = program::innovation(export)?;
    c::recorded::called(&mut text, export, &program, "model_");
    let size = export.observer.dimensions();
    let (inputs, results) = ([("u", size.inputs), ("y", size.outputs)], [("innovation", size.outputs)]);
    let about = ("output_error", "Measured minus expected output");
    let columns = Columns { inputs: &inputs, results: &results };
    c::recorded::function(&mut text, export, about, &program, ("model_", columns));
    Macros::of(export).write(&mut text, kernels::OUTPUT_ERROR);
    Ok(text)
}
