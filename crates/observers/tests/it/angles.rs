//! Filters of angles: against the same filter of readings that were unwrapped, over several turns, in radians and
//! degrees, with outliers and near half a turn.

#![cfg(feature = "dual")]

use luenberger_observers::moving_horizon::{Horizon, StaticMovingHorizonEstimator, state_length};
use luenberger_observers::unscented::SigmaPoints;
use luenberger_observers::{
    CovarianceFilter, ExtendedKalmanFilter, NoiseModel, ObserverError, SampledObserver, UnscentedKalmanFilter,
};
use luenberger_plants::plant;
use nalgebra::{ComplexField, Const, Matrix2, SVector, Vector2, convert};

const PERIOD: f64 = 0.1;

/// A heading that turns; the heading and the rate are measured, the heading continuously.
#[derive(Clone, Debug)]
struct Continuous;
plant!(Continuous, (2, 0, 2), |plant, t, x, u| [x[1], x[1] * convert(-0.02)], [x[0], x[1]]);

/// The same, and a compass that jumps at half a turn.
#[derive(Clone, Debug)]
struct Compass;
plant!(
    Compass,
    (2, 0, 2),
    |plant, t, x, u| [x[1], x[1] * convert(-0.02)],
    [ComplexField::sin(x[0]).atan2(ComplexField::cos(x[0])), x[1]]
);

/// In discrete time, with the heading continuous, and wrapped by f.
#[derive(Clone, Debug)]
struct Turning;
plant!(Turning, (2, 0, 2), |plant, t, x, u| [x[0] + x[1] * convert(PERIOD), x[1] * convert(0.998)], [x[0], x[1]]);
#[derive(Clone, Debug)]
struct Wrapped;
plant!(
    Wrapped,
    (2, 0, 2),
    |plant, t, x, u| {
        let next = x[0] + x[1] * convert(PERIOD);
        [ComplexField::sin(next).atan2(ComplexField::cos(next)), x[1] * convert(0.998)]
    },
    [x[0], x[1]]
);

/// Numbers in (-1, 1), a congruential generator's.
fn noise(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// Readings over six turns from 2.9 rad on, with noise of .06 rad and an outlier at every 40th sample, in units of
/// `unit` per radian: continuous, and wrapped.
fn readings(unit: f64) -> Vec<(Vector2<f64>, Vector2<f64>)> {
    let mut seed = 7;
    let turn = unit * std::f64::consts::TAU;
    let reading = |k: usize| {
        let t = k as f64 * PERIOD;
        let rate = 0.8 * (-0.02 * t).exp();
        let heading = 2.9 + 40.0 * (1.0 - (-0.02 * t).exp()) + if k % 40 == 39 { 1.3 } else { 0.0 };
        let continuous =
            Vector2::new(unit * (heading + 0.1 * noise(&mut seed)), unit * (rate + 0.02 * noise(&mut seed)));
        // Independent of the wrap that is tested.
        (continuous, Vector2::new(continuous[0] - turn * (continuous[0] / turn).round(), continuous[1]))
    };
    (0..600).map(reading).collect()
}

fn noises(unit: f64) -> NoiseModel<f64, Const<2>, Const<2>> {
    let square = unit * unit;
    let [w, v, p0] = [(1e-4, 1e-3), (4e-3, 2e-4), (0.04, 0.5)]
        .map(|(first, second)| Matrix2::from_diagonal(&Vector2::new(first * square, second * square)));
    NoiseModel { w, v, p0 }
}

/// Both filters over all readings: the estimates are the same modulo a turn, and so are their covariances.
fn compare<F, G>(name: &str, unit: f64, continuous: &F, wrapped: &G)
where
    F: CovarianceFilter<f64, Input = SVector<f64, 0>, Output = Vector2<f64>, Estimate = Vector2<f64>>,
    G: CovarianceFilter<f64, Input = SVector<f64, 0>, Output = Vector2<f64>, Estimate = Vector2<f64>>,
{
    let (u, turn, first) = (SVector::zeros(), unit * std::f64::consts::TAU, Vector2::new(unit * 2.8, 0.0));
    let mut exact = continuous.initial(0.0, &first, &u, &Vector2::zeros());
    // From the other side of half a turn.
    let mut found = wrapped.initial(0.0, &(first - Vector2::new(turn, 0.0)), &u, &Vector2::zeros());
    let (mut largest, mut rejected) = (0.0f64, 0);
    for (k, (y, wrapped_y)) in readings(unit).iter().enumerate() {
        let t = k as f64 * PERIOD;
        let (a, b) = (continuous.innovation(t, &exact, &u, y), wrapped.innovation(t, &found, &u, wrapped_y));
        assert!((a - b).amax() <= 1e-11 * turn, "{name}, sample {k}: innovations {a} {b}");
        for output in 0..2 {
            let rejects = continuous.rejects_output(t, &exact, &u, y, output);
            assert_eq!(wrapped.rejects_output(t, &found, &u, wrapped_y, output), rejects, "{name}, sample {k}");
            rejected += usize::from(rejects);
        }
        let first = continuous.measure(t, &mut exact, &u, y, &[]).unwrap();
        let second = wrapped.measure(t, &mut found, &u, wrapped_y, &[]).unwrap();
        assert!((first - second).abs() <= 1e-9 * (1.0 + first), "{name}, sample {k}: {first} {second}");
        assert!(continuous.advance(t, &mut exact, &u, PERIOD) && wrapped.advance(t, &mut found, &u, PERIOD));
        let (x, y) = (continuous.estimate(&exact), wrapped.estimate(&found));
        let turns = ((x[0] - y[0]) / turn).round();
        let apart = (x - y - Vector2::new(turns * turn, 0.0)).amax();
        assert!(apart <= 1e-11 * turn, "{name}, sample {k}: {x} {y}");
        let (mut p, mut q) = ([0.0; 4], [0.0; 4]);
        assert!(continuous.covariance_into(&exact, &mut p) && wrapped.covariance_into(&found, &mut q));
        for (p, q) in p.iter().zip(q) {
            assert!((p - q).abs() <= 1e-10 * unit * unit, "{name}, sample {k}: {p} {q}");
        }
        largest = largest.max(x[0].abs());
    }
    assert!(largest > 4.0 * turn, "{name}: {largest}");
    // The outliers, where there is a gate.
    assert_eq!(rejected >= 10, name.contains("Some"), "{name}: {rejected}");
}

/// The turns of the heading, in both columns.
fn turns(unit: f64) -> Vector2<f64> {
    Vector2::new(unit * std::f64::consts::TAU, 0.0)
}

#[test]
fn extended_filters_are_those_of_unwrapped_readings() {
    // Degrees for a plant that does not ask for the unit.
    for unit in [1.0, 180.0 / std::f64::consts::PI] {
        for iterations in [1, 3] {
            for gate in [None, Some(5.0)] {
                let filter = ExtendedKalmanFilter::new(Continuous, noises(unit), PERIOD, 2).unwrap();
                let filter = filter.with_iterations(iterations).unwrap();
                let filter = gate.map_or(Ok(filter.clone()), |gate| filter.with_gate(gate)).unwrap();
                let wrapped = filter.clone().with_angles(turns(unit)).unwrap();
                compare(&format!("extended, {iterations} {gate:?}"), unit, &filter, &wrapped);
            }
        }
    }
    let exact = ExtendedKalmanFilter::new(Continuous, noises(1.0), PERIOD, 2).unwrap();
    let compass = ExtendedKalmanFilter::new(Compass, noises(1.0), PERIOD, 2).unwrap();
    compare("extended, compass", 1.0, &exact, &compass.with_angles(turns(1.0)).unwrap());
    let exact = ExtendedKalmanFilter::discrete(Turning, noises(1.0), PERIOD).unwrap();
    let wrapped = ExtendedKalmanFilter::discrete(Wrapped, noises(1.0), PERIOD).unwrap();
    compare("extended, wrapped by f", 1.0, &exact, &wrapped.with_angles(turns(1.0)).unwrap());
}

#[test]
fn unscented_filters_are_those_of_unwrapped_readings() {
    let none = Vector2::zeros();
    for sigma in [SigmaPoints::default(), SigmaPoints { alpha: 0.3, beta: 2.0, kappa: 1.0 }] {
        for unit in [1.0, 180.0 / std::f64::consts::PI] {
            for gate in [None, Some(5.0)] {
                let filter = UnscentedKalmanFilter::new(Continuous, noises(unit), sigma, PERIOD, 2).unwrap();
                let filter = gate.map_or(Ok(filter.clone()), |gate| filter.with_gate(gate)).unwrap();
                let wrapped = filter.clone().with_angles(turns(unit), none).unwrap();
                compare(&format!("unscented, {sigma:?} {gate:?}"), unit, &filter, &wrapped);
            }
        }
        // The images of the points lie on both sides of the jump.
        let exact = UnscentedKalmanFilter::new(Continuous, noises(1.0), sigma, PERIOD, 2).unwrap();
        let compass = UnscentedKalmanFilter::new(Compass, noises(1.0), sigma, PERIOD, 2).unwrap();
        compare("unscented, compass", 1.0, &exact, &compass.with_angles(turns(1.0), none).unwrap());
        let exact = UnscentedKalmanFilter::discrete(Turning, noises(1.0), sigma, PERIOD).unwrap();
        let wrapped = UnscentedKalmanFilter::discrete(Wrapped, noises(1.0), sigma, PERIOD).unwrap();
        compare("unscented, wrapped by f", 1.0, &exact, &wrapped.with_angles(turns(1.0), turns(1.0)).unwrap());
    }
}

#[test]
fn moving_horizons_are_those_of_unwrapped_readings() {
    const WINDOW: usize = 5;
    type Estimator<S> = StaticMovingHorizonEstimator<S, f64, 2, 0, 2, { state_length(2, 0, 2, WINDOW) }, WINDOW>;
    let horizon = Horizon { window: WINDOW, iterations: 2 };
    for unit in [1.0, 180.0 / std::f64::consts::PI] {
        let estimator = Estimator::new(Continuous, noises(unit), horizon, PERIOD, 2).unwrap();
        let wrapped = estimator.clone().with_angles(turns(unit), Vector2::zeros()).unwrap();
        compare("moving horizon", unit, &estimator, &wrapped);
    }
    let exact = Estimator::new(Continuous, noises(1.0), horizon, PERIOD, 2).unwrap();
    let compass = Estimator::new(Compass, noises(1.0), horizon, PERIOD, 2).unwrap();
    compare("moving horizon, compass", 1.0, &exact, &compass.with_angles(turns(1.0), Vector2::zeros()).unwrap());
    let exact = Estimator::discrete(Turning, noises(1.0), horizon, PERIOD).unwrap();
    let wrapped = Estimator::discrete(Wrapped, noises(1.0), horizon, PERIOD).unwrap();
    compare("moving horizon, wrapped by f", 1.0, &exact, &wrapped.with_angles(turns(1.0), turns(1.0)).unwrap());
}

/// Without the turns the compass costs a turn: what the tests above compare is not what happens anyway.
#[test]
fn without_turns_a_wrapped_reading_is_an_error_of_a_turn() {
    let filter = ExtendedKalmanFilter::new(Compass, noises(1.0), PERIOD, 2).unwrap();
    let u = SVector::zeros();
    let estimate = filter.initial(0.0, &Vector2::new(3.1, 0.0), &u, &Vector2::zeros());
    let innovation = filter.innovation(0.0, &estimate, &u, &Vector2::new(-3.1, 0.0));
    assert!((innovation[0] + 6.2).abs() < 1e-12);
    let angles = filter.with_angles(turns(1.0)).unwrap();
    let innovation = angles.innovation(0.0, &estimate, &u, &Vector2::new(-3.1, 0.0));
    // 2 pi - 6.2
    assert!((innovation[0] - 0.083_185_307_179_586).abs() < 1e-12);
}

#[test]
fn turns_that_are_none_are_errors() {
    let filter = ExtendedKalmanFilter::new(Compass, noises(1.0), PERIOD, 2).unwrap();
    for wrong in [-360.0, f64::NAN, f64::INFINITY] {
        let error = filter.clone().with_angles(Vector2::new(0.0, wrong)).unwrap_err();
        assert!(matches!(error, ObserverError::NotPositive { what: "a full turn", .. }), "{error}");
    }
    // No angle is no option.
    let same = filter.clone().with_angles(Vector2::zeros()).unwrap();
    assert!(same.turns().is_none());
}
