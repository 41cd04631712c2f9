//! The files of a C99 project.
//!
//! The order of operations is that of the Rust observer: a matrix times a vector sums its columns from the first to the
//! last, and sums of vectors are formed from left to right.

use std::fmt::Write;

use nalgebra::DMatrix;

use crate::error::ExportError;
use crate::golden::{self, STEPS, Step};
use crate::number;
use crate::program::{Program, Scalar};
use crate::{Export, File};

pub(crate) fn files(export: &Export) -> Result<Vec<File>, ExportError> {
    let name = &export.identifier;
    let steps = golden::steps(export, STEPS)?;
    let file = |name: String, text: String| File { name, text };
    Ok(vec![
        file(format!("{name}.h"), header(export)),
        file(format!("{name}.c"), source(export)),
        file(format!("test_{name}.c"), test(export, &steps)),
        file("CMakeLists.txt".to_owned(), cmake(name)),
        file("README.md".to_owned(), readme(export)),
    ])
}

pub(crate) fn scalar(export: &Export) -> &'static str {
    match export.scalar {
        Scalar::Binary32 => "float",
        Scalar::Binary64 => "double",
    }
}

/// Text that cannot end a comment.
fn harmless(text: &str) -> String {
    text.replace("*/", "* /").replace("/*", "/ *").replace(['\n', '\r'], " ")
}

/// Lines of at most `width` characters, broken at spaces.
pub(crate) fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => line.extend([" ", word]),
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// A list of columns for a comment: `position (m), velocity (m/s)`.
fn columns(names: &[String], units: &[String]) -> String {
    if names.is_empty() {
        return "none".to_owned();
    }
    let one = |(i, name): (usize, &String)| match units.get(i) {
        Some(unit) => format!("{name} ({unit})"),
        None => name.clone(),
    };
    harmless(&names.iter().enumerate().map(one).collect::<Vec<_>>().join(", "))
}

fn lengths(export: &Export) -> (String, [(&'static str, usize); 3]) {
    let size = export.program.dimensions();
    let all = [("STATES", size.state), ("INPUTS", size.inputs), ("OUTPUTS", size.outputs)];
    (export.identifier.to_uppercase(), all)
}

fn header(export: &Export) -> String {
    let (name, number, names) = (&export.identifier, scalar(export), &export.names);
    let (upper, lengths) = lengths(export);
    let mut text = format!("/**\n * @file {name}.h\n * @brief {}, one step per sample.\n *\n", kind(export));
    let period = export.program.period();
    let unit = if names.time_unit.is_empty() { String::new() } else { format!(" {}", harmless(&names.time_unit)) };
    _ = writeln!(text, " * Period:  {period}{unit}");
    _ = writeln!(text, " * States:  {}", columns(&names.states, &names.units));
    _ = writeln!(text, " * Inputs:  {}", columns(&names.inputs, &[]));
    _ = writeln!(text, " * Outputs: {}", columns(&names.outputs, &[]));
    _ = writeln!(
        text,
        " *\n * Numbers: {number} ({}). One step takes {} floating-point operations.",
        export.scalar.name(),
        export.operations()
    );
    text.push_str(" *\n");
    for sentence in &export.statement {
        for line in wrapped(&harmless(sentence), 100) {
            _ = writeln!(text, " * {line}");
        }
    }
    _ = writeln!(text, " *\n * SHA-256 of the numbers: {}", export.digest());
    if let Some(source) = &export.source {
        _ = writeln!(text, " * SHA-256 of the study:   {source}");
    }
    text.push_str(
        " *\n * The results are those of the design to the last bit if the compiler neither contracts nor reorders\n",
    );
    text.push_str(" * floating-point operations: -std=c99 or -ffp-contract=off, and not -ffast-math.\n");
    text.push_str(" * This file belongs to whoever generated it.\n */\n");
    _ = writeln!(text, "#ifndef {upper}_H\n#define {upper}_H\n\n#ifdef __cplusplus\nextern \"C\" {{\n#endif\n");
    for (what, length) in lengths {
        _ = writeln!(text, "#define {upper}_{what} {length}");
    }
    _ = write!(
        text,
        "
/** State of the observer. */
typedef struct {{
    {number} xhat[{upper}_STATES]; /**< Estimate for the next sample. */
}} {name}_state;

/** Starts from a given estimate. */
void {name}_init({name}_state *state, const {number} *xhat);

/** Starts from the first estimate of the design. */
void {name}_reset({name}_state *state);

/**
 * One step, from the sample at t to the estimate at t + period.
 *
 * @param state  State, read and written.
 * @param u      Inputs held from this sample to the next, {upper}_INPUTS entries{}.
 * @param y      Outputs measured at this sample, {upper}_OUTPUTS entries.
 * @param xhat   Estimate for the next sample, {upper}_STATES entries; may be a null pointer.
 *
 * A value of u or y that is not finite makes the estimate not finite, for good: call {name}_reset or {name}_init.
 */
void {name}_step({name}_state *state, const {number} *u, const {number} *y, {number} *xhat);

#ifdef __cplusplus
}}
#endif

#endif
",
        if names.inputs.is_empty() { "; not read, may be a null pointer" } else { "" }
    );
    text
}

pub(crate) fn kind(export: &Export) -> &'static str {
    match export.program {
        Program::Linear(_) => "Sampled linear observer",
        Program::Cubic(_) => "Sampled cubic observer",
    }
}

/// A constant matrix, row by row.
pub(crate) fn matrix(text: &mut String, export: &Export, name: &str, m: &DMatrix<f64>) {
    _ = writeln!(text, "static const {} {name}[{}][{}] = {{", scalar(export), m.nrows(), m.ncols());
    for row in m.row_iter() {
        let row: Vec<String> = row.iter().map(|x| number::c(*x, export.scalar)).collect();
        _ = writeln!(text, "    {{ {} }},", row.join(", "));
    }
    text.push_str("};\n");
}

/// `target[i] = sum over j of matrix[i][j] vector[j]`, and then `after`, for the rows of the matrix.
pub(crate) fn product(
    text: &mut String,
    number: &str,
    (matrix, rows, columns): (&str, &str, &str),
    vector: &str,
    after: &str,
) {
    _ = write!(
        text,
        "    for (i = 0; i < {rows}; ++i) {{
        {number} sum = {matrix}[i][0] * {vector}[0];
        for (j = 1; j < {columns}; ++j) {{
            sum = {matrix}[i][j] * {vector}[j] + sum;
        }}
        {after}
    }}
"
    );
}

fn source(export: &Export) -> String {
    let (name, number) = (&export.identifier, scalar(export));
    let (upper, lengths) = lengths(export);
    let [n, m, p] = lengths.map(|(what, _)| format!("{upper}_{what}"));
    let (n, m, p) = (n.as_str(), m.as_str(), p.as_str());
    let (inputs, fed) = (lengths[1].1 > 0, export.program.feedthrough().is_some());
    let cubic = matches!(export.program, Program::Cubic(_));
    let mut text = format!("/** @file {name}.c\n * See {name}.h. */\n#include \"{name}.h\"\n\n#include <float.h>\n");
    if cubic {
        text.push_str("#include <math.h>\n");
    }
    text.push_str("\n#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0)\n#error \"operations have to be rounded to their type: FLT_EVAL_METHOD must be 0\"\n#endif\n\n");
    text.push_str("#if defined(__clang__)\n#pragma STDC FP_CONTRACT OFF\n#endif\n\n");
    for (matrix_name, values) in export.matrices() {
        if values.ncols() > 0 {
            matrix(&mut text, export, matrix_name, &values);
        }
    }
    let initial: Vec<String> = export.initial.iter().map(|x| number::c(*x, export.scalar)).collect();
    _ = writeln!(text, "static const {number} INITIAL[{n}] = {{ {} }};", initial.join(", "));
    if cubic {
        flow(&mut text, export);
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

void {name}_step({name}_state *state, const {number} *u, const {number} *y, {number} *xhat)
{{
    {number} innovation[{p}];
    {number} next[{n}];
"
    );
    if cubic {
        _ = writeln!(text, "    {number} impulse[{p}];\n    {number} moved[{n}];");
    }
    text.push_str("    int i;\n    int j;\n\n");
    if !inputs {
        text.push_str("    (void)u;\n");
    }
    product(&mut text, number, ("C", p, n), "state->xhat", "innovation[i] = y[i] - sum;");
    if fed {
        product(&mut text, number, ("D", p, m), "u", "innovation[i] = innovation[i] - sum;");
    }
    let moved = if cubic {
        text.push_str("    flow(innovation, impulse);\n");
        product(&mut text, number, ("N", n, p), "impulse", "moved[i] = state->xhat[i] - sum;");
        "moved"
    } else {
        "state->xhat"
    };
    product(&mut text, number, ("A", n, n), moved, "next[i] = sum;");
    if inputs {
        product(&mut text, number, ("B", n, m), "u", "next[i] = next[i] + sum;");
    }
    product(&mut text, number, ("L", n, p), "innovation", "next[i] = next[i] + sum;");
    _ = write!(
        text,
        "    for (i = 0; i < {n}; ++i) {{
        state->xhat[i] = next[i];
        if (xhat != 0) {{
            xhat[i] = next[i];
        }}
    }}
}}
"
    );
    text
}

/// The exact flow of the cubic part over one period: the innovation after it, and the impulse on the estimate.
fn flow(text: &mut String, export: &Export) {
    let (number, upper) = (scalar(export), export.identifier.to_uppercase());
    let p = format!("{upper}_OUTPUTS");
    let (suffix, root, magnitude, epsilon, largest) = match export.scalar {
        Scalar::Binary32 => ("f", "sqrtf", "fabsf", f64::from(f32::EPSILON), f64::from(f32::MAX.sqrt())),
        Scalar::Binary64 => ("", "sqrt", "fabs", f64::EPSILON, f64::MAX.sqrt()),
    };
    let literal = |x: f64| number::c(x, export.scalar);
    let value = |wanted: &str| export.scalars().iter().find(|(name, _)| *name == wanted).map_or(0.0, |(_, x)| *x);
    let (w, period) = (literal(value("W")), literal(value("PERIOD")));
    let (large, bound) = (literal(1.0 / epsilon), literal(largest));
    _ = write!(
        text,
        "
/* The cubic part for one period in closed form: y~ becomes y~/sqrt(1 + 2 w h y~'theta y~). Squares are not formed, so
 * that nothing overflows. */
static void flow({number} *innovation, {number} *impulse)
{{
    {number} direction[{p}];
    {number} weighted[{p}];
    {number} size = 0.0{suffix};
    {number} q;
    {number} drive;
    {number} radical;
    {number} reach;
    {number} left;
    {number} right;
    {number} pull;
    int i;
    int j;

    for (i = 0; i < {p}; ++i) {{
        const {number} entry = {magnitude}(innovation[i]);
        size = (entry > size) ? entry : size;
    }}
    if (size <= 0.0{suffix}) {{
        for (i = 0; i < {p}; ++i) {{
            impulse[i] = innovation[i];
        }}
        return;
    }}
    for (i = 0; i < {p}; ++i) {{
        direction[i] = innovation[i] / size;
    }}
"
    );
    product(text, number, ("THETA", &p, &p), "direction", "weighted[i] = sum;");
    _ = write!(
        text,
        "    q = direction[0] * weighted[0];
    for (i = 1; i < {p}; ++i) {{
        q = q + direction[i] * weighted[i];
    }}
    q = (q > 0.0{suffix}) ? q : 0.0{suffix};
    drive = 2.0{suffix} * q * {period};
    radical = ({w} > 0.0{suffix}) ? {root}({w} * drive) : 0.0{suffix};
    reach = radical * size;
    if (reach <= {large}) {{
        const {number} hypotenuse = {root}(1.0{suffix} + reach * reach);
        left = size / hypotenuse;
        right = size / (1.0{suffix} + hypotenuse);
    }} else {{
        left = 1.0{suffix} / radical;
        right = 1.0{suffix} / radical;
    }}
    pull = drive * left * right * size;
    pull = (pull < {bound}) ? pull : {bound};
    for (i = 0; i < {p}; ++i) {{
        innovation[i] = direction[i] * left;
        impulse[i] = direction[i] * pull;
    }}
}}
"
    );
}

fn test(export: &Export, steps: &[Step]) -> String {
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

fn cmake(name: &str) -> String {
    format!(
        "cmake_minimum_required(VERSION 3.10)
project({name} C)

set(CMAKE_C_STANDARD 99)
set(CMAKE_C_EXTENSIONS OFF)

add_library({name} STATIC {name}.c)
target_include_directories({name} PUBLIC ${{CMAKE_CURRENT_SOURCE_DIR}})
if(CMAKE_C_COMPILER_ID MATCHES \"GNU|Clang\")
  # Operations are rounded one by one, as in the design.
  target_compile_options({name} PRIVATE -ffp-contract=off)
endif()
if(UNIX)
  target_link_libraries({name} PUBLIC m)
endif()

enable_testing()
add_executable(test_{name} test_{name}.c)
target_link_libraries(test_{name} PRIVATE {name})
add_test(NAME {name} COMMAND test_{name})
"
    )
}

fn readme(export: &Export) -> String {
    let (name, number) = (&export.identifier, scalar(export));
    let statement = export.statement.join("\n");
    let input = if export.names.inputs.is_empty() { "0" } else { "u" };
    format!(
        "# {name}

{}, one step per sample; {} operations, {} bytes of constants and state, no allocation, no global state.

{statement}

```c
#include \"{name}.h\"

{name}_state state;
{name}_reset(&state);
/* every {period} {unit}, with the measured outputs y and the inputs u held until the next sample */
{number} xhat[{upper}_STATES];
{name}_step(&state, {input}, y, xhat);
```

The test compares {STEPS} steps with the design, bit by bit:

```console
$ cc -std=c99 -O2 {name}.c test_{name}.c -lm -o test_{name} && ./test_{name}
```

Compilers must not contract or reorder floating-point operations: `-std=c99` or `-ffp-contract=off`, not `-ffast-math`.
",
        kind(export),
        export.operations(),
        export.bytes(),
        period = export.program.period(),
        unit = if export.names.time_unit.is_empty() { "time units" } else { &export.names.time_unit },
        upper = name.to_uppercase(),
    )
}
