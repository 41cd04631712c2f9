//! Autocovariance least squares beside the likelihood in `luenberger tune`.

use std::fmt::Write;
use std::path::Path;

use luenberger_random::Random;
use luenberger_study::tune::{TuneOptions, TuneReport, tune};

use crate::studies::{scratch, study_in};

#[track_caller]
fn tuned(folder: &Path, text: &str) -> TuneReport {
    tune(&study_in(folder, text), &TuneOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

const STUDY: &str = r#"
[plant]
states = ["x1", "x2"]
outputs = ["y1", "y2"]
a = [[0.9, 0.1], [0, 0.7]]
c = [[1, 0], [1, 1]]
dt = 1
[log]
file = "log.csv"
[[observer]]
name = "filter"
kind = "extended-kalman"
initial = [0, 0]
p0 = [1, 1]
w = [0.5, 0.2]
v = [1, 0.3]
period = 1
[tune]
observer = "filter"
parameters = ["w", "v"]
held_out = 0
starts = 1
profile = 0
"#;

/// x+ = A x + w, y = C x + v with W = diag(0.5, 0.2) and V = diag(1, 0.3).
fn log(rows: usize, mut noise: impl FnMut() -> [f64; 4]) -> String {
    let (mut text, mut x) = ("t,y1,y2\n".to_owned(), [0.0f64; 2]);
    for k in 0..rows {
        let [v1, v2, w1, w2] = noise();
        writeln!(text, "{k},{},{}", x[0] + v1, x[0] + x[1] + 0.3f64.sqrt() * v2).unwrap();
        x = [0.9 * x[0] + 0.1 * x[1] + 0.5f64.sqrt() * w1, 0.7 * x[1] + 0.2f64.sqrt() * w2];
    }
    text
}

/// The same record in numpy: the maximum of the likelihood by scipy's Nelder-Mead, and there the least squares by
/// `scipy.optimize.nnls` with model autocovariances by their series, and Bartlett's formula by loops.
#[test]
fn the_least_squares_are_those_of_numpy() {
    let folder = scratch("tune-autocovariances");
    // A generator of 31 bits, the same anywhere; uniform numbers of variance 1.
    let mut state = 1u64;
    let mut uniform = || {
        state = (state * 1_103_515_245 + 12345) % 2_147_483_648;
        12f64.sqrt() * (state as f64 / 2_147_483_648.0 - 0.5)
    };
    std::fs::write(folder.join("log.csv"), log(1200, || std::array::from_fn(|_| uniform()))).unwrap();
    let report = tuned(&folder, STUDY);
    assert!((report.log_likelihood + 3_696.829_384_8).abs() < 1e-5, "{}", report.log_likelihood);
    let expected = [
        ("w[x1]", 0.513_846, 0.526_798_62, 0.041_888_43),
        ("w[x2]", 0.177_577, 0.175_402_56, 0.037_874_94),
        ("v[y1]", 0.988_111, 0.962_511_52, 0.061_287_61),
        ("v[y2]", 0.342_306, 0.327_898_44, 0.045_621_39),
    ];
    for ((name, likely, value, error), (found, by)) in
        expected.into_iter().zip(report.parameters.iter().zip(&report.autocovariances))
    {
        assert_eq!((name, name), (found.name.as_str(), by.name.as_str()));
        assert!((found.after - likely).abs() < 2e-4 * likely, "{found:?}");
        // The optimum of the other search differs in the last digits, and so does the gain.
        assert!((by.value - value).abs() < 1e-4 * value, "{by:?} {value}");
        assert!((by.standard_error.unwrap() - error).abs() < 1e-3 * error, "{by:?} {error}");
    }
    assert!(report.text().contains("Cross-check by autocovariance least squares"), "{}", report.text());
    // It is the second start.
    let far = STUDY.replace("w = [0.5, 0.2]", "w = [5, 0.02]").replace("v = [1, 0.3]", "v = [0.1, 3]");
    let report = tuned(&folder, &far.replace("starts = 1", "starts = 2"));
    assert_eq!((report.starts, report.agreeing), (2, 2));
    assert!((report.log_likelihood + 3_696.829_384_8).abs() < 1e-3, "{}", report.log_likelihood);
}

/// Over simulated logs the errors are as large as the standard errors say: the sum of the squares of 4 x 16 errors in
/// units of their standard errors, correlated within a log, is near their number.
#[test]
fn the_standard_errors_are_those_of_simulated_logs() {
    let folder = scratch("tune-autocovariances-errors");
    let truth = [0.5, 0.2, 1.0, 0.3];
    let (mut sum, mut mean, mut count) = (0.0, [0.0; 4], 0.0);
    for seed in 0..16 {
        let mut random = Random(seed);
        let noise = || {
            let ([a, b], [c, d]) = (random.normal_pair(), random.normal_pair());
            [a, b, c, d]
        };
        std::fs::write(folder.join("log.csv"), log(800, noise)).unwrap();
        let report = tuned(&folder, STUDY);
        for (k, (by, truth)) in report.autocovariances.iter().zip(truth).enumerate() {
            let error = (by.value - truth) / by.standard_error.unwrap();
            sum += error * error;
            mean[k] += error / 16.0;
            count += 1.0;
        }
    }
    assert_eq!(count, 64.0);
    // A chi-squared with 64 degrees of freedom has the deviation 11, more where errors are correlated.
    assert!((30.0..110.0).contains(&sum), "{sum}");
    assert!(mean.iter().all(|mean| mean.abs() < 4.0 / 16f64.sqrt()), "{mean:?}");
}

/// In continuous time W is an intensity, and the least squares are those of the sampled plant.
#[test]
fn in_continuous_time_the_process_noise_is_that_of_a_period() {
    let folder = scratch("tune-autocovariances-continuous");
    let mut random = Random(3);
    let (mut text, mut x) = ("t,y\n".to_owned(), 0.0);
    let (h, w, v) = (0.2f64, 0.8, 0.1f64);
    // x' = -x + w: over a period x+ = e^-h x, with the variance W (1 - e^-2h)/2.
    let step = (w * (1.0 - (-2.0 * h).exp()) / 2.0).sqrt();
    for k in 0..4000 {
        let [a, b] = random.normal_pair();
        writeln!(text, "{},{}", h * f64::from(k), x + v.sqrt() * a).unwrap();
        x = (-h).exp() * x + step * b;
    }
    std::fs::write(folder.join("log.csv"), text).unwrap();
    let study = "[plant]\na = [[-1]]\nc = [[1]]\nstates = [\"x\"]\noutputs = [\"y\"]\n[log]\nfile = \"log.csv\"\n[[observer]]\nname = \"filter\"\nkind = \"extended-kalman\"\ninitial = [0]\np0 = [1]\nw = [0.3]\nv = [0.3]\nperiod = 0.2\n[tune]\nobserver = \"filter\"\nparameters = [\"w\", \"v\"]\nheld_out = 0\nstarts = 1\nprofile = 0\n";
    let report = tuned(&folder, study);
    for (by, truth) in report.autocovariances.iter().zip([w, v]) {
        let error = by.standard_error.unwrap();
        assert!((by.value - truth).abs() < 3.0 * error && error < 0.2 * truth, "{by:?} {truth}");
    }
    assert_eq!(report.autocovariances.len(), 2);
}

#[test]
fn where_the_method_does_not_apply_nothing_is_printed() {
    let folder = scratch("tune-autocovariances-none");
    let mut random = Random(1);
    let noise = || {
        let ([a, b], [c, d]) = (random.normal_pair(), random.normal_pair());
        [a, b, c, d]
    };
    let whole = log(400, noise);
    std::fs::write(folder.join("log.csv"), &whole).unwrap();
    let applies = |text: &str| {
        let report = tuned(&folder, text);
        assert_eq!(report.text().contains("Cross-check"), !report.autocovariances.is_empty());
        !report.autocovariances.is_empty()
    };
    assert!(applies(STUDY));
    // Correlated noises are not linear in their variances.
    assert!(!applies(&STUDY.replace("w = [0.5, 0.2]", "w = [[0.5, 0.1], [0.1, 0.2]]")));
    // A nonlinear plant.
    let nonlinear = "f = [\"0.9*x1 + 0.1*sin(x2)\", \"0.7*x2\"]\nh = [\"x1\", \"x1 + x2\"]";
    assert!(!applies(&STUDY.replace("a = [[0.9, 0.1], [0, 0.7]]\nc = [[1, 0], [1, 1]]", nonlinear)));
    // A value that is missing.
    let (mut missing, at) = (whole.clone(), whole.find("\n200,").unwrap());
    let end = at + 1 + whole[at + 1..].find('\n').unwrap();
    missing.replace_range(at..end, "\n200,,0.1");
    std::fs::write(folder.join("log.csv"), missing).unwrap();
    assert!(!applies(STUDY));
}
