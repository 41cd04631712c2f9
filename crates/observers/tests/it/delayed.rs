//! Filters of late measurements: against the filter that gets them at their times.

#![cfg(feature = "dual")]

use luenberger_observers::{
    CovarianceFilter, DelayedFilter, ExtendedKalmanFilter, NoiseModel, ObserverError, SampledObserver, SigmaPoints,
    UnscentedKalmanFilter,
};
use luenberger_plants::{Plant, plant};
use luenberger_random::Random;
use nalgebra::{DMatrix, Matrix2, Vector2, dvector};

const STEPS: usize = 24;

/// A pendulum, whose angle and rate are measured.
#[derive(Clone, Debug)]
struct Pendulum;
plant!(Pendulum, (2, 1, 2), |plant, t, x, u| [x[1], u[0] - x[0].sin()], [x[0], x[1]]);

type Extended = ExtendedKalmanFilter<Pendulum, f64, nalgebra::Const<2>, nalgebra::Const<1>, nalgebra::Const<2>>;

fn noises() -> NoiseModel<f64, nalgebra::Const<2>, nalgebra::Const<2>> {
    NoiseModel {
        w: Matrix2::new(1e-4, 0.0, 0.0, 0.01),
        v: Matrix2::new(1e-4, 2e-5, 2e-5, 0.04),
        p0: Matrix2::identity(),
    }
}

fn extended() -> Extended {
    ExtendedKalmanFilter::error_controlled(Pendulum, noises(), 0.1).unwrap()
}

/// A measurement: when it is true, when it arrives, which output, and its value.
#[derive(Clone, Copy)]
struct Reading {
    of: f64,
    at: f64,
    output: usize,
    value: f64,
}

/// The inputs of the steps k = 0, 1, .. and the readings: the rate at every step, the angle at every third, `delay`
/// late.
fn experiment(delay: f64, steps: usize) -> (Vec<f64>, Vec<Reading>) {
    let mut random = Random(4);
    let u: Vec<f64> = (0..steps).map(|k| (0.5 * k as f64).cos()).collect();
    let (mut x, mut readings, fine) = (Vector2::new(0.5, 0.0), Vec::new(), 100);
    let mut states = vec![x];
    for k in 0..steps * fine {
        let slope = |x: &Vector2<f64>| Pendulum.derivative(0.0, x, &nalgebra::Vector1::new(u[k / fine]));
        let h = 0.1 / fine as f64;
        x += slope(&(x + slope(&x) * (0.5 * h))) * h;
        states.push(x);
    }
    for k in 0..steps {
        let ([a, b], t) = (random.normal_pair(), 0.1 * k as f64);
        readings.push(Reading { of: t, at: t, output: 1, value: states[k * fine][1] + 0.2 * a });
        let place = (10.0 * (t - delay) * fine as f64).round();
        if k % 3 == 0 && place >= 0.0 {
            readings.push(Reading { of: t - delay, at: t, output: 0, value: states[place as usize][0] + 0.01 * b });
        }
    }
    (u, readings)
}

/// The estimate at step k by what has arrived then, each at its time, in the order of times.
fn in_order<F>(filter: &F, (u, readings): &(Vec<f64>, Vec<Reading>), k: usize) -> (F::Estimate, F::State)
where
    F: CovarianceFilter<f64, Estimate = Vector2<f64>, Input = nalgebra::Vector1<f64>, Output = Vector2<f64>>,
    F::State: Clone,
{
    let now = 0.1 * k as f64;
    let mut times: Vec<f64> = (0..=k).map(|k| 0.1 * k as f64).collect();
    times.extend(readings.iter().filter(|one| one.at <= now + 1e-9).map(|one| one.of));
    times.sort_by(f64::total_cmp);
    times.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    let input = |t: f64| nalgebra::Vector1::new(u[((t * 10.0 + 1e-6).floor() as usize).min(u.len() - 1)]);
    let mut state = filter.initial(0.0, &Vector2::zeros(), &input(0.0), &Vector2::zeros());
    for (i, t) in times.iter().enumerate() {
        let (mut y, mut measured) = (Vector2::zeros(), [false; 2]);
        for one in readings.iter().filter(|one| one.at <= now + 1e-9 && (one.of - t).abs() < 1e-9) {
            (y[one.output], measured[one.output]) = (one.value, true);
        }
        if measured.contains(&true) {
            filter.measure(*t, &mut state, &input(*t), &y, &measured);
        }
        if let Some(next) = times.get(i + 1) {
            assert!(filter.advance(*t, &mut state, &input(*t), next - t));
        }
    }
    (filter.estimate(&state), state)
}

fn compare<F>(filter: &F, delay: f64, most: usize)
where
    F: CovarianceFilter<f64, Estimate = Vector2<f64>, Input = nalgebra::Vector1<f64>, Output = Vector2<f64>> + Clone,
    F::State: Clone,
{
    let experiment = experiment(delay, STEPS);
    let late = DelayedFilter::new(filter.clone(), &[delay, 0.0], most).unwrap();
    let input = |k: usize| nalgebra::Vector1::new(experiment.0[k]);
    let mut state = late.initial(0.0, &Vector2::zeros(), &input(0), &Vector2::zeros());
    for k in 0..STEPS {
        let t = 0.1 * k as f64;
        let (mut y, mut measured) = (Vector2::zeros(), [false; 2]);
        for one in experiment.1.iter().filter(|one| (one.at - t).abs() < 1e-9) {
            (y[one.output], measured[one.output]) = (one.value, true);
        }
        assert!(late.measure(t, &mut state, &input(k), &y, &measured).is_some(), "{k}");
        let (expected, own) = in_order(filter, &experiment, k);
        let error = (late.estimate(&state) - expected).norm();
        assert!(error < 1e-9, "delay {delay}, step {k}: {error}");
        let (mut p, mut q) = ([0.0; 4], [0.0; 4]);
        assert!(late.covariance_into(&state, &mut p) && filter.covariance_into(&own, &mut q));
        assert!(p.iter().zip(&q).all(|(p, q)| (p - q).abs() < 1e-9), "{p:?} {q:?}");
        assert!(late.advance(t, &mut state, &input(k), 0.1));
    }
}

/// Whole periods and parts of one, in both filters.
#[test]
fn late_measurements_have_the_estimates_of_those_in_order() {
    let unscented = UnscentedKalmanFilter::error_controlled(Pendulum, noises(), SigmaPoints::default(), 0.1).unwrap();
    for delay in [0.1, 0.3, 0.25, 0.72] {
        compare(&extended(), delay, 10);
        compare(&unscented, delay, 10);
    }
    compare(&extended(), 0.0, 2);
}

/// What is older than the stored times is passed over, and the filter goes on without it.
#[test]
fn a_measurement_from_before_the_stored_times_is_passed_over() {
    let u = nalgebra::Vector1::new(0.0);
    let late = DelayedFilter::new(extended(), &[0.5, 0.0], 3).unwrap();
    let mut state = late.initial(0.0, &Vector2::zeros(), &u, &Vector2::zeros());
    // Nothing is known of the time before the start.
    assert!(late.measure(0.0, &mut state, &u, &Vector2::new(1.0, 0.0), &[true, false]).is_none());
    assert!(late.rejects_output(0.0, &state, &u, &Vector2::new(1.0, 0.0), 0));
    assert!(late.innovation(0.0, &state, &u, &Vector2::new(1.0, 0.0))[0].is_finite());
    for k in 0..8 {
        assert!(late.advance(0.1 * f64::from(k), &mut state, &u, 0.1));
    }
    // Three times are kept, from 0.5 on.
    assert!(late.measure(0.8, &mut state, &u, &Vector2::new(1.0, 0.0), &[true, false]).is_none());
    let both = late.measure(0.8, &mut state.clone(), &u, &Vector2::new(1.0, 0.0), &[true, true]);
    let now = late.measure(0.8, &mut state.clone(), &u, &Vector2::new(1.0, 0.0), &[false, true]);
    assert!(both.is_some() && both == now);
    let longer = late.keeping(7).unwrap();
    let mut state = longer.initial(0.0, &Vector2::zeros(), &u, &Vector2::zeros());
    (0..8).for_each(|k| assert!(longer.advance(0.1 * f64::from(k), &mut state, &u, 0.1)));
    assert!(longer.measure(0.8, &mut state, &u, &Vector2::new(1.0, 0.0), &[true, false]).is_some());

    let wrong = |delays: &[f64], most: usize| DelayedFilter::new(extended(), delays, most).unwrap_err();
    assert!(matches!(wrong(&[0.1], 3), ObserverError::Table { expected: 2, found: 1, .. }));
    assert!(matches!(wrong(&[0.1, -0.1], 3), ObserverError::NotPositive { .. }));
    assert!(matches!(wrong(&[0.1, f64::NAN], 3), ObserverError::NotPositive { .. }));
    assert!(matches!(wrong(&[0.1, 0.0], 1), ObserverError::TooFew { least: 2, found: 1, .. }));
}

/// Sizes that are known at run time, and steps as a simulation makes them.
#[test]
fn steps_are_updates_and_predictions() {
    let one = DMatrix::from_element(1, 1, 1.0);
    let model = luenberger_observers::KalmanModel {
        ad: &one * 0.9,
        bd: one.clone(),
        c: one.clone(),
        w: &one * 0.1,
        v: one.clone(),
        p0: one,
        period: 0.5,
    };
    let filter = luenberger_observers::KalmanFilter::new(model).unwrap();
    let late = DelayedFilter::new(filter, &[1.0], 4).unwrap();
    let mut state = late.initial(0.0, &dvector![0.0], &dvector![0.0], &dvector![0.0]);
    let mut apart = state.clone();
    let mut entries = state.as_slice().to_vec();
    for k in 0..9 {
        let (t, u, y) = (0.5 * f64::from(k), dvector![f64::from(k % 3)], dvector![0.4 * f64::from(k)]);
        late.step(t, &mut state, &u, &y);
        late.measure(t, &mut apart, &u, &y, &[]);
        assert!(late.advance(t, &mut apart, &u, 0.5));
        assert!(late.step_into(t, &mut entries, u.as_slice(), y.as_slice(), &[true]));
        assert_eq!(state, apart);
        assert_eq!(entries, state.as_slice());
    }
}
