//! The numbers of a design in the form that the verification takes.
//!
//! A design names its [`Theorem`](luenberger_proof::certificate::Theorem); conditions, text, margins and file come from
//! it, computed once when the design is made and kept in its
//! [`Certificate`](luenberger_proof::certificate::Certificate). The data of a theorem are the implemented numbers: L,
//! N, P and theta as stored.

use luenberger_proof::certificate::PlantMatrices;
use luenberger_proof::{Matrix, ProofError};
use nalgebra::DMatrix;

/// The same numbers, rows first.
pub(crate) fn exact(m: &DMatrix<f64>) -> Result<Matrix<f64>, ProofError> {
    Matrix::from_column_major(m.nrows(), m.ncols(), m.as_slice())
}

/// The plant `x' = A x + B u`, `y = C x`, or its sampled form.
pub(crate) fn plant((a, b, c): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>)) -> Result<PlantMatrices, ProofError> {
    Ok(PlantMatrices { a: exact(a)?, b: exact(b)?, c: exact(c)? })
}

/// A design whose evidence is its field `certificate`.
macro_rules! certified {
    ($($design:ty),+ $(,)?) => {
        $(impl luenberger_proof::certificate::Certified for $design {
            fn certificate(&self) -> &luenberger_proof::certificate::Certificate {
                &self.certificate
            }
        })+
    };
}
pub(crate) use certified;
