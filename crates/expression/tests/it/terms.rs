//! Expressions as sums of terms: what is shown of them holds at every point.

use luenberger_expression::{Expression, Parameters, Scope, Terms, Variable};
use proptest::prelude::*;

const X1: Variable = Variable::State(0);
const X2: Variable = Variable::State(1);
const U1: Variable = Variable::Input(0);

fn parse(text: &str) -> Expression {
    let parameters = [("one", 1.0), ("k", 2.5), ("off", 0.0)].map(|(name, value)| (name.to_owned(), value));
    let scope = Scope::plant(2, 1).with(&Parameters::from(parameters)).unwrap();
    Expression::parse(text, &scope).unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn terms(text: &str) -> Terms {
    parse(text).terms()
}

#[test]
fn sums_that_are_a_variable_are_known() {
    for text in [
        "x1",
        "+x1",
        "(x1)",
        "-(-x1)",
        "1*x1",
        "x1*one",
        "x1/one",
        "x1 + 0",
        "0 + x1 - 0*u1",
        "x1 + 0*x2",
        "3*x1 - 2*x1",
        "x2 + x1 - x2",
        "(2*x1)/2",
        "x1/4 + 0.75*x1",
        "x1 + off*x2",
        "x1 + 3 - 3",
        "k*(x1 + x2) - 1.5*x1 - k*x2",
        "if(off > 0, x2, x1)",
        "if(one > 0 && !(k < 0), x1, 0)",
    ] {
        assert_eq!(terms(text).variable(), Some(X1), "{text}");
    }
    assert_eq!(terms("u1").variable(), Some(U1));
}

#[test]
fn what_differs_somewhere_is_no_variable() {
    for text in [
        "0",
        "2*x1",
        "-x1",
        "x1 + x2",
        "x1 + 1e-300",
        "x1*(1 + 1e-15)",
        "x1 + 0.1*sin(t)",
        "x1 + 0*t",
        "x1*cos(t)",
        "sat(x1, -10, 10)",
        "min(x1, 10)",
        "max(x1, -10)",
        "abs(x1)",
        "if(t > 5, 0, x1)",
        "if(x1 > 10, 10, x1)",
        "x1 + x2*u1",
        "x1*u1",
        "x1 + 0*ln(x2)",
        "x1/0",
        "x1 + 1e-20*pi - 1e-20*e",
        // Rounded, so that it is not known to be 1 and -1e-17.
        "(0.1*x1)*10",
        "x1 + 1e17 + 1 - 1e17 - 1",
    ] {
        assert_eq!(terms(text).variable(), None, "{text}");
    }
}

#[test]
fn what_a_sum_depends_on() {
    let sum = terms("pi*x1 + 0.1*x2*3 + u1*sin(u1)");
    assert!(sum.is_linear_in(X1) && sum.is_linear_in(X2) && !sum.is_linear_in(U1));
    assert_eq!((sum.multiple_of(X1), sum.multiple_of(X2), sum.multiple_of(U1)), (None, None, None));
    assert!(!sum.is_affine() && terms("pi*x1 + u1/3 - 1").is_affine());
    assert_eq!(terms("u1 - 4*x2").multiple_of(X1), Some(0.0));
    assert_eq!(terms("sin(u1) - 4*x2").multiple_of(X2), Some(-4.0));
    assert!(!terms("x2 - x2 + 0*x1").depends_on(X2) && !terms("x2 - x2 + 0*x1").depends_on(X1));
    // 0 times a part that may be undefined is not dropped.
    assert!(terms("0*(x1*x2)").depends_on(X1));
    assert!(terms("if(x2 > 0, 1, 2)").depends_on(X2) && terms("if(t > 0, 1, 2)").uses_time());
    let row: Terms = [(X1, 0.0), (X2, 1.0)].into_iter().collect();
    assert_eq!((row.variable(), row.depends_on(X1)), (Some(X2), false));
}

/// Expressions of two states, an input and the time.
fn expression() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        Just("x1".to_owned()),
        Just("x2".to_owned()),
        Just("u1".to_owned()),
        Just("t".to_owned()),
        Just("k".to_owned()),
        Just("one".to_owned()),
        (-4i32..=4).prop_map(|number| format!("({number})")),
    ];
    leaf.prop_recursive(4, 24, 3, |inner| {
        let pair = (inner.clone(), inner.clone());
        prop_oneof![
            (prop_oneof!["\\+", "-", "\\*"], pair.clone()).prop_map(|(sign, (x, y))| format!("({x} {sign} {y})")),
            inner.clone().prop_map(|x| format!("({x})/4")),
            inner.clone().prop_map(|x| format!("sin({x})")),
            inner.clone().prop_map(|x| format!("sat({x}, -2, 2)")),
            (inner, pair).prop_map(|(c, (x, y))| format!("if({c} > 1, {x}, {y})")),
        ]
    })
}

proptest! {
    /// Changing a variable changes the value by its factor, where that is known; and not at all where the expression
    /// does not depend on it.
    #[test]
    fn the_terms_hold_at_every_point(
        text in expression(),
        at in prop::array::uniform4(-8i32..=8),
        step in 1i32..=8,
    ) {
        let (row, terms) = (parse(&text), terms(&text));
        // Multiples of 1/4, so that sums and products are exact.
        let [t, x1, x2, u1] = at.map(|x| f64::from(x) / 4.0);
        let value = |t: f64, x1: f64, x2: f64, u1: f64| row.evaluate(t, &[x1, x2], &[u1]);
        let (step, here) = (f64::from(step) / 4.0, value(t, x1, x2, u1));
        for (variable, moved) in [
            (X1, value(t, x1 + step, x2, u1)),
            (X2, value(t, x1, x2 + step, u1)),
            (U1, value(t, x1, x2, u1 + step)),
        ] {
            if !terms.depends_on(variable) {
                prop_assert_eq!(moved, here, "{}", text);
            }
            if let Some(factor) = terms.multiple_of(variable) {
                let tolerance = 1e-9 * (1.0 + here.abs() + moved.abs() + factor.abs());
                prop_assert!((moved - here - factor * step).abs() <= tolerance, "{} by {:?}", text, variable);
            }
        }
        if !terms.uses_time() {
            prop_assert_eq!(value(t + step, x1, x2, u1), here, "{}", text);
        }
        let own = match terms.variable() {
            Some(X1) => x1,
            Some(X2) => x2,
            Some(_) => u1,
            None => here,
        };
        prop_assert!((here - own).abs() <= 1e-9 * (1.0 + here.abs()), "{}", text);
    }
}
