//! Expressions: values, precedence, derivatives, printing, errors, and texts that are none.

use luenberger_expression::{Expression, ExpressionErrorKind, Family, Found, Parameters, Scope};
use proptest::prelude::*;

/// Three states, two inputs, two parameters.
fn scope() -> Scope {
    let parameters = [("k", 2.5), ("J_1", 0.3)].map(|(name, value)| (name.to_owned(), value));
    Scope::plant(3, 2).with(&Parameters::from(parameters)).unwrap()
}

const X: [f64; 3] = [0.7, -1.3, 2.1];
const U: [f64; 2] = [0.4, -0.9];
const T: f64 = 1.7;

/// A derivative in closed form.
type Derivative = fn(f64) -> f64;

fn parse(text: &str) -> Expression {
    Expression::parse(text, &scope()).unwrap_or_else(|error| panic!("{text}: {error}\n{}", error.pointer()))
}

fn value(text: &str) -> f64 {
    parse(text).evaluate(T, &X, &U)
}

fn kind(text: &str) -> ExpressionErrorKind {
    Expression::parse(text, &scope()).unwrap_err().kind().clone()
}

/// Each function and operation gives what Rust gives, to two roundings of its size.
#[test]
fn values_are_those_of_rust() {
    let [x1, x2, x3] = X;
    let [u1, u2] = U;
    let (k, j) = (2.5f64, 0.3f64);
    let table = [
        ("ln(0.1 + exp(x2 - x1))", (0.1 + (x2 - x1).exp()).ln()),
        ("ln(exp(x3) + k) - ln(-2 + exp(x3))", (x3.exp() + k).ln() - (x3.exp() - 2.0).ln()),
        ("ln(exp(x1) + exp(x3))", (x1.exp() + x3.exp()).ln()),
        ("x1*x3", x1 * x3),
        ("-k*sin(x1)^2 + u1/J_1", -k * x1.sin().powi(2) + u1 / j),
        ("abs(x2) + min(x1, x2, x3) - max(x1, u2)", x2.abs() + x2 - x1),
        ("sign(x2) + sign(x1) + sign(0)", 0.0),
        ("floor(x2) + floor(x3)", 0.0),
        ("mod(x2, x1)", 0.1),
        ("mod(x1, x2)", -0.6),
        ("wrap(x3^2)", x3 * x3 - 2.0 * std::f64::consts::PI),
        ("wrap(200*x2, 360)", 100.0),
        ("sat(x3)", 1.0),
        ("sat(x2)", -1.0),
        ("sat(x1)", x1),
        ("sat(x3, -3, 2)", 2.0),
        ("sat(x3, -k, k)", x3),
        ("sqrt(x1) + log10(x3)", x1.sqrt() + x3.log10()),
        ("cos(x1) - tan(x2)", x1.cos() - x2.tan()),
        ("asin(u1) + acos(u2) + atan(x3)", u1.asin() + u2.acos() + x3.atan()),
        ("atan2(x2, u2)", x2.atan2(u2)),
        ("atan2(x1, x3)", x1.atan2(x3)),
        ("sinh(x1) + cosh(x2) + tanh(x3)", x1.sinh() + x2.cosh() + x3.tanh()),
        ("asinh(x2) + acosh(x3) + atanh(u1)", x2.asinh() + x3.acosh() + u1.atanh()),
        ("pow(x3, x1) + x3^k", x3.powf(x1) + x3.powf(k)),
        ("x2^3 + x2^-2 + x3^0.5 + x3^-0.5", x2.powi(3) + 1.0 / (x2 * x2) + x3.sqrt() + 1.0 / x3.sqrt()),
        ("x3^(1/3)", x3.powf(1.0 / 3.0)),
        ("2*pi*t + e", 2.0 * std::f64::consts::PI * T + std::f64::consts::E),
        ("1e-3 + .5 + 2. + 1.5E+2", 0.001 + 0.5 + 2.0 + 150.0),
        ("x1**2", x1 * x1),
        (" x1 \n + x2\t", x1 + x2),
        ("+x1 - +x2", x1 - x2),
    ];
    for (text, expected) in table {
        let found = value(text);
        assert!((found - expected).abs() <= 4.0 * f64::EPSILON * (1.0 + expected.abs()), "{text}: {found} {expected}");
    }
}

/// The conventions of Python and MATLAB where they agree, of Python where they do not (`2^3^2`).
#[test]
fn precedence() {
    let table = [
        ("-x1^2", -(X[0] * X[0])),
        ("(-x1)^2", X[0] * X[0]),
        ("2^-1", 0.5),
        ("2^3^2", 512.0),
        ("(2^3)^2", 64.0),
        ("8 - 4 - 2", 2.0),
        ("8/4/2", 1.0),
        ("8/4*2", 4.0),
        ("2*-3", -6.0),
        ("--3", 3.0),
        ("1 - -1", 2.0),
        ("2^-1*4", 2.0),
        ("-2^-2", -0.25),
        ("2 + 3*4^2/8 - 1", 7.0),
        ("-2*3 + 1", -5.0),
        ("2^-3^2", 1.0 / 512.0),
    ];
    for (text, expected) in table {
        assert_eq!(value(text), expected, "{text}");
    }
}

/// Every function against its derivative in closed form, at x1 = 0.7 or at the point in the row.
#[test]
fn derivatives_are_the_closed_forms() {
    let table: [(&str, f64, Derivative); 38] = [
        ("abs(x1)", -0.4, |_| -1.0),
        ("sign(x1)", -0.4, |_| 0.0),
        ("floor(x1)", -0.4, |_| 0.0),
        ("wrap(3*x1)", 1.7, |_| 3.0),
        ("mod(x1, 2)", -4.7, |_| 1.0),
        // 7.3 - 10 x and 7.3 - 11 x.
        ("mod(7.3, x1)", 0.7, |_| -10.0),
        ("wrap(7.5, x1)", 0.7, |_| -11.0),
        ("sqrt(x1)", 0.7, |x| 0.5 / x.sqrt()),
        ("exp(x1)", 0.7, f64::exp),
        ("ln(x1)", 0.7, |x| 1.0 / x),
        ("log10(x1)", 0.7, |x| 1.0 / (x * std::f64::consts::LN_10)),
        ("sin(x1)", 0.7, f64::cos),
        ("cos(x1)", 0.7, |x| -x.sin()),
        ("tan(x1)", 0.7, |x| 1.0 / x.cos().powi(2)),
        ("asin(x1)", 0.7, |x| 1.0 / (1.0 - x * x).sqrt()),
        ("acos(x1)", 0.7, |x| -1.0 / (1.0 - x * x).sqrt()),
        ("atan(x1)", 0.7, |x| 1.0 / (1.0 + x * x)),
        ("sinh(x1)", 0.7, f64::cosh),
        ("cosh(x1)", 0.7, f64::sinh),
        ("tanh(x1)", 0.7, |x| 1.0 / x.cosh().powi(2)),
        ("asinh(x1)", 0.7, |x| 1.0 / (1.0 + x * x).sqrt()),
        ("acosh(x1)", 1.7, |x| 1.0 / (x * x - 1.0).sqrt()),
        ("atanh(x1)", 0.7, |x| 1.0 / (1.0 - x * x)),
        ("atan2(x1, 2)", 0.7, |x| 2.0 / (x * x + 4.0)),
        ("atan2(2, x1)", 0.7, |x| -2.0 / (x * x + 4.0)),
        // On the axis, where y/x is infinite.
        ("atan2(2, x1)", 0.0, |_| -0.5),
        ("atan2(-2, x1)", 0.0, |_| 0.5),
        // Far out, where sinh and cosh overflow.
        ("tanh(x1)", 1000.0, |_| 0.0),
        ("tanh(x1)", -1000.0, |_| 0.0),
        ("x1^3", -1.2, |x| 3.0 * x * x),
        ("x1^-2", -1.2, |x| -2.0 / (x * x * x)),
        ("x1^2.5", 1.2, |x| 2.5 * x.powf(1.5)),
        // Where exp(2.5 ln x) has no derivative and x^2.5 has.
        ("x1^2.5", 0.0, |_| 0.0),
        // Logistic, on both sides of the change and far beyond where exp overflows.
        ("ln(3 + exp(x1))", 0.7, |x| x.exp() / (3.0 + x.exp())),
        ("ln(exp(x1) + 3)", 2.7, |x| x.exp() / (3.0 + x.exp())),
        ("ln(u1^2 + exp(x1))", 2000.0, |_| 1.0),
        ("2^x1", 0.7, |x| std::f64::consts::LN_2 * x.exp2()),
        ("sat(x1) + max(x1, 1) + min(x1, 0.1, 3)", 0.7, |_| 1.0),
    ];
    for (text, at, expected) in table {
        let gradient = parse(text).gradient(T, &[at, 0.3, 0.2], &U).unwrap_or_else(|error| panic!("{text}: {error}"));
        let expected = expected(at);
        // A few roundings, amplified by the condition of the inverse functions at 0.7.
        assert!((gradient[0] - expected).abs() <= 16.0 * f64::EPSILON * (1.0 + expected.abs()), "{text}: {gradient:?}");
        assert_eq!(gradient[1..], [0.0, 0.0]);
    }
    assert_eq!(parse("x1*u2 + u1^2").input_gradient(T, &X, &U).unwrap(), [2.0 * U[0], X[0]]);
}

/// Half a turn is in the interval of `wrap`, minus half a turn is not; `mod` has the sign of its second argument, as in
/// Python and MATLAB.
#[test]
fn ends_of_the_intervals_of_wrap_and_mod() {
    use std::f64::consts::PI;
    let table = [
        ("wrap(pi)", PI),
        ("wrap(-pi)", PI),
        ("wrap(3)", 3.0),
        ("wrap(-3)", -3.0),
        ("wrap(180, 360)", 180.0),
        ("wrap(-180, 360)", 180.0),
        ("wrap(-181, 360)", 179.0),
        ("wrap(541, 360)", -179.0),
        ("wrap(-3600, 360)", 0.0),
        ("mod(7, 3)", 1.0),
        ("mod(-7, 3)", 2.0),
        ("mod(7, -3)", -2.0),
        ("mod(-7, -3)", -1.0),
        ("mod(6, 3)", 0.0),
        ("floor(-0.5)", -1.0),
        ("floor(2)", 2.0),
    ];
    for (text, expected) in table {
        assert_eq!(value(text), expected, "{text}");
    }
    for undefined in ["mod(x1, 0)", "wrap(x1, 0)", "wrap(1/0)", "mod(1/0, 2)"] {
        assert!(value(undefined).is_nan(), "{undefined}");
    }
    assert!(matches!(kind("wrap(1, 2, 3)"), ExpressionErrorKind::Arguments { function: "wrap", found: 3, .. }));
    assert_eq!(parse("wrap(x1)").to_string(), "wrap(x1, 2.0*pi)");
}

/// No value and no derivative: the part of the text, and what it is made of.
#[test]
fn what_is_undefined_is_named() {
    let undefined = |text: &str, x: [f64; 3]| parse(text).gradient(0.0, &x, &[0.0; 2]).unwrap_err().to_string();
    let table = [
        ("x3 + u1/(x1 - x2)", [1.0, 1.0, 0.0], "`u1/(x1 - x2)` is not defined: `u1` is 0 and `(x1 - x2)` is 0"),
        ("ln(x1*x2)", [1.0, -2.0, 0.0], "`ln(x1*x2)` is not defined: `x1*x2` is -2"),
        ("k*exp(x1)", [1000.0, 0.0, 0.0], "`exp(x1)` is infinite: `x1` is 1000"),
        ("1 + sqrt(abs(x2))", [1.0, 0.0, 0.0], "`sqrt(abs(x2))` has no finite derivative by x2: `abs(x2)` is 0"),
        ("x1^-1", [0.0; 3], "`x1^-1` is infinite: `x1` is 0"),
    ];
    for (text, x, expected) in table {
        assert_eq!(undefined(text, x), expected, "{text}");
    }
    assert!(parse("x3").evaluate(0.0, &X[..2], &[]).is_nan());
}

/// Each error with its place and its words.
#[test]
fn errors_say_where_and_what() {
    let table = [
        ("x1 +", "line 1, column 5: expected a number, a name, `(` or `-`, found the end of the expression"),
        ("x1 + * x2", "line 1, column 6: expected a number, a name, `(` or `-`, found `*`"),
        ("(x1 + x2", "line 1, column 9: expected an operator or `)`, found the end of the expression"),
        ("x1 + x2)", "line 1, column 8: expected an operator or the end of the expression, found `)`"),
        ("2x1", "line 1, column 2: expected an operator or the end of the expression, found `x1`"),
        ("min(x1 x2)", "line 1, column 8: expected an operator, `,` or `)`, found `x2`"),
        ("x1 +\n  y", "line 2, column 3: there is no `y`; known are x1 to x3, u1 to u2, t, pi, e, J_1, k"),
        ("x1 < 2", "line 1, column 1: `x1 < 2` is a condition and not a number: write `if(x1 < 2, 1, 0)` for a number"),
        ("x1 = 2", "line 1, column 4: expected an operator or the end of the expression, found `=`"),
        ("x4", "line 1, column 1: there is no `x4`: there are 3 states, x1 to x3"),
        ("x0", "line 1, column 1: there is no `x0`: there are 3 states, x1 to x3"),
        ("u3*2", "line 1, column 1: there is no `u3`: there are 2 inputs, u1 to u2"),
        ("3*J1", "line 1, column 3: there is no `J1`; did you mean `J_1`?"),
        ("log(x1)", "line 1, column 1: there is no function `log`; did you mean `ln`?"),
        ("sinn(x1)", "line 1, column 1: there is no function `sinn`; did you mean `sin`?"),
        ("sim(x1)", "line 1, column 1: there is no function `sim`; did you mean `sin`?"),
        ("k(x1)", "line 1, column 1: `k` is not a function; write `k*(...)` for a product"),
        ("sin*2", "line 1, column 1: `sin` is a function: write `sin(...)`"),
        ("atan2(x1)", "line 1, column 1: `atan2` takes two arguments, and has 1"),
        ("sat(x1, 2)", "line 1, column 1: `sat` takes one argument, or three: sat(x, low, high), and has 2"),
        ("max()", "line 1, column 1: `max` takes two arguments or more, and has 0"),
        ("1e999", "line 1, column 1: the number 1e999 is too large: the largest is 1.8e308"),
        ("  ", "line 1, column 1: the expression is empty: expected a number, a name, `(` or `-`"),
        ("x1 + θ", "line 1, column 6: there is no `θ`; known are x1 to x3, u1 to u2, t, pi, e, J_1, k"),
        ("x1 . 2", "line 1, column 4: expected an operator or the end of the expression, found `.`"),
        (".", "line 1, column 1: expected a number, a name, `(` or `-`, found `.`"),
    ];
    for (text, expected) in table {
        let error = Expression::parse(text, &scope()).unwrap_err();
        assert_eq!(error.to_string(), expected, "{text}");
        assert!(error.pointer().ends_with('^'));
    }
    let program = Expression::parse("x1", &Scope::time()).unwrap_err();
    assert!(matches!(program.kind(), ExpressionErrorKind::Unavailable { .. }));
    let none = Expression::parse("u1", &Scope::plant(1, 0)).unwrap_err();
    assert_eq!(
        *none.kind(),
        ExpressionErrorKind::OutOfRange { name: "u1".to_owned(), family: Family::Inputs, count: 0 }
    );
    assert_eq!(
        kind("x1 x2"),
        ExpressionErrorKind::Unexpected {
            expected: "an operator or the end of the expression",
            found: Found::Text("x2".to_owned())
        }
    );
}

/// Every way to nest is bounded, on the small stack of a test thread.
#[test]
fn depth_and_length_are_bounded() {
    let deep = |open: &str, middle: &str, close: &str, levels: usize| {
        Expression::parse(&format!("{}{middle}{}", open.repeat(levels), close.repeat(levels)), &scope())
    };
    for (open, close) in [("(", ")"), ("-", ""), ("2^", ""), ("sin(", ")"), ("max(1, ", ")"), ("1 + 2*3^(", ")")] {
        let error = deep(open, "x1", close, 500).unwrap_err();
        assert_eq!(*error.kind(), ExpressionErrorKind::TooDeep, "{open}");
        deep(open, "x1", close, 15).unwrap();
    }
    assert_eq!(deep("(", "x1", ")", 64).unwrap().evaluate(T, &X, &U), X[0]);
    // Unclosed parentheses, and a long sum, which is not deep.
    assert_eq!(*deep("(", "", "", 8000).unwrap_err().kind(), ExpressionErrorKind::TooDeep);
    let long = "1 + ".repeat(2000) + "x1";
    assert_eq!(value(&long), 2000.0 + X[0]);
    assert_eq!(
        *deep(" ", "x1", "", 8191).unwrap_err().kind(),
        ExpressionErrorKind::TooLong { length: 8193, longest: 8192 }
    );
}

/// Constants are joined where nothing is lost, and only there: 0.1 + 0.2 is rounded once more over the intervals of a
/// box.
#[test]
fn integer_exponents_are_products_for_every_base() {
    for text in ["x2^3", "x2^(2+1)", "x2^(6/2)", "x2^(2^2 - 1)", "pow(x2, 3)", "x2^--3"] {
        let product = X[1] * X[1] * X[1];
        assert!((value(text) - product).abs() <= 2.0 * f64::EPSILON * product.abs(), "{text}");
    }
    assert!(value("x2^(0.1*30)").is_nan() || value("x2^(0.1*30)") < 0.0);
    assert_eq!(value("x2^0"), 1.0);
}

/// Texts of expressions: leaves, then operations on smaller ones.
fn texts() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        prop::sample::select(vec!["x1", "x2", "x3", "u1", "u2", "t", "k", "J_1", "pi", "e"]).prop_map(str::to_owned),
        (0.0..1e3f64).prop_map(|number| format!("{number:?}")),
        (0u32..6).prop_map(|number| number.to_string()),
    ];
    leaf.prop_recursive(5, 24, 3, |inner| {
        let functions = vec!["sin", "cos", "exp", "ln", "sqrt", "abs", "sign", "floor", "wrap", "tanh", "atan", "sat"];
        prop_oneof![
            (inner.clone(), prop::sample::select(vec!["+", "-", "*", "/", "^", " ** "]), inner.clone())
                .prop_map(|(x, sign, y)| format!("{x}{sign}{y}")),
            inner.clone().prop_map(|x| format!("({x})")),
            inner.clone().prop_map(|x| format!("-{x}")),
            (prop::sample::select(functions), inner.clone()).prop_map(|(name, x)| format!("{name}({x})")),
            (prop::sample::select(vec!["min", "max"]), inner.clone(), inner.clone(), inner.clone())
                .prop_map(|(name, x, y, z)| format!("{name}({x}, {y}, {z})")),
            (prop::sample::select(vec!["atan2", "pow", "mod", "wrap"]), inner.clone(), inner)
                .prop_map(|(name, x, y)| format!("{name}({x}, {y})")),
        ]
    })
}

/// Equal, or both not a number.
fn same(x: f64, y: f64) -> bool {
    x.to_bits() == y.to_bits() || x.is_nan() && y.is_nan()
}

proptest! {
    /// What is printed is the same expression: same value to the last bit, and printed again the same text.
    #[test]
    fn printing_and_parsing_give_the_same_expression(text in texts()) {
        let expression = parse(&text);
        let printed = expression.to_string();
        let again = parse(&printed);
        prop_assert_eq!(again.to_string(), printed);
        prop_assert!(same(expression.evaluate(T, &X, &U), again.evaluate(T, &X, &U)));
    }

    /// Any text ends in an expression or an error whose place is inside of it.
    #[test]
    fn no_text_panics(text in r"[ -~\néθ∂]{0,60}") {
        match Expression::parse(&text, &scope()) {
            Ok(expression) => {
                let _ = expression.evaluate(T, &X, &U);
            }
            Err(error) => {
                prop_assert!(error.span().end <= text.len() && text.get(error.span()).is_some());
                prop_assert!(!error.to_string().is_empty() && error.pointer().contains('^'));
            }
        }
    }

    /// Texts that are nearly expressions: one with a piece cut out or put in.
    #[test]
    fn no_broken_expression_panics(text in texts(), at in 0.0..1.0f64, piece in r"[-+*/^(),.0-9a-z ]{0,4}", cut in 0usize..4) {
        let at = (at * text.len() as f64) as usize;
        let broken = format!("{}{piece}{}", &text[..at], &text[(at + cut).min(text.len())..]);
        if let Ok(expression) = Expression::parse(&broken, &scope()) {
            let again = parse(&expression.to_string());
            prop_assert!(same(expression.evaluate(T, &X, &U), again.evaluate(T, &X, &U)));
        }
    }

    /// Affine by its form: the value is `c + a'x + b'u` with the derivatives as coefficients.
    #[test]
    fn affine_expressions_are_their_first_order(a in prop::array::uniform3(-9.0..9.0f64), b in -9.0..9.0f64, c in -9.0..9.0f64) {
        let text = format!("({:?})*x1 - x2*({:?})*2 + ((x3 - {:?})/({:?}) + u1*k) + {c:?}", a[0], a[1], a[2].abs(), b.abs() + 1.0);
        let expression = parse(&text);
        prop_assert!(expression.affine().is_ok());
        let zero = expression.evaluate(0.0, &[0.0; 3], &[0.0; 2]);
        let slopes = expression.gradient(0.0, &X, &U).unwrap().into_iter().zip(X);
        let inputs = expression.input_gradient(0.0, &X, &U).unwrap().into_iter().zip(U);
        let first_order = zero + slopes.chain(inputs).map(|(slope, entry)| slope * entry).sum::<f64>();
        // A dozen roundings of terms below 60.
        prop_assert!((expression.evaluate(0.0, &X, &U) - first_order).abs() <= 12.0 * 60.0 * f64::EPSILON);
    }
}

/// What is not affine, and the first part that is not.
#[test]
fn what_is_not_affine_is_named() {
    for (text, part) in [
        ("x1*x2", "x1*x2"),
        ("x3 + t*x1", "t"),
        ("k*sin(x1)", "sin(x1)"),
        ("1/x1", "1/x1"),
        ("x1^2", "x1^2"),
        ("sat(u1)", "sat(u1)"),
        ("2 + abs(x1) - x2", "abs(x1)"),
    ] {
        assert_eq!(parse(text).affine(), Err(part), "{text}");
    }
    for text in ["x1", "3", "sin(2)*x1/ln(3)", "-(x1 + u2)*k", "sat(2, 0, 1)*x1"] {
        assert_eq!(parse(text).affine(), Ok(()), "{text}");
    }
}

/// Names supplied by the user are the same columns; where they have no derivative it is said of them as they are
/// written.
#[test]
fn names_are_columns() {
    let (states, inputs) = (["angle", "x2", "wheel speed"].map(str::to_owned), ["torque".to_owned()]);
    let scope = Scope::plant(3, 1).named(&states, &inputs).unwrap();
    let by_name = Expression::parse("angle*x2 + torque/x3", &scope).unwrap();
    let by_number = Expression::parse("x1*x2 + u1/x3", &Scope::plant(3, 1)).unwrap();
    assert_eq!(by_name.evaluate(0.0, &[2.0, 3.0, 4.0], &[5.0]), by_number.evaluate(0.0, &[2.0, 3.0, 4.0], &[5.0]));
    let undefined = Expression::parse("sqrt(angle)", &scope).unwrap().gradient(0.0, &[0.0; 3], &[0.0]).unwrap_err();
    assert_eq!(undefined.to_string(), "`sqrt(angle)` has no finite derivative by angle: `angle` is 0");
    let taken = |states: &[&str], inputs: &[&str]| {
        let own = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        let error = Scope::plant(2, 2).named(&own(states), &own(inputs)).unwrap_err();
        (error.family, error.index, error.meaning)
    };
    assert_eq!(taken(&["a", "a"], &[]), (Family::States, 1, "another state"));
    assert_eq!(taken(&["a", "b"], &["b", "c"]), (Family::Inputs, 0, "a state"));
    assert_eq!(taken(&["a", "b"], &["c", "c"]), (Family::Inputs, 1, "another input"));
    assert_eq!(taken(&["x2", "x1"], &[]), (Family::States, 0, "a state"));
    assert_eq!(taken(&[], &["max", "u2"]), (Family::Inputs, 0, "a function"));
    let parameters = Parameters::from([("k".to_owned(), 1.0)]);
    let error = Scope::plant(1, 0).with(&parameters).unwrap().named(&["k".to_owned()], &[]).unwrap_err();
    assert_eq!(error.to_string(), "`k` cannot be the name of a state: it is a parameter");
    let error = Scope::plant(1, 0).named(&["k".to_owned()], &[]).unwrap().with(&parameters).unwrap_err();
    assert_eq!(error.to_string(), "`k` cannot be the name of a parameter: it is a state");
}
