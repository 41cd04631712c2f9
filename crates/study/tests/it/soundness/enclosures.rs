//! The enclosed Jacobian is the one that the certificate speaks of.

use std::sync::atomic::AtomicBool;

use luenberger_proof::certificate::Theorem;
use luenberger_study::design::{Designed, design};
use luenberger_study::results::NoObserver;

use crate::studies;

/// The design of each observer, or why it has none.
fn designs(text: &str) -> Vec<(String, Result<Designed, NoObserver>)> {
    let study = studies::study(text);
    let one = |requested| design(&study, requested, &AtomicBool::new(false));
    study.observers.iter().map(|requested| (requested.name.clone(), one(requested))).collect()
}

/// A state that no output sees and that rests at two places: whatever the observer, the error stays.
fn nothing_is_proved(text: &str) {
    for (name, found) in designs(text) {
        if let Ok(designed) = found {
            assert_ne!(designed.report.verdict.word(), "proved", "{name}: {}", designed.report.statement);
            assert!(designed.certificate.is_none_or(|certificate| !certificate.is_proved()), "{name}");
        }
    }
}

/// wear' = -1e-6 wear + 2e-6 sin(wear) rests at 0 and at +-1.8955. Its slope is of the order 1e-6, beside an entry of
/// 1.4e10.
#[test]
fn a_small_slope_beside_a_large_entry_is_no_constant() {
    nothing_is_proved(
        r#"[plant]
states = ["position", "pressure", "wear"]
f = ["-0.5*position", "-1.4e10*position - 20*pressure", "-1e-6*wear + 2e-6*sin(wear)"]
h = ["pressure"]
[[observer]]
name = "lip"
kind = "lipschitz"
[[observer]]
name = "lpv"
kind = "lpv"
"#,
    );
    nothing_is_proved(
        r#"[plant]
f = ["-1e17*x1", "-x2 + 2*sin(x2)"]
h = ["x1"]
[[observer]]
kind = "lipschitz"
"#,
    );
}

/// Thirteen entries vary: too many for the vertices of a polytope.
#[test]
fn nor_is_it_beyond_the_vertices_of_a_polytope() {
    let f = [
        "-x1 + 0.01*(sin(x1) + sin(x2) + sin(x3) + sin(x4))",
        "-1.4e10*x1 - 20*x2 + 0.01*(sin(x2) + sin(x3) + sin(x4))",
        "-x3 + 0.01*(sin(x1) + sin(x2) + sin(x3) + sin(x4))",
        "-1e-6*x4 + 2e-6*sin(x4) + 1e-9*sin(x1)",
    ];
    nothing_is_proved(&format!("[plant]\nf = {f:?}\nh = [\"x2\"]\n[[observer]]\nkind = \"lpv\"\n"));
}

/// The mean of x2 and x3 leaves 0 like exp(t/2) and is not seen. The slope of the sine is 4e-10 of the entry that it
/// belongs to.
#[test]
fn a_small_slope_of_a_large_entry_is_no_constant() {
    nothing_is_proved(
        r#"[plant]
f = ["-x1", "-1e10*x2 + 1e10*x3 + 2*sin(x2)", "1e10*x2 - 1e10*x3 - x3"]
h = ["x1"]
[[observer]]
kind = "mean-value"
decay_rate = 0.1
[[observer]]
name = "lpv"
kind = "lpv"
decay_rate = 0.1
[[observer]]
name = "lip"
kind = "lipschitz"
decay_rate = 0.1
"#,
    );
}

/// 1/3 is no number of binary64, and is enclosed: the theorems have the interval, in A as in C, and are proved.
#[test]
fn what_is_constant_up_to_rounding_is_an_interval_of_the_theorem() {
    let found = designs(
        r#"[plant]
f = ["x2 - x1/3", "-sin(x1)"]
h = ["x1/3"]
[[observer]]
kind = "lpv"
decay_rate = 0.5
[[observer]]
kind = "lipschitz"
decay_rate = 0.5
"#,
    );
    let third = 1.0 / 3.0f64;
    for (name, found) in found {
        let designed = found.unwrap_or_else(|failure| panic!("{name}: {failure:?}"));
        assert_eq!(designed.report.verdict.word(), "proved", "{name}");
        let certificate = designed.certificate.unwrap();
        let data = match certificate.theorems()[0].theorem() {
            Theorem::SectorConvergence(theorem) => {
                assert_eq!(theorem.terms.len(), 1, "one entry varies");
                vec![(theorem.a[(0, 0)].interval(), theorem.c[(0, 0)].interval())]
            }
            Theorem::JacobianPolytope(theorem) => {
                theorem.vertices.iter().map(|v| (v.a[(0, 0)].interval(), v.c[(0, 0)].interval())).collect()
            }
            other => panic!("{name}: {}", other.name()),
        };
        for (a, c) in data {
            // The number 1/3 is above the one of binary64 nearest to it.
            assert!(c.lo() <= third && third < c.hi(), "{name}: {c:?}");
            assert!(a.lo() < -third && -third <= a.hi(), "{name}: {a:?}");
        }
    }
}

/// A kink: whether f is continuous there is a hypothesis of all three. A jump is refused by all three.
#[test]
fn all_kinds_of_enclosures_treat_branches_alike() {
    let plant = |f2: &str| {
        let kinds = ["lpv", "lipschitz", "mean-value"].map(|kind| format!("[[observer]]\nkind = \"{kind}\"\n"));
        format!("[plant]\nf = [\"x2\", \"{f2}\"]\nh = [\"x1\"]\n{}", kinds.concat())
    };
    for (name, found) in designs(&plant("-x1 - if(x2 > 0, x2, 2*x2)")) {
        let report = found.unwrap_or_else(|failure| panic!("{name}: {failure:?}")).report;
        assert_eq!(report.verdict.word(), "proved", "{name}");
        assert!(
            report.statement.contains("and provided that f and h are continuous where they change branches"),
            "{name}: {}",
            report.statement
        );
    }
    for (name, found) in designs(&plant("-x1 - x2 + if(x2 > 1, 0.01, 0)")) {
        let failure = found.err().unwrap_or_else(|| panic!("{name} has a design"));
        assert!(failure.hypothesis.contains("f jumps at"), "{name}: {}", failure.hypothesis);
    }
    // Without branches there is no such hypothesis.
    for (name, found) in designs(&plant("-x1 - 0.5*abs(x2)")) {
        let statement = found.unwrap_or_else(|failure| panic!("{name}: {failure:?}")).report.statement;
        assert!(!statement.contains("provided that"), "{name}: {statement}");
    }
}

/// Times are those of the region, all of them by default: an entry that grows with t has no bound then, and a bound of
/// t is a hypothesis like those of the states.
#[test]
fn a_bound_of_the_time_is_a_hypothesis() {
    let text = |time: &str| {
        let region = format!("region = {{ states = [[-2, 2], [-2, 2]]{time} }}\n");
        let kinds = ["lpv", "lipschitz", "mean-value"].map(|kind| format!("[[observer]]\nkind = \"{kind}\"\n{region}"));
        format!("[plant]\nf = [\"x2\", \"-x1 - x2 - 0.1*t*sin(x1)\"]\nh = [\"x1\"]\n{}", kinds.concat())
    };
    for (name, found) in designs(&text("")) {
        let failure = found.err().unwrap_or_else(|| panic!("{name} has a design"));
        assert!(failure.hypothesis.contains("has no finite bound"), "{name}: {}", failure.hypothesis);
    }
    for (name, found) in designs(&text(", time = [0, 5]")) {
        let report = found.unwrap_or_else(|failure| panic!("{name}: {failure:?}")).report;
        assert_eq!(report.verdict.word(), "proved", "{name}");
        assert!(report.statement.contains("x2 in [-2, 2], t in [0, 5])"), "{name}: {}", report.statement);
    }
}

/// Sectors of a study that contain the Jacobian are said to; of others nothing is checked.
#[test]
fn given_sectors_are_compared_with_the_jacobian() {
    let text = |high: f64| {
        format!(
            "[plant]\nf = [\"x2\", \"-sin(x1)\"]\nh = [\"x1\"]\n[[observer]]\nkind = \"lipschitz\"\na = [[0, 1], [0, 0]]\nsectors = [{{ g = [[0], [1]], h = [[1, 0]], low = -1, high = {high} }}]\n"
        )
    };
    for (high, says) in [(1.0, "The sectors enclose the Jacobian"), (0.5, "they are not checked")] {
        let found = designs(&text(high)).remove(0).1;
        let statement = found.unwrap_or_else(|failure| panic!("{failure:?}")).report.statement;
        assert!(statement.contains(says), "{statement}");
    }
}
