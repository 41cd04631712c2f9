//! A step of a sampled observer of unknown size takes no memory, and neither does a step of an integrator, or a sample
//! of a run.
#![allow(unsafe_code, reason = "a counting allocator is an unsafe trait; it only passes on")]

#[path = "../../crates/linalg/tests/counting_allocator/mod.rs"]
mod counting_allocator;

use counting_allocator::allocations;
use luenberger_expression::{ExpressionPlant, Parameters};
use luenberger_observers::{
    DiscreteLinearObserver, ExtendedKalmanFilter, KalmanFilter, KalmanModel, NoiseModel, NonlinearLuenbergerObserver,
    SampledCubicGains, SampledCubicObserver, SampledNonlinearObserver, SampledObserver, SigmaPoints,
    UnscentedKalmanFilter, cubic,
};
use luenberger_plants::StateSpace;
use luenberger_sim::{Integrator, Noise, Scenario, Settings, Signal, solve};
use nalgebra::{DMatrix, DVector, dmatrix};

#[test]
fn steps_of_sampled_observers_take_no_memory() {
    let (ad, bd, c) = (dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1], dmatrix![1.0, 0.0]);
    let (ld, n) = (dmatrix![0.9; 2.0], dmatrix![-1.0; -1.5]);
    let (theta, w, period) = (dmatrix![10.0], cubic::rate(&c, &n), 0.1);
    let plant = StateSpace::new(ad.clone(), bd.clone(), c.clone()).unwrap();
    let linear = DiscreteLinearObserver::new(plant, ld.clone(), period).unwrap();
    let gains = SampledCubicGains { ad, bd, c, ld, n, theta, w, period };
    let cubic = SampledCubicObserver::new(gains).unwrap().with_feedthrough(dmatrix![0.5]).unwrap();
    let (mut xhat, u, y) = (DVector::zeros(2), DVector::from_element(1, 0.3), DVector::from_element(1, 1.0));
    assert_eq!(allocations(|| (0..100).for_each(|_| linear.step(0.0, &mut xhat, &u, &y))), 0);
    assert_eq!(allocations(|| (0..100).for_each(|_| cubic.step(0.0, &mut xhat, &u, &y))), 0);
    assert!(xhat.iter().all(|x| x.is_finite()));
    assert_eq!(allocations(|| DMatrix::<f64>::zeros(2, 2)), 1, "the allocator counts");
}

/// Filters and the copy of a plant in expressions, whose sizes are known at run time.
#[test]
fn steps_of_filters_take_no_memory() {
    let plant = || ExpressionPlant::new(&["x2", "u1 - sin(x1) - 0.1*x2"], &["x1"], 1, &Parameters::new()).unwrap();
    let noises = || NoiseModel { w: DMatrix::identity(2, 2) * 1e-3, v: dmatrix![1e-4], p0: DMatrix::identity(2, 2) };
    let extended = || ExtendedKalmanFilter::new(plant(), noises(), 0.01, 2).unwrap();
    no_memory(&extended());
    no_memory(&extended().with_iterations(2).unwrap().with_gate(4.0).unwrap());
    no_memory(&UnscentedKalmanFilter::new(plant(), noises(), SigmaPoints::default(), 0.01, 2).unwrap());
    no_memory(&SampledNonlinearObserver::new(plant(), dmatrix![4.0; 6.0], 0.01, 2).unwrap());
    let (ad, bd, c) = (dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1], dmatrix![1.0, 0.0]);
    let NoiseModel { w, v, p0 } = noises();
    no_memory(&KalmanFilter::new(KalmanModel { ad, bd, c, w, v, p0, period: 0.1 }).unwrap());
}

fn no_memory(
    observer: &impl SampledObserver<f64, Input = DVector<f64>, Output = DVector<f64>, Estimate = DVector<f64>>,
) {
    let (u, y) = (DVector::from_element(1, 0.3), DVector::from_element(1, 1.0));
    let mut state = observer.initial(0.0, &DVector::zeros(2), &u, &y);
    // An expression is compiled when it is evaluated first.
    observer.step(0.0, &mut state, &u, &y);
    assert_eq!(allocations(|| (1..100).for_each(|k| observer.step(0.01 * f64::from(k), &mut state, &u, &y))), 0);
    assert!(observer.estimate(&state).iter().all(|x| x.is_finite()));
}

/// What a solution keeps grows by doubling; everything else is allocated once.
#[test]
fn steps_of_the_explicit_integrator_take_no_memory() {
    let oscillator =
        |_: f64, x: &[f64], slope: &mut [f64]| (slope[0], slope[1]) = (x[1], (1.0 - x[0] * x[0]) * x[1] - x[0]);
    let settings = Settings { integrator: Integrator::Explicit, rtol: 1e-9, atol: 1e-12, ..Settings::default() };
    let count = |end: f64| {
        let mut steps = 0;
        let count = allocations(|| steps = solve(oscillator, 0.0, end, &[1.0, 0.0], &settings).unwrap().step_count());
        (count, steps)
    };
    let ((few, short), (many, long)) = (count(1.0), count(100.0));
    assert!(long > 50 * short && many < few + 30, "{few} for {short} steps, {many} for {long}");
}

/// A plant of expressions, an extended Kalman filter in the loop at 100 Hz, another observer in continuous time, noise.
#[test]
fn samples_of_a_run_take_no_memory() {
    let plant = ExpressionPlant::new(&["x2", "u1 - sin(x1) - 0.1*x2"], &["x1"], 1, &Parameters::new()).unwrap();
    let noises = NoiseModel { w: DMatrix::identity(2, 2) * 1e-3, v: dmatrix![1e-4], p0: DMatrix::identity(2, 2) };
    let filter = ExtendedKalmanFilter::new(plant.clone(), noises, 0.01, 2).unwrap();
    let observer = NonlinearLuenbergerObserver::new(plant.clone(), dmatrix![5.0; 9.0]).unwrap();
    let count = |end: f64| {
        let scenario = Scenario::new(&plant)
            .initial_state(&[1.0, 0.0])
            .input(Signal::feedback("filter", dmatrix![1.0, 1.0]))
            .hold_input(0.01)
            .noise(Noise::gaussian(&[0.01], 0.01, 1))
            .sampled_observer("filter", &filter, &[0.5, 0.0])
            .observer("copy", &observer, &[0.5, 0.0])
            .until(end, 11);
        let mut steps = 0;
        (allocations(|| steps = scenario.run().unwrap().steps), steps)
    };
    let ((few, short), (many, long)) = (count(1.0), count(20.0));
    assert!(long > 15 * short && many < few + 20, "{few} for {short} steps, {many} for {long}");
}
