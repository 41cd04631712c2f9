//! Feedback from the estimate of an observer: gains, what is proved of the loop, and the run.

use std::path::Path;

use luenberger_proof::certificate::{Theorem, verify};
use luenberger_study::execute::Step;
use luenberger_study::{RunOptions, execute};

use crate::studies::{designed, read};

/// A cart, `x1' = x2`, `x2' = u`, with the position measured.
fn cart(feedback: &str, observer: &str) -> String {
    format!(
        "[plant]\na = [[0, 1], [0, 0]]\nb = [[0], [1]]\nc = [[1, 0]]\n[input]\nfeedback = {{ {feedback}, observer = \"o\" }}\n\
         [simulation]\nx0 = [1, 0]\nduration = 12\n[[observer]]\nname = \"o\"\n{observer}\n"
    )
}

fn gain(text: &str) -> Vec<f64> {
    let found = designed(&read(text).unwrap()).unwrap();
    found.report.matrices.iter().find(|m| m.name == "K").unwrap().rows.concat()
}

#[test]
fn the_gain_comes_from_poles_or_a_cost() {
    let linear = "kind = \"luenberger\"\npoles = [-4, -5]";
    let close = |found: Vec<f64>, expected: [f64; 2]| {
        assert!(found.iter().zip(expected).all(|(x, y)| (x - y).abs() < 1e-12), "{found:?}");
    };
    close(gain(&cart("k = [[1, 2]]", linear)), [1.0, 2.0]);
    // (s + 1)(s + 2).
    close(gain(&cart("poles = [-1, -2]", linear)), [2.0, 3.0]);
    // The double integrator with Q = I, R = 1: K = (1, sqrt 3), as of scipy's solve_continuous_are.
    close(gain(&cart("lqr = { q = 1, r = 1 }", linear)), [1.0, 3f64.sqrt()]);
    let wrong = |feedback: &str| read(&cart(feedback, linear)).unwrap_err().to_string();
    assert!(wrong("k = [[1]]").contains("`k` is 1 x 1"), "{}", wrong("k = [[1]]"));
    assert!(wrong("k = [[1, 2]], poles = [-1, -2]").contains("`poles` conflicts with `k`"));
    assert!(wrong("poles = [-1]").contains("expected 2 poles"), "{}", wrong("poles = [-1]"));
    assert!(wrong("poles = [1, -2]").contains("left half plane"));
    assert!(wrong("lqr = { q = 1, r = 0 }").contains("positive definite"), "{}", wrong("lqr = { q = 1, r = 0 }"));
    let none = cart("k = [[1, 2]]", linear).replace("k = [[1, 2]], ", "");
    assert!(read(&none).unwrap_err().to_string().contains("the feedback has no gain"));
    let text = cart("poles = [-1, -2]", linear).replace("b = [[0], [1]]", "b = [[1], [0]]");
    assert!(read(&text).unwrap_err().to_string().contains("poles"), "the velocity is not controllable");
}

#[test]
fn the_loop_is_proved_and_runs() {
    for (kind, theorem) in [
        ("kind = \"luenberger\"\npoles = [-4, -5]", "linear-observer"),
        ("kind = \"h-infinity\"\ne = [[0, 0], [1, 0]]\nd = [[0, 0.1]]", "linear-observer"),
        ("kind = \"cubic\"\npoles = [-4, -5]\ngamma = 2", "feedback-loop"),
    ] {
        let text = cart("lqr = { q = 1, r = 1 }", kind);
        let study = read(&text).unwrap();
        let found = designed(&study).unwrap();
        assert_eq!(found.report.verdict.word(), "proved");
        let said = &found.report.statement;
        assert!(said.contains("r = 0: x and xhat tend to 0 exponentially, from every x(0) and xhat(0)"), "{said}");
        let certificate = found.certificate.unwrap();
        assert_eq!(certificate.theorems().len(), 2);
        assert_eq!(certificate.theorems()[1].theorem().name(), theorem);
        if let Theorem::LinearConvergence(theorem) = certificate.theorems()[1].theorem() {
            assert_eq!(theorem.p.rows(), 4);
        }
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("loop-{}", kind.len()));
        let _ = std::fs::remove_dir_all(&folder);
        execute(&study, Step::Run, &RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() })
            .unwrap();
        let proved = verify(&std::fs::read(folder.join("certificates/o.feedback.json")).unwrap()).unwrap();
        assert!(proved.statement.contains("exponentially"), "{}", proved.statement);
        let csv = std::fs::read_to_string(folder.join("trajectories/o.csv")).unwrap();
        let last: Vec<f64> = csv.lines().last().unwrap().split(',').map(|x| x.parse().unwrap()).collect();
        assert!(last[1].abs() < 1e-2 && last[2].abs() < 1e-2, "{last:?}");
    }
}

#[test]
fn an_unstable_loop_is_said_to_be_one() {
    let found = designed(&read(&cart("k = [[-1, 2]]", "kind = \"luenberger\"\npoles = [-4, -5]")).unwrap()).unwrap();
    // The observer is proved all the same; the loop has the pole sqrt(2) - 1.
    assert_eq!(found.report.verdict.word(), "proved");
    let said = &found.report.statement;
    assert!(said.contains("is not proved: the largest real part of a pole of A - B K is 0.4142"), "{said}");
    assert_eq!(found.certificate.unwrap().theorems().len(), 1);
    // In discrete time: x+ = x + 0.1 u with K = 5 has the pole 0.5, with K = 25 the pole -1.5.
    let discrete = |k: f64| {
        let text = format!(
            "[plant]\na = [[1]]\nb = [[0.1]]\nc = [[1]]\ndt = 0.1\n[input]\nfeedback = {{ k = [[{k}]], observer = \"o\" }}\n\
             [[observer]]\nname = \"o\"\nkind = \"luenberger\"\npoles = [0.2]\n"
        );
        designed(&read(&text).unwrap()).unwrap()
    };
    assert!(discrete(5.0).report.statement.contains("tend to 0 exponentially, from every x(0) and xhat(0)"));
    assert_eq!(discrete(5.0).certificate.unwrap().theorems().len(), 2);
    assert!(discrete(25.0).report.statement.contains("the largest modulus of a pole of A - B K is 1.5"));
}
