//! Recorded bodies have the bits of the body, for every kind of number.

use luenberger_expression::{
    ExpressionPlant, Extrapolation, Interpolation, Recorded, RecordingError, Scope, Table, Tables, record,
};
use luenberger_plants::{Differentiable, Plant};
use nalgebra::{DVector, RealField, convert};

const NUMBERS: [f64; 11] =
    [0.0, -0.0, 1.0, -2.5, 1e-310, 5e-324, 1e13, -1e300, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];

/// Compares the program of a body of two numbers with the body.
fn compare(program: impl Fn(&[Recorded]) -> Vec<Recorded>, body: impl Fn(&[f64]) -> Vec<f64>) {
    let routine = record(|recording| recording.program((2, 0), |_, x, _| program(x))).unwrap();
    for a in NUMBERS {
        for b in NUMBERS {
            let mut found = Vec::new();
            routine.evaluate(0.0, &[a, b], &[], |_, value| found.push(value));
            let expected = body(&[a, b]);
            let same = |(x, y): (&f64, &f64)| x.to_bits() == y.to_bits() || (x.is_nan() && y.is_nan());
            assert!(found.iter().zip(&expected).all(same), "{a:e} {b:e}: {found:?} {expected:?}");
        }
    }
}

fn signs<T: RealField + Copy>(x: &[T]) -> Vec<T> {
    let zero = T::zero();
    vec![x[0] + zero, zero - x[1], -(x[0] - x[1]), x[0] - zero, x[0] + (-x[1]), -x[0] * x[1], x[0] / -T::one()]
}

fn branches<T: RealField + Copy>(x: &[T]) -> Vec<T> {
    let held = |entry: T| entry.map_lanes(|entry| if entry.is_finite() { entry } else { T::zero() });
    let ordered = if x[0] < x[1] { x[1] - x[0] } else { x[0] };
    vec![held(x[0]), held(x[1] * x[0]), ordered, x[0].max(T::one()), x[1].min(T::one()), x[0].abs()]
}

fn limits<T: RealField + Copy>(x: &[T]) -> Vec<T> {
    let bound = T::max_value().map_or(x[0], |largest| largest.sqrt().sqrt());
    vec![x[0] * T::default_epsilon(), bound, x[1].map_lanes(|y| if y > bound { bound } else { y })]
}

#[test]
fn programs_have_the_bits_of_their_bodies() {
    compare(signs, signs);
    compare(branches, branches);
    compare(limits, limits);
}

/// The largest number and the epsilon are those of the format.
#[test]
fn limits_are_those_of_the_format() {
    let routine = record(|recording| recording.program((2, 0), |_, x, _| limits(x))).unwrap();
    let mut found = Vec::new();
    routine.evaluate(0.0_f32, &[1.0, 1e10], &[], |_, value| found.push(value));
    assert_eq!(found, [f32::EPSILON, f32::MAX.sqrt().sqrt(), f32::MAX.sqrt().sqrt()]);
}

fn all<T: RealField + Copy>(plant: &ExpressionPlant, x: &[T]) -> Vec<T> {
    let (x, u) = (DVector::from_column_slice(x), DVector::zeros(0));
    let (slope, jacobian) = (plant.derivative(T::zero(), &x, &u), plant.state_jacobian(T::zero(), &x, &u));
    slope.iter().chain(jacobian.iter()).copied().collect()
}

/// Choices and lookup tables of a plant are nodes: a body with ten of each has one path.
#[test]
fn plants_are_recorded_as_their_graph() {
    let table = Table::new(&[-1.0, 0.0, 2.0], &[0.5, 0.0, 1.5], Interpolation::MonotoneCubic, Extrapolation::Linear);
    let tables = Tables::from([("soft".to_owned(), table.unwrap().into())]);
    let scope = Scope::plant(2, 0).tables(&tables).unwrap();
    let row = (0..10).map(|k| format!("if(x1 > {k}, soft(x2), -x2/{})", k + 1)).collect::<Vec<_>>().join(" + ");
    let plant = ExpressionPlant::within(&[row.as_str(), "ln(0.1 + exp(x1)) - x2^3"], &["x1"], &scope).unwrap();
    compare(|x| all(&plant, x), |x| all(&plant, x));
}

#[test]
fn what_is_not_recorded_is_an_error() {
    let program = |body: &dyn Fn(&[Recorded]) -> Recorded| {
        record(|recording| recording.program((20, 0), |_, x, _| vec![body(x)])).map(|routine| routine.len())
    };
    let sorted = |x: &[Recorded]| x.iter().fold(convert(0.0), |sum, x| if *x > convert(0.0) { sum + *x } else { sum });
    assert!(matches!(program(&sorted), Err(RecordingError::Paths { .. })));
    let round = |x: &[Recorded]| nalgebra::ComplexField::round(x[0]);
    assert_eq!(program(&round), Err(RecordingError::Operation { name: "round" }));
    assert_eq!(program(&|x| nalgebra::ComplexField::floor(x[0])), Ok(1));
    // The next one is recorded.
    assert_eq!(program(&|x| x[0] + x[1]), Ok(1));
}
