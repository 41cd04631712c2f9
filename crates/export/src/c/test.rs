//! The test with golden vectors.

use std::fmt::Write;

use super::{Call, lengths, scalar};
use crate::golden::Step;
use crate::scalar::Scalar;
use crate::{Export, number};

pub(crate) fn test(export: &Export, steps: &[Step]) -> String {
    let (name, number) = (&export.identifier, scalar(export));
    let (upper, _) = lengths(export);
    let of_target = export.calls_target();
    let how = if of_target { "to half of the digits" } else { "bit by bit" };
    let mut text = format!(
        "/* Golden vectors: {} steps of the design, compared {how}. Exit code 0 if all agree. */\n#include \"{name}.h\"\n\n#include <stdio.h>\n#include <string.h>\n\n",
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
    let mut sizes = ["", ""];
    if of_target {
        sizes = [", sizes_expected", ", sizes_applied"];
        largest(&mut text, "expected", steps.iter().map(|step| &step.estimate));
        if fed {
            largest(&mut text, "applied", steps.iter().map(|step| &step.applied));
        }
    }
    let applied = if fed {
        format!("        count += compare(k, \"u\", u, applied[k], {upper}_INPUTS{});\n", sizes[1])
    } else {
        String::new()
    };
    let (declared, started, halves) = match halves(export, &known, elapsed, sizes[0]) {
        Some(halves) => (
            format!("{declared}    {name}_state halves; /* The same by its halves. */\n"),
            format!("    {name}_reset(&halves);\n"),
            halves,
        ),
        None => (declared, String::new(), String::new()),
    };
    let agree = if of_target { "to half of the digits" } else { "to the last bit" };
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
{started}    for (k = 0; k < {count}; ++k) {{
        int count = 0;

        {name}_step(&state, {known}, y[k], {more}{elapsed}xhat);
        count += compare(k, \"xhat\", xhat, expected[k], {upper}_STATES{expected});
{halves}{applied}        wrong += (count > 0) ? 1 : 0;
    }}
    printf(\"{name}: %d of {count} steps agree {agree}\\n\", {count} - wrong);
    if (wrong > 0) {{
        printf(\"{name}: largest relative difference %g\\n\", largest);
    }}
    return (wrong == 0) ? 0 : 1;
}}
",
        compare = comparison(number, of_target.then(|| tolerance(export.scalar))),
        more = call.applied,
        count = steps.len(),
        expected = sizes[0],
    );
    text
}

/// The step by update and prediction, compared with the same numbers; none where it does not have them apart.
fn halves(export: &Export, known: &str, elapsed: &str, sizes: &str) -> Option<String> {
    if !export.has_halves() {
        return None;
    }
    let (name, upper) = (&export.identifier, lengths(export).0);
    let compared =
        format!("        count += compare(k, \"xhat by halves\", halves.xhat, expected[k], {upper}_STATES{sizes});\n");
    let more = elapsed.trim_end_matches(", ");
    let more = if more.is_empty() { String::new() } else { format!(", {more}") };
    let update = format!("        {name}_update(&halves, {known}, y[k]{more});\n");
    let predict = format!("        {name}_predict(&halves, {known}{more});\n");
    Some(if export.observer.takes_time() {
        predict + &update + &compared
    } else if export.is_filter() {
        update + &compared + &predict
    } else {
        update + &predict + &compared
    })
}

/// What compares a column with the one that is expected, and the largest relative difference: by its bits, or within a
/// tolerance times the size of each entry.
pub(super) fn comparison(number: &str, tolerance: Option<f64>) -> String {
    // Bits of numbers with a point, and integers.
    let (form, cast) = if number == "int32_t" { ("%ld", "long") } else { ("%a", "double") };
    let (within, parameter, differ) = match tolerance {
        None => (String::new(), "", "memcmp(&found[i], &wanted[i], sizeof found[i]) != 0".to_owned()),
        Some(tolerance) => {
            let within = format!(
                "/* Whether the numbers are so near. */
static int within({number} found, {number} wanted, double limit)
{{
    const double apart = (double)found - (double)wanted;

    return (apart <= limit) && (-apart <= limit);
}}

"
            );
            (within, ", const double *sizes", format!("!within(found[i], wanted[i], {tolerance:?} * sizes[i])"))
        }
    };
    format!(
        "static double largest = 0.0; /* The largest relative difference. */

{within}/* 1 if an entry differs from what is expected; says which, with its values. */
static int compare(int step, const char *what, const {number} *found, const {number} *wanted, int length{parameter})
{{
    int differs = 0;
    int i;

    for (i = 0; i < length; ++i) {{
        if ({differ}) {{
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

/// Half of the digits of the format.
fn tolerance(scalar: Scalar) -> f64 {
    match scalar {
        Scalar::Binary32 => f64::from(f32::EPSILON),
        Scalar::Binary64 => f64::EPSILON,
    }
    .sqrt()
}

/// The largest magnitude of each entry of some columns.
fn largest<'a>(text: &mut String, what: &str, columns: impl Iterator<Item = &'a Vec<f64>>) {
    let most = columns.fold(Vec::new(), |mut most: Vec<f64>, column| {
        most.resize(column.len(), 0.0);
        most.iter_mut().zip(column).for_each(|(most, x)| *most = most.max(x.abs()));
        most
    });
    let list: Vec<String> = most.iter().map(|x| format!("{x:?}")).collect();
    _ = writeln!(text, "static const double sizes_{what}[{}] = {{ {} }};", list.len(), list.join(", "));
}
