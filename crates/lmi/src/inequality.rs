//! Strict matrix inequalities: `expression >> 0.0` and `expression << 0.0`.
//!
//! `E >> c` means that `E - c I` is positive definite, `E << c` that `E - c I` is negative definite, and `E >> F` that
//! `E - F` is positive definite. All are strict, and a margin is maximised: the solution has `E - c I >= t I` with t >
//! 0 proved. An inequality that cannot be strict (such as `Z C + C'Z' <= 0` when C has fewer rows than columns) is
//! therefore refuted, with a witness that shows why; restate it on the subspace where it can be strict.

use std::ops::{Shl, Shr};

use nalgebra::DMatrix;

use crate::expression::{Expression, minus, zeros};
use crate::variable::Variable;

/// A strict inequality, in the form "this symmetric expression is positive definite".
#[derive(Debug, Clone)]
pub struct Inequality {
    pub(crate) positive: Expression,
}

impl Inequality {
    /// The expression that is to be positive definite.
    pub fn positive(&self) -> &Expression {
        &self.positive
    }
}

/// Right-hand side of an inequality: a number c, meaning c I, or another expression.
pub trait Bound {
    /// The bound as a matrix of the given shape.
    fn of_shape(self, rows: usize, columns: usize) -> Expression;
}

impl Bound for f64 {
    fn of_shape(self, rows: usize, columns: usize) -> Expression {
        if self == 0.0 {
            zeros(rows, columns)
        } else {
            Expression::constant(DMatrix::from_diagonal_element(rows, columns, self))
        }
    }
}

macro_rules! bounds {
    ($($kind:ty),*) => {$(
        impl Bound for $kind {
            fn of_shape(self, _: usize, _: usize) -> Expression {
                self.into()
            }
        }
    )*};
}

bounds!(Expression, &Expression, &Variable, DMatrix<f64>, &DMatrix<f64>);

macro_rules! comparisons {
    ($($left:ty),*) => {$(
        impl<B: Bound> Shr<B> for $left {
            type Output = Inequality;
            fn shr(self, bound: B) -> Inequality {
                let left = Expression::from(self);
                let (rows, columns) = left.shape();
                Inequality { positive: minus(left, bound.of_shape(rows, columns)) }
            }
        }
        impl<B: Bound> Shl<B> for $left {
            type Output = Inequality;
            fn shl(self, bound: B) -> Inequality {
                let left = Expression::from(self);
                let (rows, columns) = left.shape();
                Inequality { positive: minus(bound.of_shape(rows, columns), left) }
            }
        }
    )*};
}

comparisons!(Expression, &Expression, &Variable);
