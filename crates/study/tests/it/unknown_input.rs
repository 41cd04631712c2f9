//! Unknown inputs that enter the outputs, and plants in discrete time.

use luenberger_study::deployment::sampled;
use luenberger_study::design::Designed;
use luenberger_study::execute::Step;
use luenberger_study::{RunOptions, execute};

use crate::studies::{designed, read, scratch};

/// x2 is moved and measured by what is not known: `x1' = x2, x2' = -2 x2 + d`, y1 = x1, y2 = x2 + d. By hand: d = y2 -
/// x2 leaves `x2' = -3 x2 + y2` and y1, whose gain for the poles -4 and -5 is (6, 2), so that J = [6 0; 2 1] and H = 0.
const ACCELERATED: &str = r#"[plant]
a = [[0, 1], [0, -2]]
c = [[1, 0], [0, 1]]
[simulation]
x0 = [1, -1]
duration = 6
[truth]
f = ["x2", "-2*x2 + 30*sin(50*t) + 3"]
h = ["x1", "x2 + 30*sin(50*t) + 3"]
[[observer]]
name = "o"
kind = "unknown-input"
e = [[0], [1]]
f = [[0], [1]]
poles = [-4, -5]
"#;

fn entries(found: &Designed, name: &str) -> Vec<f64> {
    found.report.matrices.iter().find(|m| m.name == name).unwrap_or_else(|| panic!("{name}")).rows.concat()
}

/// The rows of the trajectory of the observer "o", and its certificate verified.
fn rows(text: &str, folder: &str) -> Vec<Vec<f64>> {
    let (study, folder) = (read(text).unwrap(), scratch(folder));
    execute(&study, Step::Run, &RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() }).unwrap();
    luenberger_proof::certificate::verify(&std::fs::read(folder.join("certificates/o.json")).unwrap()).unwrap();
    let csv = std::fs::read_to_string(folder.join("trajectories/o.csv")).unwrap();
    csv.lines().skip(1).map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect()
}

#[test]
fn an_input_in_the_outputs_leaves_no_trace() {
    let study = read(ACCELERATED).unwrap();
    let found = designed(&study).unwrap();
    assert_eq!(found.report.verdict.word(), "proved");
    for (name, expected) in [("J", [6.0, 0.0, 2.0, 1.0]), ("H", [0.0; 4]), ("TA", [0.0, 1.0, 0.0, -2.0])] {
        let all = entries(&found, name);
        assert!(all.iter().zip(expected).all(|(x, y)| (x - y).abs() < 1e-12), "{name}: {all:?}");
    }
    // t, x1, x2, y1, y2 and the estimates: the error at the end is below exp(-24) times 40.
    let last = rows(ACCELERATED, "unknown-input-of-outputs").pop().unwrap();
    assert!((last[1] - last[5]).abs() < 1e-7 && (last[2] - last[6]).abs() < 1e-7, "{last:?}");
    sampled(&study, &study.observers[0], Some(0.01), None).unwrap();
}

/// One output that has d: no gain is left, and the poles are the zeros, those of A - E C = -2 - 1.
#[test]
fn with_as_many_outputs_as_inputs_the_poles_are_zeros() {
    let text = "[plant]\na = [[-2]]\nc = [[1]]\n[simulation]\nx0 = [1]\nduration = 2\n[truth]\nf = [\"-2*x1 + 5*cos(9*t)\"]\nh = [\"x1 + 5*cos(9*t)\"]\n\
        [[observer]]\nname = \"o\"\nkind = \"unknown-input\"\ne = [[1]]\nf = [[1]]\npoles = [-3]\n";
    let found = designed(&read(text).unwrap()).unwrap();
    assert!(found.report.statement.contains("The invariant zeros of (A, E, C, F) are among the poles"));
    let rows = rows(text, "unknown-input-of-one-output");
    let first = rows[0][1] - rows[0][3];
    for row in &rows {
        assert!((row[1] - row[3] - first * (-3.0 * row[0]).exp()).abs() < 1e-7, "{row:?}");
    }
    assert!((first - 1.0).abs() < 1e-12);
}

/// `x1+ = x2 + d, x2+ = x2/2`, y = x1: H = (1, 0), TA = [0 0; 0 1/2], the zero is 1/2. xhat1 has the measurement, and
/// the error of x2 is `2^-k`.
const OF_SAMPLES: &str = r#"[plant]
a = [[0, 1], [0, 0.5]]
c = [[1, 0]]
dt = 0.1
[simulation]
x0 = [1, 1]
duration = 1
[truth]
f = ["x2 + 100*sin(70*t) - 7", "0.5*x2"]
h = ["x1"]
[[observer]]
name = "o"
kind = "unknown-input"
e = [[1], [0]]
poles = [0.5, 0]
"#;

#[test]
fn an_unknown_input_leaves_no_trace_at_samples() {
    let found = designed(&read(OF_SAMPLES).unwrap()).unwrap();
    assert_eq!(found.report.verdict.word(), "proved");
    assert!(found.report.statement.contains("For every disturbance d(k)"), "{}", found.report.statement);
    for (name, expected) in [("H", vec![1.0, 0.0]), ("TA", vec![0.0, 0.0, 0.0, 0.5]), ("L", vec![0.0, 0.0])] {
        assert!(entries(&found, name).iter().zip(expected).all(|(x, y)| (x - y).abs() < 1e-13), "{name}");
    }
    for (sample, row) in rows(OF_SAMPLES, "unknown-input-of-samples").iter().enumerate() {
        let expected = 0.5f64.powi(i32::try_from(sample).unwrap());
        assert!((row[1] - row[4]).abs() < 1e-12 && (row[2] - row[5] - expected).abs() < 1e-12, "{row:?}");
    }
    let study = read(OF_SAMPLES).unwrap();
    sampled(&study, &study.observers[0], None, None).unwrap();
}

/// The plant of `ACCELERATED` with steps in the place of derivatives: `x1+ = x2, x2+ = -x2/4 + d`, y2 = x2 + d leaves
/// `x2+ = -5/4 x2 + y2`, and the gain of y1 for the poles 0.2 and 0.1 is l1 = -1.25 - 0.3, l2 = 0.02 - 1.25 l1.
#[test]
fn an_input_in_the_outputs_leaves_no_trace_at_samples() {
    let text = ACCELERATED
        .replace("[0, -2]]", "[0, -0.25]]\ndt = 0.1")
        .replace("-2*x2 +", "-0.25*x2 +")
        .replace("[-4, -5]", "[0.2, 0.1]")
        .replace("c = [[1, 0], [0, 1]]\n", "c = [[1, 0], [0, 1]]\nb = [[1], [2]]\nd = [[1], [-1]]\n")
        .replace("[simulation]", "[input]\nexpressions = [\"cos(t)\"]\n[simulation]")
        .replace("\"x2\", \"-0.25*x2 + 30", "\"x2 + u1\", \"-0.25*x2 + 2*u1 + 30")
        .replace("\"x1\", \"x2 + 30", "\"x1 + u1\", \"x2 - u1 + 30");
    let found = designed(&read(&text).unwrap()).unwrap();
    assert_eq!(found.report.verdict.word(), "proved");
    let (l1, j) = (-1.25 - 0.3, entries(&found, "J"));
    // s^2 + (l1 + 1.25) s + 1.25 l1 + l2 = s^2 - 0.3 s + 0.02.
    for (x, y) in j.iter().zip([l1, 0.0, 0.02 - 1.25 * l1, 1.0]) {
        assert!((x - y).abs() < 1e-12, "{j:?}");
    }
    let last = rows(&text, "unknown-input-of-outputs-and-samples").pop().unwrap();
    // t, x1, x2, u1, y1, y2 and the estimates, after 60 samples.
    assert!((last[1] - last[6]).abs() < 1e-9 && (last[2] - last[7]).abs() < 1e-9, "{last:?}");
}

#[test]
fn conditions_that_fail_are_named() {
    let why = |text: &str| match designed(&read(text).unwrap()) {
        Err(failure) => (failure.hypothesis.clone(), failure.advice().join("; ")),
        other => panic!("{other:?}"),
    };
    let (said, advice) = why(&ACCELERATED
        .replace("f = [[0], [1]]", "f = [[0], [1]]\ngamma = 1")
        .replace("poles = [-4, -5]", "lmi = true"));
    assert!(
        said.contains("the cubic term of an unknown-input observer") && advice.contains("without gamma"),
        "{said} {advice}"
    );
    // Two inputs that the outputs see as one.
    let (said, _) =
        why(&ACCELERATED.replace("e = [[0], [1]]\nf = [[0], [1]]", "e = [[0, 1], [1, 0]]\nf = [[0, 0], [1, 1]]"));
    assert!(said.contains("S = [C E, F1; F, 0] does not have full column rank"), "{said}");
    let (said, _) = why(&ACCELERATED
        .replace("a = [[0, 1], [0, -2]]", "a = [[0, 1], [0, 2]]")
        .replace("c = [[1, 0], [0, 1]]", "c = [[0, 0], [0, 1]]"));
    assert!(said.contains("(A, E, C, F) has the invariant zero"), "{said}");
    // a - e c = 1.5 - 0.25.
    let unstable = "[plant]\na = [[1.5]]\nc = [[1]]\ndt = 1\n[[observer]]\nkind = \"unknown-input\"\ne = [[0.25]]\nf = [[1]]\npoles = [0.5]\n";
    let (said, _) = why(unstable);
    assert!(said.contains("the invariant zero 1.25, which is not inside the unit circle"), "{said}");
    let (said, _) = why(&OF_SAMPLES.replace("[0.5, 0]", "[0.4, 0]"));
    assert!(said.contains("that no gain moves, 0.5"), "{said}");
    let (said, _) = why(&OF_SAMPLES.replace("e = [[1], [0]]", "e = [[0], [1]]"));
    assert!(said.contains("|C E d| = 0"), "{said}");
    let shape = read(&ACCELERATED.replace("f = [[0], [1]]", "f = [[1]]")).unwrap_err().to_string();
    assert!(shape.contains("`f` is 1 x 1"), "{shape}");
}

/// The gain of the pair that is left: of a Kalman filter, or by an inequality.
#[test]
fn the_gain_may_be_that_of_a_filter() {
    for text in [
        OF_SAMPLES.replace("poles = [0.5, 0]", "kalman = { w = 1, v = 1 }"),
        OF_SAMPLES.replace("poles = [0.5, 0]", "decay_rate = 1"),
        ACCELERATED.replace("poles = [-4, -5]", "kalman = { w = 1, v = 1 }"),
        ACCELERATED.replace("poles = [-4, -5]", "lmi = true"),
        ACCELERATED.replace("poles = [-4, -5]", "decay_rate = 1"),
    ] {
        assert_eq!(designed(&read(&text).unwrap()).unwrap().report.verdict.word(), "proved", "{text}");
    }
}
