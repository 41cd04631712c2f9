//! DiscreteNonlinearObserver of 2 states, 1 inputs and 1 outputs, one step per sample.
//!
//!
//! SHA-256 of the numbers: 3b86ede1ba58388fb7726a3b771d59a228a7fb4d8b0e9b0b3abf89ae3b32b161
pub use luenberger_observers;

use luenberger_observers::nalgebra::{Const, SMatrix, SVector};
use luenberger_observers::{DiscreteNonlinearObserver, ObserverError};

/// The observer, with its sizes and its scalar.
pub type Observer = DiscreteNonlinearObserver<Model, f32, Const<2>, Const<1>, Const<1>>;

/// The first estimate of the design.
pub fn initial() -> SVector<f32, 2> {
    SVector::from([0.25, 0.25])
}

/// The observer.
///
/// # Errors
/// None: the numbers were checked when they were written.
pub fn observer() -> Result<Observer, ObserverError> {
    DiscreteNonlinearObserver::new(Model, SMatrix::<f32, 2, 1>::from_row_slice(&[0.5, 0.25]), 0.5)
}

/// The plant x' = f(t, x, u), y = h(t, x, u), or x+ = f(t, x, u) in discrete time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model;

luenberger_observers::straight_line_plant!(Model, f32, 2, 1, 1, f, h, motion, measurement);

/// f(t, x, u).
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn f(_t: f32, x: &[f32; 2], u: &[f32], out: &mut [f32; 2]) {
    let Some(u) = u.first_chunk::<1>() else { return };
    let v2 = 0.5 * x[0];
    let v5 = libm::tanhf(x[1]);
    let v6 = 0.25 * v5;
    let v7 = v2 + v6;
    let v9 = x[0] < u[0];
    let v10 = 0.5 * x[1];
    let v11 = x[0] * 0.25;
    let v12 = if v9 { v10 } else { v11 };
    out[0] = v7;
    out[1] = v12;
}

/// h(t, x, u).
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn h(_t: f32, x: &[f32; 2], _u: &[f32], out: &mut [f32; 1]) {
    out[0] = x[0];
}

/// f(t, x, u) and Df, row by row.
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn motion(_t: f32, x: &[f32; 2], u: &[f32], out: &mut [f32; 6]) {
    let Some(u) = u.first_chunk::<1>() else { return };
    let v3 = 0.5 * x[0];
    let v6 = libm::tanhf(x[1]);
    let v7 = 0.25 * v6;
    let v8 = v3 + v7;
    let v10 = x[0] < u[0];
    let v11 = 0.5 * x[1];
    let v12 = x[0] * 0.25;
    let v13 = if v10 { v11 } else { v12 };
    let v15 = if v10 { 0.0 } else { 0.25 };
    let v16 = 1.0 - v6;
    let v17 = v6 + 1.0;
    let v18 = v16 * v17;
    let v19 = 0.25 * v18;
    let v20 = if v10 { 0.5 } else { 0.0 };
    out[0] = v8;
    out[1] = v13;
    out[2] = 0.5;
    out[3] = v19;
    out[4] = v15;
    out[5] = v20;
}

/// h(t, x, u) and Dh, row by row.
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn measurement(_t: f32, x: &[f32; 2], _u: &[f32], out: &mut [f32; 3]) {
    out[0] = x[0];
    out[1] = 1.0;
    out[2] = 0.0;
}
