//! Sensors with sampling periods of their own, and measurements that do not arrive.

use approx::assert_abs_diff_eq;
use luenberger_expression::{ExpressionPlant, Parameters};
use luenberger_observers::{
    DiscreteLinearObserver, KalmanFilter, KalmanModel, LinearObserver, NonlinearLuenbergerObserver,
};
use luenberger_plants::{LinearPlant, StateSpace, double_integrator};
use luenberger_sim::{Disturbances, MeasurementLoss, Scenario, Sensor, Signal, SimError};
use nalgebra::{DMatrix, Matrix2, Vector1, Vector2, dmatrix};

/// x' = u, y = x.
fn integrator() -> StateSpace {
    LinearPlant::new(dmatrix![0.0], dmatrix![1.0], dmatrix![1.0]).unwrap()
}

fn lost(dropout: f64, period: f64) -> Disturbances {
    let channel = MeasurementLoss { dropout, outlier: 0.0, outlier_size: vec![0.0], period, seed: 1 };
    Disturbances { channel: Some(channel), ..Disturbances::default() }
}

/// Position every 0.3 from 0.2 on, speed every 0.2, the filter every 0.1: filterpy 1.4.5, `KalmanFilter.update` with
/// the rows of H and R that are measured, then `predict`, 20 times.
#[test]
fn a_filter_is_updated_by_what_is_measured() {
    let h = 0.1;
    let model = KalmanModel {
        ad: Matrix2::new(1.0, h, 0.0, 1.0),
        bd: Vector2::new(h * h / 2.0, h),
        c: Matrix2::identity(),
        w: Matrix2::from_diagonal(&Vector2::new(0.0, 0.01)),
        v: Matrix2::from_diagonal(&Vector2::new(0.04, 0.25)),
        p0: Matrix2::identity(),
        period: h,
    };
    let plant = LinearPlant::new(dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0], DMatrix::identity(2, 2)).unwrap();
    let run = Scenario::new(plant)
        .initial_state(&[1.0, -0.5])
        .sensor(Sensor::new(0, 0.3).offset(0.2))
        .sensor(Sensor::new(1, 0.2))
        .sampled_observer("filter", KalmanFilter::new(model).unwrap(), &[0.0, 0.0])
        .until(2.0, 21)
        .run()
        .unwrap();
    let state = &run.observers[0].state;
    let expected = [
        0.004_409_353_795_072_46,
        -0.494_665_613_399_897_2,
        0.026_486_846_505_486_05,
        0.027_784_121_865_921_48,
        0.027_784_121_865_921_47,
        0.071_936_510_617_245_58,
    ];
    for (i, expected) in expected.into_iter().enumerate() {
        assert_abs_diff_eq!(state[(20, i)], expected, epsilon = 1e-12);
    }
    let measured = |output| (0..20).filter(|k| run.is_measured(output, f64::from(*k) * h)).collect::<Vec<_>>();
    assert_eq!(measured(0), [2, 5, 8, 11, 14, 17]);
    assert_eq!(measured(1), [0, 2, 4, 6, 8, 10, 12, 14, 16, 18]);
    // Before its first measurement nothing is known of the position; then the measurement is kept.
    assert!(run.measured[(1, 0)].is_nan());
    assert_abs_diff_eq!(run.measured[(4, 0)], 1.0 - 0.5 * 0.2, epsilon = 1e-12);
}

/// A filter that never gets a measurement only predicts: P = Ad^k P(0) Ad'^k.
#[test]
fn a_filter_without_measurements_predicts() {
    let h = 0.5;
    let model = KalmanModel {
        ad: Matrix2::new(1.0, h, 0.0, 1.0),
        bd: Vector2::new(h * h / 2.0, h),
        c: Matrix2::identity().fixed_rows::<1>(0).into_owned(),
        w: Matrix2::zeros(),
        v: Vector1::new(1e-6),
        p0: Matrix2::identity(),
        period: h,
    };
    let run = Scenario::new(double_integrator())
        .initial_state(&[3.0, 0.0])
        .disturbances(lost(1.0, h))
        .sampled_observer("filter", KalmanFilter::new(model).unwrap(), &[0.0, 1.0])
        .until(4.0, 9)
        .run()
        .unwrap();
    for k in 0..9 {
        let t = f64::from(k) * h;
        let row = run.observers[0].state.row(k as usize);
        for (found, expected) in row.iter().zip([t, 1.0, 1.0 + t * t, t, t, 1.0]) {
            assert_abs_diff_eq!(*found, expected, epsilon = 1e-12);
        }
    }
}

/// x+ = x + h u, observed with L = 0.5: at a sample without a measurement the error stays.
#[test]
fn a_sampled_observer_predicts_without_a_measurement() {
    let plant = LinearPlant::new(dmatrix![1.0], dmatrix![1.0], dmatrix![1.0]).unwrap();
    let observer = DiscreteLinearObserver::new(plant, dmatrix![0.5], 1.0).unwrap();
    let run = Scenario::new(integrator())
        .initial_state(&[8.0])
        .input(Signal::constant(&[1.0]))
        .hold_input(1.0)
        .sensor(Sensor::new(0, 2.0).offset(1.0))
        .sampled_observer("observer", observer, &[0.0])
        .until(6.0, 7)
        .run()
        .unwrap();
    let expected = [8.0, 8.0, 4.0, 4.0, 2.0, 2.0, 1.0];
    for (found, expected) in run.observers[0].error.iter().zip(expected) {
        assert_abs_diff_eq!(*found, expected, epsilon = 1e-9);
    }
}

/// x' = 0, xhat' = L (y - xhat): while a measurement is held the error decays, and without one it stays.
#[test]
fn an_observer_in_continuous_time_holds_until_the_next_measurement_is_due() {
    let observer = || LinearObserver::of(integrator(), dmatrix![1.0]).unwrap();
    let run = Scenario::new(integrator())
        .initial_state(&[2.0])
        .sensor(Sensor::new(0, 0.5).offset(1.0))
        .observer("observer", observer(), &[0.0])
        .until(3.0, 31)
        .run()
        .unwrap();
    for (k, &t) in run.t.iter().enumerate() {
        assert_abs_diff_eq!(run.observers[0].error[(k, 0)], 2.0 * (-(t - 1.0).max(0.0)).exp(), epsilon = 1e-8);
    }
    // Half of the measurements are lost: the error decays in the periods after those that arrive.
    let run = Scenario::new(integrator())
        .initial_state(&[2.0])
        .sensor(Sensor::new(0, 0.5))
        .disturbances(lost(0.5, 9.0))
        .observer("observer", observer(), &[0.0])
        .until(20.0, 41)
        .run()
        .unwrap();
    let arrived = (0..40).filter(|k| run.is_measured(0, f64::from(*k) * 0.5)).count();
    assert!((8..32).contains(&arrived));
    assert_abs_diff_eq!(run.observers[0].error[(40, 0)], 2.0 * (-0.5 * arrived as f64).exp(), epsilon = 1e-8);
    assert!((0..40).all(|k| run.measured[(k, 0)].is_nan() != run.is_measured(0, k as f64 * 0.5)));
}

/// The predicted output is that of the plant as the observer takes it.
#[test]
fn outputs_are_predicted_by_the_model() {
    let twice = LinearPlant::new(dmatrix![0.0], dmatrix![1.0], dmatrix![2.0]).unwrap();
    let run = |model: StateSpace| {
        let observer = LinearObserver::of(integrator(), dmatrix![1.0]).unwrap();
        let scenario = Scenario::new(twice.clone()).model(model).disturbances(lost(1.0, 1.0));
        let run = scenario.observer("observer", observer, &[3.0]).until(1.0, 2).run().unwrap();
        run.observers[0].estimate[(1, 0)]
    };
    assert_abs_diff_eq!(run(integrator()), 3.0, epsilon = 1e-12);
    assert_abs_diff_eq!(run(twice.clone()), 3.0 * 1f64.exp(), epsilon = 1e-8);
}

/// Noise of standard deviation 0.3 and 0.5 at 2000 measurements each: mean squares within five standard deviations of
/// sqrt(2/2000).
#[test]
fn sensors_have_noise_of_their_own() {
    let plant = LinearPlant::new(dmatrix![0.0], dmatrix![1.0], dmatrix![0.0; 0.0]).unwrap();
    let run = Scenario::new(plant)
        .sensor(Sensor::new(0, 0.01).gaussian(0.3, 4))
        .sensor(Sensor::new(1, 0.02).uniform(0.5, 4))
        .until(40.0, 4001)
        .run()
        .unwrap();
    let square = |output: usize, every: usize| {
        let values: Vec<f64> = (0..2000).map(|k| run.measured[(k * every, output)]).collect();
        values.iter().map(|y| y * y).sum::<f64>() / 2000.0
    };
    assert!((square(0, 1) / 0.09 - 1.0).abs() < 0.16);
    assert!((square(1, 2) * 3.0 / 0.25 - 1.0).abs() < 0.16);
    assert_eq!(run.measured[(2, 1)], run.measured[(3, 1)]);
    assert_ne!(run.measured[(2, 0)], run.measured[(3, 0)]);
}

#[test]
fn counts_of_measurements_on_samples() {
    let slow = Sensor::new(0, 0.3).offset(0.2);
    assert_eq!(slow.on_samples(0.1, 2.0), (7, 7));
    assert_eq!(slow.on_samples(0.2, 2.0), (4, 7));
    assert_eq!(slow.on_samples(0.1, 0.1), (0, 0));
    // At 0.2, 0.7, .. 2.7, of which 0.7 is a multiple of 0.7; up to the first one itself it is one.
    let other = Sensor::new(1, 0.5).offset(0.2);
    assert_eq!((other.on_samples(0.7, 2.8), other.on_samples(0.1, 0.2), other.output()), ((1, 6), (1, 1), 1));
}

/// The first measurement of a sensor has the first value of its noise, whenever it comes.
#[test]
fn the_noise_of_a_sensor_begins_with_its_first_measurement() {
    let noise = |offset: f64| {
        let sensor = Sensor::new(0, 0.5).offset(offset).gaussian(1.0, 3);
        let run = Scenario::new(integrator()).sensor(sensor).times(&[0.0, 0.6, 1.1, 1.6]).run().unwrap();
        run.measured.column(0).iter().copied().collect::<Vec<f64>>()
    };
    let (now, later) = (noise(0.0), noise(0.5));
    assert_eq!(later[1..], now[..3]);
    assert!(now.iter().all(|value| *value != 0.0));
}

/// An observer of some states predicts no output. One with a constant gain leaves out what is not measured: between the
/// measurements of a sensor, at 0, 2 and 4, its error stands still.
#[test]
fn an_observer_of_some_states_leaves_out_what_is_not_measured() {
    let still = LinearPlant::new(DMatrix::zeros(2, 2), dmatrix![0.0; 0.0], dmatrix![1.0, 0.0]).unwrap();
    let first = LinearPlant::new(dmatrix![1.0], dmatrix![0.0], dmatrix![1.0]).unwrap();
    let observer = DiscreteLinearObserver::new(first, dmatrix![0.5], 1.0).unwrap();
    let run = Scenario::new(still)
        .initial_state(&[8.0, 3.0])
        .sensor(Sensor::new(0, 2.0))
        .partial_sampled_observer("observer", observer, &[0.0], &[0])
        .until(4.0, 5)
        .run()
        .unwrap();
    for (found, expected) in run.observers[0].error.iter().zip([8.0, 4.0, 4.0, 2.0, 2.0]) {
        assert_abs_diff_eq!(*found, expected, epsilon = 1e-12);
    }
}

/// `x' = 0`, `y = x + t`, measured every half: the measurement moves by the time alone, and e' = -3 e throughout.
#[test]
fn a_measurement_moves_with_an_output_that_depends_on_the_time() {
    let plant = ExpressionPlant::new(&["0"], &["x1 + t"], 0, &Parameters::new()).unwrap();
    let observer = NonlinearLuenbergerObserver::new(plant.clone(), dmatrix![3.0]).unwrap();
    let run = Scenario::new(plant)
        .initial_state(&[2.0])
        .sensor(Sensor::new(0, 0.5))
        .observer("observer", observer, &[0.0])
        .until(2.0, 21)
        .run()
        .unwrap();
    for (k, &t) in run.t.iter().enumerate() {
        assert_abs_diff_eq!(run.observers[0].error[(k, 0)], 2.0 * (-3.0 * t).exp(), epsilon = 1e-8);
    }
}

/// From the offset on, and not before it, where a period divides the offset, too.
#[test]
fn a_sensor_does_not_measure_before_its_offset() {
    let run =
        Scenario::new(integrator()).sensor(Sensor::new(0, 0.2).offset(0.5)).start(1.0).until(2.0, 3).run().unwrap();
    let measured: Vec<i32> = (10..=20).filter(|tenths| run.is_measured(0, f64::from(*tenths) / 10.0)).collect();
    assert_eq!(measured, [15, 17, 19]);
}

#[test]
fn what_does_not_fit_is_an_error() {
    let failed = |sensors: Vec<Sensor>| {
        let scenario = sensors.into_iter().fold(Scenario::new(integrator()), Scenario::sensor);
        scenario.until(1.0, 2).run().unwrap_err()
    };
    let twice = failed(vec![Sensor::new(0, 1.0), Sensor::new(0, 2.0)]);
    assert_eq!(twice.to_string(), "output 1 has two sensors");
    assert!(matches!(failed(vec![Sensor::new(1, 1.0)]), SimError::Index { index: 1, count: 1, .. }));
    assert!(matches!(failed(vec![Sensor::new(0, 0.0)]), SimError::NotPositive { .. }));
    assert!(matches!(failed(vec![Sensor::new(0, 1.0).offset(-1.0)]), SimError::NotPositive { .. }));
    let other = Scenario::new(integrator()).model(double_integrator()).until(1.0, 2).run();
    assert!(matches!(other, Err(SimError::Length { .. })));
}
