//! Matrices and numbers of data as elements of a ring.

use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::ring::Ring;

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
