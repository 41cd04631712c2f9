//! An expression in the elementary notation of certificate files: sums, products, quotients, integer powers, and sin,
//! cos, exp, ln, sqrt, tanh, atan.
//!
//! `tan`, `sinh`, `cosh`, `log10` and powers with other exponents are written by these where that is exact in real
//! arithmetic; branches, absolute values, tables and the time have no such form. A maximum is written as its argument
//! that varies, in a form that is defined only where this is the larger one: `max(a, 1)` is `1 + sqrt(a - 1)^2`.
//! Whoever proves that the text is defined over a set has proved that it is the maximum there. The same for a minimum.

use crate::expression::Expression;
use crate::function::{Binary, Unary};
use crate::scope::{Symbol, Variable};
use crate::tree::Node;

/// The longest text that is written: a subexpression that occurs twice is written twice.
const LONGEST: usize = 16_384;

/// The largest integer exponent.
const LARGEST_EXPONENT: f64 = 64.0;

impl Expression {
    /// The expression with the numbers and variables as these functions write them, fully parenthesised.
    ///
    /// ```
    /// use luenberger_expression::{Expression, Scope, Variable};
    /// let expression = Expression::parse("-x1^2 + tan(x1)*u1/2", &Scope::plant(1, 1))?;
    /// let name = |variable: Variable| match variable {
    ///     Variable::State(k) => Some(format!("z{}", k + 1)),
    ///     Variable::Input(_) => None,
    /// };
    /// let number = |x: f64| x.to_string();
    /// assert_eq!(expression.elementary(number, name), Err("u1".to_owned()));
    /// let expression = Expression::parse("-x1^2 + cosh(x1)", &Scope::plant(1, 0))?;
    /// assert_eq!(expression.elementary(number, name).unwrap(), "-z1^2 + (exp(z1) + exp(-(z1)))/2");
    /// let expression = Expression::parse("ln(max(x1, 0.5))", &Scope::plant(1, 0))?;
    /// assert_eq!(expression.elementary(number, name).unwrap(), "ln(0.5 + sqrt(z1 - 0.5)^2)");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// The part of the text that has no such form: a function, a variable for which there is no name, or the whole
    /// where it becomes too long.
    pub fn elementary(
        &self,
        number: impl Fn(f64) -> String,
        name: impl Fn(Variable) -> Option<String>,
    ) -> Result<String, String> {
        let mut written: Vec<(String, u8)> = Vec::new();
        for (index, node) in self.tree.nodes().enumerate() {
            let part = || self.text().get(self.tree.span(index)).unwrap_or_default().to_owned();
            let of = |k: &usize| written.get(*k).cloned().unwrap_or_default();
            let held = |k: &usize, needed: u8| {
                let (text, strength) = of(k);
                if strength < needed { format!("({text})") } else { text }
            };
            let text = match node {
                Node::Number(x) => (number(*x), ATOM),
                Node::Symbol(symbol, _) => {
                    let value = |x: f64| if x < 0.0 { (format!("-{}", number(-x)), SIGN) } else { (number(x), ATOM) };
                    match symbol {
                        Symbol::State(k) => (name(Variable::State(*k)).ok_or_else(part)?, ATOM),
                        Symbol::Input(k) => (name(Variable::Input(*k)).ok_or_else(part)?, ATOM),
                        Symbol::Pi => value(core::f64::consts::PI),
                        Symbol::E => value(core::f64::consts::E),
                        Symbol::Parameter(x) if x.is_finite() => value(*x),
                        Symbol::Parameter(_) | Symbol::Time => return Err(part()),
                    }
                }
                Node::Unary(Unary::Negate, x) => (format!("-{}", held(x, SIGN)), SIGN),
                Node::Unary(function, x) => {
                    let x = of(x).0;
                    match function {
                        Unary::Reciprocal => (format!("1/({x})"), PRODUCT),
                        Unary::Sqrt | Unary::Exp | Unary::Ln | Unary::Sin | Unary::Cos | Unary::Atan | Unary::Tanh => {
                            (format!("{}({x})", function.name()), ATOM)
                        }
                        Unary::Tan => (format!("sin({x})/cos({x})"), PRODUCT),
                        Unary::Sinh => (format!("(exp({x}) - exp(-({x})))/2"), PRODUCT),
                        Unary::Cosh => (format!("(exp({x}) + exp(-({x})))/2"), PRODUCT),
                        Unary::Log10 => (format!("ln({x})/ln(10)"), PRODUCT),
                        _ => return Err(part()),
                    }
                }
                Node::Binary(operation @ (Binary::Add | Binary::Subtract), x, y) => {
                    (format!("{} {} {}", held(x, SUM), operation.name(), held(y, PRODUCT)), SUM)
                }
                Node::Binary(operation @ (Binary::Multiply | Binary::Divide), x, y) => {
                    (format!("{}{}{}", held(x, PRODUCT), operation.name(), held(y, SIGN)), PRODUCT)
                }
                Node::Binary(extreme @ (Binary::Max | Binary::Min), x, y) => {
                    let (taken, other) = if self.constant_of(*x).is_some() { (y, x) } else { (x, y) };
                    let (greater, less, sign) =
                        if *extreme == Binary::Max { (taken, other, '+') } else { (other, taken, '-') };
                    let difference = format!("{} - {}", held(greater, SUM), held(less, PRODUCT));
                    (format!("{} {sign} sqrt({difference})^2", held(other, SUM)), SUM)
                }
                Node::Binary(Binary::Power, x, y) => {
                    let exponent = self.constant_of(*y).ok_or_else(part)?;
                    if exponent.fract() == 0.0 && exponent.abs() <= LARGEST_EXPONENT {
                        (format!("{}^{exponent}", held(x, ATOM)), POWER)
                    } else if exponent == 0.5 {
                        (format!("sqrt({})", of(x).0), ATOM)
                    } else {
                        return Err(part());
                    }
                }
                _ => return Err(part()),
            };
            if text.0.len() > LONGEST {
                return Err(self.text().to_owned());
            }
            written.push(text);
        }
        Ok(written.pop().unwrap_or_default().0)
    }

    /// The number that a node is, a sign before it included.
    fn constant_of(&self, node: usize) -> Option<f64> {
        match self.tree.nodes().nth(node)? {
            Node::Number(x) | Node::Symbol(Symbol::Parameter(x), _) => Some(*x),
            Node::Unary(Unary::Negate, x) => self.constant_of(*x).map(|x| -x),
            Node::Binary(Binary::Divide, x, y) => Some(self.constant_of(*x)? / self.constant_of(*y)?),
            _ => None,
        }
    }
}

/// Binding power, as in the grammar of certificate files.
const SUM: u8 = 1;
const PRODUCT: u8 = 2;
const SIGN: u8 = 3;
const POWER: u8 = 4;
const ATOM: u8 = 5;
