//! `s` of filters: process and measurement noise that are correlated.

use std::fmt::Write as _;
use std::path::Path;

use luenberger_random::Random;
use luenberger_study::deployment::{ExportOptions, program};
use luenberger_study::tune::{TuneOptions, tune};
use luenberger_study::{Results, RunOptions, Step, execute};
use nalgebra::{DMatrix, DVector};

use crate::studies::{executed, mistakes, scratch, study, study_in};

/// The kinds that have `s`.
const KINDS: [&str; 3] = ["extended-kalman", "iterated-extended-kalman", "ukf"];

fn observers(kinds: &[&str], keys: &str) -> String {
    kinds.iter().fold(String::new(), |mut text, kind| {
        _ = write!(text, "[[observer]]\nkind = \"{kind}\"\n{keys}\n");
        text
    })
}

fn on_log(folder: &Path, text: &str) -> Results {
    let options = RunOptions { output: Some(folder.join("out").into()), ..RunOptions::default() };
    let results = execute(&study_in(folder, text), Step::Run, &options).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(results.failures(), Vec::<String>::new());
    results
}

const LINEAR: &str = "[plant]\na = [[0.9, 0.2], [0, 0.7]]\nb = [[0], [1]]\nc = [[1, 0]]\ndt = 1\n";

/// In the steady state the estimates are those of `kalman` with the same `s`, and the standard deviations those of
/// `scipy.linalg.solve_discrete_are(A', C', G W G', V, s = G S)`, scipy 1.17.1, after the measurement.
#[test]
fn of_a_linear_plant_they_become_the_stationary_filter() {
    let keys = "w = [0.04]\ng = [[0.5], [1]]\nv = 0.09\ns = [[0.05]]\n";
    let text = format!(
        "{LINEAR}[input]\nexpressions = [\"sin(t)\"]\n[simulation]\nx0 = [1, 0]\nduration = 200\nsamples = 201\nnoise = {{ amplitude = [0.3], period = 1, seed = 4 }}\n[truth]\nprocess_noise = {{ amplitude = [0.1, 0.2], period = 1, seed = 3 }}\n{}{}",
        observers(&KINDS, &format!("{keys}p0 = 1\nperiod = 1")),
        observers(&["kalman"], &format!("{keys}form = \"filter\"")),
    );
    let results = executed(&text, Step::Simulate);
    let run = |kind: &str| results.runs.iter().find(|run| run.observer == kind).unwrap();
    let of_kalman = run("kalman").estimate.clone().unwrap();
    let (last, expected) = (of_kalman.nrows() - 1, [0.088_418_818_605_116_86, 0.127_187_897_445_236_45]);
    for kind in KINDS {
        let (estimate, own) = (run(kind).estimate.as_ref().unwrap(), run(kind).deviation.as_ref().unwrap());
        for k in last - 20..=last {
            let off = (estimate.row(k) - of_kalman.row(k)).norm();
            assert!(off < 1e-12, "{kind}, row {k}: {off}");
            for i in 0..2 {
                assert!((own[(k, i)] / expected[i] - 1.0).abs() < 1e-11, "{kind}: {} {}", own[(k, i)], expected[i]);
            }
        }
        let design = results.observers.iter().find(|one| one.name == kind).unwrap().design.as_ref().unwrap();
        assert!(design.statement.to_string().contains("have the cross-covariance S"), "{}", design.statement);
        let s = design.matrices.iter().find(|matrix| matrix.name == "S").unwrap();
        assert_eq!(s.rows, [[0.5 * 0.05], [0.05]]);
    }
    // Without S the deviation of the first state is twice as large.
    let without = executed(&text.replace("s = [[0.05]]\n", ""), Step::Simulate);
    let own = without.runs[0].deviation.as_ref().unwrap();
    assert!((own[(last, 0)] - 0.176_951_62).abs() < 1e-8, "{own}");
}

/// A log of a plant with noises of the correlation 0.8 and the deviations 0.3 and 0.4: w follows v.
fn log_of(next: impl Fn(f64) -> f64, output: impl Fn(f64) -> f64, rows: usize) -> (String, Vec<[f64; 2]>) {
    let mut random = Random(12);
    let (mut csv, mut x, mut all) = ("t,x,y\n".to_owned(), 0.5, Vec::new());
    for k in 0..rows {
        let [first, second] = random.normal_pair();
        let (v, w) = (0.4 * first, 0.3 * (0.8 * first + 0.6 * second));
        let y = output(x) + v;
        _ = writeln!(csv, "{k},{x},{y}");
        all.push([x, y]);
        x = next(x) + w;
    }
    (csv, all)
}

const NOISES: &str = "initial = [0.5]\np0 = 0.01\nw = 0.09\nv = 0.16\nperiod = 1\n";

/// On a log of a nonlinear plant whose noises are correlated the filter that knows it is consistent and more accurate.
#[test]
fn a_filter_that_knows_the_correlation_is_consistent() {
    let folder = scratch("correlated/nonlinear");
    let (csv, _) = log_of(|x| 0.8 * x + 0.5 * x.sin(), |x| x + 0.02 * x.powi(3), 4000);
    std::fs::write(folder.join("log.csv"), csv).unwrap();
    let text = |s: &str| {
        format!(
            "[plant]\nstates = [\"x\"]\noutputs = [\"y\"]\nf = [\"0.8*x + 0.5*sin(x)\"]\nh = [\"x + 0.02*x^3\"]\ndt = 1\n[log]\nfile = \"log.csv\"\nstates = [\"x\"]\n{}",
            observers(&KINDS, &format!("{NOISES}{s}smooth = true"))
        )
    };
    let (with, without) = (on_log(&folder, &text("s = [[0.096]]\n")), on_log(&folder, &text("")));
    for (own, other) in with.log.as_ref().unwrap().rows.iter().zip(&without.log.as_ref().unwrap().rows) {
        let (nis, nees) = (own.nis.as_ref().unwrap(), own.nees.as_ref().unwrap());
        assert!(nis.accepted && (nees.mean / nees.expected - 1.0).abs() < 0.1, "{own:?}");
        let smoothed = own.smoothed.as_ref().unwrap().nees.as_ref().unwrap();
        assert!((smoothed.mean / smoothed.expected - 1.0).abs() < 0.1, "{smoothed:?}");
        assert!(
            !other.nis.as_ref().unwrap().accepted && own.errors[0].rmse < 0.85 * other.errors[0].rmse,
            "{own:?} {other:?}"
        );
    }
}

/// Smoothed estimates of a linear plant are the least-squares solution for all noises with their joint covariance, and
/// the likelihood is that of the recursion of the predictor.
#[test]
fn smoothed_estimates_are_least_squares_and_the_likelihood_is_of_the_predictor() {
    let folder = scratch("correlated/smoothed");
    let rows = 40;
    let (csv, all) = log_of(|x| 0.9 * x, |x| x, rows);
    std::fs::write(folder.join("log.csv"), csv).unwrap();
    let text = format!(
        "[plant]\nstates = [\"x\"]\noutputs = [\"y\"]\nf = [\"0.9*x\"]\nh = [\"x\"]\ndt = 1\n[log]\nfile = \"log.csv\"\n{}",
        observers(&KINDS, &format!("{NOISES}s = [[0.096]]\nsmooth = true"))
    );
    // Unknown x_0 .. x_(N-1); residuals x_0 - 0.5, and of each row (x_(k+1) - 0.9 x_k, y_k - x_k), of the last one y
    // alone.
    let (mut design, mut right, mut weight) =
        (DMatrix::zeros(2 * rows, rows), DVector::zeros(2 * rows), DMatrix::zeros(2 * rows, 2 * rows));
    (design[(0, 0)], right[0], weight[(0, 0)]) = (1.0, 0.5, 1.0 / 0.01);
    let joint = DMatrix::from_row_slice(2, 2, &[0.09, 0.096, 0.096, 0.16]).try_inverse().unwrap();
    for k in 0..rows - 1 {
        let at = 1 + 2 * k;
        (design[(at, k + 1)], design[(at, k)]) = (1.0, -0.9);
        // v = y - x.
        (design[(at + 1, k)], right[at + 1]) = (-1.0, -all[k][1]);
        weight.view_mut((at, at), (2, 2)).copy_from(&joint);
    }
    (design[(2 * rows - 1, rows - 1)], right[2 * rows - 1], weight[(2 * rows - 1, 2 * rows - 1)]) =
        (-1.0, -all[rows - 1][1], 1.0 / 0.16);
    let normal = design.transpose() * &weight * &design;
    let solution = normal.lu().solve(&(design.transpose() * weight * right)).unwrap();
    on_log(&folder, &text);
    for kind in KINDS {
        let table = std::fs::read_to_string(folder.join(format!("out/trajectories/log-{kind}.csv"))).unwrap();
        let mut lines = table.lines();
        let column = lines.next().unwrap().split(',').position(|name| name == "x_smoothed").unwrap();
        for (k, line) in lines.enumerate() {
            let smoothed: f64 = line.split(',').nth(column).unwrap().parse().unwrap();
            assert!((smoothed - solution[k]).abs() < 1e-9, "{kind}, row {k}: {smoothed} {}", solution[k]);
        }
    }
    // The predictor by hand.
    let (mut x, mut p, mut sum) = (0.5, 0.01, 0.0);
    for [_, y] in &all {
        let (innovation, r) = (y - x, p + 0.16);
        sum -= 0.5 * ((std::f64::consts::TAU * r).ln() + innovation * innovation / r);
        let k = (0.9 * p + 0.096) / r;
        (x, p) = (0.9 * x + k * innovation, 0.81 * p + 0.09 - k * k * r);
    }
    for kind in KINDS {
        let text = text.replace("smooth = true", "")
            + &format!("[tune]\nobserver = \"{kind}\"\nparameters = [\"v\"]\nstarts = 1\nprofile = 0\nheld_out = 0\n");
        let found = tune(&study_in(&folder, &text), &TuneOptions::default()).unwrap_or_else(|error| panic!("{error}"));
        assert!((found.log_likelihood_before - sum).abs() < 1e-9, "{kind}: {} {sum}", found.log_likelihood_before);
        // What does not fit S is no candidate.
        assert!(found.parameters[0].after >= 0.096 * 0.096 / 0.09, "{:?}", found.parameters[0]);
    }
}

/// A coloured noise is independent of the measurement, and its state has no part of S.
#[test]
fn states_of_estimated_parameters_have_no_cross_covariance() {
    let plant = "[plant]\nstates = [\"x\"]\noutputs = [\"y\"]\nf = [\"0.9*x + n\"]\nh = [\"x\"]\nparameters = { n = 0 }\ndt = 1\n[estimate.noises]\nn = { tau = 4, deviation = 0.2 }\n[simulation]\nx0 = [1]\nduration = 30\nnoise = { amplitude = [0.4], period = 1, seed = 4 }\n";
    let results = executed(&format!("{plant}{}", observers(&KINDS, &format!("{NOISES}s = [[0.05]]"))), Step::Simulate);
    for observer in &results.observers {
        let s = observer.design.as_ref().unwrap().matrices.iter().find(|matrix| matrix.name == "S").unwrap();
        assert_eq!(s.rows, [[0.05], [0.0]]);
    }
    assert_eq!(results.failures(), Vec::<String>::new());
}

#[test]
fn what_has_no_cross_covariance_is_refused_by_name() {
    let said = |plant: &str, keys: &str| {
        let text = format!("{plant}[[observer]]\nperiod = 1\n{keys}\n");
        mistakes(&text).iter().map(|mistake| mistake.message.clone()).collect::<Vec<_>>().join("; ")
    };
    let ekf = |keys: &str| said(LINEAR, &format!("kind = \"extended-kalman\"\n{keys}"));
    let unfit = ekf("w = [0.04, 1]\nv = 0.09\ns = [[0.0601], [0]]");
    assert!(
        unfit.starts_with("`s` does not fit `w` and `v`: [W S; S' V] is not a covariance: pivot -3.34e-3"),
        "{unfit}"
    );
    let at = mistakes(&format!("{LINEAR}[[observer]]\nkind = \"ukf\"\nw = 0\nv = 1\nperiod = 1\ns = [[0], [1e-9]]\n"));
    assert_eq!((at[0].line, at.len()), (11, 1), "{at:?}");
    assert_eq!(ekf("w = 1\nv = 1\ns = [[0.1]]"), "`s` is 1 x 1");
    assert_eq!(ekf("w = 1\nv = 1\ns = [[nan], [0]]"), "entry (1, 1) of `s` is NaN");
    assert_eq!(ekf("w = [\"x1\", 1]\nv = 1\ns = [[0], [0]]"), "`s` with expressions in `w`: S has to fit W and V");
    let continuous = said(&LINEAR.replace("dt = 1\n", ""), "kind = \"ukf\"\nw = 1\nv = 1\ns = [[0], [0]]");
    assert!(continuous.starts_with("`s` in continuous time: the noise of a sample has no covariance"), "{continuous}");
    let late = said(&format!("{LINEAR}delays = {{ y1 = 1 }}\n"), "kind = \"ukf\"\nw = 1\nv = 1\ns = [[0], [0]]");
    assert_eq!(late, "`s` with outputs that are measured late (`delays` of [plant])");
    for kind in ["mhe", "particle"] {
        let keys = format!("kind = \"{kind}\"\nw = 1\nv = 1\ns = [[0], [0]]");
        let refused = mistakes(&format!("{LINEAR}[[observer]]\nperiod = 1\n{keys}\n")).swap_remove(0);
        assert_eq!(refused.message, format!("`s` is not a key of [[observer]] of the kind {kind}"));
    }
    let text = format!("{LINEAR}{}", observers(&["ukf"], "w = 1\nv = 1\nperiod = 1\ns = [[0.5], [0]]"));
    let refusal = program(&study(&text), Some("ukf"), &ExportOptions::default(), None).unwrap_err();
    assert!(
        refusal.to_string().contains("the exported step of ukf has no cross-covariance of the noises"),
        "{refusal}"
    );
}
