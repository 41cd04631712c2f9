//! The prediction of the filters: against exact solutions of linear plants, stiff or not, and of nonlinear ones.

#![cfg(feature = "dual")]

use luenberger_observers::moving_horizon::{Horizon, StaticMovingHorizonEstimator, state_length};
use luenberger_observers::{
    CovarianceFilter, ExtendedKalmanFilter, KalmanFilter, KalmanModel, NoiseModel, Prediction, SampledObserver,
    SigmaPoints, UnscentedKalmanFilter,
};
use luenberger_plants::{Column, LinearPlant, StaticPlant, plant};
use nalgebra::{Matrix1, Matrix2, Matrix3, RowVector3, SMatrix, SVector, Vector1, Vector2, Vector3};
use proptest::prelude::*;

/// `x' = T diag(modes) T^-1 x + B u`, with its solution over h in closed form.
struct Solved {
    plant: StaticPlant<f64, 3, 1, 1>,
    modes: [f64; 3],
    basis: Matrix3<f64>,
    inverse: Matrix3<f64>,
}

impl Solved {
    /// An orthogonal basis turned by three angles, and scaled: in units of these sizes.
    fn new(modes: [f64; 3], angles: [f64; 3], units: [f64; 3]) -> Self {
        let turn = nalgebra::Rotation3::from_euler_angles(angles[0], angles[1], angles[2]).into_inner();
        let scale = Matrix3::from_diagonal(&Vector3::from(units));
        let (basis, inverse) = (scale * turn, turn.transpose() * scale.try_inverse().unwrap());
        let a = basis * Matrix3::from_diagonal(&Vector3::from(modes)) * inverse;
        let c = RowVector3::new(1.0 / units[0], 0.5 / units[1], 0.2 / units[2]);
        let plant = LinearPlant { a, b: basis * Vector3::new(1.0, 0.5, -0.3), c, d: None };
        Self { plant, modes, basis, inverse }
    }

    /// exp(A h), its integral on B, and int exp(A s) W exp(A' s) ds.
    fn over(&self, h: f64, w: &Matrix3<f64>) -> (Matrix3<f64>, Vector3<f64>, Matrix3<f64>) {
        let integral = |mode: f64| if mode == 0.0 { h } else { (mode * h).exp_m1() / mode };
        let phi = self.basis * Matrix3::from_diagonal(&Vector3::from(self.modes.map(|m| (m * h).exp()))) * self.inverse;
        let gamma =
            self.basis * Matrix3::from_diagonal(&Vector3::from(self.modes.map(integral))) * self.inverse * self.plant.b;
        let inner = self.inverse * w * self.inverse.transpose();
        let inner = Matrix3::from_fn(|i, j| inner[(i, j)] * integral(self.modes[i] + self.modes[j]));
        (phi, gamma, self.basis * inner * self.basis.transpose())
    }
}

const WINDOW: usize = 3;

type Estimator<S> = StaticMovingHorizonEstimator<S, f64, 3, 1, 1, { state_length(3, 1, 1, WINDOW) }, WINDOW>;

/// The largest difference of covariances, relative to the standard deviations, and of estimates relative to them.
fn distance(x: &Vector3<f64>, p: &Matrix3<f64>, exact: &Vector3<f64>, covariance: &Matrix3<f64>) -> f64 {
    let deviation = covariance.diagonal().map(f64::sqrt);
    let of_p = Matrix3::from_fn(|i, j| (p[(i, j)] - covariance[(i, j)]) / (deviation[i] * deviation[j]));
    (x - exact).component_div(&deviation).amax().max(of_p.amax())
}

fn measure<F: CovarianceFilter<f64, State: Clone>>(
    filter: &F,
    t: f64,
    state: &mut F::State,
    u: &F::Input,
    y: &F::Output,
) {
    assert!(filter.measure(t, state, u, y, &[]).is_some());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    /// Extended and unscented filter, and the moving-horizon estimator without bounds, are the Kalman filter of the
    /// exact discretisation: for every period and every W, with stiff, slow and unstable modes, in any units, and with
    /// samples that are missed.
    #[test]
    fn filters_of_linear_plants_are_kalmans(
        fast in -8.0f64..5.0, slow in -3.0f64..1.0, unstable in -1.0f64..0.5, angles in prop::array::uniform3(-3.0f64..3.0),
        units in prop::array::uniform3(-20i32..20), roots in prop::array::uniform9(-1.0f64..1.0), v in 0.01f64..10.0,
        ys in prop::array::uniform8(-1.0f64..1.0), h in -1.0f64..0.3,
    ) {
        let h = 10f64.powf(h);
        let units = units.map(|k| 2f64.powi(k));
        let solved = Solved::new([-10f64.powf(fast), -10f64.powf(slow), unstable], angles, units);
        let root = Matrix3::from_diagonal(&Vector3::from(units)) * Matrix3::from_row_slice(&roots);
        let (w, p0) = (root.columns(0, 2) * root.columns(0, 2).transpose(), root * root.transpose());
        let (w, p0, v) = ((w + w.transpose()) * 0.5, (p0 + p0.transpose()) * 0.5, Matrix1::new(v));
        let (ad, bd, noise) = solved.over(h, &w);
        let noise = (noise + noise.transpose()) * 0.5;
        let plant = &solved.plant;
        let kalman = KalmanFilter::new(KalmanModel { ad, bd, c: plant.c, w: noise, v, p0, period: h }).unwrap();
        let noises = || NoiseModel { w, v, p0 };
        let extended = ExtendedKalmanFilter::error_controlled(plant.clone(), noises(), h).unwrap();
        let sigma = SigmaPoints { alpha: 1.0, beta: 2.0, kappa: 0.0 };
        let unscented = UnscentedKalmanFilter::error_controlled(plant.clone(), noises(), sigma, h).unwrap();
        let horizon = Horizon { window: WINDOW, iterations: 1 };
        let moving = Estimator::error_controlled(plant.clone(), noises(), horizon, h).unwrap();
        let (u, start) = (Vector1::new(0.7), Vector3::from(units) * 0.3);
        let none = Vector1::new(0.0);
        let mut exact = kalman.initial(0.0, &start, &u, &none);
        let mut one = extended.initial(0.0, &start, &u, &none);
        let mut two = unscented.initial(0.0, &start, &u, &none);
        let mut three = moving.initial(0.0, &start, &u, &none);
        // Rounding of a scaling and squaring is epsilon |A| h; another path to the same P has its condition beside it.
        let stiffness = solved.modes.iter().fold(1.0, |most: f64, mode| most.max((mode * h).abs()));
        let tolerance = 1e-11 * (1.0 + 1e-2 * stiffness);
        for (k, y) in ys.into_iter().enumerate() {
            let t = h * k as f64;
            // The fourth and fifth samples are missed: the prediction goes over three periods at once.
            let (skipped, periods) = (k == 3 || k == 4, if k == 2 { 3.0 } else { 1.0 });
            if !skipped {
                let y = Vector1::new(y);
                kalman.update(&mut exact, &u, &y).unwrap();
                measure(&extended, t, &mut one, &u, &y);
                measure(&unscented, t, &mut two, &u, &y);
                measure(&moving, t, &mut three, &u, &y);
            }
            prop_assert!(kalman.predict(&mut exact, &u));
            if !skipped {
                prop_assert!(extended.advance(t, &mut one, &u, h * periods));
                prop_assert!(unscented.advance(t, &mut two, &u, h * periods));
                prop_assert!(moving.advance(t, &mut three, &u, h * periods));
            }
            if k == 2 || k == 3 {
                continue;
            }
            let (x, p) = (exact.estimate(), exact.covariance());
            let of = |found: (Vector3<f64>, Matrix3<f64>)| distance(&found.0, &found.1, &x, &p);
            let distances = [
                of((one.estimate(), one.covariance())),
                of((two.estimate(), two.covariance())),
                of((moving.estimate(&three), moving.covariance(&three))),
            ];
            prop_assert!(distances.into_iter().all(|d| d <= tolerance), "{k}: {distances:?} {:?} {h}", solved.modes);
        }
    }

    /// A fixed number of steps of the classical method converges to the exact prediction, with order 3 at least in Q,
    /// and P stays definite for every number.
    #[test]
    fn fixed_steps_converge(
        modes in prop::array::uniform3(-3.0f64..0.5), angles in prop::array::uniform3(-3.0f64..3.0),
        roots in prop::array::uniform9(-1.0f64..1.0),
    ) {
        let solved = Solved::new(modes, angles, [1.0; 3]);
        let root = Matrix3::from_row_slice(&roots);
        let (w, p0) = (root.columns(0, 1) * root.columns(0, 1).transpose(), Matrix3::zeros());
        let (_, _, noise) = solved.over(0.5, &w);
        let filter = |steps| ExtendedKalmanFilter::new(solved.plant.clone(), NoiseModel { w, v: Matrix1::new(1.0), p0 }, 0.5, steps);
        let error = |steps: usize| {
            let filter = filter(steps).unwrap();
            let u = Vector1::zeros();
            let mut state = filter.initial(0.0, &Vector3::zeros(), &u, &u);
            assert!(filter.predict(0.0, &mut state, &u, 0.5));
            assert!(state.covariance().symmetric_eigenvalues().min() >= -1e-15 * state.covariance().amax());
            (state.covariance() - noise).amax()
        };
        let (coarse, fine) = (error(2), error(8));
        // Four times the steps: 4^3 times less, but for rounding.
        prop_assert!(fine <= coarse / 50.0 + 1e-14, "{coarse} {fine}");
        prop_assert!(coarse <= 0.02 * w.amax());
    }
}

/// A lag of `tau`, integrated once, as in a servo: closed forms for any stiffness.
#[test]
fn a_lag_of_any_time_constant() {
    for lag in [1e3_f64, 1.0, 0.015, 1e-6, 1e-12] {
        let a = Matrix2::new(0.0, 1.0, 0.0, -1.0 / lag);
        let plant = LinearPlant { a, b: Vector2::new(0.0, 1.0 / lag), c: nalgebra::RowVector2::new(1.0, 0.0), d: None };
        let w = Matrix2::new(0.0, 0.0, 0.0, 0.01);
        let noises = NoiseModel { w, v: Matrix1::new(1e-4), p0: Matrix2::zeros() };
        let h = 0.1;
        let filter = ExtendedKalmanFilter::error_controlled(plant.clone(), noises, h).unwrap();
        let u = Vector1::new(2.0);
        let mut state = filter.initial(0.0, &Vector2::new(0.0, -1.0), &u, &Vector1::zeros());
        assert!(filter.predict(0.0, &mut state, &u, h));
        let decay = (-h / lag).exp_m1();
        let x = Vector2::new(2.0 * h + 3.0 * lag * decay, 2.0 - 3.0 * (1.0 + decay));
        // w lag/2 (1 - e^(-2h/lag)), and the variances of the integral.
        let rest = -(-2.0 * h / lag).exp_m1();
        let expected = [
            0.01 * lag * lag * (h + 2.0 * lag * decay + lag * rest / 2.0),
            0.01 * lag * lag * decay * decay / 2.0,
            0.01 * lag * rest / 2.0,
        ];
        let p = state.covariance();
        let tolerance = 1e-13 * (1.0 + 1e-3 * h / lag);
        assert!((state.estimate() - x).amax() < 1e-12 * (1.0 + 1e-3 * h / lag), "{lag}: {} {x}", state.estimate());
        // 1 - e^-x - ... of the first cancels for a slow lag.
        if lag <= 1.0 {
            assert!((p[(0, 0)] / expected[0] - 1.0).abs() < 1e3 * tolerance, "{lag}: {p}");
        }
        assert!((p[(0, 1)] / expected[1] - 1.0).abs() < tolerance, "{lag}: {p} {expected:?}");
        assert!((p[(1, 1)] / expected[2] - 1.0).abs() < tolerance, "{lag}: {p} {expected:?}");
    }
}

/// x' = -x^3 + u, y = x.
struct Drag;

plant!(Drag, (1, 1, 1), |plant, t, x, u| [u[0] - x[0] * x[0] * x[0]], [x[0]]);

/// x1' = -rate (x1 - cos(x2) - t), x2' = x1: a fast mode on a nonlinear plant.
struct Fast(f64);

plant!(
    Fast,
    (2, 0, 1),
    |plant, t, x, u| [nalgebra::convert::<f64, T>(-plant.0) * (x[0] - x[1].cos() - t), x[0]],
    [x[1]]
);

/// Estimate and covariance after a prediction from x, with `P = p I` and `W = w I`.
macro_rules! predicted {
    ($plant:expr, $prediction:expr, $x:expr, $m:literal, ($p:expr, $w:expr), $duration:expr) => {{
        let one = $x * $x.transpose() * 0.0 + SMatrix::identity();
        let noises = NoiseModel { w: one * $w, v: Matrix1::new(1.0), p0: one * $p };
        let filter = ExtendedKalmanFilter::discrete($plant, noises, $duration).unwrap();
        let filter = filter.with_prediction($prediction).unwrap();
        let u = SVector::<f64, $m>::repeat(0.0);
        let mut state = filter.initial(0.0, &$x, &u, &Vector1::new(0.0));
        assert!(filter.predict(0.0, &mut state, &u, $duration));
        (state.estimate(), state.covariance())
    }};
}

/// x' = -x^3 has x(h) = x0 / sqrt(1 + 2 x0^2 h) and Phi = (1 + 2 x0^2 h)^(-3/2); with s = 1 + 2 x0^2 h,
/// Q = w (s^4 - 1) / (8 x0^2 s^3).
#[test]
fn a_nonlinear_plant_with_a_closed_form() {
    for x0 in [1e-3, 0.5, 1.0, 4.0] {
        for h in [1e-6, 0.01, 1.0, 20.0] {
            let (x, p) = predicted!(Drag, Prediction::ErrorControlled, Vector1::new(x0), 1, (0.3, 0.7), h);
            let s = 1.0 + 2.0 * x0 * x0 * h;
            // (s^4 - 1) / (8 x0^2) without cancellation: s - 1 = 2 x0^2 h.
            let grown = h / 4.0 * (s + 1.0) * (s * s + 1.0);
            let exact = 0.3 * s.powi(-3) + 0.7 * grown * s.powi(-3);
            assert!(
                (x[0] * s.sqrt() / x0 - 1.0).abs() < if x0 * x0 * h > 100.0 { 1e-5 } else { 1e-8 },
                "{x0} {h}: {x}"
            );
            assert!(
                (p[0] / exact - 1.0).abs() < if x0 * x0 * h > 100.0 { 1e-5 } else { 1e-6 },
                "{x0} {h}: {p} {exact}"
            );
        }
    }
}

/// x' = cos(x) + t: what follows where the fast mode is at rest.
struct Slow;

plant!(Slow, (1, 0, 1), |plant, t, x, u| [x[0].cos() + t], [x[0]]);

/// x' = x^3.
struct Escape;

plant!(Escape, (1, 0, 1), |plant, t, x, u| [x[0] * x[0] * x[0]], [x[0]]);

/// A plant that is not stiff, one that is somewhat, and one that no explicit method would do: against a great number of
/// classical steps, and where these take too long against the quasi-steady state, which is exact to 1/rate.
#[test]
fn fast_modes_of_nonlinear_plants() {
    let start = Vector2::new(0.4, 0.3);
    for rate in [1.0, 30.0, 900.0, 1e4] {
        let controlled = predicted!(Fast(rate), Prediction::ErrorControlled, start, 0, (0.2, 0.1), 0.5);
        let classical = predicted!(Fast(rate), Prediction::RungeKutta(10_000), start, 0, (0.2, 0.1), 0.5);
        let tolerance = if rate < 1e3 { 1e-7 } else { 1e-5 };
        // The covariance of a fast mode lags by slow/fast.
        let lag = if rate < 1e3 { 0.0 } else { 0.3 / rate };
        assert!((controlled.0 - classical.0).amax() < tolerance, "{rate}: {} {}", controlled.0, classical.0);
        assert!((controlled.1 - classical.1).amax() < tolerance + lag, "{rate}: {} {}", controlled.1, classical.1);
    }
    // x2' = cos(x2) + t to first order, from x2 + x1/rate on.
    let (x, p) = predicted!(Fast(1e9), Prediction::ErrorControlled, start, 0, (0.2, 0.1), 0.5);
    let (slow, variance) = predicted!(Slow, Prediction::RungeKutta(2000), Vector1::new(0.3), 0, (0.2, 0.1), 0.5);
    assert!((x[1] - slow[0]).abs() < 1e-6, "{x} {slow}");
    assert!((x[0] - slow[0].cos() - 0.5).abs() < 1e-6);
    assert!((p[(1, 1)] / variance[0] - 1.0).abs() < 1e-3, "{p} {variance}");
}

/// A prediction that has no end is an answer, and takes a bounded time: x' = x^3 from 1 is infinite at 1/2.
#[test]
fn a_finite_escape_is_reported() {
    let noises = NoiseModel { w: Matrix1::zeros(), v: Matrix1::new(1.0), p0: Matrix1::new(1.0) };
    let filter = ExtendedKalmanFilter::error_controlled(Escape, noises, 1.0).unwrap();
    let u = SVector::<f64, 0>::zeros();
    let mut state = filter.initial(0.0, &Vector1::new(1.0), &u, &Vector1::new(0.0));
    let before = state.clone();
    assert!(!filter.predict(0.0, &mut state, &u, 1.0) && state == before);
    assert!(filter.predict(0.0, &mut state, &u, 0.4));
    filter.step(0.0, &mut state, &u, &Vector1::new(2.0));
    assert!(f64::is_nan(state.estimate()[0]) && state.as_slice().len() == 2);
}
