//! Plants over numbers, evaluated as graphs: values are those of the tape, Jacobians those of dual numbers and of
//! differences.

use luenberger_expression::{
    Expression, ExpressionPlant, Extrapolation, Interpolation, LookupTable, Parameters, Scope, Surface, Table, Tables,
};
use luenberger_plants::{Differentiable, Plant, binary32};
use nalgebra::{DVector, dvector};
use num_dual::Dual32;
use proptest::prelude::*;

fn scope() -> Scope {
    let (x, y) = ([-2.0, -0.5, 0.25, 1.5, 3.0], [1.0, -0.5, 0.25, 2.0, 2.5]);
    let table =
        |interpolation, extrapolation| LookupTable::from(Table::new(&x, &y, interpolation, extrapolation).unwrap());
    let z: Vec<Vec<f64>> = y.iter().map(|a| x[..4].iter().map(|b| a * b - 0.3 * b * b).collect()).collect();
    let surface = Surface::new(&x, &[-1.5, 0.5, 1.0, 2.0], &z, Extrapolation::Linear).unwrap();
    let tables = Tables::from([
        ("surface".to_owned(), surface.into()),
        ("line".to_owned(), table(Interpolation::Linear, Extrapolation::Hold)),
        ("cubic".to_owned(), table(Interpolation::MonotoneCubic, Extrapolation::Linear)),
    ]);
    let parameters = Parameters::from([("k".to_owned(), 0.7), ("J".to_owned(), -1.3)]);
    Scope::plant(3, 1).with(&parameters).unwrap().tables(&tables).unwrap()
}

fn plant(text: &str) -> ExpressionPlant {
    ExpressionPlant::within(&[text, "x1", "x2"], &["x3"], &scope()).unwrap_or_else(|error| panic!("{text}: {error}"))
}

/// Expressions of every kind of operation, of up to five levels.
fn texts() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        3 => prop::sample::select(vec!["x1", "x2", "x3"]).prop_map(str::to_owned),
        1 => prop::sample::select(vec!["u1", "t", "k", "J", "pi"]).prop_map(str::to_owned),
        1 => (-3.0..3.0f64).prop_map(|x| format!("({x:.3})")),
    ];
    leaf.prop_recursive(4, 24, 3, |inner| {
        let one = prop::sample::select(vec![
            "sin", "cos", "tan", "exp", "tanh", "atan", "sinh", "cosh", "asinh", "abs", "sign", "step", "floor",
            "wrap", "line", "cubic", "sqrt", "ln", "log10", "asin", "acos", "acosh", "atanh", "sat",
        ]);
        let two = prop::sample::select(vec!["+", "-", "*", "/"]);
        let both = (inner.clone(), inner.clone());
        prop_oneof![
            4 => (one, inner.clone()).prop_map(|(name, x)| format!("{name}({x})")),
            5 => (two, both.clone()).prop_map(|(sign, (x, y))| format!("({x} {sign} {y})")),
            1 => (inner.clone(), -3..7i32).prop_map(|(x, n)| format!("({x})^({n})")),
            1 => both.clone().prop_map(|(x, y)| format!("(1 + abs({x}))^({y})")),
            1 => (prop::sample::select(vec!["min", "max", "atan2", "surface"]), both.clone())
                .prop_map(|(name, (x, y))| format!("{name}({x}, {y})")),
            // A quotient that is exactly an integer is a jump.
            1 => (prop::sample::select(vec!["mod", "wrap"]), both.clone())
                .prop_map(|(name, (x, y))| format!("{name}({x}, 0.31 + {y})")),
            1 => both.clone().prop_map(|(x, y)| format!("ln({x} + exp({y}))")),
            1 => inner.clone().prop_map(|x| format!("sat({x}, -0.5, 0.75)")),
            2 => (prop::sample::select(vec!["<", ">=", "=="]), both.clone(), both)
                .prop_map(|(sign, (a, b), (x, y))| format!("if({a} {sign} {b} || !({x} > 1), {x}, {y})")),
        ]
    })
}

/// Equal up to `share` of the larger one; NaN and infinities are equal to themselves.
fn near(a: f64, b: f64, share: f64) -> bool {
    a == b || a.is_nan() && b.is_nan() || (a - b).abs() <= share * (1.0 + a.abs().max(b.abs()))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    /// Rounding aside the value is that of the tape, and finite where that is.
    #[test]
    fn values_are_those_of_the_tape(text in texts(), x in prop::array::uniform3(-2.5..2.5f64), u in -2.0..2.0f64) {
        let (plant, tape) = (plant(&text), Expression::parse(&text, &scope()).unwrap());
        let (expected, found) = (tape.evaluate(0.3, &x, &[u]), plant.derivative(0.3, &dvector![x[0], x[1], x[2]], &dvector![u])[0]);
        prop_assert!(near(found, expected, 1e-9) || expected.abs() > 1e12, "{text} at {x:?}: {found} {expected}");
    }

    /// Where the derivatives by dual numbers exist, those of the graph are the same.
    #[test]
    fn jacobians_are_those_of_dual_numbers(text in texts(), x in prop::array::uniform3(-2.5..2.5f64), u in -2.0..2.0f64) {
        let tape = Expression::parse(&text, &scope()).unwrap();
        if let Ok(expected) = tape.gradient(0.3, &x, &[u]) {
            let found = plant(&text).state_jacobian(0.3, &dvector![x[0], x[1], x[2]], &dvector![u]);
            let scale = expected.iter().fold(0.0f64, |scale, slope| scale.max(slope.abs()));
            prop_assume!(scale < 1e9);
            for (j, expected) in expected.iter().enumerate() {
                prop_assert!((found[(0, j)] - expected).abs() <= 1e-7 * (1.0 + scale), "{text} at {x:?} by x{}: {} {expected}", j + 1, found[(0, j)]);
            }
        }
    }
}

/// Every function at points inside its domain: symmetric differences of the graph itself.
#[test]
fn jacobians_are_limits_of_differences() {
    let one = |name: &str| format!("{name}(x1)");
    let mut cases: Vec<(String, Vec<f64>)> = ["sin", "cos", "tan", "exp", "tanh", "atan", "sinh", "cosh", "asinh"]
        .iter()
        .map(|name| (one(name), vec![-1.2, -0.3, 0.0, 0.4, 1.1]))
        .collect();
    cases.extend(["sqrt", "ln", "log10"].iter().map(|name| (one(name), vec![0.2, 1.0, 2.7])));
    cases.extend(["asin", "acos", "atanh"].iter().map(|name| (one(name), vec![-0.8, 0.0, 0.6])));
    cases.push((one("acosh"), vec![1.3, 2.0]));
    cases.push((one("floor"), vec![-3.4, -0.3, 0.1, 2.9]));
    for name in ["abs", "sign", "step", "wrap", "line", "cubic", "sat"] {
        cases.push((one(name), vec![-3.0, -1.1, -0.3, 0.1, 0.9, 2.0, 4.0]));
    }
    for text in [
        "x1^5 - x1^(-3)",
        "x1^0.5",
        "x1^(-0.5)",
        "x1^1.7",
        "1.3^x1",
        "x1^x2",
        "atan2(x1, x2)",
        "atan2(x2, x1)",
        "mod(x1, x2)",
        "surface(x1, x2)",
        "surface(x2, x1)",
        "mod(2 + x2, x1)",
        "wrap(2 + x2, x1)",
        "wrap(7*x1)",
        "min(x1, x2)",
        "max(x1^2, x2)",
        "ln(0.3 + exp(x1))",
        "ln(exp(3*x1) + 2)",
        "ln(x2 + exp(x1*x2))",
        "if(x1 < 1, x1^2, 1/x1)",
        "x1/(1 + x1^2)",
        "sat(x1, 0.1*x2, x2)",
        "1/tanh(x1)",
    ] {
        cases.push((text.to_owned(), vec![0.3, 0.7, 1.6, 2.2]));
    }
    for (text, points) in cases {
        let plant = plant(&text);
        let u = dvector![0.4];
        for x1 in points {
            let at = |d: f64| plant.derivative(0.0, &dvector![x1 + d, 0.9, 0.0], &u)[0];
            let d = 1e-5;
            let expected = (at(d) - at(-d)) / (2.0 * d);
            let found = plant.state_jacobian(0.0, &dvector![x1, 0.9, 0.0], &u)[(0, 0)];
            assert!((found - expected).abs() <= 1e-8 * (1.0 + expected.abs()), "{text} at {x1}: {found} {expected}");
        }
    }
}

#[test]
fn what_is_not_taken_has_no_effect() {
    let at = |text: &str, x1: f64| {
        let x = dvector![x1, 0.5, 0.0];
        let plant = plant(text);
        (plant.derivative(0.0, &x, &dvector![0.0])[0], plant.state_jacobian(0.0, &x, &dvector![0.0])[(0, 0)])
    };
    // The other branch is 0/0, a root or a logarithm of a negative number, without a value or a derivative.
    assert_eq!(at("if(x1 == 0, 1, sin(x1)/x1)", 0.0), (1.0, 0.0));
    assert_eq!(at("if(x1 > 0, sqrt(x1), 2*x1)", -4.0), (-8.0, 2.0));
    assert_eq!(at("if(x1 > 0, x1*ln(x1), 0)", -1.0), (0.0, 0.0));
    assert_eq!(at("if(x1 > 0, 1/x1, 3*x1)", 0.0), (0.0, 3.0));
    // The value exists, the derivative does not.
    let (value, slope) = at("sqrt(x1)", 0.0);
    assert!(value == 0.0 && slope == f64::INFINITY);
    // By x3 there is nothing to differentiate.
    let plant = plant("sqrt(x1)");
    assert_eq!(plant.state_jacobian(0.0, &dvector![0.0, 0.0, 0.0], &dvector![0.0])[(0, 2)], 0.0);
    // x^n at 0.
    assert_eq!(at("x1^1.5", 0.0), (0.0, 0.0));
    assert_eq!(at("x1^3", 0.0), (0.0, 0.0));
    assert!(at("0*ln(x1)", 0.0).0.is_nan());
}

#[test]
fn not_a_number_is_kept() {
    for text in [
        "max(x1, 0)",
        "min(x1, 0)",
        "sat(x1)",
        "abs(x1)",
        "sign(x1)",
        "step(x1)",
        "floor(x1)",
        "wrap(x1)",
        "mod(x1, 2)",
        "line(x1)",
        "cubic(x1)",
        "x1^2",
    ] {
        let value = plant(text).derivative(0.0, &dvector![f64::NAN, 0.5, 0.0], &dvector![0.0])[0];
        assert!(value.is_nan(), "{text}: {value}");
    }
}

#[test]
fn common_parts_are_computed_once() {
    let rows = ["sin(x1)*cos(x2) + sin(x1)", "x2*sin(x1) - (x1 + x2)^3", "(x2 + x1)^2"];
    let plant = ExpressionPlant::within(&rows, &["x1 + x2"], &scope()).unwrap();
    let routines = plant.routines();
    assert_eq!((routines.f.len(), routines.motion.len(), routines.measurement.len()), (3, 12, 4));
    // sin, cos, 2 products, sum; x1 + x2, its square and cube, difference.
    assert_eq!(routines.f.operations(), 9);
    assert_eq!(routines.h.operations(), 1);
    // Two functions only, of f and Df together.
    assert_eq!(routines.motion.functions().len(), 2);
    assert_eq!(routines.measurement.constant(1), Some(1.0));
}

/// Over binary32 the same graph: every operation is rounded to it.
#[test]
fn single_precision_is_the_same_plant() {
    let plant = plant("x1^3 - 0.1*sin(x2) + line(x3)");
    let found = plant.derivative(0.0f32, &DVector::from_row_slice(&[1.1f32, 0.3, 0.7]), &dvector![0.0])[0];
    let share = (0.7f32 - 0.25) / (1.5 - 0.25);
    let table = 0.25f32 + (2.0 - 0.25) * share;
    assert_eq!(found, 1.1f32 * 1.1 * 1.1 - 0.1 * binary32::sin(0.3) + table);
}

/// Four functions over binary32 and its dual numbers are those of `binary32`, and their derivatives are of the same.
#[test]
fn functions_without_doubles_over_binary32() {
    let (x, eps) = (0.7_f32, 3.0);
    let tan = binary32::tan(x);
    for (text, value, slope) in [
        ("sin(x1)", binary32::sin(x), binary32::cos(x)),
        ("cos(x1)", binary32::cos(x), -binary32::sin(x)),
        ("tan(x1)", tan, 1.0 + tan * tan),
        ("asin(x1)", binary32::asin(x), 1.0 / (1.0 - x * x).sqrt()),
    ] {
        let expression = Expression::parse(text, &Scope::plant(1, 0)).unwrap();
        assert_eq!(expression.evaluate(0.0, &[x], &[]), value, "{text}");
        let dual = expression.evaluate(Dual32::from_re(0.0), &[Dual32::new(x, eps)], &[]);
        assert_eq!((dual.re, dual.eps), (value, slope * eps), "{text}");
        let plant = ExpressionPlant::new(&[text], &["x1"], 0, &Parameters::new()).unwrap();
        let jacobian: f32 = plant.state_jacobian(0.0, &dvector![x], &DVector::zeros(0))[(0, 0)];
        assert!((jacobian - slope).abs() <= 2.0 * f32::EPSILON * slope.abs(), "{text}: {jacobian}, {slope}");
        let double = expression.evaluate(0.0, &[f64::from(x)], &[]);
        assert!((f64::from(value) - double).abs() <= f64::from(f32::EPSILON) * double.abs(), "{text}");
    }
}
