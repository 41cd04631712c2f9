//! Families of programs like SDPLIB's, small: every bound encloses what is known of the optimum, and is finite where
//! the programs have an interior.

use crate::families;

use families::{Instance, Known};
use luenberger_lmi::sdpa::{NoBoundReason, Outcome, Settings, Status, read, solve};
use luenberger_proof::certificate::verify;
use std::time::Duration;

fn bounds(instance: &Instance) -> Outcome {
    let program = read(instance.text.as_bytes()).unwrap_or_else(|error| panic!("{}: {error}", instance.name));
    solve(&program, &Settings::default())
}

/// Closed forms have their own rounding, of a few units.
fn encloses(found: &Outcome, optimum: f64) -> bool {
    let rounding = 16.0 * f64::EPSILON * optimum.abs();
    found.lower <= optimum + rounding && optimum - rounding <= found.upper
}

#[test]
fn what_is_known_of_each_family_comes_out() {
    for instance in families::small() {
        let found = bounds(&instance);
        let name = &instance.name;
        assert!(found.lower <= found.upper, "{name}: {found:?}");
        match instance.known {
            Known::PrimalInfeasible => assert_eq!(found.status, Status::PrimalInfeasible, "{name}: {found:?}"),
            Known::DualInfeasible => assert_eq!(found.status, Status::DualInfeasible, "{name}: {found:?}"),
            Known::Bounded(optimum) => {
                assert_eq!(found.status, Status::Bounds, "{name}: {found:?}");
                // The solver stops at a relative gap of 1e-12, and loses a few digits of it to the margins that a proof
                // asks for.
                assert!(found.upper - found.lower <= 1e-6 * (1.0 + found.upper.abs()), "{name}: {found:?}");
                assert!(optimum.is_none_or(|optimum| encloses(&found, optimum)), "{name}: {found:?}");
            }
            Known::AboveOnly(optimum) => {
                assert!(matches!(found.status, Status::Bounds | Status::Undecided), "{name}: {found:?}");
                assert!(found.upper.is_finite(), "{name}: {found:?}");
                assert!(optimum.is_none_or(|optimum| encloses(&found, optimum)), "{name}: {found:?}");
                let says_why = found.status == Status::Bounds || found.why == Some(NoBoundReason::NoDualPoint);
                assert!(says_why, "{name}: {found:?}");
            }
        }
        assert_eq!(found.why.is_some(), found.status == Status::Undecided, "{name}: {found:?}");
        // And it is checked without the solver.
        let program = read(instance.text.as_bytes()).unwrap();
        let file = found.certificate_file(&program, name).unwrap_or_else(|error| panic!("{name}: {error}")).to_json();
        let proved = verify(file.as_bytes()).unwrap_or_else(|why| panic!("{name}: {why}"));
        let is_two_sided = found.status == Status::Bounds;
        assert_eq!(proved.facts.len(), if is_two_sided { 2 } else { 1 }, "{name}: {}", proved.statement);
    }
}

/// Problems that exceed the memory or time limit are not started, and the reason is returned.
#[test]
fn without_memory_or_time_the_answer_is_a_reason() {
    let program = read(families::max_cut(24, 5.0, 1).text.as_bytes()).expect("an SDPA file");
    let found = solve(&program, &Settings { memory: 1000, ..Settings::default() });
    assert!(matches!(found.why, Some(NoBoundReason::Memory { expected, allowed: 1000 }) if expected > 1000.0));
    let found = solve(&program, &Settings { time: Some(Duration::ZERO), ..Settings::default() });
    assert_eq!((found.status, found.why, found.runs), (Status::Undecided, Some(NoBoundReason::Time), 0));
}
