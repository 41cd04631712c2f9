//! Iterated and unscented Kalman filters and moving-horizon estimators in studies, and smoothed estimates on logs.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use luenberger_export::{Scalar, golden};
use luenberger_study::deployment::{exported, record, sampled};
use luenberger_study::{Results, RunOptions, Step, execute};

use crate::studies::{self, kinds_with, last_errors, needing_noises, read, scratch, study_in};

fn run(text: &str, folder: &Path, output: Option<PathBuf>) -> Results {
    let options = RunOptions { output: output.map(Into::into), threads: Some(1), ..RunOptions::default() };
    execute(&study_in(folder, text), Step::Run, &options).unwrap_or_else(|error| panic!("{error}"))
}

pub(crate) const MAP: &str = r#"[plant]
f = ["x1 + 0.1*x2", "x2 - 0.981*sin(x1) + 0.1*u1"]
h = ["sin(x1)"]
dt = 0.1
[input]
expressions = ["cos(3*t)"]
[simulation]
x0 = [0.3, 0.1]
duration = 2.5
estimates = "predicted"
[[observer]]
kind = "ukf"
w = [1e-3, 1e-2]
v = 0.01
period = 0.1
alpha = 0.5
"#;

/// filterpy 2.0.0: `UnscentedKalmanFilter` with `MerweScaledSigmaPoints(2, 0.5, 2, 0)`, sigma points drawn again before
/// each update.
#[test]
fn an_unscented_filter_of_a_map_is_that_of_filterpy() {
    let results = run(MAP, ".".as_ref(), None);
    assert_eq!(results.failures(), Vec::<String>::new());
    for (found, expected) in last_errors(&results, "ukf").iter().zip([-0.006392627217642666, -0.008556905206280607]) {
        assert!((found.abs() - f64::abs(expected)).abs() < 1e-12, "{found}, expected {expected}");
    }
    let design = results.observers[0].design.as_ref().unwrap();
    assert_eq!(
        (design.verdict.word(), design.evidence.as_deref()),
        ("none", Some("no certificate: no theorem of stability"))
    );
    // NIS and NEES as of other filters.
    let [filter] = &results.filters[..] else { panic!("one filter") };
    assert!(filter.nis.is_some() && filter.nees.is_some());
}

/// A pendulum in continuous time: unscented and extended filter agree to the order of their difference, and the export
/// says that there is no certificate.
#[test]
fn an_unscented_filter_of_a_pendulum() {
    let filter = |kind: &str| {
        format!(
            "[[observer]]\nname = \"{kind}\"\nkind = \"{kind}\"\nw = [0, 1e-3]\nv = 1e-4\np0 = 1e-2\nperiod = 0.05\ninitial = [0.1, 0]\n"
        )
    };
    let text = format!(
        "[plant]\nf = [\"x2\", \"-9.81*sin(x1) + u1\"]\nh = [\"x1\"]\n[input]\nexpressions = [\"0.5*sin(t)\"]\n\
         [simulation]\nx0 = [0.2, 0]\nduration = 5\nhold = 0.05\n{}{}",
        filter("ukf"),
        filter("extended-kalman")
    );
    let results = run(&text, ".".as_ref(), None);
    assert_eq!(results.failures(), Vec::<String>::new());
    for (one, other) in last_errors(&results, "ukf").iter().zip(&last_errors(&results, "extended-kalman")) {
        assert!((one - other).abs() < 1e-4, "{one} {other}");
    }
    let study = studies::study(&text);
    let observer = &study.observers[0];
    let design = sampled(&study, observer, None, None).unwrap();
    let export = exported(&study, observer, design.design.clone(), Scalar::Binary32, None).unwrap();
    let header = export.c().unwrap().into_iter().find(|file| file.name == "ukf.h").unwrap().text;
    assert!(header.contains("float S[UKF_STATES][UKF_STATES];"), "{header}");
}

/// The position of a cart every second with a gap of 30 s.
fn log() -> String {
    let mut csv = "t,position,true speed\n".to_owned();
    for k in (0..40).chain(70..110) {
        let t = f64::from(k);
        _ = writeln!(csv, "{t},{},{}", 10.0 * (0.1 * t).sin() + 0.1 * (7.0 * t).sin(), (0.1 * t).cos());
    }
    csv
}

fn smoothed(kind: &str) -> String {
    format!(
        "[plant]\nf = [\"speed\", \"0\"]\nh = [\"position\"]\nstates = [\"position\", \"speed\"]\noutputs = [\"position\"]\n\
         units = [\"m\", \"m/s\"]\ntime_unit = \"s\"\n[log]\nfile = \"log.csv\"\nstates = [\"-\", \"true speed\"]\n\
         [[observer]]\nname = \"filter\"\nkind = \"{kind}\"\nw = [0, 0.01]\nv = 0.01\nperiod = 1\ninitial = [0, 1]\nsmooth = true\n"
    )
}

/// Beside the filter's estimates stand those from the whole log: in the table of the trajectory, the tables of errors,
/// consistency and deviations, and the figures.
#[test]
fn estimates_on_a_log_are_smoothed() {
    for kind in needing_noises(kinds_with(&["smooth"])) {
        let folder = scratch(&format!("smoothed-{kind}"));
        std::fs::write(folder.join("log.csv"), log()).unwrap();
        let results = run(&smoothed(kind), &folder, Some(folder.join("out")));
        assert_eq!(results.failures(), Vec::<String>::new());
        let row = &results.log.as_ref().unwrap().rows[0];
        let found = row.smoothed.as_ref().unwrap();
        let (filter, whole) = (&row.errors[0], &found.errors[0]);
        assert_eq!((filter.samples, whole.samples, whole.state.as_str()), (80, 80, "speed"));
        assert!(whole.rmse < 0.7 * filter.rmse, "{whole:?} {filter:?}");
        // At the last row the filter knows the whole log.
        assert!((whole.last - filter.last).abs() < 1e-12);
        assert!(found.nees.is_some() && found.estimate.len() == 2);
        assert!(found.deviations.iter().all(|of| of.smoothed < of.filtered), "{:?}", found.deviations);

        let table = std::fs::read_to_string(folder.join("out/trajectories/log-filter.csv")).unwrap();
        let head: Vec<&str> = table.lines().next().unwrap().split(',').collect();
        let at =
            |name: &str| head.iter().position(|title| *title == name).unwrap_or_else(|| panic!("{name}: {head:?}"));
        let (hat, after) = (at("speed_hat"), at("speed_smoothed"));
        let (before_gap, last) = (table.lines().nth(40).unwrap(), table.lines().last().unwrap());
        let cell = |row: &str, column: usize| row.split(',').nth(column).unwrap().parse::<f64>().unwrap();
        assert!((cell(last, hat) - cell(last, after)).abs() < 1e-12);
        assert!(cell(before_gap, at("speed_smoothed_2sigma")) < cell(before_gap, at("speed_2sigma")));
        let page = std::fs::read_to_string(folder.join("out/report.html")).unwrap();
        for said in ["filter, smoothed", "Standard deviations that the filters compute"] {
            assert!(page.contains(said), "{said}");
        }
        assert!(std::fs::read_to_string(folder.join("out/figures/log-states.svg")).unwrap().contains("smoothed"));
    }
}

/// numpy 2.4.6, Gauss-Newton steps in information form, of the growth model with a row that measures nothing.
/// Innovations and NIS are those of the second half.
#[test]
fn an_iterated_filter_on_a_log_is_that_of_gauss_newton_steps() {
    let text = r#"[plant]
states = ["x"]
outputs = ["y"]
f = ["0.5*x + 25*x/(1 + x^2) + 8*cos(1.2*t)"]
h = ["x^2/20"]
dt = 1
[log]
file = "log.csv"
[[observer]]
kind = "iterated-extended-kalman"
initial = [0.5]
p0 = 1
w = 10
v = 1
period = 1
"#;
    let folder = scratch("iterated-growth");
    let rows = "t,y\n0,2.0414191213851827\n1,0.716639589840931\n2,\n3,-1.948016215083824\n4,9.1\n";
    std::fs::write(folder.join("log.csv"), rows).unwrap();
    for (iterations, x, p, mean, rms, nis) in [
        (
            "",
            [0.62567163988216, 4.707230643683667, 10.334119242442682, -1.4294919197509999, -13.585988702821213],
            [0.9961513939454552, 2.721998515683783, 10.643738043622514, 4.55801925511905, 0.5316550454130028],
            -6.127872550249588,
            7.340502070923784,
            2.0623249334523623,
        ),
        (
            "iterations = 1\n",
            [0.6011929736351712, 10.067397652264212, 10.391562375339072, -1.2161263357644438, -14.612235405043991],
            [0.9975062344139651, 0.2665781254358664, 10.018092677982656, 8.250695584044436, 0.24659241923567984],
            -6.541247771676587,
            7.912565255551387,
            2.2195362397514966,
        ),
    ] {
        let results = run(&format!("{text}{iterations}"), &folder, None);
        assert_eq!(results.failures(), Vec::<String>::new());
        let (estimates, deviations) =
            (results.runs[0].estimate.as_ref().unwrap(), results.runs[0].deviation.as_ref().unwrap());
        for k in 0..5 {
            let [found, deviation] = [estimates[(k, 0)], deviations[(k, 0)]];
            // Rounding grows along the plant.
            assert!((found - x[k]).abs() < 1e-10 * x[k].abs().max(1.0), "{k}: {found}, expected {}", x[k]);
            assert!((deviation * deviation - p[k]).abs() < 1e-9, "{k}: {deviation}");
        }
        let row = &results.log.as_ref().unwrap().rows[0];
        let found = [row.outputs[0].mean, row.outputs[0].rms, row.nis.as_ref().unwrap().mean];
        assert!(
            found.iter().zip([mean, rms, nis]).all(|(found, expected)| (found - expected).abs() < 1e-9),
            "{found:?}"
        );
        let design = results.observers[0].design.as_ref().unwrap();
        assert_eq!(
            (design.verdict.word(), design.evidence.as_deref()),
            ("none", Some("no certificate: local convergence only"))
        );
        let times = if iterations.is_empty() { "3 times" } else { "1 time" };
        assert!(
            design.statement.to_string().contains(&format!("each update linearised {times}.")),
            "{}",
            design.statement
        );
    }
    // Once is the other kind, bit by bit.
    let of = |text: &str| run(text, &folder, None).runs[0].estimate.clone().unwrap();
    let once = of(&format!("{text}iterations = 1\n"));
    assert_eq!(once, of(&text.replace("iterated-extended-kalman", "extended-kalman")));
    assert_ne!(once, of(text));
}

#[test]
fn mistakes_in_filters_are_named() {
    for (old, new, message, expected) in [
        ("alpha = 0.5", "kappa = -2", "`kappa` leaves no sigma points: alpha = 1, kappa = -2", "kappa > -2"),
        ("alpha = 0.5", "alpha = 0", "`alpha` is 0", "positive"),
        ("alpha = 0.5", "smooth = true", "`smooth` is for estimates on a log", "[log]"),
        ("alpha = 0.5", "substeps = 0", "`substeps` is 0", "1"),
        ("v = 0.01\n", "v = [1, 2]\n", "the diagonal `v` has length 2", "expected length 1"),
        ("period = 0.1\n", "", "has no `period`", "positive"),
    ] {
        let text = MAP.replace(old, new);
        let error = read(&text).unwrap_err().to_string();
        assert!(error.contains(message) && error.contains(expected), "{error}");
    }
    let iterated = MAP.replace("\"ukf\"", "\"iterated-extended-kalman\"");
    for (keys, message, expected) in [
        ("iterations = 0", "`iterations` is 0", "1"),
        ("iterations = 101", "`iterations` is 101", "at most 100"),
        ("alpha = 0.5", "`alpha`", "iterations"),
    ] {
        let error = read(&iterated.replace("alpha = 0.5", keys)).unwrap_err().to_string();
        assert!(error.contains(message) && error.contains(expected), "{error}");
    }
    // A covariance that is none, and a period that is not that of the plant, are found by the design.
    for (old, new, message) in
        [("w = [1e-3, 1e-2]", "w = [-1, 1]", "W"), ("period = 0.1\nalpha", "period = 0.2\nalpha", "period = 0.2")]
    {
        let text = MAP.replace(old, new);
        let results = match read(&text) {
            Ok(study) => execute(&study, Step::Design, &RunOptions::default()).unwrap(),
            Err(error) => {
                assert!(error.to_string().contains('w'), "{error}");
                continue;
            }
        };
        let failure = results.observers[0].failure.as_ref().unwrap();
        assert!(failure.hypothesis.contains(message), "{failure:?}");
    }
}

/// Without active bounds the estimator of a linear plant is the filter, in a simulation and on a log; with bounds it
/// keeps them; and it has no export.
#[test]
fn a_moving_horizon_estimator() {
    let plant = "[plant]\na = [[1, 0.1], [-0.2, 0.9]]\nb = [[0], [0.1]]\nc = [[1, 0]]\ndt = 0.1\nstates = [\"x\", \"v\"]\noutputs = [\"y\"]\ninputs = [\"u\"]\n";
    let noise = "w = [1e-3, 1e-2]\nv = 0.01\nperiod = 0.1\n";
    let observers = format!(
        "[[observer]]\nkind = \"mhe\"\nwindow = 4\n{noise}[[observer]]\nkind = \"extended-kalman\"\n{noise}\
         [[observer]]\nname = \"bounded\"\nkind = \"mhe\"\nstate_bounds = [[-inf, inf], [0, inf]]\n{noise}"
    );
    let simulated = format!(
        "{plant}[input]\nexpressions = [\"cos(3*t)\"]\n[simulation]\nx0 = [0.3, 0.1]\nduration = 3\nnoise = {{ amplitude = [0.05], period = 0.1, seed = 3 }}\n{observers}"
    );
    let results = run(&simulated, ".".as_ref(), None);
    assert_eq!(results.failures(), Vec::<String>::new());
    for (one, other) in last_errors(&results, "mhe").iter().zip(&last_errors(&results, "extended-kalman")) {
        assert!((one - other).abs() < 1e-12, "{one} {other}");
    }
    let [own, filter, _] = &results.filters[..] else { panic!("three") };
    let mean = |of: &Option<luenberger_study::results::ConsistencyReport>| of.as_ref().unwrap().mean;
    assert!((mean(&own.nis) - mean(&filter.nis)).abs() < 1e-9 && (mean(&own.nees) - mean(&filter.nees)).abs() < 1e-9);

    let folder = scratch("moving-horizon");
    let mut csv = "t,u,y\n".to_owned();
    for k in 0..60 {
        let t = 0.1 * f64::from(k);
        let y = if k % 5 == 3 { String::new() } else { format!("{}", (3.0 * t).sin()) };
        _ = writeln!(csv, "{t},{},{y}", (2.0 * t).cos());
    }
    std::fs::write(folder.join("log.csv"), csv).unwrap();
    let logged = format!("{plant}[log]\nfile = \"log.csv\"\n{observers}");
    let results = run(&logged, &folder, Some(folder.join("out")));
    assert_eq!(results.failures(), Vec::<String>::new());
    let rows = &results.log.as_ref().unwrap().rows;
    for (one, other) in rows[0].estimate.iter().zip(&rows[1].estimate) {
        assert!((one - other).abs() < 1e-11, "{one} {other}");
    }
    let table = std::fs::read_to_string(folder.join("out/trajectories/log-bounded.csv")).unwrap();
    let head: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let at = head.iter().position(|title| *title == "v_hat").unwrap();
    let speeds: Vec<f64> =
        table.lines().skip(1).map(|line| line.split(',').nth(at).unwrap().parse().unwrap()).collect();
    // The prediction where nothing is measured is not bounded.
    let measured = speeds.iter().enumerate().filter(|(k, _)| k % 5 != 3);
    assert!(measured.clone().all(|(_, v)| *v >= 0.0) && measured.filter(|(_, v)| **v < 1e-9).count() > 5, "{speeds:?}");

    // The exported step, with the matrices of the plant as expressions: its own run, and the header of its C.
    let study = studies::study(&simulated);
    for (k, most) in [(0, 1e-9), (2, 1e-6)] {
        let observer = &study.observers[k];
        let design = sampled(&study, observer, None, None).unwrap();
        let record = record(&study, observer, &design).unwrap();
        let export = exported(&study, observer, design.design, Scalar::Binary64, None).unwrap();
        let difference = record.difference(&golden::replay(&export, &record.samples).unwrap()).unwrap();
        assert!(difference.largest.iter().all(|x| *x < most), "{difference:?}");
        let files = export.c().unwrap();
        let header = &files.iter().find(|file| file.name == format!("{}.h", observer.name)).unwrap().text;
        let is_stated = header.contains("floating-point operations, ") && header.contains("without active bounds");
        assert!(
            is_stated == (k == 2) && header.contains(&format!("_WINDOW {}", if k == 2 { 10 } else { 4 })),
            "{header}"
        );
    }
}

#[test]
fn mistakes_in_moving_horizon_estimators_are_named() {
    let mhe = MAP.replace("ukf", "mhe");
    for (new, message, expected) in [
        ("window = 0", "`window` is 0", "1"),
        ("window = 33", "`window` is 33", "at most 32"),
        ("iterations = 0", "`iterations` is 0", "1"),
        ("state_bounds = [[0, 1]]", "`state_bounds` has 1 pair", "expected 2 pairs"),
        ("state_bounds = [[0, 1], [1, 1]]", "pair 2 of `state_bounds` is from 1 to 1", "below the upper"),
        ("gate = 5", "`gate`", "window"),
    ] {
        let text = mhe.replace("alpha = 0.5", new);
        let error = read(&text).unwrap_err().to_string();
        assert!(error.contains(message) && error.contains(expected), "{error}");
    }
}

/// A carriage in discrete time with the noise that its filters are designed for.
const MATCHED: &str = r#"[plant]
a = [[1, 0.1], [0, 1]]
c = [[1, 0]]
dt = 0.1
states = ["place", "speed"]
[truth]
process_noise = { distribution = "gaussian", amplitude = [0.01, 0.1], period = 0.1, seed = 5 }
[simulation]
x0 = [0, 0]
duration = 400
samples = 4001
noise = { distribution = "gaussian", amplitude = [0.2], period = 0.1, seed = 6 }
[[observer]]
name = "predictor"
kind = "kalman"
w = [1e-4, 1e-2]
v = 0.04
[[observer]]
name = "filter form"
kind = "kalman"
w = [1e-4, 1e-2]
v = 0.04
form = "filter"
[[observer]]
name = "extended"
kind = "extended-kalman"
w = [1e-4, 1e-2]
v = 0.04
period = 0.1
[[observer]]
name = "unscented"
kind = "ukf"
w = [1e-4, 1e-2]
v = 0.04
period = 0.1
"#;

/// Two standard deviations by scipy, `2 sqrt(diag(solve_discrete_are(A', C', W, V)))`, and with the measurement of the
/// sample, `2 sqrt(diag((I - K C) P))`; 95.45 % of the errors are within them.
#[test]
fn every_kalman_filter_has_a_band_that_holds_its_errors() {
    let (predicted, filtered) = ([0.245_995_28, 0.545_646_84], [0.209_540_99, 0.507_671_62]);
    let folder = scratch("bands");
    let results = run(MATCHED, ".".as_ref(), Some(folder.clone()));
    assert_eq!(results.failures(), Vec::<String>::new());
    assert_eq!(results.coverage.len(), 4);
    for (name, expected, report) in [
        ("predictor", predicted, &results.coverage[0]),
        ("filter-form", filtered, &results.coverage[1]),
        ("extended", filtered, &results.coverage[2]),
        ("unscented", filtered, &results.coverage[3]),
    ] {
        let text = std::fs::read_to_string(folder.join(format!("trajectories/{name}.csv"))).unwrap();
        let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        let column = |title: &str| rows[0].iter().position(|name| *name == title).unwrap();
        let at = |row: &[&str], title: &str| row[column(title)].parse::<f64>().unwrap();
        for (k, state) in ["place", "speed"].into_iter().enumerate() {
            let band = at(rows.last().unwrap(), &format!("{state}_2sigma"));
            assert!((band - expected[k]).abs() < 1e-7, "{name}: {band}, expected {}", expected[k]);
            let within = rows[1..].iter().filter(|row| {
                let error = at(row, state) - at(row, &format!("{state}_hat"));
                error.abs() <= at(row, &format!("{state}_2sigma"))
            });
            let share = within.count() as f64 / 4001.0;
            assert!((share - 0.9545).abs() < 0.02, "{name}, {state}: {share}");
            assert_eq!((report.states[k].within, report.states[k].samples), (share, 4001));
        }
        assert_eq!(report.stationary, matches!(name, "predictor" | "filter-form"));
    }
    let html = std::fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(html.contains("within ± 2 sigma") && html.contains("of a stationary Kalman filter to either side"));
}

/// A filter of a plant for which no observer exists does not claim to converge, and its period has the unit of time.
#[test]
fn filters_of_an_undetectable_plant_say_so() {
    let folder = scratch("filters-undetectable");
    let evidence = |rate: &str| {
        let plant = format!("[plant]\na = [[-1, 0], [0, {rate}]]\nc = [[1, 0]]\ntime_unit = \"s\"\n");
        let of = |kind: &str| {
            let text = format!("{plant}[[observer]]\nkind = \"{kind}\"\nw = 1\nv = 1\nperiod = 0.05\n");
            let results = execute(&study_in(&folder, &text), Step::Design, &RunOptions::default()).unwrap();
            let design = results.observers[0].design.clone().unwrap();
            assert!(design.statement.to_string().starts_with("One measurement every 0.05 s; "), "{design:?}");
            design.evidence.unwrap()
        };
        ["extended-kalman", "ukf"].map(of)
    };
    assert_eq!(evidence("2"), ["no certificate: the plant is not detectable, no observer exists"; 2]);
    assert_eq!(evidence("-2"), ["no certificate: local convergence only", "no certificate: no theorem of stability"]);
}
