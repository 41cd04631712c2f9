//! The coefficients of Radau IIA.

use luenberger_sim::internals::{ALPHA, BETA, GAMMA, R6, T, T_INVERSE};
use nalgebra::Matrix3;

/// The coefficients of the method.
const A: [[f64; 3]; 3] = [
    [(88.0 - 7.0 * R6) / 360.0, (296.0 - 169.0 * R6) / 1800.0, (-2.0 + 3.0 * R6) / 225.0],
    [(296.0 + 169.0 * R6) / 1800.0, (88.0 + 7.0 * R6) / 360.0, (-2.0 - 3.0 * R6) / 225.0],
    [(16.0 - R6) / 36.0, (16.0 + R6) / 36.0, 1.0 / 9.0],
];

#[test]
fn the_coordinates_make_the_inverse_of_a_block_diagonal() {
    let of = |m: [[f64; 3]; 3]| Matrix3::from_fn(|i, j| m[i][j]);
    let (t, inverse) = (of(T), of(T_INVERSE));
    // Each entry of the tables is rounded once: 3 terms of at most 5.
    assert!((t * inverse - Matrix3::identity()).amax() <= 32.0 * f64::EPSILON);
    let blocks = Matrix3::new(GAMMA, 0.0, 0.0, 0.0, ALPHA, -BETA, 0.0, BETA, ALPHA);
    assert!((of(A) * t * blocks * inverse - Matrix3::identity()).amax() <= 128.0 * f64::EPSILON);
}
