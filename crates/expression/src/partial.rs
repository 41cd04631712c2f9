//! Partial derivatives of an expression, as text in the names of the expression.
//!
//! At a kink the derivative is that of the side whose value is taken, as in `graph::derivative`; of a jump it is 0.

use crate::expression::Expression;
use crate::function::{Binary, Unary};
use crate::scope::{Symbol, Variable};
use crate::tree::Node;

/// The longest text that is written.
const LONGEST: usize = 65_536;

impl Expression {
    /// The derivative by a variable, in the names of this expression; none where it is identically 0.
    ///
    /// ```
    /// use luenberger_expression::{Expression, Scope, Variable};
    /// let scope = Scope::plant(2, 0);
    /// let expression = Expression::parse("x1*sin(x2) + x1^3", &scope)?;
    /// let text = expression.partial(Variable::State(0)).ok().flatten().unwrap_or_default();
    /// let slope = Expression::parse(&text, &scope)?;
    /// assert_eq!(slope.evaluate(0.0, &[2.0, 0.5], &[]), 0.5_f64.sin() + 12.0);
    /// assert_eq!(Expression::parse("x1", &scope)?.partial(Variable::State(1)), Ok(None));
    /// # Ok::<(), luenberger_expression::ExpressionError>(())
    /// ```
    /// # Errors
    /// The part of the text whose derivative is not written: a lookup table, a power whose exponent is not a number, or
    /// the whole where it becomes too long.
    pub fn partial(&self, by: Variable) -> Result<Option<String>, String> {
        let mut slopes: Vec<Option<String>> = Vec::new();
        for (index, node) in self.tree.nodes().enumerate() {
            let slope = self.slope(index, node, by, &slopes)?;
            if slope.as_ref().is_some_and(|text| text.len() > LONGEST) {
                return Err(self.text().to_owned());
            }
            slopes.push(slope);
        }
        Ok(slopes.pop().flatten())
    }

    /// The text with `x1, ..` and `u1, ..` for states and inputs and with numbers for parameters; none with a lookup
    /// table.
    ///
    /// ```
    /// use luenberger_expression::{Expression, Parameters, Scope};
    /// let parameters = Parameters::from([("k".to_owned(), -2.0)]);
    /// let scope = Scope::plant(1, 0).named(&["speed".to_owned()], &[])?.with(&parameters)?;
    /// assert_eq!(Expression::parse("k*speed^2", &scope)?.numbered().as_deref(), Some("(-2.0)*x1^2.0"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn numbered(&self) -> Option<String> {
        if self.tree.nodes().any(|node| matches!(node, Node::Table(..))) {
            return None;
        }
        Some(self.tree.print_with(|symbol, name| match symbol {
            Symbol::State(k) => format!("x{}", k + 1),
            Symbol::Input(k) => format!("u{}", k + 1),
            Symbol::Parameter(value) => format!("({value:?})"),
            Symbol::Time | Symbol::Pi | Symbol::E => name.to_owned(),
        }))
    }

    /// The derivative of a node, as an operand.
    fn slope(
        &self,
        index: usize,
        node: &Node,
        by: Variable,
        slopes: &[Option<String>],
    ) -> Result<Option<String>, String> {
        let value = |k: usize| format!("({})", self.part(k));
        let of = |k: usize| slopes.get(k).cloned().flatten();
        let refused = || Err(self.part(index).to_owned());
        let written = |text: Option<String>| Ok(text.map(|text| format!("({text})")));
        match node {
            Node::Symbol(Symbol::State(k), _) => Ok((by == Variable::State(*k)).then(|| "1".to_owned())),
            Node::Symbol(Symbol::Input(k), _) => Ok((by == Variable::Input(*k)).then(|| "1".to_owned())),
            Node::Unary(function, x) => {
                let Some(dx) = of(*x) else { return Ok(None) };
                written(unary(*function, &value(*x), &dx))
            }
            Node::Binary(binary, x, y) => {
                let (dx, dy) = (of(*x), of(*y));
                if dx.is_none() && dy.is_none() {
                    return Ok(None);
                }
                let (vx, vy) = (value(*x), value(*y));
                let joined = |first: Option<String>, sign: &str, second: Option<String>| match (first, second) {
                    (Some(first), Some(second)) => format!("{first} {sign} {second}"),
                    (None, Some(second)) => format!("0 {sign} {second}"),
                    (Some(first), None) => first,
                    (None, None) => "0".to_owned(),
                };
                let or_zero = |slope: Option<String>| slope.unwrap_or_else(|| "0".to_owned());
                written(Some(match binary {
                    Binary::Add => joined(dx, "+", dy),
                    Binary::Subtract => joined(dx, "-", dy),
                    Binary::Multiply => {
                        joined(dx.map(|dx| format!("{dx}*{vy}")), "+", dy.map(|dy| format!("{vx}*{dy}")))
                    }
                    Binary::Divide => match dy {
                        None => format!("{}/{vy}", or_zero(dx)),
                        Some(dy) => format!("({})/{vy}", joined(dx, "-", Some(format!("{vx}/{vy}*{dy}")))),
                    },
                    Binary::Power if dy.is_none() => match dx {
                        Some(dx) => format!("{vy}*{vx}^({vy} - 1)*{dx}"),
                        None => "0".to_owned(),
                    },
                    Binary::Atan2 => format!(
                        "({})/({vx}^2 + {vy}^2)",
                        joined(dx.map(|dx| format!("{vy}*{dx}")), "-", dy.map(|dy| format!("{vx}*{dy}")))
                    ),
                    Binary::Max => format!("if({vy} > {vx}, {}, {})", or_zero(dy), or_zero(dx)),
                    Binary::Min => format!("if({vy} < {vx}, {}, {})", or_zero(dy), or_zero(dx)),
                    _ => return refused(),
                }))
            }
            Node::If(condition, x, y) => {
                let (dx, dy) = (of(*x), of(*y));
                if dx.is_none() && dy.is_none() {
                    return Ok(None);
                }
                let or_zero = |slope: Option<String>| slope.unwrap_or_else(|| "0".to_owned());
                written(Some(format!("if({}, {}, {})", self.part(*condition), or_zero(dx), or_zero(dy))))
            }
            Node::Saturate(x, low, high) => {
                let [dx, dlow, dhigh] = [x, low, high].map(|k| of(*k));
                if dx.is_none() && dlow.is_none() && dhigh.is_none() {
                    return Ok(None);
                }
                if dlow.is_some() || dhigh.is_some() {
                    return refused();
                }
                let inside = format!("{0} >= {1} && {0} <= {2}", value(*x), value(*low), value(*high));
                written(Some(format!("if({inside}, {}, 0)", dx.unwrap_or_default())))
            }
            Node::Table(_, _, x) if of(*x).is_some() => refused(),
            _ => Ok(None),
        }
    }
}

/// The derivative of a function of x with the derivative dx; none where it is 0.
fn unary(function: Unary, x: &str, dx: &str) -> Option<String> {
    Some(match function {
        Unary::Negate => format!("-{dx}"),
        Unary::Reciprocal => format!("-{dx}/{x}^2"),
        Unary::Abs => format!("if({x} < 0, -{dx}, {dx})"),
        Unary::Sign | Unary::Step => return None,
        Unary::Sqrt => format!("{dx}/(2*sqrt{x})"),
        Unary::Exp => format!("exp{x}*{dx}"),
        Unary::Ln => format!("{dx}/{x}"),
        Unary::Log10 => format!("{dx}/(ln(10)*{x})"),
        Unary::Sin => format!("cos{x}*{dx}"),
        Unary::Cos => format!("-sin{x}*{dx}"),
        Unary::Tan => format!("(1 + tan{x}^2)*{dx}"),
        Unary::Asin => format!("{dx}/sqrt((1 - {x})*(1 + {x}))"),
        Unary::Acos => format!("-{dx}/sqrt((1 - {x})*(1 + {x}))"),
        Unary::Atan => format!("{dx}/(1 + {x}^2)"),
        Unary::Sinh => format!("cosh{x}*{dx}"),
        Unary::Cosh => format!("sinh{x}*{dx}"),
        Unary::Tanh => format!("(1 - tanh{x})*(1 + tanh{x})*{dx}"),
        Unary::Asinh => format!("{dx}/sqrt(1 + {x}^2)"),
        Unary::Acosh => format!("{dx}/sqrt(({x} - 1)*({x} + 1))"),
        Unary::Atanh => format!("{dx}/((1 - {x})*(1 + {x}))"),
    })
}
