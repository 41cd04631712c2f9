//! The source: constants, start, step.

use std::fmt::Write;

use super::{cubic, feedback, lengths, linear, matrix, scalar};
use crate::program::Program;
use crate::{Export, number};

pub(super) fn source(export: &Export) -> String {
    let (name, number) = (&export.identifier, scalar(export));
    let (upper, _) = lengths(export);
    let n = format!("{upper}_STATES");
    let mut text = format!("/** @file {name}.c\n * See {name}.h. */\n#include \"{name}.h\"\n\n#include <float.h>\n");
    if matches!(export.program, Program::Cubic(_)) {
        text.push_str("#include <math.h>\n");
    }
    text.push_str(
        "#include <stddef.h>

#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0)
#error \"operations have to be rounded to their type: FLT_EVAL_METHOD must be 0\"
#endif

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

",
    );
    for (name, values) in export.matrices() {
        if values.ncols() > 0 {
            matrix(&mut text, export, name, &values);
        }
    }
    let initial: Vec<String> = export.initial.iter().map(|x| number::c(*x, export.scalar)).collect();
    _ = writeln!(text, "static const {number} INITIAL[{n}] = {{ {} }};", initial.join(", "));
    if matches!(export.program, Program::Cubic(_)) {
        cubic::flow(&mut text, export);
    }
    _ = write!(
        text,
        "
void {name}_init({name}_state *state, const {number} *xhat)
{{
    int i;
    for (i = 0; i < {n}; ++i) {{
        state->xhat[i] = xhat[i];
    }}
}}

void {name}_reset({name}_state *state)
{{
    {name}_init(state, INITIAL);
}}
"
    );
    match export.program {
        Program::Linear(_) | Program::Cubic(_) => linear::step(&mut text, export),
    }
    feedback::block(&mut text, export);
    text
}
