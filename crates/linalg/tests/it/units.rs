//! Balanced units of a pair (A, C).

use luenberger_linalg::internals::Units;
use nalgebra::DMatrix;

#[test]
fn a_chain_of_extreme_units_becomes_a_chain_of_ones() {
    let a = DMatrix::from_row_slice(3, 3, &[0.0, 2f64.powi(40), 0.0, 0.0, 0.0, 2f64.powi(-40), 0.0, 0.0, 0.0]);
    let c = DMatrix::from_row_slice(1, 3, &[2f64.powi(13), 0.0, 0.0]);
    let units = Units::of(&a, &c);
    for x in units.dynamics(&a).iter().chain(units.outputs(&c).iter()) {
        assert!(*x == 0.0 || (0.5..=2.0).contains(x), "{x:e} is not near one in {units:?}");
    }
}

#[test]
fn rounding_noise_is_outvoted() {
    let mut a = DMatrix::from_fn(4, 4, |i, j| 1.0 + (i + 2 * j) as f64 / 10.0);
    a[(2, 1)] = 1e-17;
    let units = Units::of(&a, &DMatrix::from_element(1, 4, 1.0));
    assert!(units.spread() <= 2, "one entry of 1e-17 among twenty bent the units: {units:?}");
}

#[test]
fn the_scaled_pair_does_not_depend_on_the_units_of_the_data() {
    let a = DMatrix::from_fn(4, 4, |i, j| ((3 * i + 5 * j + 1) % 7) as f64 - 3.3);
    let c = DMatrix::from_fn(2, 4, |i, j| ((2 * i + 3 * j) % 5) as f64 - 1.7);
    let (d, r, time) = ([37, -41, 3, 12], [-29, 17], 11);
    let other = (
        DMatrix::from_fn(4, 4, |i, j| a[(i, j)] * 2f64.powi(d[j] - d[i] - time)),
        DMatrix::from_fn(2, 4, |k, j| c[(k, j)] * 2f64.powi(d[j] - r[k])),
    );
    let (first, second) = (Units::of(&a, &c), Units::of(&other.0, &other.1));
    let (x, y) = (first.dynamics(&a), second.dynamics(&other.0));
    assert_eq!(x, y);
    assert_eq!(first.outputs(&c), second.outputs(&other.1));
}
