//! Products and factors of small matrices.

use luenberger_observers::internals::{Factor, times, times_transpose};
use nalgebra::{DMatrix, Matrix2, Matrix3};

#[test]
fn products_and_factors_are_those_of_nalgebra() {
    let a = DMatrix::from_fn(4, 3, |i, j| 1.0 / (1.0 + i as f64 + 2.0 * j as f64));
    let b = DMatrix::from_fn(3, 5, |i, j| (i as f64 - j as f64) * 0.3);
    assert!((times(&a, &b) - &a * &b).amax() <= 4.0 * f64::EPSILON);
    assert!((times_transpose(&a, &b.transpose()) - &a * &b).amax() <= 4.0 * f64::EPSILON);
    let s = Matrix3::new(4.0, 1.0, 0.5, 1.0, 3.0, -0.2, 0.5, -0.2, 2.0);
    let x = Factor::new(&s).map(|factor| factor.solve(&Matrix3::identity()));
    assert!((s * x.unwrap() - Matrix3::identity()).amax() <= 8.0 * f64::EPSILON);
    // The second pivot is 0.
    assert!(Factor::new(&Matrix2::new(4.0, 2.0, 2.0, 1.0)).is_none());
    assert!(Factor::new(&Matrix2::new(1.0, 0.0, f64::NAN, 1.0)).is_none());
}
