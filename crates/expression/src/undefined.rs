//! Diagnosis of expressions without a value or a derivative: the subexpression and its arguments.

use core::fmt;

use nalgebra::RealField;
use num_dual::Dual64;

use crate::error::Family;
use crate::expression::Expression;
use crate::scope::Symbol;
use crate::tree::Node;

/// A subexpression that is not finite, although its operands are.
#[derive(Clone, Debug, PartialEq)]
pub struct Undefined {
    /// The part, as it is written.
    pub part: String,
    /// Its value.
    pub value: f64,
    /// By which state or input it was differentiated, from 0, and its name as it is written; none where the value
    /// itself is not finite.
    pub derivative_by: Option<(Family, usize, String)>,
    /// The subexpression as written, with the values of its operands.
    pub operands: Vec<(String, f64)>,
}

impl fmt::Display for Undefined {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` ", self.part)?;
        match &self.derivative_by {
            Some((_, _, name)) => write!(f, "has no finite derivative by {name}")?,
            None if self.value.is_nan() => f.write_str("is not defined")?,
            None => f.write_str("is infinite")?,
        }
        for (k, (part, value)) in self.operands.iter().enumerate() {
            write!(f, "{}`{part}` is {value}", if k == 0 { ": " } else { " and " })?;
        }
        Ok(())
    }
}

impl std::error::Error for Undefined {}

impl Expression {
    /// Its value, if that is a finite number.
    ///
    /// ```
    /// use luenberger_expression::{Expression, Scope};
    /// let expression = Expression::parse("x2 + 1/(x1 - 2)", &Scope::plant(2, 0))?;
    /// let undefined = expression.examine(0.0, &[2.0, 1.0], &[]).unwrap_err();
    /// assert_eq!(undefined.to_string(), "`1/(x1 - 2)` is infinite: `1` is 1 and `(x1 - 2)` is 0");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`Undefined`] names the first part of the text that is not finite.
    pub fn examine(&self, t: f64, x: &[f64], u: &[f64]) -> Result<f64, Undefined> {
        value(self, t, x, u)
    }

    /// The derivatives by all states, to rounding, if they are finite numbers.
    ///
    /// ```
    /// use luenberger_expression::{Expression, Scope};
    /// let expression = Expression::parse("x1^2*x2", &Scope::plant(2, 0))?;
    /// assert_eq!(expression.gradient(0.0, &[3.0, 5.0], &[])?, [30.0, 9.0]);
    /// let root = Expression::parse("3*sqrt(x2)", &Scope::plant(2, 0))?;
    /// let undefined = root.gradient(0.0, &[1.0, 0.0], &[]).unwrap_err();
    /// assert_eq!(undefined.to_string(), "`sqrt(x2)` has no finite derivative by x2: `x2` is 0");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`Undefined`] names the first part of the text of which the value or a derivative is not finite.
    pub fn gradient(&self, t: f64, x: &[f64], u: &[f64]) -> Result<Vec<f64>, Undefined> {
        gradient(self, t, x, u, Family::States)
    }

    /// The derivatives by all inputs; as [`gradient`](Self::gradient).
    ///
    /// # Errors
    /// As [`gradient`](Self::gradient).
    pub fn input_gradient(&self, t: f64, x: &[f64], u: &[f64]) -> Result<Vec<f64>, Undefined> {
        gradient(self, t, x, u, Family::Inputs)
    }
}

/// The value, or the first part of the text for which `bad` holds, with its operands; `number` is what is shown of a
/// scalar.
fn run<T: RealField + Copy>(
    expression: &Expression,
    (t, x, u): (T, &[T], &[T]),
    bad: impl Fn(T) -> bool,
    number: impl Fn(T) -> f64,
) -> Result<T, (Undefined, Vec<T>)> {
    let mut first = None;
    // The nodes whose values are on the stack.
    let mut stack: Vec<usize> = Vec::new();
    let value = expression.tape.evaluate(t, x, u, |step| {
        let operands = stack.split_off(stack.len() - step.operands.len());
        // A comparison leaves no value.
        let Some(value) = step.value else { return };
        if first.is_none() && bad(value) {
            let written = |(node, value): (&usize, &T)| (expression.part(*node).to_owned(), number(*value));
            let undefined = Undefined {
                part: expression.part(step.node).to_owned(),
                value: number(value),
                derivative_by: None,
                operands: operands.iter().zip(step.operands).map(written).collect(),
            };
            first = Some((undefined, step.operands.to_vec()));
        }
        stack.push(step.node);
    });
    first.map_or(Ok(value), Err)
}

/// The name of a state or an input in the expression, by its index from 0.
fn written(expression: &Expression, family: Family, index: usize) -> String {
    let symbol = |node: &Node| match (node, family) {
        (Node::Symbol(Symbol::State(k), name), Family::States)
        | (Node::Symbol(Symbol::Input(k), name), Family::Inputs)
            if *k == index =>
        {
            Some(name.clone())
        }
        _ => None,
    };
    let letter = if family == Family::States { 'x' } else { 'u' };
    expression.tree.nodes().find_map(symbol).unwrap_or_else(|| format!("{letter}{}", index + 1))
}

fn value(expression: &Expression, t: f64, x: &[f64], u: &[f64]) -> Result<f64, Undefined> {
    run(expression, (t, x, u), |value| !value.is_finite(), |value| value).map_err(|(undefined, _)| undefined)
}

/// The derivatives by all states, or by all inputs.
///
/// Where a part has no derivative, none is finite: 0 times infinity is not a number along the directions that do not
/// move it. The error is that of a direction that does.
fn gradient(expression: &Expression, t: f64, x: &[f64], u: &[f64], family: Family) -> Result<Vec<f64>, Undefined> {
    value(expression, t, x, u)?;
    let count = if family == Family::States { x.len() } else { u.len() };
    let mut slopes = Vec::with_capacity(count);
    let mut error: Option<(Undefined, bool)> = None;
    for index in 0..count {
        let lifted = |column: &[f64], along: bool| -> Vec<Dual64> {
            let seed = |k: usize| if along && k == index { 1.0 } else { 0.0 };
            column.iter().enumerate().map(|(k, entry)| Dual64::new(*entry, seed(k))).collect()
        };
        let (x, u) = (lifted(x, family == Family::States), lifted(u, family == Family::Inputs));
        match run(expression, (Dual64::from_re(t), &x, &u), |value| !value.eps.is_finite(), |value| value.re) {
            Ok(value) => slopes.push(value.eps),
            Err((undefined, operands)) => {
                let moved = operands.iter().any(|operand| operand.eps != 0.0);
                if error.as_ref().is_none_or(|(_, known)| moved && !known) {
                    let name = written(expression, family, index);
                    error = Some((Undefined { derivative_by: Some((family, index, name)), ..undefined }, moved));
                }
            }
        }
    }
    error.map_or(Ok(slopes), |(undefined, _)| Err(undefined))
}
