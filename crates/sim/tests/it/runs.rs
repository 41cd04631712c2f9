//! Runs as a whole: accuracy against closed forms and between integrators, the paper's Example 1, stiff starts,
//! blow-up, sampled data, noise, feedback, and bad input.

use std::time::{Duration, Instant};

use approx::assert_abs_diff_eq;
use approx::assert_relative_eq;
use luenberger_observers::{
    CubicObserver, LinearObserver, Observer, ObserverDimensions, SampledCubicGains, SampledCubicObserver,
};
use luenberger_plants::linear::StaticPlant;
use luenberger_plants::{LinearPlant, StateSpace, double_integrator, third_order};
use luenberger_sim::{
    Integrand, Integrator, Noise, Scenario, Sensor, Settings, Signal, SimError, Trajectory, View, metrics, solve,
};
use nalgebra::{DMatrix, Matrix1, Matrix2, RowVector2, Vector1, Vector2, Vector3, dmatrix};

/// L of Example 1 for the poles -2, -5.
fn l() -> Vector2<f64> {
    Vector2::new(7.0, 10.0)
}

/// P of Example 1: F'P + PF = -10 I, by hand (110/14, -5, 30/7).
fn p() -> Matrix2<f64> {
    Matrix2::new(55.0 / 7.0, -5.0, -5.0, 30.0 / 7.0)
}

/// N = -gamma P^-1 C' theta with theta = 10.
fn n(gamma: f64) -> Vector2<f64> {
    let p = p();
    // First column of P^-1.
    Vector2::new(p[(1, 1)], -p[(1, 0)]) / p.determinant() * (-10.0 * gamma)
}

fn linear() -> LinearObserver<f64, nalgebra::Const<2>, nalgebra::Const<1>, nalgebra::Const<1>> {
    LinearObserver::of(double_integrator(), l()).unwrap()
}

fn cubic() -> CubicObserver<f64, nalgebra::Const<2>, nalgebra::Const<1>, nalgebra::Const<1>> {
    CubicObserver::of(double_integrator(), l(), n(2.0), Matrix1::new(10.0)).unwrap()
}

fn example1(size: f64, integrator: Integrator) -> Result<Trajectory, SimError> {
    Scenario::new(double_integrator())
        .initial_state(&[-size, -size])
        .input(Signal::scalar(f64::sin))
        .observer("linear", linear(), &[0.0, 0.0])
        .observer("cubic", cubic(), &[0.0, 0.0])
        .integral("j", Integrand::squared_error("cubic"))
        .until(4.0, 401)
        .integrator(integrator)
        .run()
}

/// Largest difference between two matrices, relative to the larger of 1 and the largest entry.
fn difference(a: &DMatrix<f64>, b: &DMatrix<f64>) -> f64 {
    (a - b).amax() / a.amax().max(1.0)
}

#[test]
fn example_1_gives_the_printed_peaks_and_settling_times() {
    let run = example1(3.0, Integrator::Auto).unwrap();
    let measure = |name: &str| {
        let e2 = run.error_trace(name, 1).unwrap();
        (metrics::overshoot(&e2).unwrap(), metrics::settling_last(&e2, 0.05).unwrap())
    };
    let (peak, settling) = measure("cubic");
    // 0.4852, printed as 0.48; 1.655 s, printed as 1.7.
    assert!((peak.value - 0.48).abs() < 0.006 && (settling - 1.7).abs() < 0.05, "{peak:?} {settling}");
    let (peak, settling) = measure("linear");
    // 1.1906, printed as 1.18; see the closed form below.
    assert!((peak.value - 1.19).abs() < 0.005 && (settling - 2.3).abs() < 0.05, "{peak:?} {settling}");
}

#[test]
fn crossings_and_extrema_of_a_linear_error_match_the_closed_form() {
    // e' = F e with eigenvalues -2, -5 and e(0) = -3 (1, 1): e2 = a e^{-2t} + b e^{-5t}, a + b = -3, e2'(0) = 30.
    let (a, b) = (5.0, -8.0);
    let run = example1(3.0, Integrator::Auto).unwrap();
    let e2 = run.error_trace("linear", 1).unwrap();
    for k in 0..=40 {
        let t = 0.1 * f64::from(k);
        assert_abs_diff_eq!(e2.at(t).unwrap(), a * (-2.0 * t).exp() + b * (-5.0 * t).exp(), epsilon = 1e-9);
    }
    let zero = (8f64 / 5.0).ln() / 3.0;
    assert_abs_diff_eq!(e2.first_sign_change().unwrap(), zero, epsilon = 1e-10);
    let summit = 4f64.ln() / 3.0;
    let overshoot = metrics::overshoot(&e2).unwrap();
    assert_abs_diff_eq!(overshoot.value, a * (-2.0 * summit).exp() + b * (-5.0 * summit).exp(), epsilon = 1e-9);
    assert!((overshoot.time - summit).abs() < 1e-5, "a summit is flat: its time is good to the root of its value");
    // The last |e2| = 0.05, by Newton on the closed form.
    let mut t = 2.3;
    for _ in 0..20 {
        let (value, slope) = (
            a * f64::exp(-2.0 * t) + b * f64::exp(-5.0 * t) - 0.05,
            -2.0 * a * f64::exp(-2.0 * t) - 5.0 * b * f64::exp(-5.0 * t),
        );
        t -= value / slope;
    }
    assert_abs_diff_eq!(metrics::settling_last(&e2, 0.05).unwrap(), t, epsilon = 1e-8);
    assert!(metrics::settling_first(&e2, 0.05).unwrap() < zero);
    assert_eq!(metrics::settling_last(&e2, 1e-9), None);
    assert_eq!(metrics::peak(&e2).unwrap().value, 3.0);
}

#[test]
fn integrators_agree() {
    for size in [3.0, 1000.0] {
        let runs = [Integrator::Explicit, Integrator::Implicit, Integrator::Auto].map(|i| example1(size, i).unwrap());
        for run in &runs[1..] {
            for k in 0..2 {
                let difference = difference(&runs[0].observers[k].error, &run.observers[k].error);
                assert!(difference < 1e-9, "e(0) = {size}, observer {k}: {difference:e}");
            }
            let (a, b) = (runs[0].integral("j").unwrap()[400], run.integral("j").unwrap()[400]);
            assert_relative_eq!(a, b, max_relative = 1e-9);
        }
    }
}

#[test]
fn static_and_dynamic_observers_mix_in_one_run() {
    let plant = double_integrator().to_dynamic();
    let dynamic = CubicObserver::of(
        plant.clone(),
        DMatrix::from_column_slice(2, 1, l().as_slice()),
        DMatrix::from_column_slice(2, 1, n(2.0).as_slice()),
        DMatrix::from_element(1, 1, 10.0),
    );
    let run = Scenario::new(plant)
        .initial_state(&[-3.0, -3.0])
        .observer("dynamic", dynamic.unwrap(), &[0.0, 0.0])
        .observer("static", cubic(), &[0.0, 0.0])
        .until(2.0, 21)
        .run()
        .unwrap();
    // The sums are formed in the same order but by different kernels.
    assert!(difference(&run.observers[0].error, &run.observers[1].error) < 1e-12);
}

#[test]
fn an_integral_is_the_integral() {
    // int_0^inf |e|^2 of a linear error is e0' X e0 with F'X + XF = -I: here X = P/10.
    let run = Scenario::new(double_integrator())
        .initial_state(&[-3.0, -3.0])
        .observer("linear", linear(), &[0.0, 0.0])
        .integral("j", Integrand::squared_error("linear"))
        .integral("j2", Integrand::squared_error_of("linear", 1))
        .integral("custom", Integrand::custom(|view| view.error("linear").map_or(f64::NAN, |e| e[1] * e[1])))
        .until(12.0, 121)
        .run()
        .unwrap();
    let e0 = Vector2::new(-3.0, -3.0);
    let exact = e0.dot(&(p() * e0)) / 10.0;
    assert_relative_eq!(run.integral("j").unwrap()[120], exact, max_relative = 1e-9);
    assert_eq!(run.integral("j2").unwrap(), run.integral("custom").unwrap());
    let v = metrics::lyapunov(&run, "linear", &DMatrix::from_column_slice(2, 2, p().as_slice())).unwrap();
    assert!(v.windows(2).all(|v| v[1] < v[0]));
}

#[test]
fn blow_up_of_a_scalar_cubic_is_located() {
    // e' = 4 e^3: e^2 = 1/(1/e0^2 - 8 t), gone at 1/(8 e0^2).
    for (e0, integrator) in [
        (1.0, Integrator::Explicit),
        (1.0, Integrator::Implicit),
        (0.5, Integrator::Auto),
        (1000.0, Integrator::Auto),
        (1e-3, Integrator::Auto),
    ] {
        let settings = Settings { integrator, ..Settings::default() };
        let error = solve(|_, e, slope| slope[0] = 4.0 * e[0].powi(3), 0.0, 1e9, &[e0], &settings).unwrap_err();
        let exact = 1.0 / (8.0 * e0 * e0);
        match error {
            SimError::BlowUp { time, norm } => {
                assert!((time / exact - 1.0).abs() < 1e-9, "{time} {exact} {integrator:?}");
                assert!(norm > 1e3 * e0);
            }
            other => panic!("{other}"),
        }
    }
}

#[test]
fn exponential_growth_is_no_blow_up() {
    let growth = solve(|_, x, slope| slope[0] = 3.0 * x[0], 0.0, 30.0, &[1.0], &Settings::default()).unwrap();
    assert_relative_eq!(growth.at(30.0).unwrap()[0].ln(), 90.0, max_relative = 1e-9);
}

#[test]
fn a_kink_that_cannot_be_passed_is_named() {
    // x' = -1/x reaches 0 at t = 1/2 with infinite slope, but without growing.
    let error = solve(|_, x, slope| slope[0] = -1.0 / x[0], 0.0, 1.0, &[1.0], &Settings::default()).unwrap_err();
    match error {
        SimError::Singular { time, index: 0, .. } => assert!((time - 0.5).abs() < 1e-6),
        other => panic!("{other}"),
    }
}

/// Beside x2' = -1/x2, x1 has grown by more than a thousand when the step size vanishes, and goes on slowly: this is no
/// blow-up.
#[test]
fn a_large_state_beside_a_kink_does_not_blow_up() {
    let beside = |_: f64, x: &[f64], slope: &mut [f64]| slope.copy_from_slice(&[2.2e3, -1.0 / x[1]]);
    let error = solve(beside, 0.0, 1.0, &[1.0, 1.0], &Settings::default()).unwrap_err();
    assert!(matches!(error, SimError::StepSize { time, .. } if (time - 0.5).abs() < 1e-6), "{error}");
}

/// x' = -(1 + sqrt x) leaves the domain of its right-hand side at t = 2 (1 - ln 2): the state there is named, and no
/// NaN comes out.
#[test]
fn a_state_without_a_slope_is_named() {
    let falling = |_: f64, x: &[f64], slope: &mut [f64]| slope[0] = -(1.0 + x[0].sqrt());
    let end = 2.0 * (1.0 - std::f64::consts::LN_2);
    for integrator in [Integrator::Auto, Integrator::Explicit, Integrator::Implicit] {
        let error = solve(falling, 0.0, 1.0, &[1.0], &Settings { integrator, ..Settings::default() }).unwrap_err();
        match &error {
            SimError::NotDefined { time, index: 0, value, state } => {
                assert!((time - end).abs() < 1e-6 && value.is_nan() && state[0] < 0.0 && state[0] > -1e-6, "{error}");
            }
            other => panic!("{other}"),
        }
    }
    // At the start, too.
    let error = solve(falling, 0.0, 1.0, &[-2.0], &Settings::default()).unwrap_err();
    assert!(error.to_string().contains("at the state [-2.0]"), "{error}");
}

#[test]
fn a_stiff_plant_is_finished_implicitly() {
    // x' = -1e6 (x - cos t): explicit steps would be a few microseconds long for 10 s.
    let stiff = |t: f64, x: &[f64], slope: &mut [f64]| slope[0] = -1e6 * (x[0] - t.cos());
    let settings = Settings { max_steps: 50_000, ..Settings::default() };
    let solution = solve(stiff, 0.0, 10.0, &[0.0], &settings).unwrap();
    // x = cos t + 1e-6 sin t + O(1e-12)
    assert_abs_diff_eq!(solution.at(10.0).unwrap()[0], 10f64.cos() + 1e-6 * 10f64.sin(), epsilon = 1e-9);
    let explicit = Settings { integrator: Integrator::Explicit, ..settings };
    assert!(matches!(solve(stiff, 0.0, 10.0, &[0.0], &explicit), Err(SimError::TooManySteps { steps: 50_000, .. })));
}

/// Robertson's reactions at t = 40. scipy 1.17, `solve_ivp` with rtol 1e-12: Radau, BDF and LSODA agree to 2e-11.
#[test]
fn robertsons_reactions_are_those_of_scipy() {
    let reactions = |_: f64, x: &[f64], slope: &mut [f64]| {
        let (slow, fast, faster) = (0.04 * x[0], 1e4 * x[1] * x[2], 3e7 * x[1] * x[1]);
        slope.copy_from_slice(&[fast - slow, slow - fast - faster, faster]);
    };
    let settings = Settings { integrator: Integrator::Implicit, rtol: 1e-9, atol: 1e-13, ..Settings::default() };
    let found = solve(reactions, 0.0, 40.0, &[1.0, 0.0, 0.0], &settings).unwrap().at(40.0).unwrap();
    for (found, expected) in found.iter().zip([0.715_827_068_7, 9.185_534_765e-6, 0.284_163_745_7]) {
        // Some hundred steps, each within the tolerance.
        assert_relative_eq!(*found, expected, max_relative = 1e-8);
    }
}

/// No step starts after the time limit: this one is over at once, and the one of an hour changes nothing.
#[test]
fn a_run_ends_at_its_time_limit() {
    let run = |end: Instant| {
        Scenario::new(double_integrator())
            .initial_state(&[1.0, 0.0])
            .observer("linear", LinearObserver::of(double_integrator(), l()).unwrap(), &[0.0, 0.0])
            .until(4.0, 11)
            .settings(Settings { end: Some(end), ..Settings::default() })
            .run()
    };
    let error = run(Instant::now()).unwrap_err();
    assert!(matches!(error, SimError::TimeLimit { time: 0.0 }) && error.ends_run(), "{error}");
    assert_eq!(error.to_string(), "stopped at t = 0 by the time limit");
    assert!(run(Instant::now() + Duration::from_secs(3600)).is_ok());
}

#[test]
fn the_printed_sign_of_example_3_blows_up() {
    let plant = third_order::example3();
    let l = Vector3::new(0.267, -1.429, 3.904);
    let k = DMatrix::from_row_slice(2, 3, &[-0.597, 2.004, 2.511, -0.197, 0.757, 7.510]);
    let scenario = |sign: f64, integrator: Integrator| {
        let observer = CubicObserver::of(plant.clone(), l, l * (10.0 * sign), Matrix1::new(10.0)).unwrap();
        Scenario::new(plant.clone())
            .initial_state(&[1.0, 1.0, 1.0])
            .observer("cubic", observer, &[0.0, 0.0, 0.0])
            .input(Signal::feedback("cubic", k.clone()))
            .integral("cost", Integrand::quadratic_cost(DMatrix::identity(3, 3), DMatrix::identity(2, 2)))
            .until(30.0, 301)
            .integrator(integrator)
            .run()
    };
    let run = scenario(-1.0, Integrator::Auto).unwrap();
    // The slowest pole of A - L C is near -0.12: e^-3.6 of what the slow mode had at the start.
    assert!(run.observers[0].error.row(300).amax() < 0.05, "{}", run.observers[0].error.row(300));
    let cost = run.integral("cost").unwrap();
    assert!(cost.windows(2).all(|cost| cost[1] >= cost[0]));
    let implicit = scenario(-1.0, Integrator::Implicit).unwrap();
    assert_relative_eq!(cost[300], implicit.integral("cost").unwrap()[300], max_relative = 1e-9);
    match scenario(1.0, Integrator::Auto) {
        Err(SimError::BlowUp { time, .. }) => assert!(time > 0.0 && time < 1e-2),
        other => panic!("{:?}", other.map(|run| run.steps)),
    }
}

#[test]
fn a_sampled_observer_converges_where_eulers_step_diverges() {
    let (h, c) = (1e-3, RowVector2::new(1.0, 0.0));
    let (ad, bd) = (Matrix2::new(1.0, h, 0.0, 1.0), Vector2::new(h * h / 2.0, h));
    // Poles of Ad - Ld C at exp(-2h), exp(-5h): trace and determinant of [[1 - l1, h], [-l2, 1]].
    let (z1, z2) = (f64::exp(-2.0 * h), f64::exp(-5.0 * h));
    let ld = Vector2::new(2.0 - z1 - z2, (1.0 - z1) * (1.0 - z2) / h);
    let discrete = luenberger_linalg::stein(
        &DMatrix::from_column_slice(2, 2, (ad - ld * c).as_slice()),
        &(DMatrix::identity(2, 2) * (10.0 * h)),
    )
    .unwrap();
    let p = Matrix2::from_column_slice(discrete.p.as_slice());
    let n = Vector2::new(p[(1, 1)], -p[(1, 0)]) / p.determinant() * -20.0;
    let theta = Matrix1::new(10.0);
    let observer = SampledCubicObserver::new(SampledCubicGains {
        ad,
        bd,
        c,
        ld,
        n,
        theta,
        w: luenberger_observers::cubic::rate(&c, &n),
        period: h,
    })
    .unwrap();
    let run = Scenario::new(double_integrator())
        .initial_state(&[100.0, 100.0])
        .input(Signal::scalar(f64::sin))
        .hold_input(h)
        .sampled_observer("sampled", observer, &[0.0, 0.0])
        .until(8.0, 8001)
        .run()
        .unwrap();
    let v = metrics::lyapunov(&run, "sampled", &discrete.p).unwrap();
    // Up to rounding in x - xhat: V is quadratic in an error that carries eps |x|.
    let rounding = 1e4 * f64::EPSILON * run.x.amax() * p.amax();
    assert!(v.windows(2).all(|v| v[1].sqrt() <= v[0].sqrt() + rounding), "V must never increase");
    assert!(run.observers[0].error.row(8000).amax() < 1e-3, "{}", run.observers[0].error.row(8000));

    // Euler's step of the continuous observer from the same start.
    let (continuous, mut xhat) = (cubic(), Vector2::zeros());
    for k in 0..5 {
        let y = Vector1::new(100.0 + 100.0 * f64::from(k) * h);
        xhat += h * continuous.derivative(0.0, &xhat, &Vector1::zeros(), &y);
    }
    assert!(xhat.norm() > 1e20, "{xhat}");
}

#[test]
fn a_sampled_observer_holds_between_its_samples_and_predicts() {
    let h = 0.25;
    let (ad, bd) = (Matrix2::new(1.0, h, 0.0, 1.0), Vector2::new(h * h / 2.0, h));
    let c = RowVector2::new(1.0, 0.0);
    let observer = SampledCubicObserver::new(SampledCubicGains {
        ad,
        bd,
        c,
        ld: Vector2::new(1.0, 1.0),
        n: Vector2::zeros(),
        theta: Matrix1::new(1.0),
        w: 0.0,
        period: h,
    });
    let run = Scenario::new(double_integrator())
        .initial_state(&[1.0, 2.0])
        .sampled_observer("right from the start", observer.unwrap(), &[1.0, 2.0])
        .times(&[0.0, 0.1, 0.25, 0.4, 0.5])
        .run()
        .unwrap();
    let estimate = &run.observers[0].estimate;
    for (row, wished) in [1.0, 1.0, 1.5, 1.5, 2.0].into_iter().enumerate() {
        assert_abs_diff_eq!(estimate[(row, 0)], wished, epsilon = 1e-12);
    }
}

#[test]
fn noise_reaches_the_observers_only_and_repeats() {
    let noisy = |seed: Option<u64>| {
        let mut scenario = Scenario::new(double_integrator())
            .initial_state(&[1.0, -1.0])
            .input(Signal::sine(&[1.0], 2.0))
            .observer("linear", linear(), &[1.0, -1.0])
            .until(0.5, 51);
        if let Some(seed) = seed {
            scenario = scenario.noise(Noise::uniform(&[0.02], 1e-2, seed));
        }
        scenario.run().unwrap()
    };
    let (clean, one, again, other) = (noisy(None), noisy(Some(1)), noisy(Some(1)), noisy(Some(2)));
    assert_eq!(one, again);
    assert!(difference(&one.x, &clean.x) < 1e-10);
    assert!(difference(&one.observers[0].error, &other.observers[0].error) > 1e-4);
    assert!(clean.observers[0].error.amax() < 1e-10);
}

#[test]
fn crossings_between_the_points_of_one_step_are_found() {
    // (t - 1)^2 - 1e-8 touches zero twice within 2e-4 while the integrator takes a few steps in all.
    let run = Scenario::new(double_integrator())
        .initial_state(&[1.0, -2.0])
        .input(Signal::constant(&[2.0]))
        .until(3.0, 2)
        .run()
        .unwrap();
    let crossings = run.trace(|view| view.x[0]).crossings(1e-8);
    assert_eq!(crossings.len(), 2, "{crossings:?}");
    for (crossing, exact) in crossings.iter().zip([1.0 - 1e-4, 1.0 + 1e-4]) {
        assert_abs_diff_eq!(crossing.time, exact, epsilon = 1e-9);
    }
    assert!(!crossings[0].rising && crossings[1].rising);
    assert!(run.trace(|view| view.x[0]).crossings(-1e-8).is_empty());
}

#[test]
fn a_partial_estimate_is_compared_with_its_states() {
    /// Estimates the speed of the double integrator alone: z' = u - 3 (z + 3 y), x2hat = z + 3 y. Its start needs y.
    struct Speed;
    impl Observer<f64> for Speed {
        type State = Vector1<f64>;
        type Input = Vector1<f64>;
        type Output = Vector1<f64>;
        type Estimate = Vector1<f64>;
        fn dimensions(&self) -> ObserverDimensions {
            ObserverDimensions { state: 1, inputs: 1, outputs: 1, estimate: 1 }
        }
        fn derivative(&self, t: f64, z: &Vector1<f64>, u: &Vector1<f64>, y: &Vector1<f64>) -> Vector1<f64> {
            u - 3.0 * self.estimate(t, z, u, y)
        }
        fn estimate(&self, _: f64, z: &Vector1<f64>, _: &Vector1<f64>, y: &Vector1<f64>) -> Vector1<f64> {
            z + 3.0 * y
        }
        fn initial(&self, _: f64, estimate: &Vector1<f64>, _: &Vector1<f64>, y: &Vector1<f64>) -> Vector1<f64> {
            estimate - 3.0 * y
        }
    }
    let run = Scenario::new(double_integrator())
        .initial_state(&[5.0, 2.0])
        .input(Signal::scalar(f64::sin))
        .partial_observer("speed", Speed, &[0.0], &[1])
        .until(2.0, 21)
        .run()
        .unwrap();
    // e' = -3 e from e(0) = 2.
    for (t, e) in run.t.iter().zip(run.observers[0].error.iter()) {
        assert_abs_diff_eq!(*e, 2.0 * (-3.0 * t).exp(), epsilon = 1e-9);
    }
}

#[test]
fn a_plant_without_inputs_runs() {
    let plant = third_order::example2();
    let l = Vector3::new(1.0, 0.0, 0.0);
    let run = Scenario::new(plant.clone())
        .initial_state(&[1.0, 2.0, 3.0])
        .observer("linear", LinearObserver::of(plant, l).unwrap(), &[1.0, 2.0, 3.0])
        .until(1.0, 3)
        .run()
        .unwrap();
    assert_eq!(run.u.ncols(), 0);
    assert!(run.observers[0].error.amax() < 1e-12);
}

#[test]
fn bad_input_is_an_error() {
    let plant = || double_integrator();
    let base = || Scenario::new(plant()).until(1.0, 3);
    let nan = f64::NAN;
    let length = |result: Result<Trajectory, SimError>| matches!(result, Err(SimError::Length { .. }));
    assert!(length(base().initial_state(&[1.0]).run()));
    assert!(length(base().observer("o", linear(), &[0.0; 3]).run()));
    assert!(length(base().input(Signal::constant(&[1.0, 2.0])).run()));
    assert!(length(base().noise(Noise::uniform(&[1.0, 1.0], 0.1, 0)).run()));
    let wide = StateSpace::new(DMatrix::zeros(2, 2), DMatrix::zeros(2, 2), DMatrix::zeros(1, 2)).unwrap();
    let two_inputs = LinearObserver::of(wide, DMatrix::zeros(2, 1)).unwrap();
    assert!(length(base().observer("o", two_inputs, &[0.0; 2]).run()));
    let one_state: StaticPlant<f64, 1, 1, 1> =
        LinearPlant::new(Matrix1::new(0.0), Matrix1::new(1.0), Matrix1::new(1.0)).unwrap();
    let small = LinearObserver::of(one_state, Matrix1::new(1.0)).unwrap();
    assert!(length(base().observer("o", small, &[0.0]).run()));

    for noise in [Noise::gaussian(&[-0.1], 0.1, 0), Noise::uniform(&[-0.1], 0.1, 0)] {
        assert_eq!(base().noise(noise).run(), Err(SimError::NegativeNoise { index: 0, value: -0.1 }));
    }
    let negative = base().sensor(Sensor::new(0, 0.1).gaussian(-0.1, 1)).run();
    assert_eq!(negative, Err(SimError::NegativeNoise { index: 0, value: -0.1 }));
    assert!(base().noise(Noise::gaussian(&[0.0], 0.1, 0)).run().is_ok());

    let finite = |result: Result<Trajectory, SimError>| matches!(result, Err(SimError::NotFinite { .. }));
    assert!(finite(base().initial_state(&[nan, 0.0]).run()));
    assert!(finite(base().observer("o", linear(), &[0.0, f64::INFINITY]).run()));
    assert!(finite(base().input(Signal::scalar(|_| nan)).run()));
    assert!(finite(base().times(&[0.0, nan]).run()));

    assert!(matches!(Scenario::new(plant()).run(), Err(SimError::TimeSpan { .. })));
    assert!(matches!(base().until(0.0, 5).run(), Err(SimError::TimeSpan { .. })));
    assert!(matches!(base().until(-1.0, 5).run(), Err(SimError::TimeSpan { .. })));
    let unsorted = base().times(&[0.0, 2.0, 1.0, 3.0]).run();
    assert_eq!(unsorted, Err(SimError::TimesUnsorted { index: 2, previous: 2.0, next: 1.0 }));
    assert!(matches!(base().times(&[-1.0, 1.0]).run(), Err(SimError::Outside { .. })));
    assert!(matches!(base().tolerances(0.0, 1e-9).run(), Err(SimError::NotPositive { what: "rtol", .. })));
    assert!(matches!(base().hold_input(-1.0).run(), Err(SimError::NotPositive { .. })));

    let twice = base().observer("o", linear(), &[0.0; 2]).observer("o", cubic(), &[0.0; 2]).run();
    assert_eq!(twice, Err(SimError::DuplicateName { name: "o".to_owned() }));
    let unknown = base().input(Signal::feedback("nobody", DMatrix::zeros(1, 2))).run();
    assert_eq!(unknown, Err(SimError::UnknownName { name: "nobody".to_owned() }));
    assert!(base().run().unwrap().error_trace("nobody", 0).is_err());
    let run = base().observer("o", linear(), &[0.0; 2]).run().unwrap();
    assert!(matches!(run.error_trace("o", 2), Err(SimError::Index { index: 2, count: 2, .. })));
}

/// A scenario is moved into a thread, its trajectory comes back, and it prints what it consists of.
#[test]
fn a_scenario_is_for_threads_and_prints() {
    let mut count = [0u32; 2];
    let gain = 0.5;
    let scenario = Scenario::new(double_integrator())
        .initial_state(&[1.0, 0.0])
        .observer("linear", linear(), &[0.0; 2])
        .input(Signal::function(move |t, u| u.fill(gain * t)))
        .integral("cost", Integrand::custom(|view| view.x[0]))
        .until(1.0, 2);
    let text = format!("{scenario:?}");
    for part in ["plant: Dimensions { states: 2, inputs: 1, outputs: 1 }", "\"linear\"", "Function", "Custom", "rtol"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let alone = scenario.clone().run().unwrap();
    let inside = std::thread::spawn({
        let scenario = scenario.clone();
        move || scenario.run().unwrap()
    });
    std::thread::scope(|scope| {
        for count in &mut count {
            let scenario = &scenario;
            scope.spawn(move || *count = scenario.clone().run().unwrap().t.len() as u32);
        }
    });
    assert_eq!((inside.join().unwrap(), count), (alone, [2, 2]));
}

#[test]
fn an_input_that_depends_on_itself_is_refused() {
    /// An "estimate" with direct feedthrough of the input.
    struct Feedthrough;
    impl Observer<f64> for Feedthrough {
        type State = Vector2<f64>;
        type Input = Vector1<f64>;
        type Output = Vector1<f64>;
        type Estimate = Vector2<f64>;
        fn dimensions(&self) -> ObserverDimensions {
            ObserverDimensions { state: 2, inputs: 1, outputs: 1, estimate: 2 }
        }
        fn derivative(&self, _: f64, _: &Vector2<f64>, _: &Vector1<f64>, _: &Vector1<f64>) -> Vector2<f64> {
            Vector2::zeros()
        }
        fn estimate(&self, _: f64, z: &Vector2<f64>, u: &Vector1<f64>, _: &Vector1<f64>) -> Vector2<f64> {
            z.add_scalar(u[0])
        }
        fn initial(&self, _: f64, estimate: &Vector2<f64>, _: &Vector1<f64>, _: &Vector1<f64>) -> Vector2<f64> {
            *estimate
        }
    }
    let run = Scenario::new(double_integrator())
        .observer("loop", Feedthrough, &[1.0, 1.0])
        .input(Signal::feedback("loop", DMatrix::from_row_slice(1, 2, &[1.0, 0.0])))
        .until(1.0, 3)
        .run();
    assert!(matches!(run, Err(SimError::AlgebraicLoop { .. })), "{run:?}");
}

#[test]
fn dense_output_agrees_with_samples_and_with_more_of_them() {
    let run = example1(3.0, Integrator::Auto).unwrap();
    let e2 = run.error_trace("cubic", 1).unwrap();
    for (k, &t) in run.t.iter().enumerate() {
        assert_abs_diff_eq!(e2.at(t).unwrap(), run.observers[1].error[(k, 1)], epsilon = 1e-12);
    }
    // The order of the interpolant is less than that of the method: against a run with steps ten times shorter.
    let fine = Scenario::new(double_integrator())
        .initial_state(&[-3.0, -3.0])
        .input(Signal::scalar(f64::sin))
        .observer("cubic", cubic(), &[0.0, 0.0])
        .until(4.0, 401)
        .tolerances(1e-13, 1e-14)
        .run()
        .unwrap();
    assert!(difference(&run.observers[1].error, &fine.observers[0].error) < 1e-9);
}

/// `x1' = u`, `x2' = 2 u`, `y = (x1 + x2, x2)` under u = 3: what a view of the run has is each in its place.
#[test]
fn a_view_has_state_input_and_output_in_their_places() {
    let plant = LinearPlant::new(DMatrix::zeros(2, 2), dmatrix![1.0; 2.0], dmatrix![1.0, 1.0; 0.0, 1.0]).unwrap();
    let run = Scenario::new(plant).input(Signal::constant(&[3.0])).until(2.0, 2).run().unwrap();
    let at = |quantity: fn(&View<'_>) -> f64| run.trace(quantity).at(0.5).unwrap();
    let found = [at(|v| v.x[0]), at(|v| v.x[1]), at(|v| v.u[0]), at(|v| v.y[0]), at(|v| v.y[1]), at(|v| v.t)];
    for (found, expected) in found.into_iter().zip([1.5, 3.0, 3.0, 4.5, 3.0, 0.5]) {
        assert_abs_diff_eq!(found, expected, epsilon = 1e-12);
    }
    assert_eq!([at(|v| v.u.len() as f64), at(|v| v.y.len() as f64)], [1.0, 2.0]);
}

/// The merits of a run need nothing named before it, and agree with the integral that is an extra state.
#[test]
fn a_run_has_its_root_mean_square_error_and_its_settling_time() {
    let run = example1(3.0, Integrator::Auto).unwrap();
    let squared = run.integral("j").unwrap().last().copied().unwrap();
    assert!((run.rmse("cubic").unwrap() - (squared / 4.0).sqrt()).abs() < 1e-9);
    let norm = run.error_norm("cubic").unwrap();
    let settled = run.settling_time("cubic", 0.05).unwrap().unwrap();
    assert!((norm.at(settled).unwrap() - 0.05 * 18f64.sqrt()).abs() < 1e-9);
    assert!(matches!(run.rmse("none"), Err(SimError::UnknownName { .. })));
}

/// Comma-separated values are read back as they are, and a name with a comma is one field.
#[test]
fn comma_separated_values_are_the_samples() {
    let run = Scenario::new(double_integrator())
        .initial_state(&[0.1, 1.0 / 3.0])
        .observer("a,b", linear(), &[0.0, 0.0])
        .until(1.0, 3)
        .run()
        .unwrap();
    let text = run.to_csv();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "t,x1,x2,u1,y1,\"a,b.xhat1\",\"a,b.xhat2\"");
    assert_eq!(lines.len(), 4);
    let last: Vec<f64> = lines[3].split(',').map(|value| value.parse().unwrap()).collect();
    let estimate = &run.observers[0].estimate;
    let (x, u, y) = (&run.x, &run.u, &run.y);
    assert_eq!(last, [1.0, x[(2, 0)], x[(2, 1)], u[(2, 0)], y[(2, 0)], estimate[(2, 0)], estimate[(2, 1)]]);
}

/// A copy of a scenario is a scenario of its own.
#[test]
fn a_copied_scenario_runs_alike_and_can_be_changed() {
    let base = Scenario::new(double_integrator()).initial_state(&[1.0, 0.0]).until(1.0, 11);
    assert_eq!(base.clone().run(), base.clone().run());
    let driven = base.clone().input(Signal::constant(&[1.0])).run().unwrap();
    assert!((driven.x[(10, 0)] - 1.5).abs() < 1e-9 && (base.run().unwrap().x[(10, 0)] - 1.0).abs() < 1e-12);
}

/// The estimate of a filter has the measurement, also between its samples; dense output follows it.
#[test]
fn dense_output_follows_the_estimate_of_a_filter() {
    let plant = double_integrator();
    let (ad, bd) = (Matrix2::new(1.0, 0.1, 0.0, 1.0), Vector2::new(0.005, 0.1));
    let model = luenberger_plants::StaticPlant::new(ad, bd, plant.c).unwrap();
    let predictor = luenberger_observers::DiscreteLinearObserver::new(model, Vector2::new(0.7, 0.9), 0.1).unwrap();
    let filter = luenberger_observers::StationaryKalmanFilter::new(predictor, Vector2::new(0.6, 0.9)).unwrap();
    let run = Scenario::new(plant)
        .initial_state(&[1.0, -1.0])
        .sampled_observer("filter", filter, &[0.0, 0.0])
        .until(1.0, 38)
        .run()
        .unwrap();
    let error = run.error_trace("filter", 1).unwrap();
    // At the end the rows have what happens there, the trace has what was before.
    for (k, t) in run.t.iter().enumerate().take(37) {
        assert!((error.at(*t).unwrap() - run.observers[0].error[(k, 1)]).abs() < 1e-12, "{t}");
    }
    let within = |t: f64| error.at(t).unwrap();
    assert!((within(0.31) - within(0.39)).abs() > 1e-3, "the measurement has moved on");
}

/// With x' = u and u = 2 + v for the law's own view v of the input, which is zero, x = 2 t; of x'Qx + u'Ru with Q = 1
/// and R = 3 the integral over [0, 1] is 4/3 + 12. What is no weight, no component and no observer is an error.
#[test]
fn a_cost_is_that_of_state_and_input() {
    let plant = StateSpace::new(dmatrix![0.0], dmatrix![1.0], dmatrix![1.0]).unwrap();
    let observer = LinearObserver::of(plant.clone(), dmatrix![1.0]).unwrap();
    let scenario = Scenario::new(plant)
        .observer("linear", observer, &[0.0])
        .input(Signal::law(|view, u| u[0] = 2.0 + view.u[0]))
        .until(1.0, 2);
    let of = |integrand: Integrand<'static>| scenario.clone().integral("cost", integrand).run();
    let run = of(Integrand::quadratic_cost(dmatrix![1.0], dmatrix![3.0])).unwrap();
    assert_abs_diff_eq!(run.integral("cost").unwrap()[1], 4.0 / 3.0 + 12.0, epsilon = 1e-9);
    let wide = of(Integrand::quadratic_cost(dmatrix![1.0, 0.0], dmatrix![3.0]));
    assert!(matches!(wide, Err(SimError::Length { expected: 1, found: 2, .. })));
    let nan = of(Integrand::quadratic_cost(dmatrix![1.0], dmatrix![f64::NAN]));
    assert!(matches!(nan, Err(SimError::NotFinite { .. })));
    let second = of(Integrand::squared_error_of("linear", 1));
    assert!(matches!(second, Err(SimError::Index { index: 1, count: 1, .. })));
    assert!(matches!(of(Integrand::squared_error("cubic")), Err(SimError::UnknownName { .. })));
}

#[test]
fn spans_and_steps_without_a_length_are_refused() {
    let decay = |_: f64, x: &[f64], slope: &mut [f64]| slope[0] = -x[0];
    for (start, end) in [(0.0, f64::INFINITY), (f64::NEG_INFINITY, 0.0), (f64::NAN, 1.0), (0.0, f64::NAN), (1.0, 1.0)] {
        let refused = solve(decay, start, end, &[1.0], &Settings::default());
        assert!(matches!(refused, Err(SimError::TimeSpan { .. })), "{start} {end}");
    }
    for max_step in [0.0, -1.0, f64::NAN] {
        let refused = solve(decay, 0.0, 1.0, &[1.0], &Settings { max_step, ..Settings::default() });
        assert!(matches!(refused, Err(SimError::NotPositive { what: "max_step", .. })), "{max_step}");
    }
}

/// z' = 1 from 0, and an estimate whose entry is no number from z = 1 on.
struct Ending;

impl Observer<f64> for Ending {
    type State = Vector1<f64>;
    type Input = Vector2<f64>;
    type Output = Vector2<f64>;
    type Estimate = Vector2<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: 1, inputs: 2, outputs: 2, estimate: 2 }
    }

    fn derivative(&self, _t: f64, _z: &Vector1<f64>, _u: &Vector2<f64>, _y: &Vector2<f64>) -> Vector1<f64> {
        Vector1::new(1.0)
    }

    fn estimate(&self, _t: f64, z: &Vector1<f64>, _u: &Vector2<f64>, _y: &Vector2<f64>) -> Vector2<f64> {
        Vector2::new(0.0, (1.0 - z[0]).sqrt())
    }

    fn initial(&self, _t: f64, _xhat: &Vector2<f64>, _u: &Vector2<f64>, _y: &Vector2<f64>) -> Vector1<f64> {
        Vector1::new(0.0)
    }
}

/// x1' = 1, x2' = u1, and two outputs of which the second is this.
fn with_output(second: &str) -> luenberger_expression::ExpressionPlant {
    let none = luenberger_expression::Parameters::new();
    luenberger_expression::ExpressionPlant::new(&["1", "u1"], &["x2", second], 2, &none).unwrap()
}

/// What is not finite from t = 1 on is named with the first point of the step behind it.
#[test]
fn what_is_not_finite_along_a_run_is_named() {
    let settings = Settings { max_step: 0.25, ..Settings::default() };
    let scenario = |second: &str| {
        let scenario = Scenario::new(with_output(second)).initial_state(&[0.0, 0.0]).breakpoints(&[1.0]);
        scenario.settings(settings).until(2.0, 3)
    };
    let plain = || scenario("x1");
    let k = dmatrix![1.0, 0.0; 0.0, 1.0];
    let input = Signal::function(|t, u| u.copy_from_slice(&[0.0, (1.0 - t).sqrt()]));
    for (scenario, name) in [
        (scenario("sqrt(1 - x1)"), "y2"),
        (plain().input(input), "u2"),
        (plain().observer("first", Ending, &[0.0, 0.0]), "xhat2 of \"first\""),
        (plain().functional_observer("second", Ending, &[0.0, 0.0], &k), "zhat2 of \"second\""),
    ] {
        let error = scenario.run().unwrap_err();
        let SimError::QuantityNotFinite { time, what, value } = &error else { panic!("{name}: {error}") };
        assert!(what == name && value.is_nan() && *time > 1.0 - 1e-9 && *time < 1.02, "{name}: {error}");
        assert!(error.ends_run() && error.to_string().starts_with("stopped at t = 1"), "{error}");
    }
}

/// Of x1 = t, x2 = t^2/2 under u = (t, 3), and y = (x2, 4 x1).
#[test]
fn a_trajectory_between_its_rows() {
    let run = Scenario::new(with_output("4*x1"))
        .initial_state(&[0.0, 0.0])
        .input(Signal::function(|t, u| u.copy_from_slice(&[t, 3.0])))
        .noise(Noise::gaussian(&[0.0, 0.5], 10.0, 7))
        .observer("ending", Ending, &[0.0, 0.0])
        .integral("one", Integrand::custom(|_| 1.0))
        .integral("speed", Integrand::custom(|view| view.x[1]))
        .until(0.9, 2)
        .run()
        .unwrap();
    let near = |found: &[f64], expected: &[f64]| {
        assert_eq!(found.len(), expected.len());
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?} {expected:?}");
    };
    let drawn = Noise::gaussian(&[0.0, 0.5], 10.0, 7).sample(luenberger_sim::Purpose::MeasurementNoise, 0)[1];
    for t in [0.0, 0.3, 0.77] {
        near(&run.state_at(t).unwrap(), &[t, t * t / 2.0]);
        near(&run.input_at(t).unwrap(), &[t, 3.0]);
        near(&run.measured_at(t).unwrap(), &[t * t / 2.0, 4.0 * t + drawn]);
        near(&run.observer_state_at("ending", t).unwrap(), &[t]);
        near(&[run.integral_trace("one").unwrap().at(t).unwrap()], &[t]);
        near(&[run.integral_trace("speed").unwrap().at(t).unwrap()], &[t.powi(3) / 6.0]);
    }
    assert!(run.integral_trace("none").is_err() && run.observer_state_at("none", 0.1).is_err());
    let mut times = Vec::new();
    run.visit("ending", |t, x, u, xhat| {
        near(x, &[t, t * t / 2.0]);
        near(u, &[t, 3.0]);
        near(xhat, &[0.0, (1.0 - t).sqrt()]);
        times.push(t);
    })
    .unwrap();
    assert_eq!(times.len(), 8 * run.step_spans().count());
    assert!(run.visit("none", |_, _, _, _| ()).is_err());
}

/// u = (2, -1) sin(3 t) + (1, 0): x2 = 2 (1 - cos 3 t)/3 + t.
#[test]
fn a_sine_and_a_reference() {
    let input = Signal::sine(&[2.0, -1.0], 3.0).plus(|_, r| r.copy_from_slice(&[1.0, 0.0]));
    let run = Scenario::new(with_output("x1")).initial_state(&[0.0, 0.0]).input(input).until(2.0, 2).run().unwrap();
    assert_abs_diff_eq!(run.x[(1, 1)], 2.0 * (1.0 - 6f64.cos()) / 3.0 + 2.0, epsilon = 1e-9);
    assert_abs_diff_eq!(run.u[(1, 0)], 2.0 * 6f64.sin() + 1.0, epsilon = 1e-12);
    assert_abs_diff_eq!(run.u[(1, 1)], -(6f64.sin()), epsilon = 1e-12);
}
