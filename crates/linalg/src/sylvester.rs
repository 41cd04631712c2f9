//! Sylvester equation `A X + X B = C`.
use crate::Result;
use nalgebra::DMatrix;

/// Solution of `A X + X B = C` with its evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Sylvester {
    /// The solution.
    pub x: DMatrix<f64>,
    /// Relative residual.
    pub residual: f64,
    /// Estimated separation.
    pub separation: f64,
    /// Condition.
    pub condition: f64,
}

/// Solves `A X + X B = C`.
/// # Errors
/// See [`crate::LinalgError`].
pub fn sylvester(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<Sylvester> {
    let _ = (a, b, c);
    todo!()
}
