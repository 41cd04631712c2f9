//! Emitted Rust: the sources beside this file are what is emitted, and run here over golden vectors.
//!
//! `UPDATE=1 cargo test -p luenberger-export` writes them anew.

#[rustfmt::skip]
#[allow(unreachable_pub, clippy::all, clippy::pedantic)]
mod copy;
#[rustfmt::skip]
#[allow(unreachable_pub, clippy::all, clippy::pedantic)]
mod discrete;
#[rustfmt::skip]
#[allow(unreachable_pub, clippy::all, clippy::pedantic)]
mod filter;

use std::path::Path;
use std::sync::Arc;

use luenberger_export::{Export, Names, Program, Scalar, golden};
use luenberger_expression::{ExpressionPlant, Extrapolation, Interpolation, Parameters, Scope, Table, Tables};
use luenberger_observers::{DiscreteNonlinearObserver, ExtendedKalmanFilter, NoiseModel, SampledCopy, SampledObserver};
use nalgebra::{SVector, dmatrix};

fn plant(f: &[&str], h: &[&str], inputs: usize) -> ExpressionPlant {
    let table = Table::new(&[-1.0, 0.0, 2.0], &[0.5, 0.0, 1.5], Interpolation::MonotoneCubic, Extrapolation::Linear);
    let tables = Tables::from([("drag".to_owned(), Arc::new(table.unwrap()))]);
    let scope = Scope::plant(f.len(), inputs).with(&Parameters::new()).unwrap().tables(&tables).unwrap();
    ExpressionPlant::within(f, h, &scope).unwrap()
}

fn export(program: Program, scalar: Scalar) -> Export {
    let size = program.dimensions();
    let names = Names::numbered(size.estimate, size.inputs, size.outputs);
    Export::new("plant", program, scalar, &vec![0.25; size.estimate], names).unwrap()
}

/// Compares what is emitted with the file `name`.
fn unchanged(export: &Export, name: &str) {
    let files = export.rust().unwrap();
    let text = &files.iter().find(|file| file.name == "src/lib.rs").unwrap().text;
    let text = text.replace("#![no_std]\n\n", "");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/it/emitted/{name}.rs"));
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&path, &text).unwrap();
    }
    assert_eq!(std::fs::read_to_string(path).unwrap(), text, "UPDATE=1 writes the file anew");
    assert!(files.iter().any(|file| file.name == "Cargo.toml" && file.text.contains("libm = ")));
}

/// Steps an emitted observer over the golden vectors of its export.
macro_rules! agrees {
    ($emitted:ident, $export:expr, $scalar:ty) => {
        let observer = $emitted::observer().unwrap();
        let mut state = observer.initial(0.0, &$emitted::initial(), &SVector::from([0.0; 1]), &SVector::from([0.0; 1]));
        let convert = |x: &[f64]| SVector::<$scalar, 1>::from_iterator(x.iter().map(|x| *x as $scalar));
        for (k, step) in golden::steps($export, 200).unwrap().iter().enumerate() {
            let t = k as $scalar * observer.period();
            observer.step(t, &mut state, &convert(&step.u), &convert(&step.y));
            let found: Vec<f64> = observer.estimate(&state).iter().map(|x| f64::from(*x)).collect();
            assert_eq!(found, step.estimate, "step {k}");
        }
    };
}

#[test]
fn the_copy_with_a_constant_gain_is_emitted_as_rust() {
    let plant = plant(&["x2 - drag(x1)", "-sin(x1) - x2 + u1*cos(t)"], &["x1 + 0.1*x2^3"], 1);
    let observer = SampledCopy::new(plant, dmatrix![2.0; 1.0], 0.125, 2).unwrap();
    let export = export(Program::Copy(observer), Scalar::Binary64);
    unchanged(&export, "copy");
    agrees!(copy, &export, f64);
}

#[test]
fn the_copy_in_discrete_time_is_emitted_as_rust() {
    let plant = plant(&["0.5*x1 + 0.25*tanh(x2)", "if(x1 < u1, 0.5*x2, 0.25*x1)"], &["x1"], 1);
    let observer = DiscreteNonlinearObserver::new(plant, dmatrix![0.5; 0.25], 0.5).unwrap();
    let export = export(Program::Discrete(observer), Scalar::Binary32);
    unchanged(&export, "discrete");
    agrees!(discrete, &export, f32);
}

#[test]
fn the_extended_kalman_filter_is_emitted_as_rust() {
    let plant = plant(&["x2", "-x1 - 0.5*x2*exp(-x1^2) + u1"], &["x1*sqrt(1 + x2^2)"], 1);
    let noises = NoiseModel { w: dmatrix![0.5, 0.0; 0.0, 0.25], v: dmatrix![0.125], p0: dmatrix![1.0, 0.0; 0.0, 2.0] };
    let filter = ExtendedKalmanFilter::new(plant, noises, 0.0625, 2).unwrap().with_gate(3.0).unwrap();
    let export = export(Program::Kalman(filter), Scalar::Binary32);
    unchanged(&export, "filter");
    agrees!(filter, &export, f32);
}
