//! Certificates of designs: the theorem of a design with the numbers that prove it.
//!
//! A design names its [`Theorem`](luenberger_proof::certificate::Theorem); conditions, text, margins and file come from
//! it, computed once when the design is made and kept in its
//! [`Certificate`](luenberger_proof::certificate::Certificate). The data of a theorem are the implemented numbers: L,
//! N, P and theta as stored.

use luenberger_lmi::proof_matrix;
use luenberger_proof::certificate::PlantMatrices;
use nalgebra::DMatrix;

/// The plant `x' = A x + B u`, `y = C x`, or its sampled form.
pub(crate) fn plant((a, b, c): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>)) -> PlantMatrices {
    PlantMatrices { a: proof_matrix(a), b: proof_matrix(b), c: proof_matrix(c) }
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
