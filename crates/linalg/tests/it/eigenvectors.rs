//! Eigenvectors closed under conjugation, in real columns, against complex arithmetic.

use luenberger_linalg::internals::{Eigenvectors, norm};
use nalgebra::DMatrix;

/// Norms, entries, `cond_2(X)`, and `Y*X` diagonal.
#[test]
fn real_columns_say_the_same() {
    let given = DMatrix::from_fn(5, 5, |i, j| ((3 * i + 7 * j * j + 5 * i * j + 2) as f64).sin());
    let x = Eigenvectors::reals_first(given, 1).normalised();
    let complex = |x: &Eigenvectors| DMatrix::from_fn(5, 5, |i, k| x.entry(i, k).scale(0.5f64.sqrt()));
    let whole = |x: &Eigenvectors| {
        let mut m = complex(x);
        m.column_mut(0).scale_mut(2f64.sqrt());
        m
    };
    let m = whole(&x);
    for column in m.column_iter() {
        assert!((column.norm() - 1.0).abs() < 1e-14);
    }
    assert_eq!(x.entry(2, 1), x.entry(2, 2).conj());
    let sigma = m.clone().singular_values();
    let expected = sigma.max() / sigma.min();
    assert!((x.condition().unwrap() - expected).abs() < 1e-10 * expected);
    let products = whole(&x.dual().unwrap()).adjoint() * m;
    for i in 0..5 {
        for k in 0..5 {
            assert!((products[(i, k)].norm() > 0.1) == (i == k) && (i == k || products[(i, k)].norm() < 1e-13));
        }
    }
}

#[test]
fn norms_neither_overflow_nor_vanish() {
    // Five roundings: a division, a square, a sum, a root and a product.
    let near = |x: f64, y: f64| (x / y - 1.0).abs() < 5.0 * f64::EPSILON;
    assert!(near(norm(&[3e-200, 4e-200]), 5e-200) && near(norm(&[3e200, -4e200]), 5e200));
    assert_eq!((norm(&[0.0, 0.0]), norm(&[f64::INFINITY, 1.0])), (0.0, f64::INFINITY));
    assert!(norm(&[f64::NAN, 1.0]).is_nan());
}
