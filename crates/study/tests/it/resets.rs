//! Resets of the open integration of PEB observers: what they leave as it is, and that they are events of a run and of
//! an exported step.

use luenberger_export::Scalar;
use luenberger_export::golden::Stepper;
use luenberger_observers::Observer;
use luenberger_sim::{Disturbances, Fault, Recording, Replay, Scenario, Settings, Trajectory};
use luenberger_study::Study;
use luenberger_study::deployment;
use luenberger_study::design::Designed;
use luenberger_study::kinds::PebObserver;
use luenberger_study::study::SamplingSpec;
use nalgebra::{DMatrix, DVector};

use crate::studies::{designed, mistakes, read};

/// Van der Pol's oscillator: `z = x2 - x1 + x1^3/3` has `z' = -x1`, and `y' = z + y - y^3/3`.
pub(crate) const STUDY: &str = r#"[plant]
f = ["x2", "(1 - x1^2)*x2 - x1"]
h = ["x1"]
[simulation]
x0 = [2, 0]
duration = 20
[[observer]]
kind = "pebo"
phi = ["x2 - x1 + x1^3/3"]
b = ["-y1"]
left_inverse = ["y1", "xi1 + y1 - y1^3/3"]
s = ["y1"]
g = ["xi1 + y1 - y1^3/3"]
m = [1]
alpha = 2
estimator = { kind = "gradient", gain = 2 }
region = { states = [[-3, 3], [-4, 4]] }
initial = [2, 1]
"#;

fn study(lines: &str) -> Study {
    read(&format!("{STUDY}{lines}\n")).unwrap_or_else(|error| panic!("{error}"))
}

fn run(study: &Study, designed: &Designed, from: (f64, &[f64], &[f64]), to: f64, bias: f64) -> Trajectory {
    let (start, x0, estimate) = from;
    let fault = Fault { gain: vec![1.0], bias: vec![bias], from: 0.0 };
    let scenario = Scenario::new(&study.plant.model)
        .initial_state(x0)
        .start(start)
        .tolerances(1e-12, 1e-13)
        .disturbances(Disturbances { sensor: Some(fault), ..Disturbances::default() })
        .until(to, 201);
    designed.runnable.join(scenario, "pebo", estimate, &SamplingSpec::default()).run().unwrap()
}

fn largest(run: &Trajectory, entry: usize) -> f64 {
    run.observer("pebo").unwrap().state.column(entry).rows(101, 100).amax()
}

/// The bias of y makes xi drift, and theta_hat the other way. With resets both stay where they are after the transient
/// of 10, and the estimate is that without resets to the tolerance, for every estimator.
#[test]
fn resets_bound_the_integral_and_leave_the_estimate() {
    let drem =
        |extension: &str| STUDY.replace("kind = \"gradient\", gain", &format!("kind = \"drem\", {extension}, gain"));
    let open = designed(&study("")).unwrap();
    let (bias, end, from) = (0.05, 100.0, (0.0, &[2.0, 0.0][..], &[2.0, 1.0][..]));
    let without = run(&study(""), &open, from, end, bias);
    assert!(largest(&without, 0) > 5.0, "{}", largest(&without, 0));
    for text in [STUDY.to_owned(), drem("forgetting = 1")] {
        let plain = read(&text).unwrap();
        let with = read(&format!("{text}reset = {{ period = 7 }}\n")).unwrap();
        let resetting = designed(&with).unwrap();
        assert!(resetting.report.statement.contains("the estimates are those without resets"));
        let (plain, with) =
            (run(&plain, &designed(&plain).unwrap(), from, end, bias), run(&with, &resetting, from, end, bias));
        assert!(largest(&with, 0) < 2.5 + 7.0 * bias, "{}", largest(&with, 0));
        assert!(largest(&plain, 0) > 5.0);
        let estimate = |run: &Trajectory| run.observer("pebo").unwrap().estimate.clone();
        let apart = (estimate(&plain) - estimate(&with)).amax();
        assert!(apart < 1e-8, "{text}\n{apart:e}");
    }
    // A level that is passed on the way: as many resets as are needed, and not at every instant.
    let with = study("reset = { period = 1, above = 4 }");
    let run = run(&with, &designed(&with).unwrap(), from, end, bias);
    assert!(largest(&run, 0) < 4.0 + bias + 3.0 && largest(&run, 0) > 3.0, "{}", largest(&run, 0));
    let drift = run.observer("pebo").unwrap().estimate.clone() - without.observer("pebo").unwrap().estimate.clone();
    assert!(drift.amax() < 1e-8, "{:e}", drift.amax());
}

/// `missing = 2 theta` is not the plain theta: the filters begin again, and the run is that of observers which are
/// started anew with the estimate at each reset.
#[test]
fn a_reset_that_restarts_the_filters_is_a_new_start() {
    let text = STUDY.replace("m = [1]", "m = [2]\nmissing = [\"2*theta1\"]");
    let (plain, with) = (read(&text).unwrap(), read(&format!("{text}reset = {{ period = 1.5 }}\n")).unwrap());
    let (open, resetting) = (designed(&plain).unwrap(), designed(&with).unwrap());
    assert!(resetting.report.statement.contains("the excitation since the last reset is lost"));
    let whole = run(&with, &resetting, (0.0, &[2.0, 0.0], &[2.0, 1.0]), 6.0, 0.0);
    let (mut x, mut estimate) = (vec![2.0, 0.0], vec![2.0, 1.0]);
    for k in 0..4 {
        let start = 1.5 * f64::from(k);
        let piece = run(&plain, &open, (start, &x, &estimate), start + 1.5, 0.0);
        let last = piece.t.len() - 1;
        x = piece.x.row(last).iter().copied().collect();
        estimate = piece.observer("pebo").unwrap().estimate.row(last).iter().copied().collect();
        let row = 50 * (k as usize + 1);
        assert!((whole.t[row] - (start + 1.5)).abs() < 1e-12);
        let found = whole.observer("pebo").unwrap().estimate.row(row);
        let apart = (found[0] - estimate[0]).abs().max((found[1] - estimate[1]).abs());
        assert!(apart < 1e-8, "{k} {apart:e}");
    }
    // The reset itself: xi takes over what theta adds, and the filters are those of a start.
    let observer = resetting.runnable.of::<PebObserver>().unwrap();
    let state = DVector::from_column_slice(&[0.5, 0.1, 0.2, 0.3, 0.25]);
    let after = observer.jump(0.0, &state, &DVector::zeros(0), &DVector::from_element(1, 0.7));
    assert_eq!(after.as_slice(), [1.0, 0.7, 0.0, 0.0, 0.0]);
}

/// On a log as in a simulation: the estimates with and without resets are the same.
#[test]
fn resets_on_a_log_leave_the_estimate() {
    let times: Vec<f64> = (0..=400).map(|k| 0.05 * f64::from(k)).collect();
    let y = DMatrix::from_iterator(times.len(), 1, times.iter().map(|t| 2.0 * t.cos() + 0.1));
    let on_log = |lines: &str| {
        let study = study(lines);
        let recording = Recording::new(times.clone(), DMatrix::zeros(times.len(), 0), y.clone()).unwrap();
        let replay = Replay::new(&study.plant.model, recording).settings(Settings {
            rtol: 1e-11,
            atol: 1e-12,
            ..Settings::default()
        });
        let run = designed(&study).unwrap().runnable.replay(replay, "pebo", &[2.0, 1.0]).run().unwrap();
        run.observers[0].estimate.clone()
    };
    let without = on_log("");
    // At rows, and between them.
    for period in [0.5, 0.33] {
        let with = on_log(&format!("reset = {{ period = {period} }}"));
        let apart = (&with - &without).amax();
        assert!(apart < 1e-8 && with != without, "{period} {apart:e}");
    }
}

/// The exported step with resets: its estimates are those without, up to rounding, and a period that is no part of
/// that of the resets is refused.
#[test]
fn an_exported_step_resets_at_its_samples() {
    let open = study("");
    let sampled = deployment::sampled(&open, &open.observers[0], Some(0.05), None).unwrap();
    let record = deployment::record(&open, &open.observers[0], &sampled).unwrap();
    let steps = |lines: &str| {
        let study = study(lines);
        let observer = &study.observers[0];
        let sampled = deployment::sampled(&study, observer, Some(0.05), None).unwrap();
        let export = deployment::exported(&study, observer, sampled.design, Scalar::Binary64, None).unwrap();
        let mut stepper = Stepper::new(&export).unwrap();
        record.samples.iter().map(|(u, y)| stepper.step(u, y)).collect::<Vec<_>>()
    };
    let (without, with) = (steps(""), steps("reset = { period = 0.5 }"));
    assert!(without.len() > 300);
    for (without, with) in without.iter().zip(&with) {
        assert!((without[1] - with[1]).abs() < 1e-10, "{without:?} {with:?}");
    }
    assert!(without != with);
    let odd = study("reset = { period = 0.5 }");
    let refused = deployment::sampled(&odd, &odd.observers[0], Some(0.03), None).unwrap_err();
    assert!(
        refused.hypothesis.contains("0.5, is not a multiple of the sampling period 0.03"),
        "{}",
        refused.hypothesis
    );
}

#[test]
pub(crate) fn mistakes_in_resets_are_reported_at_their_place() {
    let text = |lines: &str| format!("{STUDY}{lines}\n");
    for (text, message, expected) in [
        (text("reset = { period = 0 }"), "`period` is 0", "positive"),
        (text("reset = { above = 3 }"), "reset has no `period`", "positive"),
        (text("reset = { period = 1, above = -1 }"), "`above` is -1", "positive"),
        (text("reset = 3"), "reset is a number", "table"),
        (text("leakage = 1\nreset = { period = 1 }"), "`reset` conflicts with `leakage`", "one of them"),
        (text("theta_min = [-1]\nreset = { period = 1 }"), "`reset` conflicts with `theta_min`", "one of them"),
    ] {
        let found = mistakes(&text);
        assert!(found[0].message.contains(message), "{found:?}");
        assert!(format!("{} {:?}", found[0].expected, found[0].help).contains(expected), "{found:?}");
    }
}
