//! Decrease over an interval of times, against closed forms.

use luenberger_proof::certificate::{CubicStep, PlantMatrices, Theorem, VaryingPeriodConvergence};
use luenberger_proof::statement::decrease_over_times;
use luenberger_proof::{Interval, Matrix, UndecidedReason, Verdict};

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

/// Rotations as fast as 80 in the norm of `P = diag(1, 2, 1, 2, ..)` that need many cells: what one certificate may
/// cost is spent before all of its spans of time are decided, and the answer is the same on every machine.
#[test]
fn the_work_of_a_certificate_is_bounded() {
    let n = 40;
    let a = Matrix::from_fn(n, n, |i, j| match (i / 2 == j / 2, i.cmp(&j)) {
        (true, std::cmp::Ordering::Less) => 80.0,
        (true, std::cmp::Ordering::Greater) => -80.0,
        _ => 0.0,
    });
    let one = Matrix::from_fn(n, n, |i, j| if i == j { 1.0 } else { 0.0 });
    let plant = PlantMatrices { a, b: Matrix::from_fn(n, 0, |_, _| 0.0), c: one.map(|x| *x) };
    let theorem = VaryingPeriodConvergence {
        plant,
        k: one.map(|x| 0.5 * x),
        step: CubicStep::Linear,
        shortest: 1.0,
        longest: 2.0,
        misses: 1,
        p: Matrix::from_fn(n, n, |i, j| if i == j { 1.0 + (i % 2) as f64 } else { 0.0 }),
        factor: 0.8,
    };
    let facts = Theorem::from(theorem).facts().unwrap();
    let last = &facts.last().unwrap().verdict;
    assert!(matches!(last, Verdict::Undecided { why: UndecidedReason::TooMuchWork, .. }), "{last:?}");
}
