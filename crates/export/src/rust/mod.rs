//! The files of a `no_std` crate on `luenberger-observers`.
//!
//! | file | subject |
//! |---|---|
//! | `plant` | a nonlinear plant, and its observers |
//! | `staticlib` | a static library with the interface of the emitted C |
//! | `kkl` | the numerical KKL observer |
//! | `test` | the test with golden vectors |

mod extension;
mod kkl;
mod plant;
mod staticlib;
mod step;
mod test;
mod varying;

use std::fmt::Write;

use luenberger_observers::MatrixName;
use nalgebra::DMatrix;

use crate::c::wrapped;
use crate::error::ExportError;
use crate::exportable_observer::ExportableObserver;
use crate::golden;
use crate::number;
use crate::{Export, ExportedMatrix, File};

pub(crate) fn files(export: &Export) -> Result<Vec<File>, ExportError> {
    let steps = golden::steps(export, export.test_steps)?;
    let file = |name: &str, text: String| File { name: name.to_owned(), text };
    let mut files = vec![
        file("Cargo.toml", manifest(export)),
        file("src/lib.rs", library(export)),
        file("tests/golden.rs", test::test(export, &steps)),
        file("README.md", readme(export, steps.len())),
    ];
    files.extend(staticlib::files(export, &steps));
    Ok(files)
}

fn readme(export: &Export, count: usize) -> String {
    format!(
        "# {name}

{kind} as a `no_std` crate on `luenberger-observers`. The test compares {count} steps with the design, bit by bit:

```console
$ cargo test --config 'patch.crates-io.luenberger-observers.path = \"/path/to/luenberger/crates/observers\"'
```

Without the option once `luenberger-observers` is published; with it for every command of cargo here and in `c/`.

`c/` is the same observer as a static library for programs in C, with its header and the same test:

```console
$ cd c && cargo build --release
$ cc -std=c99 test_{name}.c target/release/lib{name}.a -lm -o test_{name} && ./test_{name}
```

For a microcontroller add its target, `cargo build --release --target thumbv7em-none-eabihf`.

{statement}
",
        name = export.identifier,
        kind = export.kind(),
        statement = export.statement.join("\n"),
    )
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
{libm}
[workspace]
",
        staticlib::package(&export.identifier),
        env!("CARGO_PKG_VERSION"),
        libm = if export.observer.maps().is_some() {
            "libm = { version = \"0.2.16\", default-features = false }\n"
        } else {
            ""
        },
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
    let size = export.observer.dimensions();
    let (n, m, p) = (size.estimate, size.inputs, size.outputs);
    let last = if export.observer.takes_time() { ", the last of which is the time since the last step," } else { "" };
    let (kind, data) = match &export.observer {
        ExportableObserver::Linear(_) if export.is_filter() => {
            ("StaticStationaryKalmanFilter", "LinearPlant, StaticDiscreteLinearObserver")
        }
        ExportableObserver::Linear(_) => ("StaticDiscreteLinearObserver", "LinearPlant"),
        ExportableObserver::Cubic(_) => ("StaticSampledCubicObserver", "SampledCubicGains"),
        ExportableObserver::Varying(_) => {
            ("StaticVaryingPeriodStep", "SampledCubicGains, StaticSampledCubicObserver, VaryingPeriodObserver")
        }
        ExportableObserver::Kalman(_) => ("StaticExtendedKalmanFilter", "ExtendedKalmanFilter, NoiseModel"),
        ExportableObserver::Unscented(_) => {
            ("StaticUnscentedKalmanFilter", "NoiseModel, Prediction, SigmaPoints, UnscentedKalmanFilter")
        }
        ExportableObserver::MovingHorizon(_) => ("MovingHorizonEstimator", "Horizon, NoiseModel"),
        ExportableObserver::SampledNonlinear(_) => ("StaticSampledNonlinearObserver", "SampledNonlinearObserver"),
        ExportableObserver::Discrete(_) => ("DiscreteNonlinearObserver", ""),
        ExportableObserver::Kkl(observer) if observer.held_inputs() > 0 => ("SampledHeldKkl", ""),
        ExportableObserver::Kkl(_) => ("SampledKkl", ""),
        ExportableObserver::Extension(_) => ("InterSampleObserver", "ObserverDimensions"),
        ExportableObserver::Step(_) => ("Step", "ObserverDimensions"),
    };
    let fed = export.feedback.is_some();
    let is_step = matches!(export.observer, ExportableObserver::Step(_));
    let model = if export.observer.maps().is_some() && !is_step { "Model, " } else { "" };
    let lengths = match export.observer {
        ExportableObserver::Discrete(_) => format!("Const<{n}>, Const<{m}>, Const<{p}>"),
        ExportableObserver::MovingHorizon(_) => {
            let (state, window) = (export.observer.dimensions().state, export.observer.window());
            format!("Const<{n}>, Const<{m}>, Const<{p}>, Const<{state}>, {window}")
        }
        _ => format!("{n}, {m}, {p}"),
    };
    let mut head = format!(
        "//! {} of {n} states, {m} inputs{last} and {p} outputs, one step per sample.\n//!\n",
        kind.trim_start_matches("Static")
    );
    for line in export.statement.iter().flat_map(|sentence| wrapped(sentence, 100)) {
        _ = writeln!(head, "//! {line}");
    }
    head.push_str("//!\n");
    for line in export.digests() {
        _ = writeln!(head, "//! {line}");
    }
    let maps = match &export.observer {
        ExportableObserver::Kkl(observer) => format!("\n{}", kkl::imports(observer)),
        _ => String::new(),
    };
    let kind = if matches!(export.observer, ExportableObserver::Kkl(_)) || is_step { "" } else { kind };
    let types = [if fed { "OutputFeedback" } else { "" }, data, kind, "ObserverError"];
    let types = types.into_iter().filter(|name| !name.is_empty()).collect::<Vec<_>>().join(", ");
    let inner = match &export.observer {
        ExportableObserver::Kkl(observer) => kkl::kind(export, observer),
        ExportableObserver::Extension(observer) => extension::kind(export, observer),
        ExportableObserver::Step(_) => "Step".to_owned(),
        _ => format!("{kind}<{model}{scalar}, {lengths}>"),
    };
    let observer = if fed {
        format!(
            "/// The observer with its sizes and its scalar, and the feedback `u = r - K xhat`.
pub type Observer = OutputFeedback<{scalar}, {inner}, Const<{m}>, Const<{n}>>;"
        )
    } else {
        format!("/// The observer, with its sizes and its scalar.\npub type Observer = {inner};")
    };
    let without = of(export, ExportedMatrix::Feedback).map_or_else(String::new, |k| {
        format!(
            "    OutputFeedback::new(without_feedback()?, {k})
}}

fn without_feedback() -> Result<{inner}, ObserverError> {{
"
        )
    });
    let mut text = format!(
        "{observer}

/// The first estimate of the design.
pub fn initial() -> SVector<{scalar}, {n}> {{
    SVector::from([{}])
}}

/// The observer.
///
/// # Errors
/// None: the numbers were checked when they were written.
pub fn observer() -> Result<Observer, ObserverError> {{
{without}",
        export.initial.iter().map(|x| number::rust(*x, export.scalar)).collect::<Vec<_>>().join(", "),
    );
    match &export.observer {
        ExportableObserver::Linear(_) => linear(&mut text, export, kind),
        ExportableObserver::Cubic(_) => cubic(&mut text, export, kind),
        ExportableObserver::Varying(step) => varying::observer(&mut text, export, step),
        ExportableObserver::Kalman(filter) => plant::kalman(&mut text, export, filter.iterations()),
        ExportableObserver::Unscented(filter) => plant::unscented(&mut text, export, filter.sigma_points()),
        ExportableObserver::MovingHorizon(estimator) => plant::moving_horizon(&mut text, export, estimator),
        ExportableObserver::SampledNonlinear(_) => plant::sampled_nonlinear(&mut text, export),
        ExportableObserver::Discrete(_) => plant::discrete(&mut text, export),
        ExportableObserver::Kkl(observer) => kkl::observer(&mut text, export, observer),
        ExportableObserver::Extension(observer) => extension::observer(&mut text, export, observer),
        ExportableObserver::Step(_) => text.push_str("    Ok(Step)\n"),
    }
    text.push_str("}\n");
    if let ExportableObserver::Kkl(observer) = &export.observer {
        kkl::first_input(&mut text, export, observer);
        kkl::trees(&mut text, export, observer);
    }
    if let ExportableObserver::Extension(observer) = &export.observer {
        extension::model(&mut text, export, observer);
    }
    if let ExportableObserver::Step(observer) = &export.observer {
        step::model(&mut text, export, observer);
    } else if let Some(routines) = export.observer.routines() {
        plant::model(&mut text, export, &routines);
    }
    let sizes = ["Const", "SMatrix", "SVector"].into_iter().filter(|name| text.contains(name)).collect::<Vec<_>>();
    format!(
        "{head}#![no_std]

pub use luenberger_observers;

use luenberger_observers::nalgebra::{{{}}};
use luenberger_observers::{{{types}}};{maps}

{text}",
        sizes.join(", ")
    )
}

/// The input at the start, in the source of a test: `of` is the crate.
fn input_at_start(export: &Export, of: &str) -> String {
    match &export.observer {
        ExportableObserver::Kkl(observer) if observer.held_inputs() > 0 => format!("{of}::first_input()"),
        _ => "SVector::zeros()".to_owned(),
    }
}

/// A matrix of the export, if it has one, as an expression of Rust.
fn of(export: &Export, wanted: impl Into<ExportedMatrix>) -> Option<String> {
    let wanted = wanted.into();
    export.matrices().iter().find(|(which, _)| *which == wanted).map(|(_, values)| matrix(export, values))
}

fn linear(text: &mut String, export: &Export, kind: &str) {
    let matrix = |name: MatrixName| of(export, name).unwrap_or_default();
    let feedthrough = of(export, MatrixName::D).map_or_else(String::new, |d| format!(".with_feedthrough({d})?"));
    let period = export.scalar.round(export.observer.period());
    let update = of(export, ExportedMatrix::Update);
    let (start, end) = match &update {
        Some(k) => ("let predictor = StaticDiscreteLinearObserver", format!("?;\n    {kind}::new(predictor, {k})")),
        None => (kind, String::new()),
    };
    _ = write!(
        text,
        "    let a = {};
    let b = {};
    let c = {};
    let plant = LinearPlant::new(a, b, c)?{feedthrough};
    {start}::new(plant, {}, {}){end}
",
        matrix(MatrixName::A),
        matrix(MatrixName::B),
        matrix(MatrixName::C),
        matrix(MatrixName::L),
        number::rust(period, export.scalar)
    );
}

fn cubic(text: &mut String, export: &Export, kind: &str) {
    let coupling = of(export, MatrixName::Coupling);
    let constructor = if coupling.is_some() { "semi_implicit" } else { "new" };
    _ = writeln!(text, "    {kind}::{constructor}(SampledCubicGains {{");
    let fields = [
        (MatrixName::Ad, "ad"),
        (MatrixName::Bd, "bd"),
        (MatrixName::C, "c"),
        (MatrixName::Ld, "ld"),
        (MatrixName::N, "n"),
        (MatrixName::Theta, "theta"),
    ];
    for (which, field) in fields {
        _ = writeln!(text, "        {field}: {},", of(export, which).unwrap_or_default());
    }
    for (name, x) in export.scalars() {
        let field = if name == "W" { "w" } else { "period" };
        _ = writeln!(text, "        {field}: {},", number::rust(x, export.scalar));
    }
    if coupling.is_some() {
        _ = writeln!(text, "        w: {},", number::rust(0.0, export.scalar));
    }
    let coupling = coupling.map_or_else(String::new, |coupling| format!(", {coupling}"));
    let feedthrough = of(export, MatrixName::D).map_or_else(String::new, |d| format!("?\n    .with_feedthrough({d})"));
    _ = writeln!(text, "    }}{coupling}){feedthrough}");
}
