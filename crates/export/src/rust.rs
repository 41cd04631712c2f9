//! The files of a `no_std` crate on `luenberger-observers`.

use std::fmt::Write;

use nalgebra::DMatrix;

use crate::c::wrapped;
use crate::error::ExportError;
use crate::golden::{self, STEPS, Step};
use crate::number;
use crate::program::Program;
use crate::{Export, File};

pub(crate) fn files(export: &Export) -> Result<Vec<File>, ExportError> {
    let steps = golden::steps(export, STEPS)?;
    let file = |name: &str, text: String| File { name: name.to_owned(), text };
    Ok(vec![
        file("Cargo.toml", manifest(export)),
        file("src/lib.rs", library(export)),
        file("tests/golden.rs", test(export, &steps)),
    ])
}

fn manifest(export: &Export) -> String {
    format!(
        "[package]
name = \"{}\"
version = \"0.1.0\"
edition = \"2024\"
publish = false

[dependencies]
luenberger-observers = {{ version = \"{}\", default-features = false }}

[workspace]
",
        export.identifier.replace('_', "-"),
        env!("CARGO_PKG_VERSION")
    )
}

/// A matrix as `Matrix::new` of nalgebra, which takes rows as they are written.
fn matrix(export: &Export, m: &DMatrix<f64>) -> String {
    let scalar = export.scalar.name();
    let row = |i: usize| m.row(i).iter().map(|x| number::rust(*x, export.scalar)).collect::<Vec<_>>().join(", ");
    let rows = (0..m.nrows()).map(row).collect::<Vec<_>>().join(", ");
    format!("SMatrix::<{scalar}, {}, {}>::from_row_slice(&[{rows}])", m.nrows(), m.ncols())
}

fn library(export: &Export) -> String {
    let scalar = export.scalar.name();
    let size = export.program.dimensions();
    let (n, m, p) = (size.state, size.inputs, size.outputs);
    let (kind, data) = match export.program {
        Program::Linear(_) => ("StaticDiscreteLinearObserver", "LinearPlant"),
        Program::Cubic(_) => ("StaticSampledCubicObserver", "SampledCubicGains"),
    };
    let fed = export.feedback.is_some();
    let mut text = format!(
        "//! {} of {n} states, {m} inputs and {p} outputs, one step per sample.\n//!\n",
        kind.trim_start_matches("Static")
    );
    for line in export.statement.iter().flat_map(|sentence| wrapped(sentence, 100)) {
        _ = writeln!(text, "//! {line}");
    }
    _ = writeln!(text, "//!\n//! SHA-256 of the numbers: {}", export.digest());
    if let Some(source) = &export.source {
        _ = writeln!(text, "//! SHA-256 of the study: {source}");
    }
    let (block, sizes) = if fed { ("OutputFeedback, ", "Const, ") } else { ("", "") };
    let inner = format!("{kind}<{scalar}, {n}, {m}, {p}>");
    let observer = if fed {
        format!(
            "/// The observer with its sizes and its scalar, and the feedback `u = r - K xhat`.
pub type Observer = OutputFeedback<{scalar}, {inner}, Const<{m}>, Const<{n}>>;"
        )
    } else {
        format!("/// The observer, with its sizes and its scalar.\npub type Observer = {inner};")
    };
    _ = write!(
        text,
        "#![no_std]

pub use luenberger_observers;

use luenberger_observers::nalgebra::{{{sizes}SMatrix, SVector}};
use luenberger_observers::{{{block}{data}, {kind}, ObserverError}};

{observer}

/// The first estimate of the design.
pub fn initial() -> SVector<{scalar}, {n}> {{
    SVector::from([{}])
}}

/// The observer.
///
/// # Errors
/// None: the numbers were checked when they were written.
pub fn observer() -> Result<Observer, ObserverError> {{
",
        export.initial.iter().map(|x| number::rust(*x, export.scalar)).collect::<Vec<_>>().join(", ")
    );
    match export.program {
        Program::Linear(_) => linear(&mut text, export, kind),
        Program::Cubic(_) => cubic(&mut text, export, kind),
    }
    text.push_str("}\n");
    text
}

/// A matrix of the export by its name, as an expression of Rust.
fn named(export: &Export, wanted: &str) -> Option<String> {
    export.matrices().iter().find(|(name, _)| *name == wanted).map(|(_, values)| matrix(export, values))
}

/// What stands around the observer where it gets a feedback.
fn wrapped_in_feedback(export: &Export) -> [String; 2] {
    match named(export, "K") {
        Some(k) => ["OutputFeedback::new(".to_owned(), format!("?, {k})")],
        None => [String::new(), String::new()],
    }
}

fn linear(text: &mut String, export: &Export, kind: &str) {
    let of = |name: &str| named(export, name).unwrap_or_default();
    let feedthrough = named(export, "D").map_or_else(String::new, |d| format!(".with_feedthrough({d})?"));
    let period = export.scalar.round(export.program.period());
    let [before, after] = wrapped_in_feedback(export);
    _ = write!(
        text,
        "    let a = {};
    let b = {};
    let c = {};
    let plant = LinearPlant::new(a, b, c)?{feedthrough};
    {before}{kind}::new(plant, {}, {}){after}
",
        of("A"),
        of("B"),
        of("C"),
        of("L"),
        number::rust(period, export.scalar)
    );
}

fn cubic(text: &mut String, export: &Export, kind: &str) {
    let [before, after] = wrapped_in_feedback(export);
    _ = writeln!(text, "    {before}{kind}::new(SampledCubicGains {{");
    for (name, field) in [("A", "ad"), ("B", "bd"), ("C", "c"), ("L", "ld"), ("N", "n"), ("THETA", "theta")] {
        _ = writeln!(text, "        {field}: {},", named(export, name).unwrap_or_default());
    }
    for (name, x) in export.scalars() {
        let field = if name == "W" { "w" } else { "period" };
        _ = writeln!(text, "        {field}: {},", number::rust(x, export.scalar));
    }
    let feedthrough = named(export, "D").map_or_else(String::new, |d| format!("?\n    .with_feedthrough({d})"));
    _ = writeln!(text, "    }}){feedthrough}{after}");
}

fn test(export: &Export, steps: &[Step]) -> String {
    let scalar = export.scalar.name();
    let size = export.program.dimensions();
    let (name, fed) = (&export.identifier, export.feedback.is_some());
    let of_the_step = if fed { String::new() } else { format!("use {name}::luenberger_observers::SampledObserver;\n") };
    let mut text = format!(
        "//! Golden vectors: {} steps of the design, compared bit by bit.\n\n{of_the_step}use {name}::luenberger_observers::nalgebra::SVector;\n",
        steps.len(),
    );
    let mut table = |what: &str, length: usize, of: fn(&Step) -> &Vec<f64>| {
        _ = writeln!(text, "\nconst {what}: [[{scalar}; {length}]; {}] = [", steps.len());
        for step in steps {
            let row: Vec<String> = of(step).iter().map(|x| number::rust(*x, export.scalar)).collect();
            _ = writeln!(text, "    [{}],", row.join(", "));
        }
        text.push_str("];\n");
    };
    table(if fed { "R" } else { "U" }, size.inputs, |step| &step.u);
    table("Y", size.outputs, |step| &step.y);
    table("EXPECTED", size.state, |step| &step.estimate);
    if fed {
        table("APPLIED", size.inputs, |step| &step.applied);
    }
    let step = if fed {
        "    for (((r, y), expected), applied) in R.iter().zip(&Y).zip(&EXPECTED).zip(&APPLIED) {
        let u = observer.step(0.0, &mut xhat, &SVector::from(*r), &SVector::from(*y));
"
    } else {
        "    for ((u, y), expected) in U.iter().zip(&Y).zip(&EXPECTED) {
        observer.step(0.0, &mut xhat, &SVector::from(*u), &SVector::from(*y));
"
    };
    let applied = if fed { "        assert_eq!(bits(u.as_slice()), bits(applied));\n" } else { "" };
    _ = write!(
        text,
        "
#[test]
fn the_steps_are_those_of_the_design() {{
    let observer = {name}::observer().unwrap();
    let mut xhat = {name}::initial();
{step}        let bits = |x: &[{scalar}]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(xhat.as_slice()), bits(expected));
{applied}    }}
}}
"
    );
    text
}
