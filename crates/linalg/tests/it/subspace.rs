//! Invariant subspaces: their condition and their separation.

use luenberger_linalg::Schur;
use nalgebra::{DMatrix, dmatrix};

#[test]
fn the_condition_of_a_plane_is_known_in_closed_form() {
    // R = c / (a - b), s = 1 / sqrt(1 + R^2), sep = |a - b|, in any units.
    for scale in [1.0, 1e-200, 1e200] {
        let t = dmatrix![1.0, 3.0; 0.0, -0.5] * scale;
        let found = Schur { q: DMatrix::identity(2, 2), t }.reorder(|l| l.re > 0.0).unwrap();
        assert_eq!(found.dimension, 1);
        assert!((found.average - 1.0 / 5.0_f64.sqrt()).abs() <= 4.0 * f64::EPSILON);
        assert!((found.separation / scale - 1.5).abs() <= 4.0 * f64::EPSILON);
    }
}

#[test]
fn the_separation_is_that_of_the_kronecker_matrix() {
    // A complex pair and two real eigenvalues; the selected ones are at the bottom initially.
    let t = dmatrix![
        1.0, 2.0, 0.5, -1.0;
        0.0, 2.0, 1.5, 0.3;
        0.0, 0.0, -1.0, 3.0;
        0.0, 0.0, -2.0, -1.0
    ];
    let found = Schur { q: DMatrix::identity(4, 4), t }.reorder(|l| l.re < 0.0).unwrap();
    let block = |i: usize, j: usize| found.schur.t.view((i, j), (2, 2)).into_owned();
    let identity = DMatrix::<f64>::identity(2, 2);
    let operator = identity.kronecker(&block(0, 0)) - block(2, 2).transpose().kronecker(&identity);
    let inverse = operator.try_inverse().unwrap();
    let norm = inverse.column_iter().map(|c| c.lp_norm(1)).fold(0.0_f64, f64::max);
    assert!(found.separation * norm >= 1.0 - 1e-12 && found.separation * norm <= 3.0, "{}", found.separation * norm);
    let coupling = DMatrix::from_column_slice(4, 1, block(0, 2).as_slice());
    let expected = 1.0 / 1.0_f64.hypot((inverse * coupling).norm());
    assert!((found.average - expected).abs() <= 1e-13, "{} {expected}", found.average);
}

#[test]
fn trivial_subspaces_are_perfectly_conditioned() {
    let t = dmatrix![1.0, -3.0; 0.0, 2.0];
    for all in [true, false] {
        let found = Schur { q: DMatrix::identity(2, 2), t: t.clone() }.reorder(|_| all).unwrap();
        assert_eq!((found.average, found.separation), (1.0, 5.0));
    }
    let empty = Schur::default().reorder(|_| true).unwrap();
    assert_eq!((empty.dimension, empty.average, empty.separation), (0, 1.0, 0.0));
}

#[test]
fn neighbours_have_a_small_separation() {
    let t = dmatrix![1.0, 1.0; 0.0, 1.0 + 1e-10];
    let found = Schur { q: DMatrix::identity(2, 2), t }.reorder(|l| l.re > 1.0).unwrap();
    assert!((found.separation / 1e-10 - 1.0).abs() <= 1e-5);
    assert!((found.average / 1e-10 - 1.0).abs() <= 1e-5);
}
