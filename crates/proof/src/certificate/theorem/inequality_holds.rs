//! A point that satisfies linear matrix inequalities.
//!
//! `F_k(x) > 0` (or `>= 0`) for every k, evaluated at the given x with outward rounding, and exactly if needed. The
//! margin is a lower bound of the smallest eigenvalue.

use super::super::members::members;
use super::inequality::{Constraint, MatrixInequality};
use super::{Fact, Names, Statement};
use crate::definite::{self, Direction, positive_definite, positive_semidefinite};
use crate::error::ProofError;
use crate::exact::Exact;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::number::Number;
use crate::ring::Ring;
use crate::verdict::Verdict;
use crate::wording::quoted;

/// `F_k(x)` over a ring.
fn evaluate<R: Ring>(constraint: &Constraint, x: &[f64], number: impl Fn(&Number) -> R) -> Matrix<R> {
    let mut sum = Matrix::<R>::zeros(constraint.order, constraint.order);
    for entry in &constraint.entries {
        let factor = match entry.unknown {
            0 => R::from_f64(1.0),
            i => x.get(i - 1).and_then(|x| R::from_f64(*x)),
        };
        let term = factor.unwrap_or_else(R::zero).mul(&number(&entry.value));
        let at = &mut sum[(entry.row, entry.column)];
        *at = at.add(&term);
    }
    Matrix::from_fn(constraint.order, constraint.order, |i, j| sum[(i.min(j), i.max(j))].clone())
}

fn decide<T: definite::Entry>(m: &Matrix<T>, strict: bool) -> Result<Verdict<Direction>, ProofError> {
    if strict { positive_definite(m) } else { positive_semidefinite(m) }
}

/// A point satisfies the inequalities; the head of the file has the theorem.
#[derive(Debug, Clone, PartialEq)]
pub struct InequalityHolds {
    /// The inequalities.
    pub inequalities: MatrixInequality,
    /// The values of the unknowns.
    pub x: Vec<f64>,
}

impl Statement for InequalityHolds {
    const NAME: &'static str = "matrix-inequality-holds";

    fn facts(&self, _: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        if self.x.len() != self.inequalities.unknowns {
            let (expected, found) = ((self.inequalities.unknowns, 1), (self.x.len(), 1));
            return Err(ProofError::DimensionMismatch { what: "x", expected, found });
        }
        if let Some((row, &value)) = self.x.iter().enumerate().find(|(_, x)| !x.is_finite()) {
            return Err(ProofError::NotFinite { what: "x", row, column: 0, value });
        }
        let strict = self.inequalities.strict;
        let mut facts = Vec::new();
        for constraint in &self.inequalities.constraints {
            let enclosed: Matrix<Interval> = evaluate(constraint, &self.x, Number::enclosure);
            let mut verdict = decide(&enclosed, strict)?;
            let dyadic = constraint.entries.iter().all(|entry| entry.value.exact().is_some());
            if dyadic && matches!(verdict, Verdict::Undecided { .. }) {
                let exact: Matrix<Exact> =
                    evaluate(constraint, &self.x, |value| value.exact().cloned().unwrap_or_else(Exact::zero));
                verdict = decide(&exact, strict)?;
            }
            facts.push(Fact::new(
                format!("F(x) {} 0 of {}", self.inequalities.relation(), quoted(&constraint.name)),
                verdict,
            ));
        }
        Ok(facts)
    }

    fn words(&self) -> String {
        format!("The x given satisfies the linear matrix inequalities {}.", self.inequalities.described())
    }
}

members! { InequalityHolds { {
    inequalities: MatrixInequality = "inequalities".part();
    x = "x".numbers(inequalities.unknowns);
} } }
