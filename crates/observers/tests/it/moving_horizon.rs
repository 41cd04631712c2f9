//! The moving-horizon estimator: the Kalman filter where no bound is active, a dense quadratic program where one is, a
//! dense nonlinear least-squares problem, and bad data.

#![cfg(feature = "dual")]

use luenberger_observers::moving_horizon::{Horizon, MovingHorizonEstimator, state_length};
use luenberger_observers::{
    CovarianceFilter, ExtendedKalmanFilter, KalmanFilter, KalmanModel, NoiseModel, ObserverError, SampledObserver,
};
use luenberger_plants::{Differentiable, StaticPlant, double_integrator, plant};
use nalgebra::{
    Const, DMatrix, DVector, Dyn, Matrix1, Matrix2, Matrix3, RowVector2, SMatrix, SVector, Vector1, Vector2, Vector3,
    dmatrix, dvector,
};
use proptest::prelude::*;

use crate::pendulum::{Pendulum, noises};

/// With sizes known at compile time and a window of W samples, the state of length D.
type Fixed<S, const N: usize, const M: usize, const P: usize, const D: usize, const W: usize> =
    MovingHorizonEstimator<S, f64, Const<N>, Const<M>, Const<P>, Const<D>, W>;

const NONE: Vector2<f64> = Vector2::new(f64::NEG_INFINITY, f64::NEG_INFINITY);

/// Steps an estimator of window W beside the Kalman filter; some samples have one output only.
fn beside<const D: usize, const W: usize>(
    model: &KalmanModel<f64, Const<3>, Const<1>, Const<2>>,
    ys: &[f64],
    is_bounded: bool,
) -> Result<(), TestCaseError> {
    let plant = StaticPlant::new(model.ad, model.bd, model.c).unwrap();
    let noises = NoiseModel { w: model.w, v: model.v, p0: model.p0 };
    let horizon = Horizon { window: W, iterations: 1 };
    let mut estimator: Fixed<_, 3, 1, 2, D, W> = MovingHorizonEstimator::discrete(plant, noises, horizon, 1.0).unwrap();
    if is_bounded {
        estimator = estimator.with_bounds(Vector3::repeat(-1e6), Vector3::repeat(1e6)).unwrap();
    }
    let kalman = KalmanFilter::new(model.clone()).unwrap();
    let (u, start) = (Vector1::new(0.7), Vector3::new(0.3, -0.2, 0.1));
    let mut exact = kalman.initial(0.0, &start, &u, &Vector2::zeros());
    let mut found = estimator.initial(0.0, &start, &u, &Vector2::zeros());
    for (k, y) in ys.chunks(2).enumerate() {
        let (measured, y) = ([k % 3 != 1, k % 4 != 2], Vector2::new(y[0], y[1]));
        let innovation = kalman.update_partial(&mut exact, &u, &y, |output| measured[output]).unwrap();
        let square = estimator.measure(0.0, &mut found, &u, &y, &measured).unwrap();
        prop_assert!((square - innovation.normalized_square).abs() <= 1e-9, "{square} {innovation:?}");
        prop_assert!((exact.estimate() - estimator.estimate(&found)).amax() <= 1e-10, "window {W}, sample {k}");
        prop_assert!(kalman.predict(&mut exact, &u));
        prop_assert!(estimator.predict(0.0, &mut found, &u, 1.0));
        prop_assert!((exact.estimate() - estimator.estimate(&found)).amax() <= 1e-10, "window {W}, sample {k}");
        prop_assert!((exact.covariance() - estimator.covariance(&found)).amax() <= 1e-10, "window {W}, sample {k}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    /// The known pitfall: an arrival cost that has samples of the window in it counts them twice. Here the estimate of
    /// a linear plant is that of the Kalman filter, for every window, before and after it begins to move, with W
    /// singular and with bounds that are not active.
    #[test]
    fn without_active_bounds_it_is_the_kalman_filter(
        a in prop::array::uniform9(-1.0f64..1.0), c in prop::array::uniform6(-1.0f64..1.0),
        roots in prop::array::uniform9(-1.0f64..1.0), v in prop::array::uniform2(0.05f64..1.0), rho in -0.9f64..0.9,
        ys in prop::array::uniform16(-1.0f64..1.0), is_bounded in any::<bool>(),
    ) {
        let (ad, c) = (Matrix3::from_row_slice(&a), SMatrix::<f64, 2, 3>::from_row_slice(&c));
        let root = Matrix3::from_row_slice(&roots);
        let (p0, w) = (root * root.transpose(), root.columns(0, 2) * root.columns(0, 2).transpose());
        let cross = rho * (v[0] * v[1]).sqrt();
        let v = Matrix2::new(v[0], cross, cross, v[1]);
        let bd = SMatrix::<f64, 3, 1>::new(0.1, 0.2, 0.3);
        let model = KalmanModel { ad, bd, c, w, v, p0, period: 1.0 };
        beside::<{ state_length(3, 1, 2, 1) }, 1>(&model, &ys, is_bounded)?;
        beside::<{ state_length(3, 1, 2, 2) }, 2>(&model, &ys, is_bounded)?;
        beside::<{ state_length(3, 1, 2, 3) }, 3>(&model, &ys, is_bounded)?;
        beside::<{ state_length(3, 1, 2, 5) }, 5>(&model, &ys, is_bounded)?;
        // Longer than the run: full information.
        beside::<{ state_length(3, 1, 2, 9) }, 9>(&model, &ys, is_bounded)?;
    }
}

/// The last state of the window's problem with two samples, by trying every set of active bounds: of the sets whose
/// solution of the equations of Karush, Kuhn and Tucker is within the bounds and has no multiplier of the wrong sign,
/// one is left. And whether it is clear which bounds are active: no multiplier is near 0, and no free state near a
/// bound.
fn by_active_sets(
    model: &KalmanModel<f64, Const<2>, Const<1>, Const<1>>,
    start: &Vector2<f64>,
    (u, ys): (f64, [f64; 2]),
    (lower, upper): (f64, f64),
) -> (Vector2<f64>, bool) {
    // The rows of the least-squares problem in z = (x0, x1), each divided by its standard deviation.
    let root = |m: Matrix2<f64>| m.cholesky().unwrap().l().try_inverse().unwrap();
    let (prior, way) = (root(model.p0), root(model.w));
    let mut rows = DMatrix::<f64>::zeros(6, 4);
    let mut right = DVector::<f64>::zeros(6);
    rows.view_mut((0, 0), (2, 2)).copy_from(&prior);
    right.rows_mut(0, 2).copy_from(&(prior * start));
    rows.view_mut((2, 0), (2, 2)).copy_from(&(-way * model.ad));
    rows.view_mut((2, 2), (2, 2)).copy_from(&way);
    right.rows_mut(2, 2).copy_from(&(way * model.bd * u));
    for (k, y) in ys.iter().enumerate() {
        let deviation = model.v[0].sqrt();
        rows.view_mut((4 + k, 2 * k), (1, 2)).copy_from(&(model.c / deviation));
        right[4 + k] = y / deviation;
    }
    let (hessian, gradient) = (rows.transpose() * &rows, rows.transpose() * right);
    let mut solutions = Vec::new();
    for set in 0..3_usize.pow(4) {
        // 0 is free, 1 at the lower bound, 2 at the upper one.
        let of: Vec<usize> = (0..4).map(|i| set / 3_usize.pow(i) % 3).collect();
        let mut matrix = hessian.clone();
        let mut side = gradient.clone();
        for i in 0..4 {
            if of[i] > 0 {
                let bound = if of[i] == 1 { lower } else { upper };
                for k in 0..4 {
                    side[k] -= hessian[(k, i)] * bound;
                    (matrix[(i, k)], matrix[(k, i)]) = (0.0, 0.0);
                }
                matrix[(i, i)] = 1.0;
            }
        }
        (0..4).filter(|i| of[*i] > 0).for_each(|i| side[i] = if of[i] == 1 { lower } else { upper });
        let z = matrix.lu().solve(&side).unwrap();
        let force = &hessian * &z - &gradient;
        let is_right = (0..4).all(|i| match of[i] {
            0 => lower <= z[i] && z[i] <= upper,
            1 => force[i] >= 0.0,
            _ => force[i] <= 0.0,
        });
        let width = upper - lower;
        let is_clear = (0..4).all(|i| match of[i] {
            0 => (z[i] - lower).min(upper - z[i]) > 1e-3 * width,
            _ => force[i].abs() * width > 1e-2,
        });
        if is_right {
            solutions.push((Vector2::new(z[2], z[3]), is_clear));
        }
    }
    assert_eq!(solutions.len(), 1, "{solutions:?}");
    solutions[0]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    /// With bounds that are active in most cases, noises of many sizes, and units of states, input and output from 1e-6
    /// to 1e6: to 1e-7 of the width of the bounds, 1e-6 where a bound is barely active. The method ends at s z = mu, a
    /// thousand roundings: a slack of 2e-11 for a multiplier of 1e-2, one of 5e-7 where both are small.
    #[test]
    fn bounds_as_by_every_active_set(
        a in prop::array::uniform4(-1.0f64..1.0), roots in prop::array::uniform8(-1.0f64..1.0),
        c in prop::array::uniform2(-1.0f64..1.0), start in prop::array::uniform2(-1.0f64..1.0),
        ys in prop::array::uniform2(-3.0f64..3.0), u in -1.0f64..1.0,
        (w, v, p0) in (-3.0f64..1.0, -4.0f64..1.0, -3.0f64..1.0), width in 0.05f64..0.5, unit in -6i32..=6,
    ) {
        let unit = 10.0_f64.powi(unit);
        let of = |roots: &[f64], size: f64| {
            let root = Matrix2::from_row_slice(roots) + Matrix2::identity();
            (root * root.transpose() + 0.05 * Matrix2::identity()) * 10.0_f64.powf(size) * unit * unit
        };
        let model = KalmanModel {
            ad: Matrix2::from_row_slice(&a),
            bd: Vector2::new(0.2, -0.1) * unit,
            c: RowVector2::new(c[0], c[1]) / unit,
            w: of(&roots[..4], w),
            v: Matrix1::new(10.0_f64.powf(v)),
            p0: of(&roots[4..], p0),
            period: 1.0,
        };
        let (lower, upper, start) = (-width * unit, 2.0 * width * unit, Vector2::new(start[0], start[1]) * unit);
        let noises = NoiseModel { w: model.w, v: model.v, p0: model.p0 };
        let plant = StaticPlant::new(model.ad, model.bd, model.c).unwrap();
        let horizon = Horizon { window: 2, iterations: 1 };
        let estimator: Fixed<_, 2, 1, 1, { state_length(2, 1, 1, 2) }, 2> =
            MovingHorizonEstimator::discrete(plant, noises, horizon, 1.0)
                .and_then(|free| free.with_bounds(Vector2::repeat(lower), Vector2::repeat(upper)))
                .unwrap();
        let input = Vector1::new(u);
        let mut state = estimator.initial(0.0, &start, &input, &Vector1::zeros());
        for (k, y) in ys.into_iter().enumerate() {
            prop_assert!(estimator.update(0.0, &mut state, &input, &Vector1::new(y), |_| true).is_some());
            if k == 0 {
                prop_assert!(estimator.predict(0.0, &mut state, &input, 1.0));
            }
        }
        let (expected, is_clear) = by_active_sets(&model, &start, (u, ys), (lower, upper));
        let distance = (estimator.estimate(&state) - expected).amax() / (upper - lower);
        prop_assert!(distance <= if is_clear { 1e-7 } else { 1e-6 }, "{distance:e}: {} {expected}", estimator.estimate(&state));
    }
}

/// In continuous time, of the double integrator, whose Runge-Kutta steps are exact: the extended Kalman filter.
#[test]
fn in_continuous_time_it_is_the_filter_as_well() {
    let noises = NoiseModel { w: Matrix2::new(0.0, 0.0, 0.0, 0.3), v: Matrix1::new(0.04), p0: Matrix2::identity() };
    let filter = ExtendedKalmanFilter::new(double_integrator(), noises.clone(), 0.2, 1).unwrap();
    let horizon = Horizon { window: 3, iterations: 1 };
    let estimator: Fixed<_, 2, 1, 1, { state_length(2, 1, 1, 3) }, 3> =
        MovingHorizonEstimator::new(double_integrator(), noises, horizon, 0.2, 1).unwrap();
    let x = Vector2::new(0.3, -0.1);
    let mut exact = filter.initial(0.0, &x, &Vector1::zeros(), &Vector1::zeros());
    let mut found = estimator.initial(0.0, &x, &Vector1::zeros(), &Vector1::zeros());
    for k in 0..20 {
        let t = 0.2 * f64::from(k);
        let (u, y) = (Vector1::new((3.0 * t).cos()), Vector1::new(t.sin()));
        filter.step(t, &mut exact, &u, &y);
        estimator.step(t, &mut found, &u, &y);
        assert!((exact.estimate() - estimator.estimate(&found)).amax() < 1e-12, "{k}");
        assert!((exact.covariance() - estimator.covariance(&found)).amax() < 1e-12, "{k}");
    }
}

/// cvxpy 1.9.3 with Clarabel, each window's problem with its variables as one dense quadratic program, and the arrival
/// cost by the Kalman filter: bounds x2 >= 0 and x1 <= 1.2, a window of four samples. Estimates after each measurement.
#[test]
fn bounds_as_by_a_dense_quadratic_program() {
    let (ad, bd, c) = (Matrix2::new(1.0, 0.5, 0.0, 1.0), Vector2::new(0.125, 0.5), RowVector2::new(1.0, 0.0));
    let noises = NoiseModel {
        w: Matrix2::new(0.02, 0.01, 0.01, 0.04),
        v: Matrix1::new(0.09),
        p0: Matrix2::new(1.0, 0.2, 0.2, 0.5),
    };
    let plant = StaticPlant::new(ad, bd, c).unwrap();
    let estimator: Fixed<_, 2, 1, 1, { state_length(2, 1, 1, 4) }, 4> =
        MovingHorizonEstimator::discrete(plant, noises, Horizon { window: 4, iterations: 1 }, 0.5)
            .and_then(|free| free.with_bounds(Vector2::new(f64::NEG_INFINITY, 0.0), Vector2::new(1.2, f64::INFINITY)))
            .unwrap();
    let mut state = estimator.initial(0.0, &Vector2::new(0.5, -0.2), &Vector1::zeros(), &Vector1::zeros());
    let samples = [(0.2, 0.1), (-0.1, -0.4), (0.3, 0.3), (0.0, 1.0), (0.5, 0.2), (0.1, 1.9), (-0.2, 2.5), (0.4, 0.1)];
    let expected = [
        [0.14277227722772282, 0.0],
        [-0.13382929345023203, 0.0704254770500259],
        [0.08533754216939632, 0.10253992534801638],
        [0.7214047630967831, 0.7002402239546157],
        [0.5102458372271916, 0.28063705624876256],
        [1.2, 0.8770713076561409],
        [1.2, 0.5514965414492901],
        [1.0628927251444968, 0.0],
    ];
    for ((u, y), expected) in samples.into_iter().zip(expected) {
        let u = Vector1::new(u);
        estimator.update(0.0, &mut state, &u, &Vector1::new(y), |_| true).unwrap();
        let found = estimator.estimate(&state);
        assert!((found - Vector2::from(expected)).amax() < 1e-8, "{found} where {expected:?} was expected");
        assert!(found[1] >= 0.0 && found[0] <= 1.2);
        assert!(estimator.predict(0.0, &mut state, &u, 0.5));
    }
}

/// scipy 1.17.1, `least_squares` over all states of six samples: without bounds, and with x1 <= 0.6 and x2 >= -0.15.
#[test]
fn a_nonlinear_plant_as_by_a_dense_least_squares_solver() {
    const STATE: usize = state_length(2, 0, 2, 6);
    let horizon = Horizon { window: 6, iterations: 8 };
    let free: Fixed<_, 2, 0, 2, STATE, 6> = MovingHorizonEstimator::discrete(Pendulum, noises(), horizon, 0.1).unwrap();
    let bounded = free.clone().with_bounds(Vector2::new(-10.0, -0.15), Vector2::new(0.6, 10.0)).unwrap();
    for (estimator, expected) in [(free, [0.7054471443973701, -0.4693095943286625]), (bounded, [0.6, -0.15])] {
        let u = SVector::zeros();
        let mut state = estimator.initial(0.0, &Vector2::new(0.5, -0.2), &u, &Vector2::zeros());
        for k in 0..6 {
            let y = Vector2::new((0.8 - 0.02 * f64::from(k)).sin(), -0.1 * f64::from(k) + 0.05);
            estimator.update(0.0, &mut state, &u, &y, |_| true).unwrap();
            let found = estimator.estimate(&state);
            if k == 5 {
                assert!((found - Vector2::from(expected)).amax() < 1e-8, "{found} where {expected:?} was expected");
            } else {
                assert!(estimator.predict(0.0, &mut state, &u, 0.1));
            }
        }
    }
}

/// What has no result is an answer, and leaves the state; a step without a prediction is NaN.
#[test]
fn a_failure_is_an_answer() {
    #[derive(Clone, Debug)]
    struct Root;
    plant!(Root, (1, 0, 1), |plant, t, x, u| [x[0].sqrt()], [x[0].sqrt()]);

    let noises = NoiseModel { w: Matrix1::new(0.01), v: Matrix1::new(0.01), p0: Matrix1::new(1.0) };
    let horizon = Horizon { window: 2, iterations: 2 };
    let free: Fixed<_, 1, 0, 1, { state_length(1, 0, 1, 2) }, 2> =
        MovingHorizonEstimator::discrete(Root, noises, horizon, 1.0).unwrap();
    let (u, y) = (SVector::zeros(), Vector1::new(0.1));
    // Outside of the domain from the start.
    let mut state = free.initial(0.0, &Vector1::new(-0.5), &u, &y);
    let before = state;
    assert!(free.update(0.0, &mut state, &u, &y, |_| true).is_none() && state == before);
    assert!(!free.predict(0.0, &mut state, &u, 1.0) && state == before);
    free.step(0.0, &mut state, &u, &y);
    assert!(free.estimate(&state)[0].is_nan());
    // The first Gauss-Newton step leaves it, to 1 - 2 (1 - 0.1)/1.04; bounds keep it in.
    let mut state = free.initial(0.0, &Vector1::new(1.0), &u, &y);
    assert!(free.update(0.0, &mut state, &u, &y, |_| true).is_none());
    let bounded = free.with_bounds(Vector1::new(1e-3), Vector1::new(10.0)).unwrap();
    assert!(bounded.update(0.0, &mut state, &u, &y, |_| true).is_some());
    let found = bounded.estimate(&state)[0];
    // d/dx ((x - 1)^2 + 100 (0.1 - sqrt x)^2) = 0: numpy 2.4.6, roots of 2 (x - 1) + 100 (1 - 0.1/sqrt x).
    assert!((2.0 * (found - 1.0) + 100.0 * (1.0 - 0.1 / found.sqrt())).abs() < 1e-6, "{found}");
}

/// Run-time sizes give the same bits.
#[test]
fn sizes_known_at_run_time() {
    let of = |m: Matrix2<f64>| DMatrix::from_column_slice(2, 2, m.as_slice());
    let plant = double_integrator();
    let w = Matrix2::new(0.1, 0.0, 0.0, 0.2);
    let horizon = Horizon { window: 3, iterations: 2 };
    let fixed: Fixed<_, 2, 1, 1, { state_length(2, 1, 1, 3) }, 3> = MovingHorizonEstimator::new(
        plant.clone(),
        NoiseModel { w, v: Matrix1::new(0.1), p0: Matrix2::identity() },
        horizon,
        0.1,
        2,
    )
    .and_then(|free| free.with_bounds(NONE, Vector2::new(0.5, 0.3)))
    .unwrap();
    let noises = NoiseModel { w: of(w), v: DMatrix::from_element(1, 1, 0.1), p0: DMatrix::identity(2, 2) };
    // Of room for eight samples three are used.
    let dynamic: MovingHorizonEstimator<_, f64, Dyn, Dyn, Dyn, Dyn, 8> =
        MovingHorizonEstimator::new(plant.to_dynamic(), noises, horizon, 0.1, 2)
            .and_then(|free| {
                free.with_bounds(DVector::from_element(2, f64::NEG_INFINITY), DVector::from_vec(vec![0.5, 0.3]))
            })
            .unwrap();
    let (u, y) = (Vector1::new(1.0), Vector1::new(2.0));
    let mut one = fixed.initial(0.0, &Vector2::zeros(), &u, &y);
    let mut other =
        dynamic.initial(0.0, &DVector::zeros(2), &DVector::from_element(1, 1.0), &DVector::from_element(1, 2.0));
    for k in 0..8 {
        let t = 0.1 * f64::from(k);
        fixed.step(t, &mut one, &u, &y);
        dynamic.step(t, &mut other, &DVector::from_element(1, 1.0), &DVector::from_element(1, 2.0));
        assert_eq!(one.as_slice(), other.as_slice());
    }
    assert_eq!(SampledObserver::<f64>::dimensions(&dynamic).state, state_length(2, 1, 1, 3));
}

#[test]
fn bad_data_are_errors() {
    fn make<const D: usize, const W: usize>(horizon: Horizon) -> Result<Fixed<Pendulum, 2, 0, 2, D, W>, ObserverError>
    where
        Pendulum: Differentiable<f64, Const<2>, Const<0>, Const<2>>,
    {
        MovingHorizonEstimator::discrete(Pendulum, noises(), horizon, 0.1)
    }
    const STATE: usize = state_length(2, 0, 2, 4);
    let horizon = Horizon { window: 4, iterations: 1 };
    let estimator = make::<STATE, 4>(horizon).unwrap();
    let table = |error: Result<_, ObserverError>| match error.err() {
        Some(ObserverError::Table { what, expected, found }) => (what, expected, found),
        other => panic!("{other:?}"),
    };
    assert_eq!(table(make::<STATE, 3>(horizon).map(|_| ())), ("samples in the window", 3, 4));
    assert_eq!(table(make::<STATE, 4>(Horizon { iterations: 0, ..horizon }).map(|_| ())), ("Gauss-Newton steps", 1, 0));
    assert_eq!(table(make::<7, 4>(horizon).map(|_| ())), ("the dimension of the state of the estimator", STATE, 7));
    assert!(matches!(
        estimator.clone().with_bounds(Vector2::new(0.0, 1.0), Vector2::new(1.0, 1.0)),
        Err(ObserverError::Box { axis: 1, lower: 1.0, upper: 1.0 })
    ));
    assert!(estimator.with_bounds(Vector2::repeat(f64::NAN), Vector2::zeros()).is_err());
}

/// A log with rows of inputs between those of a sensor: joined predictions are one way, and the window counts samples.
/// On a linear plant the estimate is that of the Kalman filter for every window; without joining, four stages span
/// three rows, and the estimator of a nonlinear plant forgets what its window should hold.
#[test]
fn predictions_without_a_measurement_are_joined() {
    type Moving<S> = MovingHorizonEstimator<S, f64, Dyn, Dyn, Dyn, Dyn, 4>;
    let plant = double_integrator().to_dynamic();
    let noises = || NoiseModel::<f64, Dyn, Dyn> {
        w: dmatrix![0.1, 0.02; 0.02, 0.3],
        v: dmatrix![0.04],
        p0: DMatrix::identity(2, 2),
    };
    let horizon = Horizon { window: 4, iterations: 1 };
    let plain = Moving::error_controlled(plant.clone(), noises(), horizon, 0.02).unwrap();
    let joined = plain.clone().with_joined_predictions().unwrap();
    let kalman = ExtendedKalmanFilter::error_controlled(plant, noises(), 0.02).unwrap();
    let start = dvector![0.3, -0.2];
    let (u, none) = (dvector![0.0], dvector![0.0]);
    let mut exact = kalman.initial(0.0, &start, &u, &none);
    let mut state = joined.initial(0.0, &start, &u, &none);
    // What was measured counts; between two measurements lie five to fifty rows, and thirty before the first.
    let mut next = 30;
    let mut samples = 0;
    for k in 0..600 {
        let t = 0.02 * f64::from(k);
        let u = dvector![(3.0 * t).sin()];
        if k == next {
            let y = dvector![t.sin()];
            kalman.measure(t, &mut exact, &u, &y, &[true]).unwrap();
            joined.measure(t, &mut state, &u, &y, &[true]).unwrap();
            next += 5 + (k * 7) % 46;
            samples += 1;
        }
        assert!(kalman.advance(t, &mut exact, &u, 0.02));
        assert!(joined.advance(t, &mut state, &u, 0.02));
        assert!((exact.estimate() - joined.estimate(&state)).amax() < 1e-11, "{k}");
        assert!((exact.covariance() - joined.covariance(&state)).amax() < 1e-11, "{k}");
    }
    assert!(samples > 15);
    assert!(plain.initial(0.0, &start, &u, &none).len() < state.len());
}
