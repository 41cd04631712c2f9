//! Condition numbers of eigenvalues, and the eigenvectors that they come from.

use luenberger_linalg::internals::{Eigen, Eigenvectors, Part, conditions, triangular_factor};
use luenberger_linalg::{Schur, schur};
use nalgebra::{Complex, DMatrix};

/// Generic matrix with real and complex eigenvalues, against the inverse of a known complex matrix of eigenvectors.
#[test]
fn conditions_are_those_of_known_eigenvectors() {
    let x = DMatrix::from_row_slice(
        4,
        4,
        &[1.0, 0.2, 0.5, -0.3, 0.0, 1.0, 0.4, 0.9, 0.3, -0.6, 1.0, 0.1, 0.8, 0.2, 0.0, 1.0],
    );
    let mut lambda = DMatrix::zeros(4, 4);
    (lambda[(0, 0)], lambda[(1, 1)]) = (-1.0, 3.0);
    (lambda[(2, 2)], lambda[(2, 3)], lambda[(3, 2)], lambda[(3, 3)]) = (0.5, 2.0, -2.0, 0.5);
    let inverse = x.clone().try_inverse().unwrap();
    let form = schur(&(&x * lambda * &inverse)).unwrap();
    // Columns 2 and 3 hold the real and imaginary part of the pair's vector u + i v; its left vector is (row 2 - i
    // row 3) / 2.
    let real = |j: usize| x.column(j).norm() * inverse.row(j).norm();
    let pair = x.column(2).norm().hypot(x.column(3).norm()) * inverse.row(2).norm().hypot(inverse.row(3).norm()) / 2.0;
    for (value, found) in form.eigenvalues().iter().zip(conditions(&form, &[0; 4])) {
        let expected = if value.im != 0.0 {
            pair
        } else if value.re < 0.0 {
            real(0)
        } else {
            real(1)
        };
        assert!((found - expected).abs() < 1e-12 * expected, "{value}: {found} for {expected}");
    }
}

/// Real eigenvalues and pairs in any order along the diagonal: `A x = lambda x`, `y*A = lambda y*`, `Y*X = I`, and
/// the condition numbers in other units computed from these vectors.
#[test]
fn vectors_of_both_sides_are_eigenvectors() {
    let n = 9;
    let a = DMatrix::from_fn(n, n, |i, j| ((5 * i * i + 3 * j + 1) as f64).sin() + f64::from(u8::from(i == j + 1)));
    let form = schur(&a).unwrap();
    let eigen = Eigen::of(&form);
    let pairs = eigen.right.parts.iter().filter(|part| **part == Part::Real).count();
    assert!(pairs >= 2 && 2 * pairs < n, "real eigenvalues and pairs: {:?}", eigen.values);
    let complex = |v: &Eigenvectors| DMatrix::from_fn(n, n, |i, k| v.entry(i, k));
    let (x, y) = (complex(&eigen.right), complex(&eigen.left));
    let lambda = DMatrix::from_diagonal(&nalgebra::DVector::from_vec(eigen.values.clone()));
    let (plain, a) = (a.clone(), a.map(Complex::from));
    let bound = 20.0 * n as f64 * f64::EPSILON * a.norm();
    assert!((&a * &x - &x * &lambda).norm() < bound * x.norm());
    assert!((y.adjoint() * &a - &lambda * y.adjoint()).norm() < bound * y.norm());
    assert!((y.adjoint() * &x - DMatrix::identity(n, n)).norm() < 1e-14 * x.norm() * y.norm());

    // In the units given, T alone suffices.
    let alone = triangular_factor(&plain).unwrap();
    assert!(alone.q.is_empty() && alone.t == form.t);
    assert_eq!(conditions(&alone, &[0; 9]), conditions(&form, &[0; 9]));

    let powers = [3, -7, 0, 12, 5, -20, 1, 1, -4];
    let unit = |i: usize| 2f64.powi(powers[i]);
    for (k, found) in conditions(&form, &powers).into_iter().enumerate() {
        let x = (0..n).map(|i| (x[(i, k)] / unit(i)).norm_sqr()).sum::<f64>().sqrt();
        let y = (0..n).map(|i| (y[(i, k)] * unit(i)).norm_sqr()).sum::<f64>().sqrt();
        assert!((found - x * y).abs() < 1e-12 * found, "{k}: {found} for {}", x * y);
    }
}

#[test]
fn a_defective_eigenvalue_has_no_condition() {
    let form = schur(&DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 0.0, 1.0])).unwrap();
    let found = conditions(&form, &[0, 0]);
    assert!(found.iter().all(|x| *x > 1e15 && x.is_finite()), "{found:?}");
    // In other units of time.
    let fast = Schur { q: form.q.clone(), t: &form.t * 2f64.powi(40) };
    assert_eq!(conditions(&fast, &[0, 0]), found);
    // Two equal, coupled pairs.
    let pairs = [0.0, 2.0, 1.0, 0.5, -2.0, 0.0, 0.3, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, -2.0, 0.0];
    let form = Schur { q: DMatrix::identity(4, 4), t: DMatrix::from_row_slice(4, 4, &pairs) };
    let found = conditions(&form, &[0; 4]);
    assert!(found.iter().all(|x| *x > 1e14 && x.is_finite()), "{found:?}");
}
