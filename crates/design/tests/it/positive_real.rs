//! The fixed-N margin for one output by strict positive realness.

use luenberger_design::robust::positive_real_margin;
use luenberger_design::{DesignError, InfeasibilityReason};
use nalgebra::dmatrix;

#[test]
fn a_first_order_error_tolerates_its_own_pole() {
    let margin = positive_real_margin(&dmatrix![-3.0], &dmatrix![1.0], &dmatrix![-2.0]).unwrap();
    assert!((margin - 3.0).abs() < 1e-14, "{margin}");
}

/// G(s) = (s + b) / ((s + 1)(s + 2)) shifted by eps is positive real iff its leading coefficient 3 - b - eps and
/// its value at zero stay positive: the margin is min(1, 3 - b) for 1 <= b < 3.
#[test]
fn a_second_order_example_has_the_textbook_margin() {
    for b in [1.0, 1.5, 2.0, 2.5, 2.9] {
        let f = dmatrix![0.0, 1.0; -2.0, -3.0];
        let margin = positive_real_margin(&f, &dmatrix![b, 1.0], &dmatrix![0.0; -1.0]).unwrap();
        let exact = f64::min(1.0, 3.0 - b);
        assert!((margin - exact).abs() < 1e-12, "b = {b}: {margin} against {exact}");
    }
}

#[test]
fn the_wrong_sign_of_the_gain_is_named() {
    let error = positive_real_margin(&dmatrix![-3.0], &dmatrix![1.0], &dmatrix![2.0]).unwrap_err();
    assert!(
        matches!(error, DesignError::Infeasible { reason: InfeasibilityReason::SignOfCn(x), .. } if x == 2.0),
        "{error}"
    );
}
