//! Plants that are not what the observers take them to be, against closed forms.

use approx::assert_abs_diff_eq;
use luenberger_observers::LinearObserver;
use luenberger_plants::{LinearPlant, StateSpace, double_integrator};
use luenberger_sim::{
    Change, Disturbances, Fault, Integrand, MeasurementLoss, Noise, Purpose, Scenario, Signal, SimError, Trajectory,
};
use nalgebra::{DMatrix, Vector2, dmatrix};

/// x' = u, y = x.
fn integrator() -> StateSpace {
    LinearPlant::new(dmatrix![0.0], dmatrix![1.0], dmatrix![1.0]).unwrap()
}

fn run(disturbances: Disturbances, input: Signal<'_>, end: f64) -> Trajectory {
    Scenario::new(integrator()).disturbances(disturbances).input(input).until(end, 101).run().unwrap()
}

/// With u = t the plant has x = (t - d)^2 / 2 from t = d on; what is known of the input is t.
#[test]
fn a_delayed_input_arrives_later() {
    let late = Disturbances { input_delay: 0.37, ..Disturbances::default() };
    let run = run(late.clone(), Signal::scalar(|t| t), 2.0);
    for (k, t) in run.t.iter().enumerate() {
        assert_abs_diff_eq!(run.x[(k, 0)], (t - 0.37).max(0.0).powi(2) / 2.0, epsilon = 1e-9);
        assert_abs_diff_eq!(run.u[(k, 0)], *t, epsilon = 1e-12);
    }
    // Held every 0.25: 0, 0.25, 0.5, ... each from 0.37 later on. At t = 1.5: 0.25 (0.25 + 0.5 + 0.75) + 0.13 * 1.
    let held = Scenario::new(integrator()).disturbances(late).input(Signal::scalar(|t| t)).hold_input(0.25);
    let held = held.until(1.5, 2).run().unwrap();
    assert_abs_diff_eq!(held.x[(1, 0)], 0.25 * 1.5 + 0.13, epsilon = 1e-9);
}

/// Of x' = u under u = 1 the output is t, and under a delay of 0.3 it was t - 0.3: that of the state and not of the
/// input, which stands beside it.
#[test]
fn a_delayed_output_of_a_plant_with_inputs_is_the_output() {
    let plant = LinearPlant::new(dmatrix![0.0, 0.0; 0.0, 0.0], dmatrix![1.0; 2.0], dmatrix![1.0, 0.0]).unwrap();
    let run = Scenario::new(plant)
        .input(Signal::constant(&[1.0]))
        .disturbances(Disturbances { output_delay: 0.3, ..Disturbances::default() })
        .until(2.0, 21)
        .run()
        .unwrap();
    for (k, &t) in run.t.iter().enumerate() {
        assert_abs_diff_eq!(run.measured[(k, 0)], (t - 0.3).max(0.0), epsilon = 1e-9);
    }
}

/// Jumps that are one instant, and a rounding error apart as sums of periods and delays: no step is taken between them.
/// Of t held every 0.05, `0, 0.05, .., 9.9` have acted for 0.05 each at t = 10.
#[test]
fn delays_of_whole_periods_make_one_jump() {
    let plant = integrator();
    let observer = LinearObserver::of(plant.clone(), dmatrix![1.0]).unwrap();
    let run = Scenario::new(plant)
        .disturbances(Disturbances { input_delay: 0.05, output_delay: 0.02, ..Disturbances::default() })
        .input(Signal::scalar(|t| t))
        .hold_input(0.05)
        .noise(Noise::gaussian(&[1e-3], 0.05, 1))
        .observer("slow", observer, &[0.0])
        .until(10.0, 2)
        .run()
        .unwrap();
    assert_abs_diff_eq!(run.x[(1, 0)], 0.05 * 0.05 * f64::from(198 * 199 / 2), epsilon = 1e-7);
}

/// x' = -x(t - 1) with x = 1 before: 1 - t up to 1, then 1 - t + (t - 1)^2/2 up to 2, then - (t - 2)^3/6 more.
#[test]
fn feedback_through_a_delay_is_integrated_step_by_step() {
    let run = Scenario::new(integrator())
        .initial_state(&[1.0])
        .disturbances(Disturbances { input_delay: 1.0, ..Disturbances::default() })
        .input(Signal::state_feedback(dmatrix![1.0]))
        .until(3.0, 61)
        .run()
        .unwrap();
    for (k, &t) in run.t.iter().enumerate() {
        let expected = 1.0 - t + (t - 1.0).max(0.0).powi(2) / 2.0 - (t - 2.0).max(0.0).powi(3) / 6.0;
        assert_abs_diff_eq!(run.x[(k, 0)], expected, epsilon = 1e-8);
    }
}

#[test]
fn a_delayed_output_is_read_later() {
    let late = Disturbances { output_delay: 0.3, ..Disturbances::default() };
    let run = run(late, Signal::scalar(|t| t), 2.0);
    for (k, t) in run.t.iter().enumerate() {
        assert_abs_diff_eq!(run.y[(k, 0)], t * t / 2.0, epsilon = 1e-9);
        assert_abs_diff_eq!(run.measured[(k, 0)], (t - 0.3).max(0.0).powi(2) / 2.0, epsilon = 1e-8);
    }
    assert_abs_diff_eq!(run.measured_at(1.234).unwrap()[0], (1.234f64 - 0.3).powi(2) / 2.0, epsilon = 1e-8);
}

/// Each output by the delay of all and its own: t^2/2 and t of a mass that is pushed from rest.
#[test]
fn outputs_have_delays_of_their_own() {
    let (a, b, c) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0], nalgebra::DMatrix::identity(2, 2));
    let late = Disturbances { output_delay: 0.1, output_delays: vec![0.3, 0.0], ..Disturbances::default() };
    let run = Scenario::new(luenberger_plants::StateSpace::new(a, b, c).unwrap())
        .initial_state(&[0.0, 0.0])
        .disturbances(late.clone())
        .input(Signal::scalar(|_| 1.0))
        .until(2.0, 41)
        .run()
        .unwrap();
    for (k, t) in run.t.iter().enumerate() {
        assert_abs_diff_eq!(run.measured[(k, 0)], (t - 0.4).max(0.0).powi(2) / 2.0, epsilon = 1e-8);
        assert_abs_diff_eq!(run.measured[(k, 1)], (t - 0.1).max(0.0), epsilon = 1e-8);
    }
    let wrong = |output_delays: Vec<f64>| {
        let late = Disturbances { output_delays, ..late.clone() };
        Scenario::new(integrator()).initial_state(&[0.0]).disturbances(late).until(1.0, 2).run().unwrap_err()
    };
    assert!(matches!(wrong(vec![0.1, 0.2]), SimError::Length { expected: 1, found: 2, .. }));
    assert!(matches!(wrong(vec![-0.1]), SimError::NotPositive { .. }));
}

/// x' = w: x is the sum of what is held.
#[test]
fn process_noise_is_integrated() {
    let noise = Noise::gaussian(&[0.7], 0.1, 3);
    let run = run(Disturbances { process_noise: Some(noise.clone()), ..Disturbances::default() }, Signal::zero(), 2.0);
    let sum: f64 = (0..20).map(|k| 0.1 * noise.sample(Purpose::ProcessNoise, k)[0]).sum();
    assert_abs_diff_eq!(run.x[(100, 0)], sum, epsilon = 1e-10);
    let half: f64 = (0..7).map(|k| 0.1 * noise.sample(Purpose::ProcessNoise, k)[0]).sum::<f64>()
        + 0.04 * noise.sample(Purpose::ProcessNoise, 7)[0];
    assert_abs_diff_eq!(run.x[(37, 0)], half, epsilon = 1e-10);
}

/// An actuator that loses half of its effect at t = 1, a sensor with a bias and steps of 0.5.
#[test]
fn faults_begin_when_they_begin() {
    let actuator = Fault { gain: vec![0.5], bias: vec![0.1], from: 1.0 };
    let sensor = Fault { gain: vec![2.0], bias: vec![0.3], from: 0.0 };
    let all = Disturbances {
        actuator: Some(actuator),
        sensor: Some(sensor),
        quantisation: vec![0.5],
        ..Disturbances::default()
    };
    let run = run(all, Signal::constant(&[1.0]), 2.0);
    assert_abs_diff_eq!(run.x[(100, 0)], 1.0 + 0.6, epsilon = 1e-10);
    // 2 * 1.6 + 0.3 = 3.5, and at t = 0.2 it is 0.7, which is nearest to 0.5.
    assert_abs_diff_eq!(run.measured[(100, 0)], 3.5, epsilon = 1e-12);
    assert_abs_diff_eq!(run.measured[(10, 0)], 0.5, epsilon = 1e-12);
}

#[test]
fn what_does_not_arrive_is_no_measurement_and_outliers_are_off_by_their_size() {
    let channel =
        |dropout, outlier| MeasurementLoss { dropout, outlier, outlier_size: vec![7.0], period: 0.5, seed: 1 };
    let with = |channel| Disturbances { channel: Some(channel), ..Disturbances::default() };
    let lost = run(with(channel(1.0, 0.0)), Signal::constant(&[1.0]), 2.0);
    assert!(lost.measured.iter().all(|y| y.is_nan()) && !lost.is_measured(0, 0.7));
    let wild = run(with(channel(0.0, 1.0)), Signal::constant(&[1.0]), 2.0);
    assert!((0..101).all(|k| ((wild.measured[(k, 0)] - wild.y[(k, 0)]).abs() - 7.0).abs() < 1e-9));
    // Of 4000 values a quarter: within five standard deviations, sqrt(0.25 * 0.75 / 4000) = 0.0068.
    let some = MeasurementLoss { period: 0.001, ..channel(0.0, 0.25) };
    let run = Scenario::new(integrator()).disturbances(with(some)).until(4.0, 4001).run().unwrap();
    let share = (0..4000).filter(|k| run.measured[(*k, 0)] != 0.0).count() as f64 / 4000.0;
    assert!((share - 0.25).abs() < 0.034, "{share}");
}

/// A bias of the sensor of 0.1 becomes an error of the position, and a constant disturbance d of the speed one of
/// e = F^-1 (0, -d): with L = (7, 10) e1 = d/10, e2 = 0.7 d.
#[test]
fn an_observer_does_not_know_of_it() {
    let plant = double_integrator();
    let linear = LinearObserver::of(plant.clone(), Vector2::new(7.0, 10.0)).unwrap();
    let pushed = Fault { gain: vec![1.0], bias: vec![0.5], from: 0.0 };
    let run = Scenario::new(plant)
        .observer("linear", &linear, &[0.0, 0.0])
        .disturbances(Disturbances { actuator: Some(pushed), ..Disturbances::default() })
        .until(15.0, 2)
        .run()
        .unwrap();
    let error = &run.observers[0].error;
    assert_abs_diff_eq!(error[(1, 0)], 0.05, epsilon = 1e-7);
    assert_abs_diff_eq!(error[(1, 1)], 0.35, epsilon = 1e-7);
}

#[test]
fn what_does_not_fit_is_an_error() {
    let failed = |disturbances| Scenario::new(integrator()).disturbances(disturbances).until(1.0, 2).run().unwrap_err();
    let none = Disturbances::default;
    let two = Fault { gain: vec![1.0, 1.0], bias: vec![0.0], from: 0.0 };
    assert!(matches!(failed(Disturbances { sensor: Some(two), ..none() }), SimError::Length { found: 2, .. }));
    assert!(matches!(failed(Disturbances { input_delay: -1.0, ..none() }), SimError::NotPositive { .. }));
    let channel = MeasurementLoss { dropout: 1.5, outlier: 0.0, outlier_size: vec![0.0], period: 1.0, seed: 0 };
    let error = failed(Disturbances { channel: Some(channel), ..none() });
    assert_eq!(error.to_string(), "the probability of dropouts is 1.5; it must be from 0 to 1");
    let noise = Noise::gaussian(&[1.0, 1.0], 0.1, 0);
    assert!(matches!(failed(Disturbances { process_noise: Some(noise), ..none() }), SimError::Length { .. }));
}

/// What does not fit a change of the plant.
#[test]
fn changes_that_do_not_fit() {
    let plant = |n: usize| StateSpace::new(DMatrix::zeros(n, n), DMatrix::zeros(n, 0), DMatrix::zeros(1, n)).unwrap();
    let run = |change: Change<'_>| Scenario::new(plant(2)).change(change).until(1.0, 2).run().unwrap_err();
    assert!(matches!(run(Change::at(0.0)), SimError::ChangeTime { time: 0.0, start: 0.0 }));
    assert!(matches!(run(Change::at(f64::NAN)), SimError::ChangeTime { .. }));
    assert!(matches!(run(Change::at(0.5).plant(plant(3))), SimError::Length { expected: 2, found: 3, .. }));
    assert!(matches!(run(Change::at(0.5).jump(&[1.0])), SimError::Length { expected: 2, found: 1, .. }));
    assert!(matches!(run(Change::at(0.5).jump(&[1.0, f64::NAN])), SimError::NotFinite { index: 1, .. }));
}

/// At the time of a change the plant is changed.
#[test]
fn a_change_counts_from_its_time_on() {
    let plant = |slope: f64| StateSpace::new(dmatrix![0.0], DMatrix::zeros(1, 0), dmatrix![slope]).unwrap();
    let run = Scenario::new(plant(1.0))
        .initial_state(&[2.0])
        .change(Change::at(0.2).jump(&[1.0]))
        .change(Change::at(0.2).plant(plant(10.0)))
        .change(Change::at(0.3).jump(&[1.0]))
        .change(Change::at(0.1).jump(&[-1.0]))
        .times(&[0.05, 0.1, 0.15, 0.2, 0.25, 0.3])
        .run()
        .unwrap();
    assert_eq!(run.x.as_slice(), [2.0, 1.0, 1.0, 2.0, 2.0, 3.0]);
    assert_eq!(run.y.as_slice(), [2.0, 1.0, 1.0, 20.0, 20.0, 30.0]);
}

/// What process noise adds is what it draws, with a bias of the sensor beside it; in discrete time to the next state;
/// and what is read is the output with the noise and the outlier of its period.
#[test]
fn noise_beside_other_disturbances_is_what_was_drawn() {
    let (process, measurement) = (Noise::gaussian(&[0.7], 0.1, 3), Noise::gaussian(&[0.2], 0.1, 5));
    let sensor = Some(Fault { gain: vec![1.0], bias: vec![0.25], from: 0.0 });
    let all = Disturbances { process_noise: Some(process.clone()), sensor, ..Disturbances::default() };
    let drawn = |k: u64| process.sample(Purpose::ProcessNoise, k)[0];
    let scenario = Scenario::new(integrator()).disturbances(all.clone()).noise(measurement.clone());
    let sum = 0.1 * (0..20).map(drawn).sum::<f64>();
    let integrated = scenario.clone().integral("x", Integrand::custom(|view| view.x[0])).until(2.0, 2).run().unwrap();
    assert_abs_diff_eq!(integrated.x[(1, 0)], sum, epsilon = 1e-10);
    let run = scenario.until(2.0, 2).run().unwrap();
    assert_abs_diff_eq!(run.x[(1, 0)], 0.1 * (0..20).map(drawn).sum::<f64>(), epsilon = 1e-10);
    let noise = run.measured_at(1.234).unwrap()[0] - run.state_at(1.234).unwrap()[0] - 0.25;
    assert_abs_diff_eq!(noise, measurement.sample(Purpose::MeasurementNoise, 12)[0], epsilon = 1e-10);
    // x+ = x/2 + w: x after three steps.
    let halved = LinearPlant::new(dmatrix![0.5], dmatrix![0.0], dmatrix![1.0]).unwrap();
    let run = Scenario::new(halved).discrete_time(0.1).disturbances(all).initial_state(&[8.0]).times(&[0.0, 0.3]);
    let expected = 1.0 + drawn(0) / 4.0 + drawn(1) / 2.0 + drawn(2);
    assert_abs_diff_eq!(run.run().unwrap().x[(1, 0)], expected, epsilon = 1e-12);
}

/// Steps end where a delayed signal jumps, and where a fault begins.
#[test]
fn jumps_arrive_with_their_delays() {
    let late = Disturbances { input_delay: 0.1, output_delay: 0.25, ..Disturbances::default() };
    let fault = |from| Some(Fault { gain: vec![1.0], bias: vec![0.5], from });
    let all = Disturbances { actuator: fault(0.37), sensor: fault(0.77), ..late.clone() };
    let ramp = Signal::scalar(|t| t);
    let run =
        Scenario::new(integrator()).breakpoints(&[0.5]).input(ramp).until(2.0, 2).disturbances(all).run().unwrap();
    let ends: Vec<f64> = run.step_spans().map(|(_, end)| end).collect();
    for jump in [0.37, 0.5, 0.6, 0.75, 0.77, 0.85] {
        assert!(ends.iter().any(|end| (end - jump).abs() < 1e-12), "{jump}: {ends:?}");
    }
    // The input of 0.1 before, and the bias from 0.37 on; of the output that of 0.25 before, and its bias.
    assert_abs_diff_eq!(run.x[(1, 0)], 1.9f64.powi(2) / 2.0 + 0.5 * 1.63, epsilon = 1e-9);
    assert_abs_diff_eq!(run.measured[(1, 0)], 1.65f64.powi(2) / 2.0 + 0.5 * 1.38 + 0.5, epsilon = 1e-9);
    // On the right side of a jump nothing has to be searched for: x' = u(t - 0.1) needs few steps for each value.
    let held = |late| {
        let scenario = Scenario::new(integrator()).input(Signal::scalar(|t| t)).hold_input(0.25).until(2.0, 2);
        scenario.disturbances(late).run().unwrap().steps
    };
    let (delayed, plain) = (held(late), held(Disturbances::default()));
    assert!(delayed <= 120, "{delayed} {plain}");
}

/// What is read is the output with its noise, rounded where there is a step.
#[test]
fn noise_is_added_before_rounding() {
    let plant = || StateSpace::new(DMatrix::zeros(2, 2), DMatrix::zeros(2, 0), DMatrix::identity(2, 2)).unwrap();
    let noise = Noise::gaussian(&[0.3, 0.3], 0.5, 11);
    let run = Scenario::new(plant())
        .initial_state(&[1.0, 1.0])
        .noise(noise.clone())
        .disturbances(Disturbances { quantisation: vec![0.0, 0.25], ..Disturbances::default() })
        .times(&[0.1, 0.6, 1.1, 1.6])
        .run()
        .unwrap();
    for k in 0..4 {
        let drawn = noise.sample(Purpose::MeasurementNoise, k as u64);
        assert_abs_diff_eq!(run.measured[(k, 0)], 1.0 + drawn[0], epsilon = 1e-12);
        let steps = run.measured[(k, 1)] / 0.25;
        assert!(steps == steps.round() && (run.measured[(k, 1)] - 1.0 - drawn[1]).abs() <= 0.125 + 1e-12);
    }
}
