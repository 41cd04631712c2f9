//! InterSampleObserver of 2 states, 1 inputs and 1 outputs, one step per sample.
//!
//!
//! SHA-256 of the numbers: 8f60598981dbc255ab654af835cb266e9e6d22b7a4b3533380479ece2f96b997
pub use luenberger_observers;

use luenberger_observers::nalgebra::{Const, SVector};
use luenberger_observers::{ObserverDimensions, InterSampleObserver, ObserverError};

/// The observer, with its sizes and its scalar.
pub type Observer = InterSampleObserver<Model, Extension, f32, Const<1>, Const<2>, Const<1>, Const<1>, Const<3>>;

/// The first estimate of the design.
pub fn initial() -> SVector<f32, 2> {
    SVector::from([0.25, 0.25])
}

/// The observer.
///
/// # Errors
/// None: the numbers were checked when they were written.
pub fn observer() -> Result<Observer, ObserverError> {
    InterSampleObserver::new(Model, Extension, 0.125, 2)
}

/// The observer z' = g(t, z, u, y), xhat = k(t, z, y).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extension;

/// (u, y).
fn known(u: &SVector<f32, 1>, y: &SVector<f32, 1>) -> [f32; 2] {
    let mut all = [0.0; 2];
    all.iter_mut().zip(u.iter().chain(y.iter())).for_each(|(entry, x)| *entry = *x);
    all
}

impl luenberger_observers::Observer<f32> for Extension {
    type State = SVector<f32, 1>;
    type Input = SVector<f32, 1>;
    type Output = SVector<f32, 1>;
    type Estimate = SVector<f32, 2>;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: 1, inputs: 1, outputs: 1, estimate: 2 }
    }

    fn derivative(&self, t: f32, z: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        let mut out = [0.0; 1];
        rate(t, &z.data.0[0], &known(u, y), &mut out);
        SVector::from(out)
    }

    fn estimate(&self, t: f32, z: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Estimate {
        let mut out = [0.0; 2];
        estimate(t, &z.data.0[0], &known(u, y), &mut out);
        SVector::from(out)
    }

    fn jump(&self, t: f32, z: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        let mut out = [0.0; 1];
        after(t, &z.data.0[0], &known(u, y), &mut out);
        SVector::from(out)
    }

    fn initial(&self, t: f32, xhat: &Self::Estimate, _u: &Self::Input, y: &Self::Output) -> Self::State {
        let mut out = [0.0; 1];
        start(t, &xhat.data.0[0], y.as_slice(), &mut out);
        SVector::from(out)
    }
}

/// g(t, z, u, y).
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn rate(t: f32, x: &[f32; 1], u: &[f32], out: &mut [f32; 1]) {
    let Some(u) = u.first_chunk::<2>() else { return };
    let v6 = x[0] * (-2.0);
    let v8 = u[1] * 5.0;
    let v9 = v6 - v8;
    let v11 = u[1] * u[1];
    let v12 = u[1] * v11;
    let v13 = v12 / 3.0;
    let v14 = u[1] - v13;
    let v15 = 2.0 * v14;
    let v16 = v9 - v15;
    let v17 = luenberger_observers::binary32::cos(t);
    let v18 = u[0] * v17;
    let v19 = v16 + v18;
    out[0] = v19;
}

/// k(t, z, y).
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn estimate(_t: f32, x: &[f32; 1], u: &[f32], out: &mut [f32; 2]) {
    let Some(u) = u.first_chunk::<2>() else { return };
    let v3 = u[1] * u[1];
    let v4 = u[1] * v3;
    let v5 = v4 / 3.0;
    let v6 = u[1] * 3.0;
    let v7 = x[0] + v6;
    let v8 = v7 - v5;
    out[0] = u[1];
    out[1] = v8;
}

/// z for an estimate and the output that it predicts.
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn start(_t: f32, x: &[f32; 2], u: &[f32], out: &mut [f32; 1]) {
    let Some(u) = u.first_chunk::<1>() else { return };
    let v4 = u[0] * u[0];
    let v5 = u[0] * v4;
    let v6 = v5 / 3.0;
    let v7 = u[0] - v6;
    let v8 = x[1] - v7;
    let v9 = u[0] * 2.0;
    let v10 = v8 - v9;
    out[0] = v10;
}

/// The state after the jump at a sample.
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn after(_t: f32, x: &[f32; 1], u: &[f32], out: &mut [f32; 1]) {
    let Some(u) = u.first_chunk::<2>() else { return };
    let v3 = x[0] > 0.75;
    let v5 = x[0] * 0.5;
    let v7 = u[1] * 0.125;
    let v8 = v5 + v7;
    let v9 = if v3 { v8 } else { x[0] };
    out[0] = v9;
}

/// The plant x' = f(t, x, u), y = h(t, x, u), or x+ = f(t, x, u) in discrete time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model;

luenberger_observers::straight_line_plant!(Model, f32, 2, 1, 1, f, h, motion, measurement);

/// f(t, x, u).
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn f(t: f32, x: &[f32; 2], u: &[f32], out: &mut [f32; 2]) {
    let Some(u) = u.first_chunk::<1>() else { return };
    let v3 = table0(x[0]);
    let v4 = 0.0 * v3;
    let v5 = x[1] + v4;
    let v7 = x[0] * x[0];
    let v8 = 1.0 - v7;
    let v9 = x[1] * v8;
    let v10 = v9 - x[0];
    let v13 = luenberger_observers::binary32::cos(t);
    let v14 = u[0] * v13;
    let v15 = v10 + v14;
    out[0] = v5;
    out[1] = v15;
}

/// h(t, x, u).
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn h(_t: f32, x: &[f32; 2], _u: &[f32], out: &mut [f32; 1]) {
    out[0] = x[0];
}

/// f(t, x, u) and Df, row by row.
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn motion(t: f32, x: &[f32; 2], u: &[f32], out: &mut [f32; 6]) {
    let Some(u) = u.first_chunk::<1>() else { return };
    let v3 = table0(x[0]);
    let v4 = 0.0 * v3;
    let v5 = x[1] + v4;
    let v7 = x[0] * x[0];
    let v8 = 1.0 - v7;
    let v9 = x[1] * v8;
    let v10 = v9 - x[0];
    let v13 = luenberger_observers::binary32::cos(t);
    let v14 = u[0] * v13;
    let v15 = v10 + v14;
    let v16 = slope0(x[0]);
    let v17 = 0.0 * v16;
    let v18 = x[0] + x[0];
    let v19 = x[1] * v18;
    let v21 = (-1.0) - v19;
    out[0] = v5;
    out[1] = v15;
    out[2] = v17;
    out[3] = 1.0;
    out[4] = v21;
    out[5] = v8;
}

/// h(t, x, u) and Dh, row by row.
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn measurement(_t: f32, x: &[f32; 2], _u: &[f32], out: &mut [f32; 3]) {
    out[0] = x[0];
    out[1] = 1.0;
    out[2] = 0.0;
}

const TABLE_X0: [f32; 3] = [-1.0, 0.0, 2.0];
const TABLE_Y0: [f32; 3] = [0.5, 0.0, 1.5];
const TABLE_M0: [f32; 3] = [-0.9166667, 0.0, 1.5833334];

fn piece0(x: f32) -> usize {
    let (mut k, mut end) = (0, 2);
    while end - k > 1 {
        let middle = k + (end - k) / 2;
        if x < TABLE_X0[middle] { end = middle } else { k = middle }
    }
    k
}

fn table0(x: f32) -> f32 {
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

fn slope0(x: f32) -> f32 {
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
