//! Products of matrices by both of their code paths.

use faer::Accum;
use luenberger_linalg::internals::{multiply, view, view_mut};
use nalgebra::DMatrix;

/// Both code paths, for all shapes and transpositions; integers make the sums exact.
#[test]
fn products_of_any_shape() {
    for (rows, inner, cols) in [(1, 1, 1), (3, 3, 3), (2, 0, 3), (0, 2, 2), (3, 4, 3), (1, 27, 1), (5, 6, 7)] {
        let l = DMatrix::from_fn(rows, inner, |i, k| (1 + i + 3 * k) as f64);
        let r = DMatrix::from_fn(inner, cols, |k, j| (2 + 5 * k) as f64 - j as f64);
        let start = DMatrix::from_fn(rows, cols, |i, j| (i * j) as f64);
        let (lt, rt) = (l.transpose(), r.transpose());
        for (left, right) in [(view(&l), view(&r)), (view(&lt).transpose(), view(&rt).transpose())] {
            let (mut added, mut replaced) = (start.clone(), DMatrix::from_element(rows, cols, f64::NAN));
            multiply(view_mut(&mut added), Accum::Add, -2.0, left, right);
            multiply(view_mut(&mut replaced), Accum::Replace, 3.0, left, right);
            assert_eq!(added, &start - &l * &r * 2.0);
            assert_eq!(replaced, &l * &r * 3.0);
        }
    }
}
