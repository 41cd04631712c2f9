//! NIS and NEES of stationary Kalman filters: of a random walk with W = 1 and V = 2, whose stationary prediction has
//! the variance 2, so that S = 4, K = 1/2 and the estimate has the variance 1.

use std::fmt::Write as _;

use luenberger_study::{RunOptions, Step, execute};

use crate::studies::{executed, scratch, study_in};

fn walk(data: &str, form: &str) -> String {
    format!(
        "[plant]\nstates = [\"x\"]\noutputs = [\"y\"]\na = [[1]]\nb = [[0]]\nc = [[1]]\ndt = 1\n{data}\n\
         [[observer]]\nname = \"filter\"\nkind = \"kalman\"\nw = 1\nv = 2\ninitial = [3]\n{form}"
    )
}

/// True state and measurement of each row.
fn rows() -> Vec<(f64, f64)> {
    (0..60)
        .map(f64::from)
        .map(|k| ((0.3 * k).sin() * 2.0 + 0.1 * k, (1.7 * k * k).cos()))
        .map(|(x, v)| (x, x + v))
        .collect()
}

/// The recursion by hand, over the rows of the second half: means of `nu^2/4` and of the squared error over its
/// variance.
fn by_hand(is_filter: bool, missing: impl Fn(usize) -> bool) -> (f64, f64, usize) {
    let (mut prediction, mut nis, mut nees) = (3.0, Vec::new(), Vec::new());
    for (k, (x, y)) in rows().into_iter().enumerate() {
        let before = prediction;
        if !missing(k) {
            let innovation = y - prediction;
            prediction += innovation / 2.0;
            if k >= 30 {
                nis.push(innovation * innovation / 4.0);
                nees.push(if is_filter { (x - prediction).powi(2) } else { (x - before).powi(2) / 2.0 });
            }
        }
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    (mean(&nis), mean(&nees), nis.len())
}

#[test]
fn on_a_log_they_are_those_of_the_recursion() {
    let missing = |k: usize| k % 7 == 5;
    let mut log = "t,y,truth,none\n".to_owned();
    for (k, (x, y)) in rows().into_iter().enumerate() {
        let y = if missing(k) { String::new() } else { y.to_string() };
        writeln!(log, "{k},{y},{x},0").unwrap();
    }
    for (form, is_filter) in [("form = \"filter\"\n", true), ("", false)] {
        let folder = scratch("stationary-log");
        std::fs::write(folder.join("log.csv"), &log).unwrap();
        let data = "[log]\nfile = \"log.csv\"\ninputs = [\"none\"]\nstates = [\"truth\"]";
        let study = study_in(&folder, &walk(data, form));
        let results = execute(&study, Step::Simulate, &RunOptions::default()).unwrap();
        let row = &results.log.as_ref().unwrap().rows[0];
        let (nis, nees, samples) = by_hand(is_filter, missing);
        let (found, errors) = (row.nis.as_ref().unwrap(), row.nees.as_ref().unwrap());
        assert!((found.mean - nis).abs() < 1e-9 && found.samples == samples && found.expected == 1.0, "{found:?}");
        assert!((errors.mean - nees).abs() < 1e-9 && errors.samples == samples, "{errors:?} for {nees}");
    }
}

/// What an input adds to the output at once is part of the prediction: the innovations are those without it.
#[test]
fn an_input_in_the_output_leaves_the_innovations() {
    let data = "[input]\nexpressions = [\"sin(0.3*t)\"]\n[simulation]\nx0 = [1]\nduration = 100\n\
                noise = { distribution = \"gaussian\", amplitude = [1.4], period = 0.5, seed = 5 }";
    for form in ["form = \"filter\"\n", ""] {
        let [without, with] = ["", "d = [[3]]\n"].map(|d| {
            let text = walk(data, form).replace("dt = 1\n", &format!("{d}dt = 0.5\n"));
            let results = executed(&text, Step::Simulate);
            let filter = &results.filters[0];
            (filter.nis.as_ref().unwrap().mean, filter.nees.as_ref().unwrap().mean)
        });
        assert!(without.0 > 0.1 && (without.0 - with.0).abs() < 1e-9, "{without:?}, {with:?}");
        assert!((without.1 - with.1).abs() < 1e-9, "{without:?}, {with:?}");
    }
}

/// With noise as it is assumed both are accepted in 19 of 20 runs, with a quarter of its variance neither is.
#[test]
fn in_a_simulation_they_say_whether_the_noise_is_as_assumed() {
    for form in ["form = \"filter\"\n", ""] {
        for (amplitude, is_right) in [(2f64.sqrt(), true), (0.5f64.sqrt(), false)] {
            let (mut accepted, mut both) = (0, 0);
            for seed in 0..20 {
                let data = format!(
                    "[simulation]\nx0 = [1]\nduration = 400\n\
                     noise = {{ distribution = \"gaussian\", amplitude = [{amplitude}], period = 1, seed = {seed} }}\n\
                     [truth]\nprocess_noise = {{ distribution = \"gaussian\", amplitude = [{}], period = 1, seed = {seed} }}",
                    if is_right { 1.0 } else { 0.5 }
                );
                let results = executed(&walk(&data, form), Step::Simulate);
                let [found] = &results.filters[..] else { panic!("{:?}", results.filters) };
                assert!(found.stationary && results.text(true).contains("with their stationary covariances"));
                accepted += usize::from(found.nis.as_ref().unwrap().accepted);
                both += usize::from(found.nees.as_ref().unwrap().mean < 1.0);
            }
            if is_right {
                assert!(accepted >= 16 && (5..=15).contains(&both), "{accepted} {both}");
            } else {
                assert!(accepted == 0 && both == 20, "{accepted} {both}");
            }
        }
    }
}

/// A gain that is given has no covariance.
#[test]
fn other_gains_have_none() {
    let text = walk("[simulation]\nx0 = [1]\nduration = 20", "")
        .replace("kind = \"kalman\"\nw = 1\nv = 2", "kind = \"luenberger\"\npoles = [0.5]");
    assert!(executed(&text, Step::Simulate).filters.is_empty());
}
