//! Plants of the papers written as text are those written in Rust.

use luenberger_expression::{ExpressionPlant, ExpressionPlantError, Parameters, Row};
use luenberger_plants::{
    Chaotic, Column, CukConverter, Differentiable, Dimensions, Plant, ReverseDuffing, Shape, VanDerPol, flexible_joint,
};
use nalgebra::{Const, DVector, OVector, Vector2, dmatrix, dvector};
use proptest::prelude::*;

fn parameters(named: &[(&str, f64)]) -> Parameters {
    named.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
}

fn plant(f: &[&str], h: &[&str], inputs: usize, named: &[(&str, f64)]) -> ExpressionPlant {
    ExpressionPlant::new(f, h, inputs, &parameters(named)).unwrap_or_else(|error| panic!("{error}"))
}

fn chaotic() -> ExpressionPlant {
    plant(&["ln(0.1 + exp(x2 - x1))", "x1*x3", "0.2 - x1*x2"], &["x1", "x2"], 0, &[])
}

fn joint() -> ExpressionPlant {
    let f = ["x2", "-48.6*x1 - 1.25*x2 + 48.6*x3 + 21.6*u1", "x4", "19.5*x1 - 19.5*x3 - 3.33*sin(x3)"];
    plant(&f, &["x1", "x2"], 1, &[])
}

fn cuk() -> ExpressionPlant {
    let f = ["(-(1 - u1)*x2 + E)/L1", "((1 - u1)*x1 + u1*x3)/C2", "(-u1*x2 - x4)/L3", "(x3 - G*x4)/C4"];
    let c = CukConverter::default();
    let named = [("L1", c.l1), ("C2", c.c2), ("L3", c.l3), ("C4", c.c4), ("G", c.g), ("E", c.e)];
    plant(&f, &["x2", "x3"], 1, &named)
}

/// Two plants at one point: the largest difference of f, h, Df and Dh, relative to the largest entry.
fn apart<S, const N: usize, const M: usize, const P: usize>(
    text: &ExpressionPlant,
    rust: &S,
    t: f64,
    x: &OVector<f64, Const<N>>,
    u: &OVector<f64, Const<M>>,
) -> f64
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<P>>,
{
    assert_eq!(text.dimensions(), Dimensions { states: N, inputs: M, outputs: P });
    let (dx, du) = (DVector::from_slice(x.as_slice()), DVector::from_slice(u.as_slice()));
    let far = |found: &[f64], expected: &[f64]| {
        let scale = expected.iter().fold(1.0f64, |scale, entry| scale.max(entry.abs()));
        found.iter().zip(expected).fold(0.0f64, |far, (a, b)| far.max((a - b).abs())) / scale
    };
    far(text.derivative(t, &dx, &du).as_slice(), rust.derivative(t, x, u).as_slice())
        .max(far(text.output(t, &dx, &du).as_slice(), rust.output(t, x, u).as_slice()))
        .max(far(text.state_jacobian(t, &dx, &du).as_slice(), rust.state_jacobian(t, x, u).as_slice()))
        .max(far(text.output_jacobian(t, &dx, &du).as_slice(), rust.output_jacobian(t, x, u).as_slice()))
}

/// Rounding of a right-hand side of some ten operations, relative to its largest term.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

proptest! {
    /// The same right-hand sides, outputs and Jacobians wherever they are evaluated.
    #[test]
    fn the_papers_plants_are_those_written_in_rust(
        x in prop::array::uniform4(-5.0..5.0f64), u in -2.0..2.0f64, t in 0.0..9.0f64,
    ) {
        let (x2, x3, x4) = ([x[0], x[1]].into(), [x[0], x[1], x[2]].into(), x.into());
        let u = [u].into();
        prop_assert!(apart(&chaotic(), &Chaotic, t, &x3, &[].into()) <= ROUNDING);
        prop_assert!(apart(&joint(), &flexible_joint::classical(), t, &x4, &u) <= ROUNDING);
        prop_assert!(apart(&cuk(), &CukConverter::default(), t, &x4, &u) <= ROUNDING);
        let duffing = plant(&["x2^3", "-x1"], &["x1"], 0, &[]);
        prop_assert!(apart(&duffing, &ReverseDuffing, t, &x2, &[].into()) <= ROUNDING);
        let oscillator = plant(&["x2", "mu*(1 - x1^2)*x2 - x1"], &["x1"], 0, &[("mu", 1.5)]);
        let rust = VanDerPol { mu: 1.5 };
        prop_assert!(apart(&oscillator, &rust, t, &x2, &[].into()) <= ROUNDING);
        // And with the sizes in the type.
        let fixed = joint().fixed::<4, 1, 2>().unwrap();
        let (found, expected) =
            (fixed.derivative(t, &x4, &u), joint().derivative(t, &dvector![x[0], x[1], x[2], x[3]], &dvector![u[0]]));
        prop_assert_eq!(found.as_slice(), expected.as_slice());
    }
}

/// Single precision runs it.
#[test]
fn single_precision_differs_by_rounding() {
    let single = joint().derivative(0.0f32, &dvector![0.1, 0.2, 0.3, 0.4], &dvector![0.5]);
    let double = joint().derivative(0.0, &dvector![0.1, 0.2, 0.3, 0.4], &dvector![0.5]);
    assert!(single.iter().zip(&double).all(|(a, b)| (f64::from(*a) - b).abs() <= 1e2 * f64::from(f32::EPSILON)));
}

/// A linear plant in text has its matrices, whatever the form of its rows; a nonlinear one says which part is not.
#[test]
fn linear_plants_are_found_out() {
    let text = plant(
        &["x2/T", "(u1 - c*x1 - 2*(x2 + u2*k))/m"],
        &["x1 - x2", "k*x2"],
        2,
        &[("T", 0.5), ("c", 3.0), ("m", 4.0), ("k", 0.25)],
    );
    let affine = text.affine().unwrap();
    assert!(affine.is_linear());
    assert_eq!(affine.linear.a, dmatrix![0.0, 2.0; -0.75, -0.5]);
    assert_eq!(affine.linear.b, dmatrix![0.0, 0.0; 0.25, -0.125]);
    assert_eq!(affine.linear.c, dmatrix![1.0, -1.0; 0.0, 0.25]);
    let offset = plant(&["1 - x1"], &["x1 + 2"], 0, &[]).affine().unwrap();
    assert!(!offset.is_linear());
    assert_eq!((offset.f0, offset.h0), (dvector![1.0], dvector![2.0]));
    let error = joint().affine().unwrap_err();
    assert_eq!(
        error.to_string(),
        "f4 = 19.5*x1 - 19.5*x3 - 3.33*sin(x3) is not affine in states and inputs: `sin(x3)` is not"
    );
    assert!(matches!(plant(&["x1/0"], &["x1"], 0, &[]).affine(), Err(ExpressionPlantError::Undefined { .. })));
}

/// An output may use the input: its value, its Jacobian at that input, and D of an affine plant.
#[test]
fn outputs_may_use_the_input() {
    let text = plant(&["x2", "-x1 + u1"], &["x1", "x2*u1 + t"], 1, &[]);
    assert_eq!(text.feedthrough(), Some(1));
    let (x, u) = (dvector![2.0, 3.0], dvector![5.0]);
    assert_eq!(text.output(0.5, &x, &u), dvector![2.0, 15.5]);
    assert_eq!(text.output_jacobian(0.5, &x, &u), dmatrix![1.0, 0.0; 0.0, 5.0]);
    assert!(text.affine().is_err());
    let affine = plant(&["x2", "-x1 + u1"], &["x1", "2*x2 - u1/4 + 1"], 1, &[]).affine().unwrap();
    assert_eq!(affine.linear.d, Some(dmatrix![0.0; -0.25]));
    assert!(!affine.is_linear());
    assert_eq!(affine.h0, dvector![0.0, 1.0]);
    assert_eq!(plant(&["u1"], &["x1"], 1, &[]).affine().unwrap().linear.d, None);
}

/// Bad plants, each with its numbers.
#[test]
fn bad_plants_are_refused() {
    let new = |f: &[&str], h: &[&str], named: &[(&str, f64)]| {
        ExpressionPlant::new(f, h, 1, &parameters(named)).unwrap_err().to_string()
    };
    assert_eq!(new(&[], &["x1"], &[]), "a plant needs at least one state and one output: f has 0 rows, h has 1");
    assert_eq!(
        new(&["x2", "x3"], &["x1"], &[]),
        "f2: line 1, column 1: there is no `x3`: there are 2 states, x1 to x2"
    );
    assert_eq!(new(&["x1"], &["x1", "u2"], &[]), "h2: line 1, column 1: there is no `u2`: there is one input, u1");
    assert_eq!(new(&["x1"], &["x1"], &[("sin", 1.0)]), "`sin` cannot be the name of a parameter: it is a function");
    assert_eq!(new(&["x1"], &["x1"], &[("k", f64::NAN)]), "the parameter `k` is NaN, not a finite number");
    assert!(new(&["x1"], &["x1"], &[("a b", 1.0)]).contains("letters, digits and _"));
    assert!(new(&["x1"; 1001], &["x1"], &[]).contains("at most 1000"));

    let text = plant(&["x2", "u1/(x1 - 1)"], &["ln(x2)"], 1, &[]);
    let at = |x: &[f64], u: &[f64]| text.check_at(0.0, x, u);
    assert!(at(&[2.0, 1.0], &[1.0]).is_ok());
    let error = at(&[1.0, 1.0], &[2.0]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "f2 = u1/(x1 - 1): `u1/(x1 - 1)` is infinite: `u1` is 2 and `(x1 - 1)` is 0, at x = [1.0, 1.0], u = [2.0]"
    );
    assert!(matches!(at(&[2.0, 0.0], &[0.0]), Err(ExpressionPlantError::Undefined { row: Row::Output(0), .. })));
    assert!(matches!(at(&[2.0], &[0.0]), Err(ExpressionPlantError::Length { expected: 2, found: 1, .. })));
    assert!(matches!(at(&[2.0, f64::INFINITY], &[0.0]), Err(ExpressionPlantError::NotFinite { index: 1, .. })));
    assert!(matches!(text.fixed::<2, 1, 2>(), Err(ExpressionPlantError::Sizes { .. })));
    assert_eq!(
        text.fixed::<2, 1, 1>().unwrap().output(0.0, &Vector2::new(0.0, 1.0), &nalgebra::Vector1::new(0.0))[0],
        0.0
    );
}
