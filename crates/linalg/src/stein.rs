//! Discrete Stein (Stein) equation `A'P A - P + Q = 0`.
use crate::Result;
use nalgebra::DMatrix;

/// Solution of `A'P A - P + Q = 0` with its evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Stein {
    /// The solution, exactly symmetric.
    pub p: DMatrix<f64>,
    /// Relative residual.
    pub residual: f64,
    /// Estimated separation.
    pub separation: f64,
    /// Condition.
    pub condition: f64,
}

/// Solves `A'P A - P + Q = 0`.
/// # Errors
/// See [`crate::LinalgError`].
pub fn stein(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<Stein> {
    let _ = (a, q);
    todo!()
}
