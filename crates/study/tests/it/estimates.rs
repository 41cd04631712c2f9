//! Which estimate of a filter has the errors, which innovation is its own, and over what its consistency is tested: on
//! a log and in a simulation alike.

use std::path::PathBuf;

use luenberger_study::{Results, RunOptions, Step, execute};

use crate::studies::{self, scratch, study_in};

fn bench(name: &str, csv: &str) -> PathBuf {
    let folder = scratch(&format!("estimates/{name}"));
    std::fs::write(folder.join("log.csv"), csv).unwrap();
    folder
}

fn run(folder: &std::path::Path, text: &str) -> Results {
    let options = RunOptions { threads: Some(1), ..RunOptions::default() };
    execute(&study_in(folder, text), Step::Simulate, &options).unwrap_or_else(|error| panic!("{error}"))
}

/// The constant 1 from the estimate 0 with the variance 1, measured exactly with the variance 1 assumed: after k
/// measurements the error and the variance are 1/(k + 1).
const CONSTANT: &str = r#"[plant]
states = ["x"]
outputs = ["y"]
f = ["0"]
h = ["x"]
"#;

fn filters(initial: &str, p0: &str, w: &str) -> String {
    let one =
        |kind| format!("[[observer]]\nkind = \"{kind}\"\ninitial = {initial}\np0 = {p0}\nw = {w}\nv = 1\nperiod = 1\n");
    studies::filters().into_iter().map(one).collect()
}

/// Root mean square of 1/2, 1/3, 1/4, 1/5 (filtered) and of 1, 1/2, 1/3, 1/4 (predicted), in a simulation and on a log.
#[test]
fn a_simulation_and_a_log_have_one_rule() {
    let rms = |errors: [f64; 4]| (errors.iter().map(|e| e * e).sum::<f64>() / 4.0).sqrt();
    let folder = bench("rule", "t,y,true\n0,1,1\n1,1,1\n2,1,1\n3,1,1\n");
    for (key, estimates, rmse, last) in [
        ("", "filtered", rms([1.0 / 2.0, 1.0 / 3.0, 1.0 / 4.0, 1.0 / 5.0]), 0.2),
        ("estimates = \"predicted\"\n", "predicted", rms([1.0, 1.0 / 2.0, 1.0 / 3.0, 1.0 / 4.0]), 0.25),
    ] {
        let simulation = format!("[simulation]\nx0 = [1]\nduration = 3\nsamples = 4\n{key}");
        let log = format!("[log]\nfile = \"log.csv\"\nstates = [\"true\"]\n{key}");
        let results = run(&folder, &format!("{CONSTANT}{simulation}{log}{}", filters("[0]", "1", "0")));
        assert_eq!(results.failures(), Vec::<String>::new());
        let (simulation, log) = (results.simulation.as_ref().unwrap(), results.log.as_ref().unwrap());
        assert_eq!((simulation.scoring.estimates, log.estimates), (estimates, estimates));
        assert!(simulation.scoring.words.iter().any(|words| words.contains(estimates)), "{:?}", simulation.scoring);
        assert!(log.estimates_in_words().contains(estimates));
        for (k, kind) in studies::filters().iter().enumerate() {
            let state = &simulation.rows[k].merits.as_ref().unwrap().states[0];
            let row = &log.rows[k].errors[0];
            for (found, expected) in [(state.rmse, rmse), (row.rmse, rmse), (state.last, last), (row.last, last)] {
                assert!((found - expected).abs() < 1e-9, "{kind}, {estimates}: {found}, expected {expected}");
            }
            // The unit of settling is the error of the first estimate, before any measurement.
            assert!((state.initial - 1.0).abs() < 1e-12 && (state.peak - 1.0).abs() < 1e-12);
            // The rows and their bands are those of the scored estimates.
            let run = &results.runs[k];
            let (estimate, deviation) = (run.estimate.as_ref().unwrap(), run.deviation.as_ref().unwrap());
            assert!((1.0 - estimate[(3, 0)] - last).abs() < 1e-9, "{kind}: {estimate}");
            assert!((deviation[(3, 0)] - last.sqrt()).abs() < 1e-9, "{kind}: {deviation}");
        }
    }
}

/// A state with the variance 0 that is known. Of the covariance of rank one NEES is that of the other state: errors and
/// variances 1/4 and 1/5 in the second half, so that the squares have the mean (1/4 + 1/5)/2, with one degree of
/// freedom each. Where the state is not what the filter takes it for, that is counted, and the filter inconsistent.
#[test]
fn the_consistency_of_a_singular_covariance_is_that_of_its_rank() {
    let plant = "[plant]\nstates = [\"x\", \"k\"]\noutputs = [\"y\"]\nf = [\"0\", \"0\"]\nh = [\"x\"]\n";
    let log = "[log]\nfile = \"log.csv\"\nstates = [\"tx\", \"tk\"]\n";
    let folder = bench("rank", "t,y,tx,tk\n0,1,1,0.5\n1,1,1,0.5\n2,1,1,0.5\n3,1,1,0.5\n");
    for (initial, outside) in [("[0, 0.5]", 0), ("[0, 0.6]", 2)] {
        let simulation = "[simulation]\nx0 = [1, 0.5]\nduration = 4\nsamples = 5\n";
        let results = run(&folder, &format!("{plant}{simulation}{log}{}", filters(initial, "[1, 0]", "[0, 0]")));
        for row in &results.log.as_ref().unwrap().rows {
            let nees = row.nees.as_ref().unwrap();
            assert!((nees.mean - 0.225).abs() < 1e-9 && nees.expected == 1.0, "{nees:?}");
            // The quantiles of chi-squared with two degrees, halved: -ln(0.975) and -ln(0.025).
            let [low, high] = nees.region;
            assert!((low - 0.025317808).abs() < 1e-8 && (high - 3.688879454).abs() < 1e-8, "{nees:?}");
            assert_eq!((nees.samples, nees.singular, nees.outside, nees.left_out), (2, 2, outside, 0));
            assert_eq!(nees.accepted, outside == 0);
            let words = nees.in_words();
            assert!(words.contains("P is singular at 2 of 2 samples"), "{words}");
            assert_eq!(words.contains("an error has no variance at 2 of 2 samples"), outside > 0);
        }
        for filter in &results.filters {
            let nees = filter.nees.as_ref().unwrap();
            assert_eq!((nees.samples, nees.singular, nees.outside, nees.left_out), (4, 4, 2 * outside, 0), "{nees:?}");
        }
    }
}

/// With a covariance of zero there is no degree of freedom, and this is said.
#[test]
fn a_filter_without_variance_is_not_tested_in_silence() {
    let folder = bench("zero", "t,y,true\n0,1,1\n1,1,1\n2,1,1\n");
    let log = "[log]\nfile = \"log.csv\"\nstates = [\"true\"]\n";
    let results = run(&folder, &format!("{CONSTANT}{log}{}", filters("[1]", "0", "0")));
    for row in &results.log.unwrap().rows {
        let nees = row.nees.as_ref().unwrap();
        assert_eq!((nees.samples, nees.singular, nees.outside), (0, 2, 0));
        assert_eq!(nees.in_words(), "- (P is singular at 2 of 2 samples)");
    }
}

/// numpy: the filter with the points xhat and xhat +- sqrt(3 P), weights 2/3 and 1/6 (and 2/3 + 2 of the
/// centre in covariances), of the growth model. The innovations of the third and the fourth row are -0.26336211 and
/// -6.19697888, against the mean of h over the points;
/// against h(xhat) they would be others.
#[test]
fn the_innovation_of_an_unscented_filter_is_that_of_its_update() {
    let text = r#"[plant]
states = ["x"]
outputs = ["y"]
f = ["0.5*x + 25*x/(1 + x^2) + 8*cos(1.2*t)"]
h = ["x^2/20"]
dt = 1
[log]
file = "log.csv"
[[observer]]
kind = "ukf"
initial = [0]
p0 = 1
w = 10
v = 1
period = 1
kappa = 2
"#;
    let rows = ["2.0414191213851827", "0.716639589840931", "5.695194447716633", "-1.948016215083824"];
    let rows: Vec<String> = rows.iter().enumerate().map(|(t, y)| format!("{t},{y}\n")).collect();
    let results = run(&bench("growth", &format!("t,y\n{}", rows.concat())), text);
    let row = &results.log.unwrap().rows[0];
    let (output, nis) = (&row.outputs[0], row.nis.as_ref().unwrap());
    for (found, expected) in
        [(output.mean, -3.2301704965962252), (output.rms, 4.385881147017518), (nis.mean, 0.27113685162687007)]
    {
        assert!((found - expected).abs() < 1e-12, "{found}, expected {expected}");
    }
}

const OVERFLOW: &str = r#"[plant]
states = ["x"]
outputs = ["level", "overflow"]
f = ["0.1"]
h = ["x", "(x - 1)^1.5"]
[log]
file = "log.csv"
"#;

/// Of three integrators that are measured alike every direction is the least observable one, with one that is measured
/// five times as well two of them, and with two of these the third.
#[test]
fn directions_that_are_seen_alike_are_counted() {
    let words = |gains: [f64; 3]| {
        let [a, b, c] = gains;
        let text =
            format!("[plant]\na = [[0, 0, 0], [0, 0, 0], [0, 0, 0]]\nc = [[{a}, 0, 0], [0, {b}, 0], [0, 0, {c}]]\n");
        let results = studies::executed(&text, Step::Observe);
        results.observability.unwrap().points[0].modes[0].words.clone()
    };
    assert_eq!(words([1.0, 1.0, 1.0]), "every direction alike");
    assert_eq!(words([1.0, 1.0, 5.0]), "2 independent directions alike");
    assert_eq!(words([5.0, 1.0, 5.0]), "x2");
}

/// The linearisation at the first estimate leaves out an output without a derivative there, and says so.
#[test]
fn observability_leaves_out_what_has_no_derivative() {
    let folder = bench("no-derivative", "t,level,overflow\n0,0.5,\n1,0.62,\n9,1.41,0.26\n10,1.5,0.36\n");
    let filter = "[[observer]]\nkind = \"ukf\"\ninitial = [0.5]\nw = 0.001\nv = [0.001, 0.01]\nperiod = 1\n";
    let study = crate::studies::study_in(&folder, &format!("{OVERFLOW}{filter}"));
    let options = luenberger_study::RunOptions::default();
    let results = luenberger_study::execute(&study, luenberger_study::Step::Run, &options).unwrap();
    assert_eq!(results.observability.as_ref().unwrap().rank, 1);
    let said = "Observability at t = 0, x = [0.5]: overflow has no derivative there, and is left out.";
    assert!(results.warnings.iter().any(|warning| warning == said), "{:?}", results.warnings);
}

/// An output that was not measured need not be defined at the estimate of a filter. One that was measured is named,
/// with its row, and so is one that another observer predicts.
#[test]
fn an_undefined_output_matters_where_it_was_measured() {
    let one = |kind| {
        format!(
            "[[observer]]\nkind = \"{kind}\"\ninitial = [0.5]\np0 = 0.01\nw = 0.001\nv = [0.001, 0.01]\nperiod = 1\n"
        )
    };
    let observers: String = studies::filters().into_iter().map(one).collect();
    let folder = bench("undefined", "t,level,overflow\n0,0.5,\n1,0.62,\n2,0.71,\n3,0.83,\n");
    let results = run(&folder, &format!("{OVERFLOW}{observers}"));
    assert_eq!(results.failures(), Vec::<String>::new());
    for row in &results.log.as_ref().unwrap().rows {
        assert_eq!((row.outputs.len(), row.outputs[0].output.as_str()), (1, "level"));
    }
    // The same estimates as of the plant without that output.
    let alone = format!("{OVERFLOW}{observers}")
        .replace(", \"overflow\"]", "]")
        .replace(", \"(x - 1)^1.5\"]", "]")
        .replace("[0.001, 0.01]", "0.001");
    let alone = run(&folder, &alone);
    for (one, other) in results.runs.iter().zip(&alone.runs) {
        let apart = (one.estimate.as_ref().unwrap() - other.estimate.as_ref().unwrap()).amax();
        assert!(apart < 1e-12, "{}: {apart:e}", one.observer);
    }
    let folder = bench("measured", "t,level,overflow\n0,0.5,\n1,0.62,\n2,,0.1\n3,0.83,\n");
    for failure in run(&folder, &format!("{OVERFLOW}{observers}")).failures() {
        let expected = "stopped at t = 2 (row 3 of the log): overflow is NaN at the estimate of";
        assert!(failure.contains(expected) && failure.ends_with("which was measured there"), "{failure}");
    }
    let folder = bench("predicted", "t,level,overflow\n0,0.5,\n1,0.62,\n2,0.71,\n");
    let gain = "[[observer]]\nname = \"gain\"\nkind = \"luenberger\"\npoles = [-1]\n";
    let linear = "a = [[0]]\nc = [[1], [1]]\nstates = [\"x\"]\noutputs = [\"level\", \"overflow\"]\n";
    let found = run(&folder, &format!("[plant]\n{linear}[log]\nfile = \"log.csv\"\n{gain}"));
    assert_eq!(found.failures(), Vec::<String>::new());
}

/// The gains 2 and 50 with a row every second: by scipy.linalg.expm of the stacked equation with w, the matrix of the
/// error from row to row has the spectral radius 12.4.
#[test]
fn an_observer_that_is_too_fast_for_the_log_is_named() {
    let rows: Vec<String> = (0..60).map(|k| format!("{k},{}\n", (0.3 * f64::from(k)).sin())).collect();
    let folder = bench("fast", &format!("t,y\n{}", rows.concat()));
    let text = "[plant]\na = [[0, 1], [0, 0]]\nc = [[1, 0]]\noutputs = [\"y\"]\n[log]\nfile = \"log.csv\"\n[[observer]]\nname = \"fast\"\nkind = \"luenberger\"\npoles = [[-1, 7], [-1, -7]]\n";
    let warnings = run(&folder, text).warnings;
    assert!(
        warnings.iter().any(|warning| warning.starts_with("fast: the innovations of y (rms ")
            && warning.contains("are larger than its deviation from its mean (0.7")),
        "{warnings:?}"
    );
}

/// A cart at the speed 1, measured once a second: an observer that starts at the state stays there, because the
/// measurement moves with the model. Held, it is late.
#[test]
fn a_continuous_observer_is_not_late_on_a_log() {
    let folder = bench("late", "t,y,place,speed\n0,0,0,1\n1,1,1,1\n2,2,2,1\n3,3,3,1\n4,4,4,1\n");
    let text = |key: &str| {
        format!(
            "[plant]\na = [[0, 1], [0, 0]]\nc = [[1, 0]]\noutputs = [\"y\"]\n[log]\nfile = \"log.csv\"\nstates = [\"place\", \"speed\"]\n{key}[[observer]]\nkind = \"luenberger\"\npoles = [-2, -3]\ninitial = [0, 1]\n"
        )
    };
    let rmse = |key: &str| {
        let log = run(&folder, &text(key)).log.unwrap();
        (log.interpolation, log.rows[0].errors[1].rmse)
    };
    let (moving, held, line) = (rmse(""), rmse("interpolation = \"held\"\n"), rmse("interpolation = \"linear\"\n"));
    assert_eq!((moving.0, held.0, line.0), ("predicted", "held", "linear"));
    assert!(moving.1 < 1e-9 && line.1 < 1e-9 && held.1 > 0.1, "{moving:?} {held:?} {line:?}");
}
