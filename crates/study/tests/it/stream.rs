//! An observer on rows that arrive: the bits of the exported step and of a run on a log, whatever is missing, and a
//! saved state that goes on with them.

use std::fmt::Write as _;
use std::path::Path;

use luenberger_export::golden;
use luenberger_study::deployment::{ExportOptions, program};
use luenberger_study::stream::{ResumeError, Stream, StreamOptions};
use luenberger_study::table::Form;
use luenberger_study::{Format, RunOptions, Step, Study, execute};

use crate::recorded::others;
use crate::studies::{read, scratch, study, study_in};

/// The answers to the lines of a text.
fn answers(stream: &mut Stream, text: &str) -> Vec<Result<String, String>> {
    let lines = text.lines().enumerate();
    lines
        .filter_map(|(k, line)| {
            stream.line(k as u64 + 1, line.as_bytes()).map_err(|error| error.to_string()).transpose()
        })
        .collect()
}

#[track_caller]
fn opened(study: &Study, options: &StreamOptions) -> Stream {
    Stream::new(study, Some(&study.observers[0].name), options).unwrap_or_else(|why| panic!("{why}"))
}

/// The cells of the answers, but for their names.
#[track_caller]
fn numbers(answers: &[Result<String, String>]) -> Vec<Vec<Option<f64>>> {
    let row = |answer: &Result<String, String>| {
        let text = answer.as_ref().unwrap_or_else(|why| panic!("{why}"));
        text.trim_end().split(',').map(|cell| (!cell.is_empty()).then(|| cell.parse().unwrap())).collect()
    };
    answers[1..].iter().map(row).collect()
}

/// Inputs and outputs.
type Samples = Vec<(Vec<f64>, Vec<f64>)>;

/// Rows of smooth inputs and outputs, with the numbers that they have.
fn rows(study: &Study, count: usize, period: f64) -> (String, Samples) {
    let smooth = |k: usize, j: usize| 0.4 + 0.3 * (0.37 * k as f64 + 1.3 * j as f64).sin();
    let (m, p) = (study.plant.inputs.len(), study.plant.outputs.len());
    let samples: Samples = (0..count)
        .map(|k| ((0..m).map(|j| smooth(k, j + 3)).collect(), (0..p).map(|j| smooth(k, j)).collect()))
        .collect();
    let names = study.plant.inputs.iter().chain(&study.plant.outputs).cloned();
    let mut text = std::iter::once("t".to_owned()).chain(names).collect::<Vec<_>>().join(",") + "\n";
    for (k, (u, y)) in samples.iter().enumerate() {
        let cells = std::iter::once(k as f64 * period).chain(u.iter().chain(y).copied());
        text += &cells.map(|x| x.to_string()).collect::<Vec<_>>().join(",");
        text.push('\n');
    }
    (text, samples)
}

/// The kinds and forms that no template has, each with its exported step.
#[test]
fn the_estimates_have_the_bits_of_the_exported_step() {
    let mut seen = 0;
    for (name, text) in others() {
        let study = read(&text).unwrap_or_else(|error| panic!("{name}: {error}"));
        let period = study.observers[0].kind.period().or(study.plant.dt).unwrap_or(0.02);
        let of_export = ExportOptions { period: Some(period), ..ExportOptions::default() };
        let export = program(&study, Some(&study.observers[0].name), &of_export, None)
            .unwrap_or_else(|why| panic!("{name}: {why}"));
        let options = StreamOptions::default().period(period).predicted(!export.is_filter());
        let mut stream = opened(&study, &options);
        let (text, mut samples) = rows(&study, 14, period);
        if export.observer().takes_time() {
            // The inputs that were held since the sample before, and the time since then.
            let held: Vec<Vec<f64>> = samples.iter().map(|(u, _)| u.clone()).collect();
            let t = |k: usize| k as f64 * period;
            for (k, (u, _)) in samples.iter_mut().enumerate() {
                u.clone_from(&held[k.saturating_sub(1)]);
                u.push(if k == 0 { 0.0 } else { t(k) - t(k - 1) });
            }
        }
        let expected = golden::replay(&export, &samples).unwrap();
        let found = numbers(&answers(&mut stream, &text));
        assert_eq!(found.len(), expected.len(), "{name}");
        let count = stream.columns().iter().filter(|column| column.ends_with("_hat")).count();
        for (k, (found, expected)) in found.iter().zip(&expected).enumerate() {
            let bits = |x: f64| x.to_bits();
            let own: Vec<u64> = found[1..=count].iter().map(|x| bits(x.unwrap())).collect();
            let its: Vec<u64> = expected[..count].iter().map(|x| bits(*x)).collect();
            assert_eq!(own, its, "{name}, sample {k}: {found:?}, expected {expected:?}");
        }
        seen += count;
    }
    assert!(seen >= 50, "{seen}");
}

/// A filter in discrete time, whose log has the same steps.
const FILTER: &str = "[plant]
states = [\"position\", \"speed\"]
inputs = [\"force\"]
outputs = [\"place\", \"rate\"]
f = [\"position + 0.25*speed\", \"speed - 0.2*sin(position) + 0.25*force\"]
h = [\"position\", \"speed\"]
dt = 0.25
[log]
file = \"log.csv\"
[[observer]]
name = \"filter\"
kind = \"extended-kalman\"
initial = [0.5, 0]
w = [1e-3, 1e-2]
v = [0.04, 0.09]
period = 0.25
";

/// Rows with missing values, missed samples, a comment and a blank line.
fn with_gaps() -> String {
    let mut text = "t [s],force [N],place,rate,other\n".to_owned();
    for k in 0..60 {
        let t = 0.25 * f64::from(k);
        let place = if k % 3 == 1 { String::new() } else { format!("{}", (0.3 * t).sin()) };
        let rate = if k % 5 == 2 { "NaN".to_owned() } else { format!("{}", 0.3 * (0.3 * t).cos()) };
        let force = if k % 7 == 3 { String::new() } else { format!("{}", 0.1 * f64::from(k % 4)) };
        if !(20..27).contains(&k) && k != 40 {
            _ = writeln!(text, "{t},{force},{place},{rate},x{k}");
        }
    }
    text.replace("\n5,", "\n# five\n\n5,")
}

fn bench(name: &str, csv: &str) -> std::path::PathBuf {
    let folder = scratch(&format!("stream/{name}"));
    std::fs::write(folder.join("log.csv"), csv).unwrap();
    folder
}

/// The trajectory of a run on a log, as text.
fn trajectory(folder: &Path, text: &str, observer: &str) -> Vec<Vec<String>> {
    let options = RunOptions { output: Some(folder.join("out").into()), threads: Some(1), ..RunOptions::default() };
    let results = execute(&study_in(folder, text), Step::Run, &options).unwrap();
    assert_eq!(results.failures(), Vec::<String>::new());
    let csv = std::fs::read_to_string(folder.join(format!("out/trajectories/log-{observer}.csv"))).unwrap();
    csv.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

#[test]
fn a_stream_of_a_log_is_the_run_on_it() {
    for (keys, estimates) in [("", ""), ("gate = 1.2\n", ""), ("", "estimates = \"predicted\"\n")] {
        let folder = bench("filter", &with_gaps());
        let text = FILTER.replace("file =", &format!("{estimates}file =")) + keys;
        let expected = trajectory(&folder, &text, "filter");
        let mut stream = opened(&study_in(&folder, &text), &StreamOptions::default());
        let answers = answers(&mut stream, &with_gaps());
        assert_eq!(answers[0].as_deref(), Ok("t,position_hat,speed_hat,position_2sigma,speed_2sigma\n"));
        let names: Vec<&str> = answers[0].as_ref().unwrap().trim_end().split(',').collect();
        let columns: Vec<usize> =
            names.iter().map(|name| expected[0].iter().position(|other| other == name).unwrap()).collect();
        // A log has a row for every sample, a stream one for each row that arrives.
        let mut compared = 0;
        for found in numbers(&answers) {
            let t = found[0].unwrap();
            let Some(row) = expected[1..].iter().find(|row| row[0].parse() == Ok(t)) else { continue };
            for (found, column) in found.iter().zip(&columns) {
                let its: f64 = row[*column].parse().unwrap();
                assert_eq!(found.unwrap().to_bits(), its.to_bits(), "t = {t}, {}", expected[0][*column]);
                compared += 1;
            }
        }
        assert!(compared >= 5 * 50, "{compared}");
    }
}

/// Observers with a constant gain, on the same log: one of two outputs is missing now and then, or both, from the first
/// row on. The stream, the run on the log and the exported step with NaN have the same bits; the sums of a run are the
/// same too, because it steps the same observer.
#[test]
fn a_constant_gain_leaves_out_what_is_missing() {
    let linear = "[plant]
states = [\"position\", \"speed\"]
inputs = [\"force\"]
outputs = [\"place\", \"rate\"]
a = [[1, 0.25], [-0.05, 0.95]]
b = [[0.02], [0.25]]
c = [[1, 0.1], [0, 1]]
d = [[0.05], [0.1]]
dt = 0.25
[log]
file = \"log.csv\"
[[observer]]
name = \"observer\"
initial = [0.5, 0]
";
    let csv = with_gaps().replacen("\n0,0,0,", "\n0,0,,", 1);
    assert!(csv.lines().nth(1).unwrap().starts_with("0,0,,0.3,"), "the first row has one output");
    for (keys, is_filter) in [
        ("kind = \"luenberger\"\npoles = [0.5, 0.4]\n", false),
        ("kind = \"kalman\"\nw = [1e-3, 1e-2]\nv = [0.04, 0.09]\n", false),
        ("kind = \"kalman\"\nform = \"filter\"\nw = [1e-3, 1e-2]\nv = [0.04, 0.09]\n", true),
    ] {
        let folder = bench("constant-gain", &csv);
        let text = format!("{linear}{keys}");
        let study = study_in(&folder, &text);
        let expected = trajectory(&folder, &text, "observer");
        let predicted = answers(&mut opened(&study, &StreamOptions::default().predicted(!is_filter)), &csv);
        let names: Vec<String> = predicted[0].as_ref().unwrap().trim_end().split(',').map(str::to_owned).collect();
        let found = numbers(&predicted);
        // A stream has the time for which the estimate is, as a run has.
        let mut compared = 0;
        for row in &found {
            let t = row[0].unwrap();
            let Some(its) = expected[1..].iter().find(|row| row[0].parse() == Ok(t)) else { continue };
            for (name, value) in names.iter().zip(row).filter(|(name, _)| name.ends_with("_hat")) {
                let column = expected[0].iter().position(|other| other == name).unwrap();
                let its: f64 = its[column].parse().unwrap();
                assert_eq!(value.unwrap().to_bits(), its.to_bits(), "{keys}, {name} at t = {t}");
                compared += 1;
            }
        }
        assert!(compared >= 2 * 45, "{compared}");
        let options = ExportOptions { period: Some(0.25), ..ExportOptions::default() };
        let mut step = golden::Stepper::new(&program(&study, None, &options, None).unwrap()).unwrap();
        let mut last = 0.0;
        for (k, row) in (0..20).zip(&found) {
            let t = 0.25 * f64::from(k);
            let place = if k % 3 == 1 || k == 0 { f64::NAN } else { (0.3 * t).sin() };
            let rate = if k % 5 == 2 { f64::NAN } else { 0.3 * (0.3 * t).cos() };
            last = if k % 7 == 3 { last } else { 0.1 * f64::from(k % 4) };
            let its = step.step(&[last], &[place, rate]);
            assert_eq!([row[1], row[2]], [Some(its[0]), Some(its[1])], "{keys}, row {k}");
        }
    }
}

/// Bounds of an interval observer hold while every measurement is there.
#[test]
fn bounds_and_constant_bands_end_where_a_measurement_is_missing() {
    let interval = "[plant]\na = [[0.9, 0.05], [-0.1, 0.7]]\nb = [[0.01], [0.2]]\nc = [[1, 0]]\ndt = 0.05\n[[observer]]\nkind = \"interval\"\ninitial_bounds = [2, 2]\npoles = [0.5, 0.6]\nbounds = { disturbance = [0.01], e = [[1], [0]], noise = [0.05] }\n";
    let kalman = "[plant]\na = [[0.9, 0.05], [-0.1, 0.7]]\nb = [[0.01], [0.2]]\nc = [[1, 0]]\ndt = 0.05\n[[observer]]\nkind = \"kalman\"\nw = [1e-4, 1e-2]\nv = 0.04\nform = \"filter\"\n";
    for (text, bands) in [(interval, ["x1_lower", "x1_upper"]), (kalman, ["x1_2sigma", "x2_2sigma"])] {
        let study = study(text);
        let mut stream = opened(&study, &StreamOptions::default());
        for band in bands {
            assert!(stream.columns().contains(&band.to_owned()), "{:?}", stream.columns());
        }
        let rows = "t,u1,y1\n0,0,0.1\n0.05,0,0.1\n0.1,0,\n0.15,0,0.1\n";
        let found = numbers(&answers(&mut stream, rows));
        assert!(found[1].iter().all(Option::is_some));
        for row in &found[2..] {
            assert!(row[1..=2].iter().all(Option::is_some) && row[3..].iter().all(Option::is_none), "{row:?}");
        }
    }
}

/// A clock that passes midnight, of times of day, of dates and of universal times in turn, and a state that is saved
/// before it.
#[test]
fn a_saved_state_goes_on_with_the_same_bits() {
    let clock = |text: String, form: usize| {
        let mut lines = text.lines().map(str::to_owned).collect::<Vec<_>>();
        for line in &mut lines[1..] {
            let (t, rest) = line.split_once(',').unwrap();
            let t = 86390.0 + t.parse::<f64>().unwrap();
            let (days, t) = ((t / 86400.0).floor(), t % 86400.0);
            let (h, m, s) = ((t / 3600.0).floor(), (t / 60.0).floor() % 60.0, t % 60.0);
            assert!(days < 2.0);
            let (date, zone) = match form {
                0 => (String::new(), ""),
                1 => (format!("2024-05-0{} ", 1.0 + days), ""),
                _ => (format!("2024-05-0{}T", 1.0 + days), "Z"),
            };
            *line = format!("{date}{h:02}:{m:02}:{s:05.2}{zone},{rest}");
        }
        lines.join("\n") + "\n"
    };
    let all = others().into_iter().filter(|(name, _)| !name.contains("kkl") && !name.contains("states"));
    for (number, (name, text)) in all.enumerate() {
        let study = read(&text).unwrap();
        let period = study.observers[0].kind.period().or(study.plant.dt).unwrap_or(0.5);
        let options = StreamOptions::default().period(period);
        let (text, _) = rows(&study, 40, period);
        let text = if period >= 0.05 { clock(text, number % 3) } else { text };
        let all = answers(&mut opened(&study, &options), &text);
        assert!(all.iter().all(Result::is_ok), "{name}: {all:?}");
        let (names, rows) = text.split_once('\n').unwrap();
        let rows: Vec<&str> = rows.lines().collect();
        for cut in [0, 1, 17, 39] {
            let part = |rows: &[&str]| format!("{names}\n{}\n", rows.join("\n"));
            let mut first = opened(&study, &options);
            let mut found = Vec::new();
            for (k, line) in part(&rows[..cut]).trim_end().lines().enumerate() {
                found.extend(first.line(k as u64 + 1, line.as_bytes()).unwrap());
                first.deliver();
            }
            let mut second = opened(&study, &options);
            second.resume(&first.saved()).unwrap();
            assert_eq!(second.saved(), first.saved());
            found.extend(answers(&mut second, &part(&rows[cut..])).into_iter().skip(1).map(Result::unwrap));
            assert_eq!(found, all.iter().map(|answer| answer.clone().unwrap()).collect::<Vec<_>>(), "{name}, {cut}");
        }
    }
}

/// A row whose answer was not delivered is not in the saved state.
#[test]
fn what_was_not_delivered_is_not_saved() {
    let folder = bench("delivered", &with_gaps());
    let study = study_in(&folder, FILTER);
    let mut stream = opened(&study, &StreamOptions::default());
    let text = with_gaps();
    let lines: Vec<&str> = text.lines().collect();
    stream.line(1, lines[0].as_bytes()).unwrap();
    stream.line(2, lines[1].as_bytes()).unwrap();
    stream.deliver();
    let saved = stream.saved();
    let lost = stream.line(3, lines[2].as_bytes()).unwrap();
    assert_eq!(stream.saved(), saved);
    let mut again = opened(&study, &StreamOptions::default());
    again.resume(&saved).unwrap();
    again.line(1, lines[0].as_bytes()).unwrap();
    assert_eq!(again.line(2, lines[2].as_bytes()).unwrap(), lost);
}

#[test]
fn another_or_damaged_state_is_refused() {
    let folder = bench("damaged", &with_gaps());
    let study = study_in(&folder, FILTER);
    let mut stream = opened(&study, &StreamOptions::default());
    for (k, line) in with_gaps().lines().take(9).enumerate() {
        stream.line(k as u64 + 1, line.as_bytes()).unwrap();
        stream.deliver();
    }
    let (saved, before) = (stream.saved(), opened(&study, &StreamOptions::default()).saved());
    let mut fresh = opened(&study, &StreamOptions::default());
    let end = saved.trim_end().len();
    for length in 0..end {
        assert_eq!(fresh.resume(&saved[..length]), Err(ResumeError::NotSaved), "{length}");
    }
    for at in 0..end {
        let mut forged = saved.clone().into_bytes();
        forged[at] = if forged[at] == b'1' { b'2' } else { b'1' };
        let forged = String::from_utf8(forged).unwrap();
        assert!(fresh.resume(&forged).is_err(), "{at}: {forged}");
    }
    // Nothing of it was taken over.
    assert_eq!(fresh.saved(), before);
    for other in [FILTER.replace("0.04", "0.05"), FILTER.replace("\"filter\"", "\"other\"")] {
        let mut other = opened(&study_in(&folder, &other), &StreamOptions::default());
        assert_eq!(other.resume(&saved), Err(ResumeError::Other));
    }
    assert_eq!(fresh.resume(&saved), Ok(()));
}

/// Each row that cannot be used is named by its line, and the next ones are answered as if it had not been there.
#[test]
fn rows_that_cannot_be_used_are_passed_over() {
    let folder = bench("refused", &with_gaps());
    let study = study_in(&folder, FILTER);
    let good = ["0,0,0.1,0.2", "0.25,0,0.1,0.2", "0.5,1,0.2,0.2", "0.75,1,,0.2"];
    let names = "t,force,place,rate";
    let all = answers(&mut opened(&study, &StreamOptions::default()), &format!("{names}\n{}\n", good.join("\n")));
    for (bad, message) in [
        ("0.5,1,0.2", "line 4 has 3 cells where the table has 4 columns"),
        (
            "0.5,1,0.2,0.2,7",
            "line 4 has 5 cells where the table has 4 columns; a decimal comma needs semicolons or tabs between the cells",
        ),
        ("0.5,1,0.2 m,0", "line 4, column 3 (place): expected a number, found `0.2 m`"),
        ("0.5,1,inf,0", "line 4, column 3 (place): inf is not a finite number"),
        ("0.5,1,1e999,0", "line 4, column 3 (place): inf is not a finite number"),
        (",1,0,0", "line 4, column 1 (t): the value is missing"),
        (
            "0.1,1,0,0",
            "line 4: the time 0.1 is not after 0.25, the time of the row before; each row of a stream is one sample",
        ),
        (
            "0.25,1,0,0",
            "line 4: the time 0.25 is not after 0.25, the time of the row before; each row of a stream is one sample",
        ),
        ("0.3,1,0,0", "line 4: the time 0.3 is only 0.05 after the row before, less than half a period (0.25)"),
        ("1e7,1,0,0", "line 4: the time 10000000 is 1e7 after the row before, 39999999 periods: the clock has jumped"),
        (
            "12:00:00,1,0,0",
            "line 4, column 1 (t): expected a number, found `12:00:00`; dates and times of day are for the column of times, all in one form, such as 2024-05-01T12:00:00.5 or 12:00:00.5",
        ),
    ] {
        let mut stream = opened(&study, &StreamOptions::default());
        let rows = format!("{names}\n{}\n{}\n{bad}\n{}\n{}\n", good[0], good[1], good[2], good[3]);
        let mut found = answers(&mut stream, &rows);
        assert_eq!(found.remove(3), Err(message.to_owned()));
        assert_eq!(found, all, "{bad}");
    }
    // Numbers after dates are of another clock.
    let mut stream = opened(&study, &StreamOptions::default());
    let dated = |second: usize| format!("12:00:0{second}.25,1,0,0");
    let mut found = answers(&mut stream, &format!("{names}\n{}\n{}\n2.25,1,0,0\n", dated(0), dated(1)));
    let error = found.pop().unwrap().unwrap_err();
    assert!(error.starts_with("line 4, column 1 (t): "), "{error}");
    assert!(!found.is_empty() && found.iter().all(Result::is_ok), "{found:?}");
    let mut stream = opened(&study, &StreamOptions::default());
    let encoding = "line 2: the byte 0xff is not UTF-8; save the file as UTF-8 (a spreadsheet: \"CSV UTF-8\")";
    stream.line(1, names.as_bytes()).unwrap();
    assert_eq!(stream.line(2, b"0,\xff,0,0").unwrap_err().to_string(), encoding);
    let missing = stream.line(3, b"0,,0,0").unwrap_err().to_string();
    assert_eq!(missing, "line 3: the input `force` has no value yet; a stream begins with a row that has all inputs");
    // Without its columns there is no stream.
    let mut stream = opened(&study, &StreamOptions::default());
    let error = stream.line(1, b"t,force,plaec,rate").unwrap_err();
    assert_eq!(error.to_string(), "there is no column `place`; did you mean `plaec`?");
    assert!(error.ends_stream());
}

/// An estimate that leaves the numbers ends the stream, with its line.
#[test]
fn an_estimate_that_diverges_ends_the_stream() {
    let text = "[plant]\nf = [\"exp(exp(x1))\"]\nh = [\"x1\"]\ndt = 1\n[[observer]]\nkind = \"extended-kalman\"\nw = 1\nv = 1\nperiod = 1\n";
    let mut stream = opened(&study(text), &StreamOptions::default());
    let mut rows = "t,y1\n".to_owned();
    (0..40).for_each(|k| _ = writeln!(rows, "{k},{}", 3 * k));
    let found = answers(&mut stream, &rows);
    let error = found.iter().find_map(|answer| answer.as_ref().err()).unwrap();
    assert!(error.ends_with("it diverges, or the model is not defined there"), "{error}");
}

/// JSON objects have the answers of the same rows in CSV; keys may be absent, in any order, and more than are used.
#[test]
fn objects_are_answered_as_rows_are() {
    let folder = bench("json", &with_gaps());
    let study = study_in(&folder, FILTER);
    let csv = "t,force,place,rate\n0,1,0.1,0.2\n0.25,,0.1,\n0.75,2,,0.3\n";
    let json = "{\"t\": 0, \"force\": 1, \"rate\": 0.2, \"place [m]\": 0.1, \"status\": {\"ok\": true}}
{\"t\": \"0.25\", \"force\": null, \"place [m]\": \"0.1\", \"rate\": \"NaN\", \"more\": [1]}

{\"rate\": 0.3, \"force\": 2, \"t\": 0.75}
";
    let expected = numbers(&answers(&mut opened(&study, &StreamOptions::default()), csv));
    let mut stream = opened(&study, &StreamOptions::default());
    let found = answers(&mut stream, json);
    assert_eq!(found.len(), 3);
    for (found, expected) in found.iter().zip(&expected) {
        let object: serde_json::Value = serde_json::from_str(found.as_ref().unwrap()).unwrap();
        let numbers: Vec<Option<f64>> = stream.columns().iter().map(|name| object[name].as_f64()).collect();
        assert_eq!(&numbers, expected);
        assert_eq!(object.as_object().unwrap().len(), expected.len());
    }
    for (line, message) in [
        ("{\"t\": 1", "line 1: expected a JSON object such as {\"t\": 0.1, \"y\": 2}: EOF while parsing"),
        ("[1, 2]", "line 1: expected a JSON object such as"),
        ("{}", "line 1: expected a JSON object such as {\"t\": 0.1, \"y\": 2}: it has no keys"),
        ("{\"t\": 1, \"plaec\": 2}", "there is no column `place`; did you mean `plaec`?"),
        ("{\"time\": 1, \"place\": 2}", "there is no column `t`"),
        ("{\"t\": 1, \"force\": 1, \"place\": [2]}", "line 1, column 2 (place): expected a number, found `[2]`"),
    ] {
        let mut stream = opened(&study, &StreamOptions::default().form(Form::Json));
        let error = stream.line(1, line.as_bytes()).unwrap_err();
        assert!(error.to_string().starts_with(message) && !error.ends_stream(), "{line}: {error}");
    }
    let mut stream = opened(&study, &StreamOptions::default());
    stream.line(1, b"{\"t\": 0, \"force\": 1, \"place\": 1}").unwrap();
    assert_eq!(stream.unseen(), ["rate"]);
}

/// Expressions of columns, units, dates, semicolons and decimal commas are those of a log.
#[test]
fn columns_are_those_of_the_log() {
    let csv = "stamp;u [mN];pos [mm];rate\n2024-05-01 12:00:00,0;1500;100;0,2\n2024-05-01 12:00:00,25;1500;;0,25\n2024-05-01 12:00:00,75;1500;120;0,3\n";
    let text = FILTER
        .replace("file =", "time = \"stamp\"\ninputs = [\"u/1000\"]\noutputs = [\"(pos + 5)/1000\", \"rate\"]\nfile =");
    let csv = csv.replace(":00,", ":00.");
    let folder = bench("columns", &csv);
    let expected = trajectory(&folder, &text, "filter");
    let study = Study::from_text("study.toml", &text, Format::Toml, &folder).unwrap();
    let found = answers(&mut opened(&study, &StreamOptions::default()), &csv);
    for row in numbers(&found) {
        let t = row[0].unwrap();
        let its = expected[1..].iter().find(|row| row[0].parse() == Ok(t)).unwrap();
        let column = expected[0].iter().position(|name| name == "speed_hat").unwrap();
        assert_eq!(row[2], its[column].parse().ok());
    }
}

/// Without times each row is the next sample, one that cannot be used too.
#[test]
fn rows_without_times_are_samples() {
    let folder = bench("untimed", &with_gaps());
    let study = study_in(&folder, FILTER);
    let timed = "t,force,place,rate\n0,1,0.1,0.2\n0.25,1,0.1,0.2\n0.75,1,0.1,0.2\n";
    let untimed = "force,place,rate\n1,0.1,0.2\n1,0.1,0.2\n1,x,0.2\n1,0.1,0.2\n";
    let expected = answers(&mut opened(&study, &StreamOptions::default()), timed);
    let mut found = answers(&mut opened(&study, &StreamOptions::default().timed(false)), untimed);
    assert!(found.remove(3).unwrap_err().contains("expected a number, found `x`"));
    assert_eq!(found, expected);
}

/// An observer without a step, and one in continuous time without a period.
#[test]
fn an_observer_needs_a_step() {
    let plant = "[plant]\na = [[0, 1], [-2, -3]]\nc = [[1, 0]]\n[[observer]]\n";
    for (observer, options, message) in [
        (
            "kind = \"functional\"\nk = [[0.5, 1]]\npoles = [-4]\n",
            StreamOptions::default().period(0.02),
            "no prediction of the output",
        ),
        ("kind = \"luenberger\"\npoles = [-4, -5]\n", StreamOptions::default(), "no period is given"),
        (
            "kind = \"extended-kalman\"\nw = [1, 1]\nv = 1\nperiod = 0.1\n",
            StreamOptions::default().period(0.2),
            "has the period 0.1 in the study, not 0.2",
        ),
    ] {
        let error = Stream::new(&study(&format!("{plant}{observer}")), None, &options).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}
