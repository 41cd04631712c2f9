//! The test with golden vectors.

use std::fmt::Write;

use super::{lengths, scalar};
use crate::golden::Step;
use crate::{Export, number};

pub(super) fn test(export: &Export, steps: &[Step]) -> String {
    let (name, number) = (&export.identifier, scalar(export));
    let (upper, _) = lengths(export);
    let mut text = format!(
        "/* Golden vectors: {} steps of the design, compared bit by bit. Exit code 0 if all agree. */\n#include \"{name}.h\"\n\n#include <stdio.h>\n#include <string.h>\n\n",
        steps.len()
    );
    let mut table = |what: &str, of: fn(&Step) -> &Vec<f64>| {
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
    table("u", |step| &step.u);
    table("y", |step| &step.y);
    table("expected", |step| &step.estimate);
    let u = if export.names.inputs.is_empty() { "0" } else { "u[k]" };
    _ = write!(
        text,
        "
int main(void)
{{
    {name}_state state;
    {number} xhat[{upper}_STATES];
    int k;
    int wrong = 0;

    {name}_reset(&state);
    for (k = 0; k < {count}; ++k) {{
        {name}_step(&state, {u}, y[k], xhat);
        if (memcmp(xhat, expected[k], sizeof xhat) != 0) {{
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
