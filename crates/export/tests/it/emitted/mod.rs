//! Emitted Rust: the sources beside this file are what is emitted, and run here over golden vectors.
//!
//! `UPDATE=1 cargo test -p luenberger-export` writes them anew.

macro_rules! emitted {
    ($($name:ident)*) => {
        $(#[allow(unreachable_pub, clippy::all, clippy::pedantic)] mod $name;)*
    };
}

emitted!(
    discrete error_state extension filter iterated kkl kkl_held kkl_held_table kkl_low_rank moving_horizon sampled_nonlinear unscented
);

use std::path::Path;

use luenberger_export::kkl::Kkl;
use luenberger_export::moving_horizon::MovingHorizon;
use luenberger_export::{Export, ExportableObserver, Names, Scalar, golden};
use luenberger_expression::{ExpressionPlant, Extrapolation, Interpolation, Parameters, Scope, Table, Tables};
use luenberger_observers::numerical_kkl::{
    Branch, Coordinates, HeldInputInverse, HeldInputTables, HeldInputTrees, InterpolatedInverse, Node,
    PolynomialInverse, PolynomialTree, SampledFilter, Search, TensorSpline, TensorTrain,
};
use luenberger_observers::{
    DiscreteNonlinearObserver, ExtendedKalmanFilter, Horizon, InterSampleObserver, NoiseModel,
    SampledNonlinearObserver, SampledObserver, SigmaPoints, UnscentedKalmanFilter,
};
use nalgebra::{SMatrix, SVector, dmatrix, dvector};

use crate::rows::Rows;

fn plant(f: &[&str], h: &[&str], inputs: usize) -> ExpressionPlant {
    let table = Table::new(&[-1.0, 0.0, 2.0], &[0.5, 0.0, 1.5], Interpolation::MonotoneCubic, Extrapolation::Linear);
    let tables = Tables::from([("drag".to_owned(), table.unwrap().into())]);
    let scope = Scope::plant(f.len(), inputs).with(&Parameters::new()).unwrap().tables(&tables).unwrap();
    ExpressionPlant::within(f, h, &scope).unwrap()
}

fn export(program: ExportableObserver, scalar: Scalar) -> Export {
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
        agrees!($emitted, $export, $scalar, SVector::zeros())
    };
    ($emitted:ident, $export:expr, $scalar:ty, $first:expr) => {
        let observer = $emitted::observer().unwrap();
        let mut state = observer.initial(0.0, &$emitted::initial(), &$first, &SVector::zeros());
        for (k, step) in golden::steps($export, 200).unwrap().iter().enumerate() {
            let t = k as $scalar * observer.period();
            let u = SVector::from_iterator(step.u.iter().map(|x| *x as $scalar));
            let y = SVector::from_iterator(step.y.iter().map(|x| *x as $scalar));
            observer.step(t, &mut state, &u, &y);
            let found: Vec<f64> = observer.estimate(&state).iter().map(|x| f64::from(*x)).collect();
            assert_eq!(found, step.estimate, "step {k}");
        }
    };
}

#[test]
fn the_sampled_nonlinear_observer_is_emitted_as_rust() {
    let plant = plant(&["x2 - drag(x1)", "-sin(x1) - x2 + u1*cos(t)"], &["x1 + 0.1*x2^3"], 1);
    let observer = SampledNonlinearObserver::new(plant, dmatrix![2.0; 1.0], 0.125, 2).unwrap();
    let export = export(ExportableObserver::SampledNonlinear(observer), Scalar::Binary64);
    unchanged(&export, "sampled_nonlinear");
    agrees!(sampled_nonlinear, &export, f64);
}

/// `x1' = x2, x2' = (1 - x1^2) x2 - x1 + u` with `phi = x2 - (x1 - x1^3/3) - 2 x1`.
#[test]
fn an_observer_of_expressions_is_emitted_as_rust() {
    let model = plant(&["x2 + 0*drag(x1)", "(1 - x1^2)*x2 - x1 + u1*cos(t)"], &["x1"], 1);
    // The inputs of the observer are (u, y), those of its start y.
    let flow = plant(&["-2*x1 - 5*u2 - 2*(u2 - u2^3/3) + u1*cos(t)"], &["u2", "x1 + 3*u2 - u2^3/3"], 2);
    let start = plant(&["0", "0"], &["x2 - (u1 - u1^3/3) - 2*u1"], 1);
    let jump = plant(&["0"], &["if(x1 > 0.75, 0.5*x1 + 0.125*u2, x1)"], 2);
    let observer = Rows { flow, start, jump: Some(jump), outputs: 1 }.recorded(&model);
    let sampled = InterSampleObserver::new(model, observer, 0.125, 2).unwrap();
    let export = export(ExportableObserver::Extension(sampled), Scalar::Binary32);
    unchanged(&export, "extension");
    agrees!(extension, &export, f32);
    let c = export.c().unwrap();
    assert!(
        c.iter().any(|file| file.name == "plant.h" && file.text.contains("float z[1]; /**< State of the observer. */"))
    );
}

#[test]
fn the_copy_in_discrete_time_is_emitted_as_rust() {
    let plant = plant(&["0.5*x1 + 0.25*tanh(x2)", "if(x1 < u1, 0.5*x2, 0.25*x1)"], &["x1"], 1);
    let observer = DiscreteNonlinearObserver::new(plant, dmatrix![0.5; 0.25], 0.5).unwrap();
    let export = export(ExportableObserver::Discrete(observer), Scalar::Binary32);
    unchanged(&export, "discrete");
    agrees!(discrete, &export, f32);
}

#[test]
fn the_extended_kalman_filter_is_emitted_as_rust() {
    let plant = plant(&["x2", "-x1 - 0.5*x2*exp(-x1^2) + u1"], &["x1*sqrt(1 + x2^2)"], 1);
    let noises = NoiseModel { w: dmatrix![0.5, 0.0; 0.0, 0.25], v: dmatrix![0.125], p0: dmatrix![1.0, 0.0; 0.0, 2.0] };
    let filter = ExtendedKalmanFilter::new(plant, noises, 0.0625, 2).unwrap().with_gate(3.0).unwrap();
    let export = export(ExportableObserver::Kalman(filter), Scalar::Binary32);
    unchanged(&export, "filter");
    agrees!(filter, &export, f32);
}

#[test]
fn the_iterated_kalman_filter_is_emitted_as_rust() {
    let plant = plant(&["0.5*x1"], &["x1^2"], 0);
    let noises = NoiseModel { w: dmatrix![0.25], v: dmatrix![0.125], p0: dmatrix![1.0] };
    let filter = ExtendedKalmanFilter::discrete(plant, noises, 0.5).unwrap().with_iterations(3).unwrap();
    let filter = filter.with_gate(4.0).unwrap().with_angles(dvector![0.75]).unwrap();
    let export = export(ExportableObserver::Kalman(filter), Scalar::Binary64);
    unchanged(&export, "iterated");
    agrees!(iterated, &export, f64);
}

#[test]
fn the_error_state_kalman_filter_is_emitted_as_rust() {
    let plant = plant(&["-x2*u1", "x1*u1", "0"], &["x2 + x3"], 1);
    let noises = NoiseModel {
        w: dmatrix![0.5, 0.0, 0.0; 0.0, 0.5, 0.0; 0.0, 0.0, 0.25],
        v: dmatrix![0.125],
        p0: dmatrix![1.0, 0.0, 0.0; 0.0, 1.0, 0.0; 0.0, 0.0, 2.0],
    };
    let filter = ExtendedKalmanFilter::new(plant, noises, 0.0625, 2).unwrap();
    let filter = filter.with_unit_vectors(dvector![1.0, 1.0, 0.0]).unwrap();
    let export = export(ExportableObserver::Kalman(filter), Scalar::Binary32);
    unchanged(&export, "error_state");
    agrees!(error_state, &export, f32);
}

#[test]
fn the_unscented_kalman_filter_is_emitted_as_rust() {
    let plant = plant(&["x2", "-x1 - 0.5*x2*exp(-x1^2) + u1"], &["x1*sqrt(1 + x2^2)"], 1);
    let noises = NoiseModel { w: dmatrix![0.5, 0.1; 0.1, 0.25], v: dmatrix![0.125], p0: dmatrix![1.0, 0.0; 0.0, 2.0] };
    let sigma = SigmaPoints { alpha: 0.5, ..SigmaPoints::default() };
    let filter = UnscentedKalmanFilter::new(plant, noises, sigma, 0.0625, 2).unwrap().with_gate(3.0).unwrap();
    let filter = filter.with_angles(dvector![0.5], dvector![0.0, 0.75]).unwrap();
    let export = export(ExportableObserver::Unscented(filter), Scalar::Binary32);
    unchanged(&export, "unscented");
    agrees!(unscented, &export, f32);
}

/// Centres, inverse half-widths, least and largest values and the coefficients of degree 1 of a leaf.
fn leaf(centre: f64, inputs: usize, outputs: usize) -> Vec<f64> {
    let mut leaf = vec![centre; inputs];
    leaf.extend(vec![0.5; inputs]);
    leaf.extend(vec![-1.5; outputs]);
    leaf.extend(vec![1.25; outputs]);
    leaf.extend((0..outputs * (inputs + 1)).map(|k| 0.25 * (k % 5) as f64 - 0.5));
    leaf
}

#[test]
fn the_moving_horizon_estimator_is_emitted_as_rust() {
    let plant = plant(&["x2", "-x1 - 0.5*x2*exp(-x1^2) + u1*cos(t)"], &["x1*sqrt(1 + x2^2)"], 1);
    let noises = NoiseModel { w: dmatrix![0.5, 0.1; 0.1, 0.25], v: dmatrix![0.125], p0: dmatrix![1.0, 0.0; 0.0, 2.0] };
    let horizon = Horizon { window: 3, iterations: 2 };
    let estimator = MovingHorizon::new(plant, noises, horizon, 0.0625, 2).unwrap();
    let (lower, upper) = (dvector![-0.125, f64::NEG_INFINITY], dvector![0.125, 0.25]);
    let export =
        export(ExportableObserver::MovingHorizon(estimator.with_bounds(lower, upper).unwrap()), Scalar::Binary32);
    unchanged(&export, "moving_horizon");
    agrees!(moving_horizon, &export, f32);
}

#[test]
fn the_numerical_kkl_observer_is_emitted_as_rust() {
    let plant = plant(&["x2^3", "-sin(x1)"], &["x1"], 0);
    let node = |axis, below, above| Node { axis, threshold: 0.125, below, above };
    let split = vec![node(1, Branch::Leaf(1), Branch::Leaf(0))];
    let inverse = PolynomialTree::new(1, split, [leaf(0.25, 3, 2), leaf(-0.25, 3, 2)].concat()).unwrap();
    let forward = PolynomialTree::new(1, Vec::new(), leaf(0.0, 2, 3)).unwrap();
    let whiten = SMatrix::<f64, 3, 3>::from_fn(|i, j| 1.0 / (1.0 + i as f64 + j as f64));
    let coordinates = Coordinates::new(SVector::from([0.125, 0.25, 0.0]), whiten, whiten.transpose()).unwrap();
    let bounds = (SVector::from([-1.0, -1.0]), SVector::from([1.0, 0.75]));
    let inverse = PolynomialInverse::new(coordinates, bounds, inverse, forward).unwrap();
    let d = SMatrix::from_diagonal(&SVector::from([-1.0, -2.0, -3.0]));
    let filter = SampledFilter { d, b: SVector::from([1.0, 0.5, -0.25]), period: 0.125, substeps: 2 };
    let program = ExportableObserver::Kkl(Kkl::new(&plant, filter, inverse).unwrap());
    let export = export(program, Scalar::Binary32);
    unchanged(&export, "kkl");
    agrees!(kkl, &export, f32);
}

#[test]
fn the_numerical_kkl_observer_with_a_table_of_low_rank_is_emitted_as_rust() {
    let plant = plant(&["x2", "x3", "x4", "x5", "-sin(x1) - x5"], &["x1"], 0);
    let inverse = PolynomialTree::new(1, Vec::new(), leaf(0.25, 6, 5)).unwrap();
    let forward = PolynomialTree::new(1, Vec::new(), leaf(0.0, 5, 6)).unwrap();
    let whiten = SMatrix::<f64, 6, 6>::from_fn(|i, j| 1.0 / (1.0 + i as f64 + j as f64));
    let coordinates = Coordinates::new(SVector::repeat(0.125), whiten, whiten.transpose()).unwrap();
    let (lower, upper) = (SVector::repeat(-1.0), SVector::from([1.0, 0.75, 1.0, 1.0, 0.5]));
    let start = PolynomialInverse::new(coordinates, (lower, upper), inverse, forward).unwrap();
    // 4 x 6 x 2 and 5 x 2 x 3, 4 x 3 x 2, 4 x 2 x 1, 4 x 1 x 1.
    let coefficients = (0..114).map(|k| 0.25 * f64::from((k * k) % 7) - 0.5).collect();
    let train = TensorTrain::<f64, Vec<f64>, 5, 6>::new(lower, upper, [2, 3, 2, 2, 2], [6, 2, 3, 2, 1], coefficients);
    let search = Search { max_evaluations: 6, tolerance: 0.125, fallback: 2 };
    let inverse = InterpolatedInverse::new(train.unwrap(), start, search).unwrap();
    let d = SMatrix::from_diagonal(&SVector::from([-1.0, -2.0, -3.0, -1.5, -2.5, -0.5]));
    let b = SVector::from([1.0, 0.5, -0.25, 1.0, 1.0, 0.25]);
    let filter = SampledFilter { d, b, period: 0.125, substeps: 2 };
    let export = export(ExportableObserver::Kkl(Kkl::new(&plant, filter, inverse).unwrap()), Scalar::Binary64);
    unchanged(&export, "kkl_low_rank");
    agrees!(kkl_low_rank, &export, f64);
}

#[test]
fn the_numerical_kkl_observer_for_held_inputs_is_emitted_as_rust() {
    let plant = plant(&["x2^3 + u1", "-sin(x1)"], &["x1"], 1);
    let whiten = SMatrix::<f64, 3, 3>::from_fn(|i, j| 1.0 / (1.0 + i as f64 + j as f64));
    let coordinates = Coordinates::new(SVector::from([0.125, 0.25, 0.0]), whiten, whiten.transpose()).unwrap();
    let (lower, upper) = (SVector::from([-1.0, -1.0]), SVector::from([1.0, 0.75]));
    let d = SMatrix::from_diagonal(&SVector::from([-1.0, -2.0, -3.0]));
    let filter = SampledFilter { d, b: SVector::from([1.0, 0.5, -0.25]), period: 0.125, substeps: 2 };
    let inverse = PolynomialTree::<f64, _, _, 4, 2>::new(1, Vec::new(), leaf(0.25, 4, 2)).unwrap();
    let forward = PolynomialTree::<f64, _, _, 3, 3>::new(1, Vec::new(), leaf(0.0, 3, 3)).unwrap();
    let family = ([-0.0625].into(), [0.125].into());
    let trees = HeldInputTrees::new(coordinates, (lower, upper), family, (inverse.clone(), forward)).unwrap();
    let first = SVector::from([0.25]);
    let embedded = Kkl::held::<_, 2, 1, 3, 5>(&plant, filter, trees, first).unwrap();
    let embedded = export(ExportableObserver::Kkl(embedded), Scalar::Binary64);
    unchanged(&embedded, "kkl_held");
    agrees!(kkl_held, &embedded, f64, kkl_held::first_input());

    let spline = |scale: f64| {
        let coefficients = (0..48).map(|k| scale * f64::from((k * k) % 7) - 0.5).collect();
        TensorSpline::<f64, Vec<f64>, 2, 3>::new(lower, upper, [2, 2], coefficients).unwrap()
    };
    let tables = HeldInputTables::new(coordinates, vec![-0.0625, 0.125], vec![spline(0.25), spline(-0.125)]).unwrap();
    let search = Search { max_evaluations: 6, tolerance: 0.125, fallback: 3 };
    let inverse = HeldInputInverse::new(tables, inverse, Some(search)).unwrap();
    let accurate = Kkl::held::<_, 2, 1, 3, 5>(&plant, filter, inverse, first).unwrap();
    let accurate = export(ExportableObserver::Kkl(accurate), Scalar::Binary32);
    unchanged(&accurate, "kkl_held_table");
    agrees!(kkl_held_table, &accurate, f32, kkl_held_table::first_input());
}
