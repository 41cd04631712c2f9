//! The test with golden vectors.

use std::fmt::Write;

use super::{Call, lengths, scalar};
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
    let inputs = export.observer.plant_inputs();
    table(if fed { "r" } else { "u" }, &|step| step.u[..inputs].to_vec());
    table("y", &|step| step.y.clone());
    table("dt", &|step| step.u[inputs..].to_vec());
    table("expected", &|step| step.estimate.clone());
    table("applied", &|step| step.applied.clone());
    let call = Call::of(export);
    let known = if call.known == "0" { "0".to_owned() } else { format!("{}[k]", call.known) };
    let elapsed = if call.elapsed.is_empty() { "" } else { "dt[k][0], " };
    let declared = if fed { format!("    {number} u[{upper}_INPUTS];\n") } else { String::new() };
    let applied = if fed {
        format!("        count += compare(k, \"u\", u, applied[k], {upper}_INPUTS);\n")
    } else {
        String::new()
    };
    _ = write!(
        text,
        "
{compare}int main(void)
{{
    {name}_state state;
    {number} xhat[{upper}_STATES];
{declared}    int k;
    int wrong = 0;

    {name}_reset(&state);
    for (k = 0; k < {count}; ++k) {{
        int count = 0;

        {name}_step(&state, {known}, y[k], {more}{elapsed}xhat);
        count += compare(k, \"xhat\", xhat, expected[k], {upper}_STATES);
{applied}        wrong += (count > 0) ? 1 : 0;
    }}
    printf(\"{name}: %d of {count} steps agree to the last bit\\n\", {count} - wrong);
    if (wrong > 0) {{
        printf(\"{name}: largest relative difference %g\\n\", largest);
    }}
    return (wrong == 0) ? 0 : 1;
}}
",
        compare = comparison(number),
        more = call.applied,
        count = steps.len()
    );
    text
}

/// What compares a column with the one that is expected, and the largest relative difference.
pub(super) fn comparison(number: &str) -> String {
    // Bits of numbers with a point, and integers.
    let (form, cast) = if number == "int32_t" { ("%ld", "long") } else { ("%a", "double") };
    format!(
        "static double largest = 0.0; /* The largest relative difference. */

/* 1 if an entry differs from what is expected; says which, with its values. */
static int compare(int step, const char *what, const {number} *found, const {number} *wanted, int length)
{{
    int differs = 0;
    int i;

    for (i = 0; i < length; ++i) {{
        if (memcmp(&found[i], &wanted[i], sizeof found[i]) != 0) {{
            const double size = (wanted[i] < 0) ? -(double)wanted[i] : (double)wanted[i];
            double apart = (double)found[i] - (double)wanted[i];

            apart = (apart < 0.0) ? -apart : apart;
            apart = (size > 0.0) ? (apart / size) : apart;
            if (apart > largest) {{
                largest = apart;
            }}
            printf(\"step %d, %s[%d]: {form}, expected {form}\\n\", step, what, i, ({cast})found[i], ({cast})wanted[i]);
            differs = 1;
        }}
    }}
    return differs;
}}

"
    )
}
