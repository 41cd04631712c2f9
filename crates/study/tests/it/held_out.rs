//! Observers on the part of a log that is held out: `advise` and `[sweep]` on a log, against recursions of this file.

use std::fmt::Write;
use std::path::Path;

use luenberger_random::Random;
use luenberger_study::advise::{Advice, AdviseOptions, RankedObserver, advise};
use luenberger_study::execute::LogError;
use luenberger_study::results::{LogSweepReport, PredictionReport};
use luenberger_study::{Format, RunOptions, Step, Study, StudyError, execute};

use crate::studies::{mistake, scratch, study_in};

/// x1+ = 0.9 x1 + 0.2 x2 + w1, x2+ = 0.8 x2 + u + w2, y = x1 + v; both states are in the log.
const STUDY: &str = r#"
[plant]
states = ["x", "z"]
inputs = ["u"]
outputs = ["y"]
a = [[0.9, 0.2], [0, 0.8]]
b = [[0], [1]]
c = [[1, 0]]
dt = 1
[log]
file = "log.csv"
states = ["x", "z"]
[[observer]]
name = "EKF"
kind = "extended-kalman"
initial = [0, 0]
p0 = [1, 2]
w = [0.1, 0.4]
v = [0.5]
period = 1
[[observer]]
name = "slow"
kind = "luenberger"
initial = [0, 0]
gain = [[0.3], [0.1]]
[[observer]]
name = "reduced"
kind = "reduced-order"
initial = [0, 0]
poles = [0.5]
"#;

/// The units of the errors.
const UNITS: &str = "[simulation]\nx0 = [0, 0]\nduration = 10\nscale = [2, 4]\n";

const ROWS: usize = 200;
const FIRST: usize = 140;

/// The columns u, y, x, z.
type Rows = Vec<[f64; 4]>;

fn rows(seed: u64) -> Rows {
    let mut random = Random(seed);
    let (mut x, mut z, mut rows) = (0.5, -1.0, Rows::new());
    for k in 0..ROWS {
        let (u, [w1, w2], [v, _]) = ((0.3 * k as f64).sin(), random.normal_pair(), random.normal_pair());
        rows.push([u, x + 0.5f64.sqrt() * v, x, z]);
        (x, z) = (0.9 * x + 0.2 * z + 0.1f64.sqrt() * w1, 0.8 * z + u + 0.4f64.sqrt() * w2);
    }
    rows
}

fn write(folder: &Path, rows: &Rows) {
    let mut log = "t,u,y,x,z\n".to_owned();
    for (k, [u, y, x, z]) in rows.iter().enumerate() {
        writeln!(log, "{k},{u},{y},{x},{z}").unwrap();
    }
    std::fs::write(folder.join("log.csv"), log).unwrap();
}

fn logged(name: &str) -> (std::path::PathBuf, Rows) {
    let folder = scratch(name);
    let rows = rows(11);
    write(&folder, &rows);
    (folder, rows)
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt()
}

/// The predictions y(k|k-1) of the linear observer with this gain, by hand.
fn of_gain(rows: &Rows, l: [f64; 2]) -> Vec<f64> {
    let (mut x, mut z) = (0.0, 0.0);
    let one = |[u, y, ..]: &[f64; 4]| {
        let nu = y - x;
        (x, z) = (0.9 * x + 0.2 * z + l[0] * nu, 0.8 * z + u + l[1] * nu);
        nu
    };
    rows.iter().map(one).collect()
}

/// Innovations and log-likelihoods of the Kalman filter, by its covariance entry by entry, and its estimates after the
/// measurement.
fn of_filter(rows: &Rows) -> Vec<(f64, f64, [f64; 2])> {
    let (mut x, mut z) = (0.0, 0.0);
    let (mut p11, mut p12, mut p22) = (1.0, 0.0, 2.0);
    let one = |[u, y, ..]: &[f64; 4]| {
        let (nu, s) = (y - x, p11 + 0.5);
        let likelihood = -0.5 * ((2.0 * std::f64::consts::PI * s).ln() + nu * nu / s);
        let (k1, k2) = (p11 / s, p12 / s);
        (x, z) = (x + k1 * nu, z + k2 * nu);
        let estimate = [x, z];
        (p11, p12, p22) = (p11 - k1 * p11, p12 - k1 * p12, p22 - k2 * p12);
        (x, z) = (0.9 * x + 0.2 * z, 0.8 * z + u);
        (p11, p12, p22) = (0.81 * p11 + 0.36 * p12 + 0.04 * p22 + 0.1, 0.72 * p12 + 0.16 * p22, 0.64 * p22 + 0.4);
        (nu, likelihood, estimate)
    };
    rows.iter().map(one).collect()
}

/// The predictions of the reduced-order observer with the pole 0.5: z+ = 0.8 z + u + l (y+ - 0.9 y - 0.2 z), where
/// 0.8 - 0.2 l = 0.5, and y+ is predicted as 0.9 y + 0.2 z before it is measured.
fn of_reduced(rows: &Rows) -> Vec<f64> {
    let l = 1.5;
    let (mut z, mut found) = (0.0, vec![rows[0][1]]);
    for pair in rows.windows(2) {
        let ([u, y, ..], [_, next, ..]) = (pair[0], pair[1]);
        let nu = next - (0.9 * y + 0.2 * z);
        found.push(nu);
        z = 0.8 * z + u + l * nu;
    }
    found
}

#[track_caller]
fn advised(study: &Study, by: Option<&str>) -> Advice {
    let criteria = by.map(|by| by.parse().unwrap());
    let options = AdviseOptions { criteria, budget: 600.0, ..AdviseOptions::default() };
    advise(study, &options).unwrap_or_else(|error| panic!("{error}")).0
}

#[track_caller]
fn ranked<'a>(advice: &'a Advice, name: &str) -> &'a RankedObserver {
    advice.ranking.iter().find(|one| one.name == name).unwrap_or_else(|| panic!("{name} in {:?}", advice.ranking))
}

#[track_caller]
fn judged<'a>(advice: &'a Advice, name: &str) -> &'a PredictionReport {
    ranked(advice, name).on_log.as_ref().unwrap()
}

#[track_caller]
fn close(found: f64, expected: f64, what: &str) {
    assert!((found - expected).abs() < 1e-9 * expected.abs().max(1.0), "{what}: {found} where {expected} was expected");
}

/// Every number of the table that a recursion by hand gives: one-step predictions of an observer with a constant gain,
/// of one whose estimate has the measurement of its row, and of a filter, with its likelihood and its errors.
#[test]
fn observers_are_ranked_by_their_predictions_of_what_is_held_out() {
    let (folder, rows) = logged("advise-on-log");
    let advice = advised(&study_in(&folder, STUDY), None);
    assert_eq!((advice.runs, advice.ensemble, advice.criteria.to_string().as_str()), (1, 1, "innovations"));
    let held: Vec<f64> = rows[FIRST..].iter().map(|row| row[1]).collect();
    let mean = held.iter().sum::<f64>() / held.len() as f64;
    let deviation = rms(&held.iter().map(|y| y - mean).collect::<Vec<_>>());
    let filter = of_filter(&rows);
    let nu: Vec<f64> = filter.iter().map(|of| of.0).collect();
    for (name, nu) in [("EKF", nu), ("slow", of_gain(&rows, [0.3, 0.1])), ("reduced", of_reduced(&rows))] {
        let report = judged(&advice, name);
        let output = &report.outputs[0];
        assert_eq!((output.samples, output.output.as_str()), (ROWS - FIRST, "y"));
        close(output.rms, rms(&nu[FIRST..]), name);
        close(output.deviation, deviation, name);
        close(report.relative, rms(&nu[FIRST..]) / deviation, name);
        assert_eq!(report.log_likelihood.is_some(), name == "EKF", "{name}");
    }
    let ekf = judged(&advice, "EKF");
    let likelihood = filter[FIRST..].iter().map(|of| of.1).sum::<f64>() / (ROWS - FIRST) as f64;
    close(ekf.log_likelihood.unwrap(), likelihood, "log-likelihood");
    for (i, state) in ekf.states.iter().enumerate() {
        let errors: Vec<f64> = (FIRST..ROWS).map(|k| rows[k][2 + i] - filter[k].2[i]).collect();
        close(state.rms, rms(&errors), &state.state);
    }
    // The order is that of the innovations, of those that ran; kinds of the registry are among them, with V of the EKF.
    let order: Vec<f64> = advice.ranking.iter().map(|one| one.on_log.as_ref().unwrap().relative).collect();
    assert!(order.windows(2).all(|pair| pair[0] <= pair[1] * (1.0 + 1e-9)), "{order:?}");
    assert!(ranked(&advice, "kalman").kind == "kalman" && ranked(&advice, "ukf").kind == "ukf");
    let noise = advice.information.iter().find(|item| item.what == "noise level").unwrap();
    assert!(noise.value.contains("y 0.7071") && noise.from == "v of the observer \"EKF\"", "{noise:?}");
    let region = advice.information.iter().find(|item| item.what == "region").unwrap();
    assert!(region.from.starts_with("the true states in the log"), "{region:?}");
    // Those that no other one is better than in operations and in innovations; no peak is known.
    let points = advice.ranking.iter().filter_map(|one| Some((one, one.operations?, one.on_log.as_ref()?.relative)));
    let points: Vec<_> = points.collect();
    let is_better = |(_, a, b): &(_, usize, f64), (_, c, d): &(_, usize, f64)| a <= c && b <= d && (a < c || b < d);
    let front: Vec<String> = points
        .iter()
        .filter(|one| !points.iter().any(|other| is_better(other, one)))
        .map(|(one, ..)| one.name.clone())
        .collect();
    assert!(!front.is_empty(), "{points:?}");
    assert_eq!(advice.pareto_cost, front);
    assert_eq!(advice.pareto_peak, [""; 0]);
    assert!(advice.held_out.unwrap().starts_with("Held out: the last 60 rows, from t = 140; judged on all of them."));
}

/// Times are differences: a log that begins later has the same ranking. Of its table the best values are marked, of the
/// likelihood the largest.
#[test]
fn a_log_may_begin_at_any_time() {
    let (folder, rows) = logged("advise-later");
    let first = advised(&study_in(&folder, STUDY), None);
    let log = std::fs::read_to_string(folder.join("log.csv")).unwrap();
    let later = log.lines().enumerate().map(|(k, line)| match line.split_once(',') {
        Some((_, rest)) if k > 0 => format!("{},{rest}\n", 1000 + k),
        _ => format!("{line}\n"),
    });
    std::fs::write(folder.join("log.csv"), later.collect::<String>()).unwrap();
    let second = advised(&study_in(&folder, STUDY), None);
    let of = |advice: &Advice| -> Vec<(String, String)> {
        advice
            .ranking
            .iter()
            .map(|one| (one.name.clone(), format!("{:.6e}", one.on_log.as_ref().unwrap().relative)))
            .collect()
    };
    assert_eq!(of(&first), of(&second));
    let value = |advice: &Advice, what: &str| {
        advice.information.iter().find(|item| item.what == what).map(|item| item.value.clone())
    };
    for item in &first.information {
        assert_eq!(value(&second, item.what), Some(item.value.clone()), "{}", item.what);
    }
    let markdown = first.markdown("10 min");
    let head =
        markdown.lines().find(|line| line.starts_with("| observer |") && line.contains("log-likelihood")).unwrap();
    let column = head.split('|').position(|cell| cell.trim() == "log-likelihood").unwrap();
    let cells =
        markdown.lines().filter(|line| first.ranking.iter().any(|one| line.starts_with(&format!("| {} | ", one.name))));
    let cells: Vec<&str> = cells.filter_map(|line| line.split('|').nth(column)).map(str::trim).collect();
    let number = |cell: &&str| cell.trim_matches('*').parse::<f64>().ok();
    let largest = cells.iter().filter_map(number).fold(f64::NEG_INFINITY, f64::max);
    let marked: Vec<f64> = cells.iter().filter(|cell| cell.starts_with("**")).filter_map(number).collect();
    assert!(!marked.is_empty() && marked.iter().all(|value| *value == largest), "{cells:?}");
    assert_eq!(rows.len(), ROWS);
}

/// Measurements that rest on the steps of a converter have a second difference of zero: their noise is that of its
/// step.
#[test]
fn a_coarse_converter_has_the_noise_of_its_step() {
    let (folder, mut rows) = logged("advise-coarse");
    for (k, row) in rows.iter_mut().enumerate() {
        row[1] = 0.5 * (k as f64 / 8.0).floor();
    }
    write(&folder, &rows);
    let region = "[advise]\nregion = { states = [[-30, 30], [-30, 30]] }\n";
    let only = &STUDY[..STUDY.find("[[observer]]").unwrap()];
    let advice = advised(
        &study_in(&folder, &format!("{only}{region}").replace("states = [\"x\", \"z\"]\n[advise]", "[advise]")),
        None,
    );
    let noise = advice.information.iter().find(|item| item.what == "noise level").unwrap();
    // 0.5/sqrt(12).
    assert!(noise.value.contains("y 0.1443"), "{noise:?}");
}

#[test]
fn other_criteria_rank_a_log_too() {
    let (folder, _) = logged("advise-criteria");
    let study = study_in(&folder, STUDY);
    let by_error = advised(&study, Some("error"));
    let errors: Vec<f64> = by_error.ranking.iter().map(|one| one.on_log.as_ref().unwrap().error.unwrap()).collect();
    assert!(errors.windows(2).all(|pair| pair[0] <= pair[1] * (1.0 + 1e-9)), "{errors:?}");
    assert!(by_error.explanation[0].contains("has the least rms |e|"), "{:?}", by_error.explanation);
    // Each error in the unit of its state.
    let scaled = format!("{STUDY}{UNITS}");
    let scaled = advised(&study_in(&folder, &scaled), Some("error"));
    let of = judged(&scaled, "EKF");
    close(of.error.unwrap(), (of.states[0].rms / 2.0).hypot(of.states[1].rms / 4.0), "error in units");
    // Observers without a covariance have no likelihood, and are behind those that have one.
    let likely = advised(&study, Some("likelihood"));
    let known: Vec<Option<f64>> =
        likely.ranking.iter().map(|one| one.on_log.as_ref().unwrap().log_likelihood).collect();
    let count = known.iter().flatten().count();
    assert!(count > 1 && known[..count].iter().all(Option::is_some), "{known:?}");
    assert!(known[..count].windows(2).all(|pair| pair[0].unwrap() >= pair[1].unwrap() - 1e-9), "{known:?}");
}

/// An outlier that one gate rejects counts for no observer; a filter that rejects much is none that can be compared.
#[test]
fn what_a_gate_rejects_is_judged_for_none() {
    let (folder, mut rows) = logged("advise-gate");
    rows[160][1] += 50.0;
    write(&folder, &rows);
    let gated = STUDY.replace("period = 1\n", "period = 1\ngate = 8\n");
    let advice = advised(&study_in(&folder, &gated), None);
    assert!(advice.held_out.as_ref().unwrap().contains("judged on 59 of them"), "{:?}", advice.held_out);
    let nu = of_gain(&rows, [0.3, 0.1]);
    let without: Vec<f64> = (FIRST..ROWS).filter(|k| *k != 160).map(|k| nu[k]).collect();
    close(judged(&advice, "slow").outputs[0].rms, rms(&without), "slow");
    let locked = STUDY.replace("v = [0.5]\nperiod = 1\n", "v = [1e-4]\nperiod = 1\ngate = 0.5\n");
    let advice = advised(&study_in(&folder, &locked), None);
    let ekf = ranked(&advice, "EKF");
    assert!(ekf.on_log.is_none() && ekf.ended.as_ref().unwrap().contains("its gate rejects"), "{ekf:?}");
    assert_eq!(advice.ranking.last().unwrap().name, "EKF");
}

/// The numbers that are given take the place of those that are derived.
#[test]
fn what_the_log_does_not_say_is_derived_from_its_first_part() {
    let (folder, rows) = logged("advise-basis");
    let text = STUDY.replace("states = [\"x\", \"z\"]\n[[observer]]", "[[observer]]");
    let only = &text[..text.find("[[observer]]").unwrap()];
    let error = advise(&study_in(&folder, only), &AdviseOptions::default()).unwrap_err();
    assert!(matches!(error, StudyError::OnLog(LogError::NoRegion)), "{error}");
    let region = "[advise]\nregion = { states = [[-8, 8], [-8, 8]] }\n";
    let advice = advised(&study_in(&folder, &format!("{only}{region}")), None);
    let item = |what: &str| advice.information.iter().find(|item| item.what == what).unwrap();
    // The median second difference of the fitted rows over 0.6745 sqrt(6).
    let y: Vec<f64> = rows[..FIRST].iter().map(|row| row[1]).collect();
    let mut second: Vec<f64> = y.windows(3).map(|of| (of[0] - 2.0 * of[1] + of[2]).abs()).collect();
    second.sort_by(f64::total_cmp);
    let deviation = second[(second.len() - 1) / 2] / (0.674_489_75 * 6f64.sqrt());
    let found: f64 = item("noise level").value.split([' ', ',']).nth(3).unwrap().parse().unwrap();
    assert!((found / deviation - 1.0).abs() < 1e-3, "{} {deviation}", item("noise level").value);
    assert_eq!(item("sampling period").from, "plant.dt");
    let given = format!("{only}{region}noise = [0.25]\nheld_out = 0.5\n");
    let advice = advised(&study_in(&folder, &given), None);
    let noise = advice.information.iter().find(|item| item.what == "noise level").unwrap();
    assert!(noise.from == "advise.noise" && noise.value.contains("y 0.25"), "{noise:?}");
    assert!(advice.held_out.unwrap().contains("the last 100 rows"));
    // A filter of the study says the noise where its covariances are numbers.
    let noise = |text: &str| {
        let advice = advised(&study_in(&folder, text), None);
        advice.information.into_iter().find(|item| item.what == "noise level").unwrap()
    };
    assert_eq!(noise(&text).from, "v of the observer \"EKF\"");
    for (constant, varying) in
        [("v = [0.5]", "v = [\"0.5 + 0*x\"]"), ("w = [0.1, 0.4]", "w = [\"0.1 + 0*x\", \"0.4\"]")]
    {
        let from = noise(&text.replace(constant, varying)).from;
        assert!(from.starts_with("the median second difference"), "{from}");
    }
    // An observer of the study bounds the states where the log does not know them.
    let advice = advised(&study_in(&folder, &text), None);
    let region = advice.information.iter().find(|item| item.what == "region").unwrap();
    assert!(region.from.starts_with("the estimates of \"EKF\""), "{region:?}");
    assert!(advice.ranking.iter().all(|one| one.on_log.as_ref().is_none_or(|of| of.error.is_none())));
}

#[test]
fn what_cannot_be_compared_on_a_log_is_refused() {
    let (folder, rows) = logged("advise-refused");
    let study = study_in(&folder, STUDY);
    let refused = |study: &Study, by: Option<&str>| {
        let options = AdviseOptions { criteria: by.map(|by| by.parse().unwrap()), ..AdviseOptions::default() };
        advise(study, &options).unwrap_err()
    };
    let settling = refused(&study, Some("settling")).to_string();
    assert!(settling.contains("a [simulation] to rank by noise, peak or settling"), "{settling}");
    let known = STUDY.replace("states = [\"x\", \"z\"]\n[[observer]]", "[[observer]]");
    let error = refused(&study_in(&folder, &known), Some("error")).to_string();
    assert!(error.contains("columns of true states"), "{error}");
    let linear =
        STUDY.replace("[[observer]]\nname = \"EKF\"", "interpolation = \"linear\"\n[[observer]]\nname = \"EKF\"");
    assert!(matches!(refused(&study_in(&folder, &linear), None), StudyError::OnLog(LogError::Linear)));
    // Too short, and without a measurement.
    let tenth = format!("{STUDY}[advise]\nheld_out = 0.05\n");
    let error = refused(&study_in(&folder, &tenth), None);
    assert!(
        matches!(error, StudyError::OnLog(LogError::TooShort { rows: 10, measurements: 10, least: 20, .. })),
        "{error}"
    );
    let mut log = "t,u,y,x,z\n".to_owned();
    for (k, [u, y, x, z]) in rows.iter().enumerate() {
        let y = if k < FIRST { y.to_string() } else { String::new() };
        writeln!(log, "{k},{u},{y},{x},{z}").unwrap();
    }
    std::fs::write(folder.join("log.csv"), log).unwrap();
    let error = refused(&study_in(&folder, STUDY), None);
    assert!(error.to_string().contains("has 60 rows with 0 measurements"), "{error}");
    let without = mistake("[plant]\na = [[-1]]\nc = [[1]]\n[advise]\nheld_out = 0.95\n");
    assert!(without.message.contains("`held_out` is 0.95"), "{}", without.message);
}

/// No candidate runs: each has its reason, and none is recommended.
#[test]
fn a_log_on_which_nothing_runs_says_why() {
    let (folder, _) = logged("advise-none");
    let text = STUDY.replace(
        "a = [[0.9, 0.2], [0, 0.8]]\nb = [[0], [1]]\nc = [[1, 0]]",
        "f = [\"0.9*x + 0.2*z\", \"0.8*z + u\"]\nh = [\"x + 0*sqrt(x - 50)\"]",
    );
    let text = &text[..text.find("[[observer]]\nname = \"slow\"").unwrap()];
    let advice = advised(&study_in(&folder, text), None);
    assert!(advice.ranking.iter().all(|one| one.on_log.is_none()), "{:?}", advice.ranking);
    assert_eq!(advice.explanation[0], "No observer finished its run:");
    assert!(advice.explanation[1].contains("stopped at t = 0"), "{:?}", advice.explanation);
    assert!(advice.recommended.is_empty() && advice.held_out.is_none());
}

#[test]
fn the_written_study_runs_on_the_log() {
    let (folder, _) = logged("advise-log-files");
    let output = scratch("advise-log-output");
    let run = RunOptions { output: Some(output.clone().into()), ..RunOptions::default() };
    let options = AdviseOptions { run, budget: 600.0, ..AdviseOptions::default() };
    let (advice, _) = advise(&study_in(&folder, STUDY), &options).unwrap();
    let table = std::fs::read_to_string(output.join("runs.csv")).unwrap();
    assert!(table.starts_with("observer,relative_innovation,log_likelihood,error,rms_y,error_x,error_z,failure\n"));
    assert_eq!(table.lines().count(), 1 + advice.ranking.len());
    let written = Study::from_path(&output.join("study.toml")).unwrap();
    let results = execute(&written, Step::Compare, &RunOptions::default()).unwrap();
    assert!(results.log.unwrap().rows.iter().all(|row| row.failure.is_none()));
}

#[track_caller]
fn swept(folder: &Path, text: &str) -> LogSweepReport {
    let results = execute(&study_in(folder, text), Step::Sweep, &RunOptions::default());
    results.unwrap_or_else(|error| panic!("{error}")).sweep_on_log.unwrap()
}

/// The predictions of the observer with a gain of the plant's parameter, by hand for each value.
#[test]
fn a_sweep_on_a_log_has_the_predictions_at_each_value() {
    let (folder, rows) = logged("sweep-on-log");
    let text = r#"
[plant]
states = ["x", "z"]
inputs = ["u"]
outputs = ["y"]
parameters = { c = 0.2 }
f = ["0.9*x + c*z", "0.8*z + u"]
h = ["x"]
dt = 1
[log]
file = "log.csv"
states = ["-", "z"]
[[observer]]
name = "EKF"
kind = "extended-kalman"
initial = [0, 0]
p0 = [1, 2]
w = [0.1, 0.4]
v = [0.5]
period = 1
[sweep]
parameter = "plant.c"
values = [0.1, 0.2, 0.4]
"#;
    let report = swept(&folder, text);
    assert_eq!(report.rows.len(), 3);
    let filter = of_filter(&rows);
    let at = report.rows[1].on_log.as_ref().unwrap();
    assert_eq!(report.rows[1].value, 0.2);
    close(at.outputs[0].rms, rms(&filter[FIRST..].iter().map(|of| of.0).collect::<Vec<_>>()), "rms");
    let errors: Vec<f64> = (FIRST..ROWS).map(|k| rows[k][3] - filter[k].2[1]).collect();
    close(at.states[0].rms, rms(&errors), "z");
    assert_eq!(at.states.len(), 1);
    // 0.2 made the log.
    let best = report.rows.iter().max_by(|a, b| {
        let of = |row: &luenberger_study::results::LogSweepRow| row.on_log.as_ref().unwrap().log_likelihood.unwrap();
        of(a).total_cmp(&of(b))
    });
    assert_eq!(best.unwrap().value, 0.2);
    assert!(report.best()[0].contains("the largest log-likelihood"), "{:?}", report.best());
    // A number of an observer.
    let other = format!("{STUDY}[sweep]\nparameter = \"observer.EKF.period\"\nvalues = [1]\nobservers = [\"EKF\"]\n");
    let one = swept(&folder, &other);
    close(one.rows[0].on_log.as_ref().unwrap().outputs[0].rms, at.outputs[0].rms, "the same filter");
    // Poles, of those that have some; a design that does not exist has its reason, and the others are judged.
    let poles = format!("{STUDY}[sweep]\nparameter = \"poles\"\nvalues = [1, 2]\nobservers = [\"reduced\"]\n");
    let found = swept(&folder, &poles);
    close(found.rows[0].on_log.as_ref().unwrap().outputs[0].rms, rms(&of_reduced(&rows)[FIRST..]), "reduced");
}

#[test]
fn a_sweep_writes_its_table_and_its_figure() {
    let (folder, _) = logged("sweep-log-files");
    let text =
        format!("{STUDY}[sweep]\nparameter = \"poles\"\nfrom = 0.5\nto = 2\ncount = 3\nobservers = [\"reduced\"]\n");
    let output = scratch("sweep-log-output");
    let run = RunOptions { output: Some(output.clone().into()), ..RunOptions::default() };
    let results = execute(&study_in(&folder, &text), Step::Sweep, &run).unwrap();
    let table = std::fs::read_to_string(output.join("sweep.csv")).unwrap();
    assert!(
        table.starts_with("observer,poles,relative_innovation,log_likelihood,error,rms_y,error_x,error_z,failure\n")
    );
    assert_eq!(table.lines().count(), 4);
    for (line, row) in table.lines().skip(1).zip(&results.sweep_on_log.as_ref().unwrap().rows) {
        let of = row.on_log.as_ref().unwrap();
        let numbers = [Some(of.relative), of.log_likelihood, of.error, Some(of.outputs[0].rms)];
        let errors = of.states.iter().map(|state| Some(state.rms));
        let expected: Vec<Option<f64>> = numbers.into_iter().chain(errors).collect();
        let cells: Vec<Option<f64>> = line.split(',').skip(2).map(|cell| cell.parse().ok()).collect();
        assert_eq!(cells[..6], expected, "{line}");
        assert!(expected[0].is_some() && expected[4].is_some() && line.ends_with(','), "{line}");
    }
    for file in ["figures/sweep.svg", "study.json"] {
        assert!(output.join(file).is_file(), "{file}: {:?}", results.files);
    }
    let text = results.text(false);
    assert!(text.contains("Sweep on the log") && text.contains("relative innovation"), "{text}");
    assert!(text.contains("Relative innovation: rms of y - h as predicted from the row before"), "{text}");
    // The norm is in the units of a simulation; the log-likelihood that of filters with a covariance.
    assert!(!text.contains("rms |e|") && !text.contains("Norm |e| of the states"), "{text}");
    assert!(!text.contains("log-likelihood") && !text.contains("Log-likelihood"), "{text}");
    // All steps at once have it too.
    let both = format!("{STUDY}[sweep]\nparameter = \"poles\"\nvalues = [1, 2]\nobservers = [\"reduced\"]\n");
    let all = execute(&study_in(&folder, &both), Step::Run, &RunOptions::default()).unwrap();
    assert!(all.sweep_on_log.is_some() && all.sweep.is_none() && all.log.is_some());
    assert!(all.warnings.iter().all(|warning| !warning.contains("Not finished")), "{:?}", all.warnings);
}

#[test]
fn a_sweep_that_makes_no_sense_on_a_log_is_refused() {
    let (folder, _) = logged("sweep-refused");
    let wrong = |sweep: &str| {
        let text = format!("{STUDY}{sweep}");
        let error = Study::from_text("study.toml", &text, Format::Toml, &folder).unwrap_err();
        error.to_string()
    };
    let ensemble = wrong("[sweep]\nparameter = \"poles\"\nvalues = [1, 2]\nensemble = 20\n");
    assert!(ensemble.contains("`ensemble` is 20, and on a log there is one run at each value"), "{ensemble}");
    let noise = wrong("[sweep]\nparameter = \"noise\"\nvalues = [1, 2]\n");
    assert!(noise.contains("`parameter` is noise, which no log depends on"), "{noise}");
    let on = wrong("[sweep]\nparameter = \"poles\"\nvalues = [1, 2]\non = \"simulation\"\n");
    assert!(on.contains("[sweep] without a [simulation]"), "{on}");
    let share = wrong("[sweep]\nparameter = \"poles\"\nvalues = [1, 2]\nheld_out = 0.99\n");
    assert!(share.contains("`held_out` is 0.99"), "{share}");
}
