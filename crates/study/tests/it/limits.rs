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

/// What is counted, by hand: 2 states, an input and an output, one observer by poles (1e-6 s n^3) and one by a matrix
/// inequality of 5 unknowns (1e-9 s and 32 bytes times their third and second power).
const COUNTED: &str = r#"[plant]
a = [[0, 1], [0, 0]]
b = [[0], [1]]
c = [[1, 0]]
outputs = ["y"]
[[observer]]
name = "poles"
kind = "luenberger"
poles = [-2, -5]
[[observer]]
name = "inequality"
kind = "luenberger"
lmi = true
"#;

fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-12 * expected, "{found:e}, by hand {expected:e}");
}

/// 0.01 s for each observer, beside its design; on a log 1e-5 s and 7 numbers of 3e-7 s for each row and observer. The
/// matrices take 60 n^2 numbers of 8 bytes. Of a row of the log the recording and its copy are kept (2 + m + p numbers
/// each), of each observer 1 + 3n + m + 2p, and of those that run 4n + 5p + 9 more.
#[test]
fn designs_and_logs_are_estimated_as_counted_by_hand() {
    let folder = crate::studies::scratch("limits-log");
    let designs = 8e-6 + 1.25e-7 + 0.02;
    for (rows, mostly) in [(100, "designs"), (3000, "simulations")] {
        let csv: Vec<String> = (0..rows).map(|k| format!("{k},0,1\n")).collect();
        let csv = csv.concat();
        std::fs::write(folder.join("log.csv"), format!("t,u1,y\n{csv}")).unwrap();
        let study = crate::studies::study_in(&folder, &format!("{COUNTED}[log]\nfile = \"log.csv\"\n"));
        let of = |step, threads| estimate(&study, step, threads);
        let observed = of(Step::Observe, 1);
        assert_eq!((observed.runs, observed.mostly.as_str()), (0, "designs"));
        assert_eq!((observed.memory.bytes, observed.memory.mostly), (1920.0, "matrices of the order of the plant"));
        near(observed.seconds, 8e-7);
        for step in [Step::Design, Step::Certify] {
            let cost = of(step, 1);
            assert_eq!((cost.runs, cost.mostly.as_str(), cost.memory.bytes), (0, "designs", 1920.0 + 800.0));
            near(cost.seconds, designs);
        }
        let all_rows = f64::from(rows);
        let running = 2.0 * all_rows * (1e-5 + 7.0 * 3e-7);
        for (step, observed) in [(Step::Simulate, 0.0), (Step::Compare, 0.0), (Step::Run, 8e-7)] {
            for (threads, active) in [(1, 1.0), (2, 2.0), (3, 2.0)] {
                let cost = of(step, threads);
                assert_eq!((cost.runs, cost.mostly.as_str()), (2, mostly), "{step:?}");
                near(cost.seconds, observed + designs + running);
                let log = all_rows * 8.0 * (2.0 * 4.0 + 2.0 * 10.0 + active * (22.0 + 10.0));
                near(cost.memory.bytes, 2720.0 + log);
                assert_eq!(cost.memory.mostly, "the estimates on the log (a part of it, or fewer observers)");
            }
        }
    }
}

/// A filter on the log with true states keeps its covariances (n^2), twice where both estimates are shown, and for the
/// smoother another 4 n^2 + 5 n. Its steps take 4e-9 s times 16 n^3.
#[test]
fn filters_on_a_log_are_estimated_as_counted_by_hand() {
    let folder = crate::studies::scratch("limits-filter");
    let csv: Vec<String> = (0..100).map(|k| format!("{},0,1,1,0\n", 0.5 * f64::from(k))).collect();
    let csv = csv.concat();
    std::fs::write(folder.join("log.csv"), format!("t,u1,y,x1,x2\n{csv}")).unwrap();
    let plant = COUNTED.split("[[observer]]").next().unwrap();
    let filter = "[[observer]]\nkind = \"extended-kalman\"\nw = 0.1\nv = 0.1\nperiod = 0.5\n";
    let truth = "states = [\"x1\", \"x2\"]\n";
    for (smooth, log, covariances) in [
        ("", "", 0.0),
        ("", truth, 4.0),
        ("", "estimates = \"predicted\"\nstates = [\"x1\", \"x2\"]\n", 8.0),
        ("smooth = true\n", "", 4.0 + 16.0 + 10.0),
        ("smooth = true\n", truth, 4.0 + 16.0 + 10.0),
    ] {
        let text = format!("{plant}[log]\nfile = \"log.csv\"\n{log}{filter}{smooth}");
        let cost = estimate(&crate::studies::study_in(&folder, &text), Step::Simulate, 1);
        near(cost.memory.bytes, 1920.0 + 800.0 * (8.0 + 10.0 + 32.0 + covariances));
        let steps = 49.5 / 0.5 * 16.0 * 8.0 * 4e-9;
        near(cost.seconds, 2e-7 * 8.0 + 0.01 + 1e-3 + steps + 7.0 * 3e-5);
    }
}

/// The time of a study of seconds is that of a part of it, and is right to an order of magnitude: other
/// programs may take half of it.
#[test]
fn the_time_of_a_run_is_estimated_to_an_order_of_magnitude() {
    let text = "[plant]\nf = [\"x2\", \"-sin(x1) - 0.1*x2\"]\nh = [\"x1\"]\n\
                [simulation]\nx0 = [1, 0]\nduration = 20000\nsamples = 1000\n\
                [[observer]]\nkind = \"extended-kalman\"\nw = 0.1\nv = 0.1\nperiod = 0.1\n";
    let study = study(text);
    let expected = estimate(&study, Step::Simulate, 1).seconds;
    let begin = std::time::Instant::now();
    execute(&study, Step::Simulate, &RunOptions { threads: Some(1), ..RunOptions::default() }).unwrap();
    let seconds = begin.elapsed().as_secs_f64();
    assert!((1.0 / 30.0..30.0).contains(&(expected / seconds)), "{expected} s, and took {seconds} s");
}

/// A sweep on a log keeps of each run and row two numbers of each state and output, and 4 besides.
#[test]
fn a_sweep_on_a_log_is_estimated_as_counted_by_hand() {
    let folder = crate::studies::scratch("limits-sweep-on-log");
    let csv: Vec<String> = (0..100).map(|k| format!("{},0,1\n", 0.5 * f64::from(k))).collect();
    std::fs::write(folder.join("log.csv"), format!("t,u1,y\n{}", csv.concat())).unwrap();
    let sweep = "[sweep]\nparameter = \"poles\"\nvalues = [1, 2, 3]\nobservers = [\"poles\"]\n";
    let text = format!("{COUNTED}[log]\nfile = \"log.csv\"\n{sweep}");
    let cost = estimate(&crate::studies::study_in(&folder, &text), Step::Sweep, 1);
    assert_eq!(cost.memory.bytes, 2720.0 + 8.0 * 2.0 * (2.0 + 1.0 + 4.0) * 3.0 * 100.0);
}

/// Of a simulation the table of each observer is kept (time, states and estimates, input, output); of those in progress
/// the integrals and the text of 22 digits with its number as well. A sweep has neither table nor text, all threads in
/// use, and 16 scores of a block of 32 runs and of 100 runs.
#[test]
fn simulations_and_sweeps_are_estimated_as_counted_by_hand() {
    let simulation = "[simulation]\nx0 = [1, 1]\nduration = 1\nsamples = 1000\n";
    let sweep = "[sweep]\nparameter = \"initial\"\nvalues = [1, 2, 3]\nensemble = 100\nobservers = [\"poles\"]\n";
    let [alone, swept] = ["", sweep].map(|sweep| study(&format!("{COUNTED}{simulation}{sweep}")));
    let (kept, table, text) = (2.0 * 7000.0 * 8.0, 10_000.0 * 8.0, 7000.0 * 30.0);
    let of_sweep = 16.0 * 8.0 * (32.0 + 100.0);
    for (study, step, runs, threads, bytes) in [
        (&alone, Step::Design, 0, 8, 0.0),
        (&alone, Step::Simulate, 2, 1, kept + table + text),
        (&alone, Step::Compare, 2, 2, kept + 2.0 * (table + text)),
        (&alone, Step::Run, 2, 8, kept + 2.0 * (table + text)),
        (&swept, Step::Simulate, 2, 8, kept + 8.0 * (table + text)),
        (&swept, Step::Run, 302, 3, kept + 3.0 * (table + text) + of_sweep),
        (&swept, Step::Run, 302, 1, kept + table + text + of_sweep),
        (&swept, Step::Sweep, 301, 3, 3.0 * table + of_sweep),
    ] {
        let cost = estimate(study, step, threads);
        assert_eq!((cost.runs, cost.memory.bytes), (runs, 2720.0 + bytes), "{step:?} on {threads} threads");
    }
}

/// Observers of 60 states are designed anew for each of three values: a second for each of 1890 unknowns cubed, by 1e9,
/// beside which a simulation of a millisecond is nothing.
#[test]
fn the_designs_of_a_sweep_are_estimated() {
    let row = |i: usize| format!("{:?}", (0..60).map(|j| if i == j { -1.0 } else { 0.0 }).collect::<Vec<_>>());
    let rows: Vec<String> = (0..60).map(row).collect();
    let text = format!(
        "[plant]\na = [{}]\nc = [{:?}]\n[[observer]]\nkind = \"luenberger\"\nlmi = true\n[simulation]\nx0 = {:?}\n\
         duration = 1e-4\nsamples = 2\n[sweep]\nensemble = 2\nvalues = [1, 2, 3]\nparameter = ",
        rows.join(","),
        vec![1.0; 60],
        vec![1.0; 60]
    );
    let design = 1890.0_f64.powi(3) * 1e-9;
    for (parameter, step, designs) in [
        ("poles", Step::Sweep, 4.0),
        ("poles", Step::Run, 4.0),
        ("initial", Step::Run, 1.0),
        ("poles", Step::Compare, 1.0),
    ] {
        let cost = estimate(&study(&format!("{text}\"{parameter}\"\n")), step, 1);
        assert!((cost.seconds / design - designs).abs() < 0.2, "{parameter}, {step:?}: {cost:?}");
        assert_eq!(cost.mostly, "designs");
    }
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
    let options = RunOptions { limits, output: Some(folder.clone().into()), threads: Some(1), ..RunOptions::default() };
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
