//! Arguments that have to be symmetric, and their scale.

use luenberger_linalg::internals::unit_scale;
use luenberger_linalg::{LinalgError, symmetric};
use nalgebra::{DMatrix, dmatrix};

#[test]
fn the_worst_asymmetric_entry_is_named() {
    let m = dmatrix![1.0, 2.0, 3.0; 2.0, 1.0, 5.0; 3.5, 7.0, 1.0];
    assert_eq!(
        symmetric("Q", &m).unwrap_err(),
        LinalgError::NotSymmetric {
            what: "Q",
            row: 2,
            col: 1,
            asymmetry: 2.0,
            allowed: 8.0 * 3.0 * f64::EPSILON * 7.0
        }
    );
}

#[test]
fn symmetry_is_judged_relative_to_the_matrix() {
    let m = dmatrix![1e-300, 1e-301; 2e-301, 1e-300];
    assert!(symmetric("Q", &m).is_err());
    let m = dmatrix![1e300, 1e300; 1e300 * (1.0 + 4.0 * f64::EPSILON), 1e300];
    assert!(symmetric("Q", &m).is_ok());
}

#[test]
fn the_unit_scale_is_exact_and_bounded() {
    for x in [1.0, 3.0, 1e-300, 1e300, 5e-324, f64::MAX] {
        let m = DMatrix::from_element(2, 2, x);
        let scale = unit_scale(&m);
        assert!(scale.is_normal() && (1.0 / scale).is_normal());
        assert!((1e-30..4.0).contains(&(x * scale)), "{x:e} -> {:e}", x * scale);
    }
    assert_eq!(unit_scale(&DMatrix::zeros(0, 0)), 1.0);
}
