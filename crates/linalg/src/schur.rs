//! Real Schur form.
use crate::Result;
use nalgebra::{Complex, DMatrix};

/// `A = Q T Q'`.
#[derive(Debug, Clone, PartialEq)]
pub struct Schur {
    /// Orthogonal.
    pub q: DMatrix<f64>,
    /// Upper quasi-triangular.
    pub t: DMatrix<f64>,
}

/// Real Schur form.
/// # Errors
/// Not square, not finite, not converged.
pub fn schur(a: &DMatrix<f64>) -> Result<Schur> {
    let _ = a;
    todo!()
}

impl Schur {
    /// The eigenvalues, in the order of the diagonal.
    pub fn eigenvalues(&self) -> Vec<Complex<f64>> {
        todo!()
    }
}
