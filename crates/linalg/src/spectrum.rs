//! Where the eigenvalues lie.
use crate::Result;
use nalgebra::{Complex, DMatrix};

/// Eigenvalues of `a`.
/// # Errors
/// Not square, not finite, not converged.
pub fn eigenvalues(a: &DMatrix<f64>) -> Result<Vec<Complex<f64>>> {
    let _ = a;
    todo!()
}
/// Eigenvalues of symmetric `m`, ascending.
/// # Errors
/// Not symmetric, not finite, not converged.
pub fn symmetric_eigenvalues(m: &DMatrix<f64>) -> Result<Vec<f64>> {
    let _ = m;
    todo!()
}
/// Smallest eigenvalue of symmetric `m`.
/// # Errors
/// As [`symmetric_eigenvalues`], and empty.
pub fn lambda_min(m: &DMatrix<f64>) -> Result<f64> {
    let _ = m;
    todo!()
}
/// Largest eigenvalue of symmetric `m`.
/// # Errors
/// As [`symmetric_eigenvalues`], and empty.
pub fn lambda_max(m: &DMatrix<f64>) -> Result<f64> {
    let _ = m;
    todo!()
}
/// Largest real part of the eigenvalues.
/// # Errors
/// As [`eigenvalues`], and empty.
pub fn spectral_abscissa(a: &DMatrix<f64>) -> Result<f64> {
    let _ = a;
    todo!()
}
/// Largest modulus of the eigenvalues.
/// # Errors
/// As [`eigenvalues`], and empty.
pub fn spectral_radius(a: &DMatrix<f64>) -> Result<f64> {
    let _ = a;
    todo!()
}
