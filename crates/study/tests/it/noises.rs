//! Noises of filters that are not constant, noise that enters through a matrix, and bounds of estimates.

use std::fmt::Write as _;
use std::path::Path;

use luenberger_random::Random;
use luenberger_study::deployment::{ExportOptions, program};
use luenberger_study::tune::{TuneOptions, tune};
use luenberger_study::{Results, RunOptions, Step, execute};
use nalgebra::DMatrix;

use crate::studies::{executed, mistakes, mistakes_of, read, scratch, study, study_in};

/// The kinds whose noises may be expressions.
const KINDS: [&str; 3] = ["extended-kalman", "iterated-extended-kalman", "ukf"];

fn on_log(folder: &Path, text: &str) -> Results {
    let results = execute(&study_in(folder, text), Step::Run, &RunOptions::default());
    let results = results.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(results.failures(), Vec::<String>::new());
    results
}

/// The estimates and standard deviations of each observer.
fn estimates(results: &Results) -> Vec<(String, DMatrix<f64>, DMatrix<f64>)> {
    let of = |run: &luenberger_study::results::ObserverRun| {
        (run.observer.clone(), run.estimate.clone().unwrap(), run.deviation.clone().unwrap())
    };
    results.runs.iter().map(of).collect()
}

fn observers(kinds: &[&str], keys: &str) -> String {
    kinds.iter().fold(String::new(), |mut text, kind| {
        _ = write!(text, "[[observer]]\nkind = \"{kind}\"\n{keys}\n");
        text
    })
}

/// A constant, measured with variances of its own in every row: the estimate is the weighted mean
/// `(x0/p0 + sum y/v)/(1/p0 + sum 1/v)`, whether v is an expression of t, of an input, or a column of the log.
#[test]
fn a_constant_is_its_weighted_mean() {
    let folder = scratch("noises/weighted");
    let mut random = Random(8);
    let (mut csv, mut sums, mut with_gaps) =
        ("t,u,sigma,y\n".to_owned(), vec![(2.0 / 4.0, 1.0 / 4.0)], vec![(0.5, 0.25)]);
    for k in 0..30 {
        let (t, u) = (0.5 * f64::from(k), 1.0 + 0.4 * f64::from(k % 4));
        let (variance, y) = (0.01 + 0.1 * t + u * u, 1.2 + random.normal_pair()[0]);
        let (mean, weight) = *sums.last().unwrap();
        sums.push((mean + y / variance, weight + 1.0 / variance));
        // Without a variance in the row it is that of the observer.
        let has_variance = k % 5 != 2;
        let own = if has_variance { variance } else { 9.0 };
        let (mean, weight) = *with_gaps.last().unwrap();
        with_gaps.push((mean + y / own, weight + 1.0 / own));
        let sigma = if has_variance { variance.sqrt().to_string() } else { String::new() };
        _ = writeln!(csv, "{t},{u},{sigma},{y}");
    }
    std::fs::write(folder.join("log.csv"), csv).unwrap();
    let text = |log: &str, v: &str| {
        format!(
            "[plant]\ninputs = [\"u\"]\noutputs = [\"y\"]\nf = [\"0\"]\nh = [\"x1\"]\nparameters = {{ slope = 0.1 }}\n[log]\nfile = \"log.csv\"\n{log}{}",
            observers(&KINDS, &format!("initial = [2]\np0 = 4\nw = 0\nv = {v}\nperiod = 0.5"))
        )
    };
    let check = |text: &str, sums: &[(f64, f64)]| {
        let found = estimates(&on_log(&folder, text));
        assert_eq!(found.len(), KINDS.len());
        for (name, estimate, deviation) in found {
            for (k, (mean, weight)) in sums[1..].iter().enumerate() {
                let (expected, own) = (mean / weight, weight.sqrt().recip());
                assert!(
                    (estimate[(k, 0)] - expected).abs() < 1e-13,
                    "{name}, row {k}: {} {expected}",
                    estimate[(k, 0)]
                );
                assert!((deviation[(k, 0)] - own).abs() < 1e-13, "{name}, row {k}: {} {own}", deviation[(k, 0)]);
            }
        }
    };
    check(&text("", "[\"0.01 + slope*t + u^2\"]"), &sums);
    check(&text("variances = [\"sigma^2\"]\n", "9"), &with_gaps);
    // mhe has one V in its window, and says so.
    let mhe = text("variances = [\"sigma^2\"]\n", "9")
        + "[[observer]]\nkind = \"mhe\"\ninitial = [2]\np0 = 4\nw = 0\nv = 9\nperiod = 0.5\n";
    let warnings = on_log(&folder, &mhe).warnings;
    let said: Vec<&String> = warnings.iter().filter(|warning| warning.contains("`variances`")).collect();
    assert_eq!(said.len(), 1, "{warnings:?}");
    assert!(said[0].starts_with("mhe has its own V in all rows"), "{}", said[0]);
    // What is no variance is said where the log is read.
    let zero = text("variances = [\"sigma^2 - sigma^2\"]\n", "9");
    let read = luenberger_study::Study::from_text("study.toml", &zero, luenberger_study::Format::Toml, &folder);
    assert_eq!(mistakes_of(&zero, read)[0].message, "the variance of y is 0 at t = 0");
    // The likelihood of rows with the variance of the observer is that of the observer.
    let tuned = |log: &str, v: &str| {
        let text = text(log, v).replace("w = 0\n", "w = 0.01\n")
            + "[tune]\nobserver = \"extended-kalman\"\nparameters = [\"bias[y]\"]\nstarts = 1\nprofile = 0\nheld_out = 0\n";
        tune(&study_in(&folder, &text), &TuneOptions::default()).unwrap_or_else(|error| panic!("{error}"))
    };
    let (constant, by_rows) = (tuned("", "9"), tuned("variances = [\"9 + 0*t\"]\n", "4"));
    assert_eq!(constant.log_likelihood_before.to_bits(), by_rows.log_likelihood_before.to_bits());
    assert_ne!(constant.log_likelihood_before.to_bits(), tuned("", "4").log_likelihood_before.to_bits());
    // An expression is no number that is fitted.
    let wrong = text("", "[\"0.01 + t\"]") + "[tune]\nobserver = \"ukf\"\nparameters = [\"v\"]\n";
    let read = luenberger_study::Study::from_text("study.toml", &wrong, luenberger_study::Format::Toml, &folder);
    assert_eq!(mistakes_of(&wrong, read)[0].message, "`parameters` has \"v\", which cannot be fitted");
}

/// A pendulum in a simulation.
fn pendulum(keys: &str) -> String {
    format!(
        "[plant]\nf = [\"x2\", \"-sin(x1) - 0.1*x2\"]\nh = [\"x1\"]\n[simulation]\nx0 = [1, 0]\nduration = 10\nnoise = {{ amplitude = [0.1], period = 0.1, seed = 2 }}\n{}",
        observers(&KINDS, &format!("{keys}\np0 = [1, 1]\nperiod = 0.1"))
    )
}

fn merits(results: &Results) -> String {
    let rows = &results.simulation.as_ref().unwrap().rows;
    let all: Vec<_> = rows.iter().map(|row| serde_json::to_string(&row.merits).unwrap()).collect();
    all.join("\n") + &serde_json::to_string(&results.filters).unwrap()
}

/// Expressions that are constant have the bits of numbers, and G those of `G W G'`.
#[test]
fn constant_expressions_are_numbers() {
    let numbers = executed(&pendulum("w = [[0.25, 0.5], [0.5, 1]]\nv = 0.01"), Step::Simulate);
    for keys in [
        "w = [1]\ng = [[0.5], [1]]\nv = 0.01",
        "w = [\"1 + 0*x1\"]\ng = [[0.5], [1]]\nv = [\"0.01 + 0*x2\"]",
        "w = 1\ng = [[\"0.5*cos(0*t)\"], [1]]\nv = [\"0.01\"]",
    ] {
        let found = executed(&pendulum(keys), Step::Simulate);
        assert!(merits(&found) == merits(&numbers), "{keys}\n{}\n{}", merits(&found), merits(&numbers));
    }
    // What an expression is shows in the design, and a constant in its matrices.
    let found = executed(&pendulum("w = [\"1 + x1^2\"]\ng = [[0.5], [1]]\nv = 0.01"), Step::Simulate);
    let design = found.observers[0].design.as_ref().unwrap();
    let words = design.statement.to_string();
    assert!(words.contains("by w = [1 + x1^2] and g = [0.5, 1.0], W = g w g'"), "{words}");
    assert_eq!(design.matrices.iter().map(|matrix| matrix.name.as_str()).collect::<Vec<_>>(), ["V", "P(0)"]);
    assert!(merits(&found) != merits(&numbers));
}

/// `P+ = F P F' + G q G'` with G and q at the estimate: a step of known direction and length.
#[test]
fn noise_enters_in_the_direction_of_the_estimate() {
    let folder = scratch("noises/entering");
    std::fs::write(folder.join("log.csv"), "t,y\n0,0\n1,0\n2,0\n").unwrap();
    let text = format!(
        "[plant]\nstates = [\"heading\", \"x\", \"y\"]\nf = [\"heading\", \"x\", \"y\"]\nh = [\"x\"]\noutputs = [\"y1\"]\ndt = 1\n[log]\nfile = \"log.csv\"\noutputs = [\"y\"]\n{}",
        observers(
            &KINDS,
            "initial = [0.7, 3, 0]\np0 = 0\nw = [\"0.04*x\"]\ng = [[0], [\"cos(heading)\"], [\"sin(heading)\"]]\nv = 1e12\nperiod = 1"
        )
    );
    for (name, _, deviation) in estimates(&on_log(&folder, &text)) {
        for (k, steps) in [0.0f64, 1.0, 2.0].into_iter().enumerate() {
            let length = (steps * 0.04 * 3.0).sqrt();
            let expected = [0.0, length * 0.7f64.cos(), length * 0.7f64.sin()];
            for (i, expected) in expected.into_iter().enumerate() {
                assert!((deviation[(k, i)] - expected).abs() < 1e-9, "{name}: {deviation} {expected}");
            }
        }
    }
}

/// The first estimate within bounds is that of `mhe`, which solves the bounded least-squares problem by an
/// interior-point method: for a linear plant both are the same problem. And no estimate leaves the bounds.
#[test]
fn bounded_filters_begin_as_the_bounded_least_squares_problem() {
    let folder = scratch("noises/bounds");
    let mut csv = "t,u,y\n".to_owned();
    for k in 0..60 {
        _ = writeln!(csv, "{},{},{}", 0.1 * f64::from(k), (0.3 * f64::from(k)).sin(), 4.0 * (0.2 * f64::from(k)).cos());
    }
    std::fs::write(folder.join("log.csv"), csv).unwrap();
    let bounds = "[[-1, 1], [-inf, 0.3], [-0.2, inf]]";
    let text = |bounds: &str, kinds: &[&str]| {
        format!(
            "[plant]\nstates = [\"a\", \"b\", \"c\"]\ninputs = [\"u\"]\noutputs = [\"y\"]\nf = [\"b\", \"u - c\", \"-c\"]\nh = [\"a\"]\n[log]\nfile = \"log.csv\"\n{}",
            observers(
                kinds,
                &format!(
                    "initial = [0, 0, 0]\np0 = [[1, 0.6, -0.5], [0.6, 1, 0.2], [-0.5, 0.2, 2]]\nw = [0.1, 1, 0.1]\nv = 0.5\nperiod = 0.1\nstate_bounds = {bounds}"
                )
            )
        )
    };
    let all = ["extended-kalman", "iterated-extended-kalman", "ukf", "mhe"];
    let found = estimates(&on_log(&folder, &text(bounds, &all)));
    let (_, least, _) = found.last().unwrap();
    for (name, estimate, _) in &found {
        let off = (estimate.row(0) - least.row(0)).norm();
        assert!(off < 1e-6, "{name}: {off} from {}", least.row(0));
        for k in 0..estimate.nrows() {
            let x = estimate.row(k);
            let slack = if name == "mhe" { 1e-6 } else { 0.0 };
            assert!(x[0].abs() <= 1.0 + slack && x[1] <= 0.3 + slack && x[2] >= -0.2 - slack, "{name}, row {k}: {x}");
        }
    }
    // All three are active somewhere, and without them the estimates leave them.
    let free = estimates(&on_log(&folder, &text("[[-inf, inf], [-inf, inf], [-inf, inf]]", &KINDS)));
    assert!(free.iter().all(|(_, estimate, _)| estimate.column(0).amax() > 2.0));
    assert!(found[0].1.column(1).max() == 0.3 && found[0].1.column(2).min() == -0.2);
    // Bounds of parameters that are estimated are bounds of states.
    let parameters =
        text("[[-1, 1], [-inf, 0.3], [-0.2, inf]]", &all).replace("u - c\", \"-c\"", "gain*u - c\", \"-c\"").replace(
            "[log]",
            "parameters = { gain = 0.9 }\n[estimate]\nparameters = [\"gain\"]\np0 = [4]\nbounds = [[0.5, 1]]\n[log]",
        );
    for (name, estimate, _) in estimates(&on_log(&folder, &parameters)) {
        let gain = estimate.column(3);
        assert!(gain.min() >= 0.5 - 1e-6 && gain.max() <= 1.0 + 1e-6 && gain.amax() > gain.min(), "{name}: {gain}");
    }
}

/// An export has constant noises and no bounds, and says so.
#[test]
fn exports_say_what_they_do_not_have() {
    for (keys, said) in [
        (
            "w = 1\nv = [\"0.01 + x1^2\"]",
            "the exported step of extended-kalman has no noises that are expressions of the estimate",
        ),
        (
            "w = 1\nv = 1\nstate_bounds = [[-1, 1], [-1, 1]]",
            "the exported step of extended-kalman has no bounds of its estimates",
        ),
    ] {
        let text = pendulum(keys);
        let refusal = program(&study(&text), Some("extended-kalman"), &ExportOptions::default(), None).unwrap_err();
        assert!(refusal.to_string().contains(said), "{refusal}");
    }
    // What enters through a matrix of numbers is a constant W.
    let text = pendulum("w = [1]\ng = [[0.5], [1]]\nv = 0.01");
    assert!(program(&study(&text), Some("ukf"), &ExportOptions::default(), None).is_ok());
}

#[test]
fn mistakes_of_noises_are_named() {
    let said = |keys: &str| {
        let text = format!("[plant]\nf = [\"x2\", \"0\"]\nh = [\"x1\"]\n[[observer]]\nperiod = 1\n{keys}\n");
        mistakes(&text).iter().map(|mistake| mistake.message.clone()).collect::<Vec<_>>().join("; ")
    };
    let ekf = |keys: &str| said(&format!("kind = \"extended-kalman\"\n{keys}"));
    assert_eq!(ekf("w = 1\nv = [\"x1\", \"x2\"]"), "`v` has 2 expressions, and the plant has 1 output");
    assert_eq!(ekf("w = [1, 2, 3]\ng = [[1, 0], [0, 1]]\nv = 1"), "the diagonal `w` has length 3");
    assert_eq!(ekf("w = 1\ng = [[1]]\nv = 1"), "`g` is 1 x 1, and the plant has 2 states");
    let name = ekf("w = 1\nv = [\"x1 + q\"]");
    assert!(name.contains('q'), "{name}");
    assert_eq!(
        said("kind = \"mhe\"\nw = 1\nv = [\"x1\"]"),
        "`v` has expressions, and the kind mhe has the same noises in all of its window"
    );
    assert_eq!(ekf("w = 1\nv = 1\nstate_bounds = [[1, 0], [0, 1]]"), "pair 1 of `state_bounds` goes from 1 to 0");
    let estimated = "[plant]\nf = [\"q*x1\"]\nh = [\"x1\"]\nparameters = { q = 2 }\n[estimate]\nparameters = [\"q\"]\np0 = [1]\nbounds = [[0, 1]]\n";
    assert_eq!(mistakes(estimated)[0].message, "the bounds of q do not enclose its value");
    assert!(read(&estimated.replace("[[0, 1]]", "[[0, inf]]")).is_ok());
}
