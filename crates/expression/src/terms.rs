//! An expression as a sum of terms: constant multiples of variables, and the rest, of which only the variables are
//! known.
//!
//! What is read here holds for all states, inputs and times for which the expression is defined, in real arithmetic
//! with the constants as stored: `1*x1`, `x1 + 0*x2` and `3*x1 - 2*x1` are `x1`, and `sat(x1, -10, 10)` is not. A
//! factor is known only if no operation rounded it. Whatever is no sum, and no product with a constant, belongs to the
//! rest: what cannot be shown of an expression counts as not so.

use core::mem;
use std::collections::{BTreeMap, BTreeSet};

use crate::expression::Expression;
use crate::function::{Binary, Unary};
use crate::scope::{Symbol, Variable};
use crate::tree::Node;

/// The terms of an expression; see [`Expression::terms`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Terms {
    /// Constant multiples, none of which is known to be 0; no number where it was rounded.
    multiples: BTreeMap<Variable, Option<f64>>,
    /// The variables of all other terms.
    rest: BTreeSet<Variable>,
    /// Whether the time occurs in these.
    timed: bool,
    /// The sum of the terms without variables and time; none where it was rounded.
    constant: Option<f64>,
}

impl Expression {
    /// What it is as a sum of terms.
    ///
    /// Cost: linear in the length, times a logarithm.
    ///
    /// ```
    /// use luenberger_expression::{Expression, Scope, Variable};
    /// let terms = |text: &str| Expression::parse(text, &Scope::plant(2, 1)).map(|expression| expression.terms());
    /// assert_eq!(terms("2*x1 - x1 + 0*x2")?.variable(), Some(Variable::State(0)));
    /// assert_eq!(terms("if(t > 5, 0, x1)")?.variable(), None);
    /// let sum = terms("4*x2 + x1*u1")?;
    /// assert_eq!(sum.multiple_of(Variable::State(1)), Some(4.0));
    /// assert!(!sum.is_linear_in(Variable::State(0)) && sum.depends_on(Variable::Input(0)) && !sum.uses_time());
    /// # Ok::<(), luenberger_expression::ExpressionError>(())
    /// ```
    pub fn terms(&self) -> Terms {
        let mut all: Vec<Terms> = Vec::new();
        // Of each condition whose answer is known.
        let mut truths: Vec<Option<bool>> = Vec::new();
        for node in self.tree.nodes() {
            let truth = match node {
                Node::Compare(comparison, x, y) => {
                    all[*x].number().zip(all[*y].number()).map(|(x, y)| comparison.at(x, y))
                }
                Node::And(x, y) => match (truths[*x], truths[*y]) {
                    (Some(x), Some(y)) => Some(x && y),
                    _ => None,
                },
                Node::Or(x, y) => match (truths[*x], truths[*y]) {
                    (Some(x), Some(y)) => Some(x || y),
                    _ => None,
                },
                Node::Not(x) => truths[*x].map(|truth| !truth),
                _ => None,
            };
            // Each node is an operand once.
            let mut take = |index: &usize| mem::take(&mut all[*index]);
            let terms = match node {
                Node::Number(x) | Node::Symbol(Symbol::Parameter(x), _) => Terms::constant(Some(*x)),
                Node::Symbol(Symbol::Pi | Symbol::E, _) | Node::Then | Node::Else => Terms::constant(None),
                Node::Symbol(Symbol::State(k), _) => [(Variable::State(*k), 1.0)].into_iter().collect(),
                Node::Symbol(Symbol::Input(k), _) => [(Variable::Input(*k), 1.0)].into_iter().collect(),
                Node::Symbol(Symbol::Time, _) => Terms { timed: true, ..Terms::constant(Some(0.0)) },
                Node::Unary(Unary::Negate, x) => take(x).scaled(Some(-1.0), product),
                Node::Binary(Binary::Add, x, y) => take(x).plus(take(y)),
                Node::Binary(Binary::Subtract, x, y) => take(x).plus(take(y).scaled(Some(-1.0), product)),
                Node::Binary(Binary::Multiply, x, y) => match (take(x), take(y)) {
                    (factor, of) | (of, factor) if factor.is_constant() => of.scaled(factor.constant, product),
                    (x, y) => Terms::of_unknown([x, y]),
                },
                Node::Binary(Binary::Divide, x, y) => match (take(x), take(y)) {
                    (of, divisor) if divisor.is_constant() && divisor.constant != Some(0.0) => {
                        of.scaled(divisor.constant, quotient)
                    }
                    (x, y) => Terms::of_unknown([x, y]),
                },
                Node::If(condition, x, y) => match truths[*condition] {
                    Some(true) => take(x),
                    Some(false) => take(y),
                    None => Terms::of_unknown([condition, x, y].map(take)),
                },
                Node::Unary(_, x) | Node::Table(_, _, x) | Node::Not(x) => Terms::of_unknown([take(x)]),
                Node::Surface(_, _, x, y)
                | Node::Binary(_, x, y)
                | Node::Compare(_, x, y)
                | Node::And(x, y)
                | Node::Or(x, y) => Terms::of_unknown([x, y].map(take)),
                Node::Saturate(x, low, high) => Terms::of_unknown([x, low, high].map(take)),
            };
            all.push(terms);
            truths.push(truth);
        }
        all.pop().unwrap_or_default()
    }
}

impl Terms {
    /// The variable that this is, for all states, inputs and times, if that is shown.
    pub fn variable(&self) -> Option<Variable> {
        let mut multiples = self.multiples.iter();
        match (multiples.next(), multiples.next()) {
            (Some((variable, Some(1.0))), None) if self.is_affine() && self.constant == Some(0.0) => Some(*variable),
            _ => None,
        }
    }

    /// Whether this is a sum of constant multiples of variables and a constant, without the time.
    pub fn is_affine(&self) -> bool {
        self.rest.is_empty() && !self.timed
    }

    /// Whether a variable occurs in constant multiples only, or not at all.
    pub fn is_linear_in(&self, variable: Variable) -> bool {
        !self.rest.contains(&variable)
    }

    /// The constant factor of a variable that occurs in multiples only, 0 if it does not occur; none if it is not
    /// known.
    pub fn multiple_of(&self, variable: Variable) -> Option<f64> {
        if self.is_linear_in(variable) {
            self.multiples.get(&variable).map_or(Some(0.0), |factor| *factor)
        } else {
            None
        }
    }

    /// Whether it may depend on a variable.
    pub fn depends_on(&self, variable: Variable) -> bool {
        self.multiples.contains_key(&variable) || self.rest.contains(&variable)
    }

    /// The variables on which it may depend.
    pub fn variables(&self) -> impl Iterator<Item = Variable> {
        self.multiples.keys().chain(&self.rest).copied()
    }

    /// Whether it may depend on the time.
    pub fn uses_time(&self) -> bool {
        self.timed
    }

    fn constant(value: Option<f64>) -> Self {
        Self { constant: value.filter(|value| value.is_finite()), ..Self::default() }
    }

    fn is_constant(&self) -> bool {
        self.multiples.is_empty() && self.is_affine()
    }

    /// The number that this is.
    fn number(&self) -> Option<f64> {
        self.constant.filter(|_| self.is_constant())
    }

    /// The result of any operation on these.
    fn of_unknown<const N: usize>(operands: [Self; N]) -> Self {
        let mut rest = BTreeSet::new();
        let mut timed = false;
        for operand in operands {
            rest.extend(operand.variables());
            timed |= operand.timed;
        }
        let is_constant = rest.is_empty() && !timed;
        Self { multiples: BTreeMap::new(), rest, timed, constant: if is_constant { None } else { Some(0.0) } }
    }

    fn plus(mut self, mut other: Self) -> Self {
        if self.multiples.len() < other.multiples.len() {
            mem::swap(&mut self, &mut other);
        }
        for (variable, factor) in other.multiples {
            let both = match self.multiples.get(&variable) {
                Some(own) => own.zip(factor).and_then(|(a, b)| sum(a, b)),
                None => factor,
            };
            if both == Some(0.0) {
                self.multiples.remove(&variable);
            } else {
                self.multiples.insert(variable, both);
            }
        }
        if self.rest.len() < other.rest.len() {
            mem::swap(&mut self.rest, &mut other.rest);
        }
        self.rest.extend(other.rest);
        self.timed |= other.timed;
        self.constant = self.constant.zip(other.constant).and_then(|(a, b)| sum(a, b));
        self
    }

    /// Times, or over, a constant. The rest stays, also with the factor 0: it may be undefined somewhere.
    fn scaled(mut self, by: Option<f64>, operation: fn(f64, f64) -> Option<f64>) -> Self {
        let scaled = |factor: Option<f64>| factor.zip(by).and_then(|(factor, by)| operation(factor, by));
        self.multiples.values_mut().for_each(|factor| *factor = scaled(*factor));
        self.multiples.retain(|_, factor| *factor != Some(0.0));
        self.constant = scaled(self.constant);
        self
    }
}

/// The row of a matrix: multiples of variables.
impl FromIterator<(Variable, f64)> for Terms {
    fn from_iter<I: IntoIterator<Item = (Variable, f64)>>(row: I) -> Self {
        let one = |(variable, factor): (Variable, f64)| {
            let factor = Some(factor).filter(|factor| factor.is_finite());
            let multiples = if factor == Some(0.0) { BTreeMap::new() } else { [(variable, factor)].into() };
            Self { multiples, ..Self::constant(Some(0.0)) }
        };
        row.into_iter().map(one).fold(Self::constant(Some(0.0)), Self::plus)
    }
}

/// Below this the remainder of a product of binary64 numbers may underflow.
const LEAST: f64 = f64::MIN_POSITIVE / (f64::EPSILON * f64::EPSILON);

/// `a + b`, if it is a binary64 number (Knuth's error of a sum is 0).
fn sum(a: f64, b: f64) -> Option<f64> {
    let sum = a + b;
    let part = sum - a;
    let error = (a - (sum - part)) + (b - part);
    (sum.is_finite() && error == 0.0).then_some(sum)
}

/// `a b`, if it is a binary64 number.
fn product(a: f64, b: f64) -> Option<f64> {
    let product = a * b;
    let is_exact = a == 0.0 || b == 0.0 || (product.abs() >= LEAST && a.mul_add(b, -product) == 0.0);
    (product.is_finite() && is_exact).then_some(product)
}

/// `a / b`, if it is a binary64 number; b is not 0.
fn quotient(a: f64, b: f64) -> Option<f64> {
    let quotient = a / b;
    let is_exact = a == 0.0 || (a.abs() >= LEAST && quotient.mul_add(b, -a) == 0.0);
    (quotient.is_finite() && is_exact).then_some(quotient)
}
