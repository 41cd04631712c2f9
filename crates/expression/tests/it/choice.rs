//! Conditions, `if`, `step`, lookup tables, and parameters that depend on parameters.

use luenberger_expression::{
    Definition, DerivedError, Expression, ExpressionErrorKind, ExpressionPlant, Extrapolation, Interpolation,
    LookupTable, Parameters, Scope, Surface, Table, TableError, Tables, derived,
};
use luenberger_plants::Differentiable;
use nalgebra::{dmatrix, dvector};
use proptest::prelude::*;

/// Three states, an input, a parameter, and the tables `line` and `cubic` through the same points.
fn scope() -> Scope {
    let table =
        |interpolation, extrapolation| LookupTable::from(Table::new(&X, &Y, interpolation, extrapolation).unwrap());
    let tables = Tables::from([
        ("line".to_owned(), table(Interpolation::Linear, Extrapolation::Hold)),
        ("cubic".to_owned(), table(Interpolation::MonotoneCubic, Extrapolation::Linear)),
    ]);
    Scope::plant(3, 1).with(&Parameters::from([("k".to_owned(), 2.0)])).unwrap().tables(&tables).unwrap()
}

const X: [f64; 6] = [0.0, 1.0, 1.5, 4.0, 5.0, 7.0];
const Y: [f64; 6] = [1.0, 3.0, 2.0, 2.0, 6.0, -1.0];

fn parse(text: &str) -> Expression {
    Expression::parse(text, &scope()).unwrap_or_else(|error| panic!("{text}: {error}\n{}", error.pointer()))
}

fn at(text: &str, x: [f64; 3]) -> f64 {
    parse(text).evaluate(0.5, &x, &[4.0])
}

/// x, y and z of a table of two variables.
fn grid() -> (Vec<f64>, Vec<f64>, Vec<Vec<f64>>) {
    let z = vec![vec![1.0, 3.0, 2.0], vec![0.0, -2.0, 5.0], vec![4.0, 4.0, -1.0], vec![2.0, 0.5, 7.0]];
    (vec![0.0, 1.0, 1.5, 4.0], vec![-1.0, 0.5, 2.0], z)
}

/// The values are those of scipy 1.17's `RegularGridInterpolator`, whose extrapolation is the linear one.
#[test]
fn tables_of_two_variables_are_bilinear() {
    let (x, y, z) = grid();
    let [hold, beyond] =
        [Extrapolation::Hold, Extrapolation::Linear].map(|kind| Surface::new(&x, &y, &z, kind).unwrap());
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-14, "{found}, expected {expected}");
    for ((x, y), expected) in [
        ((0.25, 0.0), 1.416_666_666_666_666_7),
        ((1.2, 1.7), 2.16),
        ((3.0, -0.5), 2.5),
        ((1.5, 0.5), 4.0),
        ((4.0, 2.0), 7.0),
        ((1.0, 1.0), 0.333_333_333_333_333),
    ] {
        near(hold.at(x, y), expected);
        near(beyond.at(x, y), expected);
    }
    for ((x, y), (line, held)) in [
        ((-1.0, 0.0), (6.0, 2.333_333_333_333_333_5)),
        ((5.0, 3.0), (17.6, 7.0)),
        ((2.0, 4.0), (-3.0, 0.6)),
        ((9.0, -2.0), (1.0, 2.0)),
    ] {
        near(hold.at(x, y), held);
        near(beyond.at(x, y), line);
    }
    let scope = Scope::plant(2, 0).tables(&Tables::from([("map".to_owned(), hold.clone().into())])).unwrap();
    let expression = Expression::parse("1 + map(2*x1, x2)", &scope).unwrap();
    assert_eq!(
        (expression.to_string().as_str(), expression.evaluate(0.0, &[2.0, 2.0], &[])),
        ("1.0 + map(2.0*x1, x2)", 8.0)
    );
    assert_eq!(expression.formula().latex, "1 + \\mathrm{map}\\left(2 x_{1}, x_{2}\\right)");
    // By hand, between 0 and 1 and between -1 and 0.5: 1 - x + 4 (y + 1)/3 - 8 x (y + 1)/3, half of it at y = -0.25.
    let slopes = Expression::parse("map(x1, x2)", &scope).unwrap().gradient(0.0, &[0.5, -0.25], &[]).unwrap();
    near(slopes[0], -1.0 - 2.0);
    near(slopes[1], 0.0);
    for (text, message) in [
        ("map(x1)", "`map` is a lookup table and takes two arguments"),
        ("map(x1, x2, 1)", "`map` is a lookup table and takes two arguments"),
        ("map", "`map` is a function: write `map(...)`"),
    ] {
        let error = Expression::parse(text, &scope).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
    assert!(ExpressionPlant::within(&["map(x1, 2)", "x1"], &["x1"], &scope).unwrap().affine().is_err());
}

#[test]
fn grids_that_are_none_are_refused() {
    let (x, y, z) = grid();
    let refused =
        |x: &[f64], y: &[f64], z: &[Vec<f64>]| Surface::new(x, y, z, Extrapolation::Hold).unwrap_err().to_string();
    assert_eq!(refused(&x[..3], &y, &z), "x has 3 entries, and z has 4 rows");
    assert_eq!(refused(&x, &y[..2], &z), "y has 2 entries, and row 1 of z has 3");
    assert_eq!(refused(&[0.0, 1.0, 1.0, 4.0], &y, &z), "x must increase: entry 3 is 1, after 1");
    assert_eq!(refused(&x, &[2.0, 1.0, 3.0], &z), "along y: x must increase: entry 2 is 1, after 2");
    assert_eq!(refused(&x[..1], &y, &z[..1]), "a table needs two points or more: it has 1");
    let mut bad = z.clone();
    bad[2][1] = f64::INFINITY;
    assert_eq!(refused(&x, &y, &bad), "entry 2 of row 3 of z is inf, not a finite number");
}

#[test]
fn values_of_conditions_and_choices() {
    let x = [1.0, -2.0, 3.0];
    for (text, expected) in [
        ("if(x1 > 0, 5, 7)", 5.0),
        ("if(x1 > 1, 5, 7)", 7.0),
        ("if(x1 >= 1, 5, 7)", 5.0),
        ("if(x2 < -2, 5, 7)", 7.0),
        ("if(x2 <= -2, 5, 7)", 5.0),
        ("if(x1 == 1, 5, 7) + if(x1 != 1, 10, 20)", 25.0),
        ("if(x1 > 0 && x2 > 0, 5, 7)", 7.0),
        ("if(x1 > 0 || x2 > 0, 5, 7)", 5.0),
        ("if(!(x1 > 0) || x2 < 0 && x3 > 0, 5, 7)", 5.0),
        ("if((x1 > 0 || x2 > 0) && x3 < 0, 5, 7)", 7.0),
        // Sums bind tighter than comparisons, comparisons than &&, and that than ||.
        ("if(x1 + 1 > 1 && 2*x3 == 6 || 0 > 1, 5, 7)", 5.0),
        ("2*if(x1 > 0, x3, 1)^2 - 1", 17.0),
        ("x3^if(x1 > 0, 2, 3)", 9.0),
        ("x3^if(x1 < 0, 2, 3)", 27.0),
        ("ln(0 + if(x1 < 0, exp(x1), 1))", 0.0),
        ("if(x2 > 0, 1, if(x3 > 5, 2, if(t < 1, 3, 4)))", 3.0),
        ("if(if(x1 > 0, x2, x3) < 0, u1, -u1)", 4.0),
        ("max(if(x1 > 0, 1, 9), if(x1 < 0, 9, 2))", 2.0),
        ("-if(x1 > 0, 1, 2)", -1.0),
        ("step(x1) + 10*step(x2) + 100*step(0)", 101.0),
        ("line(0.5) + line(x1) + line(-3) + line(9)", 2.0 + 3.0 + 1.0 - 1.0),
        ("cubic(k*x1 - 1)", 3.0),
    ] {
        assert_eq!(at(text, x), expected, "{text}");
        let printed = parse(text).to_string();
        assert_eq!(at(&printed, x), expected, "{text} printed as {printed}");
        assert_eq!(parse(&printed).to_string(), printed);
    }
}

/// The branch that is not taken is not evaluated: it may be undefined there without an error.
#[test]
fn the_other_branch_is_not_evaluated() {
    let root = parse("if(x1 > 0, sqrt(x1), -sqrt(-x1))");
    assert_eq!(root.examine(0.0, &[4.0, 0.0, 0.0], &[0.0]), Ok(2.0));
    assert_eq!(root.examine(0.0, &[-9.0, 0.0, 0.0], &[0.0]), Ok(-3.0));
    assert_eq!(root.gradient(0.0, &[4.0, 0.0, 0.0], &[0.0]).unwrap(), [0.25, 0.0, 0.0]);
    let undefined = parse("1 + if(x1 > 0, 2*ln(x2), 0)").examine(0.0, &[1.0, -1.0, 0.0], &[0.0]).unwrap_err();
    assert_eq!(undefined.to_string(), "`ln(x2)` is not defined: `x2` is -1");
    // NaN satisfies no comparison but !=.
    assert_eq!(at("if(x1 < 0, 1, 2) + if(x1 != x1, 10, 20)", [f64::NAN, 0.0, 0.0]), 12.0);
    assert!(at("step(x1)", [f64::NAN, 0.0, 0.0]).is_nan() && at("line(x1)", [f64::NAN, 0.0, 0.0]).is_nan());
}

#[test]
fn derivatives_are_those_of_the_branch() {
    for (text, x1, expected) in [
        ("if(x1 > 1, x1^2, 2*x1 - 1)", 3.0, 6.0),
        ("if(x1 > 1, x1^2, 2*x1 - 1)", 0.5, 2.0),
        ("x1*step(x1)", 3.0, 1.0),
        ("x1*step(x1)", -3.0, 0.0),
        ("line(x1)", 0.5, 2.0),
        ("line(x1)", 4.5, 4.0),
        // On a point the piece after it.
        ("line(x1)", 1.0, -2.0),
        ("line(x1)", -1.0, 0.0),
        ("line(2*x1)", 0.25, 4.0),
    ] {
        let found = parse(text).gradient(0.0, &[x1, 0.0, 0.0], &[0.0]).unwrap();
        assert_eq!(found, [expected, 0.0, 0.0], "{text} at {x1}");
    }
    let plant = ExpressionPlant::within(&["if(x1 > x2, cubic(x1), u1)", "x1", "0*x3"], &["x1"], &scope()).unwrap();
    let (x, u) = (dvector![4.5, 0.0, 0.0], dvector![1.0]);
    assert_eq!(plant.state_jacobian(0.0, &x, &u), dmatrix![6.0, 0.0, 0.0; 1.0, 0.0, 0.0; 0.0, 0.0, 0.0]);
}

/// Values and derivatives of scipy 1.17.1, `PchipInterpolator(X, Y)`.
#[test]
fn the_monotone_cubic_is_scipys() {
    let table = [
        (0.0, 1.0, 4.666666666666667),
        (0.25, 1.9687500000000002, 3.125),
        (0.8, 2.9413333333333336, 0.6133333333333328),
        (1.0, 3.0, 0.0),
        (1.2, 2.6480000000000006, -2.88),
        (1.5, 2.0, 0.0),
        (2.0, 2.0, 0.0),
        (3.9, 2.0, 0.0),
        (4.5, 4.0, 6.0),
        (5.0, 6.0, 0.0),
        (5.5, 5.703125, -1.28125),
        (6.9, -0.18212500000000276, -7.861250000000002),
        (7.0, -1.0, -8.5),
    ];
    let cubic = parse("cubic(x1)");
    let close = |found: f64, expected: f64| (found - expected).abs() <= 64.0 * f64::EPSILON * (1.0 + expected.abs());
    for (x, value, slope) in table {
        let found = cubic.evaluate(0.0, &[x], &[]);
        assert!(close(found, value), "at {x}: {found}, expected {value}");
        let found = cubic.gradient(0.0, &[x], &[]).unwrap()[0];
        assert!(close(found, slope), "the slope at {x}: {found}, expected {slope}");
    }
    // Beyond the ends along the slopes there.
    assert!(close(cubic.evaluate(0.0, &[8.0], &[]), -9.5) && close(cubic.evaluate(0.0, &[-3.0], &[]), -13.0));
    let other = |x: &[f64], y: &[f64]| Table::new(x, y, Interpolation::MonotoneCubic, Extrapolation::Hold).unwrap();
    assert_eq!(other(&[0.0, 2.0], &[1.0, 5.0]).at(0.5), 2.0);
    let steps = other(&[0.0, 1.0, 2.0, 3.0], &[0.0, 0.1, 0.9, 1.0]);
    for (x, expected) in [(0.3, 0.010400000000000001), (1.5, 0.5), (2.7, 0.9896)] {
        assert!(close(steps.at(x), expected), "{x}");
    }
    let valley = other(&[0.0, 1.0, 3.0], &[0.0, -4.0, 5.0]);
    assert!(close(valley.at(0.5), -2.8541666666666665) && close(valley.at(2.0), -2.0416666666666665));
    // Monotone points and no overshoot, in single precision as well.
    assert!((steps.at(0.3f32) - 0.0104).abs() < 1e-8);
}

proptest! {
    /// A table goes through its points, and both kinds stay between two neighbours.
    #[test]
    fn tables_go_through_their_points(
        widths in prop::collection::vec(0.01..10.0f64, 1..12), y in prop::collection::vec(-9.0..9.0f64, 13), share in 0.0..1.0f64,
    ) {
        let x: Vec<f64> = std::iter::once(-3.0).chain(widths.iter().scan(-3.0, |x, width| { *x += width; Some(*x) })).collect();
        let y = &y[..x.len()];
        for interpolation in [Interpolation::Linear, Interpolation::MonotoneCubic] {
            let table = Table::new(&x, y, interpolation, Extrapolation::Hold).unwrap();
            for k in 0..x.len() {
                prop_assert!((table.at(x[k]) - y[k]).abs() <= 8.0 * f64::EPSILON * 9.0);
            }
            for k in 1..x.len() {
                let found = table.at(x[k - 1] + share * (x[k] - x[k - 1]));
                let (low, high) = (y[k - 1].min(y[k]), y[k - 1].max(y[k]));
                prop_assert!(found >= low - 1e-13 && found <= high + 1e-13, "{found} in {low} to {high}");
            }
        }
    }
}

#[test]
fn what_is_no_choice_and_no_table_is_refused() {
    for (text, expected) in [
        ("if(x1, 1, 2)", "line 1, column 4: `x1` is a number and not a condition, such as `x1 > 0`"),
        ("if(x1 > 0, 1)", "line 1, column 1: `if` takes three arguments: if(condition, x, y), and has 2"),
        ("if(x1 > 0, 1, 2, 3)", "line 1, column 1: `if` takes three arguments: if(condition, x, y), and has 4"),
        ("if()", "line 1, column 1: `if` takes three arguments: if(condition, x, y), and has 0"),
        (
            "2*(x1 > 0)",
            "line 1, column 3: `(x1 > 0)` is a condition and not a number: write `if((x1 > 0), 1, 0)` for a number",
        ),
        (
            "if(0 < x1 < 2, 1, 2)",
            "line 1, column 4: `0 < x1` is a condition and not a number: write `if(0 < x1, 1, 0)` for a number",
        ),
        ("if(x1 && x2 > 0, 1, 2)", "line 1, column 4: `x1` is a number and not a condition, such as `x1 > 0`"),
        ("if(!x1 > 0, 1, 2)", "line 1, column 5: `x1` is a number and not a condition, such as `x1 > 0`"),
        (
            "if(x1 > 0, x2 > 0, 2)",
            "line 1, column 12: `x2 > 0` is a condition and not a number: write `if(x2 > 0, 1, 0)` for a number",
        ),
        (
            "sin(x1 > 0)",
            "line 1, column 5: `x1 > 0` is a condition and not a number: write `if(x1 > 0, 1, 0)` for a number",
        ),
        ("line(1, 2)", "line 1, column 1: `line` is a lookup table and takes one argument"),
        ("line", "line 1, column 1: `line` is a function: write `line(...)`"),
        ("lime(x1)", "line 1, column 1: there is no function `lime`; did you mean `line`?"),
        ("where(x1 > 0, 1, 2)", "line 1, column 1: there is no function `where`; did you mean `if`?"),
        ("heaviside(x1)", "line 1, column 1: there is no function `heaviside`; did you mean `step`?"),
    ] {
        let error = Expression::parse(text, &scope()).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{text}: {error}");
    }
    let new = |x: &[f64], y: &[f64]| Table::new(x, y, Interpolation::Linear, Extrapolation::Hold).unwrap_err();
    assert_eq!(new(&[1.0], &[1.0]), TableError::TooFew { points: 1 });
    assert_eq!(new(&[1.0, 2.0], &[1.0]).to_string(), "x has 2 entries, and y has 1");
    assert_eq!(new(&[1.0, 1.0], &[1.0, 2.0]).to_string(), "x must increase: entry 2 is 1, after 1");
    assert_eq!(new(&[1.0, 2.0], &[1.0, f64::NAN]).to_string(), "entry 2 of y is NaN, not a finite number");
    assert!(matches!(new(&[0.0, 1e-300], &[-1e300, 1e300]), TableError::Slope { .. }));
    let table = LookupTable::from(Table::new(&X, &Y, Interpolation::Linear, Extrapolation::Hold).unwrap());
    for (name, meaning) in
        [("sin", "a function"), ("k", "a parameter"), ("x1", "a state"), ("a b", "no word of letters")]
    {
        let scope = Scope::plant(1, 0).with(&Parameters::from([("k".to_owned(), 2.0)])).unwrap();
        let error = scope.tables(&Tables::from([(name.to_owned(), table.clone())])).unwrap_err().to_string();
        assert!(
            error.starts_with(&format!("`{name}` cannot be the name of a lookup table: it is {meaning}")),
            "{error}"
        );
    }
}

#[test]
fn choices_that_are_affine_are_found_out() {
    for text in ["if(k > 1, x1, 2*x1)", "line(k)*x1", "if(k > 1 && k < 3, 1, 0)*u1", "step(k)*x1"] {
        assert_eq!(parse(text).affine(), Ok(()), "{text}");
    }
    for (text, part) in [
        ("if(x1 > 0, x1, 2*x1)", "if(x1 > 0, x1, 2*x1)"),
        ("line(x1) + x2", "line(x1)"),
        ("if(k > 1, x1, x1*x2)", "x1*x2"),
        ("step(x1)", "step(x1)"),
    ] {
        assert_eq!(parse(text).affine(), Err(part), "{text}");
    }
}

/// Deep and long choices are bounded like everything else.
#[test]
fn nested_choices_are_bounded() {
    let nested = |levels: usize| format!("{}0{}", "if(x1 > 0, 1, ".repeat(levels), ")".repeat(levels));
    assert_eq!(at(&nested(15), [-1.0, 0.0, 0.0]), 0.0);
    assert!(Expression::parse(&nested(500), &scope()).is_err());
    let many = format!("if({}, 1, 2)", vec!["x1 > 0"; 700].join(" && "));
    assert_eq!((at(&many, [1.0, 0.0, 0.0]), at(&many, [-1.0, 0.0, 0.0])), (1.0, 2.0));
    let right = format!("if({}x1 > 0{}, 1, 2)", "x1 < 0 || (".repeat(30), ")".repeat(30));
    assert_eq!(at(&right, [1.0, 0.0, 0.0]), 1.0);
    // Two conditions wait at each level.
    let waiting = |levels: usize| {
        let text =
            format!("if({}x1 > 0{}, 1, 2)", "x1 > 0 && !(x1 < 0) || x1 < 0 && (".repeat(levels), ")".repeat(levels));
        Expression::parse(&text, &scope())
    };
    assert_eq!(waiting(30).unwrap().evaluate(0.0, &[1.0, 0.0, 0.0], &[]), 1.0);
    assert_eq!(*waiting(40).unwrap_err().kind(), ExpressionErrorKind::TooDeep);
}

#[test]
fn parameters_may_depend_on_parameters() {
    let of = |list: &[(&str, &str)]| {
        let definition = |text: &str| match text.parse() {
            Ok(number) => Definition::Number(number),
            Err(_) => Definition::Text(text.to_owned()),
        };
        derived(&list.iter().map(|(name, text)| ((*name).to_owned(), definition(text))).collect())
    };
    let values = of(&[("a", "b*2"), ("b", "c + 1"), ("c", "3"), ("d", "if(a > b, pi, e)")]).unwrap();
    assert_eq!((values["a"], values["b"], values["d"]), (8.0, 4.0, std::f64::consts::PI));
    let error = |list: &[(&str, &str)]| of(list).unwrap_err();
    let circle = error(&[("a", "b"), ("b", "c"), ("c", "2*b"), ("d", "1")]);
    assert_eq!(circle.to_string(), "the parameters depend on each other in a circle: `b` -> `c` -> `b`");
    assert_eq!(error(&[("a", "a + 1")]).to_string(), "the parameters depend on each other in a circle: `a` -> `a`");
    assert_eq!(
        error(&[("a", "1/b"), ("b", "0")]).to_string(),
        "the parameter `a`: `1/b` is infinite: `1` is 1 and `b` is 0"
    );
    assert!(
        error(&[("a", "2*x1")])
            .to_string()
            .contains("a parameter is a number: it may depend on other parameters alone")
    );
    assert!(error(&[("a", "2*t")]).to_string().contains("a parameter is a number"));
    assert!(error(&[("a", "2*bb"), ("b", "1")]).to_string().ends_with("there is no `bb`; did you mean `b`?"));
    assert!(matches!(error(&[("sin", "1")]), DerivedError::Parameter(_)));
    assert_eq!(error(&[("a", "1/b"), ("b", "0")]).name(), "a");
}
