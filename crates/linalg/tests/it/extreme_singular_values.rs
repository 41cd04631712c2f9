//! The largest and the smallest singular value alone, against the decomposition and against known ones.

use luenberger_linalg::internals::extreme_singular_values;
use nalgebra::DMatrix;

fn generic(n: usize) -> DMatrix<f64> {
    DMatrix::from_fn(n, n, |i, j| ((3 * i + 7 * j * j + 5 * i * j + 2) as f64).sin())
}

#[test]
fn they_are_those_of_the_decomposition() {
    for n in 1..=12 {
        let x = generic(n);
        let all = x.clone().singular_values();
        let (largest, smallest) = extreme_singular_values(x).unwrap();
        let bound = 20.0 * n as f64 * f64::EPSILON * all.max();
        assert!((largest - all.max()).abs() < bound && (smallest - all.min()).abs() < bound, "n = {n}: {all}");
    }
}

/// Known singular values, from `Q1 S Q2`: multiple ones, and ones several decades apart.
#[test]
fn multiple_and_small_ones() {
    let (q1, q2) = (generic(6).qr().q(), (generic(6) + DMatrix::identity(6, 6) * 2.0).qr().q());
    for sigma in [
        [1.0, 1.0, 1.0, 1.0, 1.0, 1.0],
        [3.0, 3.0, 1.0, 1.0, 0.5, 0.5],
        [2.0, 2.0, 2.0, 1e-3, 1e-3, 1e-3],
        [5.0, 4.0, 3.0, 2.0, 1.0, 1e-9],
    ] {
        let s = DMatrix::from_diagonal(&nalgebra::DVector::from_row_slice(&sigma));
        let (largest, smallest) = extreme_singular_values(&q1 * s * &q2).unwrap();
        // Three products and the reduction: n eps each, relative to the largest.
        let bound = 20.0 * 6.0 * f64::EPSILON * sigma[0];
        assert!((largest - sigma[0]).abs() < bound, "{largest} of {sigma:?}");
        assert!((smallest - sigma[5]).abs() < bound, "{smallest:e} of {sigma:?}");
    }
    // A bidiagonal matrix determines its smallest singular value to full accuracy: d / sqrt 2 to first order for (1
    // 1; 0 d).
    let mut steep = DMatrix::identity(2, 2);
    (steep[(0, 1)], steep[(1, 1)]) = (1.0, 1e-20);
    let (_, smallest) = extreme_singular_values(steep).unwrap();
    assert!((smallest * 2f64.sqrt() / 1e-20 - 1.0).abs() < 1e-14, "{smallest:e}");
}

#[test]
fn what_is_singular_has_a_zero() {
    assert_eq!(extreme_singular_values(DMatrix::zeros(3, 3)), Some((0.0, 0.0)));
    assert_eq!(extreme_singular_values(DMatrix::zeros(0, 0)), Some((0.0, 0.0)));
    let (largest, smallest) = extreme_singular_values(DMatrix::from_element(3, 3, 1.0)).unwrap();
    assert!((largest - 3.0).abs() < 1e-14 && smallest < 1e-15, "{largest} {smallest:e}");
}
