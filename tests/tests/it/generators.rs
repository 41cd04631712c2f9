//! Generators for the hypotheses of the theorems: plants that are observable by construction, admissible gains, columns
//! of a given size.

use std::ops::RangeInclusive;

use luenberger_design::{LinearDesign, LyapunovWeight};
use luenberger_plants::StateSpace;
use nalgebra::{DMatrix, Vector2, Vector4};
use proptest::prelude::*;

/// Entries between -1 and 1.
pub(crate) fn matrix(rows: usize, columns: usize) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec(-1.0..1.0, rows * columns).prop_map(move |v| DMatrix::from_vec(rows, columns, v))
}

/// Entries between -size and size.
pub(crate) fn vector2(size: f64) -> impl Strategy<Value = Vector2<f64>> {
    prop::array::uniform2(-size..size).prop_map(Vector2::from)
}

/// Entries between -size and size.
pub(crate) fn vector4(size: f64) -> impl Strategy<Value = Vector4<f64>> {
    prop::array::uniform4(-size..size).prop_map(Vector4::from)
}

/// An observable pair (A, C) by construction: in these coordinates each output is followed by a chain of integrators,
/// plus injection and an orthogonal change of coordinates that observability does not notice. At least so many states
/// are `unmeasured`.
fn observable_pair(
    orders: RangeInclusive<usize>,
    unmeasured: usize,
) -> impl Strategy<Value = (DMatrix<f64>, DMatrix<f64>)> {
    orders.prop_flat_map(move |n| (Just(n), 1..=n - unmeasured)).prop_flat_map(|(n, p)| {
        (matrix(n, p), matrix(n, n)).prop_map(move |(injection, turn)| {
            // x_1 .. x_p are measured, and x_k' = x_(k+p): every state is some derivative of some output.
            let chain = DMatrix::from_fn(n, n, |i, j| if j == i + p { 1.0 } else { 0.0 });
            let c = DMatrix::from_fn(p, n, |i, j| if i == j { 1.0 } else { 0.0 });
            let a = chain + injection * &c;
            let q = (turn + DMatrix::identity(n, n) * 2.0).qr().q();
            (&q * a * q.transpose(), c * q.transpose())
        })
    })
}

/// An observable plant with one input.
pub(crate) fn observable_plant(orders: RangeInclusive<usize>) -> impl Strategy<Value = StateSpace> {
    with_one_input(observable_pair(orders, 0))
}

/// The same with fewer outputs than states; orders of at least 2.
pub(crate) fn partly_measured_plant(orders: RangeInclusive<usize>) -> impl Strategy<Value = StateSpace> {
    with_one_input(observable_pair(orders, 1))
}

fn with_one_input(pairs: impl Strategy<Value = (DMatrix<f64>, DMatrix<f64>)>) -> impl Strategy<Value = StateSpace> {
    pairs.prop_flat_map(|(a, c)| {
        let n = a.nrows();
        (Just((a, c)), matrix(n, 1)).prop_map(|((a, c), b)| StateSpace::new(a, b, c).unwrap())
    })
}

/// An observable plant with an input for every state, so that it is stabilisable by construction.
pub(crate) fn stabilisable_plant(orders: RangeInclusive<usize>) -> impl Strategy<Value = StateSpace> {
    observable_pair(orders, 0).prop_flat_map(|(a, c)| {
        let n = a.nrows();
        (Just((a, c)), matrix(n, n))
            .prop_map(move |((a, c), b)| StateSpace::new(a, b + DMatrix::identity(n, n) * 3.0, c).unwrap())
    })
}

/// `D D' + K - K' + I/10` of the leading p rows and columns: accretive.
pub(crate) fn accretive(p: usize, d: &DMatrix<f64>, k: &DMatrix<f64>) -> DMatrix<f64> {
    let (d, k) = (d.view((0, 0), (p, p)), k.view((0, 0), (p, p)));
    d * d.transpose() + k - k.transpose() + DMatrix::identity(p, p) * 0.1
}

/// A Luenberger observer with real poles from -1 on, certified with `Q = rho I`.
pub(crate) fn linear(plant: &StateSpace, rho: f64) -> LinearDesign {
    let poles: Vec<f64> = (0..plant.a.nrows()).map(|k| -1.0 - 0.4 * k as f64).collect();
    LinearDesign::with_poles_and_weight(plant, &poles, LyapunovWeight::Identity(rho)).unwrap()
}
