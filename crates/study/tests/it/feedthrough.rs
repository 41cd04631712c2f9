//! Studies of plants whose output depends on the input: `d` beside the matrices, inputs in `h`.

use luenberger_study::Step;
use luenberger_study::results::StateReport;

use crate::studies::{executed, read};

const MATRICES: &str = r"
[plant]
a = [[0, 1], [-2, -0.5]]
b = [[0], [1]]
c = [[1, 0]]
d = [[0.5]]
";

const EXPRESSIONS: &str = r#"
[plant]
f = ["x2", "-2*x1 - 0.5*x2 + u1"]
h = ["x1 + u1/2"]
"#;

const OBSERVERS: &str = r#"
[input]
expressions = ["sin(2*t)"]
[simulation]
x0 = [1, -1]
duration = 20
hold = 0.01
[[observer]]
name = "poles"
kind = "luenberger"
poles = [-4, -5]
[[observer]]
name = "kalman"
kind = "kalman"
w = [[0.1, 0], [0, 1]]
v = [[0.2]]
[[observer]]
name = "cubic"
kind = "cubic"
poles = [-4, -5]
gamma = 2
[[observer]]
name = "sampled"
kind = "sampled-cubic"
poles = [-4, -5]
gamma = 1
period = 0.01
[[observer]]
name = "ekf"
kind = "extended-kalman"
w = [[0.1, 0], [0, 1]]
v = [[0.2]]
period = 0.01
[[observer]]
name = "lpv"
kind = "lpv"
decay_rate = 0.1
"#;

/// Every kind for such a plant finds the state, whether the plant is given by matrices or in text; the gains are those
/// of python-control 0.10.2 (`place`, `lqe`), which has no D in them.
#[test]
fn every_kind_for_a_linear_plant_takes_d() {
    for plant in [MATRICES, EXPRESSIONS] {
        let results = executed(&format!("{plant}{OBSERVERS}"), Step::Run);
        assert_eq!(results.failures(), Vec::<String>::new());
        assert!(results.plant.equations.contains(&"y = C x + D u".to_owned()), "{:?}", results.plant.equations);
        let d = results.plant.matrices.iter().find(|matrix| matrix.name == "D").unwrap();
        assert_eq!(d.rows, [[0.5]]);
        let gain = |name: &str| {
            let observer = results.observers.iter().find(|observer| observer.name == name).unwrap();
            let matrices = &observer.design.as_ref().unwrap().matrices;
            matrices.iter().find(|matrix| matrix.name == "L").unwrap().rows.clone()
        };
        for (name, expected) in
            [("poles", [8.5, 13.75]), ("kalman", [1.170785140823704, 0.435368922986791]), ("cubic", [8.5, 13.75])]
        {
            for (row, expected) in gain(name).iter().zip(expected) {
                assert!((row[0] - expected).abs() < 1e-12 * expected, "{name}: {row:?}");
            }
        }
        for run in &results.simulation.as_ref().unwrap().rows {
            let merits = run.merits.as_ref().unwrap_or_else(|| panic!("{run:?}"));
            assert!(merits.states.iter().all(|state| state.last.abs() < 2e-3), "{}: {merits:?}", run.observer);
        }
    }
}

/// The filter's own kind needs y = h(t, x, u) of a nonlinear plant, with the derivative at the input.
#[test]
fn a_nonlinear_output_may_use_the_input() {
    let text = r#"
[plant]
f = ["x2", "torque - 9.81*sin(x1) - 0.2*x2"]
h = ["sin(x1) + 0.5*torque*cos(x1)"]
inputs = ["torque"]
[input]
expressions = ["sin(3*t)"]
[simulation]
x0 = [0.6, -0.2]
duration = 5
hold = 0.02
[[observer]]
kind = "extended-kalman"
w = 0.01
v = 0.01
period = 0.02
"#;
    let results = executed(text, Step::Run);
    let merits = results.simulation.unwrap().rows[0].merits.clone().unwrap();
    let norm = |of: fn(&StateReport) -> f64| merits.states.iter().map(of).map(|x| x * x).sum::<f64>().sqrt();
    assert!(norm(|state| state.last) < 0.05 * norm(|state| state.initial), "{merits:?}");
}

/// What is proved over a region is proved over its inputs too: the slope of h by x1 is `1 + u1/2`, between 0.5 and 1.5.
#[test]
fn the_enclosure_of_an_output_is_over_the_inputs() {
    let text = r#"
[plant]
f = ["-x1"]
h = ["x1*(1 + u1/2)"]
[simulation]
x0 = [1]
duration = 1
[[observer]]
kind = "lpv"
decay_rate = 0.5
region = { states = [[-2, 2]], inputs = [[-1, 1]] }
"#;
    let results = executed(text, Step::Design);
    let design = results.observers[0].design.as_ref().unwrap_or_else(|| panic!("{:?}", results.observers[0]));
    assert_eq!(design.verdict.word(), "proved");
    let named =
        |wanted: &str| design.numbers.iter().find(|number| number.name == wanted).and_then(|number| number.value);
    assert_eq!(named("vertices"), Some(2.0), "{:?}", design.numbers);
}

/// The theory of these kinds excludes an output that depends on the input; they say so, and which output.
#[test]
fn kinds_without_feedthrough_refuse_it() {
    for kind in [
        "kind = \"high-gain\"\nr = 0.1\nchains = [2]",
        "kind = \"mean-value\"\nregion = { states = [[-2, 2], [-2, 2]] }",
        "kind = \"kkl-numerical\"\ndomain = [[-2, 2], [-2, 2]]\ncutoff = 1",
    ] {
        let text = format!(
            "[plant]\nf = [\"x2\", \"-sin(x1) + u1\"]\nh = [\"x1 + 0.1*u1\"]\noutputs = [\"angle\"]\n\
             [simulation]\nx0 = [1, 0]\nduration = 1\n[[observer]]\n{kind}\n"
        );
        let results = executed(&text, Step::Design);
        let failure = results.observers[0].failure.clone().unwrap_or_else(|| panic!("{kind} fits"));
        assert!(
            failure.hypothesis.contains("is for outputs of the state alone, y = h(t, x): angle depends on the input"),
            "{}",
            failure.hypothesis
        );
        assert!(!failure.alternatives.is_empty());
    }
}

#[test]
fn a_d_of_the_wrong_size_is_refused_where_it_stands() {
    let text = "[plant]\na = [[-1]]\nb = [[1]]\nc = [[1]]\nd = [[1, 2]]\n[simulation]\nx0 = [1]\nduration = 1\n";
    let error = read(text).unwrap_err().to_string();
    assert!(error.contains("`d` is 1 x 2") && error.contains("5:5") || error.contains("line 5"), "{error}");
}
