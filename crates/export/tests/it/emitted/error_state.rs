//! ExtendedKalmanFilter of 3 states, 1 inputs and 1 outputs, one step per sample.
//!
//!
//! SHA-256 of the numbers: f3089d315772e4572b3841465bf66ea3ca2cb5787380a2ed38f6aaa660913459
pub use luenberger_observers;

use luenberger_observers::nalgebra::{SMatrix, SVector};
use luenberger_observers::{ExtendedKalmanFilter, NoiseModel, StaticExtendedKalmanFilter, ObserverError};

/// The observer, with its sizes and its scalar.
pub type Observer = StaticExtendedKalmanFilter<Model, f32, 3, 1, 1>;

/// The first estimate of the design.
pub fn initial() -> SVector<f32, 3> {
    SVector::from([0.25, 0.25, 0.25])
}

/// The observer.
///
/// # Errors
/// None: the numbers were checked when they were written.
pub fn observer() -> Result<Observer, ObserverError> {
    let w = SMatrix::<f32, 3, 3>::from_row_slice(&[0.5, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.25]);
    let v = SMatrix::<f32, 1, 1>::from_row_slice(&[0.125]);
    let p0 = SMatrix::<f32, 3, 3>::from_row_slice(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0]);
    let noises = NoiseModel { w, v, p0 };
    ExtendedKalmanFilter::new(Model, noises, 0.0625, 2)?
        .with_unit_vectors(SVector::from([1.0, 1.0, 0.0]))
}

/// The plant x' = f(t, x, u), y = h(t, x, u), or x+ = f(t, x, u) in discrete time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model;

luenberger_observers::straight_line_plant!(Model, f32, 3, 1, 1, f, h, motion, measurement);

/// f(t, x, u).
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn f(_t: f32, x: &[f32; 3], u: &[f32], out: &mut [f32; 3]) {
    let Some(u) = u.first_chunk::<1>() else { return };
    let v3 = x[1] * u[0];
    let v4 = -v3;
    let v6 = u[0] * x[0];
    out[0] = v4;
    out[1] = v6;
    out[2] = 0.0;
}

/// h(t, x, u).
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn h(_t: f32, x: &[f32; 3], _u: &[f32], out: &mut [f32; 1]) {
    let v2 = x[1] + x[2];
    out[0] = v2;
}

/// f(t, x, u) and Df, row by row.
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn motion(_t: f32, x: &[f32; 3], u: &[f32], out: &mut [f32; 12]) {
    let Some(u) = u.first_chunk::<1>() else { return };
    let v3 = x[1] * u[0];
    let v4 = -v3;
    let v6 = u[0] * x[0];
    let v7 = -u[0];
    out[0] = v4;
    out[1] = v6;
    out[2] = 0.0;
    out[3] = 0.0;
    out[4] = v7;
    out[5] = 0.0;
    out[6] = u[0];
    out[7] = 0.0;
    out[8] = 0.0;
    out[9] = 0.0;
    out[10] = 0.0;
    out[11] = 0.0;
}

/// h(t, x, u) and Dh, row by row.
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn measurement(_t: f32, x: &[f32; 3], _u: &[f32], out: &mut [f32; 4]) {
    let v3 = x[1] + x[2];
    out[0] = v3;
    out[1] = 0.0;
    out[2] = 1.0;
    out[3] = 1.0;
}
