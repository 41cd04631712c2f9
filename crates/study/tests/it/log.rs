//! Observers on logs: what was measured, and nothing else, corrects the estimate.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use luenberger_study::{Format, Results, RunOptions, Step, Study, execute};

use crate::studies::{scratch, study_in};

/// A folder of the test with the log in it.
fn bench(name: &str, csv: &str) -> PathBuf {
    let folder = scratch(&format!("log/{name}"));
    std::fs::write(folder.join("log.csv"), csv).unwrap();
    folder
}

fn run(folder: &Path, text: &str) -> Results {
    let study = study_in(folder, text);
    let options = RunOptions { output: Some(folder.join("out").into()), threads: Some(1), ..RunOptions::default() };
    execute(&study, Step::Run, &options).unwrap_or_else(|error| panic!("{error}"))
}

/// A column of a trajectory: none where the cell is empty.
fn column(folder: &Path, file: &str, name: &str) -> Vec<Option<f64>> {
    let text = std::fs::read_to_string(folder.join("out/trajectories").join(file)).unwrap();
    let mut lines = text.lines();
    let at = lines.next().unwrap().split(',').position(|title| title == name).unwrap_or_else(|| panic!("{name}"));
    lines.map(|line| line.split(',').nth(at).filter(|cell| !cell.is_empty()).map(|x| x.parse().unwrap())).collect()
}

/// The speed is known, the position is measured once a second from 0 to 10 and from 410 to 420, and the sensor has
/// moved by 100 in between.
fn with_a_gap() -> String {
    let mut csv = "t,speed,position\n".to_owned();
    for k in (0..=10).chain(410..=420) {
        let moved = if k > 10 { 100.0 } else { 0.0 };
        _ = writeln!(csv, "{k},0.5,{}", 0.5 * f64::from(k) + moved);
    }
    csv
}

const CART: &str = r#"
[plant]
a = [[0]]
b = [[1]]
c = [[1]]
states = ["x"]
inputs = ["speed"]
outputs = ["position"]

[log]
file = "log.csv"
"#;

const FILTER: &str = r#"
[[observer]]
name = "filter"
kind = "extended-kalman"
w = [[0.01]]
v = [[0.04]]
p0 = [[1]]
"#;

/// Across the gap the filter predicts: x = 5 + 0.5 * 400 = 205 by the model, and its variance grows by 400 W. The row
/// after the gap is one measurement, with the weight of that variance, and not the last of 400.
#[test]
fn a_gap_is_no_measurement() {
    for period in [1.0, 0.37, 0.01, 50.0] {
        let folder = bench(&format!("gap-{period}"), &with_a_gap());
        let results = run(&folder, &format!("{CART}{FILTER}period = {period}\n"));
        assert_eq!(results.failures(), Vec::<String>::new());
        let estimate = column(&folder, "log-filter.csv", "x_hat");
        assert_eq!(estimate.len(), 22, "one estimate for each row of the log, whatever the period {period}");
        // The variance after 11 updates is the stationary one, P = -W/2 + sqrt(W^2/4 + W V), to its convergence.
        let (w, v) = (0.01f64, 0.04f64);
        let mut p = 1.0;
        for k in 0..11 {
            p = p * v / (p + v);
            p += if k < 10 { w } else { 400.0 * w };
        }
        let expected = 205.0 + p / (p + v) * 100.0;
        let found = estimate[11].unwrap();
        assert!((found - expected).abs() < 1e-9 * expected, "period {period}: {found} where {expected} was expected");
    }
}

/// Blank cells are passed over, and counted.
#[test]
fn a_blank_cell_is_no_measurement() {
    let full = with_a_gap();
    let blanked = full.lines().map(|line| match line.rsplit_once(',') {
        Some((rest, _)) if line.starts_with("3,") || line.starts_with("4,") => format!("{rest},"),
        _ => line.to_owned(),
    });
    let blank = blanked.collect::<Vec<_>>().join("\n") + "\n";
    let kept = full.lines().filter(|line| !line.starts_with("3,") && !line.starts_with("4,"));
    let without = kept.collect::<Vec<_>>().join("\n") + "\n";
    let text = format!("{CART}{FILTER}period = 1\n");
    let (a, b) = (bench("blank", &blank), bench("without", &without));
    let results = run(&a, &text);
    run(&b, &text);
    let (estimate, other) = (column(&a, "log-filter.csv", "x_hat"), column(&b, "log-filter.csv", "x_hat"));
    assert_eq!((estimate.len(), other.len()), (22, 20));
    for (k, x) in other.iter().enumerate() {
        let same = estimate[if k < 3 { k } else { k + 2 }].unwrap();
        assert!((x.unwrap() - same).abs() < 1e-9, "row {k}");
    }
    assert_eq!(column(&a, "log-filter.csv", "position")[3..5], [None, None]);
    // Where no state is known, no errors are counted.
    assert_eq!(results.coverage, []);
    let log = results.log.unwrap();
    assert_eq!((log.samples, log.columns[0].samples, log.rows[0].rows_used, log.rows[0].interpolated), (22, 20, 22, 0));
    assert_eq!((&log.gaps[..], log.interpolation, log.median_period), (&[[10.0, 410.0]][..], "predicted", 1.0));
    assert!(results.warnings.contains(&"in the log: Gap 10-410 (median Ts 1)".to_owned()), "{:?}", results.warnings);
}

const POSITION: &str = r#"
[plant]
a = [[0, 1], [0, 0]]
b = [[0], [1]]
c = [[1, 0]]
states = ["position", "speed"]
units = ["m", "m/s"]
time_unit = "s"
inputs = ["u"]
outputs = ["y"]

[log]
file = "log.csv"
states = ["-", "true speed"]
"#;

/// A log every second with a gap, a true speed in every second row.
fn oscillation() -> String {
    let mut csv = "t,u,y,true speed\n".to_owned();
    for k in (0..100).chain(150..250) {
        let t = f64::from(k);
        let speed = if k % 2 == 0 { format!("{}", (0.1 * t).cos()) } else { String::new() };
        _ = writeln!(csv, "{t},{},{},{speed}", -0.1 * (0.1 * t).sin(), 10.0 * (0.1 * t).sin());
    }
    csv
}

/// An observer in discrete time says which rows it uses; a period that fits no row is an error with the numbers.
#[test]
fn a_period_that_does_not_fit_the_log_is_named() {
    let cubic = |period: f64| {
        format!(
            "{POSITION}\n[[observer]]\nname = \"cubic\"\nkind = \"sampled-cubic\"\npoles = [-0.2, -0.3]\ntheta = 1\ngamma = 0.1\nperiod = {period}\n"
        )
    };
    let folder = bench("period", &oscillation());
    let fits = run(&folder, &cubic(1.0));
    assert_eq!(fits.failures(), Vec::<String>::new());
    let warned = |results: &Results| results.warnings.iter().any(|warning| warning.contains("Only"));
    assert!(!warned(&fits), "{:?}", fits.warnings);
    assert_eq!(fits.log.unwrap().rows[0].rows_used, 200);
    let partly = run(&folder, &cubic(3.0));
    assert_eq!(partly.failures(), Vec::<String>::new());
    assert!(
        partly.warnings.iter().any(|warning| warning
            == "cubic: Only 68 of 200 rows lie on the observer's samples (period 3 s, median Ts 1 s); the others are not used"),
        "{:?}",
        partly.warnings
    );
    let rarely = run(&folder, &cubic(0.25));
    assert!(
        rarely.warnings.iter().any(|warning| warning
            == "cubic: Only 200 of 997 samples of the observer (period 0.25 s, median Ts 1 s) have a row; at the others it predicts"),
        "{:?}",
        rarely.warnings
    );
    let never = run(&folder, &cubic(1000.0));
    let failure = never.log.as_ref().unwrap().rows[0].failure.clone().unwrap();
    assert!(
        failure.contains("does not fit the log: of 200 rows (median Ts 1) only the first lies on its samples"),
        "{failure}"
    );
    // On lines, where they are asked for and said.
    let lines = run(&folder, &cubic(0.25).replace("[log]\n", "[log]\ninterpolation = \"linear\"\n"));
    let log = lines.log.as_ref().unwrap();
    assert_eq!((log.interpolation, log.rows[0].interpolated), ("linear", 594));
    assert!(lines.warnings.iter().any(|warning| warning.contains("linear interpolation")), "{:?}", lines.warnings);
    let page = crate::page::read(&folder.join("out/report.html"));
    assert!(page.contains("Between the rows outputs are interpolated linearly, as asked for"));
}

/// Errors of the states that the log knows, NIS and NEES of the filter, and what is written of them.
#[test]
fn true_states_in_a_log_give_errors() {
    let folder = bench("truth", &oscillation());
    let filter = "\n[[observer]]\nname = \"filter\"\nkind = \"extended-kalman\"\nw = [0.001, 0.01]\nv = 0.01\nperiod = 1\ninitial = [0, 1]\n";
    let linear = "\n[[observer]]\nname = \"linear\"\nkind = \"luenberger\"\npoles = [-1, -1.5]\n";
    let results = run(&folder, &format!("{POSITION}{filter}{linear}"));
    assert_eq!(results.failures(), Vec::<String>::new());
    let log = results.log.as_ref().unwrap();
    let truth = column(&folder, "log-filter.csv", "speed");
    for row in &log.rows {
        let estimate = column(&folder, &format!("log-{}.csv", row.observer), "speed_hat");
        let errors: Vec<f64> = truth.iter().zip(&estimate).filter_map(|(x, xhat)| Some((*x)? - (*xhat)?)).collect();
        assert_eq!(errors.len(), 100);
        let [score] = &row.errors[..] else { panic!("{:?}", row.errors) };
        let rmse = (errors.iter().map(|e| e * e).sum::<f64>() / 100.0).sqrt();
        let peak = errors.iter().fold(0.0f64, |peak, e| peak.max(e.abs()));
        assert_eq!((score.state.as_str(), score.samples, score.last), ("speed", 100, errors[99]));
        assert!((score.rmse - rmse).abs() < 1e-12 && (score.peak - peak).abs() < 1e-12, "{score:?}");
    }
    // NEES of the one known state is e^2/P22 over the second half; both means have their acceptance region.
    let (filter, linear) = (&log.rows[0], &log.rows[1]);
    assert!(linear.nis.is_none() && linear.nees.is_none());
    let (nis, nees) = (filter.nis.as_ref().unwrap(), filter.nees.as_ref().unwrap());
    let sigma = column(&folder, "log-filter.csv", "speed_2sigma");
    let estimate = column(&folder, "log-filter.csv", "speed_hat");
    let squares: Vec<f64> =
        (100..200).filter_map(|k| Some(((truth[k]? - estimate[k]?) / (sigma[k]? / 2.0)).powi(2))).collect();
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    assert!((nees.mean - mean).abs() < 1e-9 * mean && nees.samples == 50 && nees.expected == 1.0, "{nees:?} {mean}");
    // scipy 1.17.1: chi2.ppf([0.025, 0.975], 100)/100, chi2.ppf([0.025, 0.975], 50)/50.
    assert!((nis.region[0] - 0.7422192747).abs() < 1e-9 && (nis.region[1] - 1.295611971858).abs() < 1e-9, "{nis:?}");
    assert!((nees.region[0] - 0.647147).abs() < 1e-5 && (nees.region[1] - 1.428404).abs() < 1e-5, "{nees:?}");
    assert_eq!(nis.accepted, (nis.region[0]..=nis.region[1]).contains(&nis.mean));
    let page = crate::page::read(&folder.join("out/report.html"));
    for said in
        ["RMSE", "NIS (innovations)", "NEES (errors)", "whiteness test p-value (Ljung-Box)", "filter \u{b1} 2 sigma"]
    {
        assert!(page.contains(said), "{said}");
    }
    // Errors are counted where the state is known, over the second half.
    let within = squares.iter().filter(|square| **square <= 4.0).count();
    let [coverage] = &results.coverage[..] else { panic!("{:?}", results.coverage) };
    let states: Vec<_> = coverage.states.iter().map(|of| (of.state.as_str(), of.within, of.samples)).collect();
    assert_eq!(states, [("speed", within as f64 / 50.0, 50)]);
    assert_eq!((coverage.observer.as_str(), coverage.on_log, coverage.stationary), ("filter", true, false));
    let json: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(folder.join("out/study.json")).unwrap()).unwrap();
    assert_eq!(json["log"]["rows"][0]["errors"][0]["state"], "speed");
}

/// A filter in a simulation is tested as well, over all its samples; there the truth is known.
#[test]
fn a_filter_in_a_simulation_has_nis_and_nees() {
    let folder = bench("simulated", "");
    let simulation = POSITION[..POSITION.find("[log]").unwrap()].to_owned()
        + "[simulation]\nx0 = [1, 0]\nduration = 200\nsamples = 101\nnoise = { amplitude = [0.2], period = 0.5, seed = 4 }\n";
    let filter = |name: &str, v: f64| {
        format!("\n[[observer]]\nname = \"{name}\"\nkind = \"extended-kalman\"\nw = 0\nv = {v}\np0 = 1\nperiod = 0.5\n")
    };
    let results = run(&folder, &(simulation + &filter("right", 0.04) + &filter("trusting", 0.0004)));
    assert_eq!(results.failures(), Vec::<String>::new());
    let [right, trusting] = &results.filters[..] else { panic!("{:?}", results.filters) };
    let nis = right.nis.as_ref().unwrap();
    assert!(nis.accepted && nis.samples == 400 && nis.expected == 1.0, "{nis:?}");
    // Without process noise the error is a polynomial of degree 1, which all measurements share: NEES is one draw of
    // chi-squared with 2 degrees, slowly averaged, and far from that of a filter that believes in a tenth of the noise.
    let nees = |filter: &luenberger_study::results::FilterReport| filter.nees.as_ref().unwrap().mean;
    assert!(nees(right) < 10.0 && nees(trusting) > 10.0 * nees(right), "{} {}", nees(right), nees(trusting));
    let trusting = trusting.nis.as_ref().unwrap();
    assert!(!trusting.accepted && trusting.mean > 20.0 && trusting.in_words().contains("above ["), "{trusting:?}");
    let sigma = column(&folder, "right.csv", "speed_2sigma");
    assert_eq!(sigma[0], Some(2.0));
    assert!(sigma.last().unwrap().unwrap() < 0.02);
}

/// A log that leaves the region of a certificate is said to, with the count of its rows.
#[test]
fn leaving_the_design_region_is_counted() {
    let mut csv = "t,torque,angle,true angle,true speed\n".to_owned();
    for k in 0..200 {
        let t = 0.01 * f64::from(k);
        let (torque, angle) = (if k < 30 { 3.0 } else { 0.0 }, 0.5 + 0.6 * t);
        _ = writeln!(csv, "{t},{torque},{angle},{angle},0.6");
    }
    let folder = bench("region", &csv);
    let results = run(
        &folder,
        r#"
[plant]
states = ["angle", "speed"]
inputs = ["torque"]
f = ["speed", "-sin(angle) - speed + torque"]
h = ["angle"]
outputs = ["angle"]

[log]
file = "log.csv"
states = ["true angle", "true speed"]

[[observer]]
name = "lpv"
kind = "lpv"
region = { states = [[-1, 1], [-2, 2]], inputs = [[-1, 1]] }
decay_rate = 1
initial = [0.5, 0]
"#,
    );
    let said: Vec<&String> = results.warnings.iter().filter(|warning| warning.contains("Guarantee")).collect();
    // The input in the first 30 rows, the true angle in the last 116.
    assert_eq!(
        said,
        [
            "Guarantee not valid outside the design region: lpv: outside at 146 of 200 rows, first at t = 0, where torque = 3 is not in [-1, 1]"
        ]
    );
}

/// The innovations of a report are those of the second half of the log: of 20 rows, in which three outliers by 50 are
/// rejected, the two of the second half are counted beside its eight other measurements. The warning counts all.
#[test]
fn rejected_measurements_are_those_of_the_second_half() {
    let mut csv = "t,speed,position\n".to_owned();
    for k in 0..20 {
        let outlier = if [3, 12, 15].contains(&k) { 50.0 } else { 0.0 };
        _ = writeln!(csv, "{k},0.5,{}", 0.5 * f64::from(k) + outlier);
    }
    let results = run(&bench("rejected", &csv), &format!("{CART}{FILTER}period = 1\ngate = 5\n"));
    let log = results.log.as_ref().unwrap();
    let [output] = &log.rows[0].outputs[..] else { panic!("{:?}", log.rows[0].outputs) };
    assert_eq!((output.samples, output.rejected, output.samples_in_words().as_str()), (8, 2, "8 (2 rejected)"));
    assert!(output.peak < 1e-12, "{output:?}");
    let warned = results.warnings.iter().find(|warning| warning.contains("gate")).unwrap();
    assert!(warned.contains("rejects 3 of 20 measurements of position"), "{warned}");
}

/// A constant, measured N times without process noise: after k measurements the variance is p0 v/(v + k p0), and that
/// of the estimate from the whole log is the last of these at every row.
#[test]
fn the_deviations_of_a_smoothed_log_are_root_mean_squares_over_its_rows() {
    let rows = 30;
    let row = |csv: String, k: i32| csv + &format!("{k},0,{}\n", 0.1 * f64::from(k % 3));
    let csv = (0..rows).fold("t,speed,position\n".to_owned(), row);
    let filter = FILTER.replace("w = [[0.01]]", "w = [[0]]");
    let text = format!("{CART}{filter}period = 1\nsmooth = true\n");
    let results = run(&bench("constant", &csv), &text);
    let (p0, v) = (1.0, 0.04);
    let variance = |k: i32| p0 * v / (v + f64::from(k) * p0);
    let mean = (1..=rows).map(variance).sum::<f64>() / f64::from(rows);
    let smoothed = results.log.as_ref().unwrap().rows[0].smoothed.as_ref().unwrap();
    let [found] = &smoothed.deviations[..] else { panic!("{:?}", smoothed.deviations) };
    assert!((found.filtered - mean.sqrt()).abs() < 1e-9, "{found:?}, expected {}", mean.sqrt());
    assert!((found.smoothed - variance(rows).sqrt()).abs() < 1e-9, "{found:?}, expected {}", variance(rows).sqrt());
}

/// The band of a stationary filter is that of a measurement in every row, P = sqrt(W V) of x' = w: a log in which one
/// is missing has none.
#[test]
fn a_log_with_a_missing_measurement_has_no_stationary_band() {
    let kalman = "\n[[observer]]\nname = \"stationary\"\nkind = \"kalman\"\nw = 0.09\nv = 0.04\n";
    let full = (0..20).fold("t,speed,position\n".to_owned(), |csv, k| csv + &format!("{k},0,0.5\n"));
    let header = |name: &str, csv: &str| {
        let folder = bench(name, csv);
        let results = run(&folder, &format!("{CART}{kalman}"));
        assert_eq!(results.failures(), Vec::<String>::new());
        let text = std::fs::read_to_string(folder.join("out/trajectories/log-stationary.csv")).unwrap();
        (folder, text.lines().next().unwrap().to_owned())
    };
    let (folder, columns) = header("stationary", &full);
    assert!(columns.contains("x_2sigma"), "{columns}");
    for band in column(&folder, "log-stationary.csv", "x_2sigma") {
        assert!((band.unwrap() - 2.0 * (0.09f64 * 0.04).sqrt().sqrt()).abs() < 1e-9, "{band:?}");
    }
    let (_, columns) = header("stationary-missing", &full.replace("\n7,0,0.5\n", "\n7,0,\n"));
    assert!(columns.contains("x_hat") && !columns.contains("2sigma"), "{columns}");
}

/// A filter that is too sure of its first estimate rejects every measurement, and the report says so.
#[test]
fn a_gate_that_locks_a_filter_out_is_named() {
    let folder = bench("gate", &with_a_gap());
    let filter = |p0: f64| {
        let sure = FILTER.replace("p0 = [[1]]", &format!("p0 = [[{p0}]]\ninitial = [-30]"));
        format!("{CART}{sure}period = 1\ngate = 5\n")
    };
    let warned = |p0: f64| {
        let results = run(&folder, &filter(p0));
        let row = results.log.as_ref().unwrap().rows[0].clone();
        let text = results.text(false);
        let line = text.lines().find(|line| line.contains(" rejected)")).unwrap_or_else(|| panic!("{text}"));
        // What has no samples has no mean.
        let numbers = line.split_once(" rejected)").map(|(_, rest)| rest.split_whitespace().collect::<Vec<_>>());
        assert_eq!(row.outputs[0].samples == 0, numbers == Some(vec!["-"; 4]), "{line}");
        (results.warnings.into_iter().find(|warning| warning.contains("gate")), row.outputs[0].rejected)
    };
    let (warning, _) = warned(1e-4);
    let expected = "filter: the gate rejects 22 of 22 measurements of position: the filter is overconfident, or the model is wrong; increase p0, w or gate";
    assert_eq!(warning.as_deref(), Some(expected));
    // With P(0) that covers the first error, only the rows after the sensor has moved by 100 are rejected.
    let (warning, rejected) = warned(900.0);
    assert!(warning.is_some_and(|warning| warning.contains("rejects 11 of 22")) && rejected == 11);
    let text = filter(1.0).replace("gate = 5", "gate = 0");
    let error = Study::from_text("study.toml", &text, Format::Toml, &folder).unwrap_err().to_string();
    assert!(error.contains("`gate` is 0"), "{error}");
}
