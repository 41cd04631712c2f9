//! Decrease over an interval of times, against closed forms.

use luenberger_proof::statement::decrease_over_times;
use luenberger_proof::{Interval, Matrix, Verdict};

fn scalar(x: f64) -> Matrix<f64> {
    Matrix::from_rows([[x]])
}

/// e' = e between corrections that halve e: `exp(t)/2 < factor` for t below `log(2 factor)`.
fn grows_until(factor: f64, end: f64) -> Verdict<luenberger_proof::Direction> {
    let half = Matrix::from_rows([[Interval::of(0.5)]]);
    decrease_over_times(&scalar(1.0), &half, &scalar(3.0), factor, (0.1, end)).unwrap()
}

#[test]
fn a_scalar_decreases_until_the_time_of_its_closed_form() {
    for factor in [0.6, 0.9, 0.99] {
        let last = (2.0_f64 * factor).ln();
        assert!(grows_until(factor, last - 1e-6).is_proved(), "{factor}");
        // Only the end of the interval is too late.
        assert!(grows_until(factor, last + 1e-6).is_refuted(), "{factor}");
    }
}

/// A rotation neither grows nor decays in the norm: the map alone decides, at every time.
#[test]
fn a_rotation_is_decided_by_the_map() {
    let turn = Matrix::from_rows([[0.0, 5.0], [-5.0, 0.0]]);
    let one = Matrix::from_rows([[1.0, 0.0], [0.0, 1.0]]);
    let map = |size: f64| Matrix::from_rows([[size, 0.0], [0.0, -size]]).map(|x: &f64| Interval::of(*x));
    let over = |size, factor| decrease_over_times(&turn, &map(size), &one, factor, (0.01, 2.0)).unwrap();
    assert!(over(0.79, 0.8).is_proved());
    assert!(over(0.81, 0.8).is_refuted());
}
