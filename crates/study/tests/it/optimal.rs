//! The kind optimal-cubic: its numbers, its certificates, its export, its mistakes.

use std::sync::atomic::AtomicBool;

use luenberger_design::EstimationProblem;
use luenberger_observers::{CubicObserver, LinearObserver};
use luenberger_study::Study;
use luenberger_study::deployment::{SampledDesign, sampled};
use luenberger_study::design::{Designed, design};
use luenberger_study::kinds::OptimalCubic;
use nalgebra::Dyn;

use crate::studies::read;

const SCALAR: &str = "[plant]\na = [[0]]\nc = [[1]]\n[[observer]]\nname = \"o\"\nkind = \"optimal-cubic\"\n";

fn designed(text: &str) -> (Study, Designed) {
    let study = read(text).unwrap();
    let found = design(&study, &study.observers[0], &AtomicBool::new(false)).unwrap();
    (study, found)
}

#[test]
fn the_report_has_both_costs_and_the_certificates_both_theorems() {
    let text = format!(
        "{SCALAR}first_errors = [1]\nhorizon = 20\nnoise_deviation = [0.1]\nnoise_period = 0.05\nbounds = {{ noise = [0.3] }}\n"
    );
    let (study, found) = designed(&text);
    assert_eq!(found.report.verdict.word(), "proved");
    let number = |name: &str| found.report.number(name).unwrap();
    let saving = 1.0 - number("cost J") / number("cost J of the linear optimum");
    assert!(saving > 0.1 && number("cost J of the Kalman gain") >= number("cost J of the linear optimum"));
    assert!((number("cost J: first errors") + number("cost J: noise") - number("cost J")).abs() < 1e-12);
    assert!(found.report.statement.starts_with("Its cost J is "), "{}", found.report.statement);
    let theorems: Vec<&str> =
        found.certificate.as_ref().unwrap().theorems().iter().map(|proved| proved.theorem().name()).collect();
    assert_eq!(theorems, ["cubic-observer", "input-to-state-stability"]);
    let observer = found.runnable.of::<CubicObserver<f64, Dyn, Dyn, Dyn>>().unwrap();
    // x' = 0, y = x: the export at 0.05 keeps the pole of L and the direction and strength of N.
    let SampledDesign::Cubic(exported) = sampled(&study, &study.observers[0], Some(0.05), None).unwrap().design else {
        panic!("not cubic")
    };
    let pole = (-0.05 * observer.l[(0, 0)]).exp();
    assert!((1.0 - exported.observer.ld()[(0, 0)] - pole).abs() < 1e-12);
    assert!((exported.observer.n() / observer.n[(0, 0)])[(0, 0)] - 1.0 < 1e-12);
    assert!(exported.certificate.is_proved());
}

#[test]
fn where_the_cubic_term_does_not_pay_the_report_says_so() {
    let text = format!("{SCALAR}first_errors = [1]\nhorizon = 20\nnoise_deviation = [1]\nnoise_period = 0.1\n");
    let (study, found) = designed(&text);
    assert!(found.report.statement.starts_with("The cubic term does not pay"), "{}", found.report.statement);
    assert!(
        found.runnable.of::<LinearObserver<f64, Dyn, Dyn, Dyn>>().is_some() && found.report.verdict.word() == "proved"
    );
    let exported = sampled(&study, &study.observers[0], Some(0.1), None).unwrap();
    assert!(matches!(exported.design, SampledDesign::Linear(_)));
}

/// Noise and horizon of the simulation, and the defaults of the others.
#[test]
fn what_is_not_given_is_that_of_the_simulation() {
    let text = format!(
        "{SCALAR}first_errors = [2]\n[simulation]\nx0 = [1]\nduration = 7\nnoise = {{ distribution = \"uniform\", amplitude = [0.3], period = 0.02 }}\n"
    );
    let study = read(&text).unwrap();
    let OptimalCubic(problem) = study.observers[0].kind.of().unwrap();
    let expected = EstimationProblem::new(&[2.0], &[0.3 / 3.0_f64.sqrt()], 0.02, 7.0);
    assert_eq!(*problem, EstimationProblem { is_uniform: true, ..expected });
}

#[test]
fn mistakes_are_named() {
    let mistake = |keys: &str, expected: &str| {
        let found = read(&format!("{SCALAR}{keys}\n")).unwrap_err().to_string();
        assert!(found.contains(expected), "{found}");
    };
    let sound = "first_errors = [1]\nhorizon = 20\nnoise_deviation = [0.1]\nnoise_period = 0.05";
    mistake("horizon = 20\nnoise_deviation = [0.1]\nnoise_period = 0.05", "`first_errors`");
    mistake(&sound.replace("[1]", "[1, 2]"), "`first_errors` has length 2, and the plant has 1 state");
    mistake(&sound.replace("[1]", "[0]"), "`first_errors`");
    mistake(&sound.replace("horizon = 20", ""), "no simulation whose duration could be the horizon");
    mistake(&sound.replace("noise_deviation = [0.1]", ""), "without noise no gain is too large");
    mistake(&sound.replace("noise_period = 0.05", ""), "expected `noise_period`");
    mistake(&format!("{sound}\nweight = 0"), "`weight` is 0");
    mistake(&format!("{sound}\nweight = -1"), "`weight` has the eigenvalue -1");
    mistake(&format!("{sound}\nprocess_noise = [[1, 2], [3, 4]]"), "`process_noise` is 2 x 2");
    mistake(&format!("{sound}\npoles = [-1]"), "poles");
    let discrete = SCALAR.replace("c = [[1]]", "c = [[1]]\ndt = 0.1");
    let study = read(&format!("{discrete}{sound}\n")).unwrap();
    let refused = design(&study, &study.observers[0], &AtomicBool::new(false)).unwrap_err();
    let said = format!("{refused:?}");
    assert!(said.contains("the kind optimal-cubic is for plants in continuous time"), "{said}");
    let nonlinear = "[plant]\nf = [\"-x1^3\"]\nh = [\"x1\"]\n[[observer]]\nkind = \"optimal-cubic\"\n";
    let study = read(&format!("{nonlinear}{sound}\n")).unwrap();
    let refused = design(&study, &study.observers[0], &AtomicBool::new(false)).unwrap_err();
    let said = format!("{refused:?}");
    assert!(said.contains("the kind optimal-cubic needs a linear plant"), "{said}");
    assert!(said.contains("v = 1 and [operating_point] with x = [0]"), "{said}");
}
