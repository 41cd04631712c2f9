//! Extreme eigenvalues of symmetric and general matrices.

use luenberger_linalg::{
    LinalgError, lambda_max, lambda_min, spectral_abscissa, spectral_radius, symmetric_eigenvalues,
};
use nalgebra::{DMatrix, dmatrix};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Weyl and Rayleigh: the extreme eigenvalues bound every Rayleigh quotient, at every scale of the matrix.
    #[test]
    fn rayleigh_quotients_lie_between_the_extremes(
        (n, data, v) in (1..=8_usize).prop_flat_map(|n| (
            Just(n),
            prop::collection::vec(-1.0..1.0_f64, n * n),
            prop::collection::vec(0.01..1.0_f64, n),
        )),
        decade in -300..300_i32,
    ) {
        let units = 10.0_f64.powi(decade);
        let half = DMatrix::from_row_slice(n, n, &data);
        let m = (&half + half.transpose()) * units;
        let v = DMatrix::from_column_slice(n, 1, &v);
        let quotient = (v.transpose() * (&m / units) * &v)[(0, 0)] / v.norm_squared();
        let slack = 20.0 * n as f64 * f64::EPSILON * (&m / units).norm();
        prop_assert!(lambda_min(&m).unwrap() / units <= quotient + slack);
        prop_assert!(lambda_max(&m).unwrap() / units >= quotient - slack);
        let sum: f64 = symmetric_eigenvalues(&m).unwrap().iter().map(|l| l / units).sum();
        prop_assert!((sum - (&m / units).trace()).abs() <= n as f64 * slack);
    }
}

#[test]
fn an_empty_matrix_has_no_extreme_eigenvalue() {
    let empty = DMatrix::zeros(0, 0);
    assert_eq!(symmetric_eigenvalues(&empty), Ok(vec![]));
    assert_eq!(lambda_min(&empty), Err(LinalgError::Empty { what: "M" }));
    assert_eq!(lambda_max(&empty), Err(LinalgError::Empty { what: "M" }));
    assert_eq!(spectral_abscissa(&empty), Err(LinalgError::Empty { what: "A" }));
    assert_eq!(spectral_radius(&empty), Err(LinalgError::Empty { what: "A" }));
}

#[test]
fn an_asymmetric_matrix_is_refused() {
    let m = dmatrix![1.0, 2.0; 3.0, 1.0];
    assert!(matches!(lambda_min(&m), Err(LinalgError::NotSymmetric { row: 1, col: 0, asymmetry: 1.0, .. })));
    assert!(matches!(lambda_min(&dmatrix![f64::NAN]), Err(LinalgError::NotFinite { row: 0, col: 0, .. })));
}

#[test]
fn extremes_of_a_general_spectrum() {
    // Eigenvalues -3, 1 +- 4i.
    let a = dmatrix![-3.0, 0.0, 0.0; 7.0, 1.0, 4.0; 0.0, -4.0, 1.0];
    assert!((spectral_abscissa(&a).unwrap() - 1.0).abs() <= 1e3 * f64::EPSILON);
    assert!((spectral_radius(&a).unwrap() - 17.0_f64.sqrt()).abs() <= 1e3 * f64::EPSILON);
}
