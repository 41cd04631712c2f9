//! `luenberger tune` of observers without a covariance: their gains, poles and rates by prediction errors or errors.

use std::fmt::Write;
use std::path::Path;

use luenberger_random::Random;
use luenberger_study::execute::LogError;
use luenberger_study::tune::{TuneError, TuneOptions, TuneReport, TunedParameter, tune};
use luenberger_study::{Format, Study, StudyError};
use nalgebra::{Matrix2, Vector2};

use crate::studies::{mistakes_of, scratch, study_in};

#[track_caller]
fn tuned(folder: &Path, text: &str) -> TuneReport {
    tune(&study_in(folder, text), &TuneOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
fn refused(folder: &Path, text: &str) -> StudyError {
    tune(&study_in(folder, text), &TuneOptions::default()).unwrap_err()
}

#[track_caller]
fn mistake(folder: &Path, text: &str) -> String {
    let read = Study::from_text("study.toml", text, Format::Toml, folder);
    let found = &mistakes_of(text, read)[0];
    format!("{} | {} | {}", found.message, found.expected, found.help.clone().unwrap_or_default())
}

#[track_caller]
fn parameter<'a>(report: &'a TuneReport, name: &str) -> &'a TunedParameter {
    report.parameters.iter().find(|one| one.name == name).unwrap_or_else(|| panic!("{name} in {report:?}"))
}

/// x1+ = x1 + 0.1 x2 + w1, x2+ = 0.95 x2 + 0.1 u + w2, y = x1 + v, with W = diag(1e-4, 1e-2) and V = 0.04.
fn two_states(rows: usize, seed: u64) -> Vec<[f64; 4]> {
    let (mut random, mut x) = (Random(seed), [0.0; 2]);
    (0..rows)
        .map(|k| {
            let ([w1, w2], [v, _]) = (random.normal_pair(), random.normal_pair());
            let u = (0.07 * k as f64).sin();
            let row = [u, x[0] + 0.2 * v, x[0], x[1]];
            x = [x[0] + 0.1 * x[1] + 0.01 * w1, 0.95 * x[1] + 0.1 * u + 0.1 * w2];
            row
        })
        .collect()
}

fn write_log(folder: &Path, rows: &[[f64; 4]]) {
    let mut log = "t,u,y,x1,x2\n".to_owned();
    for (k, [u, y, x1, x2]) in rows.iter().enumerate() {
        writeln!(log, "{},{u},{y},{x1},{x2}", 0.1 * k as f64).unwrap();
    }
    std::fs::write(folder.join("log.csv"), log).unwrap();
}

fn of_two_states(log: &str, observer: &str, tune: &str) -> String {
    format!(
        "[plant]\nstates = [\"x1\", \"x2\"]\ninputs = [\"u\"]\noutputs = [\"y\"]\na = [[1, 0.1], [0, 0.95]]\nb = [[0], [0.1]]\nc = [[1, 0]]\ndt = 0.1\n[log]\nfile = \"log.csv\"\n{log}\n[[observer]]\nname = \"observer\"\ninitial = [0, 0]\n{observer}\n[tune]\nobserver = \"observer\"\n{tune}\n"
    )
}

/// The stationary gain of the predicting filter, A P C'/(C P C' + V), by scipy 1.x `solve_discrete_are(A', C', W, V)`,
/// and the eigenvalues 0.838020 +- 0.131657i of A - L C.
const KALMAN: [f64; 2] = [0.273_960_505_231_157_9, 0.298_731_412_028_518_44];

/// Squares of the innovations of a Luenberger observer with this gain, by hand.
fn squares(rows: &[[f64; 4]], l: [f64; 2]) -> f64 {
    let a = Matrix2::new(1.0, 0.1, 0.0, 0.95);
    let (mut x, mut sum) = (Vector2::zeros(), 0.0);
    for [u, y, ..] in rows {
        let nu: f64 = y - x[0];
        sum += nu * nu;
        x = a * x + Vector2::new(0.0, 0.1 * u) + Vector2::from(l) * nu;
    }
    sum
}

/// Prediction errors are the least at the gain of the Kalman filter (Ljung 1999, section 8.4): the fitted gain is there
/// within its standard errors, at the minimum of a recursion by hand, and its poles are those of the other fit.
#[test]
fn the_gain_of_least_prediction_errors_is_that_of_the_kalman_filter() {
    let folder = scratch("tune-gain");
    let rows = two_states(3000, 4);
    write_log(&folder, &rows);
    let given = "kind = \"luenberger\"\ngain = [[0.6], [0.1]]";
    let report =
        tuned(&folder, &of_two_states("", given, "parameters = [\"gain\"]\nheld_out = 0.2\nstarts = 2\nprofile = 3"));
    assert_eq!((report.criterion, report.agreeing), ("innovations", 2));
    let fitted = &rows[..2400];
    let l = [parameter(&report, "gain[1,1]").after, parameter(&report, "gain[2,1]").after];
    for (i, name) in ["gain[1,1]", "gain[2,1]"].into_iter().enumerate() {
        let deviation = parameter(&report, name).standard_error.unwrap();
        assert!((l[i] - KALMAN[i]).abs() < 3.0 * deviation, "{report:?}");
        // The information of the record: the second derivative of N/2 ln(sum nu^2), by hand, without the other gain.
        let mut other = l;
        let at = |x: [f64; 2]| 0.5 * fitted.len() as f64 * squares(fitted, x).ln();
        other[i] += 0.01;
        let up = at(other);
        other[i] -= 0.02;
        let conditional = ((up + at(other) - 2.0 * at(l)) / 1e-4).sqrt().recip();
        assert!((0.98 * conditional..2.0 * conditional).contains(&deviation), "{deviation} {conditional}");
        let Some([Some(low), Some(high)]) = parameter(&report, name).profile_interval else { panic!("{report:?}") };
        let [from, to] = parameter(&report, name).interval.unwrap();
        assert!((low - from).abs() < 0.2 * deviation && (high - to).abs() < 0.2 * deviation, "{report:?}");
    }
    // A grid about it, by hand, has no better gain.
    let best = squares(fitted, l);
    let mut least = (f64::INFINITY, [0.0; 2]);
    for i in 0..=40 {
        for j in 0..=40 {
            let x = [0.1 + 0.01 * f64::from(i), 0.1 + 0.01 * f64::from(j)];
            let sum = squares(fitted, x);
            if sum < least.0 {
                least = (sum, x);
            }
        }
    }
    assert!(
        best <= least.0 && (l[0] - least.1[0]).abs() < 0.011 && (l[1] - least.1[1]).abs() < 0.011,
        "{l:?} {least:?}"
    );
    // The numbers of the report are those of the recursion.
    let mean = fitted.iter().map(|row| row[1]).sum::<f64>() / 2400.0;
    let deviation = fitted.iter().map(|row| (row[1] - mean).powi(2)).sum::<f64>();
    let [before, after] = report.relative.unwrap();
    assert!((after - (best / deviation).sqrt()).abs() < 1e-9 * after, "{after}");
    assert!((before - (squares(fitted, [0.6, 0.1]) / deviation).sqrt()).abs() < 1e-9 * before, "{before}");
    let held = &report.held_out.as_ref().unwrap().after;
    assert_eq!(held.innovations[0].samples, 600);
    assert!(held.innovations[0].white.unwrap() > 0.01 && held.log_likelihood.is_none(), "{held:?}");

    // By its poles, from two real ones, which become a pair of conjugates.
    let poles = "kind = \"luenberger\"\npoles = [0.9, 0.4]";
    let of_poles = tuned(&folder, &of_two_states("", poles, "parameters = [\"poles\"]\nheld_out = 0.2\nprofile = 0"));
    assert!((of_poles.relative.unwrap()[1] - after).abs() < 1e-6 * after, "{of_poles:?}");
    let written = study_in(&folder, &of_poles.study);
    let placed = written.observers[0].kind.gain().map(|linear| format!("{:?}", linear.gain)).unwrap();
    assert!(placed.starts_with("Poles([Complex { re: 0.8") && placed.contains("im: -0."), "{placed}");
    // A - L C has the trace and the determinant of the gain: 1.95 - l1, and 0.95 (1 - l1) + 0.1 l2.
    let z = written.observers[0].kind.gain().and_then(|linear| match &linear.gain {
        luenberger_study::study::GainSpec::Poles(poles) => Some(poles.clone()),
        _ => None,
    });
    let z = z.unwrap();
    assert!(
        ((z[0] + z[1]).re - (1.95 - l[0])).abs() < 2e-3
            && ((z[0] * z[1]).re - (0.95 * (1.0 - l[0]) + 0.1 * l[1])).abs() < 2e-3,
        "{z:?} {l:?}"
    );
}

/// A gain depends on W and V by their ratio alone, and so do prediction errors: the report says so.
#[test]
fn prediction_errors_determine_noises_but_for_a_factor() {
    let folder = scratch("tune-gain-ratio");
    write_log(&folder, &two_states(900, 4));
    for kind in [
        "kind = \"luenberger\"\nkalman = { w = [1e-4, 3e-2], v = [0.02] }",
        "kind = \"kalman\"\nw = [1e-4, 3e-2]\nv = [0.02]",
    ] {
        let text = of_two_states(
            "",
            kind,
            "parameters = [\"w[x2]\", \"v\"]\ncriterion = \"innovations\"\nstarts = 1\nprofile = 0",
        );
        let report = tuned(&folder, &text);
        let said = report.remarks.iter().any(|words| {
            words.contains("determines only w[x2] / v[y]") || words.contains("determines only v[y] / w[x2]")
        });
        assert!(said && report.parameters.iter().all(|one| one.interval.is_none()), "{report:?}");
    }
}

/// By the errors of the second state alone, the only one that the log knows: the minimum is that of a recursion by
/// hand.
#[test]
fn the_least_errors_are_those_of_a_recursion_by_hand() {
    let folder = scratch("tune-errors");
    let rows = two_states(1500, 9);
    write_log(&folder, &rows);
    let given = "kind = \"luenberger\"\ngain = [[0.3], [0.1]]";
    let text = of_two_states("states = [\"-\", \"x2\"]", given, "parameters = [\"gain\"]\nstarts = 2");
    let report = tuned(&folder, &text);
    assert_eq!((report.criterion, report.reference.as_slice()), ("errors", &["x2".to_owned()][..]));
    let squares = |l: [f64; 2]| {
        let a = Matrix2::new(1.0, 0.1, 0.0, 0.95);
        let (mut x, mut sum) = (Vector2::zeros(), 0.0);
        for [u, y, _, x2] in &rows[..1050] {
            sum += (x2 - x[1]) * (x2 - x[1]);
            let nu: f64 = y - x[0];
            x = a * x + Vector2::new(0.0, 0.1 * u) + Vector2::from(l) * nu;
        }
        sum
    };
    let l = [parameter(&report, "gain[1,1]").after, parameter(&report, "gain[2,1]").after];
    let best = squares(l);
    for i in 0..2 {
        for step in [-0.01, 0.01] {
            let mut other = l;
            other[i] += step;
            assert!(squares(other) > best, "{l:?}");
        }
    }
    let mean = rows[..1050].iter().map(|row| row[3]).sum::<f64>() / 1050.0;
    let deviation = rows[..1050].iter().map(|row| (row[3] - mean).powi(2)).sum::<f64>();
    assert!((report.relative.unwrap()[1] - (best / deviation).sqrt()).abs() < 1e-9, "{report:?}");
    // Errors of successive rows are correlated: no interval is stated.
    assert!(report.parameters.iter().all(|one| one.interval.is_none()) && report.profiles.is_empty());
    let text = report.text();
    assert!(text.contains("by the least errors of x2") && text.contains("relative error"), "{text}");
    assert!(text.contains("At this minimum the log determines") && !text.contains("likelihood"), "{text}");
    assert!(report.study.contains("by the least errors of x2 on the first 1050 rows of 1500"), "{}", report.study);
    let held = report.held_out.unwrap();
    assert!(held.after.relative.unwrap() < held.before.relative.unwrap(), "{held:?}");
    // The criterion can be chosen, and prediction errors are another.
    let other = tuned(
        &folder,
        &text_with(
            &of_two_states("states = [\"-\", \"x2\"]", given, "parameters = [\"gain\"]\nstarts = 1\nprofile = 0"),
            "innovations",
        ),
    );
    assert!((parameter(&other, "gain[2,1]").after - l[1]).abs() > 1e-3, "{other:?}");
}

fn text_with(text: &str, criterion: &str) -> String {
    text.replace("[tune]\n", &format!("[tune]\ncriterion = \"{criterion}\"\n"))
}

/// Position and speed of a mass with friction, in continuous time.
fn write_mass(folder: &Path) {
    let (mut random, mut x, mut log) = (Random(8), [0.3f64, 0.0], "t,u,y,z,position,speed\n".to_owned());
    for k in 0..160 {
        let ([noise, push], [other, _]) = (random.normal_pair(), random.normal_pair());
        let u = if k % 60 < 30 { 1.0 } else { -1.0 };
        let (y, z) = (x[0] + 0.02 * noise, x[1] + 0.05 * other);
        writeln!(log, "{},{u},{y},{z},{},{}", 0.05 * f64::from(k), x[0], x[1]).unwrap();
        for _ in 0..50 {
            x = [x[0] + 1e-3 * x[1], x[1] + 1e-3 * (u + 0.3 * push - 0.5 * x[1])];
        }
    }
    std::fs::write(folder.join("log.csv"), log).unwrap();
}

fn of_mass(plant: &str, observer: &str, tune: &str) -> String {
    let outputs = if plant.contains("[0, 1]]\n") { "[\"y\", \"z\"]" } else { "[\"y\"]" };
    format!(
        "[plant]\nstates = [\"position\", \"speed\"]\ninputs = [\"u\"]\noutputs = {outputs}\n{plant}\n[log]\nfile = \"log.csv\"\nstates = [\"position\", \"speed\"]\n[[observer]]\nname = \"observer\"\ninitial = [0, 0]\n{observer}\n[tune]\nobserver = \"observer\"\nparameters = {tune}\nstarts = 1\nprofile = 0\n"
    )
}

const LINEAR: &str = "a = [[0, 1], [0, -0.5]]\nb = [[0], [1]]\nc = [[1, 0]]";

/// Each kind by the numbers that it is tuned by: the fit is not worse, and what is written is what was fitted.
#[test]
fn every_kind_is_tuned_by_its_own_numbers() {
    let folder = scratch("tune-kinds");
    write_mass(&folder);
    let general = "f = [\"speed\", \"u - 0.5*speed - 0*speed^3\"]\nh = [\"position\"]";
    let cases = [
        (LINEAR, "kind = \"luenberger\"\npoles = [-4, -5]", "[\"poles\"]"),
        (LINEAR, "kind = \"luenberger\"\ngain = [[9], [20]]", "[\"gain\"]"),
        (LINEAR, "kind = \"luenberger\"\ndecay_rate = 5\nnoise = [1e-5]", "[\"decay_rate\"]"),
        (LINEAR, "kind = \"luenberger\"\nkalman = { w = [1e-6, 1], v = [1e-4] }", "[\"w[speed]\"]"),
        (
            LINEAR,
            "kind = \"cubic\"\npoles = [-3, -4]\ngamma = 0.3",
            "[\"gamma\", \"poles\"]\nbounds = { gamma = [0.01, 30] }",
        ),
        (LINEAR, "kind = \"proportional-integral\"\ne = [[0], [1]]\npoles = [-8, -9, -10]", "[\"poles\"]"),
        (LINEAR, "kind = \"extended-state\"\ne = [[0], [1]]\nbandwidth = 15", "[\"bandwidth\"]"),
        (LINEAR, "kind = \"reduced-order\"\npoles = [-12]", "[\"poles\"]"),
        (
            LINEAR,
            "kind = \"mhe\"\nw = [1e-6, 0.1]\nv = [1e-4]\np0 = [1, 1]\nperiod = 0.05\nwindow = 3",
            "[\"w[speed]\"]",
        ),
        (general, "kind = \"high-gain\"\nr = 0.2", "[\"r\"]"),
        (general, "kind = \"high-gain\"\nr = 0.2\nalpha = [2, 1]", "[\"alpha\"]"),
        (general, "kind = \"sliding-mode\"\nbound = 5\nperiod = 0.05", "[\"bound\"]"),
    ];
    for (plant, observer, parameters) in cases {
        let text = of_mass(plant, observer, parameters);
        for criterion in ["errors", "innovations"] {
            let report = tuned(&folder, &text_with(&text, criterion));
            let [before, after] = report.relative.unwrap();
            assert!(after <= before && after < 0.9, "{observer} {criterion}: {before} {after}");
            if criterion == "innovations" {
                continue;
            }
            let again = tuned(&folder, &report.study).relative.unwrap()[0];
            assert!((again - after).abs() < 1e-6 * after, "{observer}: {again} {after}\n{}", report.study);
        }
    }
}

/// The same of kinds whose designs cost more.
#[test]
fn kinds_with_costly_designs_are_tuned_by_their_own_numbers() {
    let folder = scratch("tune-costly-kinds");
    write_mass(&folder);
    let swing = "f = [\"speed\", \"u - 0.5*speed - 0.1*sin(position)\"]\nh = [\"position\"]";
    let both = "a = [[0, 1], [0, -0.5]]\nb = [[0], [1]]\nc = [[1, 0], [0, 1]]\n";
    let region = "region = { states = [[-5, 5], [-5, 5]], inputs = [[-1, 1]] }";
    let noises = "e = [[0, 0], [1, 0]]\nd = [[0, 0.05]]";
    let rate = "[\"decay_rate\"]\nbounds = { decay_rate = [0.3, 4] }";
    let cases = [
        (LINEAR, "kind = \"sampled-cubic\"\npoles = [-3, -4]\ngamma = 0.3\nperiod = 0.05".to_owned(), "[\"poles\"]"),
        (LINEAR, "kind = \"interval\"\ninitial_bounds = [1, 1]\nbounds = { noise = [0.1], disturbance = [1], e = [[0], [1]] }\npoles = [-4, -6]".to_owned(), "[\"poles\"]"),
        (both, "kind = \"unknown-input\"\ne = [[0], [1]]\npoles = [-4, -6]".to_owned(), "[\"poles\"]"),
        (LINEAR, format!("kind = \"h2\"\n{noises}\ngain = [[5], [8]]"), "[\"gain\"]"),
        (LINEAR, format!("kind = \"h-infinity\"\n{noises}\ngamma = 1.5"), "[\"gamma\"]"),
        (swing, format!("kind = \"lipschitz\"\n{region}\ndecay_rate = 1\nnoise = [2e-5]"), rate),
        (swing, format!("kind = \"lpv\"\n{region}\ngain = [[5], [8]]"), "[\"gain\"]"),
        (swing, format!("kind = \"mean-value\"\n{region}\ndecay_rate = 1\neta = 2\nnoise = [2e-5]"), "[\"eta\"]"),
    ];
    for (plant, observer, parameters) in cases {
        let report = tuned(&folder, &of_mass(plant, &observer, parameters));
        let [before, after] = report.relative.unwrap();
        assert!(after <= before, "{observer}: {before} {after}");
    }
}

#[test]
fn what_cannot_be_fitted_is_refused() {
    let folder = scratch("tune-gain-refused");
    write_log(&folder, &two_states(200, 2));
    let gain = "kind = \"luenberger\"\ngain = [[0.3], [0.1]]";
    let with = |log: &str, observer: &str, tune: &str| of_two_states(log, observer, tune);
    // No reference columns.
    let said = mistake(&folder, &with("", gain, "criterion = \"errors\"\nparameters = [\"gain\"]"));
    assert!(said.contains("the log has no column of a true state") && said.contains("`states` in [log]"), "{said}");
    // No covariance.
    let said = mistake(&folder, &with("", gain, "criterion = \"likelihood\"\nparameters = [\"gain\"]"));
    assert!(said.contains("have no likelihood") && said.contains("criterion = \"innovations\""), "{said}");
    // A key that the study does not give, and noises that the observer does not have.
    let said = mistake(&folder, &with("", gain, "parameters = [\"poles\"]"));
    assert!(
        said.contains("which cannot be fitted") && said.contains("\"observer\" has no `poles` in the study"),
        "{said}"
    );
    let said = mistake(&folder, &with("", gain, "parameters = [\"w\"]"));
    assert!(said.contains("expected one of bias[y], gain[1,1], gain[2,1], gain"), "{said}");
    let zero = "kind = \"luenberger\"\ngain = [[0], [0]]";
    let said = mistake(&folder, &with("", zero, "parameters = [\"gain\"]"));
    assert!(said.contains("gain[1,1] is 0 in the study"), "{said}");
    // Parts that are too short, in measurements or in true states.
    let short = |tune: &str, log: &str| match refused(&folder, &with(log, gain, tune)) {
        StudyError::OnLog(LogError::TooShort { measurements, least, of, .. }) => (measurements, least, of),
        other => panic!("{other}"),
    };
    assert_eq!(short("parameters = [\"gain\"]\nheld_out = 0.05", ""), (10, 20, "measurement"));
    assert_eq!(short("parameters = [\"gain\"]\nheld_out = 0.05", "states = [\"x1\", \"-\"]"), (10, 20, "true state"));
    // An observer that diverges with the values of the study.
    let unstable = "kind = \"luenberger\"\npoles = [0.5, 0.6]";
    std::fs::write(
        folder.join("log.csv"),
        "t,u,y,x1,x2\n".to_owned()
            + &(0..100).map(|k| format!("{},0,1e300,0,0\n", 0.1 * f64::from(k))).collect::<Vec<_>>().concat(),
    )
    .unwrap();
    let error = refused(&folder, &with("", unstable, "parameters = [\"poles\"]"));
    assert!(matches!(&error, StudyError::Tune(TuneError::NoStart { .. })), "{error}");
}

/// A sensor bias and the gain at once, over two logs: the bias is found, and each log begins anew.
#[test]
fn biases_and_several_logs_are_fitted_with_gains() {
    let folder = scratch("tune-gain-logs");
    let mut rows = two_states(800, 5);
    for row in &mut rows {
        row[1] += 0.5;
    }
    write_log(&folder, &rows);
    std::fs::rename(folder.join("log.csv"), folder.join("second.csv")).unwrap();
    let mut rows = two_states(800, 6);
    for row in &mut rows {
        row[1] += 0.5;
    }
    write_log(&folder, &rows);
    let given = "kind = \"luenberger\"\ngain = [[0.3], [0.2]]";
    let text = of_two_states(
        "states = [\"x1\", \"x2\"]",
        given,
        "files = [\"second.csv\"]\nparameters = [\"gain\", \"bias[y]\"]\nstarts = 1",
    );
    let report = tuned(&folder, &text);
    // The mean of the errors of the position is the bias, to its noise over 1120 rows.
    assert!((parameter(&report, "bias[y]").after - 0.5).abs() < 0.05, "{report:?}");
    assert_eq!(report.logs.len(), 2);
    assert!(report.study.contains("outputs = [\"y - 0."), "{}", report.study);
}
