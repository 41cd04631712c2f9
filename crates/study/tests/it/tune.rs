//! `luenberger tune`: what is fitted, with which errors, and what is refused.

use std::fmt::Write;
use std::path::Path;

use luenberger_random::Random;
use luenberger_study::execute::LogError;
use luenberger_study::tune::{TuneError, TuneOptions, TuneReport, TunedParameter, tune};
use luenberger_study::{RunOptions, Study, StudyError};

use crate::studies::{mistake, scratch, study_in};

fn tuned(study: &Study) -> TuneReport {
    tune(study, &TuneOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
fn refused(study: &Study) -> TuneError {
    match tune(study, &TuneOptions::default()) {
        Err(StudyError::Tune(error)) => error,
        other => panic!("{other:?}"),
    }
}

#[track_caller]
fn parameter<'a>(report: &'a TuneReport, name: &str) -> &'a TunedParameter {
    report.parameters.iter().find(|one| one.name == name).unwrap_or_else(|| panic!("{name} in {report:?}"))
}

/// Annual flow of the Nile at Aswan, 1871 to 1970 (Cobb, Biometrika 65, 1978).
const NILE: [f64; 100] = [
    1120.0, 1160.0, 963.0, 1210.0, 1160.0, 1160.0, 813.0, 1230.0, 1370.0, 1140.0, 995.0, 935.0, 1110.0, 994.0, 1020.0,
    960.0, 1180.0, 799.0, 958.0, 1140.0, 1100.0, 1210.0, 1150.0, 1250.0, 1260.0, 1220.0, 1030.0, 1100.0, 774.0, 840.0,
    874.0, 694.0, 940.0, 833.0, 701.0, 916.0, 692.0, 1020.0, 1050.0, 969.0, 831.0, 726.0, 456.0, 824.0, 702.0, 1120.0,
    1100.0, 832.0, 764.0, 821.0, 768.0, 845.0, 864.0, 862.0, 698.0, 845.0, 744.0, 796.0, 1040.0, 759.0, 781.0, 865.0,
    845.0, 944.0, 984.0, 897.0, 822.0, 1010.0, 771.0, 676.0, 649.0, 846.0, 812.0, 742.0, 801.0, 1040.0, 860.0, 874.0,
    848.0, 890.0, 744.0, 749.0, 838.0, 1050.0, 918.0, 986.0, 797.0, 923.0, 975.0, 815.0, 1020.0, 906.0, 901.0, 1170.0,
    912.0, 746.0, 919.0, 718.0, 714.0, 740.0,
];

const LEVEL: &str = r#"# The flow of the Nile.
[plant]
a = [[1]]  # a random walk
c = [[1]]
dt = 1
states = ["level"]
outputs = ["flow"]

[log]
file = "nile.csv"
time = "year"

# The local level model, nothing known of its first level.
[[observer]]
name = "level"
kind = "extended-kalman"
initial = [0]
p0 = [1e9]
w = [1000]
v = [10000]  # by eye
period = 1

[tune]
observer = "level"
parameters = ["w", "v"]
held_out = 0
profile = 3
"#;

fn nile(folder: &Path) {
    let mut log = "year,flow\n".to_owned();
    for (k, flow) in NILE.iter().enumerate() {
        writeln!(log, "{},{flow}", 1871 + k).unwrap();
    }
    std::fs::write(folder.join("nile.csv"), log).unwrap();
}

/// Durbin and Koopman, Time Series Analysis by State Space Methods, 2012, section 2.10.3: 15099 and 1469.1. The
/// standard errors of the logarithms and the log-likelihood are those of statsmodels 0.14 with P(0) = 1e9.
#[test]
fn the_level_of_the_nile_has_the_published_variances() {
    let folder = scratch("tune-nile");
    nile(&folder);
    let report = tuned(&study_in(&folder, LEVEL));
    let (w, v) = (parameter(&report, "w[level]"), parameter(&report, "v[flow]"));
    assert!((w.after - 1469.1).abs() < 1.0, "{w:?}");
    assert!((v.after - 15099.0).abs() < 1.5, "{v:?}");
    assert!((report.log_likelihood + 643.826_816_5).abs() < 1e-6, "{}", report.log_likelihood);
    // The standard error of a value is that of its logarithm times the value.
    assert!((w.standard_error.unwrap() / w.after - 0.871_5).abs() < 2e-3, "{w:?}");
    assert!((v.standard_error.unwrap() / v.after - 0.208_34).abs() < 5e-4, "{v:?}");
    assert_eq!((report.agreeing, report.starts), (3, 3));
    // The two intervals of V are close; that of W is skew, and the profile says so.
    let ([low, _], Some([Some(profile_low), Some(_)])) = (v.interval.unwrap(), v.profile_interval) else {
        panic!("{v:?}");
    };
    assert!((low / profile_low - 1.0).abs() < 0.1, "{v:?}");
}

#[test]
fn the_tuned_study_keeps_its_comments_and_says_where_numbers_come_from() {
    let folder = scratch("tune-text");
    nile(&folder);
    let text = LEVEL.replace("profile = 3", "profile = 0").replace("\"v\"]", "\"v\", \"bias[flow]\"]");
    let text = text.replace("held_out = 0", "held_out = 0\nbounds = { \"bias[flow]\" = [-1, 1] }");
    let report = tuned(&study_in(&folder, &text.replace("initial = [0]\np0 = [1e9]", "initial = [1100]\np0 = [1e4]")));
    let w = parameter(&report, "w[level]").after;
    for line in [
        "# The flow of the Nile.",
        "a = [[1]]  # a random walk",
        "# The local level model, nothing known of its first level.",
        &format!("w = [{w}]"),
        &format!("v = [{}]  # by eye", parameter(&report, "v[flow]").after),
    ] {
        assert!(report.study.lines().any(|other| other == line), "{line} in\n{}", report.study);
    }
    assert!(
        report.study.contains(&format!("# luenberger tune: w[level] = {w}, before 1000; 95 % ")),
        "{}",
        report.study
    );
    assert!(report.study.contains("outputs = [\"flow "), "{}", report.study);
    // What is written is what was fitted.
    let again = study_in(&folder, &report.study);
    let before = tuned(&again).log_likelihood_before;
    assert!((before - report.log_likelihood).abs() < 1e-9 * before.abs(), "{before} {}", report.log_likelihood);
}

#[test]
fn a_tuned_study_is_never_written_over_without_force() {
    let folder = scratch("tune-file");
    nile(&folder);
    let study = study_in(&folder, &LEVEL.replace("profile = 3", "profile = 0\nstarts = 1"));
    let write = |force| {
        let run = RunOptions { force, ..RunOptions::default() };
        tune(&study, &TuneOptions { run, write: true })
    };
    write(false).unwrap();
    let found = write(false);
    assert!(
        matches!(&found, Err(StudyError::Tune(TuneError::Exists { path })) if path.ends_with("tuned.toml")),
        "{found:?}"
    );
    write(true).unwrap();
    // That of a tuned study is another file.
    let again = Study::from_path(&folder.join("tuned.toml")).unwrap();
    assert_eq!(tuned(&again).file, "tuned-2.toml");
}

#[test]
fn the_results_do_not_depend_on_the_number_of_threads() {
    let folder = scratch("tune-threads");
    nile(&folder);
    let study = study_in(&folder, LEVEL);
    let with = |threads| {
        let run = RunOptions { threads: Some(threads), ..RunOptions::default() };
        let report = tune(&study, &TuneOptions { run, write: false }).unwrap();
        serde_json::to_string(&report).unwrap()
    };
    assert_eq!(with(1), with(3));
}

/// x+ = a x + b u + w, y = x + v.
const SCALAR: &str = r#"
[plant]
states = ["x"]
inputs = ["u"]
outputs = ["y"]
parameters = { a = 0.7, b = 1.3 }
f = ["a*x + b*u"]
h = ["x"]
dt = 1

[log]
file = "log.csv"

[[observer]]
name = "filter"
kind = "extended-kalman"
initial = [0]
p0 = [1]
w = [0.3]
v = [0.5]
period = 1

[tune]
observer = "filter"
parameters = ["a", "b", "w", "v"]
held_out = 0
starts = 1
profile = 0
"#;

/// A log of the plant with these numbers, the state with its first standard deviation 1.
fn scalar(rows: usize, (a, b, w, v): (f64, f64, f64, f64), seed: u64, input: impl Fn(usize) -> f64) -> String {
    let mut random = Random(seed);
    let (mut log, mut x) = ("t,u,y\n".to_owned(), random.normal_pair()[0]);
    for k in 0..rows {
        let ([process, measurement], u) = (random.normal_pair(), input(k));
        writeln!(log, "{k},{u},{}", x + v.sqrt() * measurement).unwrap();
        x = a * x + b * u + w.sqrt() * process;
    }
    log
}

fn square_wave(k: usize) -> f64 {
    if (k / 10).is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// The 95 % intervals contain what the log was made with in 95 % of all logs: of 200 of them the docs say how often. A
/// share of 90 % is three standard deviations of 200 logs away; of the 40 logs here, 34 are.
#[test]
fn the_intervals_cover_the_truth() {
    let count = if std::env::var_os("EVERY_CASE").is_some() { 200 } else { 40 };
    let least = if count == 200 { 180 } else { 34 };
    let truth = [("a", 0.8), ("b", 1.0), ("w[x]", 0.5), ("v[y]", 1.0)];
    let folder = scratch("tune-coverage");
    let mut inside = [0; 4];
    for seed in 0..count {
        std::fs::write(folder.join("log.csv"), scalar(400, (0.8, 1.0, 0.5, 1.0), seed, square_wave)).unwrap();
        let report = tuned(&study_in(&folder, SCALAR));
        for ((name, value), inside) in truth.iter().zip(&mut inside) {
            let [low, high] = parameter(&report, name).interval.unwrap();
            *inside += u64::from((low..=high).contains(value));
        }
    }
    println!("of {count} logs, a, b, w, v are inside in {inside:?}");
    assert!(inside.iter().all(|inside| *inside >= least && (count < 200 || *inside <= 196)), "{inside:?} of {count}");
}

/// The stationary filter of y: P of its Riccati equation is the root of a quadratic.
#[test]
fn a_stationary_filter_has_the_likelihood_of_its_closed_form() {
    let folder = scratch("tune-stationary");
    let log = scalar(60, (0.8, 1.0, 0.5, 1.0), 7, |_| 0.0);
    std::fs::write(folder.join("log.csv"), &log).unwrap();
    let text = r#"
[plant]
a = [[0.8]]
c = [[1]]
dt = 1
[log]
file = "log.csv"
outputs = ["y"]
[[observer]]
name = "filter"
kind = "kalman"
initial = [0]
w = [0.5]
v = [1]
[tune]
observer = "filter"
parameters = ["w", "v"]
starts = 1
profile = 0
held_out = 0
"#;
    let report = tuned(&study_in(&folder, text));
    let (a, w, v) = (0.8f64, 0.5f64, 1.0f64);
    // P = a^2 P V/(P + V) + W.
    let half = 0.5 * (a * a * v + w - v);
    let p = half + (half * half + w * v).sqrt();
    let (s, gain) = (p + v, p / (p + v));
    let (mut predicted, mut expected) = (0.0, 0.0);
    for line in log.lines().skip(1) {
        let y: f64 = line.rsplit(',').next().unwrap().parse().unwrap();
        let nu: f64 = y - predicted;
        expected -= 0.5 * (std::f64::consts::TAU.ln() + s.ln() + nu * nu / s);
        predicted = a * (predicted + gain * nu);
    }
    assert!((report.log_likelihood_before - expected).abs() < 1e-9, "{} {expected}", report.log_likelihood_before);
    assert!(report.log_likelihood > expected);
}

/// The log-likelihood of the scalar filter on a log, by hand, from P(0) = 1 and the estimate 0.
fn by_hand(log: &str, (a, b, w, v): (f64, f64, f64, f64)) -> f64 {
    let (mut x, mut p, mut sum) = (0.0, 1.0, 0.0);
    for line in log.lines().skip(1) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let (nu, s) = (cells[2] - x, p + v);
        sum -= 0.5 * ((2.0 * std::f64::consts::PI * s).ln() + nu * nu / s);
        x = a * (x + p / s * nu) + b * cells[1];
        p = a * a * (p - p * p / s) + w;
    }
    sum
}

/// Each of several logs begins with the first estimate and P(0), so that their log-likelihoods add; one log that is cut
/// in two is not the two, since its second part knows the first.
#[test]
fn the_likelihoods_of_several_logs_add() {
    let folder = scratch("tune-logs");
    let values = (0.7, 1.3, 0.3, 0.5);
    let whole = scalar(160, (0.8, 1.0, 0.5, 1.0), 3, square_wave);
    let lines: Vec<&str> = whole.lines().collect();
    let part = |lines: &[&str]| format!("t,u,y\n{}\n", lines.join("\n"));
    let [first, second] = [part(&lines[1..101]), part(&lines[101..])];
    std::fs::write(folder.join("log.csv"), &first).unwrap();
    std::fs::write(folder.join("second.csv"), &second).unwrap();
    let both = SCALAR.replace("held_out = 0", "files = [\"second.csv\"]\nheld_out = 0");
    let report = tuned(&study_in(&folder, &both));
    let expected = by_hand(&first, values) + by_hand(&second, values);
    assert!((report.log_likelihood_before - expected).abs() < 1e-9 * expected.abs(), "{report:?}");
    assert!((by_hand(&whole, values) - expected).abs() > 1e-3);
    let rows: Vec<(usize, usize)> = report.logs.iter().map(|log| (log.fitted, log.measurements)).collect();
    assert_eq!(rows, [(100, 100), (60, 60)]);
    // The maximum is one of the sum, and not of either.
    let fitted: Vec<f64> = ["a", "b", "w[x]", "v[y]"].iter().map(|name| parameter(&report, name).after).collect();
    let at = |values: &[f64]| {
        let values = (values[0], values[1], values[2], values[3]);
        by_hand(&first, values) + by_hand(&second, values)
    };
    assert!((report.log_likelihood - at(&fitted)).abs() < 1e-8 * expected.abs());
    for i in 0..4 {
        for factor in [0.98, 1.02] {
            let mut other = fitted.clone();
            other[i] *= factor;
            assert!(at(&other) < at(&fitted), "{i} {factor}");
        }
    }
    // The part that is held out is the last of each.
    let held = tuned(&study_in(&folder, &both.replace("held_out = 0", "held_out = 0.3")));
    let rows: Vec<(usize, usize)> = held.logs.iter().map(|log| (log.fitted, log.held_out)).collect();
    assert_eq!(rows, [(70, 30), (42, 18)]);
    let words = "the first 70 rows of 100 of log.csv and the first 42 rows of 60 of second.csv";
    assert!(held.study.contains(words), "{}", held.study);
    // A log that lacks a column, or is named twice, is refused where it is named.
    std::fs::write(folder.join("second.csv"), second.replace("t,u,y", "t,v,y")).unwrap();
    let error = Study::from_text("study.toml", &both, luenberger_study::Format::Toml, &folder).unwrap_err().to_string();
    assert!(error.contains("second.csv") && error.contains('u'), "{error}");
    let twice = both.replace("\"second.csv\"", "\"log.csv\"");
    let error =
        Study::from_text("study.toml", &twice, luenberger_study::Format::Toml, &folder).unwrap_err().to_string();
    assert!(error.contains("the log \"log.csv\" is named twice"), "{error}");
}

#[test]
fn what_the_log_determines_only_together_is_named() {
    let folder = scratch("tune-together");
    std::fs::write(folder.join("log.csv"), scalar(200, (0.8, 1.0, 0.5, 1.0), 3, square_wave)).unwrap();
    // Only the product of the two gains enters.
    let text = SCALAR.replace("b = 1.3", "b = 1.3, c = 1").replace("b*u", "b*c*u");
    let text = text.replace("\"a\", \"b\", \"w\", \"v\"", "\"b\", \"c\"");
    let report = tuned(&study_in(&folder, &text));
    assert!(
        report.remarks.iter().any(|words| words.contains("determines only") && words.contains(" x ")),
        "{report:?}"
    );
    assert!(parameter(&report, "b").interval.is_none() && parameter(&report, "c").interval.is_none());
    let product = parameter(&report, "b").after * parameter(&report, "c").after;
    assert!((product - 1.0).abs() < 0.3, "{product}");
}

/// All that is fitted ends at its bound: the values stand there, without an interval.
#[test]
fn a_fit_that_ends_at_all_bounds_has_no_intervals() {
    let folder = scratch("tune-at-bounds");
    std::fs::write(folder.join("log.csv"), scalar(200, (0.8, 1.0, 0.5, 1.0), 3, square_wave)).unwrap();
    for (parameters, bounds, ends) in [
        ("\"v\"", "{ v = [100, 500] }", vec![("v[y]", 100.0)]),
        ("\"v\", \"b\"", "{ v = [100, 500], b = [3, 5] }", vec![("v[y]", 100.0), ("b", 3.0)]),
    ] {
        let text = SCALAR.replace("b = 1.3", "b = 4").replace("v = [0.5]", "v = [200]");
        let text = text.replace("\"a\", \"b\", \"w\", \"v\"", parameters) + &format!("bounds = {bounds}\n");
        let report = tuned(&study_in(&folder, &text));
        for (name, end) in ends {
            let found = parameter(&report, name);
            assert!((found.after - end).abs() < 1e-6 * end, "{found:?}");
            assert!(found.interval.is_none(), "{found:?}");
        }
    }
}

#[test]
fn logs_that_say_nothing_are_refused() {
    let folder = scratch("tune-refused");
    let write = |log: String| std::fs::write(folder.join("log.csv"), log).unwrap();
    // Without an input, its gain does not matter.
    write(scalar(200, (0.8, 1.0, 0.5, 1.0), 3, |_| 0.0));
    let error = refused(&study_in(&folder, SCALAR));
    assert!(matches!(&error, TuneError::NoInformation { name, .. } if name == "b"), "{error}");
    assert!(error.to_string().contains("inputs that are constant: u = 0"), "{error}");
    // A log without noise is fitted ever better by less of it.
    write(scalar(200, (0.7, 1.3, 0.0, 0.0), 3, square_wave));
    let text = SCALAR.replace("\"a\", \"b\", \"w\", \"v\"", "\"w\", \"v\"");
    let error = refused(&study_in(&folder, &text));
    assert!(matches!(&error, TuneError::NoMaximum { falls: true, .. }), "{error}");
    // Parts that are too short.
    write(scalar(50, (0.8, 1.0, 0.5, 1.0), 3, square_wave));
    let short = |held_out: &str| {
        let text = SCALAR.replace("held_out = 0", &format!("held_out = {held_out}"));
        match tune(&study_in(&folder, &text), &TuneOptions::default()) {
            Err(StudyError::OnLog(LogError::TooShort { rows, measurements, least, .. })) => (rows, measurements, least),
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(short("0.2"), (10, 10, 20));
    assert_eq!(short("0.9"), (5, 5, 20));
    // A filter that does not run.
    write(scalar(50, (0.8, 1.0, 0.5, 1.0), 3, square_wave));
    let error = refused(&study_in(&folder, &SCALAR.replace("h = [\"x\"]", "h = [\"sqrt(x - 5) + x\"]")));
    assert!(matches!(&error, TuneError::NoStart { .. }), "{error}");
}

/// One wrong reading makes V large: the rows that are held out say so, and the reading is named. With a gate in the
/// tuned study, which lets the others pass, the variances are found. With one in the first study, whose V is far too
/// small, hardly any measurement is left.
#[test]
fn an_outlier_is_named_and_a_gate_that_rejects_the_log_too() {
    let folder = scratch("tune-outlier");
    let log = scalar(600, (0.7, 1.3, 0.5, 1.0), 5, square_wave);
    let text = SCALAR.replace("\"a\", \"b\", \"w\", \"v\"", "\"w\", \"v\"").replace("held_out = 0", "held_out = 0.3");
    std::fs::write(folder.join("log.csv"), &log).unwrap();
    let clean = tuned(&study_in(&folder, &text));
    assert_eq!(clean.warnings, [""; 0]);
    let mut rows: Vec<&str> = log.lines().collect();
    // The line of t = 200.
    let wrong = format!("{},99.9", rows[201].rsplit_once(',').unwrap().0);
    rows[201] = &wrong;
    std::fs::write(folder.join("log.csv"), rows.join("\n")).unwrap();
    let report = tuned(&study_in(&folder, &text));
    let [warning] = &report.warnings[..] else { panic!("{:?}", report.warnings) };
    let held_out = report.held_out.as_ref().unwrap().after.nis.as_ref().unwrap();
    assert!(held_out.mean < held_out.region[0], "{held_out:?}");
    assert!(warning.contains(&format!(" is {}, the region of 95 %", held_out.in_words())), "{warning}");
    assert!(warning.contains(" is that of y = 99.9 at t = 200 in log.csv: if it is an outlier"), "{warning}");
    assert!(warning.contains("add `gate = 5` to filter in tuned.toml"), "{warning}");
    assert!(report.text().contains(&format!("warning: {}", &warning[..20])), "{}", report.text());
    let gated = tuned(&study_in(&folder, &report.study.replace("period = 1", "period = 1\ngate = 5")));
    assert_eq!((gated.rejected, &gated.warnings[..]), (1, &[][..]));
    let of = |report: &TuneReport| parameter(report, "v[y]").after;
    assert!(
        (of(&gated) - of(&clean)).abs() < 0.1 && of(&report) > 3.0,
        "{} {} {}",
        of(&clean),
        of(&report),
        of(&gated)
    );
    let narrow = text.replace("w = [0.3]\nv = [0.5]", "w = [1e-6]\nv = [1e-6]\ngate = 3");
    let error = refused(&study_in(&folder, &narrow));
    let TuneError::Gate { part, rejected, measurements, least, .. } = &error else { panic!("{error}") };
    assert!(measurements < least && rejected > least && ["fitted", "held out"].contains(part), "{error}");
    assert!(error.to_string().contains("tune without `gate` first"), "{error}");
}

/// A heading that turns several times, measured and logged within half a turn, while the estimates go on: the errors on
/// the part that is held out are those of angles, and V is that of the compass, 0.1 rad.
#[test]
fn errors_of_angles_on_what_is_held_out_are_taken_modulo_a_turn() {
    let folder = scratch("tune-angles");
    let mut random = Random(5);
    let (mut heading, mut log) = (0.0f64, "t,rate,compass,heading\n".to_owned());
    let within = |x: f64| x.sin().atan2(x.cos());
    for k in 0..600 {
        let rate = 1.0 + (0.07 * f64::from(k)).sin();
        let [noise, _] = random.normal_pair();
        _ = writeln!(log, "{},{rate},{},{}", 0.1 * f64::from(k), within(heading + 0.1 * noise), within(heading));
        heading += 0.1 * rate;
    }
    assert!(heading > 50.0, "{heading}");
    std::fs::write(folder.join("log.csv"), log).unwrap();
    let text = r#"
[plant]
states = ["heading"]
inputs = ["rate"]
outputs = ["compass"]
f = ["heading + 0.1*rate"]
h = ["heading"]
dt = 0.1
angles = ["heading"]
[log]
file = "log.csv"
states = ["heading"]
[[observer]]
name = "EKF"
kind = "extended-kalman"
initial = [0]
p0 = [0.1]
w = [1e-5]
v = [0.05]
period = 0.1
[tune]
observer = "EKF"
parameters = ["v"]
held_out = 0.3
starts = 1
profile = 0
"#;
    let report = tuned(&study_in(&folder, text));
    let v = parameter(&report, "v[compass]");
    let [low, high] = v.interval.unwrap();
    assert!(low < 0.01 && 0.01 < high && high < 2.0 * low, "{v:?}");
    for judged in [report.held_out.as_ref().unwrap()].into_iter().flat_map(|of| [&of.before, &of.after]) {
        // A stationary filter with W and V has about sqrt(W V) of variance: far below one measurement's.
        assert!(judged.errors[0].samples == 180 && judged.errors[0].rms < 0.1, "{judged:?}");
    }
}

#[test]
fn a_table_that_cannot_be_fitted_is_refused_where_it_is_written() {
    let folder = scratch("tune-mistakes");
    nile(&folder);
    let file = folder.join("nile.csv");
    let text = LEVEL.replace("\"nile.csv\"", &format!("{:?}", file.to_str().unwrap()));
    let changed = |from: &str, to: &str| {
        let changed = text.replace(from, to);
        assert_ne!(changed, text);
        mistake(&changed)
    };
    let wrong = changed("[\"w\", \"v\"]", "[\"w\", \"v[flaw]\"]");
    assert!(wrong.message.contains("cannot be fitted") && wrong.help.unwrap().contains("v[flow]"));
    assert!(changed("[\"w\", \"v\"]", "[\"w\", \"w[level]\"]").message.contains("named twice"));
    assert!(changed("held_out = 0", "held_out = 0.95").message.contains("`held_out` is 0.95"));
    assert!(changed("observer = \"level\"", "observer = \"lever\"").message.contains("no observer named"));
    assert!(changed("profile = 3", "bounds = { w = [0, 1e4] }").message.contains("the lower bound of w[level] is 0"));
    assert!(changed("profile = 3", "bounds = { w = [2000, 1e4] }").message.contains("its value is 1000"));
    assert!(changed("profile = 3", "bounds = { p0 = [1, 2] }").message.contains("not among the parameters"));
    assert!(changed("w = [1000]", "w = [0]").message.contains("no positive entry"));
    let gain = "kind = \"luenberger\"\ngain = [[0.3]]\ninitial = [0]";
    let start = text.find("kind = \"extended-kalman\"").unwrap();
    let end = text.find("period = 1").unwrap() + "period = 1".len();
    let other = mistake(&format!("{}{gain}{}", &text[..start], &text[end..]));
    assert!(other.message.contains("\"w\", which cannot be fitted"), "{}", other.message);
    assert!(other.expected.contains("gain[1,1]"), "{}", other.expected);
    let without = text.replace("[log]", "[simulation]\nx0 = [0]\nduration = 10").replace("time = \"year\"", "");
    let kept: Vec<&str> = without.lines().filter(|line| !line.starts_with("file =")).collect();
    let without = kept.join("\n");
    assert!(mistake(&without).message.contains("[tune] without a [log]"));
}

/// `kalman` is fitted in discrete time, without angles and correlated noises; for the others the same filter is named.
#[test]
fn a_stationary_filter_without_a_likelihood_names_the_kind_that_has_one() {
    let folder = scratch("tune-kalman");
    std::fs::write(folder.join("log.csv"), scalar(200, (0.8, 1.0, 0.5, 1.0), 3, square_wave)).unwrap();
    let file = folder.join("log.csv");
    let study = |plant: &str, noises: &str| {
        format!(
            "[plant]\nstates = [\"x\"]\ninputs = [\"u\"]\noutputs = [\"y\"]\na = [[0.5]]\nb = [[1]]\nc = [[1]]\n{plant}\n[log]\nfile = {:?}\n[[observer]]\nname = \"filter\"\nkind = \"kalman\"\ninitial = [0]\nw = [0.3]\nv = [0.5]\n{noises}\n[tune]\nobserver = \"filter\"\nparameters = [\"w\"]\n",
            file.to_str().unwrap()
        )
    };
    let refused = |plant: &str, noises: &str| {
        let wrong = mistake(&study(plant, noises));
        format!("{} | {}", wrong.message, wrong.expected)
    };
    let continuous = refused("", "");
    assert!(
        continuous.contains("V is an intensity") && continuous.contains("v = the intensity over the"),
        "{continuous}"
    );
    let angle = refused("dt = 1\nangles = [\"x\"]", "");
    assert!(angle.contains("a full turn is an error") && angle.contains("which wraps angles"), "{angle}");
    assert!(angle.contains("period = 1"), "{angle}");
    let correlated = refused("dt = 1", "s = [[0.1]]");
    assert!(correlated.contains("correlated") && correlated.contains("w, v and s as they are"), "{correlated}");
    assert!(correlated.contains("period = 1"), "{correlated}");
    assert!(crate::studies::read(&study("dt = 1", "")).is_ok());
}
