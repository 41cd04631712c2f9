//! What an observer sees of an output between the rows of a log, against closed forms.

use luenberger_observers::LinearObserver;
use luenberger_plants::LinearPlant;
use luenberger_sim::samples::Samples;
use luenberger_sim::{BetweenRows, Recording, Replay, SampleInterpolation};
use nalgebra::{DMatrix, Matrix1, SMatrix, dmatrix};

/// The estimates at the rows of a log of `x' = a x`, `y = x`, of the observer with the gain 1 from 0. The rows say when
/// they are and whether they measured y, as 1.
fn estimates(a: f64, rows: &[(f64, bool)], between: BetweenRows) -> Vec<f64> {
    let plant = LinearPlant::new(Matrix1::new(a), SMatrix::<f64, 1, 0>::zeros(), Matrix1::new(1.0)).unwrap();
    let observer = LinearObserver::of(plant.clone(), Matrix1::new(1.0)).unwrap();
    let y = DMatrix::from_fn(rows.len(), 1, |k, _| rows[k].1.then_some(1.0));
    let times = rows.iter().map(|row| row.0).collect();
    let log = Recording::with_missing(times, &DMatrix::from_element(rows.len(), 0, None), &y).unwrap();
    let log = log.between(SampleInterpolation::ZeroOrderHold, between);
    let replayed = Replay::new(plant, log).observer("o", observer, &[0.0]).run().unwrap();
    replayed.observers[0].estimate.iter().copied().collect()
}

/// `x' = 0`: while y = 1 is held the estimate is `1 - exp(-T)` after a time T of holding; while y is predicted it
/// rests. A measurement reaches over its own period and half a period of the log, and not beyond a row that should
/// have repeated it and did not.
#[test]
fn a_measurement_is_held_for_its_period_and_half_a_period_of_the_log() {
    let all = |times: &[f64]| times.iter().map(|t| (*t, true)).collect::<Vec<_>>();
    let every_second = |k: u32| k.is_multiple_of(2) && k != 4;
    let cases = [
        // Across a gap for 1.5, up to a row that comes before that, and to one at its very end.
        (all(&[0.0, 1.0, 2.0, 3.0, 10.0]), vec![0.0, 1.0, 2.0, 3.0, 4.5]),
        (all(&[0.0, 1.0, 2.0, 3.0, 4.4]), vec![0.0, 1.0, 2.0, 3.0, 4.4]),
        (all(&[0.0, 1.0, 2.0, 3.0, 4.5]), vec![0.0, 1.0, 2.0, 3.0, 4.5]),
        (all(&[0.0, 1.0, 2.0, 3.0, 4.6]), vec![0.0, 1.0, 2.0, 3.0, 4.5]),
        // Nothing in the fourth row, and nothing in the first.
        ((0..6).map(|k| (f64::from(k), k != 3)).collect(), vec![0.0, 1.0, 2.0, 3.0, 3.0, 4.0]),
        ((0..4).map(|k| (f64::from(k), k != 0)).collect(), vec![0.0, 0.0, 1.0, 2.0]),
        // In every second row, but for the fifth: until it should have come.
        ((0..9).map(|k| (f64::from(k), every_second(k))).collect(), vec![0.0, 1.0, 2.0, 3.0, 4.0, 4.0, 4.0, 5.0, 6.0]),
    ];
    for (rows, held) in cases {
        let found = estimates(0.0, &rows, BetweenRows::Held);
        for (k, (found, held)) in found.iter().zip(&held).enumerate() {
            assert!((found - (1.0 - f64::exp(-held))).abs() < 1e-7, "{rows:?}, row {k}: {found}, held for {held}");
        }
    }
}

/// `x' = -x`: the measurement w moves with the model, `w' = -xhat`, and `xhat' = -2 xhat + w`. The matrix
/// `[-2 1; -1 0]` has the double eigenvalue -1 and the exponential `exp(-t) [1 - t, t; -t, 1 + t]`. After one and a
/// half periods the observer is a copy of the plant.
#[test]
fn a_measurement_that_moves_reaches_as_far() {
    let rows = [0.0, 1.0, 2.0, 3.0, 10.0].map(|t| (t, true));
    let found = estimates(-1.0, &rows, BetweenRows::Predicted);
    let after = |xhat: f64, t: f64| (-t).exp() * ((1.0 - t) * xhat + t);
    let mut expected = vec![0.0];
    for k in 0..3 {
        expected.push(after(expected[k], 1.0));
    }
    expected.push(after(expected[3], 1.5) * (-5.5_f64).exp());
    for (k, (found, expected)) in found.iter().zip(&expected).enumerate() {
        assert!((found - expected).abs() < 1e-7, "row {k}: {found}, expected {expected}");
    }
}

/// In the place of a missing value stands the last one before it, before the first one the first, and 0 in a column
/// without values: by hand.
#[test]
fn missing_values_are_filled_and_stay_missing() {
    let (some, none) = (Some, None);
    let values = dmatrix![none, none; some(5.0), none; none, none; some(7.0), none; none, none];
    let t = vec![0.0, 1.0, 2.0, 3.0, 4.0];
    let samples = Samples::with_missing(t, &values, SampleInterpolation::Linear).unwrap();
    assert_eq!(*samples.values(), dmatrix![5.0, 0.0; 5.0, 0.0; 5.0, 0.0; 7.0, 0.0; 7.0, 0.0]);
    let there: Vec<_> = (0..6).map(|row| samples.value(row, 0)).collect();
    assert_eq!(there, [None, Some(5.0), None, Some(7.0), None, None]);
    assert_eq!((samples.value(1, 1), samples.value(1, 2), samples.count(0), samples.count(1)), (None, None, 2, 0));
    let at = |samples: &Samples, t: f64| {
        let mut value = [f64::NAN; 3];
        samples.at(t, &mut value);
        assert!(value[1] == 0.0 && value[2].is_nan(), "{value:?}");
        value[0]
    };
    assert_eq!([0.5, 1.5, 2.25, 3.0, 3.5].map(|t| at(&samples, t)), [5.0, 5.0, 5.5, 7.0, 7.0]);
    let held = samples.with(SampleInterpolation::ZeroOrderHold);
    assert_eq!([0.5, 1.5, 2.25, 3.0, 3.5].map(|t| at(&held, t)), [5.0, 5.0, 5.0, 7.0, 7.0]);
}
