//! H2 and H-infinity norms: what has none, and shapes that do not fit.

use luenberger_linalg::{
    HInfinityNorm, LinalgError, discrete_h_infinity_norm, discrete_h2_norm, h_infinity_norm, h2_norm,
};
use nalgebra::{Complex, DMatrix, dmatrix};

type H2 = fn(&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>) -> Result<f64, LinalgError>;
type HInfinity = fn(&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>) -> Result<HInfinityNorm, LinalgError>;

#[test]
fn an_unstable_system_has_no_h2_norm() {
    let one = dmatrix![1.0];
    for (a, refused) in
        [(0.5, h2_norm(&dmatrix![0.5], &one, &one)), (2.0, discrete_h2_norm(&dmatrix![2.0], &one, &one))]
    {
        let error = refused.unwrap_err();
        assert!(
            matches!(error, LinalgError::NotStable { eigenvalue, .. } if eigenvalue == Complex::from(a)),
            "{error}"
        );
    }
}

#[test]
fn shapes_that_do_not_fit_are_named() {
    let (a, b, c, d) = (dmatrix![0.5, 0.0; 0.0, 0.5], dmatrix![1.0; 1.0], dmatrix![1.0, 1.0], dmatrix![0.0]);
    let short = dmatrix![1.0];
    for norm in [(|a, b, c| h2_norm(a, b, c)) as H2, |a, b, c| discrete_h2_norm(a, b, c)] {
        assert!(matches!(norm(&b, &b, &c), Err(LinalgError::NotSquare { what: "A", .. })));
        assert!(matches!(norm(&a, &short, &c), Err(LinalgError::DimensionMismatch { what: "B", .. })));
        assert!(matches!(norm(&a, &b, &short), Err(LinalgError::DimensionMismatch { what: "C", .. })));
    }
    for norm in
        [(|a, b, c, d| h_infinity_norm(a, b, c, d)) as HInfinity, |a, b, c, d| discrete_h_infinity_norm(a, b, c, d)]
    {
        assert!(matches!(norm(&c, &b, &c, &d), Err(LinalgError::NotSquare { what: "A", .. })));
        assert!(matches!(norm(&a, &short, &c, &d), Err(LinalgError::DimensionMismatch { what: "B", .. })));
        assert!(matches!(norm(&a, &b, &short, &d), Err(LinalgError::DimensionMismatch { what: "C", .. })));
        assert!(matches!(norm(&a, &b, &c, &c), Err(LinalgError::DimensionMismatch { what: "D", .. })));
    }
}
