//! The direction of the state that the outputs see least.

use luenberger_linalg::internals::least_visible;
use luenberger_linalg::schur;
use nalgebra::{Complex, DMatrix};

/// A chain of 60 equal cells seen at one end, at one of its own eigenvalues: the smallest singular values are so
/// near each other that inverse iteration alone needs hundreds of steps.
#[test]
fn the_direction_is_that_of_the_smallest_singular_value() {
    let n = 60;
    let chain = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 => -2.5,
        1 => 1.0,
        _ => 0.0,
    });
    let rotation = DMatrix::from_fn(n, n, |i, j| ((i * j) as f64).sin()).qr().q();
    let c = DMatrix::from_fn(1, n, |_, j| if j == 0 { 1.0 } else { 0.0 }) * rotation;
    let form = schur(&chain).unwrap();
    for shift in [Complex::from(-2.5), Complex::new(-1.0, 0.7), form.eigenvalues()[n / 2]] {
        let v = least_visible(&form.t, &c, shift).unwrap();
        let complex = |m: &DMatrix<f64>| m.map(Complex::from);
        let mut stacked = DMatrix::zeros(n + 1, n);
        stacked.rows_mut(0, n).copy_from(&(complex(&form.t) - DMatrix::identity(n, n) * shift));
        stacked.rows_mut(n, 1).copy_from(&complex(&c));
        let smallest = stacked.clone().singular_values().min();
        let found = (&stacked * &v).norm();
        assert!((v.norm() - 1.0).abs() < 1e-14);
        assert!(found <= smallest * (1.0 + 1e-9) + 1e-15, "{shift}: {found:e}, smallest {smallest:e}");
    }
}
