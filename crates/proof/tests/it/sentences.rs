//! Sentences of reports: they are made of proved theorems, and claim no more.

use std::collections::BTreeMap;

use luenberger_proof::certificate::{
    Certificate, CubicConvergence, DiscreteConvergence, LinearConvergence, PlantMatrices, PlantWithin, ProvedSentence,
    Reading, Region, Represented, SampledCubicConvergence,
};
use luenberger_proof::{Exact, Matrix, Ring};
use proptest::prelude::*;

fn names(of: &[&str]) -> Vec<String> {
    of.iter().map(|name| (*name).to_owned()).collect()
}

/// The sentences of a certificate for a plant with these states.
fn said(certificate: &Certificate, states: &[&str], plant: Represented<'_>) -> Vec<String> {
    let (states, none, units) = (names(states), Vec::new(), BTreeMap::new());
    let reading = Reading {
        states: &states,
        inputs: &none,
        outputs: &none,
        units: &units,
        plant,
        is_linearised: false,
        scales: &[],
    };
    certificate.sentences(&reading).iter().map(ProvedSentence::to_string).collect()
}

fn one(a: f64, l: f64, rate: f64) -> Certificate {
    let scalar = |x: f64| Matrix::from_rows([[x]]);
    let plant = PlantWithin::exactly(&scalar(a), &Matrix::from_fn(1, 0, |_, _| 0.0), &scalar(1.0)).unwrap();
    Certificate::of([LinearConvergence { plant, l: scalar(l), p: scalar(1.0), rate }]).unwrap()
}

/// `e' = -e` is faster than exp(-t/2) and not faster than exp(-2 t): of what is not proved nothing is said.
#[test]
fn nothing_is_said_of_what_is_not_proved() {
    let proved = said(&one(0.0, 1.0, 0.5), &["x"], Represented::Itself);
    assert_eq!(
        proved,
        ["e' = (A - L C) e: for all x(0) and xhat(0) the error tends to 0, at least as fast as exp(-0.5 t)."]
    );
    assert!(said(&one(0.0, 1.0, 2.0), &["x"], Represented::Itself).is_empty());
    assert!(said(&one(0.0, -1.0, 0.0), &["x"], Represented::Itself).is_empty());
}

proptest! {
    /// The rate in a sentence, read as a decimal, is one of the error: of `e' = -l e` it is at most l.
    #[test]
    fn a_printed_rate_is_proved(mantissa in 1.0..10.0_f64, exponent in -9..9_i32, ulps in 0..4_u32) {
        let rate = mantissa * 10.0_f64.powi(exponent);
        // Barely faster than the rate, so that the shortest decimal may be too fast.
        let l = (0..=ulps).fold(rate, |l, _| l.next_up());
        for text in said(&one(0.0, l, rate), &["x"], Represented::Itself) {
            let (_, from) = text.split_once("exp(-").expect("a rate");
            let printed = from.split_once(" t)").map_or("1", |(rate, _)| rate);
            // The decimal exactly, as a fraction of integers.
            prop_assert!(decimal_at_most(printed, l), "{printed} against {l:e}");
        }
    }
}

/// Whether a positive decimal is at most a binary64 number, in exact arithmetic.
fn decimal_at_most(text: &str, bound: f64) -> bool {
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let (whole, part) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits: f64 = format!("{whole}{part}").parse().expect("fewer than 2^53");
    let exponent = exponent.parse::<i32>().expect("an integer") - i32::try_from(part.len()).expect("few digits");
    let ten = |power: i32| {
        let ten = Exact::from_f64(10.0).expect("finite");
        (0..power.max(0)).fold(Exact::from_f64(1.0).expect("finite"), |product, _| product.mul(&ten))
    };
    let left = Exact::from_f64(digits).expect("finite").mul(&ten(exponent));
    let right = Exact::from_f64(bound).expect("finite").mul(&ten(-exponent));
    right.sub(&left).signum() >= 0
}

/// A double integrator with a constant force, `y = x1`, poles -1, -2, -3.
fn with_force(a: &Matrix<f64>) -> Certificate {
    let plant = PlantWithin::exactly(a, &Matrix::from_fn(3, 0, |_, _| 0.0), &Matrix::from_rows([[1.0, 0.0, 0.0]]));
    let l = Matrix::from_rows([[6.0], [11.0], [6.0]]);
    // F'P + PF = -I for F = A - L C.
    let p = Matrix::from_rows([[1.7, -0.5, -0.7], [-0.5, 0.7, -0.5], [-0.7, -0.5, 4.6 / 3.0]]);
    Certificate::of([LinearConvergence { plant: plant.unwrap(), l, p, rate: 0.0 }]).unwrap()
}

/// A reading is checked: the last state is a disturbance only if its row is 0 and y does not show it.
#[test]
fn a_disturbance_is_a_chain_that_drives_the_plant() {
    let chain = Matrix::from_rows([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]);
    let all = Represented::WithDisturbance { states: 2, order: 1 };
    let certificate = with_force(&chain);
    assert!(certificate.is_proved(), "{certificate}");
    let states = ["x", "v", "d"];
    assert_eq!(
        said(&certificate, &states, all),
        ["For a constant disturbance d the errors of x and of d tend to 0, for all x(0), xhat(0) and d."]
    );
    // The same is a plant with one state and a disturbance that is linear in t; not with one state and order 1.
    assert_eq!(said(&certificate, &states, Represented::WithDisturbance { states: 1, order: 2 }).len(), 1);
    for wrong in [(1, 1), (2, 2), (3, 1), (0, 2), (2, 0)] {
        let plant = Represented::WithDisturbance { states: wrong.0, order: wrong.1 };
        assert!(said(&certificate, &states, plant).is_empty(), "{wrong:?}");
    }
    let mut slow = chain;
    slow[(2, 2)] = -1e-9;
    let certificate = with_force(&slow);
    assert!(certificate.is_proved() && said(&certificate, &states, all).is_empty(), "{certificate}");
}

/// `x+ = 1.2 x + u`, `u = -xhat`, L = 1: both poles at 0.2.
fn loop_of(feedback: f64) -> (SampledCubicConvergence, DiscreteConvergence) {
    let (a, l, k) = (1.2, 1.0, 1.0);
    let scalar = |x: f64| Matrix::from_rows([[x]]);
    let plant = PlantMatrices { a: scalar(a), b: scalar(1.0), c: scalar(1.0) };
    let observer = SampledCubicConvergence {
        plant,
        l: scalar(l),
        n: scalar(-0.5),
        theta: scalar(1.0),
        p: scalar(1.0),
        w: 1.0,
        period: 0.1,
    };
    let joined = DiscreteConvergence {
        plant: PlantMatrices {
            a: Matrix::from_rows([[a, 0.0], [0.0, a]]),
            b: Matrix::from_rows([[1.0], [1.0]]),
            c: Matrix::from_rows([[0.0, k], [-1.0, 1.0]]),
        },
        l: Matrix::from_rows([[1.0, feedback], [1.0, l]]),
        p: Matrix::from_rows([[4.5, -3.0], [-3.0, 3.6]]),
        factor: None,
    };
    (observer, joined)
}

/// The loop of a sampled cubic observer is that of its plant and its gain; the output does not enter the plant.
#[test]
fn a_loop_is_one_of_its_observer() {
    let (observer, joined) = loop_of(0.0);
    let linear = Certificate::of([joined]).unwrap();
    let of_loop = |is_linear_part| Represented::Loop { states: 1, is_linear_part };
    assert!(linear.is_proved(), "{linear}");
    assert!(said(&linear, &["x"], of_loop(false))[0].contains("from every x(0) and xhat(0)"));
    assert!(said(&linear, &["x"], of_loop(true))[0].contains("if they start near 0"));
    let observer = Certificate::of([observer]).unwrap();
    assert!(observer.is_proved(), "{observer}");
    let of_both = |joined| observer.sentence_of_sampled_loop(&Certificate::of([joined]).unwrap());
    assert!(of_both(loop_of(0.0).1).unwrap().as_str().contains("from every x(0) and xhat(0)"));
    // Another gain, or another plant, than those of the observer.
    let mut other = loop_of(0.0).1;
    other.l[(1, 1)] = 1.125;
    assert!(of_both(other).is_none());
    let mut other = loop_of(0.0).1;
    (other.plant.a[(0, 0)], other.plant.a[(1, 1)]) = (1.1875, 1.1875);
    assert!(of_both(other).is_none());
    let (_, injected) = loop_of(0.125);
    let injected = Certificate::of([injected]).unwrap();
    assert!(injected.is_proved() && said(&injected, &["x"], of_loop(false)).is_empty(), "{injected}");
}

/// A level is a hypothesis and rounded down; so is the ball inside.
#[test]
fn a_region_is_in_the_sentence() {
    let scalar = |x: f64| Matrix::from_rows([[x]]);
    let theorem = |region| CubicConvergence {
        plant: PlantMatrices { a: scalar(0.0), b: Matrix::from_fn(1, 0, |_, _| 0.0), c: scalar(1.0) },
        l: scalar(1.0),
        n: scalar(-1.0),
        theta: scalar(1.0),
        p: scalar(1.0),
        s: scalar(1.0),
        rate: 0.0,
        region,
    };
    let everywhere = Certificate::of([theorem(Region::Everywhere)]).unwrap();
    let text = said(&everywhere, &["x"], Represented::Itself).join(" ");
    assert!(text.contains("With the gains as stored it converges from every initial error."), "{text}");
    let within = Certificate::of([theorem(Region::Within(0.123_456_7))]).unwrap();
    let text = said(&within, &["x"], Represented::Itself).join(" ");
    assert!(within.is_proved(), "{within}");
    assert!(
        text.contains("from every initial error e with e'Pe < 0.123456, such as all of norm below 0.35136."),
        "{text}"
    );
}
