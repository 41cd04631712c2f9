//! Sums and products in twice the working precision.

use luenberger_linalg::internals::{product, sum};
use nalgebra::dmatrix;

#[test]
fn what_cancels_is_kept() {
    // 2^60 + 1 - 2^60, and (2^30 + 1)^2 - 2^60 - 2^31 = 1.
    let big = 2.0_f64.powi(60);
    assert_eq!(sum(&[big, 1.0, -big]), 1.0);
    let x = 2.0_f64.powi(30) + 1.0;
    let (high, low) = product(&dmatrix![x, 2.0_f64.powi(30)], &dmatrix![x; -2.0_f64.powi(30) - 2.0]);
    assert_eq!(sum(&[high[(0, 0)], low[(0, 0)]]), 1.0);
}
