//! Every message of a study in one reviewed file, `tests/golden/messages.txt`: mistakes, observers that do not apply,
//! warnings, runs that end early, designs and errors.
//!
//! The mistakes and refusals are those of the tests in `mistakes`, which are called here. Numbers may differ in their
//! digits on another machine and are not compared. Run with `UPDATE=1` in the environment after an intended change, and
//! read the difference.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use luenberger_design::numerical_kkl::NumericalKklError;
use luenberger_study::diagnostic::Located;
use luenberger_study::results::NoObserver;
use luenberger_study::table::Table;
use luenberger_study::{Excess, Format, Limits, RunOptions, Step, Study, StudyError, execute};

use crate::{composed, kkl_numerical, maps, mistakes, resets, varying_periods};

thread_local! {
    static MISTAKES: RefCell<BTreeSet<String>> = const { RefCell::new(BTreeSet::new()) };
    static MISFITS: RefCell<BTreeSet<String>> = const { RefCell::new(BTreeSet::new()) };
}

/// Notes a mistake that a test on this thread has found.
pub(crate) fn mistake(located: &Located) {
    let help = located.help.as_ref().map(|help| format!("    help: {help}\n")).unwrap_or_default();
    let text = format!("{}\n    {}\n{help}", located.message, located.expected);
    MISTAKES.with_borrow_mut(|seen| seen.insert(text));
}

/// Notes an observer that does not apply.
pub(crate) fn refusal(failure: &NoObserver) {
    let advice = failure.advice().iter().fold(String::new(), |lines, line| lines + "    " + line + "\n");
    MISFITS.with_borrow_mut(|seen| seen.insert(format!("{}\n{advice}", failure.hypothesis)));
}

/// Options without a limit of the time for alternatives: which of them are named does not depend on the machine.
pub(crate) fn all_alternatives() -> RunOptions<'static> {
    RunOptions::default().limits(Limits { alternatives: f64::INFINITY, ..Limits::default() })
}

fn folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("messages");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

const INTEGRATORS: &str = "[plant]\na = [[0, 1], [0, 0]]\nb = [[0], [1]]\nc = [[1, 0]]\n";
const PENDULUM: &str = "[plant]\nf = [\"x2\", \"-sin(x1)\"]\nh = [\"x1\"]\n";

/// Studies with something to say, each with its step.
fn studies() -> Vec<(&'static str, Step, String)> {
    let with = |plant: &str, rest: &str| format!("{plant}{rest}");
    let log =
        "t,y1,u1\n0,0,0\n1,1,0\n2,,0\n3,1.5,0\n4,1.25,0\n5,1,0\n60,1.125,0\n61,1,0\n62,1,0\n63,1,0\n64,1,0\n65,1,0\n";
    std::fs::write(folder().join("log.csv"), log).unwrap();
    let quick = "[[observer]]\nkind = \"luenberger\"\npoles = [-2, -5]\n";
    let simulated = "[simulation]\nx0 = [1, 1]\nduration = 2\nsamples = 5\n";
    vec![
        ("a linear plant", Step::Run, with(INTEGRATORS, &format!("{quick}{simulated}"))),
        (
            "all kinds for linear plants",
            Step::Design,
            with(
                INTEGRATORS,
                "[[observer]]\nname = \"rate\"\nkind = \"luenberger\"\ndecay_rate = 1\n[[observer]]\nkind = \"kalman\"\nw = 1\nv = 1\n\
                 [[observer]]\nkind = \"cubic\"\npoles = [-2, -5]\ngamma = 1\n\
                 [[observer]]\nkind = \"sampled-cubic\"\npoles = [-2, -5]\ngamma = 1\nperiod = 0.1\n\
                 [[observer]]\nkind = \"extended-kalman\"\nw = 1\nv = 1\nperiod = 0.1\n",
            ),
        ),
        (
            "a detectable plant",
            Step::Observe,
            "[plant]\na = [[-1, 0], [0, -2]]\nc = [[1, 0]]\n".to_owned(),
        ),
        ("a plant that is not detectable", Step::Observe, "[plant]\na = [[-1, 0], [0, 2]]\nc = [[1, 0]]\n".to_owned()),
        (
            "a weakly observable mode",
            Step::Run,
            with("[plant]\na = [[-1, 0], [0, -1.0000001]]\nc = [[1, 1]]\n", "[[observer]]\nkind = \"luenberger\"\nlmi = true\n"),
        ),
        (
            "a mode that is unobservable, and said to be only once",
            Step::Run,
            with("[plant]\na = [[1, 0], [0, -1]]\nc = [[0, 1]]\n", "[[observer]]\nkind = \"luenberger\"\npoles = [-1, -2]\n"),
        ),
        (
            "a covariance in the place of an intensity",
            Step::Compare,
            with(
                INTEGRATORS,
                &format!("[[observer]]\nkind = \"kalman\"\nw = 1\nv = 1e-4\n{simulated}noise = {{ distribution = \"gaussian\", amplitude = [0.01], period = 0.05 }}\n"),
            ),
        ),
        (
            "a filter without a hold",
            Step::Compare,
            with(
                INTEGRATORS,
                &format!("[input]\nexpressions = [\"sin(t)\"]\n[[observer]]\nkind = \"extended-kalman\"\nw = 1\nv = 1\nperiod = 0.1\n{simulated}"),
            ),
        ),
        (
            "gains of no use",
            Step::Compare,
            with(
                "[plant]\na = [[0, 1], [-2, -3]]\nc = [[1, 0]]\n",
                &format!(
                    "[[observer]]\nkind = \"luenberger\"\npoles = [-20000, -50000]\n{simulated}noise = {{ amplitude = [0.1], period = 0.01 }}\n"
                ),
            ),
        ),
        (
            "a run that leaves the region",
            Step::Compare,
            with(
                PENDULUM,
                &format!("[[observer]]\nkind = \"lpv\"\nregion = {{ states = [[-1.1, 1.1], [-0.5, 0.5]] }}\n{simulated}"),
            ),
        ),
        (
            "kinds for nonlinear plants",
            Step::Run,
            with(
                PENDULUM,
                &format!(
                    "[[observer]]\nkind = \"lpv\"\ndecay_rate = 0.5\n[[observer]]\nname = \"fastest\"\nkind = \"lpv\"\nfastest = 2\n\
                     [[observer]]\nkind = \"lipschitz\"\n[[observer]]\nkind = \"mean-value\"\n\
                     [[observer]]\nkind = \"high-gain\"\nr = 0.1\n{simulated}"
                ),
            ),
        ),
        (
            "a direction that no gain reaches",
            Step::Design,
            "[plant]\nf = [\"x1*x1\", \"-x2\"]\nh = [\"x2\"]\n[[observer]]\nkind = \"lpv\"\nregion = { states = [[1, 2], [-1, 1]] }\n".to_owned(),
        ),
        (
            "vertices in conflict",
            Step::Design,
            "[plant]\nf = [\"x2*sin(x1)\", \"0.1*x2\"]\nh = [\"x1\"]\n[[observer]]\nkind = \"lpv\"\nregion = { states = [[-2, 2], [-1, 1]] }\n".to_owned(),
        ),
        (
            "one gain in discrete time",
            Step::Design,
            "[plant]\nf = [\"x1 + 0.1*x2\", \"x2 - 0.1*sin(x1)\"]\nh = [\"x1\"]\ndt = 0.1\n".to_owned()
                + &["decay_rate = 1", "decay_rate = 0", "fastest = 20", "decay_rate = 1e3", "gain = [[0], [0]]"].map(|key| {
                    format!("[[observer]]\nname = \"{key}\"\nkind = \"lpv\"\n{key}\nregion = {{ states = [[-1, 1], [-5, 5]] }}\n")
                }).concat(),
        ),
        ("divergence", Step::Compare, with("[plant]\nf = [\"x1^3\"]\nh = [\"x1\"]\n", "[[observer]]\nkind = \"extended-kalman\"\nw = 1\nv = 1\nperiod = 0.1\n[simulation]\nx0 = [1]\nduration = 9\n")),
        ("a division by zero", Step::Compare, with("[plant]\nf = [\"-1/x1\"]\nh = [\"x1\"]\n", "[[observer]]\nkind = \"extended-kalman\"\nw = 1\nv = 1\nperiod = 0.1\n[simulation]\nx0 = [1]\nduration = 9\n")),
        ("outside of the domain", Step::Compare, with("[plant]\nf = [\"-1 - 0*sqrt(x1)\"]\nh = [\"x1\"]\n", "[[observer]]\nkind = \"extended-kalman\"\nw = 1\nv = 1\nperiod = 0.1\n[simulation]\nx0 = [1]\nduration = 9\n")),
        ("a log with a gap and a blank cell", Step::Compare, with(INTEGRATORS, &format!("{quick}[log]\nfile = \"log.csv\"\n"))),
        (
            "observers of a fixed period on a log",
            Step::Compare,
            with(INTEGRATORS, "[log]\nfile = \"log.csv\"\ninterpolation = \"linear\"\n")
                + &[("slow", 2.0), ("fast", 0.25), ("never", 1000.0)].map(|(name, period)| {
                    format!("[[observer]]\nname = \"{name}\"\nkind = \"sampled-cubic\"\npoles = [-0.2, -0.5]\ngamma = 0.1\nperiod = {period}\n")
                }).concat(),
        ),
        (
            "a filter on a log that rejects too much",
            Step::Compare,
            with(
                INTEGRATORS,
                "[log]\nfile = \"log.csv\"\nstates = [\"y1\", \"-\"]\n[[observer]]\nkind = \"extended-kalman\"\nw = 0\nv = 1e-6\np0 = 1e-6\nperiod = 1\ngate = 5\n",
            ),
        ),
        (
            "feedback of an observer without a design",
            Step::Compare,
            with(
                INTEGRATORS,
                &format!("[input]\nfeedback = {{ k = [[1, 1]], observer = \"bad\" }}\n{quick}[[observer]]\nname = \"bad\"\nkind = \"luenberger\"\ngain = [[-1], [0]]\n{simulated}"),
            ),
        ),
        (
            "a sweep",
            Step::Sweep,
            with(INTEGRATORS, &format!("{quick}{simulated}[sweep]\nparameter = \"poles\"\nvalues = [1, 2]\nensemble = 2\n")),
        ),
    ]
}

/// What the results of a study say, without the numbers of tables.
fn said(text: &str, step: Step) -> String {
    let study = match Study::from_text("study.toml", text, Format::Toml, &folder()) {
        Ok(study) => study,
        Err(error) => panic!("{error}\n{text}"),
    };
    let results = match execute(&study, step, &all_alternatives()) {
        Ok(results) => results,
        Err(error) => return format!("error: {error}\n"),
    };
    let mut said = String::new();
    for mode in results.observability.iter().flat_map(|report| &report.points).flat_map(|point| &point.hidden) {
        _ = writeln!(said, "unobservable: {}", mode.words);
    }
    if let Some(nonlinear) = results.observability.as_ref().and_then(|report| report.nonlinear.as_ref()) {
        _ = writeln!(said, "{}", nonlinear.words);
    }
    for observer in &results.observers {
        if let Some(design) = &observer.design {
            _ = writeln!(said, "{} ({}): {}\n  {}", observer.name, observer.kind, design.verdict, design.statement);
            let facts = design.facts.iter().map(|fact| format!("{}: {}", fact.statement, fact.words));
            for line in facts.chain(design.evidence.clone()) {
                _ = writeln!(said, "  {line}");
            }
        }
        if let Some(failure) = &observer.failure {
            _ = writeln!(said, "{} ({}): not applicable: {}", observer.name, observer.kind, failure.hypothesis);
            for line in failure.advice() {
                _ = writeln!(said, "  {line}");
            }
        }
    }
    let scorings =
        results.simulation.iter().map(|report| &report.scoring).chain(results.sweep.iter().map(|s| &s.scoring));
    for sentence in scorings.flat_map(|scoring| &scoring.words) {
        _ = writeln!(said, "{sentence}");
    }
    if let Some(log) = &results.log {
        _ = writeln!(said, "{}", luenberger_study::results::log_data(log, None));
    }
    for warning in &results.warnings {
        _ = writeln!(said, "warning: {warning}");
    }
    for failure in results.failures() {
        _ = writeln!(said, "failed: {failure}");
    }
    said
}

/// Mistakes of CSV files.
fn tables() -> Vec<String> {
    let texts = [
        "",
        "0,1\n1,2\n",
        "t,y,t\n",
        "t,y\n0,1\n1\n",
        "t,y\n0,1\n1,1,5\n",
        "t,y\n0,1.5V\n1,2\n",
        "t,y\n01.05.2024 12:00,1\n01.05.2024 12:01,2\n",
        "t;y\n0;1.5\n1;1,5\n",
        "t;y\n0;1,5\n1;1.5\n",
        "t,y\n0,\"1,500\"\n1,2\n",
        "t,y\n0,inf\n1,2\n",
        "t,y\n0,1\n,2\n",
        "t,y\n0,1\n",
        "t,y\n0,1\n0,2\n",
        "t,y\n1,1\n0,2\n",
        "time,y\n0,1\n1,2\n",
        "t,Y\n0,1\n1,2\n",
    ];
    let mistake = |text: &&str| {
        let log = Table::parse(text).and_then(|table| table.recording("t", &[], &["y"]));
        log.map_or_else(|error| error.to_string(), |_| panic!("{text}"))
    };
    let encoding = Table::from_bytes(b"t,T [\xb0C]\n").map_or_else(|error| error.to_string(), |_| panic!("encoding"));
    texts.iter().map(mistake).chain([encoding]).collect()
}

/// Errors that are hard to cause.
fn errors() -> Vec<String> {
    let path = PathBuf::from("results");
    let io = |kind| StudyError::Io { path: "results/report.html".into(), error: std::io::Error::from(kind) };
    let memory =
        Excess::Memory { needed: 24e9, limit: 4_294_967_296.0, mostly: "the trajectories (reduce simulation.samples)" };
    let time = Excess::Time { needed: 3e5, limit: 86400.0, mostly: "simulations".to_owned() };
    let studies = [
        io(std::io::ErrorKind::PermissionDenied),
        StudyError::NotAFolder { path: path.clone() },
        StudyError::ForeignFolder { path: path.clone() },
        StudyError::FolderInUse { path },
        StudyError::TooExpensive(memory),
        StudyError::TooExpensive(time),
        StudyError::TimeLimit { limit: 86400.0 },
        StudyError::Threads(4),
        StudyError::Interrupted,
    ];
    let fits = [
        NumericalKklError::Unresolved { error: 1.42, most: 0.2 },
        NumericalKklError::Uncontrollable { ratio: 1.2345e-20 },
        NumericalKklError::GridTooLarge { points: 1e9, most: 1_000_000, megabytes: 4e4, per_axis: 98 },
        NumericalKklError::Family { input: 0, lower: 1.0, upper: -1.0 },
        NumericalKklError::HeldInput {
            input: vec![0.5],
            error: Box::new(NumericalKklError::Unresolved { error: 0.5, most: 0.2 }),
        },
        NumericalKklError::NotFinite { from: vec![1.0, 2.0], time: 0.5 },
    ];
    studies.iter().map(ToString::to_string).chain(fits.iter().map(ToString::to_string)).collect()
}

/// The text with every number replaced by `#`.
fn without_numbers(text: &str) -> String {
    let mut kept = String::new();
    let mut inside = false;
    let mut before = ' ';
    for c in text.chars() {
        let starts = c.is_ascii_digit() && !before.is_alphanumeric() && before != '_';
        let goes_on = inside && (c.is_ascii_digit() || ".e-".contains(c));
        if starts && !inside {
            kept.push('#');
        }
        if !(starts || goes_on) {
            kept.push(c);
        }
        inside = starts || goes_on;
        before = c;
    }
    kept
}

#[test]
fn every_message_stands_in_the_reviewed_file() {
    for test in [
        mistakes::keys,
        mistakes::kinds_of_values,
        mistakes::dimensions,
        mistakes::what_joins_keys,
        mistakes::names_in_expressions,
        mistakes::expressions,
        mistakes::kinds_of_observers,
        mistakes::files_that_a_study_names,
        mistakes::grammar,
        mistakes::long_names,
        mistakes::scores,
        mistakes::swept_numbers,
        mistakes::truth,
        mistakes::other_plants,
        mistakes::an_observer_that_does_not_fit_says_which_hypothesis_fails_and_what_would_fit,
        maps::mistakes_in_maps_are_reported_at_their_place,
        resets::mistakes_in_resets_are_reported_at_their_place,
        kkl_numerical::bad_settings_are_reported_at_their_place,
        composed::mistakes_in_given_chains_are_reported_at_their_place,
        varying_periods::mistakes_in_the_sampling,
        maps::maps_that_are_wrong_are_refused_with_the_place,
    ] {
        test();
    }
    let mut text = "# Mistakes in a study\n\n".to_owned();
    MISTAKES.with_borrow(|seen| text.extend(seen.iter().map(String::as_str)));
    text.push_str("\n# Observers that do not apply\n\n");
    MISFITS.with_borrow(|seen| text.extend(seen.iter().map(String::as_str)));
    for (title, step, study) in studies() {
        _ = write!(text, "\n# {} of {title}\n\n{}", step.name(), said(&study, step));
    }
    text.push_str("\n# Mistakes in a CSV file\n\n");
    text.extend(tables().iter().flat_map(|error| [error, "\n"]));
    text.push_str("\n# Errors\n\n");
    text.extend(errors().iter().flat_map(|error| [error, "\n"]));
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/messages.txt");
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&path, &text).unwrap();
        return;
    }
    let golden = std::fs::read_to_string(path).unwrap();
    for (found, expected) in text.lines().zip(golden.lines()) {
        assert_eq!(without_numbers(found), without_numbers(expected), "run with UPDATE=1 and read the difference");
    }
    assert_eq!(text.lines().count(), golden.lines().count(), "run with UPDATE=1 and read the difference");
}

#[test]
fn numbers_are_left_out() {
    assert_eq!(without_numbers("x1 at t = 5.65e-3, [1, -2]: 3 % of a2"), "x1 at t = #, [#, -#]: # % of a2");
    assert_ne!(without_numbers("one"), without_numbers("two"));
}
