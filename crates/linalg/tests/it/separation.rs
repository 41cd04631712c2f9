//! Estimates of the separation of operators that are known.

use luenberger_linalg::internals::{separation, separation_by_three};
use nalgebra::{DMatrix, dmatrix};

#[test]
fn the_estimate_is_exact_for_diagonal_operators_and_never_below_the_separation() {
    let d = dmatrix![4.0, -2.0; 0.5, 8.0];
    let solve = |x: &mut DMatrix<f64>| x.component_div_assign(&d);
    assert_eq!(separation(2, 2, solve, solve), 0.5);
    assert_eq!(separation_by_three(&mut DMatrix::zeros(2, 2), solve, solve), 0.5);
    assert_eq!(separation_by_three(&mut DMatrix::zeros(1, 1), |x| *x /= -4.0, |x| *x /= -4.0), 4.0);
    assert_eq!(separation_by_three(&mut DMatrix::zeros(0, 3), solve, solve), f64::INFINITY);
    // An overflow gives the separation zero.
    assert_eq!(separation_by_three(&mut DMatrix::zeros(2, 2), |x| x.fill(f64::NAN), solve), 0.0);
    // A full operator: X -> X M, whose inverse has the 1-norm of M^-1 transposed.
    let m = dmatrix![1.0, 2.0, 0.0; 0.0, 1.0, 3.0; -1.0, 0.0, 2.0];
    let inverse = m.clone().try_inverse().unwrap();
    let norm = inverse.row_iter().map(|r| r.lp_norm(1)).fold(0.0_f64, f64::max);
    let solve = |x: &mut DMatrix<f64>| *x = &*x * &inverse;
    let adjoint = |x: &mut DMatrix<f64>| *x = &*x * inverse.transpose();
    for found in [separation(2, 3, solve, adjoint), separation_by_three(&mut DMatrix::zeros(2, 3), solve, adjoint)] {
        assert!(found >= 1.0 / norm * (1.0 - 1e-14) && found <= 3.0 / norm, "{found} {}", 1.0 / norm);
    }
}
