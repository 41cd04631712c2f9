//! The linear plant `x' = A x + B u`, `y = C x` of a certificate.

use super::super::fields::Fields;
use super::super::write::Out;
use super::{FileError, bounded, counted, data};
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
    pub(super) fn read(file: &mut Fields<'_>) -> Result<Self, FileError> {
        let mut fields = file.object("plant")?;
        let a = fields.take("A")?.square()?;
        let b = fields.take("B")?.matrix_with_rows(a.rows())?;
        let c = fields.take("C")?.matrix_with_columns(a.rows())?;
        fields.finish()?;
        Ok(Self { a, b, c })
    }

    pub(super) fn write(&self) -> (&'static str, Out) {
        let members = vec![("A", Out::matrix(&self.a)), ("B", Out::matrix(&self.b)), ("C", Out::matrix(&self.c))];
        ("plant", Out::Object(members))
    }

    /// `n x p`: the shape of the gains.
    pub(super) fn gain(&self) -> (usize, usize) {
        (self.a.rows(), self.c.rows())
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

    pub(super) fn read(file: &mut Fields<'_>) -> Result<Self, FileError> {
        let mut fields = file.object("plant")?;
        let a = fields.take("A")?.square_data()?;
        let b = fields.take("B")?.data_with_rows(a.rows())?;
        let c = fields.take("C")?.data_with_columns(a.rows())?;
        fields.finish()?;
        Ok(Self { a, b, c })
    }

    pub(super) fn write(&self) -> (&'static str, Out) {
        let members = vec![("A", Out::data(&self.a)), ("B", Out::data(&self.b)), ("C", Out::data(&self.c))];
        ("plant", Out::Object(members))
    }

    pub(super) fn gain(&self) -> (usize, usize) {
        (self.a.rows(), self.c.rows())
    }

    pub(super) fn size(&self) -> String {
        size(self.a.rows(), self.b.cols(), self.c.rows())
    }
}

fn size(states: usize, inputs: usize, outputs: usize) -> String {
    format!("{}, {} and {}", counted(states, "state"), counted(inputs, "input"), counted(outputs, "output"))
}
