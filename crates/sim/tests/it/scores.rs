//! Scores at the samples: a sampled observer is not blamed for what happens between them.

use approx::assert_abs_diff_eq;
use luenberger_observers::{KalmanFilter, KalmanModel, LinearObserver, Observer, ObserverDimensions, SampledObserver};
use luenberger_plants::{LinearPlant, double_integrator};
use luenberger_sim::samples::{SampleInterpolation, Samples};
use luenberger_sim::{Comparison, ErrorMetrics, Errors, Scenario, ScoreGrid, SimError, solve};
use nalgebra::{Matrix2, Vector1, Vector2, dmatrix};

/// The deadbeat observer of the double integrator, sampled every half: A = [1 h; 0 1], L = [2; 1/h], (A - L C)^2 = 0.
struct Deadbeat {
    period: f64,
}

impl SampledObserver<f64> for Deadbeat {
    type State = Vector2<f64>;
    type Input = Vector1<f64>;
    type Output = Vector1<f64>;
    type Estimate = Vector2<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: 2, inputs: 1, outputs: 1, estimate: 2 }
    }

    fn period(&self) -> f64 {
        self.period
    }

    fn step(&self, _t: f64, state: &mut Vector2<f64>, _u: &Vector1<f64>, y: &Vector1<f64>) {
        let a = Matrix2::new(1.0, self.period, 0.0, 1.0);
        *state = a * *state + Vector2::new(2.0, 1.0 / self.period) * (y[0] - state[0]);
    }

    fn estimate(&self, state: &Vector2<f64>) -> Vector2<f64> {
        *state
    }

    fn initial(&self, _t: f64, estimate: &Vector2<f64>, _u: &Vector1<f64>, _y: &Vector1<f64>) -> Vector2<f64> {
        *estimate
    }
}

/// Divides by the time that is left until t = 1.
struct Diverging;

impl SampledObserver<f64> for Diverging {
    type State = Vector2<f64>;
    type Input = Vector1<f64>;
    type Output = Vector1<f64>;
    type Estimate = Vector2<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: 2, inputs: 1, outputs: 1, estimate: 2 }
    }

    fn period(&self) -> f64 {
        0.5
    }

    fn step(&self, t: f64, state: &mut Vector2<f64>, _u: &Vector1<f64>, _y: &Vector1<f64>) {
        state[1] = 1.0 / (1.0 - t);
    }

    fn estimate(&self, state: &Vector2<f64>) -> Vector2<f64> {
        *state
    }

    fn initial(&self, _t: f64, estimate: &Vector2<f64>, _u: &Vector1<f64>, _y: &Vector1<f64>) -> Vector2<f64> {
        *estimate
    }
}

const X0: [f64; 2] = [1.0, 1.0];

/// From e(0) = (1, 1) the errors at the samples are (1, 1), (-1/2, -1), 0, 0, ... exactly. Held until the next sample
/// the position lags by the velocity times the period, 1/2, for ever.
#[test]
fn a_sampled_observer_is_scored_at_its_samples() {
    let run = Scenario::new(double_integrator())
        .initial_state(&X0)
        .sampled_observer("deadbeat", Deadbeat { period: 0.5 }, &[0.0, 0.0])
        .until(3.0, 2)
        .run()
        .unwrap();
    assert_eq!(run.score_grid().unwrap(), ScoreGrid::Samples { period: 0.5 });
    let held = run.error_norm("deadbeat").unwrap();
    assert_abs_diff_eq!(held.last(), 0.5, epsilon = 1e-9);
    let merits = ErrorMetrics::of(&run, "deadbeat", 0.05).unwrap();
    assert!(merits.last < 1e-12, "{merits:?}");
    assert_eq!((merits.settling_first, merits.settling_last), (Some(1.0), Some(1.0)));
    assert_abs_diff_eq!(merits.peak, 2f64.sqrt(), epsilon = 1e-12);
    // Seven samples.
    assert_abs_diff_eq!(merits.rmse, (3.25f64 / 7.0).sqrt(), epsilon = 1e-12);
    assert_abs_diff_eq!(run.rmse("deadbeat").unwrap(), merits.rmse, epsilon = 0.0);
    assert_eq!(run.settling_time("deadbeat", 0.05).unwrap(), Some(1.0));
    for band in [-1.0, 0.0, f64::NAN, f64::INFINITY] {
        let refused = |found: Result<_, SimError>| matches!(found, Err(SimError::NotPositive { value, .. }) if value.to_bits() == band.to_bits());
        assert!(refused(run.settling_time("deadbeat", band).map(|_| ())));
        assert!(refused(ErrorMetrics::of(&run, "deadbeat", band).map(|_| ())));
        let errors = Errors::of(&run, "deadbeat", ScoreGrid::Samples { period: 0.5 }).unwrap();
        assert!(refused(errors.norm(None, band).map(|_| ())));
    }
    let position = Errors::of(&run, "deadbeat", ScoreGrid::Samples { period: 0.5 }).unwrap().state(0).unwrap();
    assert_abs_diff_eq!(position.rmse, (1.25f64 / 7.0).sqrt(), epsilon = 1e-12);
    assert_eq!(run.state_scores("deadbeat").unwrap()[0], position);
    assert!(matches!(run.state_scores("none"), Err(SimError::UnknownName { .. })));
    assert_abs_diff_eq!(position.overshoot, 0.5, epsilon = 1e-12);
    assert_eq!((position.initial, position.peak), (1.0, 1.0));
    assert_eq!((position.settling_5, position.settling_2), (Some(1.0), Some(1.0)));
}

/// One sampled observer in a comparison, and the continuous one beside it has the same grid: e' = F e with the poles -1
/// and -2 from e(0) = (1, 1) is known at every sample.
#[test]
fn one_sampled_observer_puts_all_on_its_grid() {
    let plant = double_integrator();
    let (deadbeat, linear) =
        (Deadbeat { period: 0.5 }, LinearObserver::of(plant.clone(), Vector2::new(3.0, 2.0)).unwrap());
    let comparison = Comparison::new(Scenario::new(&plant).initial_state(&X0).until(3.0, 2), &[0.0, 0.0])
        .observer("linear", &linear)
        .sampled_observer("deadbeat", &deadbeat);
    let table = comparison.clone().run().unwrap();
    assert_eq!(table.grid, ScoreGrid::Samples { period: 0.5 });
    let text = table.to_string();
    assert!(text.contains("Scores at the samples, every 0.5\n"), "{text}");
    // F = [-3 1; -2 0]; eigenvectors (1, 1) of -2 and (1, 2) of -1, and e(0) = (1, 1) is the first: e = e^-2t (1, 1).
    let row = table.row("linear").unwrap();
    let squares: f64 = (0..=6).map(|k| 2.0 * (-4.0 * 0.5 * f64::from(k)).exp()).sum();
    assert_abs_diff_eq!(row.outcome.clone().unwrap().rmse, (squares / 7.0).sqrt(), epsilon = 1e-9);
    assert_abs_diff_eq!(row.states[1].last, (-6f64).exp(), epsilon = 1e-9);
    // ln 20 / 2 = 1.498: the first sample after it.
    assert_eq!((row.states[0].settling_5, row.states[0].overshoot), (Some(1.5), 0.0));
    assert!(table.row("deadbeat").unwrap().outcome.clone().unwrap().last < 1e-12);
    // In units of the scale [1, 2] the norm at the start is |(1, 1/2)|.
    let scaled = comparison.clone().scale(&[1.0, 2.0]).run().unwrap();
    assert_abs_diff_eq!(scaled.initial_error, 1.25f64.sqrt(), epsilon = 1e-15);
    assert_abs_diff_eq!(scaled.row("linear").unwrap().outcome.clone().unwrap().peak, 1.25f64.sqrt(), epsilon = 1e-12);
    assert!(scaled.to_string().contains("norm in units of scale = [1.0, 2.0]"));
    assert!(matches!(comparison.clone().scale(&[1.0, 0.0]).run(), Err(SimError::NotPositive { .. })));
    assert!(matches!(comparison.scale(&[1.0]).run(), Err(SimError::Length { .. })));
}

/// Without a sampled observer the integral is exact: of e^-4t over [0, 3].
#[test]
fn without_a_sampled_observer_scores_are_those_of_continuous_time() {
    let plant = double_integrator();
    let linear = LinearObserver::of(plant.clone(), Vector2::new(3.0, 2.0)).unwrap();
    let table = Comparison::new(Scenario::new(&plant).initial_state(&X0).until(3.0, 2), &[0.0, 0.0])
        .observer("linear", &linear)
        .run()
        .unwrap();
    assert_eq!(table.grid, ScoreGrid::Continuous);
    let velocity = table.row("linear").unwrap().states[1];
    assert_abs_diff_eq!(velocity.rmse, ((1.0 - (-12f64).exp()) / 4.0 / 3.0).sqrt(), epsilon = 1e-9);
    assert_abs_diff_eq!(velocity.settling_2.unwrap(), 50f64.ln() / 2.0, epsilon = 1e-8);
    assert!(table.to_string().contains("Scores in continuous time\n"));
}

/// Two periods: the grid is their least common multiple, or one that is asked for, or an error.
#[test]
fn several_periods_have_common_multiples() {
    let plant = double_integrator();
    let (slow, fast, odd) =
        (Deadbeat { period: 0.5 }, Deadbeat { period: 0.2 }, Deadbeat { period: 0.1 * 2f64.sqrt() });
    let of = |other| {
        Comparison::new(Scenario::new(&plant).initial_state(&X0).until(12.0, 2), &[0.0, 0.0])
            .sampled_observer("slow", &slow)
            .sampled_observer("other", other)
    };
    let table = of(&fast).run().unwrap();
    assert_eq!(table.grid.period(), Some(1.0));
    assert!(table.rows.iter().all(|row| row.outcome.clone().unwrap().last < 1e-12), "{table}");
    let error = of(&odd).run().unwrap_err();
    assert!(error.to_string().contains("have no common multiple that occurs ten times in a run of 12"), "{error}");
    // Each at its last sample up to the instants asked for: no estimate is compared with a later state.
    let table = of(&odd).score_period(0.7).run().unwrap();
    assert!(table.rows.iter().all(|row| row.outcome.clone().unwrap().last < 1e-12), "{table}");
    let error = of(&odd).score_period(0.3).run().unwrap_err();
    assert!(matches!(error, SimError::ScorePeriod { .. }), "{error}");
}

/// An error that starts at 0 has no settling time: no band is within 5 % of nothing.
#[test]
fn an_error_that_starts_at_zero_does_not_settle() {
    let plant = double_integrator();
    let linear = LinearObserver::of(plant.clone(), Vector2::new(3.0, 2.0)).unwrap();
    let run =
        Scenario::new(&plant).initial_state(&X0).observer("linear", &linear, &[1.0, 0.0]).until(6.0, 2).run().unwrap();
    let errors = Errors::of(&run, "linear", ScoreGrid::Continuous).unwrap();
    let position = errors.state(0).unwrap();
    assert!(position.initial == 0.0 && position.peak > 0.1);
    assert_eq!((position.settling_5, position.settling_2), (None, None));
    assert!(errors.state(1).unwrap().settling_5.is_some());
    assert!(matches!(errors.state(2), Err(SimError::Index { index: 2, count: 2, .. })));
}

/// A division by zero is no blow-up: x2' = 1/x1 where x1 falls through 0 at t = 1 and x2 is 37 at most.
#[test]
fn a_division_by_zero_is_named() {
    let falling = |_: f64, x: &[f64], slope: &mut [f64]| (slope[0], slope[1]) = (-1.0, 1.0 / x[0]);
    let error = solve(falling, 0.0, 2.0, &[1.0, 0.0], &luenberger_sim::Settings::default()).unwrap_err();
    match &error {
        SimError::Singular { time, index: 1, value, slope } => {
            assert!((time - 1.0).abs() < 1e-6 && *value < 40.0 && *slope > 1e6, "{error}");
        }
        other => panic!("{other}"),
    }
    assert!(
        error.to_string().starts_with("stopped at t = 1: the derivative of entry 2 is unbounded there ("),
        "{error}"
    );
    assert!(error.to_string().ends_with("as by a division by zero"), "{error}");
}

/// A sampled observer that announces other lengths than its columns have.
struct Misfit;

impl SampledObserver<f64> for Misfit {
    type State = Vector2<f64>;
    type Input = Vector1<f64>;
    type Output = Vector1<f64>;
    type Estimate = Vector2<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: 3, inputs: 1, outputs: 1, estimate: 2 }
    }

    fn period(&self) -> f64 {
        0.5
    }

    fn step(&self, _t: f64, _state: &mut Vector2<f64>, _u: &Vector1<f64>, _y: &Vector1<f64>) {}

    fn estimate(&self, state: &Vector2<f64>) -> Vector2<f64> {
        *state
    }

    fn initial(&self, _t: f64, estimate: &Vector2<f64>, _u: &Vector1<f64>, _y: &Vector1<f64>) -> Vector2<f64> {
        *estimate
    }
}

#[test]
fn a_sampled_observer_of_other_lengths_is_refused() {
    let run = Scenario::new(double_integrator()).sampled_observer("misfit", Misfit, &[0.0, 0.0]).until(1.0, 2).run();
    assert!(matches!(run, Err(SimError::Length { .. })), "{run:?}");
}

/// The same in continuous time; its description is that of its sizes.
struct Continuously;

impl Observer<f64> for Continuously {
    type State = Vector2<f64>;
    type Input = Vector1<f64>;
    type Output = Vector1<f64>;
    type Estimate = Vector2<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: 3, inputs: 1, outputs: 1, estimate: 2 }
    }

    fn derivative(&self, _t: f64, state: &Vector2<f64>, _u: &Vector1<f64>, _y: &Vector1<f64>) -> Vector2<f64> {
        *state
    }

    fn estimate(&self, _t: f64, state: &Vector2<f64>, _u: &Vector1<f64>, _y: &Vector1<f64>) -> Vector2<f64> {
        *state
    }

    fn initial(&self, _t: f64, estimate: &Vector2<f64>, _u: &Vector1<f64>, _y: &Vector1<f64>) -> Vector2<f64> {
        *estimate
    }
}

#[test]
fn an_observer_in_continuous_time_of_other_lengths_is_refused() {
    let scenario = Scenario::new(double_integrator()).until(1.0, 2);
    let run = scenario.clone().observer("misfit", Continuously, &[0.0, 0.0]).run();
    assert!(matches!(run, Err(SimError::Length { expected: 2, found: 3, .. })), "{run:?}");
    let log = luenberger_sim::Recording::new(vec![0.0, 1.0], dmatrix![0.0; 0.0], dmatrix![0.0; 0.0]).unwrap();
    let replayed = luenberger_sim::Replay::new(double_integrator(), log).observer("misfit", Continuously, &[0.0, 0.0]);
    assert!(matches!(replayed.run(), Err(SimError::Length { expected: 2, found: 3, .. })));
    let described = format!("{:?}", scenario.observer("misfit", Continuously, &[0.0, 0.0]));
    assert!(described.contains("state: 3"), "{described}");
}

/// A sampled observer whose state becomes NaN ends its own run, not the comparison.
#[test]
fn a_sampled_observer_that_is_not_finite_is_a_row() {
    let plant = double_integrator();
    let (broken, deadbeat) = (Diverging, Deadbeat { period: 0.5 });
    let run = Scenario::new(&plant).initial_state(&X0).sampled_observer("broken", &broken, &[0.0, 0.0]);
    let error = run.until(3.0, 2).run().unwrap_err();
    let named = "stopped at t = 1: entry 2 of the state of \"broken\" is inf after this sample";
    assert_eq!(error.to_string(), named);
    let table = Comparison::new(Scenario::new(&plant).initial_state(&X0).until(3.0, 2), &[0.0, 0.0])
        .sampled_observer("broken", &broken)
        .sampled_observer("deadbeat", &deadbeat)
        .run()
        .unwrap();
    assert!(table.to_string().contains(named) && table.row("deadbeat").unwrap().outcome.is_ok(), "{table}");
}

/// x1' = x2, x2' = -w^2 x1 with w = 2 pi, and an observer without correction of it: its error is sin(2 pi t), zero at
/// the samples of the other observer, every 0.5.
#[test]
fn a_peak_between_the_samples_of_another_observer_is_a_peak() {
    let w = std::f64::consts::TAU;
    let plant = LinearPlant::new(dmatrix![0.0, 1.0; -w * w, 0.0], dmatrix![0.0; 0.0], dmatrix![1.0, 0.0]).unwrap();
    let model = KalmanModel {
        ad: dmatrix![-1.0, 0.0; 0.0, -1.0],
        bd: dmatrix![0.0; 0.0],
        c: dmatrix![1.0, 0.0],
        w: dmatrix![0.0, 0.0; 0.0, 0.0],
        v: dmatrix![1.0],
        p0: dmatrix![0.0, 0.0; 0.0, 0.0],
        period: 0.5,
    };
    let open = LinearObserver::of(plant.clone(), dmatrix![0.0; 0.0]).unwrap();
    let run = Scenario::new(plant)
        .initial_state(&[0.0, w])
        .observer("open", open, &[0.0, 0.0])
        .sampled_observer("sampled", KalmanFilter::new(model).unwrap(), &[0.0, 0.0])
        .until(5.0, 11)
        .run()
        .unwrap();
    let grid = run.score_grid().unwrap();
    assert_eq!(grid, ScoreGrid::Samples { period: 0.5 });
    let scores = |name| Errors::of(&run, name, grid).unwrap().state(0).unwrap();
    let open = scores("open");
    assert!((open.peak - 1.0).abs() < 1e-9 && (open.overshoot - 1.0).abs() < 1e-9, "{open:?}");
    assert!(open.rmse < 1e-9 && open.last < 1e-9);
    assert!(scores("sampled").peak < 1e-9);
    // In units of (1, w) the norm is 1 at all times; of the first state alone it would be 0 at the samples.
    let norm = Errors::of(&run, "open", grid).unwrap().norm(Some(&[1.0, 1e9]), 0.05).unwrap();
    assert!((norm.peak - 1.0).abs() < 1e-9 && norm.rmse < 1e-6);
}

/// The speed of the double integrator alone: `w' = -4 w - 16 y + u`, `zhat = w + 4 y`, whose error is exp(-4 t) e(0).
/// It stands between two observers of the state, one of them sampled.
#[test]
fn errors_of_a_function_of_the_state_are_those_of_the_function() {
    use luenberger_observers::FunctionalObserver;
    use nalgebra::matrix;
    let plant = double_integrator();
    let speed = FunctionalObserver::new(matrix![-4.0], matrix![-16.0], matrix![1.0], matrix![4.0]).unwrap();
    let linear = LinearObserver::of(plant.clone(), Vector2::new(7.0, 10.0)).unwrap();
    let scenario = Scenario::new(plant)
        .initial_state(&[0.5, 2.0])
        .observer("linear", linear, &[0.5, 1.0])
        .functional_observer("speed", speed, &[1.0], &dmatrix![0.0, 1.0])
        .sampled_observer("deadbeat", Deadbeat { period: 0.5 }, &[0.0, 0.0])
        .until(2.0, 5);
    let run = scenario.clone().run().unwrap();
    let error = |t: f64| (-4.0 * t).exp();
    let of = run.observer("speed").unwrap();
    for (k, t) in run.t.iter().enumerate() {
        assert_abs_diff_eq!(of.error[(k, 0)], error(*t), epsilon = 1e-9);
        assert_abs_diff_eq!(of.estimate[(k, 0)], run.x[(k, 1)] - error(*t), epsilon = 1e-9);
    }
    assert!(of.states.is_empty());
    assert_abs_diff_eq!(run.error_trace("speed", 0).unwrap().at(0.3).unwrap(), error(0.3), epsilon = 1e-9);
    assert_abs_diff_eq!(run.error_norm("speed").unwrap().at(0.7).unwrap(), error(0.7), epsilon = 1e-9);
    let continuous = Errors::of(&run, "speed", ScoreGrid::Continuous).unwrap().state(0).unwrap();
    assert_abs_diff_eq!(continuous.rmse, ((1.0 - (-16f64).exp()) / 16.0).sqrt(), epsilon = 1e-9);
    let sampled = Errors::of(&run, "speed", ScoreGrid::Samples { period: 0.5 }).unwrap().state(0).unwrap();
    let mean = (0..5).map(|k| error(0.5 * f64::from(k)).powi(2)).sum::<f64>() / 5.0;
    assert_abs_diff_eq!(sampled.rmse, mean.sqrt(), epsilon = 1e-9);
    // The deadbeat observer is exact from its second sample on, whatever stands before it in a row.
    assert_abs_diff_eq!(run.observer("deadbeat").unwrap().error.row(3).amax(), 0.0, epsilon = 1e-9);
    let head = run.to_csv().lines().next().unwrap().to_owned();
    assert_eq!(head, "t,x1,x2,u1,y1,linear.xhat1,linear.xhat2,speed.zhat1,deadbeat.xhat1,deadbeat.xhat2");
    let wide = FunctionalObserver::new(matrix![-4.0], matrix![-16.0], matrix![1.0], matrix![4.0]).unwrap();
    let wrong = scenario.functional_observer("wide", wide, &[1.0], &dmatrix![0.0, 1.0, 0.0]).run().unwrap_err();
    assert!(matches!(wrong, SimError::Length { expected: 2, found: 3, .. }), "{wrong}");
}

#[test]
fn a_common_grid_is_the_least_common_multiple() {
    let period = |periods: &[f64], duration| {
        let periods: Vec<Option<f64>> = periods.iter().map(|period| Some(*period)).collect();
        ScoreGrid::common(&periods, duration).map(ScoreGrid::period)
    };
    assert_eq!(period(&[0.3, 0.1, 0.2], 6.0).unwrap().map(|p| (p * 1e9).round()), Some(6e8));
    assert_eq!(period(&[0.01, 0.01], 0.05).unwrap(), Some(0.01));
    // 0.6 ten times in 6, and not in what is a hundredth shorter.
    assert_eq!(period(&[0.2, 0.3], 6.0).unwrap().map(|p| (p * 1e9).round()), Some(6e8));
    assert!(matches!(period(&[0.2, 0.3], 5.94), Err(SimError::NoCommonGrid { .. })));
    // After 10 s two periods that differ by 0.005 % are half a millisecond apart: they are two.
    for other in [0.100005, 0.300015] {
        assert!(matches!(period(&[0.1, other], 100.0), Err(SimError::NoCommonGrid { .. })), "{other}");
    }
    // Of 21 and 0.97 the least common multiple is 2037: not ten times in 100.
    assert!(matches!(period(&[21.0, 0.97], 100.0), Err(SimError::NoCommonGrid { .. })));
    assert!(matches!(period(&[0.0], 1.0), Err(SimError::NotPositive { .. })));
    assert_eq!(ScoreGrid::Samples { period: 0.01 }.to_string(), "Scores at the samples, every 0.01");
}

/// The time of the run counts from its start: e = e^-2(t-3) (1, 1) from t = 3 to 6, whose integrals are exact.
#[test]
fn a_run_that_starts_later_has_the_same_root_mean_squares() {
    let plant = double_integrator();
    let linear = LinearObserver::of(plant.clone(), Vector2::new(3.0, 2.0)).unwrap();
    let run = Scenario::new(&plant)
        .initial_state(&X0)
        .observer("linear", &linear, &[0.0, 0.0])
        .start(3.0)
        .until(6.0, 2)
        .run()
        .unwrap();
    // sqrt(1/T int e^-4t dt) over [0, 3] and over [1.5, 3].
    let (all, late) = (((1.0 - (-12f64).exp()) / 12.0).sqrt(), (((-6f64).exp() - (-12f64).exp()) / 4.0 / 1.5).sqrt());
    let errors = Errors::of(&run, "linear", ScoreGrid::Continuous).unwrap();
    for state in errors.states().unwrap() {
        assert_abs_diff_eq!(state.rmse, all, epsilon = 1e-9);
        assert_abs_diff_eq!(state.steady_rmse, late, epsilon = 1e-9);
        assert_abs_diff_eq!(state.settling_5.unwrap(), 3.0 + 20f64.ln() / 2.0, epsilon = 1e-8);
    }
    let norm = errors.norm(None, 0.05).unwrap();
    assert_abs_diff_eq!(norm.rmse, 2f64.sqrt() * all, epsilon = 1e-9);
    assert_abs_diff_eq!(norm.steady_rmse, 2f64.sqrt() * late, epsilon = 1e-9);
}

/// Estimates of a state that is 0, such that the errors are these.
struct Script([f64; 5]);

impl SampledObserver<f64> for Script {
    type State = Vector1<f64>;
    type Input = Vector1<f64>;
    type Output = Vector1<f64>;
    type Estimate = Vector1<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: 1, inputs: 1, outputs: 1, estimate: 1 }
    }

    fn period(&self) -> f64 {
        1.0
    }

    fn step(&self, _t: f64, state: &mut Vector1<f64>, _u: &Vector1<f64>, _y: &Vector1<f64>) {
        state[0] += 1.0;
    }

    /// The number of the sample is the state.
    fn estimate(&self, state: &Vector1<f64>) -> Vector1<f64> {
        Vector1::new(-self.0[state[0] as usize])
    }

    fn initial(&self, _t: f64, _estimate: &Vector1<f64>, _u: &Vector1<f64>, _y: &Vector1<f64>) -> Vector1<f64> {
        Vector1::new(0.0)
    }
}

#[test]
fn scores_of_samples() {
    let still = LinearPlant::new(Vector1::new(0.0), Vector1::new(0.0), Vector1::new(1.0)).unwrap();
    let run = Scenario::new(still)
        .sampled_observer("script", Script([-2.0, 1.0, 0.04, -0.2, 0.01]), &[2.0])
        .sampled_observer("constant", Script([1.0; 5]), &[-1.0])
        .until(4.0, 5)
        .run()
        .unwrap();
    let errors = Errors::of(&run, "script", ScoreGrid::Samples { period: 1.0 }).unwrap();
    let state = errors.state(0).unwrap();
    assert_eq!((state.initial, state.last, state.peak, state.overshoot), (-2.0, 0.01, 2.0, 1.0));
    // 5 % and 2 % of 2.
    assert_eq!((state.settling_5, state.settling_2), (Some(4.0), Some(4.0)));
    assert!((state.rmse - (5.0417f64 / 5.0).sqrt()).abs() < 1e-15);
    assert!((state.steady_rmse - (0.0417f64 / 3.0).sqrt()).abs() < 1e-15);
    // A band of 0.1 is entered at the third sample, left at the fourth, and kept from the fifth; one of 0.001 never.
    let settling = |within: f64| {
        let norm = errors.norm(None, within / 2.0).unwrap();
        (norm.settling_first, norm.settling_last)
    };
    assert_eq!(settling(0.1), (Some(2.0), Some(4.0)));
    assert_eq!((settling(0.001), settling(2.0)), ((None, None), (Some(0.0), Some(0.0))));
    let constant = Errors::of(&run, "constant", ScoreGrid::Samples { period: 1.0 }).unwrap();
    assert_eq!(constant.state(0).unwrap().overshoot, 0.0);
}

/// Scores at the samples of a run that starts at t = 3: from e = (1, 1) they are those of a start at 0, three later. On
/// a grid of 0.7 each instant has the last sample up to it: 3, 3.5, 4, ..
#[test]
fn samples_count_from_the_start_of_a_run() {
    let run = Scenario::new(double_integrator())
        .initial_state(&X0)
        .sampled_observer("deadbeat", Deadbeat { period: 0.5 }, &[0.0, 0.0])
        .start(3.0)
        .until(6.0, 2)
        .run()
        .unwrap();
    for (period, samples) in [(0.5, 7.0), (0.7, 5.0)] {
        let errors = Errors::of(&run, "deadbeat", ScoreGrid::Samples { period }).unwrap();
        assert!(!errors.is_empty() && errors.len() == 2);
        let norm = errors.norm(None, 0.05).unwrap();
        assert_abs_diff_eq!(norm.rmse, (3.25f64 / samples).sqrt(), epsilon = 1e-12);
        assert!(norm.last < 1e-12 && norm.initial == 2f64.sqrt());
        // Exact from the third sample on, at t = 4, or from the third instant, 4.4.
        assert_abs_diff_eq!(norm.settling_last.unwrap(), 3.0 + 2.0 * period, epsilon = 1e-12);
    }
}

/// Of nothing no band is a share: an error that starts at 0 and returns to it, or stays there, has no settling time.
#[test]
fn an_error_of_samples_that_starts_at_zero_has_no_settling_time() {
    let still = LinearPlant::new(Vector1::new(0.0), Vector1::new(0.0), Vector1::new(1.0)).unwrap();
    let run = Scenario::new(still)
        .sampled_observer("returns", Script([0.0, 1.0, 0.0, 0.0, 0.0]), &[0.0])
        .sampled_observer("exact", Script([0.0; 5]), &[0.0])
        .until(4.0, 5)
        .run()
        .unwrap();
    for (name, peak) in [("returns", 1.0), ("exact", 0.0)] {
        let errors = Errors::of(&run, name, ScoreGrid::Samples { period: 1.0 }).unwrap();
        let (state, norm) = (errors.state(0).unwrap(), errors.norm(None, 0.05).unwrap());
        assert_eq!((state.initial, state.peak, norm.initial, norm.peak), (0.0, peak, 0.0, peak), "{name}");
        assert_eq!((state.settling_5, state.settling_2), (None, None), "{name}");
        assert_eq!((norm.settling_first, norm.settling_last), (None, None), "{name}");
    }
}

/// A filter of the constant 3 from the estimate 1, with the variances 1 of both: its error is 2 before the first
/// measurement, and 1, 2/3, 1/2 after each.
#[test]
fn the_error_of_a_filter_begins_before_its_first_measurement() {
    let one = dmatrix![1.0];
    let (bd, w) = (nalgebra::DMatrix::zeros(1, 0), dmatrix![0.0]);
    let model = KalmanModel {
        ad: one.clone(),
        bd: bd.clone(),
        c: one.clone(),
        w,
        v: one.clone(),
        p0: one.clone(),
        period: 1.0,
    };
    let run = Scenario::new(LinearPlant::new(dmatrix![0.0], bd, one).unwrap())
        .initial_state(&[3.0])
        .sampled_observer("filter", KalmanFilter::new(model).unwrap(), &[1.0])
        .until(2.0, 3)
        .run()
        .unwrap();
    let errors = Errors::of(&run, "filter", run.score_grid().unwrap()).unwrap();
    let (state, norm) = (errors.state(0).unwrap(), errors.norm(Some(&[2.0]), 0.6).unwrap());
    let near = |found: f64, expected: f64| assert_abs_diff_eq!(found, expected, epsilon = 1e-14);
    near(state.initial, 2.0);
    near(state.peak, 2.0);
    near(state.last, 0.5);
    near(state.rmse, ((1.0 + 4.0 / 9.0 + 0.25) / 3.0f64).sqrt());
    near(norm.initial, 1.0);
    near(norm.peak, 1.0);
    // 0.6 of 2 is reached by the first measurement.
    assert_eq!((norm.settling_first, norm.settling_last), (Some(0.0), Some(0.0)));
    let samples = run.observers[0].at_samples.as_ref().unwrap();
    let places = [0.0, 0.5, 1.0, 1.0 + 1e-12, 2.0 - 1e-12, 1.9].map(|t| samples.at(t));
    assert_eq!(places, [Some(0), None, Some(1), Some(1), Some(2), None]);
}

/// Before its first sample a table is what it is there, held or interpolated; after its last one likewise.
#[test]
fn beyond_its_ends_a_table_holds_its_ends() {
    for between in [SampleInterpolation::ZeroOrderHold, SampleInterpolation::Linear] {
        let table = Samples::new(vec![1.0, 2.0, 4.0], dmatrix![5.0; 7.0; 1.0], between).unwrap();
        let at = |t: f64| {
            let mut value = [f64::NAN];
            table.at(t, &mut value);
            value[0]
        };
        assert_eq!((at(-3.0), at(0.5), at(1.0), at(4.0), at(9.0)), (5.0, 5.0, 5.0, 1.0, 1.0), "{between:?}");
        let middle = if between == SampleInterpolation::Linear { [6.0, 4.0] } else { [5.0, 7.0] };
        assert_eq!([at(1.5), at(3.0)], middle, "{between:?}");
    }
}

/// The rows of a table by hand: n equal parts, or every so many samples, and the end of the run where it is no sample.
#[test]
fn rows_of_a_table_are_samples() {
    use luenberger_sim::row_times;
    let near = |(found, end): (Vec<f64>, Option<f64>), expected: &[f64], rest: Option<f64>| {
        assert_eq!(end, rest);
        assert_eq!(found.len(), expected.len(), "{found:?}");
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        assert!(rest.is_some() || found.last() == expected.last());
    };
    near(row_times(6.0, 4, None), &[0.0, 2.0, 4.0, 6.0], None);
    near(row_times(6.0, 0, None), &[0.0, 6.0], None);
    // 60 samples: of 61 rows all, of 7 every tenth, of 5 every fifteenth, of 6 every twelfth.
    let all: Vec<f64> = (0..=60).map(|k| f64::from(k) / 10.0).collect();
    near(row_times(6.0, 61, Some(0.1)), &all, None);
    near(row_times(6.0, 500, Some(0.1)), &all, None);
    near(row_times(6.0, 7, Some(0.1)), &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0], None);
    // In at most four rows every twentieth; in six every twelfth; in eight every ninth, and the end.
    near(row_times(6.0, 4, Some(0.1)), &[0.0, 2.0, 4.0, 6.0], None);
    near(row_times(6.0, 6, Some(0.1)), &[0.0, 1.2, 2.4, 3.6, 4.8, 6.0], None);
    near(row_times(6.0, 8, Some(0.1)), &[0.0, 0.9, 1.8, 2.7, 3.6, 4.5, 5.4], Some(6.0));
    near(row_times(6.05, 4, Some(0.1)), &[0.0, 2.0, 4.0, 6.0], Some(6.05));
    near(row_times(0.5, 4, Some(2.0)), &[0.0], Some(0.5));
}

/// The merits in one line, as they are printed.
#[test]
fn merits_in_words() {
    let merits = luenberger_sim::ErrorMetrics {
        initial: 2.0,
        peak: 2.5,
        settling_first: Some(1.23456),
        settling_last: None,
        rmse: 0.5,
        last: 1e-9,
        steady_rmse: 0.125,
    };
    let text = "|e| at the start 2, peak 2.5, RMSE 0.5, in the second half 0.125, at the end 1e-9; enters the band at \
                1.235, settles at never";
    assert_eq!(merits.to_string(), text);
}
