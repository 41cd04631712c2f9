//! A linear observer in fixed point: header, source, test and README.

use std::fmt::Write;

use luenberger_observers::FixedPointFormats;
use nalgebra::DMatrix;

use super::kernels::{self, Macros};
use super::project::cmake;
use super::test::comparison;
use super::{Layout, columns, harmless, lengths, macros, wrapped};
use crate::File;
use crate::error::ExportError;
use crate::fixed_point::{FixedPointExport, PARTIAL_EVERY, name};

impl FixedPointExport<'_> {
    /// The files of [`c`](Self::c) in the folders that a build system expects, as
    /// [`Export::c_in`](crate::Export::c_in).
    ///
    /// # Errors
    /// [`ExportError::TimeUnit`] and [`ExportError::Period`].
    pub fn c_in(&self, layout: Layout) -> Result<Vec<File>, ExportError> {
        layout.place(self.design, self.c(), "int32_t")
    }

    /// The files of a C99 project: header, source, test with golden vectors, `CMakeLists.txt` and `README.md`.
    pub fn c(&self) -> Vec<File> {
        let name = &self.design.identifier;
        let file = |name: String, text: String| File { name, text };
        vec![
            file(format!("{name}.h"), header(self)),
            file(format!("{name}.c"), source(self)),
            file(format!("test_{name}.c"), test(self)),
            file("CMakeLists.txt".to_owned(), cmake(name)),
            file("README.md".to_owned(), readme(self)),
        ]
    }
}

/// What the numbers are, and how they are computed.
fn arithmetic(export: &FixedPointExport<'_>) -> String {
    let FixedPointFormats { gains, signals } = export.observer.formats();
    let (whole, part) = (signals.integer_bits() - 1, signals.fraction_bits());
    let stored = if gains == signals { String::new() } else { format!(" The gains are stored in {}.", name(gains)) };
    format!(
        "Numbers: int32_t, {}: the integer of a number x is x 2^{part}, rounded.{stored} One step takes {} products, \
         which are accumulated in 64 bits without rounding; the sums cannot overflow, whatever u, y and xhat are. Each \
         sum is rounded once, to nearest, ties upwards: an error of at most 2^-{}. A result beyond the range from -2^{whole} \
         to 2^{whole} - 2^-{part} becomes the end of the range, and is counted in saturations.",
        name(signals),
        export.products(),
        part + 1,
    )
}

fn header(export: &FixedPointExport<'_>) -> String {
    let design = export.design;
    let (id, names) = (&design.identifier, &design.names);
    let (upper, _) = lengths(design);
    let mut text =
        format!("/**\n * @file {id}.h\n * @brief {} in fixed point, one step per sample.\n *\n", design.kind());
    let unit = if names.time_unit.is_empty() { String::new() } else { format!(" {}", harmless(&names.time_unit)) };
    _ = writeln!(text, " * Period:  {}{unit}", design.observer.period());
    _ = writeln!(text, " * States:  {}", columns(&names.states, &names.units));
    _ = writeln!(text, " * Inputs:  {}", columns(&names.inputs, &names.input_units));
    _ = writeln!(text, " * Outputs: {}", columns(&names.outputs, &names.output_units));
    let sentences = [arithmetic(export)].into_iter().chain(design.statement.iter().cloned());
    for sentence in sentences {
        text.push_str(" *\n");
        for line in wrapped(&harmless(&sentence), 100) {
            _ = writeln!(text, " * {line}");
        }
    }
    text.push_str(" *\n");
    for line in design.digests_with(&export.digest()) {
        _ = writeln!(text, " * {}", harmless(&line));
    }
    text.push_str(" *\n * This file belongs to whoever generated it.\n */\n");
    _ = writeln!(
        text,
        "#ifndef {upper}_H\n#define {upper}_H\n\n#include <stdint.h>\n\n#ifdef __cplusplus\nextern \"C\" {{\n#endif\n"
    );
    text.push_str(&macros(design, &export.digest()));
    let unread = if names.inputs.is_empty() { "; not read, may be a null pointer" } else { "" };
    _ = write!(
        text,
        "#define {upper}_FRACTION_BITS {}

/** State of the observer. */
typedef struct {{
    int32_t xhat[{upper}_STATES]; /**< Estimate for the next sample. */
    uint32_t saturations; /**< Results cut off at an end of the range since the start; stays at its largest value. */
}} {id}_state;

/** Starts from a given estimate. */
void {id}_init({id}_state *state, const int32_t *xhat);

/** Starts from the first estimate of the design. */
void {id}_reset({id}_state *state);

/**
 * One step, from the sample at t to the estimate at t + period. All numbers are integers, x 2^{upper}_FRACTION_BITS.
 *
 * @param state  State, read and written.
 * @param u      Inputs held from this sample to the next, {upper}_INPUTS entries{}.
 * @param y      Outputs measured at this sample, {upper}_OUTPUTS entries.
 * @param xhat   Estimate for the next sample, {upper}_STATES entries; may be a null pointer.
 */
void {id}_step({id}_state *state, const int32_t *u, const int32_t *y, int32_t *xhat);

/**
 * The same of a sample of which some outputs are missing, since integers have no NAN: their columns of the gain are left
 * out, and the others correct as they always do. Nothing is proved of such a sample, nor that nothing saturates; what is
 * proved of convergence holds anew after the last one, from the error that there is then.
 *
 * @param state     State, read and written.
 * @param u         Inputs held from this sample to the next, {upper}_INPUTS entries{}.
 * @param y         Outputs measured at this sample, {upper}_OUTPUTS entries; missing ones are not read.
 * @param measured  0 for an output that is missing, {upper}_OUTPUTS entries; a null pointer if none is.
 * @param xhat      Estimate for the next sample, {upper}_STATES entries; may be a null pointer.
 */
void {id}_step_partial({id}_state *state, const int32_t *u, const int32_t *y, const uint8_t *measured,
                       int32_t *xhat);

#ifdef __cplusplus
}}
#endif

#endif
",
        export.observer.formats().signals.fraction_bits(),
        unread,
        unread,
    );
    text
}

/// A constant of C; the smallest integer has no literal.
fn literal(x: i32) -> String {
    if x == i32::MIN { "(-2147483647 - 1)".to_owned() } else { x.to_string() }
}

fn matrix(text: &mut String, name: &str, m: &DMatrix<i32>) {
    _ = writeln!(text, "static const int32_t {name}[{}][{}] = {{", m.nrows(), m.ncols());
    for row in m.row_iter() {
        let row: Vec<String> = row.iter().map(|x| literal(*x)).collect();
        _ = writeln!(text, "    {{ {} }},", row.join(", "));
    }
    text.push_str("};\n");
}

fn source(export: &FixedPointExport<'_>) -> String {
    let design = export.design;
    let id = &design.identifier;
    let n = format!("{}_STATES", id.to_uppercase());
    let FixedPointFormats { gains, signals } = export.observer.formats();
    let one = 1_i64 << gains.fraction_bits();
    let mut text = format!("/** @file {id}.c\n * See {id}.h. */\n#include \"{id}.h\"\n\n#include <stddef.h>\n\n");
    _ = write!(
        text,
        "/* The gains are their numbers times this. */
static const int64_t ONE = {one};
static const int64_t HALF = {};
static const int64_t GREATEST = {};
static const int64_t SMALLEST = {};
",
        one / 2,
        signals.largest(),
        literal(signals.smallest()),
    );
    for (which, values) in export.matrices() {
        if values.ncols() > 0 {
            matrix(&mut text, which.name(), values);
        }
    }
    let initial: Vec<String> = export.initial.iter().map(|x| literal(*x)).collect();
    _ = writeln!(text, "static const int32_t INITIAL[{n}] = {{ {} }};", initial.join(", "));
    Macros::of(design).write(&mut text, kernels::FIXED_POINT);
    text
}

fn test(export: &FixedPointExport<'_>) -> String {
    let steps = export.golden(export.design.test_steps);
    let (id, names) = (&export.design.identifier, &export.design.names);
    let (upper, _) = lengths(export.design);
    let count = steps.len();
    let mut text = format!(
        "/* Golden vectors: {count} steps of the design, compared bit by bit. Exit code 0 if all agree. */\n#include \"{id}.h\"\n\n#include <stdio.h>\n#include <string.h>\n\n"
    );
    let rows = |of: &dyn Fn(usize) -> Vec<i32>| DMatrix::from_row_iterator(count, of(0).len(), (0..count).flat_map(of));
    let tables: [(&str, DMatrix<i32>); 3] = [
        ("u", rows(&|k| steps[k].u.clone())),
        ("y", rows(&|k| steps[k].y.clone())),
        ("expected", rows(&|k| steps[k].estimate.clone())),
    ];
    for (name, table) in &tables {
        if table.ncols() > 0 {
            matrix(&mut text, name, table);
        }
    }
    _ = writeln!(text, "static const uint8_t measured[{count}][{}] = {{", steps[0].measured.len());
    for step in &steps {
        let row: Vec<&str> = step.measured.iter().map(|measured| if *measured { "1u" } else { "0u" }).collect();
        _ = writeln!(text, "    {{ {} }},", row.join(", "));
    }
    text.push_str("};\n");
    let saturations: Vec<String> = steps.iter().map(|step| format!("{}u", step.saturations)).collect();
    let saturations = wrapped(&saturations.join(", "), 100).join("\n    ");
    let u = if names.inputs.is_empty() { "0" } else { "u[k]" };
    _ = write!(
        text,
        "static const uint32_t saturations[{count}] = {{
    {saturations}
}};

{compare}int main(void)
{{
    {id}_state state;
    int32_t xhat[{upper}_STATES];
    int k;
    int wrong = 0;

    {id}_reset(&state);
    for (k = 0; k < {count}; ++k) {{
        int differs;

        if ((k % {every}) == ({every} - 1)) {{
            {id}_step_partial(&state, {u}, y[k], measured[k], xhat);
        }} else {{
            {id}_step(&state, {u}, y[k], xhat);
        }}
        differs = compare(k, \"xhat\", xhat, expected[k], {upper}_STATES);
        if (state.saturations != saturations[k]) {{
            printf(\"step %d: %lu saturations, expected %lu\\n\", k, (unsigned long)state.saturations,
                   (unsigned long)saturations[k]);
            differs = 1;
        }}
        wrong += differs;
    }}
    printf(\"{id}: %d of {count} steps agree to the last bit\\n\", {count} - wrong);
    if (wrong > 0) {{
        printf(\"{id}: largest relative difference %g\\n\", largest);
    }}
    return (wrong == 0) ? 0 : 1;
}}
",
        compare = comparison("int32_t", None),
        every = PARTIAL_EVERY,
    );
    text
}

fn readme(export: &FixedPointExport<'_>) -> String {
    let design = export.design;
    let id = &design.identifier;
    format!(
        "# {id}

{} in fixed point, one step per sample; {} products, {} bytes of constants and state, no allocation, no global state.

{}

{}

```c
#include \"{id}.h\"

{id}_state state;
{id}_reset(&state);
/* every {period} {unit}, with the measured outputs y and the inputs u held until the next sample, times 2^{part} */
int32_t xhat[{upper}_STATES];
{id}_step(&state, {input}, y, xhat);
```

The test compares {count} steps with the design, bit by bit; some of them saturate on purpose:

```console
$ cc -std=c99 -O2 {id}.c test_{id}.c -o test_{id} && ./test_{id}
```
",
        design.kind(),
        export.products(),
        export.bytes(),
        arithmetic(export),
        design.statement.join("\n"),
        count = design.test_steps,
        period = design.observer.period(),
        unit = if design.names.time_unit.is_empty() { "time units" } else { &design.names.time_unit },
        upper = id.to_uppercase(),
        part = export.observer.formats().signals.fraction_bits(),
        input = if design.names.inputs.is_empty() { "0" } else { "u" },
    )
}
