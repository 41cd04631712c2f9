//! Linear runs with held inputs are exact, and what is not linear is integrated.

use luenberger_expression::{ExpressionPlant, Parameters};
use luenberger_observers::{CubicObserver, DiscreteLinearObserver, LinearObserver};
use luenberger_plants::StateSpace;
use luenberger_sim::{Integrator, Noise, Scenario, Settings, Signal, SimError, Trajectory};
use nalgebra::{DMatrix, dmatrix};

fn plant() -> StateSpace {
    let a = dmatrix![0.0, 1.0, 0.0; -4.0, -0.4, 1.0; 0.0, 0.0, -2.0];
    StateSpace::new(a, dmatrix![0.0; 0.0; 2.0], dmatrix![1.0, 0.0, 0.0]).unwrap()
}

fn held<'a>() -> Scenario<'a> {
    let observer = LinearObserver::of(plant(), dmatrix![5.0; 6.0; 0.5]).unwrap();
    Scenario::new(plant())
        .initial_state(&[1.0, 0.0, -1.0])
        .input(Signal::scalar(|t| (3.0 * t).cos()))
        .hold_input(0.1)
        .observer("linear", observer, &[0.0; 3])
}

fn largest_difference(a: &DMatrix<f64>, b: &DMatrix<f64>) -> f64 {
    (a - b).amax()
}

/// Computed with scipy 1.17.1: `scipy.linalg.expm` of the plant, the observer `xhat' = A xhat + B u + L (y - C xhat)`
/// and the input held over 0.1 as one matrix of order 7, applied 23 times and once over 0.04, and 50 times.
const AT_2_34: [f64; 6] = [
    -0.20030311886133986,
    1.5056092417482805,
    0.49705449377932176,
    -0.20183905008174935,
    1.4993579696688129,
    0.5028290722947328,
];
const AT_5: [f64; 6] = [
    -0.41245170349689725,
    0.8084760055854245,
    0.15111748647582413,
    -0.4124483971711356,
    0.8084811845007868,
    0.15114053126702998,
];

#[test]
fn held_inputs_give_the_solution_of_scipys_exponential() {
    let run = held().times(&[2.34, 5.0]).run().unwrap();
    let row = |k: usize| {
        let (x, xhat) = (run.x.row(k), run.observers[0].estimate.row(k));
        x.iter().chain(xhat.iter()).copied().collect::<Vec<f64>>()
    };
    for (k, expected) in [AT_2_34, AT_5].iter().enumerate() {
        for (found, expected) in row(k).iter().zip(expected) {
            // Rounding of 50 products of matrices with entries up to 10.
            assert!((found - expected).abs() <= 1e-14, "{found} {expected}");
        }
    }
    // Between the samples of the dense output as well.
    let state = run.state_at(2.34).unwrap();
    assert!(state.iter().zip(&AT_2_34).all(|(found, expected)| (found - expected).abs() <= 1e-12), "{state:?}");
}

fn tight(scenario: Scenario<'_>) -> Trajectory {
    // An integral makes the equation one that is integrated.
    let settings = Settings { integrator: Integrator::Explicit, rtol: 1e-13, atol: 1e-15, ..Settings::default() };
    scenario.integral("one", luenberger_sim::Integrand::custom(|_| 1.0)).settings(settings).run().unwrap()
}

#[test]
fn the_integrator_agrees() {
    let noise = || Noise::gaussian(&[0.1], 0.07, 3);
    let sampled = DiscreteLinearObserver::new(plant(), dmatrix![0.5; 0.2; 0.1], 0.1).unwrap();
    let process = Noise::uniform(&[0.1, 0.2, 0.3], 0.05, 8);
    let disturbed = luenberger_sim::Disturbances { process_noise: Some(process), ..Default::default() };
    let scenarios = [
        held(),
        held().noise(noise()),
        held().noise(noise()).disturbances(disturbed),
        held().breakpoints(&[0.333]).change(luenberger_sim::Change::at(1.234).jump(&[0.1, 0.2, 0.3])),
        held().sampled_observer("sampled", sampled, &[0.0; 3]),
        Scenario::new(plant()).initial_state(&[1.0, 0.0, -1.0]).noise(noise()).input(Signal::constant(&[2.0])),
    ];
    for (k, scenario) in scenarios.into_iter().enumerate() {
        let scenario = scenario.until(5.0, 77);
        let (exact, integrated) = (scenario.clone().run().unwrap(), tight(scenario));
        assert!(largest_difference(&exact.x, &integrated.x) < 1e-11, "{k}");
        for (one, other) in exact.observers.iter().zip(&integrated.observers) {
            assert!(largest_difference(&one.estimate, &other.estimate) < 1e-11, "{k}: {}", one.name);
        }
        for t in [0.012, 1.235, 3.3] {
            let (one, other) = (exact.state_at(t).unwrap(), integrated.state_at(t).unwrap());
            assert!(one.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-10), "{k} at {t}");
        }
        assert!(exact.steps != integrated.steps || k > 5, "{k}");
    }
}

/// The same matrices as expressions with a constant; and expressions in which the time occurs, or a square.
#[test]
fn expressions_are_affine_by_their_form() {
    let run = |first: &str| {
        let f = [first, "-4*x1 - 0.4*x2 + x3 - 9.81", "2*u1 - 2*x3"];
        let plant = ExpressionPlant::new(&f, &["x1"], 1, &Parameters::new()).unwrap();
        Scenario::new(plant).initial_state(&[1.0, 0.0, -1.0]).input(Signal::scalar(f64::cos)).hold_input(0.1)
    };
    let affine = run("x2").until(3.0, 4).run().unwrap();
    assert!(largest_difference(&affine.x, &tight(run("x2").until(3.0, 4)).x) < 1e-11);
    // In one step per period, where the integrator starts with a short one.
    let coarse = |first: &str| run(first).tolerances(1e-7, 1e-9).until(3.0, 4).run().unwrap();
    let difference = largest_difference(&coarse("x2").x, &affine.x);
    assert!(difference < 1e-13 && coarse("x2").steps == 30, "{difference} {}", coarse("x2").steps);
    for first in ["x2 + 0*t", "x2 + 0*x1^2"] {
        let difference = largest_difference(&coarse(first).x, &affine.x);
        assert!(difference > 1e-13, "{first}: {difference}");
    }
}

/// A cubic observer, an input between its samples, and long intervals are integrated.
#[test]
fn what_is_not_exact_is_integrated() {
    let cubic = CubicObserver::of(plant(), dmatrix![5.0; 6.0; 0.5], dmatrix![-1.0; -1.0; 0.0], dmatrix![1.0]).unwrap();
    let with_cubic = held().observer("cubic", cubic, &[0.0; 3]).until(5.0, 2).run().unwrap();
    assert!(largest_difference(&with_cubic.x, &held().until(5.0, 2).run().unwrap().x) < 1e-10);
    let long = Scenario::new(plant()).initial_state(&[1.0, 0.0, -1.0]).hold_input(50.0).until(60.0, 2).run().unwrap();
    // 0.5 per step at least, where the series would need 0.05.
    assert!(long.steps < 400, "{}", long.steps);
}

#[test]
fn what_grows_beyond_all_bounds_is_named() {
    let plant = StateSpace::new(dmatrix![10.0], DMatrix::zeros(1, 0), dmatrix![1.0]).unwrap();
    let run = |settings: Settings| {
        Scenario::new(plant.clone()).initial_state(&[1.0]).hold_input(0.1).settings(settings).until(100.0, 2).run()
    };
    // exp(10 t) is 1e100 at t = 23.03.
    let error = run(Settings::default()).unwrap_err();
    assert!(matches!(error, SimError::BlowUp { time, .. } if (22.9..23.1).contains(&time)), "{error}");
    let few = Settings { max_steps: 10, ..Settings::default() };
    assert!(matches!(run(few), Err(SimError::TooManySteps { .. })));
}

/// Steps are as long as the tolerances of the dense output and `|F| h <= 2` let them be, the next ones equal parts of
/// the rest: where they end is computed by a second implementation in Python, with the powers of F by numpy 2.
#[test]
fn steps_of_the_series_keep_the_dense_output_within_its_tolerances() {
    let ends = [
        0.909090909091,
        1.86363636364,
        2.77045454545,
        3.78395721925,
        4.9422459893,
        6.19705882353,
        7.57735294118,
        9.13018382353,
        10.6830147059,
        12.2358455882,
        13.7886764706,
        15.3415073529,
        16.8943382353,
        18.4471691176,
        20.0,
    ];
    let (a, b) = (dmatrix![-0.8, 0.4; 0.0, -0.5], dmatrix![0.3; -1.0]);
    let of = |a: DMatrix<f64>, b: DMatrix<f64>, x0: &[f64], end: f64, (rtol, atol): (f64, f64)| {
        let c = DMatrix::from_fn(1, a.nrows(), |_, j| f64::from(u8::from(j == 0)));
        let scenario = Scenario::new(StateSpace::new(a, b, c).unwrap()).initial_state(x0);
        scenario.input(Signal::constant(&[1.0])).hold_input(end).tolerances(rtol, atol).until(end, 2)
    };
    let run = of(a, b, &[1.0, -2.0], 20.0, (1e-9, 1e-10)).run().unwrap();
    // One step more is tried, and found too long.
    assert_eq!((run.step_spans().count(), run.steps), (15, 16));
    for ((_, end), expected) in run.step_spans().zip(ends) {
        assert!((end - expected).abs() < 1e-10, "{end} {expected}");
    }
    let scalar = of(dmatrix![-0.8], dmatrix![0.3], &[1.0], 5.0, (1e-11, 1e-12));
    let run = scalar.clone().run().unwrap();
    assert_eq!(run.steps, 10);
    for ((_, end), expected) in run.step_spans().zip([0.5, 1.0625, 1.625, 2.1875, 2.75, 3.3125, 3.875, 4.4375, 5.0]) {
        assert!((end - expected).abs() < 1e-10, "{end} {expected}");
    }
    // x = 3/8 + 5/8 exp(-0.8 t), in the dense output too.
    for k in 0..=100 {
        let t = 0.05 * f64::from(k);
        assert!((run.state_at(t).unwrap()[0] - 0.375 - 0.625 * (-0.8 * t).exp()).abs() < 2e-12, "{t}");
    }
    // Sixteen steps of 2.5, or of the longest that is allowed, and no more: 40 s, or 4.
    let alone = |end: f64, longest: f64| {
        let settings = Settings { max_step: longest, rtol: 1e-2, atol: 1e-2, ..Settings::default() };
        let scenario = of(dmatrix![-0.8], dmatrix![0.3], &[1.0], end, (1e-2, 1e-2)).settings(settings);
        scenario.run().unwrap().steps
    };
    assert_eq!((alone(40.0, f64::INFINITY), alone(4.0, 0.25)), (16, 16));
    assert!(alone(40.5, f64::INFINITY) != 17 && alone(4.05, 0.25) > 17);
}
