//! Why there is no observer, as one error with its numbers from the design to the export.

use std::sync::atomic::AtomicBool;

use luenberger_design::DesignError;
use luenberger_study::deployment::sampled;
use luenberger_study::design::{Cause, design};

use crate::studies::study;

/// The cause of the first observer of a study.
fn cause(text: &str) -> Cause {
    let study = study(text);
    let none = design(&study, &study.observers[0], &AtomicBool::new(false)).map(|_| "a design").unwrap_err();
    assert_eq!(none.line, study.observers[0].place.line);
    *none.cause.unwrap_or_else(|| panic!("{}", none.hypothesis))
}

#[test]
fn a_hypothesis_of_the_plant_has_its_numbers() {
    let sampled = "[plant]\ndt = 0.5\na = [[0.9]]\nc = [[1]]\n[[observer]]\nname = \"o\"\n";
    let slow = format!("{sampled}kind = \"cubic\"\npoles = [-1]\ngamma = 1\n");
    assert_eq!(cause(&slow), Cause::DiscreteTime { dt: 0.5 });
    let other = format!("{sampled}kind = \"ukf\"\nw = 1\nv = 1\nperiod = 0.25\n");
    assert_eq!(cause(&other), Cause::OtherPeriod { period: 0.25, dt: 0.5 });
    let nonlinear = "[plant]\nf = [\"-x1^3\"]\nh = [\"x1\"]\n[[observer]]\nname = \"o\"\nkind = \"luenberger\"\n";
    assert_eq!(cause(&format!("{nonlinear}poles = [-1]\n")), Cause::NotLinear);
    let fed = "[plant]\nf = [\"x2\", \"-x1\"]\nh = [\"x1 + u1\"]\n[[observer]]\nname = \"o\"\nkind = \"high-gain\"\nr = 0.1\n";
    assert_eq!(cause(fed), Cause::Feedthrough { output: 0 });
}

#[test]
fn an_interruption_is_a_cause_and_no_hypothesis() {
    let study = study(
        "[plant]\na = [[0, 1], [-1, 0]]\nc = [[1, 0]]\n[[observer]]\nname = \"o\"\nkind = \"kkl-numerical\"\ndomain = [[-1, 1], [-1, 1]]\n",
    );
    let none = design(&study, &study.observers[0], &AtomicBool::new(true)).map(|_| "a design").unwrap_err();
    assert!(none.is_interrupted() && none.advice().is_empty(), "{none:?}");
}

/// A step that fails keeps its error, told from one of the design of the observer.
#[test]
fn an_error_of_a_step_is_told_from_one_of_the_design() {
    // The poles +-2 pi i of the plant are one at the period 1.
    let text = "[plant]\na = [[0, 6.283185307179586], [-6.283185307179586, 0]]\nb = [[0], [1]]\nc = [[1, 0]]\n[[observer]]\nname = \"o\"\nkind = \"luenberger\"\npoles = [-1, -2]\n";
    let study = study(text);
    let none = sampled(&study, &study.observers[0], Some(1.0), None).map(|_| "a step").unwrap_err();
    match none.cause.as_deref() {
        Some(Cause::Step(step)) => assert!(matches!(**step, Cause::Design(DesignError::OfPair { .. })), "{step:?}"),
        other => panic!("{other:?}"),
    }
}
