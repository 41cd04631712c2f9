//! What an observer sees of an output between the rows of a log, against closed forms.

use luenberger_observers::kalman::{ExtendedKalmanFilter, NoiseModel};
use luenberger_observers::{ContinuousDiscreteObserver, LinearObserver, Observer, ObserverDimensions};
use luenberger_plants::{LinearPlant, plant};
use luenberger_sim::replay::ReplayedObserver;
use luenberger_sim::samples::Samples;
use luenberger_sim::{BetweenRows, Recording, Replay, SampleInterpolation};
use nalgebra::{DMatrix, Matrix1, SMatrix, SVector, Vector1, dmatrix};

/// The estimates at the rows of a log of `x' = a x`, `y = x`, of the observer with the gain 1 from 0. The rows say when
/// they are and whether they measured y, as 1.
fn estimates(a: f64, rows: &[(f64, bool)], between: BetweenRows) -> Vec<f64> {
    replayed(a, rows, |_| 1.0, between).estimate.iter().copied().collect()
}

/// The same, with y as a function of the time.
fn replayed(a: f64, rows: &[(f64, bool)], y: impl Fn(f64) -> f64, between: BetweenRows) -> ReplayedObserver {
    let plant = LinearPlant::new(Matrix1::new(a), SMatrix::<f64, 1, 0>::zeros(), Matrix1::new(1.0)).unwrap();
    let observer = LinearObserver::of(plant.clone(), Matrix1::new(1.0)).unwrap();
    let y = DMatrix::from_fn(rows.len(), 1, |k, _| rows[k].1.then(|| y(rows[k].0)));
    let times = rows.iter().map(|row| row.0).collect();
    let log = Recording::with_missing(times, &DMatrix::from_element(rows.len(), 0, None), &y).unwrap();
    let log = log.between(SampleInterpolation::ZeroOrderHold, between);
    let replayed = Replay::new(plant, log).observer("o", observer, &[0.0]).run().unwrap();
    replayed.observers[0].clone()
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

/// `x' = 0`, y = t at the rows that measure it, the gain 1: along a line `xhat' = t - xhat`, from xhat at s to
/// `t - 1 + (xhat - s + 1) exp(s - t)`; where a value is held, `value + (xhat - value) exp(-T)`; otherwise it rests.
#[test]
fn lines_join_measurements_that_are_near_enough() {
    enum Piece {
        Line(f64, f64),
        Held(f64, f64),
        Rest,
    }
    use Piece::{Held, Line, Rest};
    let after = |xhat: f64, piece: &Piece| match *piece {
        Line(s, t) => t - 1.0 + (xhat - s + 1.0) * (s - t).exp(),
        Held(value, time) => value + (xhat - value) * (-time).exp(),
        Rest => xhat,
    };
    let even = |times: &[f64]| times.iter().enumerate().map(|(k, t)| (*t, k % 2 == 0)).collect::<Vec<_>>();
    let cases = [
        // Across a gap: the last value for 1.5 periods. One of 1.4 periods is a line.
        ([0.0, 1.0, 2.0, 10.0].map(|t| (t, true)).to_vec(), vec![Line(0.0, 1.0), Line(1.0, 2.0), Held(2.0, 1.5)]),
        ([0.0, 1.0, 2.0, 3.4].map(|t| (t, true)).to_vec(), vec![Line(0.0, 1.0), Line(1.0, 2.0), Line(2.0, 3.4)]),
        // In every second row, and through the rows between them.
        (even(&[0.0, 1.0, 2.0, 3.0, 4.0]), vec![Line(0.0, 1.0), Line(1.0, 2.0), Line(2.0, 3.0), Line(3.0, 4.0)]),
        // Also through a row that comes so late that a measurement that is held would be given up there.
        (
            even(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.8, 6.4]),
            vec![Line(0.0, 1.0), Line(1.0, 2.0), Line(2.0, 3.0), Line(3.0, 4.0), Line(4.0, 5.8), Line(5.8, 6.4)],
        ),
        // Around a missing one no line: the one before it is held up to its row.
        ((0..5).map(|k| (f64::from(k), k != 3)).collect(), vec![Line(0.0, 1.0), Line(1.0, 2.0), Held(2.0, 1.0), Rest]),
    ];
    for (rows, pieces) in cases {
        let found = replayed(0.0, &rows, |t| t, BetweenRows::Linear);
        let mut expected = 0.0;
        for (k, piece) in pieces.iter().enumerate() {
            expected = after(expected, piece);
            let xhat = found.estimate[(k + 1, 0)];
            assert!((xhat - expected).abs() < 1e-7, "{rows:?}, row {}: {xhat}, expected {expected}", k + 1);
            let innovation = found.innovation.as_ref().unwrap()[(k + 1, 0)];
            let measured = rows[k + 1].1.then(|| rows[k + 1].0 - expected);
            assert!(innovation.is_some() == measured.is_some());
            assert!((innovation.unwrap_or(0.0) - measured.unwrap_or(0.0)).abs() < 1e-7, "{innovation:?} {measured:?}");
        }
    }
}

/// `xhat' = 0`, and at a sample `xhat := xhat + T (y - xhat)`, T the time since the last one.
struct ByElapsed;

impl Observer<f64> for ByElapsed {
    type State = Vector1<f64>;
    type Input = SVector<f64, 0>;
    type Output = Vector1<f64>;
    type Estimate = Vector1<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: 1, inputs: 0, outputs: 1, estimate: 1 }
    }

    fn derivative(&self, t: f64, _: &Vector1<f64>, _: &SVector<f64, 0>, _: &Vector1<f64>) -> Vector1<f64> {
        Vector1::new(t)
    }

    fn estimate(&self, _: f64, z: &Vector1<f64>, _: &SVector<f64, 0>, _: &Vector1<f64>) -> Vector1<f64> {
        *z
    }

    fn initial(&self, _: f64, xhat: &Vector1<f64>, _: &SVector<f64, 0>, _: &Vector1<f64>) -> Vector1<f64> {
        *xhat
    }
}

impl ContinuousDiscreteObserver<f64> for ByElapsed {
    fn correct(&self, z: &mut Vector1<f64>, _: &SVector<f64, 0>, y: &Vector1<f64>, elapsed: f64) {
        z[0] += elapsed * (y[0] - z[0]);
    }
}

/// With `xhat' = t` in between, from 0: at t = 1/2 it is 1/8 and is corrected by half of `4 - 1/8`; nothing is measured
/// at t = 1; and at t = 1.5 a whole second has passed, so that it is y. Before the corrections: 0, 1/8, ..
#[test]
fn samples_correct_by_the_time_that_has_passed() {
    let plant = LinearPlant::new(Matrix1::new(0.0), SMatrix::<f64, 1, 0>::zeros(), Matrix1::new(1.0)).unwrap();
    let y = dmatrix![Some(4.0); Some(4.0); None; Some(7.0)];
    let log = Recording::with_missing(vec![0.0, 0.5, 1.0, 1.5], &DMatrix::from_element(4, 0, None), &y).unwrap();
    let replayed = Replay::new(plant, log).corrected_observer("o", ByElapsed, &[0.0]).run().unwrap();
    let found = &replayed.observers[0];
    let after = 0.125 + 0.5 * 3.875;
    let before = [0.0, 0.125, after + 0.375, after + 1.0];
    let near = |found: &[f64], expected: [f64; 4]| {
        assert!(found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-9), "{found:?}");
    };
    near(found.estimate.as_slice(), [0.0, 0.125 + 0.5 * 3.875, after + 0.375, 7.0]);
    near(found.with_predictions().estimate.as_slice(), before);
    let innovation: Vec<Option<f64>> = found.innovation.as_ref().unwrap().iter().copied().collect();
    assert!(innovation[2].is_none() && (innovation[3].unwrap() - (7.0 - before[3])).abs() < 1e-9);
    assert!((innovation[1].unwrap() - 3.875).abs() < 1e-9 && found.steps > 0);
}

/// `x' = t`, known without noise, from a log whose gap of 3 takes three steps of the filter: `(4^2 - 1)/2`.
struct Clock;

plant!(Clock, (1, 0, 1), |plant, t, x, u| [t], [x[0]]);

#[test]
fn a_filter_that_crosses_a_gap_knows_the_time() {
    let noises = NoiseModel { w: Matrix1::new(0.5), v: Matrix1::new(1e12), p0: Matrix1::new(2.0) };
    let filter = ExtendedKalmanFilter::new(Clock, noises, 1.0, 4).unwrap();
    let log = Recording::new(vec![1.0, 4.0], DMatrix::zeros(2, 0), dmatrix![0.0; 0.0]).unwrap();
    let replayed = Replay::new(Clock, log).smoothed_filter("f", filter, &[3.0]).run().unwrap();
    let found = replayed.observer("f").unwrap();
    assert!((found.estimate[(1, 0)] - 10.5).abs() < 1e-9, "{}", found.estimate);
    // P' = 0.5 from 2 on, and measurements that say nothing.
    let consistency = found.consistency.as_ref().unwrap();
    assert!((consistency.covariance(1).unwrap()[0] - 3.5).abs() < 1e-9 && consistency.covariance(2).is_none());
    let deviation = consistency.deviation();
    assert!((deviation[(0, 0)] - 2f64.sqrt()).abs() < 1e-9 && (deviation[(1, 0)] - 3.5f64.sqrt()).abs() < 1e-9);
    let before = found.with_predictions();
    assert!((before.consistency.unwrap().covariance(1).unwrap()[0] - 3.5).abs() < 1e-9);
    assert!((found.smoothed.as_ref().unwrap().estimate[(0, 0)] - 3.0).abs() < 1e-9);
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
