//! SampledHeldKkl of 2 states, 1 inputs and 1 outputs, one step per sample.
//!
//!
//! SHA-256 of the numbers: 95fea57f97d2299833aea984b60c444991ea1f9375690fdbf64eb548ba7cfb7e
pub use luenberger_observers;

use luenberger_observers::nalgebra::{SMatrix, SVector};
use luenberger_observers::{ObserverError};
use luenberger_observers::numerical_kkl::{
    Coordinates, HeldInputInverse, HeldInputTables, Node, PolynomialTree, SampledFilter, SampledHeldKkl, Search, TensorSpline,
};

/// The observer, with its sizes and its scalar.
pub type Observer = SampledHeldKkl<Model, f32, HeldInputInverse<f32, &'static [Node<f32>], &'static [f32], [TensorSpline<f32, &'static [f32], 2, 3>; 2], 2, 1, 3, 4>, 2, 1, 1, 3, 5>;

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
    let splines = [
        TensorSpline::new(lower, upper, [2, 2], TABLES[0])?,
        TensorSpline::new(lower, upper, [2, 2], TABLES[1])?,
    ];
    let tables = HeldInputTables::new(coordinates, NODES, splines)?;
    let search = Some(Search { max_evaluations: 6, tolerance: 0.125, fallback: 3 });
    let inverse = HeldInputInverse::new(tables, inverse, search)?;
    SampledHeldKkl::new(Model, filter, inverse)
}

/// The input at which z starts.
pub fn first_input() -> SVector<f32, 1> {
    SMatrix::<f32, 1, 1>::from_row_slice(&[0.25])
}

const INVERSE_NODES: &[Node<f32>] = &[
];

const INVERSE_LEAVES: &[f32] = &[
    0.25, 0.25, 0.25, 0.25, 0.5, 0.5,
    0.5, 0.5, -1.5, -1.5, 1.25, 1.25,
    -0.5, -0.25, 0.0, 0.25, 0.5, -0.5,
    -0.25, 0.0, 0.25, 0.5,
];

const NODES: &[f32] = &[
    -0.0625, 0.125,
];

const TABLES: [&[f32]; 2] = [
    &[
        -0.5, -0.25, 0.5, 0.0, 0.0, 0.5,
        -0.25, -0.5, -0.25, 0.5, 0.0, 0.0,
        0.5, -0.25, -0.5, -0.25, 0.5, 0.0,
        0.0, 0.5, -0.25, -0.5, -0.25, 0.5,
        0.0, 0.0, 0.5, -0.25, -0.5, -0.25,
        0.5, 0.0, 0.0, 0.5, -0.25, -0.5,
        -0.25, 0.5, 0.0, 0.0, 0.5, -0.25,
        -0.5, -0.25, 0.5, 0.0, 0.0, 0.5,
    ],
    &[
        -0.5, -0.625, -1.0, -0.75, -0.75, -1.0,
        -0.625, -0.5, -0.625, -1.0, -0.75, -0.75,
        -1.0, -0.625, -0.5, -0.625, -1.0, -0.75,
        -0.75, -1.0, -0.625, -0.5, -0.625, -1.0,
        -0.75, -0.75, -1.0, -0.625, -0.5, -0.625,
        -1.0, -0.75, -0.75, -1.0, -0.625, -0.5,
        -0.625, -1.0, -0.75, -0.75, -1.0, -0.625,
        -0.5, -0.625, -1.0, -0.75, -0.75, -1.0,
    ],
];

/// The plant x' = f(t, x, u), y = h(t, x, u), or x+ = f(t, x, u) in discrete time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model;

luenberger_observers::straight_line_plant!(Model, f32, 2, 1, 1, f, h, motion, measurement);

/// f(t, x, u).
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn f(_t: f32, x: &[f32; 2], u: &[f32], out: &mut [f32; 2]) {
    let Some(u) = u.first_chunk::<1>() else { return };
    let v1 = x[1] * x[1];
    let v2 = x[1] * v1;
    let v4 = v2 + u[0];
    let v6 = luenberger_observers::binary32::sin(x[0]);
    let v7 = -v6;
    out[0] = v4;
    out[1] = v7;
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
    let v2 = x[1] * x[1];
    let v3 = x[1] * v2;
    let v5 = v3 + u[0];
    let v7 = luenberger_observers::binary32::sin(x[0]);
    let v8 = -v7;
    let v9 = luenberger_observers::binary32::cos(x[0]);
    let v10 = -v9;
    let v11 = x[1] + x[1];
    let v12 = x[1] * v11;
    let v13 = v2 + v12;
    out[0] = v5;
    out[1] = v8;
    out[2] = 0.0;
    out[3] = v13;
    out[4] = v10;
    out[5] = 0.0;
}

/// h(t, x, u) and Dh, row by row.
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn measurement(_t: f32, x: &[f32; 2], _u: &[f32], out: &mut [f32; 3]) {
    out[0] = x[0];
    out[1] = 1.0;
    out[2] = 0.0;
}
