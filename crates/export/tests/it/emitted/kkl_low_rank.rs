//! SampledKkl of 5 states, 0 inputs and 1 outputs, one step per sample.
//!
//!
//! SHA-256 of the numbers: c2c244d4f3648b7979e13a91d82a95e0ae3f9742b2f942f0a3390236c1de1430
pub use luenberger_observers;

use luenberger_observers::nalgebra::{SMatrix, SVector};
use luenberger_observers::{ObserverError};
use luenberger_observers::numerical_kkl::{
    Coordinates, InterpolatedInverse, Node, PolynomialInverse, PolynomialTree, SampledFilter, SampledKkl, Search, TensorTrain,
};

/// The observer, with its sizes and its scalar.
pub type Observer = SampledKkl<Model, f64, InterpolatedInverse<f64, &'static [Node<f64>], &'static [f64], 5, 6, TensorTrain<f64, &'static [f64], 5, 6>>, 5, 0, 1, 6>;

/// The first estimate of the design.
pub fn initial() -> SVector<f64, 5> {
    SVector::from([0.25, 0.25, 0.25, 0.25, 0.25])
}

/// The observer.
///
/// # Errors
/// None: the numbers were checked when they were written.
pub fn observer() -> Result<Observer, ObserverError> {
    let filter = SampledFilter {
        d: SMatrix::<f64, 6, 6>::from_row_slice(&[-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -2.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0.5]),
        b: SMatrix::<f64, 6, 1>::from_row_slice(&[1.0, 0.5, -0.25, 1.0, 1.0, 0.25]),
        period: 0.125,
        substeps: 2,
    };
    let mean = SMatrix::<f64, 6, 1>::from_row_slice(&[0.125, 0.125, 0.125, 0.125, 0.125, 0.125]);
    let whiten = SMatrix::<f64, 6, 6>::from_row_slice(&[1.0, 0.5, 0.3333333333333333, 0.25, 0.2, 0.16666666666666666, 0.5, 0.3333333333333333, 0.25, 0.2, 0.16666666666666666, 0.14285714285714285, 0.3333333333333333, 0.25, 0.2, 0.16666666666666666, 0.14285714285714285, 0.125, 0.25, 0.2, 0.16666666666666666, 0.14285714285714285, 0.125, 0.1111111111111111, 0.2, 0.16666666666666666, 0.14285714285714285, 0.125, 0.1111111111111111, 0.1, 0.16666666666666666, 0.14285714285714285, 0.125, 0.1111111111111111, 0.1, 0.09090909090909091]);
    let colour = SMatrix::<f64, 6, 6>::from_row_slice(&[1.0, 0.5, 0.3333333333333333, 0.25, 0.2, 0.16666666666666666, 0.5, 0.3333333333333333, 0.25, 0.2, 0.16666666666666666, 0.14285714285714285, 0.3333333333333333, 0.25, 0.2, 0.16666666666666666, 0.14285714285714285, 0.125, 0.25, 0.2, 0.16666666666666666, 0.14285714285714285, 0.125, 0.1111111111111111, 0.2, 0.16666666666666666, 0.14285714285714285, 0.125, 0.1111111111111111, 0.1, 0.16666666666666666, 0.14285714285714285, 0.125, 0.1111111111111111, 0.1, 0.09090909090909091]);
    let coordinates = Coordinates::new(mean, whiten, colour)?;
    let lower = SMatrix::<f64, 5, 1>::from_row_slice(&[-1.0, -1.0, -1.0, -1.0, -1.0]);
    let upper = SMatrix::<f64, 5, 1>::from_row_slice(&[1.0, 0.75, 1.0, 1.0, 0.5]);
    let inverse = PolynomialTree::new(1, INVERSE_NODES, INVERSE_LEAVES)?;
    let forward = PolynomialTree::new(1, FORWARD_NODES, FORWARD_LEAVES)?;
    let inverse = PolynomialInverse::new(coordinates, (lower, upper), inverse, forward)?;
    let spline = TensorTrain::new(lower, upper, [2, 3, 2, 2, 2], [6, 2, 3, 2, 1], TABLE)?;
    let search = Search { max_evaluations: 6, tolerance: 0.125, fallback: 2 };
    let inverse = InterpolatedInverse::new(spline, inverse, search)?;
    SampledKkl::new(Model, filter, inverse)
}

const INVERSE_NODES: &[Node<f64>] = &[
];

const INVERSE_LEAVES: &[f64] = &[
    0.25, 0.25, 0.25, 0.25, 0.25, 0.25,
    0.5, 0.5, 0.5, 0.5, 0.5, 0.5,
    -1.5, -1.5, -1.5, -1.5, -1.5, 1.25,
    1.25, 1.25, 1.25, 1.25, -0.5, -0.25,
    0.0, 0.25, 0.5, -0.5, -0.25, 0.0,
    0.25, 0.5, -0.5, -0.25, 0.0, 0.25,
    0.5, -0.5, -0.25, 0.0, 0.25, 0.5,
    -0.5, -0.25, 0.0, 0.25, 0.5, -0.5,
    -0.25, 0.0, 0.25, 0.5, -0.5, -0.25,
    0.0, 0.25, 0.5,
];

const FORWARD_NODES: &[Node<f64>] = &[
];

const FORWARD_LEAVES: &[f64] = &[
    0.0, 0.0, 0.0, 0.0, 0.0, 0.5,
    0.5, 0.5, 0.5, 0.5, -1.5, -1.5,
    -1.5, -1.5, -1.5, -1.5, 1.25, 1.25,
    1.25, 1.25, 1.25, 1.25, -0.5, -0.25,
    0.0, 0.25, 0.5, -0.5, -0.25, 0.0,
    0.25, 0.5, -0.5, -0.25, 0.0, 0.25,
    0.5, -0.5, -0.25, 0.0, 0.25, 0.5,
    -0.5, -0.25, 0.0, 0.25, 0.5, -0.5,
    -0.25, 0.0, 0.25, 0.5, -0.5, -0.25,
    0.0, 0.25, 0.5, -0.5,
];

const TABLE: &[f64] = &[
    -0.5, -0.25, 0.5, 0.0, 0.0, 0.5,
    -0.25, -0.5, -0.25, 0.5, 0.0, 0.0,
    0.5, -0.25, -0.5, -0.25, 0.5, 0.0,
    0.0, 0.5, -0.25, -0.5, -0.25, 0.5,
    0.0, 0.0, 0.5, -0.25, -0.5, -0.25,
    0.5, 0.0, 0.0, 0.5, -0.25, -0.5,
    -0.25, 0.5, 0.0, 0.0, 0.5, -0.25,
    -0.5, -0.25, 0.5, 0.0, 0.0, 0.5,
    -0.25, -0.5, -0.25, 0.5, 0.0, 0.0,
    0.5, -0.25, -0.5, -0.25, 0.5, 0.0,
    0.0, 0.5, -0.25, -0.5, -0.25, 0.5,
    0.0, 0.0, 0.5, -0.25, -0.5, -0.25,
    0.5, 0.0, 0.0, 0.5, -0.25, -0.5,
    -0.25, 0.5, 0.0, 0.0, 0.5, -0.25,
    -0.5, -0.25, 0.5, 0.0, 0.0, 0.5,
    -0.25, -0.5, -0.25, 0.5, 0.0, 0.0,
    0.5, -0.25, -0.5, -0.25, 0.5, 0.0,
    0.0, 0.5, -0.25, -0.5, -0.25, 0.5,
    0.0, 0.0, 0.5, -0.25, -0.5, -0.25,
];

/// The plant x' = f(t, x, u), y = h(t, x, u), or x+ = f(t, x, u) in discrete time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model;

luenberger_observers::straight_line_plant!(Model, f64, 5, 0, 1, f, h, motion, measurement);

/// f(t, x, u).
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn f(_t: f64, x: &[f64; 5], _u: &[f64], out: &mut [f64; 5]) {
    let v5 = libm::sin(x[0]);
    let v6 = -v5;
    let v7 = v6 - x[4];
    out[0] = x[1];
    out[1] = x[2];
    out[2] = x[3];
    out[3] = x[4];
    out[4] = v7;
}

/// h(t, x, u).
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn h(_t: f64, x: &[f64; 5], _u: &[f64], out: &mut [f64; 1]) {
    out[0] = x[0];
}

/// f(t, x, u) and Df, row by row.
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn motion(_t: f64, x: &[f64; 5], _u: &[f64], out: &mut [f64; 30]) {
    let v6 = libm::sin(x[0]);
    let v7 = -v6;
    let v8 = v7 - x[4];
    let v10 = libm::cos(x[0]);
    let v11 = -v10;
    out[0] = x[1];
    out[1] = x[2];
    out[2] = x[3];
    out[3] = x[4];
    out[4] = v8;
    out[5] = 0.0;
    out[6] = 1.0;
    out[7] = 0.0;
    out[8] = 0.0;
    out[9] = 0.0;
    out[10] = 0.0;
    out[11] = 0.0;
    out[12] = 1.0;
    out[13] = 0.0;
    out[14] = 0.0;
    out[15] = 0.0;
    out[16] = 0.0;
    out[17] = 0.0;
    out[18] = 1.0;
    out[19] = 0.0;
    out[20] = 0.0;
    out[21] = 0.0;
    out[22] = 0.0;
    out[23] = 0.0;
    out[24] = 1.0;
    out[25] = v11;
    out[26] = 0.0;
    out[27] = 0.0;
    out[28] = 0.0;
    out[29] = -1.0;
}

/// h(t, x, u) and Dh, row by row.
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn measurement(_t: f64, x: &[f64; 5], _u: &[f64], out: &mut [f64; 6]) {
    out[0] = x[0];
    out[1] = 1.0;
    out[2] = 0.0;
    out[3] = 0.0;
    out[4] = 0.0;
    out[5] = 0.0;
}
