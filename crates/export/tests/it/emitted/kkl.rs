//! SampledKkl of 2 states, 0 inputs and 1 outputs, one step per sample.
//!
//!
//! SHA-256 of the numbers: e99af5ba98847f19c8e684ba6c863969e22321cf1c0a9976f6b788362a13025f
pub use luenberger_observers;

use luenberger_observers::nalgebra::{SMatrix, SVector};
use luenberger_observers::{ObserverError};
use luenberger_observers::numerical_kkl::{
    Branch, Coordinates, Node, PolynomialInverse, PolynomialTree, SampledFilter, SampledKkl,
};

/// The observer, with its sizes and its scalar.
pub type Observer = SampledKkl<Model, f32, PolynomialInverse<f32, &'static [Node<f32>], &'static [f32], 2, 3>, 2, 0, 1, 3>;

/// The first estimate of the design.
pub fn initial() -> SVector<f32, 2> {
    SVector::from([0.25, 0.25])
}

/// The observer.
///
/// # Errors
/// None: the numbers were checked when they were written.
pub fn observer() -> Result<Observer, ObserverError> {
    let filter = SampledFilter {
        d: SMatrix::<f32, 3, 3>::from_row_slice(&[-1.0, 0.0, 0.0, 0.0, -2.0, 0.0, 0.0, 0.0, -3.0]),
        b: SMatrix::<f32, 3, 1>::from_row_slice(&[1.0, 0.5, -0.25]),
        period: 0.125,
        substeps: 2,
    };
    let mean = SMatrix::<f32, 3, 1>::from_row_slice(&[0.125, 0.25, 0.0]);
    let whiten = SMatrix::<f32, 3, 3>::from_row_slice(&[1.0, 0.5, 0.33333334, 0.5, 0.33333334, 0.25, 0.33333334, 0.25, 0.2]);
    let colour = SMatrix::<f32, 3, 3>::from_row_slice(&[1.0, 0.5, 0.33333334, 0.5, 0.33333334, 0.25, 0.33333334, 0.25, 0.2]);
    let coordinates = Coordinates::new(mean, whiten, colour)?;
    let lower = SMatrix::<f32, 2, 1>::from_row_slice(&[-1.0, -1.0]);
    let upper = SMatrix::<f32, 2, 1>::from_row_slice(&[1.0, 0.75]);
    let inverse = PolynomialTree::new(1, INVERSE_NODES, INVERSE_LEAVES)?;
    let forward = PolynomialTree::new(1, FORWARD_NODES, FORWARD_LEAVES)?;
    let inverse = PolynomialInverse::new(coordinates, (lower, upper), inverse, forward)?;
    SampledKkl::new(Model, filter, inverse)
}

const INVERSE_NODES: &[Node<f32>] = &[
    Node { axis: 1, threshold: 0.125, below: Branch::Leaf(1), above: Branch::Leaf(0) },
];

const INVERSE_LEAVES: &[f32] = &[
    0.25, 0.25, 0.25, 0.5, 0.5, 0.5,
    -1.5, -1.5, 1.25, 1.25, -0.5, -0.25,
    0.0, 0.25, 0.5, -0.5, -0.25, 0.0,
    -0.25, -0.25, -0.25, 0.5, 0.5, 0.5,
    -1.5, -1.5, 1.25, 1.25, -0.5, -0.25,
    0.0, 0.25, 0.5, -0.5, -0.25, 0.0,
];

const FORWARD_NODES: &[Node<f32>] = &[
];

const FORWARD_LEAVES: &[f32] = &[
    0.0, 0.0, 0.5, 0.5, -1.5, -1.5,
    -1.5, 1.25, 1.25, 1.25, -0.5, -0.25,
    0.0, 0.25, 0.5, -0.5, -0.25, 0.0,
    0.25,
];

/// The plant x' = f(t, x, u), y = h(t, x, u), or x+ = f(t, x, u) in discrete time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model;

luenberger_observers::straight_line_plant!(Model, f32, 2, 0, 1, f, h, motion, measurement);

/// f(t, x, u).
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn f(_t: f32, x: &[f32; 2], _u: &[f32], out: &mut [f32; 2]) {
    let v1 = x[1] * x[1];
    let v2 = x[1] * v1;
    let v4 = luenberger_observers::binary32::sin(x[0]);
    let v5 = -v4;
    out[0] = v2;
    out[1] = v5;
}

/// h(t, x, u).
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn h(_t: f32, x: &[f32; 2], _u: &[f32], out: &mut [f32; 1]) {
    out[0] = x[0];
}

/// f(t, x, u) and Df, row by row.
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn motion(_t: f32, x: &[f32; 2], _u: &[f32], out: &mut [f32; 6]) {
    let v2 = x[1] * x[1];
    let v3 = x[1] * v2;
    let v5 = luenberger_observers::binary32::sin(x[0]);
    let v6 = -v5;
    let v7 = luenberger_observers::binary32::cos(x[0]);
    let v8 = -v7;
    let v9 = x[1] + x[1];
    let v10 = x[1] * v9;
    let v11 = v2 + v10;
    out[0] = v3;
    out[1] = v6;
    out[2] = 0.0;
    out[3] = v11;
    out[4] = v8;
    out[5] = 0.0;
}

/// h(t, x, u) and Dh, row by row.
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn measurement(_t: f32, x: &[f32; 2], _u: &[f32], out: &mut [f32; 3]) {
    out[0] = x[0];
    out[1] = 1.0;
    out[2] = 0.0;
}
