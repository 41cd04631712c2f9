//! A numerical KKL observer of which only the domain is given: the report says what was chosen, why, and what the other
//! candidates gave.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use luenberger_study::design::design;
use luenberger_study::{Format, Study};

const VAN_DER_POL: &str = r#"
[plant]
states = ["x", "v"]
f = ["v", "(1 - x^2)*v - x"]
h = ["x"]
[[observer]]
kind = "kkl-numerical"
domain = [[-2.3, 2.3], [-3, 3]]
points = 33
leaves = 16
samples = 2000
"#;

#[test]
fn what_was_chosen_is_reported_with_the_other_candidates() {
    let study = Study::from_text("study.toml", VAN_DER_POL, Format::Toml, Path::new(".")).unwrap();
    let designed = design(&study, &study.observers[0], &AtomicBool::new(false)).unwrap();
    let cutoff = designed.report.number("cutoff").unwrap();
    assert!(cutoff > 4.0, "slower filters are refused: {cutoff}");
    assert_eq!(designed.report.number("grid points per axis"), Some(33.0));
    let evidence = designed.report.evidence.unwrap();
    for part in [
        "points that were not used in the fit. Chosen: cutoff = ",
        "escape = 1 (a trajectory is unbounded backward in time)",
        "Coarse designs: cutoff ",
        "refused (the table does not resolve T)",
        "on 33 points: error ",
    ] {
        assert!(evidence.contains(part), "{part}\n{evidence}");
    }
    // The points are given: there is nothing to say of them.
    assert!(!evidence.contains("points = "), "{evidence}");
}
