//! Sliding-mode observers in studies: run, certificate, step for a target, and what is refused.

use luenberger_export::{Scalar, golden::Stepper};
use luenberger_proof::statement::Format as Number;
use luenberger_study::deployment::{evidence, exported, sampled};
use luenberger_study::{RunOptions, Step, execute};

use crate::studies::read;

const PENDULUM: &str = r#"
title = "pendulum"
[plant]
states = ["angle", "speed"]
inputs = ["torque"]
outputs = ["encoder"]
f = ["speed", "-9.81*sin(angle) - 0.2*speed + torque"]
h = ["angle"]
[simulation]
duration = 6
x0 = [0.5, 0]
hold = 0.01
[input]
expressions = ["sin(t)"]
"#;

fn observer(rest: &str) -> String {
    format!("[[observer]]\nkind = \"sliding-mode\"\n{rest}\n")
}

#[test]
fn a_pendulum_is_observed() {
    let both = observer("name = \"implicit\"\nbound = 15\nperiod = 0.01")
        + &observer("name = \"explicit\"\nbound = 15\nperiod = 0.01\ndiscretisation = \"explicit\"");
    let study = read(&format!("{PENDULUM}{both}")).unwrap();
    let results = execute(&study, Step::Run, &RunOptions::default()).unwrap();
    assert!(results.failures().is_empty(), "{:?}", results.failures());
    let design = results.observers[0].design.as_ref().unwrap();
    assert_eq!(design.verdict.word(), "proved", "{:?}", design.facts);
    assert!(
        design.statement.contains("does not chatter") && design.statement.contains("h^2 k2, about 0.00165"),
        "{}",
        design.statement
    );
    let late = |name: &str| {
        let run = results.runs.iter().find(|run| run.observer == name).unwrap();
        let estimate = run.estimate.as_ref().unwrap();
        (run.t.len() / 2..run.t.len()).map(|k| (run.x[(k, 1)] - estimate[(k, 1)]).abs()).fold(0.0, f64::max)
    };
    // f at the estimate leaves little open once the estimate is there: far below h D/2 = 0.075.
    assert!(late("implicit") < 0.01, "{}", late("implicit"));
    assert!(late("explicit") > 5.0 * late("implicit"), "{} {}", late("explicit"), late("implicit"));
}

/// The exported step is the observer of the study: the same estimates in binary64, to the last bit.
#[test]
fn the_exported_step_is_that_of_the_study() {
    for gains in ["", "k = [9, 17]\n", "discretisation = \"explicit\"\n"] {
        let study =
            read(&format!("{PENDULUM}{}", observer(&format!("name = \"o\"\nbound = 15\nperiod = 0.01\n{gains}"))))
                .unwrap();
        let requested = study.observer("o").unwrap();
        let found = sampled(&study, requested, None, None).unwrap();
        let said = evidence(&study, requested, &found.design, Number::Binary64.into());
        assert!(said.is_proved(), "{:?}", said.sentences);
        let export = exported(&study, requested, found.design.clone(), Scalar::Binary64, None).unwrap();
        let record = luenberger_study::deployment::record(&study, requested, &found).unwrap();
        let mut stepper = Stepper::new(&export).unwrap();
        let estimates: Vec<Vec<f64>> = record.samples.iter().map(|(u, y)| stepper.step(u, y)).collect();
        let difference = record.difference(&estimates).unwrap();
        assert_eq!(difference.largest, [0.0, 0.0], "{gains}");
        let single = exported(&study, requested, found.design, Scalar::Binary32, None).unwrap();
        assert!(Stepper::new(&single).is_ok());
    }
}

#[test]
fn one_state_and_three_states() {
    let one = "[plant]\na = [[0]]\nb = [[1]]\nc = [[1]]\n[simulation]\nduration = 2\nx0 = [1]\n[input]\nexpressions = [\"0.3\"]\n";
    let study = read(&format!("{one}{}", observer("name = \"o\"\nbound = 0.5\nperiod = 0.02"))).unwrap();
    let requested = study.observer("o").unwrap();
    let found = sampled(&study, requested, None, None).unwrap();
    let export = exported(&study, requested, found.design.clone(), Scalar::Binary64, None).unwrap();
    let mut stepper = Stepper::new(&export).unwrap();
    // xhat = 0, y = 1: corrected by h k = 0.02 0.55, moved by h u.
    let next = stepper.step(&[0.3], &[1.0]);
    assert!((next[0] - (0.02 * 0.55 + 0.02 * 0.3)).abs() < 1e-15, "{next:?}");
    let said = evidence(&study, requested, &found.design, Number::Binary64.into());
    assert!(!said.is_proved() && said.sentences[0].starts_with("No stability certificate"), "{:?}", said.sentences);

    let three = "[plant]\na = [[0, 1, 0], [0, 0, 1], [0, 0, 0]]\nc = [[1, 0, 0]]\n[simulation]\nduration = 6\nx0 = [0.1, 0.2, 0.3]\n";
    let study = read(&format!("{three}{}", observer("name = \"o\"\nbound = 1\nperiod = 0.01"))).unwrap();
    let results = execute(&study, Step::Run, &RunOptions::default()).unwrap();
    assert!(results.failures().is_empty(), "{:?}", results.failures());
    let run = &results.runs[0];
    let (last, estimate) = (run.t.len() - 1, run.estimate.as_ref().unwrap());
    for i in 0..3 {
        assert!((run.x[(last, i)] - estimate[(last, i)]).abs() < 1e-6, "x{}", i + 1);
    }
    let found = sampled(&study, study.observer("o").unwrap(), None, None).unwrap();
    assert!(exported(&study, study.observer("o").unwrap(), found.design, Scalar::Binary64, None).is_ok());
}

#[test]
fn mistakes_and_refusals_are_named() {
    let mistake = |rest: &str, expected: &str| {
        let found = read(&format!("{PENDULUM}{}", observer(rest))).unwrap_err().to_string();
        assert!(found.contains(expected), "{found}");
    };
    mistake("period = 0.01", "bound");
    mistake("bound = 1", "period");
    mistake("bound = -1\nperiod = 0.01", "-1");
    mistake("bound = 1\nperiod = 0.01\nk = [1]", "`k` has length 1");
    mistake("bound = 1\nperiod = 0.01\ndiscretisation = \"trapezoidal\"", "trapezoidal");
    let why = |plant: &str| {
        let study = read(&format!("{plant}{}", observer("name = \"o\"\nbound = 1\nperiod = 0.01"))).unwrap();
        execute(&study, Step::Design, &RunOptions::default()).unwrap().observers[0].failure.clone().unwrap().hypothesis
    };
    let coupled = why("[plant]\na = [[-1, 1], [0, 0]]\nc = [[1, 0]]\n");
    assert!(coupled.contains("x1' is not x2"), "{coupled}");
    let output = why("[plant]\na = [[0, 1], [0, 0]]\nc = [[0, 1]]\n");
    assert!(output.contains("y1 is not x1"), "{output}");
    // Gains for which the quadratic Lyapunov function does not exist: Levant's.
    let study = read(&format!("{PENDULUM}{}", observer("bound = 1\nk = [1.5, 1.1]\nperiod = 0.01"))).unwrap();
    let results = execute(&study, Step::Design, &RunOptions::default()).unwrap();
    let design = results.observers[0].design.as_ref().unwrap();
    assert!(
        design.verdict.word() == "none" && design.statement.starts_with("No stability certificate"),
        "{}",
        design.statement
    );
}
