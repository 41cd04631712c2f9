//! ExtendedKalmanFilter of 2 states, 1 inputs and 1 outputs, one step per sample.
//!
//!
//! SHA-256 of the numbers: ecede503cd1f465c8e2209f8730307899799f5df471813add27bb4486c9be48c
pub use luenberger_observers;

use luenberger_observers::nalgebra::{SMatrix, SVector};
use luenberger_observers::{ExtendedKalmanFilter, NoiseModel, StaticExtendedKalmanFilter, ObserverError};

/// The observer, with its sizes and its scalar.
pub type Observer = StaticExtendedKalmanFilter<Model, f32, 2, 1, 1>;

/// The first estimate of the design.
pub fn initial() -> SVector<f32, 2> {
    SVector::from([0.25, 0.25])
}

/// The observer.
///
/// # Errors
/// None: the numbers were checked when they were written.
pub fn observer() -> Result<Observer, ObserverError> {
    let w = SMatrix::<f32, 2, 2>::from_row_slice(&[0.5, 0.0, 0.0, 0.25]);
    let v = SMatrix::<f32, 1, 1>::from_row_slice(&[0.125]);
    let p0 = SMatrix::<f32, 2, 2>::from_row_slice(&[1.0, 0.0, 0.0, 2.0]);
    let noises = NoiseModel { w, v, p0 };
    ExtendedKalmanFilter::new(Model, noises, 0.0625, 2)?.with_gate(3.0)
}

/// The plant x' = f(t, x, u), y = h(t, x, u), or x+ = f(t, x, u) in discrete time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model;

luenberger_observers::straight_line_plant!(Model, f32, 2, 1, 1, f, h, motion, measurement);

/// f(t, x, u).
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn f(_t: f32, x: &[f32; 2], u: &[f32], out: &mut [f32; 2]) {
    let Some(u) = u.first_chunk::<1>() else { return };
    let v2 = -x[0];
    let v4 = x[1] * 0.5;
    let v5 = x[0] * x[0];
    let v6 = -v5;
    let v7 = libm::expf(v6);
    let v8 = v4 * v7;
    let v9 = v2 - v8;
    let v11 = v9 + u[0];
    out[0] = x[1];
    out[1] = v11;
}

/// h(t, x, u).
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn h(_t: f32, x: &[f32; 2], _u: &[f32], out: &mut [f32; 1]) {
    let v3 = x[1] * x[1];
    let v4 = 1.0 + v3;
    let v5 = libm::sqrtf(v4);
    let v6 = x[0] * v5;
    out[0] = v6;
}

/// f(t, x, u) and Df, row by row.
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn motion(_t: f32, x: &[f32; 2], u: &[f32], out: &mut [f32; 6]) {
    let Some(u) = u.first_chunk::<1>() else { return };
    let v3 = -x[0];
    let v5 = x[1] * 0.5;
    let v7 = x[0] * x[0];
    let v8 = -v7;
    let v9 = libm::expf(v8);
    let v10 = v5 * v9;
    let v11 = v3 - v10;
    let v13 = v11 + u[0];
    let v15 = x[0] + x[0];
    let v16 = v9 * v15;
    let v17 = v5 * v16;
    let v18 = (-1.0) + v17;
    let v19 = 0.5 * v9;
    let v20 = -v19;
    out[0] = x[1];
    out[1] = v13;
    out[2] = 0.0;
    out[3] = 1.0;
    out[4] = v18;
    out[5] = v20;
}

/// h(t, x, u) and Dh, row by row.
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn measurement(_t: f32, x: &[f32; 2], _u: &[f32], out: &mut [f32; 3]) {
    let v3 = x[1] * x[1];
    let v4 = 1.0 + v3;
    let v5 = libm::sqrtf(v4);
    let v6 = x[0] * v5;
    let v7 = x[1] + x[1];
    let v8 = v5 + v5;
    let v9 = v7 / v8;
    let v10 = x[0] * v9;
    out[0] = v6;
    out[1] = v5;
    out[2] = v10;
}
