//! `[estimate]`: parameters of the plant that filters estimate as its last states.

use std::fmt::Write as _;
use std::path::Path;

use luenberger_study::study::Event;
use luenberger_study::tune::{TuneOptions, tune};
use luenberger_study::{Results, RunOptions, Step, Study, execute};

use crate::studies::{executed, filters, last_errors, mistakes, scratch, study, study_in};

/// Observers of all kinds that have a covariance, with the lists of `w`, `p0` and `initial` as they stand.
fn observers(w: &str, p0: &str, initial: &str, period: f64) -> String {
    let mut text = String::new();
    for kind in filters() {
        _ = write!(
            text,
            "[[observer]]\nkind = \"{kind}\"\nw = [{w}]\np0 = [{p0}]\ninitial = [{initial}]\nv = 0.01\nperiod = {period}\n"
        );
    }
    text
}

/// A mass on a spring with friction, driven, of which the stiffness k and the friction c are not known.
const SPRING: &str = "[plant]\nstates = [\"x\", \"v\"]\ninputs = [\"force\"]\noutputs = [\"position\"]\nf = [\"v\", \"force - k*x - c*v\"]\nh = [\"x\"]\nparameters = { k = 2, c = 0.3 }\nunits = [\"m\", \"m/s\"]\n[input]\nexpressions = [\"sin(1.3*t) + sin(0.4*t)\"]\n";
const OF_SPRING: &str = "[estimate]\nparameters = [\"k\", \"c\"]\np0 = [4, 0.25]\nw = [1e-4, 0]\n";

/// The same plant with the parameters as states that are written by hand.
const BY_HAND: &str = "[plant]\nstates = [\"x\", \"v\", \"k\", \"c\"]\ninputs = [\"force\"]\noutputs = [\"position\"]\nf = [\"v\", \"force - k*x - c*v\", \"0\", \"0\"]\nh = [\"x\"]\nunits = { x = \"m\", v = \"m/s\" }\n[input]\nexpressions = [\"sin(1.3*t) + sin(0.4*t)\"]\n";

fn simulation(x0: &str) -> String {
    format!("[simulation]\nx0 = [{x0}]\nduration = 20\nnoise = {{ amplitude = [0.1], period = 0.1, seed = 4 }}\n")
}

fn numbers(results: &Results) -> (Vec<serde_json::Value>, serde_json::Value) {
    let simulation = results.simulation.as_ref().unwrap();
    let rows = simulation.rows.iter().map(|row| serde_json::to_value(&row.merits).unwrap()).collect();
    (rows, serde_json::to_value(&results.filters).unwrap())
}

/// All scores, NIS and NEES are those of the plant that has the parameters as states by hand, to the last bit; in
/// discrete time too.
#[test]
fn parameters_are_the_states_that_one_writes_by_hand() {
    let with = |text: &str, table: &str, x0: &str, rest: &str| format!("{text}{table}{}{rest}", simulation(x0));
    let named = with(SPRING, OF_SPRING, "1, 0", &observers("0, 1e-3", "1, 1", "0, 0", 0.1));
    let by_hand =
        with(BY_HAND, "", "1, 0, 2, 0.3", &observers("0, 1e-3, 1e-4, 0", "1, 1, 4, 0.25", "0, 0, 2, 0.3", 0.1));
    let (named, by_hand) = (executed(&named, Step::Simulate), executed(&by_hand, Step::Simulate));
    assert_eq!(named.simulation.as_ref().unwrap().rows.len(), filters().len());
    assert_eq!(numbers(&named), numbers(&by_hand));
    assert_eq!(named.simulation.unwrap().x_end[2..], [2.0, 0.3]);

    let map = |plant: &str, table: &str, x0: &str, rest: &str| {
        format!("[plant]\n{plant}outputs = [\"y\"]\nh = [\"x^2\"]\ndt = 0.5\n{table}{}{rest}", simulation(x0))
    };
    let named = map(
        "states = [\"x\"]\nf = [\"a*x + 0.2*cos(t)\"]\nparameters = { a = 0.9 }\n",
        "[estimate]\nparameters = [\"a\"]\np0 = [0.04]\nw = [1e-6]\n",
        "1",
        &observers("1e-3", "0.1", "1.2", 0.5),
    );
    let by_hand = map(
        "states = [\"x\", \"a\"]\nf = [\"a*x + 0.2*cos(t)\", \"a\"]\n",
        "",
        "1, 0.9",
        &observers("1e-3, 1e-6", "0.1, 0.04", "1.2, 0.9", 0.5),
    );
    assert_eq!(numbers(&executed(&named, Step::Simulate)), numbers(&executed(&by_hand, Step::Simulate)));
}

/// The gain b of an input that is measured directly is the least-squares estimate
/// `(b0/p0 + sum u y/v)/(1/p0 + sum u^2/v)`, by every filter.
#[test]
fn a_parameter_of_an_output_is_estimated_by_least_squares() {
    let folder = scratch("parameters/least-squares");
    let (mut csv, mut sums) = ("t,u,y\n".to_owned(), (1.5 / 0.25, 1.0 / 0.25));
    for k in 0..40 {
        let (t, u) = (0.5 * f64::from(k), (0.7 * f64::from(k)).sin());
        let y = 2.3 * u + 0.1 * (11.3 * f64::from(k * k)).cos();
        sums = (sums.0 + u * y / 0.01, sums.1 + u * u / 0.01);
        _ = writeln!(csv, "{t},{u},{y}");
    }
    std::fs::write(folder.join("log.csv"), csv).unwrap();
    let text = format!(
        "[plant]\nstates = [\"x\"]\ninputs = [\"u\"]\noutputs = [\"y\"]\nf = [\"0\"]\nh = [\"x + b*u\"]\nparameters = {{ b = 1.5 }}\n[estimate]\nparameters = [\"b\"]\np0 = [0.25]\n[log]\nfile = \"log.csv\"\n{}",
        observers("0", "0", "0", 0.5)
    );
    let results = run(&folder, &text);
    let (expected, deviation) = (sums.0 / sums.1, (1.0 / sums.1).sqrt());
    for run in &results.runs {
        let (estimate, own) = (run.estimate.as_ref().unwrap(), run.deviation.as_ref().unwrap());
        let last = estimate.nrows() - 1;
        assert!((estimate[(last, 1)] - expected).abs() < 1e-12, "{}: {}", run.observer, estimate[(last, 1)]);
        assert!((own[(last, 1)] - deviation).abs() < 1e-12, "{}: {}", run.observer, own[(last, 1)]);
    }
    assert_eq!(results.runs.len(), filters().len());
    let table = std::fs::read_to_string(folder.join("out/trajectories/log-ukf.csv")).unwrap();
    assert!(table.lines().next().unwrap().contains("b_hat"), "{table}");
}

fn run(folder: &Path, text: &str) -> Results {
    let options = RunOptions { output: Some(folder.join("out").into()), ..RunOptions::default() };
    let results = execute(&study_in(folder, text), Step::Run, &options).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(results.failures(), Vec::<String>::new());
    results
}

/// The simulated plant has its own value, and an event changes it.
#[test]
fn the_simulated_plant_keeps_its_values() {
    let text = |truth: &str| {
        format!(
            "{SPRING}{OF_SPRING}{}{truth}{}",
            simulation("1, 0").replace("duration = 20", "duration = 60"),
            observers("0, 1e-6", "1, 1", "0, 0", 0.1)
        )
    };
    let other =
        "[truth]\nparameters = { k = 3.1 }\nprocess_noise = { amplitude = [0, 0.01], period = 0.1, seed = 3 }\n";
    let results = executed(&text(other), Step::Simulate);
    assert_eq!(results.simulation.as_ref().unwrap().x_end[2..], [3.1, 0.3]);
    for kind in filters() {
        // From 1.1 off.
        let error = last_errors(&results, kind)[2];
        assert!(error.abs() < 0.1, "{kind}: {error}");
    }
    let changed = format!(
        "{other}[[truth.event]]\nat = 20\nparameters = {{ k = 2.5 }}\n[[truth.event]]\nat = 30\njump = [0.1, 0]\n"
    );
    let of_events = study(&text(&changed));
    let jumps = |event: &Event| event.jump.clone();
    let jumps: Vec<Vec<f64>> = of_events.truth.as_ref().unwrap().events.iter().map(jumps).collect();
    assert_eq!(jumps, [vec![0.0, 0.0, 2.5 - 3.1, 0.0], vec![0.1, 0.0, 0.0, 0.0]]);
    let results = executed(&text(&changed), Step::Simulate);
    let end = &results.simulation.as_ref().unwrap().x_end;
    assert!((end[2] - 2.5).abs() < 1e-15 && end[3] == 0.3, "{end:?}");
    // Other equations have no states of the parameters.
    let equations = "[truth]\nf = [\"v\", \"force - stiff*x^3 - c*v\"]\nparameters = { stiff = 4, c = 0.2 }\n";
    let results = executed(&text(equations), Step::Simulate);
    assert_eq!(results.simulation.unwrap().x_end[2..], [2.0, 0.2]);
}

/// `tune` fits the random walk and the first variance of a parameter, and writes them where they are.
#[test]
fn variances_of_parameters_are_tuned() {
    let folder = scratch("parameters/tuned");
    // A gain that walks: b_(k+1) = b_k + 0.1 w.
    let mut random = luenberger_random::Random(3);
    let (mut csv, mut b) = ("t,u,y\n".to_owned(), 2.0);
    for k in 0..400 {
        let [first, second] = random.normal_pair();
        let u = 1.0 + (0.9 * f64::from(k)).sin();
        _ = writeln!(csv, "{k},{u},{}", b * u + 0.2 * first);
        b += 0.1 * second;
    }
    std::fs::write(folder.join("log.csv"), csv).unwrap();
    let plant = |states: &str, f: &str, rest: &str| {
        format!(
            "[plant]\nstates = [{states}]\ninputs = [\"u\"]\noutputs = [\"y\"]\nf = [{f}]\nh = [\"x + b*u\"]\ndt = 1\n{rest}[log]\nfile = \"log.csv\"\n"
        )
    };
    let observer = |w: &str, p0: &str, initial: &str| {
        format!(
            "[[observer]]\nkind = \"extended-kalman\"\nw = [{w}]\np0 = [{p0}]\ninitial = [{initial}]\nv = 0.04\nperiod = 1\n[tune]\nobserver = \"extended-kalman\"\nparameters = [\"w[b]\"]\nstarts = 1\nprofile = 0\n"
        )
    };
    let named = plant(
        "\"x\"",
        "\"x\"",
        "parameters = { b = 1 }\n[estimate]\nparameters = [\"b\"]\np0 = [4]\nw = [0.001] # walk\n",
    ) + &observer("0", "0", "0");
    let by_hand = plant("\"x\", \"b\"", "\"x\", \"b\"", "") + &observer("0, 0.001", "0, 4", "0, 1");
    let options = TuneOptions {
        run: RunOptions { output: Some(folder.join("out").into()), ..RunOptions::default() },
        ..TuneOptions::default()
    };
    let fit = |text: &str| tune(&study_in(&folder, text), &options).unwrap_or_else(|error| panic!("{error}"));
    let (found, expected) = (fit(&named), fit(&by_hand));
    // The true one is 0.01.
    let value = found.parameters[0].after;
    assert!(value > 0.006 && value < 0.016, "{value}");
    assert_eq!(value.to_bits(), expected.parameters[0].after.to_bits());
    assert_eq!(found.parameters[0].name, "w[b]");
    let text = found.study;
    let line = text.lines().find(|line| line.starts_with("w = [0.0")).unwrap();
    assert!(line.ends_with("# walk"), "{line}");
    let tuned = Study::from_text("tuned.toml", &text, luenberger_study::Format::Toml, &folder).unwrap();
    assert_eq!(tuned.estimated[0].w.to_bits(), value.to_bits());
}

#[test]
fn mistakes_of_the_table_are_named() {
    let said = |table: &str, rest: &str| {
        let text = format!("{SPRING}{table}{rest}");
        mistakes(&text).iter().map(|mistake| mistake.message.clone()).collect::<Vec<_>>().join("; ")
    };
    assert_eq!(said("[estimate]\nparameters = [\"m\"]\np0 = [1]\n", ""), "there is no parameter named \"m\"");
    assert_eq!(said("[estimate]\nparameters = [\"k\", \"k\"]\np0 = [1, 1]\n", ""), "`k` is named twice");
    let lengths = said("[estimate]\nparameters = [\"k\"]\np0 = [1, 1]\nw = [0, 0]\n", "");
    assert_eq!(lengths, "`p0` has length 2, and 1 parameter is named; `w` has length 2, and 1 parameter is named");
    let point = said(OF_SPRING, "[operating_point]\nu = [0]\n");
    assert!(point.starts_with("[operating_point] conflicts with [estimate]: with a parameter as a state"), "{point}");
    let kind = said(OF_SPRING, "[[observer]]\nkind = \"high-gain\"\nr = 0.1\n");
    assert_eq!(kind, "the kind high-gain does not estimate the parameters of [estimate]: k, c");
    let numbers = said(OF_SPRING, "[[observer]]\nkind = \"ukf\"\nv = 1\nw = [1, 1, 1, 1]\nperiod = 1\n");
    assert_eq!(numbers, "the diagonal `w` has length 4");
    let derived = |parameters: &str| {
        let plant = SPRING.replace("{ k = 2, c = 0.3 }", parameters);
        mistakes(&format!("{plant}{OF_SPRING}")).swap_remove(0).message
    };
    assert_eq!(
        derived("{ k = 2, c = 0.3, half = \"k/2\" }"),
        "the parameter `half` is an expression of `k`, which would be a state"
    );
    let unused = mistakes(&format!("{}{OF_SPRING}", SPRING.replace(" - c*v", ""))).swap_remove(0).message;
    assert_eq!(unused, "no row of f or h has the parameter `c`");
    let matrices = "[plant]\na = [[1]]\nc = [[1]]\n[estimate]\nparameters = [\"k\"]\np0 = [1]\n";
    assert!(mistakes(matrices)[0].message.starts_with("[estimate] is for plants of expressions"));
}
