//! Published examples of SLICOT's routines: data and results as printed there, with the number of digits they print.
//!
//! SB03MD, SB03QD, SB04MD and SB04QD are beside the equations they belong to (`equations.rs`), SB02MD and BB01AD 1.3 in
//! `riccati.rs`, SB01BD in `placement.rs`.

use approx::assert_abs_diff_eq;
use luenberger_linalg::{generalized_lyapunov, lyapunov_factor};
use nalgebra::dmatrix;

#[test]
fn sb03od() {
    // "Continuous-time, no transposition": op(A)'X + X op(A) = -B'B, X = U'U.
    let a = dmatrix![
        -1.0, 37.0, -12.0, -12.0;
        -1.0, -10.0, 0.0, 4.0;
        2.0, -4.0, 7.0, -6.0;
        2.0, 2.0, 7.0, -9.0
    ];
    let b = dmatrix![
        1.0, 2.5, 1.0, 3.5;
        0.0, 1.0, 0.0, 1.0;
        -1.0, -2.5, -1.0, -1.5;
        1.0, 2.5, 4.0, -5.5;
        -1.0, -2.5, -4.0, 3.5
    ];
    let found = lyapunov_factor(&a, &b).unwrap();
    let printed = dmatrix![
        1.0, 3.0, 2.0, -1.0;
        0.0, 1.0, -1.0, 1.0;
        0.0, 0.0, 1.0, -2.0;
        0.0, 0.0, 0.0, 1.0
    ];
    // Integers, so that more than the printed digits are known; the condition of the equation is 1e3.
    assert_abs_diff_eq!(found.u, printed, epsilon = 1e-11);
    assert!(found.residual <= 30.0 * 4.0 * f64::EPSILON);
}

#[test]
fn sg03ad() {
    // "A'XE + E'XA = SCALE * Y", continuous, SEP 0.29, FERR 0.40E-13.
    let a = dmatrix![3.0, 1.0, 1.0; 1.0, 3.0, 0.0; 1.0, 0.0, 2.0];
    let e = dmatrix![1.0, 3.0, 0.0; 3.0, 2.0, 1.0; 1.0, 0.0, 1.0];
    let y = dmatrix![-64.0, -73.0, -28.0; -73.0, -70.0, -25.0; -28.0, -25.0, -18.0];
    let found = generalized_lyapunov(&a, &e, &-y).unwrap();
    let printed = dmatrix![-2.0, -1.0, 0.0; -1.0, -3.0, -1.0; 0.0, -1.0, -3.0];
    let error = (&found.p - &printed).norm() / printed.norm();
    assert!(error <= found.forward_error() && found.forward_error() <= 1e-10, "{error:e} {:e}", found.forward_error());
}
