//! Matrices and numbers of data as elements of a ring, and expressions of them.

use crate::definite::{self, Direction, Sense};
use crate::error::ProofError;
use crate::exact::Exact;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::Verdict;

/// Largest order for exact evaluation: a product costs n^3 exact multiplications, about 1 s at this order.
pub(crate) const EXACT_ORDER: usize = 160;

/// Embeds a matrix of data into the ring, after a check of its shape.
pub(crate) fn embed<R: Ring>(
    data: &Matrix<f64>,
    what: &'static str,
    shape: (usize, usize),
) -> Result<Matrix<R>, ProofError> {
    data.expect_shape(what, shape)?;
    Matrix::embed(data, what)
}

/// Embeds a number.
pub(crate) fn number<R: Ring>(x: f64, what: &'static str) -> Result<R, ProofError> {
    R::from_f64(x).ok_or(ProofError::NotFinite { what, row: 0, column: 0, value: x })
}

/// Embeds a matrix that must be symmetric of the given order.
pub(crate) fn embed_symmetric<R: Ring>(
    data: &Matrix<f64>,
    what: &'static str,
    order: usize,
) -> Result<Matrix<R>, ProofError> {
    let embedded = embed(data, what, (order, order))?;
    for row in 0..order {
        for column in row + 1..order {
            let (upper, lower) = (data[(row, column)], data[(column, row)]);
            if upper != lower {
                return Err(ProofError::NotSymmetric { what, row, column, upper, lower });
            }
        }
    }
    Ok(embedded)
}

/// A matrix as an expression in the data, over any ring.
pub(crate) trait Expression {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError>;

    /// Decides the definiteness of the expression, which must be symmetric.
    fn decide(&self, sense: Sense) -> Result<Verdict<Direction>, ProofError> {
        let enclosed: Matrix<Interval> = self.evaluate()?;
        let verdict = definite::decide(&enclosed, sense)?;
        if matches!(verdict, Verdict::Undecided { .. }) && enclosed.rows() <= EXACT_ORDER {
            return definite::decide(&self.evaluate::<Exact>()?, sense);
        }
        Ok(verdict)
    }
}

impl Expression for Matrix<f64> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        Matrix::embed(self, "the matrix")
    }
}
