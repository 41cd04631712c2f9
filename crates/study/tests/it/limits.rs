//! Bounds on the cost of a study: estimates, refusals, and the end of a run at its time limit.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;

use luenberger_study::execute::{about, bytes, duration};
use luenberger_study::{Excess, Limits, Progress, RunOptions, Step, StudyError, estimate, execute, execute_in_part};

use crate::studies::study;

const STUDY: &str = r#"[plant]
a = [[0, 1], [0, 0]]
c = [[1, 0]]
[[observer]]
kind = "luenberger"
poles = [-2, -5]
[simulation]
x0 = [1, 1]
duration = 1
samples = SAMPLES
"#;

fn excess(text: &str, step: Step, limits: Limits) -> Option<String> {
    match execute(&study(text), step, &RunOptions { limits, threads: Some(1), ..RunOptions::default() }) {
        Err(StudyError::TooExpensive(excess @ Excess::Memory { .. })) => Some(excess.to_string()),
        Err(error) => panic!("{error}"),
        Ok(_) => None,
    }
}

#[test]
fn a_hundred_million_samples_are_refused_before_they_are_computed() {
    let text = STUDY.replace("SAMPLES", "100000000");
    let said = excess(&text, Step::Run, Limits::default()).unwrap();
    assert!(said.contains("(limit 4 GiB), most of it for the trajectories (reduce simulation.samples)"), "{said}");
    // A step that does not simulate is not refused.
    assert_eq!(excess(&text, Step::Design, Limits::default()), None);
    // 9 numbers of 8 bytes for each sample at the least.
    let needed = estimate(&study(&text), Step::Run, 1).memory.bytes;
    assert!((7.2e9..7.2e10).contains(&needed), "{needed:e}");
}

/// Percentiles of few runs are formed of all values, those of many by counting.
#[test]
fn the_memory_of_a_sweep_is_bounded() {
    let needed = |ensemble: usize| {
        let sweep = format!("[sweep]\nparameter = \"initial\"\nvalues = [1]\nensemble = {ensemble}\n");
        estimate(&study(&(STUDY.replace("SAMPLES", "3") + &sweep)), Step::Sweep, 1).memory.bytes
    };
    // 16 scores of two states.
    let each = (needed(1_000_000) - needed(500_000)) / 5e5;
    assert!((each - 128.0).abs() < 1.0, "{each}");
    assert!(needed(2_000_000) < 260.0 * 1024.0 * 1024.0);
    assert_eq!(needed(3_000_000), needed(1_000_000_000));
    assert!(needed(1_000_000_000) < 26.0 * 1024.0 * 1024.0);
}

#[test]
fn a_large_matrix_inequality_is_refused() {
    let n = 200;
    let row = |i: usize| format!("[{}]", (0..n).map(|j| if i == j { "-1" } else { "0" }).collect::<Vec<_>>().join(","));
    let rows: Vec<String> = (0..n).map(row).collect();
    let plant = format!("[plant]\na = [{}]\nc = [[{}]]\n", rows.join(","), vec!["1"; n].join(","));
    let text = format!("{plant}[[observer]]\nkind = \"luenberger\"\nlmi = true\n");
    let said = excess(&text, Step::Design, Limits::default()).unwrap();
    assert!(said.contains("the matrix inequality of an observer (for a linear plant, use poles or kalman)"), "{said}");
}

#[test]
fn the_limit_is_what_is_compared() {
    let text = STUDY.replace("SAMPLES", "1001");
    let needed = estimate(&study(&text), Step::Run, 1).memory.bytes;
    let with = |memory: f64| excess(&text, Step::Run, Limits { memory, ..Limits::NONE });
    assert!(with(0.99 * needed).is_some() && with(1.01 * needed).is_none());
    let cost = estimate(&study(&text), Step::Run, 1);
    assert!(cost.within(&Limits { seconds: cost.seconds * 0.99, ..Limits::NONE }, 1).is_err());
    assert!(cost.within(&Limits { seconds: cost.seconds * 0.99, ..Limits::NONE }, 2).is_ok());
}

/// A sweep of hours ends soon after its time limit, with the results so far.
#[test]
fn a_run_ends_at_its_time_limit() {
    let text = STUDY.replace("SAMPLES", "101")
        + "[sweep]\nparameter = \"initial\"\nfrom = 1\nto = 2\ncount = 1000\nensemble = 1000\n";
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("time-limit");
    _ = std::fs::remove_dir_all(&folder);
    let limits = Limits { seconds: 0.5, ..Limits::default() };
    let options = RunOptions { limits, output: Some(folder.clone()), threads: Some(1), ..RunOptions::default() };
    let error = execute(&study(&text), Step::Run, &options).unwrap_err();
    assert!(matches!(error, StudyError::TimeLimit { limit } if limit == 0.5), "{error}");
    assert!(error.to_string().starts_with("stopped at the time limit (0.5 s): "), "{error}");
    assert!(folder.join("manifest.json").is_file() && folder.join("trajectories/luenberger.csv").is_file());
}

/// A panic of the work ends the thread that watches the time: the execution fails, and does not wait for ever.
#[test]
fn a_panic_ends_a_run_with_a_time_limit() {
    let (sender, receiver) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        let failing = |_: Progress<'_>| panic!("as a defect in a simulation would");
        let options = RunOptions { progress: &failing, ..RunOptions::default() };
        let study = study(&STUDY.replace("SAMPLES", "101"));
        let caught = catch_unwind(AssertUnwindSafe(|| execute(&study, Step::Run, &options).is_ok()));
        _ = sender.send(caught.is_err());
    });
    assert_eq!(receiver.recv_timeout(Duration::from_secs(120)), Ok(true), "it hangs");
}

/// With what is finished at its time limit.
fn in_part(text: &str, step: Step, seconds: f64) -> luenberger_study::Results {
    let limits = Limits { seconds, ..Limits::default() };
    let options = RunOptions { limits, threads: Some(1), ..RunOptions::default() };
    let (results, stopped) = execute_in_part(&study(text), step, &options).unwrap();
    assert!(matches!(stopped, Some(StudyError::TimeLimit { limit }) if limit == seconds), "{stopped:?}");
    results
}

/// A single integration that would take its million steps is stopped on its way.
#[test]
fn the_time_limit_acts_within_an_integration() {
    let text = "[plant]\na = [[0, 1e5], [-1e5, 0]]\nc = [[1, 0]]\n[simulation]\nx0 = [1, 0]\nduration = 1000\nrtol = 1e-13\n\
                [[observer]]\nname = \"slow\"\nkind = \"luenberger\"\npoles = [-1e5, -2e5]\n\
                [[observer]]\nname = \"next\"\nkind = \"luenberger\"\npoles = [-1e5, -2e5]\n";
    let results = in_part(text, Step::Run, 0.2);
    assert!(results.observers.iter().all(|observer| observer.design.is_some()));
    let rows = results.simulation.unwrap().rows;
    let why = rows[0].failure.clone().unwrap();
    assert!(why.starts_with("stopped at t = ") && why.ends_with(": time limit reached"), "{why}");
    assert_eq!(rows.len(), 1);
    assert_eq!(results.warnings, ["Not finished: simulation of next"]);
}

/// Likewise a matrix inequality that would take a minute, and the observability analysis of a nonlinear plant.
#[test]
fn the_time_limit_acts_within_a_design() {
    let n = 70;
    let entry = |i: usize, j: usize| if i == j { -1.0 } else { 0.01 * ((7 * i + 3 * j) % 5) as f64 };
    let row = |i: usize| format!("{:?}", (0..n).map(|j| entry(i, j)).collect::<Vec<_>>());
    let rows: Vec<String> = (0..n).map(row).collect();
    let text = format!(
        "[plant]\na = [{}]\nc = [{:?}]\n[[observer]]\nname = \"quick\"\nkind = \"luenberger\"\ngain = {:?}\n\
         [[observer]]\nname = \"slow\"\nkind = \"luenberger\"\nlmi = true\nmax_gain = 100\n",
        rows.join(","),
        vec![1.0; n],
        vec![[0.0]; n]
    );
    let results = in_part(&text, Step::Design, 0.5);
    let names: Vec<&str> = results.observers.iter().map(|observer| observer.name.as_str()).collect();
    assert_eq!(names, ["quick"]);
    assert_eq!(results.warnings, ["Not finished: design of slow"]);
    let text = "[plant]\nf = [\"1e5*x2\", \"-1e5*sin(x1)\"]\nh = [\"x1\"]\n[simulation]\nx0 = [1, 0]\nduration = 1000\nrtol = 1e-13\n";
    assert!(in_part(text, Step::Observe, 0.2).observability.is_none());
}

#[test]
fn an_order_of_magnitude_in_words() {
    let words = [(0.2, "1 second"), (12.3, "10 seconds"), (61.0, "1 minute"), (3500.0, "60 minutes")];
    let more = [(7300.0, "2 hours"), (86400.0 * 365.0, "400 days"), (86400.0, "1 day")];
    for (seconds, expected) in words.into_iter().chain(more) {
        assert_eq!(about(seconds), expected);
    }
}

#[test]
fn limits_are_written_with_their_units() {
    let limits = Limits::default();
    assert_eq!((bytes(limits.memory), duration(limits.seconds)), ("4 GiB".to_owned(), "24 h".to_owned()));
    assert_eq!((bytes(0.0), bytes(1536.0), bytes(2e9)), ("0 B".into(), "1.5 KiB".into(), "1.9 GiB".into()));
    assert_eq!((duration(90.0), duration(5400.0), duration(300.0)), ("90 s".into(), "1.5 h".into(), "5 min".into()));
}

#[test]
fn an_excess_says_what_to_do() {
    let memory = Excess::Memory { needed: 24e9, limit: 4_294_967_296.0, mostly: "x" }.to_string();
    assert!(memory.contains("about 22 GiB of memory (limit 4 GiB)") && memory.ends_with("memory=28GiB"), "{memory}");
    let time = Excess::Time { needed: 3e5, limit: 86400.0, mostly: "runs".to_owned() }.to_string();
    assert!(time.contains("about 3 days (limit 24 h)") && time.ends_with("time=167h"), "{time}");
}
