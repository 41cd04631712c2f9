//! Operating points in studies: linear observers of a nonlinear plant, in deviations.

use luenberger_study::Step;

use crate::studies::{executed, mistake};

/// The stirred reactor of Seborg, Edgar and Mellichamp, Process Dynamics and Control, 2nd ed. 2004, table 2.3.
const REACTOR: &str = include_str!("../studies/reactor.toml");

#[test]
fn linear_observers_of_a_reactor() {
    let results = executed(REACTOR, Step::Run);
    assert_eq!(results.failures(), Vec::<String>::new());
    let point = results.operating_point.as_ref().unwrap();
    // scipy 1.17.1, `fsolve`; numpy for A.
    assert!(
        (point.x[0] - 0.499_918_285_958_655_5).abs() < 1e-13 && (point.x[1] - 350.005_528_690_212_77).abs() < 1e-10
    );
    assert!((point.matrices[0].rows[1][0] - 209.273_412_048_449_16).abs() < 1e-9 && point.observable);
    let names: Vec<&str> = point.matrices.iter().map(|matrix| matrix.name.as_str()).collect();
    assert_eq!(names, ["A", "B", "C"]);
    // python-control 0.10.2, `lqe` of the linearisation.
    let kalman = results.observers[0].design.as_ref().unwrap();
    let l = kalman.matrices.iter().find(|matrix| matrix.name == "L").unwrap();
    for (row, expected) in l.rows.iter().zip([0.012_762_233_206_153_1, 10.256_829_447_477_552]) {
        assert!((row[0] / expected - 1.0).abs() < 1e-8, "{:?}", l.rows);
    }
    for observer in &results.observers {
        let design = observer.design.as_ref().unwrap();
        assert_eq!(design.verdict.word(), "proved", "{}", observer.name);
        assert!(design.statement.starts_with("Linearised at the operating point c = 0.49992, T = 350.01; Tc = 300."));
        assert!(
            design
                .statement
                .contains("The certificate is of the linearisation: nothing is proved of the nonlinear plant"),
            "{}",
            design.statement
        );
    }
    // The errors at the end of the nonlinear plant and of the observer in deviations, from the operating point: scipy,
    // `solve_ivp` (Radau, rtol 1e-12).
    let merits = results.simulation.as_ref().unwrap().rows[0].merits.clone().unwrap();
    for (state, expected) in merits.states.iter().zip([0.020_564_707_937_323_1, 1.703_891_840_046_196_5]) {
        assert!((state.last.abs() / expected - 1.0).abs() < 1e-5, "{state:?}, expected {expected}");
    }
    assert!(results.simulation.as_ref().unwrap().rows.iter().all(|row| row.merits.is_some()));
}

/// Without the table the same observers do not fit, and an affine plant is certified itself.
#[test]
fn the_table_is_what_linear_kinds_need() {
    let without = REACTOR.replace("[operating_point]\nx = [0.5, 349]\nu = [300]\n", "");
    let failure = executed(&without, Step::Design).observers[0].failure.clone().unwrap();
    assert!(failure.alternatives.iter().any(|instead| instead.words().contains("[operating_point]")), "{failure:?}");
    let affine = r#"[plant]
f = ["x2", "9.81 - 2*x1 - x2 + u1"]
h = ["x1 + 0.1*u1 - 1"]
[operating_point]
u = [1]
[input]
expressions = ["1 + sin(t)"]
[simulation]
x0 = [0, 0]
duration = 20
[[observer]]
kind = "luenberger"
poles = [-2, -3]
initial = [3, 3]
"#;
    let results = executed(affine, Step::Run);
    let design = results.observers[0].design.as_ref().unwrap();
    assert!(design.statement.contains("The plant is affine"), "{}", design.statement);
    let point = results.operating_point.as_ref().unwrap();
    assert!((point.x[0] - 5.405).abs() < 1e-14 && (point.y[0] - 4.505).abs() < 1e-14, "{point:?}");
    assert_eq!(
        point.matrices.last().map(|matrix| (matrix.name.as_str(), matrix.rows.clone())),
        Some(("D", vec![vec![0.1]]))
    );
    let merits = results.simulation.as_ref().unwrap().rows[0].merits.clone().unwrap();
    assert!(merits.states.iter().all(|state| state.last.abs() < 1e-8), "{merits:?}");
}

#[test]
fn mistakes_have_their_place() {
    for (old, new, line, message) in [
        ("u = [300]", "u = [300, 1]", 9, "`u` has length 2"),
        ("x = [0.5, 349]", "x = [0.5]", 8, "`x` has length 1"),
        ("x = [0.5, 349]", "x = [0.5, 0]", 8, "df/dx(1, 2) is NaN"),
        ("u = [300]", "v = [300]", 9, "`v` is not a key of [operating_point]"),
        ("\"1 - c", "\"1 - t - c", 7, "f1 depends on the time t"),
        ("h = [\"T\"]", "h = [\"T + t\"]", 7, "h1 depends on the time t"),
        ("\"1 - c - k0*exp(-8750/T)*c\"", "\"1 + c^2\"", 8, "no operating point was found"),
        ("\"1 - c - k0*exp(-8750/T)*c\"", "\"Tc - 299\"", 8, "df/dx is singular"),
    ] {
        let found = mistake(&REACTOR.replace(old, new));
        assert!(found.message.contains(message), "{new}: {found:?}");
        assert_eq!(found.line, line, "{new}: {found:?}");
    }
}

/// A pendulum x1' = x2, x2' = u - sin x1, held at x1 = pi/6 by u0 - K (xhat - x0): scipy 1.17.1, `solve_ivp` with
/// DOP853 and tolerances of 1e-12.
#[test]
fn feedback_is_of_the_deviations() {
    let text = r#"
[plant]
f = ["x2", "u1 - sin(x1)"]
h = ["x1"]
[operating_point]
x = [0.5, 0]
u = [0.5]
[input]
feedback = { k = [[2, 2]], observer = "at" }
[simulation]
x0 = [1, 0]
duration = 1.5
rtol = 1e-11
atol = 1e-12
[[observer]]
name = "at"
kind = "luenberger"
poles = [-4, -5]
initial = [0.5, 0]
"#;
    let results = executed(text, Step::Compare);
    let end = &results.simulation.unwrap().x_end;
    for (found, expected) in end.iter().zip([0.320_165_725_421_125_6, -0.067_803_574_915_426_24]) {
        assert!((found - expected).abs() < 1e-8, "{found} {expected}");
    }
}
