//! DiscreteNonlinearObserver of 2 states, 1 inputs and 1 outputs, one step per sample.
//!
//!
//! SHA-256 of the numbers: 3b86ede1ba58388fb7726a3b771d59a228a7fb4d8b0e9b0b3abf89ae3b32b161
pub use luenberger_observers;

use luenberger_observers::nalgebra::{Const, SMatrix, SVector};
use luenberger_observers::{DiscreteNonlinearObserver, ObserverError};
use luenberger_observers::{Differentiable, Dimensions, Plant, Shape};

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

impl Shape for Model {
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: 2, inputs: 1, outputs: 1 }
    }
}

impl Plant<f32> for Model {
    type State = SVector<f32, 2>;
    type Input = SVector<f32, 1>;
    type Output = SVector<f32, 1>;

    fn derivative(&self, t: f32, x: &Self::State, u: &Self::Input) -> Self::State {
        let mut out = [0.0; 2];
        f(t, &x.data.0[0], u.as_slice(), &mut out);
        SVector::from(out)
    }

    fn output(&self, t: f32, x: &Self::State, u: &Self::Input) -> Self::Output {
        let mut out = [0.0; 1];
        h(t, &x.data.0[0], u.as_slice(), &mut out);
        SVector::from(out)
    }
}

impl Differentiable<f32, Const<2>, Const<1>, Const<1>> for Model {
    fn directional(
        &self,
        t: f32,
        x: &SVector<f32, 2>,
        u: &SVector<f32, 1>,
        v: &SVector<f32, 2>,
    ) -> (SVector<f32, 2>, SVector<f32, 2>) {
        (self.derivative(t, x, u), self.state_jacobian(t, x, u) * v)
    }

    fn output_directional(
        &self,
        t: f32,
        x: &SVector<f32, 2>,
        u: &SVector<f32, 1>,
        v: &SVector<f32, 2>,
    ) -> (SVector<f32, 1>, SVector<f32, 1>) {
        (self.output(t, x, u), self.output_jacobian(t, x, u) * v)
    }

    fn state_jacobian(&self, t: f32, x: &Self::State, u: &Self::Input) -> SMatrix<f32, 2, 2> {
        let mut out = [0.0; 6];
        motion(t, &x.data.0[0], u.as_slice(), &mut out);
        SMatrix::from_fn(|i, j| out[2 + i * 2 + j])
    }

    fn output_jacobian(&self, t: f32, x: &Self::State, u: &Self::Input) -> SMatrix<f32, 1, 2> {
        let mut out = [0.0; 3];
        measurement(t, &x.data.0[0], u.as_slice(), &mut out);
        SMatrix::from_fn(|i, j| out[1 + i * 2 + j])
    }
}

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
