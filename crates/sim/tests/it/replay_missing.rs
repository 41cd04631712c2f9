//! Logs as they are: gaps, missing values, sensors of different rates, periods that are not those of the observer. Only
//! what was measured corrects an estimate, and nothing looks ahead.

use luenberger_observers::kalman::{ExtendedKalmanFilter, NoiseModel};
use luenberger_observers::{
    KalmanFilter, KalmanModel, LinearObserver, SampledCubicGains, SampledCubicObserver, SampledObserver, cubic,
};
use luenberger_plants::{LinearPlant, StaticPlant, double_integrator};
use luenberger_sim::samples::Samples;
use luenberger_sim::{BetweenRows, Recording, Replay, SampleInterpolation, SimError};
use nalgebra::{
    Const, DMatrix, Matrix1, Matrix2, Matrix2x1, RowVector2, SMatrix, Vector1, Vector2, Vector3, dmatrix, matrix,
};

type Filter<const P: usize> = ExtendedKalmanFilter<StaticPlant<f64, 2, 1, P>, f64, Const<2>, Const<1>, Const<P>>;

fn noises() -> NoiseModel<f64, Const<2>, Const<1>> {
    NoiseModel { w: Matrix2::new(0.02, 0.01, 0.01, 0.3), v: Matrix1::new(0.04), p0: Matrix2::new(1.0, 0.2, 0.2, 2.0) }
}

fn filter(period: f64) -> Filter<1> {
    ExtendedKalmanFilter::new(double_integrator(), noises(), period, 2).unwrap()
}

/// Exact prediction of the double integrator over a time tau: `P(tau) = F P F' + int F W F'`.
fn predicted(x: Vector2<f64>, p: Matrix2<f64>, u: f64, tau: f64) -> (Vector2<f64>, Matrix2<f64>) {
    let f = matrix![1.0, tau; 0.0, 1.0];
    let w = noises().w;
    let cross = w[(0, 1)] * tau + w[(1, 1)] * tau * tau / 2.0;
    let first = w[(0, 0)] * tau + w[(0, 1)] * tau * tau + w[(1, 1)] * tau.powi(3) / 3.0;
    let spread = matrix![first, cross; cross, w[(1, 1)] * tau];
    (f * x + Matrix2x1::new(tau * tau / 2.0, tau) * u, f * p * f.transpose() + spread)
}

fn corrected(x: Vector2<f64>, p: Matrix2<f64>, y: f64) -> (Vector2<f64>, Matrix2<f64>) {
    let gain = p.column(0) / (p[(0, 0)] + 0.04);
    (x + gain * (y - x[0]), p - gain * p.row(0))
}

/// Times between 0.05 and 40 apart: row by row the textbook's filter with the time that has really passed, whatever the
/// period of the filter.
#[test]
fn a_filter_is_predicted_over_the_time_that_has_passed() {
    let t = [0.0, 0.1, 0.15, 0.9, 1.0, 41.0, 41.1, 42.0];
    let u = [0.3, -0.2, 0.5, 0.1, 0.05, 0.0, 0.4, 0.0];
    let y = [0.2, 0.1, 0.3, -0.1, 0.2, 9.0, 8.8, 8.0];
    let (mut x, mut p) = (Vector2::new(0.5, -0.5), noises().p0);
    let mut expected = Vec::new();
    for k in 0..t.len() {
        (x, p) = corrected(x, p, y[k]);
        expected.push((x, p));
        if let Some(next) = t.get(k + 1) {
            (x, p) = predicted(x, p, u[k], next - t[k]);
        }
    }
    for period in [0.01, 0.37, 1.0, 100.0] {
        let column = |values: &[f64]| DMatrix::from_column_slice(8, 1, values);
        let log = Recording::new(t.to_vec(), column(&u), column(&y)).unwrap();
        let replayed = Replay::new(double_integrator(), log).filter("f", filter(period), &[0.5, -0.5]).run().unwrap();
        let found = replayed.observer("f").unwrap();
        assert_eq!((&found.t[..], found.rows_used(), found.interpolated), (&t[..], 8, 0));
        let consistency = found.consistency.as_ref().unwrap();
        for (k, (x, p)) in expected.iter().enumerate() {
            let apart = (0..2).fold(0.0f64, |apart, i| apart.max((found.estimate[(k, i)] - x[i]).abs()));
            assert!(apart < 1e-9 * (1.0 + x.amax()), "period {period}, row {k}: {apart:e}");
            let covariance = consistency.covariance(k).unwrap();
            let apart = (0..4).fold(0.0f64, |apart, i| apart.max((covariance[i] - p[i]).abs()));
            assert!(apart < 1e-9 * p.amax(), "period {period}, row {k}: {apart:e}");
            assert!((consistency.deviation()[(k, 1)] - p[(1, 1)].sqrt()).abs() < 1e-9 * p.amax());
        }
    }
}

/// Position every 0.1, speed every 0.5 and not at all for a while: a filter with both sensors, updated by what is
/// there.
#[test]
fn sensors_of_different_rates_update_when_they_have_measured() {
    let plant =
        StaticPlant::<f64, 2, 1, 2>::new(Matrix2::new(0.0, 1.0, 0.0, 0.0), Vector2::new(0.0, 1.0), Matrix2::identity())
            .unwrap();
    let v = Matrix2::new(0.04, 0.01, 0.01, 0.09);
    let noises = NoiseModel { w: noises().w, v, p0: noises().p0 };
    let filter = ExtendedKalmanFilter::new(plant.clone(), noises.clone(), 0.1, 1).unwrap();
    let t: Vec<f64> = (0..60).map(|k| 0.1 * f64::from(k)).collect();
    let y = DMatrix::from_fn(60, 2, |k, j| {
        let there = if j == 0 { !(20..30).contains(&k) } else { k % 5 == 0 };
        there.then(|| (k as f64 * 0.7).sin() + j as f64)
    });
    let u = DMatrix::from_fn(60, 1, |k, _| (k % 7 != 3).then_some(0.1 * k as f64));
    let log = Recording::with_missing(t.clone(), &u, &y).unwrap();
    let replayed = Replay::new(plant, log).filter("f", filter.clone(), &[1.0, 1.0]).run().unwrap();
    let found = replayed.observer("f").unwrap();
    let mut estimate = filter.initial(0.0, &Vector2::new(1.0, 1.0), &Vector1::zeros(), &Vector2::zeros());
    let mut input = 0.0;
    for k in 0..60 {
        input = u[(k, 0)].unwrap_or(input);
        let measured = [y[(k, 0)].is_some(), y[(k, 1)].is_some()];
        let values = Vector2::new(y[(k, 0)].unwrap_or(f64::NAN), y[(k, 1)].unwrap_or(f64::NAN));
        let nis = found.consistency.as_ref().unwrap().nis[k];
        if measured.contains(&true) {
            let innovation =
                filter.update_partial(t[k], &mut estimate, &Vector1::new(input), &values, |j| measured[j]).unwrap();
            let nis = nis.unwrap();
            assert_eq!(nis.degrees, measured.iter().filter(|m| **m).count());
            assert!((nis.square - innovation.normalized_square).abs() < 1e-9 * (1.0 + nis.square), "row {k}");
        } else {
            assert_eq!(nis, None);
        }
        assert!((0..2).all(|j| found.innovation.as_ref().unwrap()[(k, j)].is_some() == measured[j]));
        let apart = (0..2).fold(0.0f64, |apart, i| apart.max((found.estimate[(k, i)] - estimate.estimate()[i]).abs()));
        assert!(apart < 1e-9, "row {k}: {apart:e}");
        if let Some(next) = t.get(k + 1) {
            assert!(filter.predict(t[k], &mut estimate, &Vector1::new(input), next - t[k]));
        }
    }
    // The expected NIS is the number of outputs that were there: 50 positions and 12 speeds in 52 rows.
    let consistency = found.consistency(0.0).unwrap().unwrap();
    assert_eq!((consistency.samples, consistency.expected), (52, 62.0 / 52.0));
}

/// The filter in discrete time at its own period, with a third of its samples missing, is the continuous-discrete one
/// of a plant whose discretisation is exact.
#[test]
fn the_discrete_filter_passes_over_what_is_missing() {
    let (_, w) = predicted(Vector2::zeros(), Matrix2::zeros(), 0.0, 0.2);
    let discrete = KalmanFilter::new(KalmanModel {
        ad: matrix![1.0, 0.2; 0.0, 1.0],
        bd: Matrix2x1::new(0.02, 0.2),
        c: RowVector2::new(1.0, 0.0),
        w,
        v: noises().v,
        p0: noises().p0,
        period: 0.2,
    })
    .unwrap();
    let kept: Vec<usize> = (0..200).filter(|k| k % 3 != 1).collect();
    let t: Vec<f64> = kept.iter().map(|k| 0.2 * *k as f64).collect();
    let u = DMatrix::from_element(t.len(), 1, 0.1);
    let y = DMatrix::from_fn(t.len(), 1, |i, _| (0.3 * t[i]).sin());
    let log = Recording::new(t, u, y).unwrap();
    // The extended filter of a plant in discrete time, whose `derivative` is the next state.
    let KalmanModel { ad, bd, c, w, v, p0, .. } = discrete.model().clone();
    let next = LinearPlant::new(ad, bd, c).unwrap();
    let extended = ExtendedKalmanFilter::discrete(next, NoiseModel { w, v, p0 }, 0.2).unwrap();
    let replay = Replay::new(double_integrator(), log).filter("continuous", filter(0.2), &[1.0, 0.0]);
    let replay = replay.filter("discrete", discrete, &[1.0, 0.0]).filter("extended", extended, &[1.0, 0.0]);
    let replayed = replay.run().unwrap();
    let [continuous, discrete, extended] = &replayed.observers[..] else { panic!() };
    assert_eq!((&extended.t, &extended.row), (&discrete.t, &discrete.row));
    assert!((&extended.estimate - &discrete.estimate).amax() < 1e-12);
    assert_eq!((discrete.t.len(), discrete.rows_used()), (kept.last().unwrap() + 1, kept.len()));
    for (i, k) in kept.iter().enumerate() {
        assert_eq!(discrete.row[*k], Some(i));
        let apart = (continuous.estimate.row(i) - discrete.estimate.row(*k)).amax();
        assert!(apart < 1e-9, "row {i}: {apart:e}");
    }
}

fn linear() -> LinearObserver<f64, Const<2>, Const<1>, Const<1>> {
    LinearObserver::of(double_integrator(), Vector2::new(3.0, 2.0)).unwrap()
}

fn sampled() -> SampledCubicObserver<f64, Const<2>, Const<1>, Const<1>> {
    let (h, c) = (0.1, RowVector2::new(1.0, 0.0));
    let (ad, bd) = (Matrix2::new(1.0, h, 0.0, 1.0), Vector2::new(h * h / 2.0, h));
    let (ld, n) = (Vector2::new(0.9, 2.0), Vector2::new(-1.0, -1.5));
    let w = cubic::rate(&c, &n);
    SampledCubicObserver::new(SampledCubicGains { ad, bd, c, ld, n, theta: Matrix1::new(10.0), w, period: h }).unwrap()
}

/// A log at these times of what is known of y; the input is 0.5.
fn log(rows: &[(f64, Option<f64>)]) -> Recording {
    let y = DMatrix::from_fn(rows.len(), 1, |k, _| rows[k].1);
    let u = DMatrix::from_element(rows.len(), 1, Some(0.5));
    Recording::with_missing(rows.iter().map(|row| row.0).collect(), &u, &y).unwrap()
}

/// Across a gap, and from a missing value on, the continuous observer is the copy of the plant: position and speed by
/// `x1 + x2 t + u t^2/2`, after the last measurement has moved with it for its period.
#[test]
fn a_continuous_observer_predicts_what_is_not_measured() {
    let dense = |from: u32, to: u32| (from..=to).map(|k| (0.1 * f64::from(k), Some(0.3 * f64::from(k % 4))));
    for (rows, blank) in [
        (dense(0, 20).chain(dense(60, 62)).collect::<Vec<_>>(), false),
        (dense(0, 20).chain((21..60).map(|k| (0.1 * f64::from(k), None))).chain(dense(60, 62)).collect(), true),
    ] {
        let replayed = Replay::new(double_integrator(), log(&rows)).observer("l", linear(), &[1.0, 0.0]).run().unwrap();
        let found = replayed.observer("l").unwrap();
        // Measured for one and a half periods where no row comes, and until the row with the missing value: w' = xhat2.
        let held: f64 = if blank { 0.1 } else { 0.15 };
        let y = rows[20].1.unwrap();
        let slope = |x: Vector3<f64>| Vector3::new(x[1] + 3.0 * (x[2] - x[0]), 0.5 + 2.0 * (x[2] - x[0]), x[1]);
        let mut x = Vector3::new(found.estimate[(20, 0)], found.estimate[(20, 1)], y);
        let steps = 1000;
        let h = held / f64::from(steps);
        for _ in 0..steps {
            let k1 = slope(x);
            let k2 = slope(x + k1 * (h / 2.0));
            let k3 = slope(x + k2 * (h / 2.0));
            let k4 = slope(x + k3 * h);
            x += (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
        }
        let alone = 4.0 - held;
        let expected = Vector2::new(x[0] + alone * x[1] + 0.25 * alone * alone, x[1] + 0.5 * alone);
        let after = found.t.iter().position(|t| *t > 5.95).unwrap();
        let apart = (0..2).fold(0.0f64, |apart, i| apart.max((found.estimate[(after, i)] - expected[i]).abs()));
        assert!(apart < 1e-7, "{blank}: {apart:e}");
        let innovation = found.innovation.as_ref().unwrap();
        assert!((0..rows.len()).all(|k| innovation[(k, 0)].is_some() == rows[k].1.is_some()));
    }
}

/// What comes later has no influence on what was estimated before it: for each kind of observer.
#[test]
fn nothing_looks_ahead() {
    let value = |k: u32| Some((0.3 * f64::from(k)).sin());
    let first: Vec<_> = (0..40).map(|k| (0.1 * f64::from(k), value(k))).collect();
    let second: Vec<_> = first
        .iter()
        .map(|(t, y)| if *t > 1.95 { (t + 0.1 * (t - 1.9), y.map(|y| y + 7.0)) } else { (*t, *y) })
        .collect();
    let run = |rows: &[(f64, Option<f64>)]| {
        Replay::new(double_integrator(), log(rows))
            .observer("linear", linear(), &[1.0, 0.0])
            .sampled_observer("sampled", sampled(), &[1.0, 0.0])
            .filter("filter", filter(0.1), &[1.0, 0.0])
            .run()
            .unwrap()
    };
    let (one, two) = (run(&first), run(&second));
    for (one, two) in one.observers.iter().zip(&two.observers) {
        assert_eq!(one.estimate.rows(0, 20), two.estimate.rows(0, 20), "{}", one.name);
        assert_ne!(one.estimate.rows(0, 25), two.estimate.rows(0, 25), "{}", one.name);
    }
}

/// Rows off the samples of an observer in discrete time are not used, and its samples without a row are predictions.
#[test]
fn an_observer_of_a_fixed_period_uses_the_rows_on_its_samples() {
    // On 0, 0.1, 0.2, ...: every fifth row of a log every 0.02 s, and a few that are late by less than 1 %.
    let rows: Vec<_> = (0..=100).map(|k| (0.02 * f64::from(k) + if k == 50 { 5e-4 } else { 0.0 }, Some(1.0))).collect();
    let replayed =
        Replay::new(double_integrator(), log(&rows)).sampled_observer("s", sampled(), &[0.0; 2]).run().unwrap();
    let found = replayed.observer("s").unwrap();
    assert_eq!((found.t.len(), found.rows_used(), found.interpolated), (21, 21, 0));

    // A row at every third sample: in between the innovation is zero.
    let rows: Vec<_> = (0..=30).map(|k| (0.3 * f64::from(k), Some((0.2 * f64::from(k)).cos()))).collect();
    let replayed =
        Replay::new(double_integrator(), log(&rows)).sampled_observer("s", sampled(), &[0.5, 0.0]).run().unwrap();
    let found = replayed.observer("s").unwrap();
    let (observer, mut state) = (sampled(), Vector2::new(0.5, 0.0));
    for k in 0..=90usize {
        let apart = (0..2).fold(0.0f64, |apart, i| apart.max((found.estimate[(k, i)] - state[i]).abs()));
        assert!(apart < 1e-12, "sample {k}: {apart:e}");
        let y = if k % 3 == 0 { rows[k / 3].1.unwrap() } else { state[0] };
        observer.step(0.1 * k as f64, &mut state, &Vector1::new(0.5), &Vector1::new(y));
    }
    assert_eq!((found.t.len(), found.rows_used()), (91, 31));

    // A period that does not fit at all.
    let rows: Vec<_> = (0..=100).map(|k| (0.137 * f64::from(k) + if k > 0 { 0.013 } else { 0.0 }, Some(1.0))).collect();
    let rows = &rows[..3];
    let error =
        Replay::new(double_integrator(), log(rows)).sampled_observer("s", sampled(), &[0.0; 2]).run().unwrap_err();
    assert!(matches!(error, SimError::PeriodDoesNotFit { rows: 3, period: 0.1, .. }), "{error}");
    let rows = [(0.0, Some(1.0)), (1e7, Some(1.0))];
    let error =
        Replay::new(double_integrator(), log(&rows)).sampled_observer("s", sampled(), &[0.0; 2]).run().unwrap_err();
    assert!(matches!(error, SimError::TooManySamples { .. }), "{error}");
    let error = Replay::new(double_integrator(), log(&rows)).filter("s", filter(0.1), &[0.0; 2]).run().unwrap_err();
    assert!(matches!(error, SimError::TooManySamples { .. }), "{error}");
}

/// Lines are drawn where they are asked for, and neither across gaps nor over missing values.
#[test]
fn lines_cross_neither_gaps_nor_missing_values() {
    // y = t, a missing value at 1.0, a gap from 2 to 4.
    let rows: Vec<_> =
        (0..=20).chain(40..=60).map(|k| (0.1 * f64::from(k), (k != 10).then_some(0.1 * f64::from(k)))).collect();
    let lines = log(&rows).between(SampleInterpolation::ZeroOrderHold, BetweenRows::Linear);
    let run =
        |log: Recording| Replay::new(double_integrator(), log).observer("l", linear(), &[0.0, 1.0]).run().unwrap();
    let (held, line) = (run(log(&rows)), run(lines.clone()));
    let row = |t: f64| rows.iter().position(|row| (row.0 - t).abs() < 1e-9).unwrap();
    // Up to 0.9 the line is y itself, of which the input 0.5 is wrong: the exact response to it is small.
    assert_ne!(held.observers[0].estimate.row(row(0.9)), line.observers[0].estimate.row(row(0.9)));
    // From 0.9 to 1.1 nothing but 0.9 is known: held for a period, then predicted, with lines and without.
    let step = |run: &luenberger_sim::Replayed, from: usize, to: usize| {
        let at = |k: usize| Vector2::new(run.observers[0].estimate[(k, 0)], run.observers[0].estimate[(k, 1)]);
        (at(from), at(to))
    };
    for run in [&held, &line] {
        let (from, to) = step(run, row(1.0), row(1.1));
        let predicted = Vector2::new(from[0] + 0.1 * from[1] + 0.0025, from[1] + 0.05);
        assert!((to - predicted).amax() < 1e-9);
        let (from, to) = step(run, row(2.0), row(4.0));
        // 0.15 of the time the last value is held; the rest is free: the speed grows by u.
        assert!((to[1] - from[1] - 1.0).abs() < 0.2, "{from} {to}");
    }
    // An observer in discrete time finds its samples on the lines, and counts them.
    let rows: Vec<_> = (0..=20).map(|k| (0.15 * f64::from(k), Some(1.0))).collect();
    let run = |log: Recording| {
        Replay::new(double_integrator(), log).sampled_observer("s", sampled(), &[0.0; 2]).run().unwrap()
    };
    let (held, line) =
        (run(log(&rows)), run(log(&rows).between(SampleInterpolation::ZeroOrderHold, BetweenRows::Linear)));
    assert_eq!((held.observers[0].rows_used(), held.observers[0].interpolated), (11, 0));
    assert_eq!((line.observers[0].rows_used(), line.observers[0].interpolated), (11, 20));
}

/// An output that a slow sensor measures is held for its own period, and is then a missing value.
#[test]
fn a_slow_sensor_is_held_for_its_own_period() {
    let plant = LinearPlant::new(Matrix1::new(0.0), SMatrix::<f64, 1, 0>::zeros(), Vector2::new(1.0, 1.0)).unwrap();
    let observer = LinearObserver::of(plant.clone(), matrix![0.0, 0.5]).unwrap();
    // x' = 0; the fast sensor has no weight, the slow one says 1 every second until 3, then nothing.
    let t: Vec<f64> = (0..=60).map(|k| 0.1 * f64::from(k)).collect();
    let y = DMatrix::from_fn(61, 2, |k, j| if j == 0 { Some(5.0) } else { (k % 10 == 0 && k <= 30).then_some(1.0) });
    let log = Recording::with_missing(t, &DMatrix::from_element(61, 0, None), &y).unwrap();
    assert!((log.median_period() - 0.1).abs() < 1e-12 && (log.output_period(1) - 1.0).abs() < 1e-12);
    assert_eq!((log.gaps(), log.output_gaps(1), log.outputs().count(1)), (vec![], vec![], 4));
    let replayed = Replay::new(plant, log).observer("o", observer, &[0.0]).run().unwrap();
    let at = |k: usize| replayed.observers[0].estimate[(k, 0)];
    // e' = -e/2 while it is held: up to 4, and not beyond.
    for (k, expected) in [(5, 0.25f64), (10, 0.5), (27, 1.35), (40, 2.0), (60, 2.0)] {
        assert!((at(k) - (1.0 - (-expected).exp())).abs() < 1e-7, "row {k}: {}", at(k));
    }
}

/// Errors and NEES where the truth is known, also of some states only.
#[test]
fn errors_are_known_where_the_truth_is() {
    let rows: Vec<_> = (0..50).map(|k| (0.1 * f64::from(k), Some(0.1 * f64::from(k)))).collect();
    let replayed = Replay::new(double_integrator(), log(&rows)).filter("f", filter(0.1), &[0.0, 0.0]).run().unwrap();
    let found = replayed.observer("f").unwrap();
    let t: Vec<f64> = rows.iter().map(|row| row.0).collect();
    let truth = DMatrix::from_fn(50, 2, |k, i| if i == 0 { Some(t[k]) } else { (k % 2 == 0).then_some(1.0) });
    let truth = Samples::with_missing(t, &truth, SampleInterpolation::ZeroOrderHold).unwrap();
    let errors = found.errors(&truth).unwrap();
    assert_eq!((errors[(3, 0)], errors[(3, 1)]), (Some(truth.values()[(3, 0)] - found.estimate[(3, 0)]), None));
    let (mut sum, consistency) = (0.0, found.consistency.as_ref().unwrap());
    for k in 0..50 {
        let p = consistency.covariance(k).unwrap();
        let e1 = errors[(k, 0)].unwrap();
        sum += match errors[(k, 1)] {
            Some(e2) => {
                let e = Vector2::new(e1, e2);
                let p = Matrix2::new(p[(0, 0)], p[(0, 1)], p[(1, 0)], p[(1, 1)]);
                (e.transpose() * p.try_inverse().unwrap() * e)[0]
            }
            None => e1 * e1 / p[(0, 0)],
        };
    }
    let nees = found.nees(&truth, 0.0).unwrap().unwrap();
    assert!((nees.mean - sum / 50.0).abs() < 1e-9 * sum && nees.expected == 1.5 && nees.samples == 50, "{nees:?}");
    let one = Samples::new(vec![0.0, 1.0], dmatrix![0.0; 0.0], SampleInterpolation::ZeroOrderHold).unwrap();
    assert!(matches!(found.errors(&one), Err(SimError::Length { expected: 2, found: 1, .. })));
}

#[test]
fn an_input_has_to_be_known_at_the_start() {
    let error = Recording::with_missing(vec![0.0, 1.0], &dmatrix![None; Some(1.0)], &dmatrix![Some(0.0); None]);
    assert_eq!(error, Err(SimError::NoInput { input: 0, time: 0.0 }));
}

/// A measurement that the gate rejects is none: listed, without weight in estimate, NIS and statistics.
#[test]
fn a_gate_makes_an_outlier_a_missing_value() {
    let right: Vec<_> = (0..60).map(|k| (0.1 * f64::from(k), Some(0.1 * f64::from(k % 3)))).collect();
    let outlier: Vec<_> =
        right.iter().enumerate().map(|(k, row)| if k == 40 { (row.0, Some(50.0)) } else { *row }).collect();
    let blank: Vec<_> = right.iter().enumerate().map(|(k, row)| if k == 40 { (row.0, None) } else { *row }).collect();
    let run = |rows: &[(f64, Option<f64>)], filter: Filter<1>| {
        let replayed = Replay::new(double_integrator(), log(rows)).filter("f", filter, &[0.0, 0.0]).run().unwrap();
        replayed.observer("f").unwrap().clone()
    };
    let gated = run(&outlier, filter(0.1).with_gate(6.0).unwrap());
    let without = run(&blank, filter(0.1));
    assert_eq!(gated.estimate, without.estimate);
    let (consistency, other) = (gated.consistency.as_ref().unwrap(), without.consistency.as_ref().unwrap());
    assert_eq!(
        (&consistency.rejected[..], &consistency.nis, &other.rejected[..]),
        (&[(40, 0)][..], &other.nis, &[][..])
    );
    assert!(gated.innovation.as_ref().unwrap()[(40, 0)].unwrap() > 40.0);
    assert_eq!(gated.statistics(0.0).unwrap(), without.statistics(0.0).unwrap());
}
