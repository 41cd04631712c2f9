//! MovingHorizonEstimator of 2 states, 1 inputs and 1 outputs, one step per sample.
//!
//!
//! SHA-256 of the numbers: 9e352c7bccf67eb6fc431fde27770026b01c3f180b8b4fdd6d1327e5e8efb731
pub use luenberger_observers;

use luenberger_observers::nalgebra::{Const, SMatrix, SVector};
use luenberger_observers::{Horizon, NoiseModel, MovingHorizonEstimator, ObserverError};

/// The observer, with its sizes and its scalar.
pub type Observer = MovingHorizonEstimator<Model, f32, Const<2>, Const<1>, Const<1>, Const<34>, 3>;

/// The first estimate of the design.
pub fn initial() -> SVector<f32, 2> {
    SVector::from([0.25, 0.25])
}

/// The observer.
///
/// # Errors
/// None: the numbers were checked when they were written.
pub fn observer() -> Result<Observer, ObserverError> {
    let w = SMatrix::<f32, 2, 2>::from_row_slice(&[0.5, 0.1, 0.1, 0.25]);
    let v = SMatrix::<f32, 1, 1>::from_row_slice(&[0.125]);
    let p0 = SMatrix::<f32, 2, 2>::from_row_slice(&[1.0, 0.0, 0.0, 2.0]);
    let noises = NoiseModel { w, v, p0 };
    let horizon = Horizon { window: 3, iterations: 2 };
    MovingHorizonEstimator::new(Model, noises, horizon, 0.0625, 2)?
        .with_bounds(SVector::from([-0.125, f32::NEG_INFINITY]), SVector::from([0.125, 0.25]))
}

/// The plant x' = f(t, x, u), y = h(t, x, u), or x+ = f(t, x, u) in discrete time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model;

luenberger_observers::straight_line_plant!(Model, f32, 2, 1, 1, f, h, motion, measurement);

/// f(t, x, u).
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn f(t: f32, x: &[f32; 2], u: &[f32], out: &mut [f32; 2]) {
    let Some(u) = u.first_chunk::<1>() else { return };
    let v2 = -x[0];
    let v4 = x[1] * 0.5;
    let v5 = x[0] * x[0];
    let v6 = -v5;
    let v7 = libm::expf(v6);
    let v8 = v4 * v7;
    let v9 = v2 - v8;
    let v12 = luenberger_observers::binary32::cos(t);
    let v13 = u[0] * v12;
    let v14 = v9 + v13;
    out[0] = x[1];
    out[1] = v14;
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
fn motion(t: f32, x: &[f32; 2], u: &[f32], out: &mut [f32; 6]) {
    let Some(u) = u.first_chunk::<1>() else { return };
    let v3 = -x[0];
    let v5 = x[1] * 0.5;
    let v7 = x[0] * x[0];
    let v8 = -v7;
    let v9 = libm::expf(v8);
    let v10 = v5 * v9;
    let v11 = v3 - v10;
    let v14 = luenberger_observers::binary32::cos(t);
    let v15 = u[0] * v14;
    let v16 = v11 + v15;
    let v18 = x[0] + x[0];
    let v19 = v9 * v18;
    let v20 = v5 * v19;
    let v21 = (-1.0) + v20;
    let v22 = 0.5 * v9;
    let v23 = -v22;
    out[0] = x[1];
    out[1] = v16;
    out[2] = 0.0;
    out[3] = 1.0;
    out[4] = v21;
    out[5] = v23;
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
