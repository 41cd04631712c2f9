//! Balancing of a matrix before its eigenvalues.

use luenberger_linalg::{Balanced, LinalgError, balanced};
use nalgebra::{DMatrix, dmatrix};

/// `S^-1 A S = B` entry by entry: all factors are powers of two.
fn check(a: &DMatrix<f64>) -> Balanced {
    let b = balanced(a).unwrap();
    for i in 0..a.nrows() {
        for j in 0..a.nrows() {
            let expected = a[(b.permutation[i], b.permutation[j])] * (b.scaling[j] / b.scaling[i]);
            assert_eq!(b.matrix[(i, j)], expected);
            assert!(i <= j || (b.active.contains(&i) && b.active.contains(&j)) || b.matrix[(i, j)] == 0.0);
        }
    }
    b
}

#[test]
fn hidden_units_are_found() {
    let a = dmatrix![1.0, 2.0, 1.0; -1.0, 1.0, 2.0; 1.0, 1.0, 1.0];
    let d = [1e-8_f64, 1.0, 1e30];
    let b = check(&DMatrix::from_fn(3, 3, |i, j| a[(i, j)] * d[i] / d[j]));
    assert!(b.matrix.amax() <= 8.0, "{}", b.matrix);
    assert_eq!(check(&a).matrix, a);
}

#[test]
fn triangular_matrices_fall_apart() {
    let a = dmatrix![1.0, 0.0, 0.0; 2.0, 3.0, 0.0; 4.0, 5.0, 6.0];
    let b = check(&a);
    assert!(b.active.is_empty());
    // A block of order two between an isolated column and an isolated row.
    let a = dmatrix![2.0, 1.0, 3.0, 1.0; 0.0, 7.0, 0.0, 0.0; 4.0, 1.0, 5.0, 1.0; 0.0, 1.0, 0.0, 1.0];
    let b = check(&a);
    assert_eq!(b.active.len(), 2);
    assert_eq!(b.matrix[(3, 3)], 7.0);
    let a = dmatrix![1.0, 2.0, 3.0, 1.0; 0.0, 2.0, 3.0, 1.0; 0.0, 4.0, 5.0, 1.0; 0.0, 0.0, 0.0, 7.0];
    let b = check(&a);
    assert_eq!((b.active, b.matrix[(0, 0)], b.matrix[(3, 3)]), (1..3, 1.0, 7.0));
}

#[test]
fn small_couplings_are_not_made_worse() {
    // James, Langou and Lowery: norms without the diagonal would scale such a matrix badly.
    let a = dmatrix![1.0, 1e-15, 1e-4; 1e-12, 1.0, 1e-15; 1e-15, 1e-13, 1.0];
    assert_eq!(check(&a).scaling, [1.0; 3]);
}

#[test]
fn eigenvectors_come_back() {
    let a = dmatrix![2.0, 1e9; 1e-9, 2.0];
    let b = check(&a);
    // The balanced matrix has the eigenvector (d1 x, d2 y) of (1e9, 1), for the eigenvalue 3.
    let inverse = DMatrix::from_fn(2, 1, |i, _| [1e9, 1.0][b.permutation[i]] / b.scaling[i]);
    let x = b.back(&inverse).unwrap();
    assert!((&a * &x - &x * 3.0).norm() <= 4.0 * f64::EPSILON * (a.norm() * x.norm()));
    assert!(matches!(b.back(&DMatrix::zeros(3, 1)), Err(LinalgError::DimensionMismatch { .. })));
    assert!(matches!(balanced(&dmatrix![f64::NAN]), Err(LinalgError::NotFinite { .. })));
    assert!(matches!(balanced(&DMatrix::zeros(2, 3)), Err(LinalgError::NotSquare { .. })));
    assert!(balanced(&DMatrix::zeros(0, 0)).unwrap().active.is_empty());
}

#[test]
fn the_ends_of_the_range_do_not_overflow() {
    let a = dmatrix![1e300, 1e300; 1e-300, 1e-300];
    let b = balanced(&a).unwrap();
    assert!(b.matrix.iter().all(|e| e.is_finite()) && b.matrix[(0, 1)] * b.matrix[(1, 0)] > 0.0, "{}", b.matrix);
}
