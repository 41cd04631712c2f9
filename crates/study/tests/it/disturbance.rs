//! Disturbances in studies: bounds of the error, proportional-integral and unknown-input observers.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use luenberger_proof::certificate::{DeployedObserver, Theorem};
use luenberger_proof::statement::Format::Binary32 as Format32;
use luenberger_study::deployment::{evidence, sampled};
use luenberger_study::design::{Designed, NoObserver, design};
use luenberger_study::execute::Step;
use luenberger_study::study::ObserverSpec;
use luenberger_study::{RunOptions, Study, StudyError, execute};

use crate::studies::{read, scratch};

fn designed(study: &Study, name: &str) -> Result<Designed, NoObserver> {
    let observer = study.observer(name).expect("an observer of that name");
    design(study, observer, &AtomicBool::new(false))
}

const CARTS: &str = r#"[plant]
a = [[0, 1], [0, 0]]
b = [[0], [1]]
c = [[1, 0]]
states = ["position", "velocity"]
[simulation]
x0 = [1, 0]
duration = 12
noise = { distribution = "uniform", amplitude = [0.01], period = 0.01 }
[truth]
f = ["velocity", "u1 - 0.5"]
h = ["position"]
"#;

/// The last row of the run of an observer, whose name is that of its folder too: time, states, inputs, outputs,
/// estimates, and those of the disturbance behind them.
fn last_row(text: &str, observer: &str) -> Vec<f64> {
    let folder = scratch(&format!("disturbance/{observer}"));
    let study = read(text).unwrap();
    execute(&study, Step::Run, &RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() }).unwrap();
    let csv = std::fs::read_to_string(folder.join(format!("trajectories/{observer}.csv"))).unwrap();
    csv.lines().last().unwrap().split(',').map(|x| x.parse().unwrap()).collect()
}

#[test]
fn a_constant_force_is_estimated_and_bounded() {
    let text = format!(
        "{CARTS}[[observer]]\nname = \"pi\"\nkind = \"proportional-integral\"\ne = [[0], [1]]\npoles = [-2, -3, -4]\nrate = [0.1]\nbounds = {{ }}\n\
         [[observer]]\nname = \"cubic\"\nkind = \"proportional-integral\"\ne = [[0], [1]]\npoles = [-2, -3, -4]\ngamma = 2\nrate = [0.1]\nbounds = {{ }}\n"
    );
    let study = read(&text).unwrap();
    for name in ["pi", "cubic"] {
        let found = designed(&study, name).unwrap();
        assert_eq!(found.report.verdict.word(), "proved");
        let bound = |of: &str| found.report.number(&format!("bound of the error of {of}")).unwrap();
        // L by hand: (s + 2)(s + 3)(s + 4) = s^3 + 9 s^2 + 26 s + 24.
        let l = &found.report.matrices.iter().find(|m| m.name == "L").unwrap().rows;
        for (row, expected) in l.iter().zip([9.0, 26.0, 24.0]) {
            assert!((row[0] - expected).abs() < 1e-9, "{l:?}");
        }
        // t, position, velocity, u1, y1, estimates of position, velocity and force.
        let row = last_row(&text, name);
        assert_eq!(row.len(), 8);
        assert!((row[7] + 0.5).abs() < bound("d1"), "{row:?}");
        assert!((row[2] - row[6]).abs() < bound("velocity") && (row[1] - row[5]).abs() < bound("position"));
        // A ramp of slope 0.1 leaves the error 0.1 (1/24) in the position, 9/24 and 26/24 in the others.
        assert!(bound("d1") > 0.1 * 26.0 / 24.0 && bound("d1") < 0.5, "{}", bound("d1"));
    }
}

#[test]
fn an_unknown_input_leaves_no_trace() {
    let text = "[plant]\na = [[0, 1], [-1, -2]]\nc = [[1, 0]]\n[simulation]\nx0 = [1, -1]\nduration = 12\n\
        [truth]\nf = [\"x2 + 30*sin(50*t) + 3\", \"-x1 - 2*x2\"]\nh = [\"x1\"]\n\
        [[observer]]\nname = \"ui\"\nkind = \"unknown-input\"\ne = [[1], [0]]\npoles = [-2, -3]\n\
        [[observer]]\nname = \"ui3\"\nkind = \"unknown-input\"\ne = [[1], [0]]\nlmi = true\ngamma = 2\n";
    let study = read(text).unwrap();
    for name in ["ui", "ui3"] {
        let found = designed(&study, name).unwrap();
        assert_eq!(found.report.verdict.word(), "proved");
        assert!(found.report.statement.contains("The invariant zeros of (A, E, C) are among the poles"));
        let row = last_row(text, name);
        assert!((row[1] - row[4]).abs() < 1e-6 && (row[2] - row[5]).abs() < 1e-6, "{row:?}");
    }
}

#[test]
fn a_bound_of_the_error_is_a_second_theorem() {
    let text = format!(
        "{CARTS}[[observer]]\nname = \"l\"\nkind = \"luenberger\"\npoles = [-2, -3]\nbounds = {{ disturbance = [0.5], e = [[0], [1]] }}\n\
         [[observer]]\nname = \"c\"\nkind = \"cubic\"\npoles = [-2, -3]\ngamma = 1\nbounds = {{ disturbance = [0.5], e = [[0], [1]] }}\n"
    );
    let study = read(&text).unwrap();
    for name in ["l", "c"] {
        let found = designed(&study, name).unwrap();
        let theorems: Vec<&str> =
            found.certificate.as_ref().unwrap().theorems().iter().map(|proved| proved.theorem().name()).collect();
        let first = if name == "l" { "linear-observer" } else { "cubic-observer" };
        assert_eq!(theorems, [first, "input-to-state-stability"]);
        // The force of 0.5 alone leaves 0.5/6 in the position and 0.5 5/6 in the velocity.
        let bound = |of: &str| found.report.number(&format!("bound of the error of {of}")).unwrap();
        assert!(bound("position") > 0.5 / 6.0 && bound("velocity") > 0.5 * 5.0 / 6.0);
        let row = last_row(&text, name);
        assert!((row[1] - row[5]).abs() < bound("position") && (row[2] - row[6]).abs() < bound("velocity"));
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("disturbance").join(name);
        let file = std::fs::read(folder.join(format!("certificates/{name}.bounds.json"))).unwrap();
        let proved = luenberger_proof::certificate::verify(&file).unwrap();
        assert!(proved.statement.contains("limsup |e_1| <= "), "{}", proved.statement);
    }
}

#[test]
fn conditions_that_fail_are_named() {
    let why = |kind: &str, e: &str, rest: &str| {
        let text = format!("{CARTS}[[observer]]\nname = \"o\"\nkind = \"{kind}\"\ne = {e}\n{rest}\n");
        match designed(&read(&text).unwrap(), "o") {
            Err(failure) => (failure.hypothesis.clone(), failure.advice().join("; ")),
            other => panic!("{other:?}"),
        }
    };
    let (why_not, instead) = why("proportional-integral", "[[1], [0]]", "lmi = true");
    assert!(why_not.starts_with("no output sees the constant disturbance d = ("), "{why_not}");
    assert!(instead.contains("an output that depends on this state"), "{instead}");
    let (why_not, _) = why("proportional-integral", "[[0], [0]]", "lmi = true");
    assert!(why_not.starts_with("the disturbance d = (1) does not act: E d = 0, so that [A E; C 0]"), "{why_not}");
    assert!(!why_not.contains("invariant zero"), "{why_not}");
    // A state at rest that no output sees, whatever the disturbance.
    let hidden = "[plant]\na = [[-1, 0], [0, 0]]\nc = [[1, 0]]\n[[observer]]\nname = \"o\"\nkind = \"proportional-integral\"\ne = [[1], [0]]\nlmi = true\n";
    let Err(failure) = designed(&read(hidden).unwrap(), "o") else { panic!("a hidden state") };
    let why_not = failure.hypothesis;
    assert!(why_not.contains("no output sees the state x = (0, "), "{why_not}");
    assert!(why_not.contains("at rest: A x = 0 and C x = 0"), "{why_not}");
    let (why_not, instead) = why("unknown-input", "[[0], [1]]", "lmi = true");
    assert!(why_not.contains("|E d| = 1 and |C E d| = 0"), "{why_not}");
    assert!(instead.contains("proportional-integral"), "{instead}");
    let (why_not, _) = why("unknown-input", "[[1], [-1]]", "lmi = true");
    assert!(why_not.contains("has the invariant zero 1"), "{why_not}");
    let (why_not, instead) = why("unknown-input", "[[1], [1]]", "poles = [-2, -3]");
    assert!(why_not.contains("the invariant zeros of (A, E, C) that no gain moves, -1,"), "{why_not}");
    assert!(instead.contains("`poles` with these zeros"), "{instead}");
}

#[test]
fn mistakes_are_named() {
    let mistake = |observer: &str, expected: &str| {
        let text = format!("{CARTS}[[observer]]\n{observer}\n");
        let found = read(&text).unwrap_err().to_string();
        assert!(found.contains(expected), "{found}");
    };
    let linear = "kind = \"luenberger\"\npoles = [-2, -3]\n";
    mistake(&format!("{linear}bounds = {{ noise = [0.1, 0.2] }}"), "`noise` has length 2, and the plant has 1 output");
    mistake(&format!("{linear}bounds = {{ noise = [0] }}"), "all bounds are 0");
    mistake(&format!("{linear}bounds = {{ disturbance = [1] }}"), "`e` does not say how it enters");
    mistake(&format!("{linear}bounds = {{ disturbance = [1], e = [[1]] }}"), "`e` is 1 x 1");
    mistake(&format!("{linear}bounds = {{ noise = [-1] }}"), "-1");
    let integral = "kind = \"proportional-integral\"\ne = [[0], [1]]\n";
    mistake(
        &format!("{integral}poles = [-2, -3]"),
        "`poles` has length 2, and the plant has 2 states and 1 disturbance",
    );
    mistake(&format!("{integral}lmi = true\nrate = [1, 2]"), "`rate` has length 2, and `e` has 1 column");
    mistake(&format!("{integral}lmi = true\nrate = [1]"), "`rate` has no effect without `bounds`");
    mistake(&format!("{integral}lmi = true\ntheta = 2"), "`theta` has no effect without a cubic term");
    mistake("kind = \"unknown-input\"\nlmi = true", "`e`");
    let text = "[plant]\na = [[0.5]]\nc = [[1]]\ndt = 0.1\n[[observer]]\nkind = \"luenberger\"\npoles = [0.1]\nbounds = { noise = [1], states = [1], m = [[1]], h = [[0.1]] }\n";
    assert!(read(text).unwrap_err().to_string().contains("`states` is for plants in continuous time"));
}

const PENDULUM: &str = r#"[plant]
a = [[0, 1], [-4, -0.2]]
b = [[0], [1]]
c = [[1, 0]]
[[observer]]
name = "linear"
kind = "luenberger"
poles = [-4, -5]
bounds = { noise = [0.01], states = [1, 2], deviations = [{ a = [[0, 0], [-0.4, 0]] }, { a = [[0, 0], [0.4, 0]] }] }
[[observer]]
name = "cubic"
kind = "cubic"
poles = [-4, -5]
gamma = 2
bounds = { states = [1, 2], m = [[0], [0.4]], h = [[1, 0]] }
"#;

/// The stiffness is known to 10 %. A constant x1 = 1 leaves 0.4/20 of x1 in e1, as the steady state of e' = Fe + Delta
/// x says: no bound is below that.
#[test]
fn an_uncertain_plant_has_a_bound_while_its_states_have() {
    let study = read(PENDULUM).unwrap();
    // P of the cubic observer has the structure that its N asks for, which costs a factor here.
    for (name, most) in [("linear", 0.05), ("cubic", 0.08)] {
        let found = designed(&study, name).unwrap();
        assert_eq!(found.report.verdict.word(), "proved", "{name}");
        let bound = found.report.number("bound of the error of x1").unwrap();
        assert!((0.02..most).contains(&bound), "{name}: {bound}");
        let words = &found.report.statement;
        assert!(words.contains("for every deviation of A and while the states keep theirs"), "{words}");
    }
}

/// With the deviations the exported step has a larger bound, for the same simulation; both are certificates.
#[test]
fn the_rounding_of_an_exported_step_is_bounded_for_an_uncertain_plant() {
    let run = "[simulation]\nx0 = [0.5, 0]\nduration = 5\nhold = 0.01\n\
        noise = { distribution = \"uniform\", amplitude = [0.001], period = 0.01 }\n";
    let study = read(&format!("{PENDULUM}{run}")).unwrap();
    for observer in &study.observers {
        let exactly = ObserverSpec { bounds: None, ..observer.clone() };
        let [with, without] = [observer, &exactly].map(|observer| {
            let design = sampled(&study, observer, Some(0.01), None).unwrap().design;
            let found = evidence(&study, observer, &design, Format32.into());
            let Theorem::DeployedObserver(theorem) = found.file.unwrap().theorem().clone() else { panic!("theorem") };
            (found.sentences.join(" "), theorem)
        });
        let said = "every deviation of A within `bounds`";
        assert!(with.0.contains(said) && !without.0.contains(said), "{}", with.0);
        // The states keep the larger of the bounds of the run and of the study.
        assert!(with.1.operation.state[0] >= 1.0 && with.1.operation.state[1] >= 2.0);
        assert!(with.1.operation.deviation.is_some() && without.1.operation.deviation.is_none());
        let entry = |of: &(String, DeployedObserver)| of.1.ball.as_ref().unwrap().entries[0];
        // A constant x1 = 1 leaves 0.4/20 of x1 in e1, sampled as well. The ball of a cubic observer is coarse.
        let is_near = observer.name == "cubic" || (entry(&with) < 0.1 && entry(&without) < 0.01);
        assert!(
            is_near && entry(&with) > 0.02 && entry(&with) > entry(&without),
            "{}: {} {}",
            observer.name,
            entry(&with),
            entry(&without)
        );
    }
}

#[test]
fn mistakes_in_the_deviations_are_found_where_they_are() {
    for (from, to, line, message) in [
        ("states = [1, 2], dev", "dev", 9, "`deviations` without bounds of the states"),
        ("states = [1, 2], dev", "states = [1], dev", 9, "`states` has length 1"),
        ("states = [1, 2], dev", "states = [0, 0], dev", 9, "all bounds of the states are 0"),
        ("[{ a = [[0, 0], [-0.4, 0]] }, { a = [[0, 0], [0.4, 0]] }]", "[]", 9, "`deviations` is empty"),
        ("[[0, 0], [-0.4, 0]]", "[[0, 0]]", 9, "`a`"),
        ("m = [[0], [0.4]], ", "", 15, "how the plant deviates"),
        ("h = [[1, 0]]", "h = [[1]]", 15, "`h`"),
        ("h = [[1, 0]]", "h = [[1, 0]], deviations = [{ a = [[0, 0], [1, 0]] }]", 15, "how the plant deviates"),
    ] {
        let text = PENDULUM.replacen(from, to, 1);
        assert_ne!(text, PENDULUM, "{from}");
        let Err(StudyError::File(diagnostics)) = read(&text) else { panic!("no mistake in {to}") };
        let found = diagnostics.located()[0].clone();
        assert!(found.line == line && found.message.contains(message), "{to}: {found:?}");
    }
}

/// A servo `x1' = x2`, `x2' = -x2 + u + d` with d = 1 + 2 t, of which nobody knows.
const SERVO: &str = r#"[plant]
a = [[0, 1], [0, -1]]
b = [[0], [1]]
c = [[1, 0]]
[simulation]
x0 = [1, 0]
duration = 6
hold = 0.01
[truth]
f = ["x2", "-x2 + u1 + 1 + 2*t"]
h = ["x1"]
"#;

#[test]
fn a_ramp_is_estimated_by_a_chain_of_two_integrators() {
    let observer = |order: usize, rest: &str| {
        format!(
            "[[observer]]\nname = \"e{order}\"\nkind = \"extended-state\"\ne = [[0], [1]]\norder = {order}\n{rest}\n"
        )
    };
    let text = format!(
        "{SERVO}{}{}",
        observer(1, "bandwidth = 8\nrate = [2]\nbounds = { noise = [1e-6] }"),
        observer(2, "bandwidth = 8")
    );
    let study = read(&text).unwrap();
    for (name, gain) in [("e1", vec![23.0, 169.0, 512.0]), ("e2", vec![31.0, 353.0, 2048.0, 4096.0])] {
        let found = designed(&study, name).unwrap();
        assert_eq!(found.report.verdict.word(), "proved");
        // By hand: (s + 8)^n against the chain with the pole of the servo.
        let l = &found.report.matrices.iter().find(|m| m.name == "L").unwrap().rows;
        for (row, expected) in l.iter().zip(gain) {
            assert!((row[0] - expected).abs() < 1e-6 * expected, "{l:?}");
        }
    }
    // t, x1, x2, u1, y1, estimates of x1 and x2, then those of d and its derivative.
    let row = last_row(&text, "e1");
    assert_eq!(row.len(), 8);
    // The lag of an integrator behind a ramp of slope 2: 2 (l2 + l1 a22)/l3 with L above.
    let bound = designed(&study, "e1").unwrap().report.number("bound of the error of d1").unwrap();
    let lag = 13.0 - row[7];
    assert!(lag > 0.5 && lag < bound && bound < 1.0, "{lag} and {bound}");
    let row = last_row(&text, "e2");
    assert_eq!(row.len(), 9);
    assert!((row[7] - 13.0).abs() < 1e-6 && (row[8] - 2.0).abs() < 1e-6, "{row:?}");
    assert!((row[1] - row[5]).abs() < 1e-8 && (row[2] - row[6]).abs() < 1e-8, "{row:?}");
}

#[test]
fn the_columns_of_an_extended_state_are_named() {
    let text = format!(
        "{SERVO}[[observer]]\nname = \"e3\"\nkind = \"extended-state\"\ne = [[0], [1]]\norder = 3\nbandwidth = 5\n"
    );
    let names = read(&text).unwrap().observers[0].kind.estimated_disturbances();
    assert_eq!(names, ["d1", "d1_rate", "d1_rate2"]);
    let two = "[plant]\na = [[0, 0], [0, 0]]\nc = [[1, 0], [0, 1]]\n[[observer]]\nkind = \"extended-state\"\ne = [[1, 0], [0, 1]]\norder = 2\nbandwidth = 5\n";
    let study = read(two).unwrap();
    assert_eq!(study.observers[0].kind.estimated_disturbances(), ["d1", "d2", "d1_rate", "d2_rate"]);
    // Two outputs: six poles, two and two of them equal, with the geometric mean 5.
    let found = designed(&study, "extended-state").unwrap();
    let product: f64 = found.report.poles.iter().map(|pole| pole[0].hypot(pole[1])).product();
    assert_eq!(found.report.poles.len(), 6);
    assert!((product / 5f64.powi(6) - 1.0).abs() < 1e-6 && found.report.verdict.word() == "proved");
}

#[test]
fn an_extended_state_that_no_output_sees_is_named() {
    // The zero at 0 from d to y: y = x2 is the derivative of x1, on which a constant force leaves no trace.
    let text = "[plant]\na = [[0, 1], [-4, -1]]\nc = [[0, 1]]\n[[observer]]\nname = \"o\"\nkind = \"extended-state\"\ne = [[0], [1]]\nbandwidth = 5\n";
    match designed(&read(text).unwrap(), "o") {
        Err(failure) => {
            let said = &failure.hypothesis;
            assert!(said.contains("d = (1)") && said.contains("x = (0.25, 0)"), "{said}");
            assert!(said.contains("an invariant zero of (A, E, C) at 0"), "{said}");
        }
        other => panic!("{other:?}"),
    }
    let wrong = |rest: &str| {
        let text = format!("{SERVO}[[observer]]\nkind = \"extended-state\"\ne = [[0], [1]]\n{rest}\n");
        read(&text).unwrap_err().to_string()
    };
    assert!(wrong("bandwidth = 0").contains("bandwidth"), "{}", wrong("bandwidth = 0"));
    assert!(wrong("order = 0\nbandwidth = 5").contains("order"));
    assert!(wrong("order = 17\nbandwidth = 5").contains("expected at most 16"));
    assert!(wrong("order = 2").contains("expected one of bandwidth, poles"), "{}", wrong("order = 2"));
    assert!(wrong("bandwidth = 5\npoles = [-1, -2, -3]").contains("conflicts"));
    let few = wrong("order = 2\npoles = [-1, -2, -3]");
    assert!(few.contains("2 states and 1 disturbance with 1 derivative to be estimated"), "{few}");
}
