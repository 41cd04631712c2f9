//! Expressions as formulas.

use luenberger_expression::{Expression, Scope};

fn latex(text: &str) -> String {
    Expression::parse(text, &Scope::plant(2, 1)).unwrap().formula().latex
}

#[test]
fn parentheses_stand_where_they_are_needed() {
    assert_eq!(latex("x1 - (x2 - u1)"), "x_{1} - \\left(x_{2} - u_{1}\\right)");
    assert_eq!(latex("x1 - x2 - u1"), "x_{1} - x_{2} - u_{1}");
    assert_eq!(latex("x1 + (x2 + u1)"), "x_{1} + x_{2} + u_{1}");
    assert_eq!(latex("(x1 + x2)*u1"), "\\left(x_{1} + x_{2}\\right) \\cdot u_{1}");
    assert_eq!(latex("-(x1 + x2)"), "-\\left(x_{1} + x_{2}\\right)");
    assert_eq!(latex("x1*(-x2)"), "x_{1} \\cdot \\left(-x_{2}\\right)");
    assert_eq!(latex("(-x1)^2 + (x1*x2)^2"), "\\left(-x_{1}\\right)^{2} + \\left(x_{1} \\cdot x_{2}\\right)^{2}");
    assert_eq!(latex("(x1^2)^u1"), "\\left(x_{1}^{2}\\right)^{u_{1}}");
    assert_eq!(latex("(x1/x2)^2"), "\\left(\\frac{x_{1}}{x_{2}}\\right)^{2}");
    assert_eq!(latex("exp(-x1)^2"), "\\left(e^{-x_{1}}\\right)^{2}");
    assert_eq!(latex("x1 + (-x2)"), "x_{1} + \\left(-x_{2}\\right)");
    assert_eq!(latex("2*3*x1"), "2 \\cdot 3 x_{1}");
    assert_eq!(latex("1e-9*sqrt(abs(x1))"), "10^{-9} \\cdot \\sqrt{\\left|x_{1}\\right|}");
    assert_eq!(
        latex("if(x1 < 0 && !(x2 >= 1), sat(x1, -1, 1), atan2(x1, x2))"),
        "\\begin{cases}\\operatorname{sat}\\left(x_{1}, -1, 1\\right) & \\text{if } \\left(x_{1} < 0\\right) \\land \\left(\\lnot \\left(x_{2} \\ge 1\\right)\\right) \\\\ \\operatorname{atan2}\\left(x_{1}, x_{2}\\right) & \\text{else}\\end{cases}"
    );
}

#[test]
fn mathml_is_balanced() {
    let formula = Expression::parse("if(x1 <= 2, x1^2/3, -sin(x2)*1.5e12)", &Scope::plant(2, 0)).unwrap().formula();
    let mut open = Vec::new();
    for tag in formula.mathml.split('<').skip(1) {
        let name = tag.split(['>', ' ']).next().unwrap();
        match name.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name)),
            None => open.push(name),
        }
    }
    assert!(open.is_empty());
}

/// A browser drops a space at the end of a text within a formula: one that does not break stays.
#[test]
fn words_of_a_formula_stand_apart() {
    let formula = Expression::parse("if(x1 < 3600, 1, 0)", &Scope::plant(2, 0)).unwrap().formula();
    assert!(formula.mathml.contains("<mtext>if&#xA0;</mtext>"), "{}", formula.mathml);
    let texts = formula.mathml.split("<mtext>").skip(1).filter_map(|text| text.split('<').next());
    assert!(texts.into_iter().all(|text| text.trim() == text), "{}", formula.mathml);
}
