//! ExtendedKalmanFilter of 1 states, 0 inputs and 1 outputs, one step per sample.
//!
//!
//! SHA-256 of the numbers: 83076d16344b5627346b1623f992fa87f6e04af2361396d97c3f096f83f196b1
pub use luenberger_observers;

use luenberger_observers::nalgebra::{SMatrix, SVector};
use luenberger_observers::{ExtendedKalmanFilter, NoiseModel, StaticExtendedKalmanFilter, ObserverError};

/// The observer, with its sizes and its scalar.
pub type Observer = StaticExtendedKalmanFilter<Model, f64, 1, 0, 1>;

/// The first estimate of the design.
pub fn initial() -> SVector<f64, 1> {
    SVector::from([0.25])
}

/// The observer.
///
/// # Errors
/// None: the numbers were checked when they were written.
pub fn observer() -> Result<Observer, ObserverError> {
    let w = SMatrix::<f64, 1, 1>::from_row_slice(&[0.25]);
    let v = SMatrix::<f64, 1, 1>::from_row_slice(&[0.125]);
    let p0 = SMatrix::<f64, 1, 1>::from_row_slice(&[1.0]);
    let noises = NoiseModel { w, v, p0 };
    ExtendedKalmanFilter::discrete(Model, noises, 0.5)?.with_iterations(3)?.with_gate(4.0)?
        .with_angles(SVector::from([0.75]))
}

/// The plant x' = f(t, x, u), y = h(t, x, u), or x+ = f(t, x, u) in discrete time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model;

luenberger_observers::straight_line_plant!(Model, f64, 1, 0, 1, f, h, motion, measurement);

/// f(t, x, u).
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn f(_t: f64, x: &[f64; 1], _u: &[f64], out: &mut [f64; 1]) {
    let v2 = 0.5 * x[0];
    out[0] = v2;
}

/// h(t, x, u).
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn h(_t: f64, x: &[f64; 1], _u: &[f64], out: &mut [f64; 1]) {
    let v1 = x[0] * x[0];
    out[0] = v1;
}

/// f(t, x, u) and Df, row by row.
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn motion(_t: f64, x: &[f64; 1], _u: &[f64], out: &mut [f64; 2]) {
    let v2 = 0.5 * x[0];
    out[0] = v2;
    out[1] = 0.5;
}

/// h(t, x, u) and Dh, row by row.
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn measurement(_t: f64, x: &[f64; 1], _u: &[f64], out: &mut [f64; 2]) {
    let v1 = x[0] * x[0];
    let v2 = x[0] + x[0];
    out[0] = v1;
    out[1] = v2;
}
