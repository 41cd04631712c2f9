//! The test with golden vectors.

use std::fmt::Write;

use super::{lengths, scalar};
use crate::golden::Step;
use crate::{Export, number};

pub(crate) fn test(export: &Export, steps: &[Step]) -> String {
    let (name, number) = (&export.identifier, scalar(export));
    let (upper, _) = lengths(export);
    let mut text = format!(
        "/* Golden vectors: {} steps of the design, compared bit by bit. Exit code 0 if all agree. */\n#include \"{name}.h\"\n\n#include <stdio.h>\n#include <string.h>\n\n",
        steps.len()
    );
    let mut table = |what: &str, of: &dyn Fn(&Step) -> Vec<f64>| {
        let width = steps.first().map_or(0, |step| of(step).len());
        if width == 0 {
            return;
        }
        _ = writeln!(text, "static const {number} {what}[{}][{width}] = {{", steps.len());
        for step in steps {
            let row: Vec<String> = of(step).iter().map(|x| number::c(*x, export.scalar)).collect();
            _ = writeln!(text, "    {{ {} }},", row.join(", "));
        }
        text.push_str("};\n");
    };
    let fed = export.feedback.is_some();
    let (is_varying, inputs) = (export.observer.takes_time(), export.observer.plant_inputs());
    table(if fed { "r" } else { "u" }, &|step| step.u[..inputs].to_vec());
    table("y", &|step| step.y.clone());
    table("dt", &|step| step.u[inputs..].to_vec());
    table("expected", &|step| step.estimate.clone());
    table("applied", &|step| step.applied.clone());
    let known = match (fed, export.names.inputs.is_empty()) {
        (true, _) => "r[k]",
        (false, true) => "0",
        (false, false) => "u[k]",
    };
    let (declared, more, compared) = if fed {
        let compared = " || (memcmp(u, applied[k], sizeof u) != 0)";
        (format!("    {number} u[{upper}_INPUTS];\n"), "u, ", compared)
    } else {
        (String::new(), if is_varying { "dt[k][0], " } else { "" }, "")
    };
    _ = write!(
        text,
        "
int main(void)
{{
    {name}_state state;
    {number} xhat[{upper}_STATES];
{declared}    int k;
    int wrong = 0;

    {name}_reset(&state);
    for (k = 0; k < {count}; ++k) {{
        {name}_step(&state, {known}, y[k], {more}xhat);
        if ((memcmp(xhat, expected[k], sizeof xhat) != 0){compared}) {{
            printf(\"step %d differs: %a, expected %a\\n\", k, (double)xhat[0], (double)expected[k][0]);
            ++wrong;
        }}
    }}
    printf(\"{name}: %d of {count} steps agree to the last bit\\n\", {count} - wrong);
    return (wrong == 0) ? 0 : 1;
}}
",
        count = steps.len()
    );
    text
}
