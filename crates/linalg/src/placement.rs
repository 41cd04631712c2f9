//! t
use crate::Result;
use nalgebra::{Complex, DMatrix};
/// t
pub struct Placement {
    /// Gain.
    pub gain: DMatrix<f64>,
    /// Poles.
    pub poles: Vec<Complex<f64>>,
    /// cond
    pub condition: f64,
}
/// t
/// # Errors
/// t
pub fn place(_a: &DMatrix<f64>, _b: &DMatrix<f64>, _poles: &[Complex<f64>]) -> Result<Placement> {
    todo!()
}
/// t
/// # Errors
/// t
pub fn place_observer(_a: &DMatrix<f64>, _c: &DMatrix<f64>, _poles: &[Complex<f64>]) -> Result<Placement> {
    todo!()
}
