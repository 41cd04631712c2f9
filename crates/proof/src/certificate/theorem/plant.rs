//! The linear plant `x' = A x + B u`, `y = C x` of a certificate.

use super::super::members::members;
use super::{bounded, counted, data};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::number::Datum;

/// A plant known exactly: A n x n, B n x m (m may be 0), C p x n.
#[derive(Debug, Clone, PartialEq)]
pub struct PlantMatrices {
    /// The state matrix.
    pub a: Matrix<f64>,
    /// The input matrix.
    pub b: Matrix<f64>,
    /// The output matrix.
    pub c: Matrix<f64>,
}

/// A plant whose entries are numbers or bounds of numbers: A n x n, B n x m (m may be 0), C p x n.
#[derive(Debug, Clone, PartialEq)]
pub struct PlantWithin {
    /// The state matrix.
    pub a: Matrix<Datum>,
    /// The input matrix.
    pub b: Matrix<Datum>,
    /// The output matrix.
    pub c: Matrix<Datum>,
}

impl PlantMatrices {
    pub(super) fn order(&self) -> usize {
        self.a.rows()
    }

    pub(super) fn outputs(&self) -> usize {
        self.c.rows()
    }

    /// `n x p`: the shape of the gains.
    pub(super) fn gain(&self) -> (usize, usize) {
        (self.order(), self.outputs())
    }

    pub(super) fn size(&self) -> String {
        size(self.a.rows(), self.b.cols(), self.c.rows())
    }
}

impl PlantWithin {
    /// A plant known exactly.
    ///
    /// # Errors
    /// [`ProofError::NotFinite`].
    pub fn exactly(a: &Matrix<f64>, b: &Matrix<f64>, c: &Matrix<f64>) -> Result<Self, ProofError> {
        Ok(Self { a: data(a, "A")?, b: data(b, "B")?, c: data(c, "C")? })
    }

    /// A plant between bounds.
    ///
    /// # Errors
    /// [`ProofError::NotFinite`] for a bound that is infinite.
    pub fn within(a: &Matrix<Interval>, b: &Matrix<Interval>, c: &Matrix<Interval>) -> Result<Self, ProofError> {
        Ok(Self { a: bounded(a, "A")?, b: bounded(b, "B")?, c: bounded(c, "C")? })
    }

    pub(super) fn order(&self) -> usize {
        self.a.rows()
    }

    pub(super) fn outputs(&self) -> usize {
        self.c.rows()
    }

    /// `n x p`: the shape of the gains.
    pub(super) fn gain(&self) -> (usize, usize) {
        (self.order(), self.outputs())
    }

    pub(super) fn size(&self) -> String {
        size(self.a.rows(), self.b.cols(), self.c.rows())
    }
}

fn size(states: usize, inputs: usize, outputs: usize) -> String {
    format!("{}, {} and {}", counted(states, "state"), counted(inputs, "input"), counted(outputs, "output"))
}

members! { PlantMatrices { {
    a = "A".square();
    b = "B".matrix_with_rows(a.rows());
    c = "C".matrix_with_columns(a.rows());
} } }

members! { PlantWithin { {
    a = "A".square_data();
    b = "B".data_with_rows(a.rows());
    c = "C".data_with_columns(a.rows());
} } }
