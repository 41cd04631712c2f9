//! Filters of stiff plants, of a plant whose W enters through an integrator, and what their exports say of the steps of
//! the prediction.
//!
//! Standard deviations before the last measurement: numpy, the Kalman filter of the exact discretisation (Van Loan's
//! block exponential in scipy, divided so that it does not overflow).

use luenberger_proof::statement::Format;
use luenberger_study::deployment::{evidence, sampled};
use luenberger_study::{RunOptions, Step, execute};

use crate::studies::{filters, scratch, study, study_in};

fn observers(kinds: &[&str], keys: &str) -> String {
    let one = |kind: &&str| format!("[[observer]]\nname = \"{kind}\"\nkind = \"{kind}\"\n{keys}\n");
    kinds.iter().map(one).collect()
}

/// The standard deviations in the last row of an observer's trajectory.
#[track_caller]
fn last_deviations(folder: &str, text: &str, observer: &str, states: &[&str]) -> Vec<f64> {
    let folder = scratch(folder);
    let options = RunOptions { output: Some(folder.clone().into()), threads: Some(1), ..RunOptions::default() };
    let results = execute(&study_in(".".as_ref(), text), Step::Run, &options).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(results.failures(), Vec::<String>::new());
    let csv = std::fs::read_to_string(folder.join(format!("trajectories/{observer}.csv"))).unwrap();
    let mut lines = csv.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let last: Vec<&str> = lines.next_back().unwrap().split(',').collect();
    let column = |state: &&str| head.iter().position(|name| *name == format!("{state}_2sigma")).unwrap();
    states.iter().map(|state| last[column(state)].parse::<f64>().unwrap() / 2.0).collect()
}

#[track_caller]
fn near(found: &[f64], expected: &[f64]) {
    for (found, expected) in found.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 1e-9, "{found}, expected {expected}");
    }
}

/// A lag of 15 ms, sampled at 10 Hz, whatever steps are asked of a target.
#[test]
fn a_lag_far_below_the_period() {
    for substeps in ["", "substeps = 4", "substeps = 64"] {
        let keys = format!("initial = [0, 0]\np0 = 0.01\nw = [1e-6, 0.01]\nv = 1e-4\nperiod = 0.1\n{substeps}");
        let text = format!(
            "[plant]\nstates = [\"pos\", \"cur\"]\ninputs = [\"u\"]\nf = [\"cur\", \"(u - cur)/0.015\"]\nh = [\"pos\"]\n\
             [input]\nexpressions = [\"sin(t)\"]\n\
             [simulation]\nx0 = [0.05, 0.05]\nduration = 20\nhold = 0.1\nestimates = \"predicted\"\n{}",
            observers(&filters(), &keys)
        );
        for kind in filters() {
            near(&last_deviations("stiff-lag", &text, kind, &["pos", "cur"]), &[0.002418333729, 0.008660254037]);
        }
    }
}

/// A motor with R/L = 667/s, sampled at 100 Hz.
#[test]
fn a_motor_with_a_fast_winding() {
    let text = format!(
        "[plant]\nstates = [\"angle\", \"speed\", \"current\"]\ninputs = [\"volts\"]\n\
         f = [\"speed\", \"(k*current - b*speed)/J\", \"(volts - R*current - k*speed)/Ls\"]\nh = [\"angle\"]\n\
         parameters = {{ k = 0.05, b = 1e-4, J = 1e-4, R = 2, Ls = 0.003 }}\n[input]\nexpressions = [\"6*sin(2*t)\"]\n\
         [simulation]\nx0 = [0, 0, 0]\nduration = 5\nhold = 0.01\nestimates = \"predicted\"\n{}",
        observers(
            &filters(),
            "initial = [0.1, 10, 0]\np0 = [0.01, 100, 0.01]\nw = [1e-6, 1, 0.1]\nv = 2.5e-5\nperiod = 0.01"
        )
    );
    for kind in filters() {
        let found = last_deviations("stiff-motor", &text, kind, &["angle", "speed", "current"]);
        near(&found, &[0.004152050875, 0.158423073526, 0.009403313216]);
    }
}

/// Constant velocity: W enters the position as W h^3/3.
#[test]
fn noise_through_an_integrator() {
    let text = format!(
        "[plant]\nstates = [\"pos\", \"vel\"]\nf = [\"vel\", \"0\"]\nh = [\"pos\"]\n\
         [simulation]\nx0 = [0, 0]\nduration = 400\nestimates = \"predicted\"\n{}",
        observers(&filters(), "p0 = 1\nw = [0, 1]\nv = 0.0025\nperiod = 1")
    );
    for kind in filters() {
        near(&last_deviations("integrated-noise", &text, kind, &["pos", "vel"]), &[0.800829989519, 1.139856858363]);
    }
}

fn of_rate(rate: &str, keys: &str) -> String {
    format!(
        "[plant]\nstates = [\"a\", \"b\"]\nf = [\"-{rate}*(a - cos(b))\", \"a - 0.1*b^3\"]\nh = [\"b\"]\n\
         [simulation]\nx0 = [0.5, 0.2]\nduration = 20\n{}",
        observers(&filters(), &format!("w = [0.01, 0.01]\nv = 1e-4\np0 = 0.1\nperiod = 0.5\n{keys}"))
    )
}

/// An export takes as many steps as its error needs, says how large it is, and refuses where a hundred are not enough:
/// with the fastest mode, over the period.
#[test]
fn an_export_states_the_error_of_its_prediction() {
    let said = |text: &str, kind: &str, substeps: Option<usize>| {
        let study = study(text);
        let observer = study.observer(kind).unwrap();
        sampled(&study, observer, None, substeps).map(|found| {
            let said = evidence(&study, observer, &found.design, Format::Binary64.into());
            (found.design.substeps(), said.sentences.join(" "))
        })
    };
    for kind in filters() {
        let measured = |words: &str| -> f64 {
            let error = words.split("was measured: at most ").nth(1).and_then(|rest| rest.split(' ').next());
            error.unwrap_or_else(|| panic!("{words}")).parse().unwrap()
        };
        let (substeps, words) = said(&of_rate("3", ""), kind, None).unwrap();
        let substeps = substeps.unwrap();
        assert!(substeps > 1 && measured(&words) > 1e-8 && measured(&words) <= 1e-3, "{words}");
        // Half of them are not enough, whether they are said to be or refused.
        let half = said(&of_rate("3", ""), kind, Some(substeps / 2));
        assert!(
            half.is_err_and(|why| why.hypothesis.contains("standard deviations")) || {
                let (_, words) = said(&of_rate("3", ""), kind, Some(substeps / 2)).unwrap();
                measured(&words) > 1e-3
            }
        );
        let (given, words) = said(&of_rate("3", "substeps = 40"), kind, None).unwrap();
        assert!(given == Some(40) && words.contains("A prediction takes 40 steps"), "{given:?} {words}");
        let refused = said(&of_rate("1e6", ""), kind, None).unwrap_err();
        let why = &refused.hypothesis;
        assert!(
            why.contains("more than 100 Runge-Kutta steps per period") && why.contains("|lambda| h = 500000"),
            "{why}"
        );
        let unstable = said(&of_rate("30", ""), kind, Some(2)).unwrap_err();
        assert!(
            unstable.hypothesis.starts_with("a prediction with 2 Runge-Kutta steps has "),
            "{}",
            unstable.hypothesis
        );
    }
    // No steps, and a run whose first prediction has no result, are refused: nothing is measured over no sample.
    let nowhere = "[plant]\nf = [\"x1^3\"]\nh = [\"x1\"]\n[simulation]\nx0 = [1]\nduration = 2\n";
    for kind in filters() {
        let none = said(&of_rate("3", ""), kind, Some(0)).unwrap_err();
        assert!(none.hypothesis.contains("at least one"), "{}", none.hypothesis);
        let text = format!("{nowhere}{}", observers(&[kind], "w = 1\nv = 1e-4\nperiod = 1\ninitial = [1]"));
        let refused = said(&text, kind, None).unwrap_err();
        assert!(refused.hypothesis.contains("cannot be measured"), "{}", refused.hypothesis);
    }
    // The plant of the lag is linear.
    let lag = "[plant]\nf = [\"x2\", \"-1e6*x2\"]\nh = [\"sin(x1)\"]\n[simulation]\nx0 = [0.05, 0.05]\nduration = 2\n";
    for kind in filters() {
        let text = format!("{lag}{}", observers(&[kind], "w = [0, 1]\nv = 1e-4\nperiod = 0.1"));
        let (substeps, words) = said(&text, kind, None).unwrap();
        assert!(substeps.is_none() && words.contains("the prediction is its exact discretisation"), "{words}");
    }
}
