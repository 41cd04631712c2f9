//! `refuted`, `no gain` and `no observer` need a witness against the observer or the plant.

use std::sync::atomic::AtomicBool;

use luenberger_design::{DesignError, UnseenModes};
use luenberger_study::Step;
use luenberger_study::design::{Designed, NoDesign, design};
use luenberger_study::results::FailureReport;

use crate::studies;

/// The design of each observer, or why it has none.
fn designs(text: &str) -> Vec<(String, Result<Designed, FailureReport>)> {
    let study = studies::study(text);
    let one = |requested| match design(&study, requested, &AtomicBool::new(false)) {
        Ok(designed) => Ok(designed),
        Err(NoDesign::Misfit(failure)) => Err(failure),
        Err(NoDesign::Interrupted) => panic!("interrupted"),
    };
    study.observers.iter().map(|requested| (requested.name.clone(), one(requested))).collect()
}

/// Every observer of a study is designed and proved.
#[track_caller]
fn all_proved(text: &str) -> Vec<Designed> {
    let proved = designs(text).into_iter().map(|(name, found)| match found {
        Ok(designed) => {
            assert_eq!(designed.report.verdict, "proved", "{name}: {:?}", designed.report.facts);
            designed
        }
        Err(failure) => panic!("{name}: {}", failure.hypothesis),
    });
    proved.collect()
}

const LEAST: &str = r#"[plant]
a = [[-1]]
c = [[1]]
[[observer]]
name = "least"
kind = "h2"
e = [[1e-4, 0]]
d = [[0, 1e-4]]
[[observer]]
name = "asked"
kind = "h2"
e = [[1e-4, 0]]
d = [[0, 1e-4]]
gamma = 6.76e-5
"#;

/// By hand: `L = sqrt(2) - 1`, the norm `1e-4 sqrt(sqrt(2) - 1)`.
#[test]
fn the_least_h2_norm_is_the_least() {
    let found = all_proved(LEAST);
    let least = 1e-4 * (2f64.sqrt() - 1.0).sqrt();
    let number = |name: &str| found[0].report.number(name).unwrap();
    assert!((number("least H2 norm") / least - 1.0).abs() < 1e-9 && (number("H2 norm") / least - 1.0).abs() < 1e-9);
    assert!((found[0].report.matrices[0].rows[0][0] - (2f64.sqrt() - 1.0)).abs() < 1e-9);
    assert!(found[1].report.number("H2 norm").unwrap() < 6.76e-5);
}

/// Without noise of the output every bound is kept by a gain that is large enough: `L = 1e10` leaves 1e-10.
#[test]
fn a_bound_that_a_large_gain_keeps_is_not_out_of_reach() {
    let found = all_proved(
        r#"[plant]
a = [[-1]]
b = [[1]]
c = [[1]]
[[observer]]
name = "asked"
kind = "h-infinity"
e = [[1, 0]]
d = [[0, 0]]
gamma = 1e-9
[[observer]]
name = "given"
kind = "h-infinity"
e = [[1, 0]]
d = [[0, 0]]
gain = [[1e10]]
[[observer]]
name = "asked2"
kind = "h2"
e = [[1, 0]]
d = [[0, 0]]
gamma = 1e-3
[[observer]]
name = "given2"
kind = "h2"
e = [[1, 0]]
d = [[0, 0]]
gain = [[1e6]]
"#,
    );
    assert!(found[0].report.number("H-infinity norm").unwrap() < 1e-9);
    assert!(found[2].report.number("H2 norm").unwrap() < 1e-3);
}

/// The gains 39.9 and 1600 have the norms .0019975 and 1.00025e-4, below the bounds asked for.
#[test]
fn a_bound_that_another_gain_of_the_file_keeps_is_kept() {
    let found = all_proved(
        r#"[plant]
a = [[-1]]
b = [[1]]
c = [[10]]
[[observer]]
name = "least"
kind = "h2"
e = [[0.04, 0]]
d = [[0, 0.001]]
[[observer]]
name = "asked"
kind = "h2"
e = [[0.04, 0]]
d = [[0, 0.001]]
gamma = 0.0021
[[observer]]
name = "given"
kind = "h2"
e = [[0.04, 0]]
d = [[0, 0.001]]
gain = [[39.9]]
[[observer]]
name = "hleast"
kind = "h-infinity"
e = [[0.04, 0]]
d = [[0, 0.001]]
[[observer]]
name = "hasked"
kind = "h-infinity"
e = [[0.04, 0]]
d = [[0, 0.001]]
gamma = 0.00011
[[observer]]
name = "hgiven"
kind = "h-infinity"
e = [[0.04, 0]]
d = [[0, 0.001]]
gain = [[1600]]
"#,
    );
    let number = |k: usize, name: &str| found[k].report.number(name).unwrap();
    assert!(number(0, "least H2 norm") <= number(2, "H2 norm"));
    assert!(number(1, "H2 norm") < 0.0021 && number(4, "H-infinity norm") < 0.000_11);
    // sqrt(.0016 + 1e-6 L^2)/(1 + 10 L) has its least value at L = 16 000.
    let least = (0.0016f64 + 256.0).sqrt() / 160_001.0;
    assert!(number(3, "H-infinity norm") >= least * (1.0 - 1e-9));
    assert!((number(3, "least H-infinity norm found") / least - 1.0).abs() < 1e-2);
}

/// A is Hurwitz and its own comparison matrix, so that L = 0 is a gain.
#[test]
fn a_linear_program_that_is_not_solved_excludes_no_gain() {
    let mut found = designs(
        r#"[plant]
a = [[-3073.172593148491, 1.715448395432328e+19], [1.3004253222139086e-13, -2450.637983320863]]
b = [[1.0], [1.0]]
c = [[1000000.0, 0.0]]
[[observer]]
kind = "interval"
least_width = true
initial_bounds = [1.0, 1.0]
bounds = { noise = [1], disturbance = [1.0], e = [[1.0], [1.0]] }
"#,
    );
    match found.remove(0).1 {
        Ok(designed) => assert_eq!(designed.report.verdict, "proved"),
        Err(failure) => {
            assert!(matches!(failure.cause.as_deref(), Some(DesignError::Undecided { .. })), "{}", failure.hypothesis);
            assert!(failure.hypothesis.contains("is undecided") && !failure.hypothesis.contains("no gain"));
        }
    }
}

const SLOW: &str = r#"[plant]
a = [[-1e-9, 0], [0, -1e8]]
b = [[0], [1]]
c = [[0, 1]]
[[observer]]
name = "poles"
kind = "luenberger"
poles = [-1, -2e8]
[[observer]]
name = "kalman"
kind = "kalman"
w = [0, 1]
v = 1
[[observer]]
name = "given"
kind = "luenberger"
gain = [[0], [1]]
"#;

/// The unseen mode -1e-9 decays, beside another of -1e8.
#[test]
fn a_slow_unseen_mode_leaves_an_observer() {
    for (name, found) in designs(SLOW) {
        match found {
            Ok(designed) => assert_eq!((name.as_str(), designed.report.verdict.as_str()), ("given", "proved")),
            Err(failure) => {
                let words = format!("{}; {}", failure.hypothesis, failure.alternatives.join("; "));
                assert!(!words.contains("no observer") && words.contains("the plant is detectable"), "{name}: {words}");
            }
        }
    }
    let results = studies::executed(SLOW, Step::Observe);
    let report = results.observability.unwrap();
    assert_eq!((report.rank, report.points[0].unseen), (1, UnseenModes::Decay));
    let json = serde_json::to_value(&report).unwrap();
    assert_eq!(json["points"][0]["detectable"], serde_json::json!(true));
    // With the other sign it grows, and nothing is left.
    let growing = SLOW.replace("[[-1e-9, 0]", "[[1e-9, 0]").replace("gain = [[0], [1]]", "lmi = true");
    for (name, found) in designs(&growing) {
        let failure = found.err().unwrap_or_else(|| panic!("{name}"));
        assert!(failure.alternatives.iter().any(|way| way.contains("no observer exists")), "{name}: {failure:?}");
    }
    assert_eq!(studies::executed(&growing, Step::Observe).observability.unwrap().points[0].unseen, UnseenModes::Remain);
}

/// Two unstable modes that differ in the last digit, of which the output has the sum: an observer exists, although to
/// working precision their difference is unobservable.
#[test]
fn a_nearly_unobservable_plant_has_an_observer() {
    let seen = SLOW.replace("[[-1e-9, 0], [0, -1e8]]", "[[1, 0], [0, 1.0000000000000002]]");
    let seen = seen.replace("c = [[0, 1]]", "c = [[1, 1]]").replace("gain = [[0], [1]]", "lmi = true");
    let report = studies::executed(&seen, Step::Observe).observability.unwrap();
    assert_eq!((report.rank, report.points[0].unseen), (1, UnseenModes::None));
    for (name, found) in designs(&seen) {
        if let Err(failure) = found {
            let words = format!("{}; {}", failure.hypothesis, failure.alternatives.join("; "));
            assert!(!words.contains("no observer") && !words.contains("is not detectable: "), "{name}: {words}");
        }
    }
}

/// Hurwitz in units in which the P of `Q = I` fails: proved with another.
#[test]
fn units_refute_no_observer() {
    all_proved(
        r#"[plant]
a = [[0, 1e10], [0, 0]]
b = [[0], [1]]
c = [[1, 0]]
[[observer]]
kind = "luenberger"
poles = [-1, -2]
"#,
    );
    all_proved(
        r#"[plant]
a = [[-1.3121937076769445, 440.7580707586047, -105.89738377833429, 3352.873808038119], [0.0014753829738044597, -0.3539200149581298, 0.03747059176887548, -11.055210169022498], [0.007816862010582331, -20.903983210862613, 0.004992483459789415, -118.29992514911847], [-0.00010035533924915676, -0.099208789102124, 0.0160593778254374, -0.9273006072337506]]
b = [[1.0], [1.0], [1.0], [1.0]]
c = [[-0.0070532278023336175, -0.7182639974108997, -0.1890577908066564, -14.127428926792032]]
[[observer]]
kind = "h2"
e = [[100.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.1, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.01, 0.0]]
d = [[0.0, 0.0, 0.0, 0.0, 1.0]]
"#,
    );
}

/// A hydraulic cylinder in SI units: metres beside megapascals.
#[test]
fn a_cylinder_in_si_units_is_proved() {
    all_proved(
        r#"[plant]
a = [[0, 1, 0], [0, -5, 2e-5], [0, -2.8e9, -10]]
b = [[0], [0], [1.4e12]]
c = [[1, 0, 0]]
[[observer]]
name = "kalman"
kind = "kalman"
w = [0, 1e-4, 1e10]
v = 1e-13
[[observer]]
name = "poles"
kind = "luenberger"
poles = [-300, [-200, 200], [-200, -200]]
[[observer]]
name = "rate"
kind = "luenberger"
decay_rate = 50
noise = [1e-13]
[[observer]]
name = "lmi"
kind = "luenberger"
lmi = true
[[observer]]
name = "h2"
kind = "h2"
e = [[0, 0, 0], [0.01, 0, 0], [0, 1e5, 0]]
d = [[0, 0, 3.1622776601683795e-7]]
[[observer]]
name = "h2x"
kind = "h2"
e = [[0, 0, 0], [0.01, 0, 0], [0, 1e5, 0]]
d = [[0, 0, 3.1622776601683795e-7]]
h = [[1, 0, 0]]
[[observer]]
name = "hinf"
kind = "h-infinity"
e = [[0, 0, 0], [0.01, 0, 0], [0, 1e5, 0]]
d = [[0, 0, 3.1622776601683795e-7]]
h = [[1, 0, 0]]
[[observer]]
name = "reduced"
kind = "reduced-order"
poles = [[-200, 200], [-200, -200]]
[[observer]]
name = "bounds"
kind = "luenberger"
poles = [-300, [-200, 200], [-200, -200]]
bounds = { noise = [4e-5] }
[[observer]]
name = "interval"
kind = "interval"
poles = [-300, [-200, 200], [-200, -200]]
initial_bounds = [0.1, 0.1, 1e6]
bounds = { noise = [4e-5] }
[[observer]]
name = "eso"
kind = "extended-state"
e = [[0], [1], [0]]
bandwidth = 200
[[observer]]
name = "cubic"
kind = "cubic"
poles = [-300, [-200, 200], [-200, -200]]
gamma = 1
"#,
    );
}

/// Entries of 1e-150 and 1e150: what is proved is true, since the plant is observable, and nothing is refuted.
#[test]
fn entries_at_the_ends_of_binary64_get_true_words() {
    let all = designs(
        r#"[plant]
a = [[1e-150, 1e150], [0, 0]]
b = [[0], [1]]
c = [[1, 0]]
[[observer]]
name = "a"
kind = "luenberger"
poles = [-1, -2]
[[observer]]
name = "b"
kind = "luenberger"
lmi = true
[[observer]]
name = "c"
kind = "kalman"
w = [1, 1]
v = 1
[[observer]]
name = "d"
kind = "cubic"
poles = [-1, -2]
gamma = 1e-150
[[observer]]
name = "e"
kind = "interval"
poles = [-1, -2]
initial_bounds = [1e-150, 1e150]
bounds = { noise = [1e-160] }
[[observer]]
name = "f"
kind = "reduced-order"
poles = [-1]
[[observer]]
name = "g"
kind = "luenberger"
poles = [-1, -2]
bounds = { noise = [1e-160] }
"#,
    );
    for (name, found) in all {
        match found {
            Ok(designed) => assert_ne!(designed.report.verdict, "refuted", "{name}"),
            Err(failure) => {
                let words = failure.hypothesis;
                let false_words =
                    ["not distinct enough", "no observer", "no gain", "not observable", "must be positive", "NaN"];
                assert!(!false_words.iter().any(|word| words.contains(word)), "{name}: {words}");
            }
        }
    }
}

/// A weight that is given keeps its P, which may fail: that says nothing of the observer.
#[test]
fn a_false_inequality_is_one_of_its_p() {
    let found = designs(
        r#"[plant]
a = [[0, 1e10], [0, 0]]
c = [[1, 0]]
[[observer]]
kind = "luenberger"
poles = [-1, -2]
rho = 1
"#,
    );
    let report = &found[0].1.as_ref().unwrap_or_else(|failure| panic!("{failure:?}")).report;
    assert_eq!(report.verdict, "undecided");
}
