//! Inputs of a study in a simulation: expressions, tables with their breakpoints, feedback with a reference; and their
//! errors.

use luenberger_expression::Parameters;
use luenberger_observers::LinearObserver;
use luenberger_plants::double_integrator;
use luenberger_sim::{SampleInterpolation, Scenario, Signal, Trajectory};
use luenberger_study::signal::{Input, Program, SignalError};
use luenberger_study::table::Table;
use nalgebra::{Vector2, dmatrix};

fn program(texts: &[&str]) -> Program {
    Program::expressions(texts, &Parameters::from([("a".to_owned(), 2.0)])).unwrap()
}

fn run(input: &Input) -> Trajectory {
    Scenario::new(double_integrator())
        .initial_state(&[1.0, 0.0])
        .input(input.signal())
        .breakpoints(&input.breakpoints(0.0, 3.0))
        .observer("linear", LinearObserver::of(double_integrator(), Vector2::new(7.0, 10.0)).unwrap(), &[0.0, 0.0])
        .until(3.0, 31)
        .run()
        .unwrap()
}

#[test]
fn expressions_are_inputs() {
    let trajectory = run(&Input::Program(program(&["a*sin(3*t)"])));
    // x2 = (2/3) (1 - cos 3t), x1 = 1 + (2/3) (t - sin(3t)/3).
    for k in [10, 20, 30] {
        let t = trajectory.t[k];
        let (x1, x2) = (1.0 + 2.0 / 3.0 * (t - (3.0 * t).sin() / 3.0), 2.0 / 3.0 * (1.0 - (3.0 * t).cos()));
        assert!((trajectory.x[(k, 0)] - x1).abs() < 1e-9 && (trajectory.x[(k, 1)] - x2).abs() < 1e-9);
    }
    assert_eq!(run(&Input::Zero).x[(30, 0)], 1.0);
}

#[test]
fn tables_are_inputs_with_breakpoints() {
    let table = Table::parse("time,force\n0,0\n1,2\n2,-1\n3,0\n").unwrap();
    let samples = |between| Input::Program(Program::Table(table.samples("time", &["force"], between).unwrap()));
    let line = samples(SampleInterpolation::Linear);
    assert_eq!(line.breakpoints(0.0, 3.0), [0.0, 1.0, 2.0]);
    // The integral of a polygon: 1, then 0.5, then -0.5.
    let trajectory = run(&line);
    for (k, x2) in [(10, 1.0), (20, 1.5), (30, 1.0)] {
        assert!((trajectory.x[(k, 1)] - x2).abs() < 1e-9, "{}", trajectory.x[(k, 1)]);
    }
    // Held: 0, then 2, then -1.
    let trajectory = run(&samples(SampleInterpolation::ZeroOrderHold));
    for (k, x2) in [(10, 0.0), (20, 2.0), (30, 1.0)] {
        assert!((trajectory.x[(k, 1)] - x2).abs() < 1e-8, "{}", trajectory.x[(k, 1)]);
    }
    assert!(matches!(line.check(1, 0.0, 4.0), Err(SignalError::Span { table: (0.0, 3.0), run: (0.0, 4.0) })));
    assert!(line.check(1, 0.0, 3.0).is_ok());
}

#[test]
fn feedback_has_a_reference() {
    let gain = dmatrix![4.0, 4.0];
    let feedback = |reference| Input::Feedback { observer: "linear".to_owned(), gain: gain.clone(), reference };
    // Without a reference it equals the feedback of the simulation, to the last bit.
    let plain = run(&feedback(None));
    let known = Scenario::new(double_integrator())
        .initial_state(&[1.0, 0.0])
        .input(Signal::feedback("linear", gain.clone()))
        .observer("linear", LinearObserver::of(double_integrator(), Vector2::new(7.0, 10.0)).unwrap(), &[0.0, 0.0])
        .until(3.0, 31)
        .run()
        .unwrap();
    assert_eq!(plain.x, known.x);
    let led = run(&feedback(Some(program(&["a"]))));
    // u = 2 - K xhat at every time.
    for k in 0..31 {
        let u = 2.0 - 4.0 * led.observers[0].estimate[(k, 0)] - 4.0 * led.observers[0].estimate[(k, 1)];
        assert!((led.u[(k, 0)] - u).abs() <= 8.0 * f64::EPSILON * 10.0);
    }
    let ideal = run(&Input::StateFeedback { gain, reference: Some(program(&["a"])) });
    assert!((ideal.u[(0, 0)] - (2.0 - 4.0)).abs() == 0.0);
}

#[test]
fn bad_signals_are_refused() {
    let parse = |text: &str| Program::expressions(&["t", text], &Parameters::new()).unwrap_err().to_string();
    assert_eq!(
        parse("sin(x1)"),
        "component 2: line 1, column 5: `x1` may not be used here: this is a function of the time t alone"
    );
    assert!(Program::expressions(&["t"], &Parameters::from([("t".to_owned(), 1.0)])).is_err());
    let pole = program(&["1/(t - 1)"]);
    let error = pole.check(1, 0.0, 2.0).unwrap_err();
    assert_eq!(
        error.to_string(),
        "component 1 = 1/(t - 1): `1/(t - 1)` is infinite: `1` is 1 and `(t - 1)` is 0, at t = 1"
    );
    assert_eq!(pole.check(2, 0.0, 0.5), Err(SignalError::Length { expected: 2, found: 1 }));
    assert!(pole.check(1, 0.0, 0.5).is_ok() && Input::Zero.check(3, 0.0, 1.0).is_ok());
    // An unknown observer and a gain of the wrong size are rejected by the simulation, with a reference too.
    let input =
        Input::Feedback { observer: "other".to_owned(), gain: dmatrix![1.0, 1.0], reference: Some(program(&["1"])) };
    assert!(Scenario::new(double_integrator()).input(input.signal()).until(1.0, 2).run().is_err());
}
