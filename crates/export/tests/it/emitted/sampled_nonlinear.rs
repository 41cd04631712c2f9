//! SampledNonlinearObserver of 2 states, 1 inputs and 1 outputs, one step per sample.
//!
//!
//! SHA-256 of the numbers: ac98d0313b92f90011115a00e4fea1d0b8fc118a54886e0b280a0e9ae8a59bb1
pub use luenberger_observers;

use luenberger_observers::nalgebra::{SMatrix, SVector};
use luenberger_observers::{SampledNonlinearObserver, StaticSampledNonlinearObserver, ObserverError};

/// The observer, with its sizes and its scalar.
pub type Observer = StaticSampledNonlinearObserver<Model, f64, 2, 1, 1>;

/// The first estimate of the design.
pub fn initial() -> SVector<f64, 2> {
    SVector::from([0.25, 0.25])
}

/// The observer.
///
/// # Errors
/// None: the numbers were checked when they were written.
pub fn observer() -> Result<Observer, ObserverError> {
    SampledNonlinearObserver::new(Model, SMatrix::<f64, 2, 1>::from_row_slice(&[2.0, 1.0]), 0.125, 2)
}

/// The plant x' = f(t, x, u), y = h(t, x, u), or x+ = f(t, x, u) in discrete time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model;

luenberger_observers::straight_line_plant!(Model, f64, 2, 1, 1, f, h, motion, measurement);

/// f(t, x, u).
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn f(t: f64, x: &[f64; 2], u: &[f64], out: &mut [f64; 2]) {
    let Some(u) = u.first_chunk::<1>() else { return };
    let v2 = table0(x[0]);
    let v3 = x[1] - v2;
    let v4 = libm::sin(x[0]);
    let v5 = -v4;
    let v6 = v5 - x[1];
    let v9 = libm::cos(t);
    let v10 = u[0] * v9;
    let v11 = v6 + v10;
    out[0] = v3;
    out[1] = v11;
}

/// h(t, x, u).
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn h(_t: f64, x: &[f64; 2], _u: &[f64], out: &mut [f64; 1]) {
    let v3 = x[1] * x[1];
    let v4 = x[1] * v3;
    let v5 = 0.1 * v4;
    let v6 = x[0] + v5;
    out[0] = v6;
}

/// f(t, x, u) and Df, row by row.
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn motion(t: f64, x: &[f64; 2], u: &[f64], out: &mut [f64; 6]) {
    let Some(u) = u.first_chunk::<1>() else { return };
    let v2 = table0(x[0]);
    let v3 = x[1] - v2;
    let v4 = libm::sin(x[0]);
    let v5 = -v4;
    let v6 = v5 - x[1];
    let v9 = libm::cos(t);
    let v10 = u[0] * v9;
    let v11 = v6 + v10;
    let v13 = slope0(x[0]);
    let v14 = -v13;
    let v15 = libm::cos(x[0]);
    let v16 = -v15;
    out[0] = v3;
    out[1] = v11;
    out[2] = v14;
    out[3] = 1.0;
    out[4] = v16;
    out[5] = -1.0;
}

/// h(t, x, u) and Dh, row by row.
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn measurement(_t: f64, x: &[f64; 2], _u: &[f64], out: &mut [f64; 3]) {
    let v4 = x[1] * x[1];
    let v5 = x[1] * v4;
    let v6 = 0.1 * v5;
    let v7 = x[0] + v6;
    let v8 = x[1] + x[1];
    let v9 = x[1] * v8;
    let v10 = v4 + v9;
    let v11 = 0.1 * v10;
    out[0] = v7;
    out[1] = 1.0;
    out[2] = v11;
}

const TABLE_X0: [f64; 3] = [-1.0, 0.0, 2.0];
const TABLE_Y0: [f64; 3] = [0.5, 0.0, 1.5];
const TABLE_M0: [f64; 3] = [-0.9166666666666666, 0.0, 1.5833333333333333];

fn piece0(x: f64) -> usize {
    let (mut k, mut end) = (0, 2);
    while end - k > 1 {
        let middle = k + (end - k) / 2;
        if x < TABLE_X0[middle] { end = middle } else { k = middle }
    }
    k
}

fn table0(x: f64) -> f64 {
    if x < TABLE_X0[0] {
        return TABLE_Y0[0] + ((TABLE_M0[0]) * (x - TABLE_X0[0]));
    }
    if x > TABLE_X0[2] {
        return TABLE_Y0[2] + ((TABLE_M0[2]) * (x - TABLE_X0[2]));
    }
    let k = piece0(x);
    let width = TABLE_X0[k + 1] - TABLE_X0[k];
    let share = (x - TABLE_X0[k]) / width;
    let rest = 1.0 - share;
    let three = 3.0;
    let first = TABLE_M0[k] * width;
    let second = TABLE_M0[k + 1] * width;
    (TABLE_Y0[k] * rest * rest * rest) + (((TABLE_Y0[k] * three) + first) * rest * rest * share) + (((TABLE_Y0[k + 1] * three) - second) * rest * share * share) + (TABLE_Y0[k + 1] * share * share * share)
}

fn slope0(x: f64) -> f64 {
    if x < TABLE_X0[0] {
        return TABLE_M0[0];
    }
    if x > TABLE_X0[2] {
        return TABLE_M0[2];
    }
    let k = piece0(x);
    let width = TABLE_X0[k + 1] - TABLE_X0[k];
    let share = (x - TABLE_X0[k]) / width;
    let rest = 1.0 - share;
    let middle = (6.0 * ((TABLE_Y0[k + 1] - TABLE_Y0[k]) / width)) - (TABLE_M0[k] + TABLE_M0[k]) - (TABLE_M0[k + 1] + TABLE_M0[k + 1]);
    (TABLE_M0[k] * rest * rest) + (middle * rest * share) + (TABLE_M0[k + 1] * share * share)
}
