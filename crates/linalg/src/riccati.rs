//! Algebraic Riccati equations.
use crate::Result;
use nalgebra::{Complex, DMatrix};

/// Stabilizing solution of a Riccati equation with its evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Riccati {
    /// The solution, exactly symmetric.
    pub x: DMatrix<f64>,
    /// The feedback gain of `u = -K x`.
    pub k: DMatrix<f64>,
    /// Eigenvalues of `A - B K`.
    pub poles: Vec<Complex<f64>>,
    /// Relative residual.
    pub residual: f64,
}

/// Steady-state Kalman gain with its evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Kalman {
    /// The observer gain of `A - L C`.
    pub l: DMatrix<f64>,
    /// The error covariance.
    pub p: DMatrix<f64>,
    /// Eigenvalues of `A - L C`.
    pub poles: Vec<Complex<f64>>,
    /// Relative residual.
    pub residual: f64,
}

/// `A'X + X A - X B R^-1 B'X + Q = 0`.
/// # Errors
/// See [`crate::LinalgError`].
pub fn care(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>, r: &DMatrix<f64>) -> Result<Riccati> {
    let _ = (a, b, q, r);
    todo!()
}

/// `A'X A - X - A'X B (R + B'X B)^-1 B'X A + Q = 0`.
/// # Errors
/// See [`crate::LinalgError`].
pub fn dare(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>, r: &DMatrix<f64>) -> Result<Riccati> {
    let _ = (a, b, q, r);
    todo!()
}

/// The feedback gain of the continuous linear-quadratic regulator: [`care`].
/// # Errors
/// Those of [`care`].
pub fn lqr(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>, r: &DMatrix<f64>) -> Result<Riccati> {
    care(a, b, q, r)
}

/// The feedback gain of the discrete linear-quadratic regulator: [`dare`].
/// # Errors
/// Those of [`dare`].
pub fn dlqr(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>, r: &DMatrix<f64>) -> Result<Riccati> {
    dare(a, b, q, r)
}

/// Kalman gain.
/// # Errors
/// See [`crate::LinalgError`].
pub fn kalman_gain(a: &DMatrix<f64>, c: &DMatrix<f64>, w: &DMatrix<f64>, v: &DMatrix<f64>) -> Result<Kalman> {
    let _ = (a, c, w, v);
    todo!()
}

/// Predictor gain.
/// # Errors
/// See [`crate::LinalgError`].
pub fn discrete_kalman_gain(a: &DMatrix<f64>, c: &DMatrix<f64>, w: &DMatrix<f64>, v: &DMatrix<f64>) -> Result<Kalman> {
    let _ = (a, c, w, v);
    todo!()
}
