//! Scores: where they are taken, in which units, and what is said where there are none.

use std::path::{Path, PathBuf};

use luenberger_study::results::{NormReport, StateReport};
use luenberger_study::{Results, RunOptions, Step, Study, execute, template};

use crate::studies::{self, study};

fn scratch(name: &str) -> PathBuf {
    studies::scratch(&format!("scores/{name}"))
}

fn run(study: &Study, step: Step) -> Results {
    execute(study, step, &RunOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// Columns by name.
fn columns(path: &Path, names: &[&str]) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).unwrap();
    let head: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let place = |name: &&str| head.iter().position(|column| column == name).unwrap();
    let column = |k: usize| text.lines().skip(1).map(|line| line.split(',').nth(k).unwrap().parse().unwrap()).collect();
    names.iter().map(|name| column(place(name))).collect()
}

/// The scores of an error at samples, computed anew.
fn anew(t: &[f64], e: &[f64]) -> StateReport {
    let largest = |e: &[f64]| e.iter().fold(0.0f64, |largest, e| largest.max(e.abs()));
    let rms = |e: &[f64]| (e.iter().map(|e| e * e).sum::<f64>() / e.len() as f64).sqrt();
    let crossed = e.iter().position(|x| x * e[0] < 0.0);
    let settles = |share: f64| {
        let outside = (0..e.len()).filter(|k| e[*k].abs() > share * e[0].abs()).max();
        outside.map_or(Some(t[0]), |k| t.get(k + 1).copied())
    };
    StateReport {
        state: String::new(),
        unit: None,
        initial: e[0],
        rmse: rms(e),
        steady_rmse: rms(&e[e.len() / 2..]),
        peak: largest(e),
        overshoot: crossed.map_or(0.0, |k| largest(&e[k..])),
        settling_5: settles(0.05),
        settling_2: settles(0.02),
        last: e[e.len() - 1].abs(),
    }
}

/// The rows of a sampled observer are its samples, those of the others hold its samples: every score of the template is
/// computed anew from the CSV files.
#[test]
fn the_scores_are_those_of_the_rows() {
    let study = Study { sweep: None, ..study(template::text("double-integrator").unwrap()) };
    let folder = scratch("rows");
    let options = RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() };
    let results = execute(&study, Step::Simulate, &options).unwrap();
    let simulation = results.simulation.unwrap();
    assert_eq!(simulation.scoring.period, Some(0.02));
    assert_eq!(simulation.scoring.words[0], "Scores at the samples, every 0.02 s.");
    assert_eq!(simulation.scoring.words[1], "Norm |e| in units of scale = [1 m, 1 m/s].");
    // One number for more than six states is said once.
    let scale = |scale: &[f64]| {
        let n = scale.len();
        let row =
            |i: usize| format!("[{}]", (0..n).map(|j| if i == j { "-1" } else { "0" }).collect::<Vec<_>>().join(", "));
        let a = (0..n).map(row).collect::<Vec<_>>().join(", ");
        let (c, x0) = (vec!["1"; n].join(", "), vec!["1"; n].join(", "));
        let text = format!(
            "[plant]\na = [{a}]\nc = [[{c}]]\n[simulation]\nx0 = [{x0}]\nduration = 1\nscale = {scale:?}\n\
             [[observer]]\nkind = \"luenberger\"\ngain = [{}]\n",
            vec!["[0.1]"; n].join(", ")
        );
        crate::studies::executed(&text, Step::Simulate).simulation.unwrap().scoring.words[1].clone()
    };
    assert_eq!(scale(&[2.0; 7]), "Norm |e| in units of scale = [2, ..].");
    assert_eq!(scale(&[2.0; 6]), "Norm |e| in units of scale = [2, 2, 2, 2, 2, 2].");
    assert_eq!(scale(&[2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 3.0]), "Norm |e| in units of scale = [2, 2, 2, 2, 2, 2, 3].");
    for row in &simulation.rows {
        let names = ["t", "position", "velocity", "position_hat", "velocity_hat"];
        let mut table = columns(&folder.join(format!("trajectories/{}.csv", row.observer)), &names);
        assert_eq!(table[0].len(), if row.observer == "sampled" { 201 } else { 401 });
        if row.observer != "sampled" {
            table = table.into_iter().map(|column| column.into_iter().step_by(2).collect()).collect();
        }
        let t = &table[0];
        let errors: Vec<Vec<f64>> =
            (1..3).map(|i| table[i].iter().zip(&table[i + 2]).map(|(x, xhat)| x - xhat).collect()).collect();
        let merits = row.merits.as_ref().unwrap();
        let same = |a: f64, b: f64| assert!((a - b).abs() <= 1e-9 * b.abs() + 1e-12, "{}: {a} {b}", row.observer);
        for (i, found) in merits.states.iter().enumerate() {
            let wished = anew(t, &errors[i]);
            same(merits.rms_by_state[i], wished.rmse);
            let numbers = |scores: &StateReport| {
                let [five, two] = [scores.settling_5, scores.settling_2].map(Option::unwrap);
                let others = [scores.initial, scores.rmse, scores.peak, scores.overshoot, scores.last];
                others.into_iter().chain([five, two, scores.steady_rmse])
            };
            // The extrema of observers in continuous time are those of all times.
            let rows = if row.observer == "sampled" {
                found.clone()
            } else {
                assert!(found.peak >= wished.peak && found.overshoot >= wished.overshoot);
                assert!(found.peak < 1.01 * wished.peak && found.overshoot < 1.01 * wished.overshoot);
                StateReport { peak: wished.peak, overshoot: wished.overshoot, ..found.clone() }
            };
            numbers(&rows).zip(numbers(&wished)).for_each(|(a, b)| same(a, b));
        }
        let norm: Vec<f64> = errors[0].iter().zip(&errors[1]).map(|(a, b)| a.hypot(*b)).collect();
        let wished = anew(t, &norm);
        let NormReport { initial, band, settling_last, peak, rms, last, steady_rms, .. } = merits.norm.clone().unwrap();
        for (a, b) in [(initial, wished.initial), (band, 0.05 * initial), (peak, wished.peak), (rms, wished.rmse)] {
            same(a, b);
        }
        same(last, wished.last);
        same(steady_rms, wished.steady_rmse);
        same(settling_last.unwrap(), wished.settling_5.unwrap());
    }
}

/// A cart that rolls on is estimated without error at the samples; between them the estimate that was held lagged.
const ROLLING: &str = r#"
[plant]
a = [[0, 1], [0, 0]]
c = [[1, 0]]
[simulation]
x0 = [1, 2]
duration = 20
samples = 11
[[observer]]
name = "sampled"
kind = "sampled-cubic"
poles = [-2, -3]
gamma = 0.1
period = 0.5
"#;

#[test]
fn a_sampled_observer_that_converges_settles() {
    let results = run(&study(ROLLING), Step::Compare);
    let simulation = results.simulation.unwrap();
    let merits = simulation.rows[0].merits.clone().unwrap();
    // Its slowest pole is exp(-2 * 0.5): exp(-40) at the end.
    for state in &merits.states {
        assert!(state.last < 1e-9 && state.settling_2.is_some(), "{state:?}");
    }
    // Without a scale there is no norm anywhere.
    assert!(merits.norm.is_none() && simulation.scoring.scale.is_none());
    let said = &simulation.scoring.words[1];
    assert!(said.starts_with("No norm of the error") && said.contains("set simulation.scale"), "{said}");
    let json = serde_json::to_value(&merits).unwrap();
    assert_eq!(json.as_object().unwrap().keys().collect::<Vec<_>>(), ["rms_by_state", "states"]);
}

#[test]
fn without_a_scale_no_norm_is_drawn_or_swept() {
    let text = format!("{ROLLING}[sweep]\nparameter = \"gamma\"\nvalues = [0.1, 0.2]\nensemble = 3\n");
    let folder = scratch("no-scale");
    let options = RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() };
    let results = luenberger_study::run(&study(&text), &options).unwrap();
    assert!(!folder.join("figures/error-norm.svg").exists() && folder.join("figures/errors.svg").exists());
    assert!(folder.join("figures/sweep.svg").exists());
    let sweep = results.sweep.unwrap();
    for row in &sweep.rows {
        assert_eq!((row.finished, row.rms, row.peak, row.last, row.settling), (3, None, None, None, None));
        assert!(row.states.len() == 2 && row.states[1].rmse > 0.0);
    }
    let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(page.contains("set simulation.scale") && !page.contains("rms |e|"));
}

/// The widths of a region are a scale, if all observers with a region agree.
#[test]
fn the_widths_of_the_region_are_a_scale() {
    let text = r#"
[plant]
f = ["x2", "-sin(x1) - 0.1*x2"]
h = ["x1"]
states = ["angle", "speed"]
[simulation]
x0 = [1, 0]
duration = 5
[[observer]]
name = "one"
kind = "lpv"
region = { states = [[-2, 2], [-0.5, 0.5]] }
decay_rate = 0.5
[[observer]]
name = "free"
kind = "high-gain"
r = 0.2
"#;
    let results = run(&study(text), Step::Compare);
    let simulation = results.simulation.as_ref().unwrap();
    assert_eq!(simulation.scoring.scale, Some(vec![4.0, 1.0]));
    assert!(simulation.scoring.words[1].ends_with("the widths of the design region."), "{:?}", simulation.scoring);
    let norm = simulation.rows[0].merits.as_ref().unwrap().norm.as_ref().unwrap();
    assert!((norm.initial - 0.25).abs() < 1e-12, "{norm:?}");
    let other = text.replace(
        "kind = \"high-gain\"\nr = 0.2",
        "kind = \"lpv\"\nregion = { states = [[-2, 2], [-9, 9]] }\ndecay_rate = 0.5",
    );
    assert_eq!(run(&study(&other), Step::Compare).simulation.unwrap().scoring.scale, None);
    // A region without an end has no width.
    let half = text.replace("[-0.5, 0.5]", "[-0.5, inf]");
    assert_eq!(run(&study(&half), Step::Compare).simulation.unwrap().scoring.scale, None);
}

/// The pendulum swings past its region: the speed reaches 0.9, and every step that runs it says so.
#[test]
fn a_run_outside_the_region_is_warned_of_by_every_step() {
    let text = r#"
[plant]
f = ["x2", "-sin(x1)"]
h = ["x1"]
states = ["angle", "speed"]
[simulation]
x0 = [1, 0]
duration = 5
samples = 2
[[observer]]
name = "one"
kind = "lpv"
region = { states = [[-2, 2], [-0.5, 0.5]] }
decay_rate = 0.5
initial = [1, 0]
[sweep]
parameter = "initial"
values = [0.5, 1]
"#;
    let study = study(text);
    // scipy 1.17.1, `solve_ivp` with DOP853: the speed is beyond 0.5 first at t = 0.61658, and for 63.0 % of the run;
    // at t = 0.62693, the first point of a step after that, it is -0.50771.
    let warned = "Guarantee not valid outside the design region: one: outside for 63 % of the run, first at t = 0.62693, where speed = -0.50771 is";
    for step in [Step::Simulate, Step::Compare, Step::Run] {
        let warnings = run(&study, step).warnings;
        assert!(warnings.iter().any(|text| text.starts_with(warned)), "{step:?}: {warnings:?}");
    }
    let warnings = run(&study, Step::Sweep).warnings;
    let warned = "Guarantee not valid outside the design region: one: left in 2 of 2 runs of the sweep, first with initial = 0.5 at t = 0.62";
    assert!(warnings.iter().any(|text| text.starts_with(warned)), "{warnings:?}");
    assert!(run(&study, Step::Design).warnings.is_empty());
}

/// A division by zero is named with the state, and no table is empty.
#[test]
fn observers_that_all_fail_say_why() {
    let text = r#"
[plant]
f = ["-1", "1/level"]
h = ["level", "volume"]
states = ["level", "volume"]
[simulation]
x0 = [1, 0]
duration = 2
[[observer]]
name = "gain"
kind = "extended-kalman"
w = 1
v = 1
period = 0.1
initial = [1, 0]
"#;
    let results = run(&study(text), Step::Compare);
    let simulation = results.simulation.as_ref().unwrap();
    let why = simulation.rows[0].failure.as_ref().unwrap();
    // The last prediction ends at the division by zero.
    assert!(why.starts_with("stopped at t = 0.9: the estimate of \"gain\" becomes NaN with this sample: "), "{why}");
    assert!(why.contains("on the way to the next one f or its Jacobian is not finite"), "{why}");
    let warned = "The plant alone: stopped at t = 1: the derivative of volume is unbounded there";
    assert!(results.warnings.iter().any(|text| text.starts_with(warned)), "{:?}", results.warnings);
    assert!(simulation.norm_table(&results.plant).is_none() && simulation.state_table(&results.plant, 6).is_none());
    assert_eq!(simulation.ended(), [format!("gain: {why}")]);
}

/// Noise that leaves more than the first error is warned of in the state in which it does so most, and not in one that
/// begins without an error.
#[test]
fn noise_beyond_the_first_error_is_warned_of_in_its_state() {
    let warnings = |x0: &str| {
        let text = format!(
            "[plant]\na = [[0, 1], [0, 0]]\nc = [[1, 0]]\n[[observer]]\nkind = \"luenberger\"\npoles = [-2, -5]\n\
             [simulation]\nx0 = {x0}\nduration = 1\nnoise = {{ amplitude = [0.1], period = 0.01 }}\n"
        );
        let about = "the measurement noise alone leaves an error of standard deviation";
        let all = run(&study(&text), Step::Compare).warnings;
        all.into_iter().filter(|warning| warning.contains(about)).collect::<Vec<_>>()
    };
    for (x0, end) in [
        ("[1e-6, 1e-3]", " in x1, more than the initial error 1e-6;"),
        ("[1e-3, 1e-6]", " in x2, more than the initial error 1e-6;"),
        ("[0, 1e-3]", " in x2, more than the initial error 0.001;"),
    ] {
        let found = warnings(x0);
        assert!(found.len() == 1 && found[0].contains(end), "{x0}: {found:?}");
    }
    assert!(warnings("[10, 10]").is_empty());
}
