//! Observers at varying periods in studies: what a simulation draws, and what is said of it.

use std::fmt::Write as _;

use luenberger_export::{Scalar, golden};
use luenberger_study::deployment;
use luenberger_study::{Results, RunOptions, Step, execute};

use crate::studies::{executed, mistake, scratch, study, study_in};

pub(crate) const STUDY: &str = include_str!("../studies/varying_periods.toml");

/// Within the periods of the design: no warning, also not of the input, which need not be held. The scores are in
/// continuous time, from the error at the start.
#[test]
fn a_run_within_the_periods_of_the_design() {
    let folder = scratch("varying-periods");
    let options = RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() };
    let results = execute(&study(STUDY), Step::Run, &options).unwrap();
    assert!(results.warnings.is_empty(), "{:?}", results.warnings);
    let simulation = results.simulation.unwrap();
    assert_eq!(simulation.scoring.period, None);
    for (row, sampling) in simulation.rows.iter().zip(&simulation.sampling) {
        let norm = row.merits.as_ref().unwrap().norm.as_ref().unwrap();
        assert!((norm.initial - 10f64.sqrt()).abs() < 1e-12 && norm.last < 1e-3, "{}: {norm:?}", row.observer);
        assert!(sampling.within_design && sampling.observer == row.observer, "{sampling:?}");
    }
    let [radial, weighted] = simulation.sampling.as_slice() else { panic!("{:?}", simulation.sampling) };
    assert!(radial.missed > 0 && radial.missed_in_a_row == 2 && radial.shortest >= 0.0699 && radial.longest <= 0.1401);
    assert!(weighted.missed == 0 && weighted.shortest >= 0.0899 && weighted.longest <= 0.1201);
    let end = format!(
        "{} missed, at most 2 in a row (seed 0). Convergence is proved for them: periods from 0.07 to 0.14 with at most 2 \
         missed samples in a row.",
        radial.missed
    );
    assert!(radial.words.starts_with("radial: ") && radial.words.ends_with(&end), "{}", radial.words);
    let table = std::fs::read_to_string(folder.join("trajectories/samples-radial.csv")).unwrap();
    assert!(table.starts_with("t,arrives,elapsed\n") && table.lines().count() == radial.samples + 1, "{table}");
    assert!(folder.join("figures/samples.svg").exists());
    let report = std::fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(report.contains("Convergence is proved for them"));
}

/// Wider bounds of the simulation, with a seed of their own: the run is said to be outside, with the first sample.
#[test]
fn a_run_outside_the_periods_of_the_design_is_said_to_be() {
    let wider = format!("{STUDY}[simulation.sampling]\njitter = [0.05, 0.2]\nmisses = 5\nseed = 7\n");
    let outside = executed(&wider, Step::Simulate);
    let simulation = outside.simulation.unwrap();
    assert!(simulation.sampling.iter().all(|sampling| !sampling.within_design && sampling.seed == 7));
    let words = &simulation.sampling[0].words;
    assert!(
        words.contains("(seed 7). They are not within those for which convergence is proved: periods from"),
        "{words}"
    );
    let [radial, weighted] = outside.warnings.as_slice() else { panic!("{:?}", outside.warnings) };
    let start = "Guarantee not valid outside the periods of the design: radial: outside at ";
    assert!(radial.starts_with(start) && radial.contains("where the "), "{radial}");
    assert!(weighted.contains("weighted: outside at "), "{weighted}");
    // Misses alone.
    let missed = format!("{STUDY}[simulation.sampling]\nmisses = 6\n");
    let missed = executed(&missed, Step::Simulate);
    let warning = &missed.warnings[0];
    assert!(warning.contains("where the number of samples missed in a row = 3 is not in [0, 2]"), "{warning}");
}

/// The theorem corrects by all outputs: a sample with a part of them is outside of what is proved, and one with none of
/// them is a missed one.
#[test]
fn a_sample_with_missing_outputs_is_outside_of_what_is_proved() {
    let of = |outputs: &str| {
        let (one, _) = STUDY.split_once("[[observer]]\nname = \"weighted\"").unwrap();
        let losing = "[simulation.sampling]\nmisses = 0\n[truth]\ndropout = 0.1\nperiod = 0.01\nseed = 1\n";
        let text = format!("{}{losing}", one.replace("c = [[1, 0]]", outputs));
        executed(&text, Step::Simulate)
    };
    let partly = of("c = [[1, 0], [1, 1]]");
    let sampling = &partly.simulation.as_ref().unwrap().sampling[0];
    assert!(!sampling.within_design, "{}", sampling.words);
    let warning = partly.warnings.iter().find(|warning| warning.contains("radial: outside at ")).unwrap();
    assert!(warning.contains("where the number of outputs missing from a sample = 1 is not in [0, 0]"), "{warning}");
    // The same losses with one output are missed samples, and the design has room for them.
    let missed = of("c = [[1, 0]]");
    let sampling = &missed.simulation.as_ref().unwrap().sampling[0];
    assert!(sampling.missed > 0 && sampling.within_design, "{} {:?}", sampling.words, missed.warnings);
}

/// The seed of the noise is that of the samples, unless they have their own.
#[test]
fn the_samples_have_the_seed_of_the_noise() {
    let noise = "scale = [1, 1]\nnoise = { amplitude = [1e-3], period = 0.01, seed = 5 }";
    let noisy = STUDY.replace("scale = [1, 1]", noise);
    let seeds = |text: &str| {
        let simulation = executed(text, Step::Simulate).simulation.unwrap();
        (simulation.sampling[0].seed, simulation.sampling[0].samples, simulation.sampling[0].shortest)
    };
    let (seed, samples, shortest) = seeds(&noisy);
    assert_eq!(seed, 5);
    let own = seeds(&format!("{noisy}[simulation.sampling]\nseed = 6\n"));
    assert!(own.0 == 6 && (own.1, own.2) != (samples, shortest), "{own:?}");
}

/// In deviations from an operating point.
#[test]
fn an_operating_point_shifts_the_observer() {
    let text = r#"[plant]
f = ["v", "9.81*sin(x) - v + u"]
h = ["x"]
states = ["x", "v"]
inputs = ["u"]
[operating_point]
x = [3.2, 0]
u = [0.57]
[input]
expressions = ["0.57"]
[simulation]
x0 = [3.3, 0.1]
duration = 6
[[observer]]
kind = "sampled-cubic"
poles = [-3, -4]
gamma = 1
period = 0.1
jitter = [0.08, 0.13]
misses = 1
initial = [3.0, 0]
"#;
    let results = executed(text, Step::Simulate);
    let simulation = results.simulation.unwrap();
    let states = &simulation.rows[0].merits.as_ref().unwrap().states;
    assert!(
        (states[0].initial - 0.3).abs() < 1e-12 && states.iter().all(|state| state.last.abs() < 1e-3),
        "{states:?}"
    );
    assert_eq!(simulation.sampling.len(), 1);
}

/// The observer `radial` on a log.
const LOGGED: &str = r#"[plant]
a = [[0, 1], [0, 0]]
b = [[0], [1]]
c = [[1, 0]]
time_unit = "s"
[log]
file = "log.csv"
states = ["x1", "x2"]
[[observer]]
name = "radial"
kind = "sampled-cubic"
poles = [-2, -5]
gamma = 10
period = 0.1
jitter = [0.07, 0.14]
misses = 2
"#;

/// A mass at the constant speed -1, measured at periods from 0.08 to 0.125 but for a gap after row 50. Rows 20 and 21
/// are not in the log, and row 30 has no measurement.
fn on_uneven_log(name: &str, gap: f64, observer: &str) -> Results {
    let folder = scratch(&format!("uneven-log/{name}"));
    let (mut csv, mut t) = ("t,u1,y1,x1,x2\n".to_owned(), 0.0);
    for k in 0..100 {
        let x = 3.0 - t;
        match k {
            20 | 21 => {}
            30 => _ = writeln!(csv, "{t},0,,{x},-1"),
            _ => _ = writeln!(csv, "{t},0,{x},{x},-1"),
        }
        t += 0.08 + 0.005 * f64::from((7 * k) % 10) + if k == 50 { gap } else { 0.0 };
    }
    std::fs::write(folder.join("log.csv"), csv).unwrap();
    let study = study_in(&folder, observer);
    execute(&study, Step::Run, &RunOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// The times of the rows are those of the samples: the errors tend to 0, which they do not where the observer of the
/// nominal period takes rows beside its samples for measurements at them.
#[test]
fn on_a_log_the_rows_are_the_samples() {
    let results = on_uneven_log("within", 0.0, LOGGED);
    let row = &results.log.as_ref().unwrap().rows[0];
    let last = row.errors.iter().map(|error| error.last.abs()).fold(0.0, f64::max);
    assert!(row.errors.len() == 2 && last < 1e-6, "{:?}", row.errors);
    let sampling = row.sampling.as_ref().unwrap();
    // Rows 20, 21 and 30 are missed: 97 corrections, 0.29 and 0.21 apart there.
    assert_eq!((sampling.corrections, sampling.missed_in_a_row, sampling.outside), (97, 2, 0), "{sampling:?}");
    assert!(sampling.missed == 3 && (sampling.longest - 0.29).abs() < 1e-9, "{sampling:?}");
    assert!(
        sampling
            .words
            .starts_with("radial: 97 corrections at the rows of the log, 0.08 to 0.29 s apart: at least 3 missed")
            && sampling.words.contains("Convergence is proved for them: periods from 0.07 to 0.14"),
        "{}",
        sampling.words
    );
    assert_eq!(results.warnings, Vec::<String>::new());
}

#[test]
fn a_log_outside_the_periods_of_the_design_is_said_to_be() {
    // More than three periods of 0.14; and between two periods of 0.14 and three of 0.1.
    let narrow = LOGGED.replace("[0.07, 0.14]", "[0.1, 0.14]");
    for (name, gap, text, of, why) in [
        ("gap", 0.5, LOGGED, 1, "t = 5.705 s the last correction is 0.58 s ago."),
        ("narrow", 0.0, &narrow, 37, "s ago; the same holds for 36 more."),
    ] {
        let results = on_uneven_log(name, gap, text);
        let sampling = results.log.as_ref().unwrap().rows[0].sampling.as_ref().unwrap();
        assert_eq!(sampling.outside, of, "{sampling:?}");
        let words = &sampling.words;
        assert!(
            words.contains("Not all are within those for which convergence is proved") && words.ends_with(why),
            "{words}"
        );
        assert!(results.warnings.contains(words), "{:?}", results.warnings);
    }
}

/// A row with one of two outputs corrects, with the other as predicted; the theorem has no such sample.
#[test]
fn a_row_without_one_of_two_outputs_is_outside() {
    let folder = scratch("uneven-log/partly");
    let mut csv = "t,u1,y1,y2,x1,x2\n".to_owned();
    for k in 0..80 {
        let (t, missing) = (0.1 * f64::from(k), k == 40);
        let y2 = if missing { String::new() } else { "-1".to_owned() };
        _ = writeln!(csv, "{t},0,{},{y2},{},-1", 3.0 - t, 3.0 - t);
    }
    std::fs::write(folder.join("log.csv"), csv).unwrap();
    let text = LOGGED.replace("c = [[1, 0]]", "c = [[1, 0], [0, 1]]");
    let study = study_in(&folder, &text);
    let results = execute(&study, Step::Run, &RunOptions::default()).unwrap();
    let row = &results.log.as_ref().unwrap().rows[0];
    let sampling = row.sampling.as_ref().unwrap();
    assert!(sampling.outside == 1 && sampling.corrections == 80, "{sampling:?}");
    assert!(sampling.words.ends_with("at t = 4 s 1 output missing."), "{}", sampling.words);
    assert!(row.errors.iter().all(|error| error.last.abs() < 1e-6), "{:?}", row.errors);
}

/// Numbers of `[simulation.sampling]` and both ends of `jitter` can be varied; a pair is no number.
#[test]
fn sampling_can_be_swept() {
    let sampling = "[simulation.sampling]\njitter = [0.07, 0.14]\nmisses = 2\n";
    let sweep = |parameter: &str, values: &str| {
        format!("{STUDY}{sampling}[sweep]\nparameter = \"{parameter}\"\nvalues = {values}\nobservers = [\"radial\"]\n")
    };
    for (parameter, values) in [
        ("simulation.sampling.misses", "[0, 3]"),
        ("simulation.sampling.jitter.longest", "[0.08, 0.5]"),
        ("observer.radial.jitter.shortest", "[0.07, 0.09]"),
    ] {
        let swept = executed(&sweep(parameter, values), Step::Sweep).sweep.unwrap();
        let rms: Vec<f64> = swept.rows.iter().map(|row| row.rms.unwrap()).collect();
        assert!(rms.len() == 2 && (rms[0] - rms[1]).abs() > 1e-6, "{parameter}: {rms:?}");
    }
    let found = mistake(&sweep("simulation.sampling.jitter", "[1, 2]"));
    assert!(found.message.contains("\"simulation.sampling.jitter\", which is no number of the study"), "{found:?}");
    assert!(found.expected.contains("simulation.sampling.jitter.longest"), "{found:?}");
    let found = mistake(&sweep("simulation.sampling.misses", "[1, 1.5]"));
    assert!(found.message.contains("with simulation.sampling.misses = 1.5"), "{found:?}");
    let found = mistake(&sweep("simulation.sampling.jitter.longest", "[0.01]"));
    assert!(found.message.contains("with simulation.sampling.jitter.longest = 0.01"), "{found:?}");
}

/// The exported step at the samples of the run, with the time that passed: without an input the estimates are those of
/// the simulation, up to the rounding of its integration.
#[test]
fn the_exported_step_follows_the_run_at_its_samples() {
    let text = STUDY.replace("[input]\nexpressions = [\"sin(t)\"]\n", "");
    let study = study(&text);
    for observer in &study.observers {
        let sampled = deployment::sampled(&study, observer, None, None).unwrap();
        let record = deployment::record(&study, observer, &sampled).unwrap();
        let periods = observer.kind.varying_periods().unwrap();
        let longest = (periods.misses + 1) as f64 * periods.longest;
        for (u, y) in &record.samples {
            assert!(u.len() == 2 && y.len() == 1 && u[1] > periods.shortest - 1e-9 && u[1] < longest + 1e-9, "{u:?}");
        }
        let export = deployment::exported(&study, observer, sampled.design, Scalar::Binary64, None).unwrap();
        let difference = record.difference(&golden::replay(&export, &record.samples).unwrap()).unwrap();
        assert!(record.samples.len() > 20 && difference.largest.iter().all(|x| *x < 1e-8), "{difference:?}");
    }
}

#[test]
pub(crate) fn mistakes_in_the_sampling() {
    let fixed = STUDY.replace("jitter = [0.07, 0.14]\nmisses = 2\n", "").replace("jitter = [0.09, 0.12]\n", "");
    let unused = mistake(&format!("{fixed}[simulation.sampling]\nmisses = 1\n"));
    assert!(unused.message.contains("no observer has `jitter` or `misses`"), "{unused:?}");
    let zero = mistake(&format!("{STUDY}[simulation.sampling]\njitter = [0, 0.2]\n"));
    assert!(zero.message.contains("`jitter` is from 0 to 0.2") && zero.line == 29, "{zero:?}");
    let many = mistake(&format!("{STUDY}[simulation.sampling]\nmisses = 65\n"));
    assert!(many.message.contains("`misses` is 65") && many.expected.contains("at most 64"), "{many:?}");
}
