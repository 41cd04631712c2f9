//! The files of a C99 project.
//!
//! The order of operations is that of the Rust observer: a matrix times a vector sums its columns from the first to the
//! last, and sums of vectors are formed from left to right.
//!
//! | file | subject |
//! |---|---|
//! | `header` | the header |
//! | `source` | the source: constants, start, step |
//! | `kernels` | the loops of the observers, in files of C |
//! | `fixed` | all files of a linear observer in fixed point |
//! | `plant` | the right-hand sides of a nonlinear plant |
//! | `recorded` | the functions and steps of recorded observers |
//! | `filter` | the steps of the extended and of the unscented Kalman filter |
//! | `moving_horizon` | the step of the moving-horizon estimator |
//! | `varying` | declarations and step of an observer at varying periods |
//! | `feedback` | declarations of the feedback |
//! | `kkl` | the step of the numerical KKL observer, and the constants of its left inverse |
//! | `test` | the test with golden vectors |
//! | `project` | build file and README |
//! | `layout` | the folders of Arduino, Zephyr, ESP-IDF and ROS 2 |

mod feedback;
mod filter;
mod fixed;
mod header;
pub(crate) mod kernels;
mod kkl;
mod layout;
mod moving_horizon;
pub(crate) mod plant;
mod project;
pub(crate) mod recorded;
pub(crate) mod source;
mod test;
mod varying;

pub(crate) use header::header;
pub use layout::Layout;
pub(crate) use test::test;

use std::fmt::Write;

use nalgebra::DMatrix;

use crate::error::ExportError;
use crate::golden;
use crate::scalar::Scalar;
use crate::{Export, File, number};

pub(crate) fn files(export: &Export) -> Result<Vec<File>, ExportError> {
    let name = &export.identifier;
    let steps = golden::steps(export, export.test_steps)?;
    let file = |name: String, text: String| File { name, text };
    Ok(vec![
        file(format!("{name}.h"), header(export)),
        file(format!("{name}.c"), source::source(export)?),
        file(format!("test_{name}.c"), test(export, &steps)),
        file("CMakeLists.txt".to_owned(), project::cmake(name)),
        file("README.md".to_owned(), project::readme(export, steps.len())),
    ])
}

/// The arguments of a step beside the state and xhat, by their names.
pub(crate) struct Call {
    /// Whether the step has the feedback.
    pub(crate) is_fed: bool,
    /// What is known: the inputs, the references, or a null pointer.
    pub(crate) known: &'static str,
    /// The inputs that the step computes, and a comma.
    pub(crate) applied: &'static str,
    /// The time since the last step, and a comma.
    pub(crate) elapsed: &'static str,
}

impl Call {
    pub(crate) fn of(export: &Export) -> Self {
        let is_fed = export.feedback.is_some();
        let known = match (is_fed, export.names.inputs.is_empty()) {
            (true, _) => "r",
            (false, true) => "0",
            (false, false) => "u",
        };
        let elapsed = if export.observer.takes_time() { "dt, " } else { "" };
        Self { is_fed, known, applied: if is_fed { "u, " } else { "" }, elapsed }
    }
}

pub(crate) fn scalar(export: &Export) -> &'static str {
    match export.scalar {
        Scalar::Binary32 => "float",
        Scalar::Binary64 => "double",
    }
}

/// Text that cannot end a comment.
fn harmless(text: &str) -> String {
    // No trigraph either.
    text.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?").replace(['\n', '\r'], " ")
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
        Some(unit) if !unit.is_empty() => format!("{name} ({unit})"),
        _ => name.clone(),
    };
    harmless(&names.iter().enumerate().map(one).collect::<Vec<_>>().join(", "))
}

fn lengths(export: &Export) -> (String, [(&'static str, usize); 3]) {
    let size = export.observer.dimensions();
    let inputs = export.observer.plant_inputs();
    let all = [("STATES", size.estimate), ("INPUTS", inputs), ("OUTPUTS", size.outputs)];
    (export.identifier.to_uppercase(), all)
}

/// The macros of a header that say what it is: sizes, period, names, the digest of its numbers, and what wrote it.
fn macros(export: &Export, digest: &str) -> String {
    let (upper, lengths) = lengths(export);
    let mut text = String::new();
    for (what, length) in lengths {
        _ = writeln!(text, "#define {upper}_{what} {length}");
    }
    let period = export.observer.period();
    let period = match export.scalar {
        Scalar::Binary32 => format!("{:?}f", period as f32),
        Scalar::Binary64 => format!("{period:?}"),
    };
    _ = writeln!(text, "#define {upper}_PERIOD {period}");
    let names = &export.names;
    let inputs = &names.inputs[..names.inputs.len().min(lengths[1].1)];
    for (what, names) in [("STATE", &names.states[..]), ("INPUT", inputs), ("OUTPUT", &names.outputs[..])] {
        let listed: Vec<String> = names.iter().map(|name| quoted(name)).collect();
        if !listed.is_empty() {
            _ = writeln!(text, "#define {upper}_{what}_NAMES {{ {} }}", listed.join(", "));
        }
    }
    _ = writeln!(text, "#define {upper}_DIGEST \"{digest}\"");
    _ = writeln!(text, "#define {upper}_GENERATOR \"luenberger {}\"", env!("CARGO_PKG_VERSION"));
    text
}

/// A string of C: what is not plain ASCII as the octal digits of its bytes.
fn quoted(text: &str) -> String {
    let byte = |byte: u8| match byte {
        // No trigraph.
        b'"' | b'\\' | b'?' => format!("\\{}", char::from(byte)),
        // `*` neither: a program that looks for the ends of comments may not look for texts.
        b' '..=b')' | b'+'..=b'~' => char::from(byte).to_string(),
        _ => format!("\\{byte:03o}"),
    };
    format!("\"{}\"", text.bytes().map(byte).collect::<String>())
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
