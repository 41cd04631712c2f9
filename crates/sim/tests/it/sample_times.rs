//! Observers corrected at samples of varying periods, some of them missed.

use luenberger_linalg::zero_order_hold;
use luenberger_observers::{LinearObserver, SampledCubicGains, SampledCubicObserver, VaryingPeriodObserver};
use luenberger_plants::double_integrator;
use luenberger_sim::{Disturbances, MeasurementLoss, SampleTimes, Scenario, Signal, SimError, Trajectory};
use nalgebra::{DMatrix, Matrix1, Matrix2, RowVector2, U1, U2, Vector1, Vector2};

const TIMES: SampleTimes = SampleTimes { shortest: 0.07, longest: 0.14, misses: 2, seed: 3 };

fn observer() -> VaryingPeriodObserver<f64, U2, U1, U1> {
    let (h, c) = (0.1, RowVector2::new(1.0, 0.0));
    let (ad, bd) = (Matrix2::new(1.0, h, 0.0, 1.0), Vector2::new(h * h / 2.0, h));
    let (ld, n) = (Vector2::new(0.9, 2.0), Vector2::new(-1.0, -1.5));
    let gains = SampledCubicGains { ad, bd, c, ld, n, theta: Matrix1::new(10.0), w: 1.0, period: h };
    let nominal = SampledCubicObserver::new(gains).unwrap();
    let (a, b, k) = (Matrix2::new(0.0, 1.0, 0.0, 0.0), Vector2::new(0.0, 1.0), Vector2::new(0.7, 2.0));
    VaryingPeriodObserver::new(nominal, a, b, k, 0.42).unwrap()
}

fn run(times: SampleTimes, input: f64, lost: Option<MeasurementLoss>) -> Result<Trajectory, SimError> {
    Scenario::new(double_integrator())
        .initial_state(&[3.0, -1.0])
        .input(Signal::constant(&[input]))
        .continuous_discrete_observer("jitter", observer(), times, &[0.5, 0.0])
        .disturbances(Disturbances { channel: lost, ..Disturbances::default() })
        .until(6.0, 61)
        .run()
}

/// The samples of the run, taken by the observer itself with the zero-order hold of the plant: no integrator.
#[test]
fn the_estimate_is_that_of_corrections_and_predictions_over_the_elapsed_times() {
    let run = run(TIMES, 0.3, None).unwrap();
    let plant = double_integrator().to_dynamic();
    let (observer, found) = (observer(), &run.observers[0]);
    let (mut x, mut xhat, u) = (Vector2::new(3.0, -1.0), Vector2::new(0.5, 0.0), Vector1::new(0.3));
    let mut t = 0.0;
    for sample in found.samples.iter().filter(|sample| sample.arrives) {
        assert!((sample.time - t - sample.elapsed).abs() < 1e-12, "{sample:?} after {t}");
        t = sample.time;
        let held = zero_order_hold(&plant.a, &plant.b, sample.elapsed).unwrap();
        let next = &held.ad * DMatrix::from_column_slice(2, 1, x.as_slice()) + held.bd * u[0];
        x = Vector2::new(next[0], next[1]);
        observer.predict(&mut xhat, &u, sample.elapsed);
        // The estimate just before the next sample is that of the trajectory.
        let before = run.observer_state_at("jitter", t - 1e-9).unwrap();
        assert!((Vector2::from_column_slice(&before) - xhat).norm() < 1e-7, "t = {t}: {before:?} and {xhat}");
        observer.correct(&mut xhat, &u, &Vector1::new(x[0]), sample.elapsed);
        let after = run.observer_state_at("jitter", t + 1e-9).unwrap();
        assert!((Vector2::from_column_slice(&after) - xhat).norm() < 1e-7, "t = {t}: {after:?} and {xhat}");
    }
    assert!(found.samples.len() > 40 && found.error[(0, 0)] == 2.5 && found.error.row(60).norm() < 1e-3);
}

/// Whatever stands before it in a row.
#[test]
fn the_estimate_does_not_depend_on_the_observers_beside_it() {
    let alone = run(TIMES, 0.3, None).unwrap();
    let beside = Scenario::new(double_integrator())
        .initial_state(&[3.0, -1.0])
        .input(Signal::constant(&[0.3]))
        .observer("linear", LinearObserver::of(double_integrator(), Vector2::new(3.0, 2.0)).unwrap(), &[0.0, 0.0])
        .continuous_discrete_observer("jitter", observer(), TIMES, &[0.5, 0.0])
        .until(6.0, 61)
        .run()
        .unwrap();
    let difference = &alone.observers[0].estimate - &beside.observers[1].estimate;
    assert!(difference.amax() < 1e-9, "{difference}");
}

#[test]
fn the_samples_keep_their_bounds_and_depend_on_the_seed() {
    let of = |times: SampleTimes| run(times, 0.0, None).unwrap().observers[0].samples.clone();
    let samples = of(TIMES);
    let mut before = 0.0;
    for sample in &samples {
        assert!((0.07 - 1e-12..0.14 + 1e-12).contains(&(sample.time - before)), "{sample:?}");
        before = sample.time;
    }
    assert!(samples.windows(3).all(|three| three.iter().any(|sample| sample.arrives)));
    assert!(samples.windows(2).any(|two| two.iter().all(|sample| !sample.arrives)));
    assert_eq!(samples, of(TIMES));
    assert_ne!(samples, of(SampleTimes { seed: 4, ..TIMES }));
    // A constant period without misses.
    let constant = of(SampleTimes { shortest: 0.1, longest: 0.1, misses: 0, seed: 0 });
    assert!(constant.iter().enumerate().all(|(k, sample)| {
        sample.arrives && (sample.time - 0.1 * (k + 1) as f64).abs() < 1e-12 && (sample.elapsed - 0.1).abs() < 1e-12
    }));
    let refused = run(SampleTimes { shortest: 0.0, ..TIMES }, 0.0, None);
    assert!(matches!(refused, Err(SimError::NotPositive { value: 0.0, .. })), "{refused:?}");
}

/// What a channel loses is missed as well, and the time since the last sample that arrived goes on.
#[test]
fn a_channel_loses_further_samples() {
    let channel = MeasurementLoss { dropout: 0.7, outlier: 0.0, outlier_size: vec![0.0], period: 0.5, seed: 2 };
    let run = run(TIMES, 0.0, Some(channel)).unwrap();
    let samples = &run.observers[0].samples;
    assert!(samples.windows(4).any(|four| four.iter().all(|sample| !sample.arrives)));
    let mut last = 0.0;
    for sample in samples {
        assert!((sample.time - last - sample.elapsed).abs() < 1e-12, "{sample:?} after {last}");
        if sample.arrives {
            assert!(run.is_measured(0, sample.time), "{sample:?}");
            last = sample.time;
        }
    }
}
