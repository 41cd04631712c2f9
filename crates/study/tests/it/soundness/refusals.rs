//! `refuted`, `no gain` and `no observer` need a witness against the observer or the plant.

use std::sync::atomic::AtomicBool;

use luenberger_design::{DesignError, UnseenModes};
use luenberger_study::Step;
use luenberger_study::design::{Designed, design};
use luenberger_study::results::{Cause, NoObserver};

use crate::studies;

/// The design of each observer, or why it has none.
fn designs(text: &str) -> Vec<(String, Result<Designed, NoObserver>)> {
    let study = studies::study(text);
    let one = |requested| design(&study, requested, &AtomicBool::new(false));
    study.observers.iter().map(|requested| (requested.name.clone(), one(requested))).collect()
}

/// Every observer of a study is designed and proved.
#[track_caller]
fn all_proved(text: &str) -> Vec<Designed> {
    let proved = designs(text).into_iter().map(|(name, found)| match found {
        Ok(designed) => {
            assert_eq!(designed.report.verdict.word(), "proved", "{name}: {:?}", designed.report.facts);
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

/// The least noise gain with a rate is one gain for every intensity; 2.33692 by a general solver of such programs for V
/// = 1.
#[test]
fn the_quietest_gain_with_a_rate_does_not_depend_on_the_intensity() {
    for v in ["1e-14", "1", "1e8"] {
        let found = all_proved(&format!(
            r#"[plant]
a = [[0, 1], [-1, -0.2]]
c = [[1, 0]]
[[observer]]
kind = "luenberger"
decay_rate = 2
noise = [{v}]
"#
        ));
        let gain = found[0].report.number("noise gain").unwrap();
        assert!((gain - 2.33692).abs() < 1e-4, "{v}: {gain}");
    }
}

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
        Ok(designed) => assert_eq!(designed.report.verdict.word(), "proved"),
        Err(failure) => {
            let cause = failure.cause.as_deref();
            let is_undecided = matches!(cause, Some(Cause::Design(DesignError::Undecided { .. })));
            assert!(is_undecided, "{}", failure.hypothesis);
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
            Ok(designed) => assert_eq!((name.as_str(), designed.report.verdict.word()), ("given", "proved")),
            Err(failure) => {
                let words = format!("{}; {}", failure.hypothesis, failure.advice().join("; "));
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
        assert!(
            failure.hints.iter().any(|way| way.contains("no observer exists")) && failure.alternatives.is_empty(),
            "{name}: {failure:?}"
        );
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
            let words = format!("{}; {}", failure.hypothesis, failure.advice().join("; "));
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
            Ok(designed) => assert_ne!(designed.report.verdict.word(), "refuted", "{name}"),
            Err(failure) => {
                let words = failure.hypothesis;
                let false_words =
                    ["not distinct enough", "no observer", "no gain", "not observable", "must be positive", "NaN"];
                assert!(!false_words.iter().any(|word| words.contains(word)), "{name}: {words}");
            }
        }
    }
}

/// A matrix that is given keeps its P, which may fail: that says nothing of the observer. Of a factor of the identity
/// another Q takes the place.
#[test]
fn a_false_inequality_is_one_of_its_p() {
    let verdict = |weight: &str| {
        let found = designs(&format!(
            "[plant]\na = [[0, 1e10], [0, 0]]\nc = [[1, 0]]\n[[observer]]\nkind = \"luenberger\"\npoles = [-1, -2]\n{weight}\n"
        ));
        let report = &found[0].1.as_ref().unwrap_or_else(|failure| panic!("{failure:?}")).report;
        report.verdict.word().to_owned()
    };
    assert_eq!(verdict("q = [[1, 0], [0, 1]]"), "undecided");
    assert_eq!(verdict("rho = 1"), "proved");
}

/// Why the only observer of a study has no design, with the alternatives.
#[track_caller]
fn refused(text: &str) -> (String, String) {
    match designs(text).remove(0).1 {
        Ok(designed) => panic!("{:?}", designed.report.statement),
        Err(failure) => (failure.hypothesis.clone(), failure.advice().join("; ")),
    }
}

/// The Lyapunov equation of the error fails, which leaves the norm of a given gain to other units.
#[test]
fn a_given_gain_whose_variances_are_unknown_is_designed() {
    for (name, found) in designs(
        r#"[plant]
a = [[0, 0, 0], [-0.29, -1.7999999999999998, 0], [83, 16000, -46]]
b = [[0], [0.36], [0]]
c = [[4.5e-7, -0.00016999999999999999, -1.3e-6]]
d = [[0.61]]
[[observer]]
kind = "h-infinity"
e = [[0.0007000000000000001, 0, 0, 0], [0, 0.0009, 0, 0], [0, 0, 0.7000000000000001, 0]]
d = [[0, 0, 0, 0.005]]
gain = [[0], [0], [378823.5294117647]]
"#,
    ) {
        match found {
            Ok(designed) => assert_ne!(designed.report.verdict.word(), "refuted"),
            Err(failure) => assert!(failure.hypothesis.contains("is undecided"), "{name}: {}", failure.hypothesis),
        }
    }
}

/// `x' = 0`: every gain of the right sign has the same width in the end, `W/|C|`, however small it is.
#[test]
fn a_width_that_no_gain_changes_ends_the_search() {
    let both = [
        ("c = [[-1.5]]", "initial_bounds = [0.01]\nbounds = { noise = [80] }", 80.0 / 1.5),
        (
            "c = [[-0.017]]",
            "initial_bounds = [0.06]\nbounds = { noise = [6], disturbance = [0.5], e = [[0]] }",
            6.0 / 0.017,
        ),
    ];
    for (output, bounds, width) in both {
        let found = all_proved(&format!(
            "[plant]\na = [[0]]\n{output}\n[[observer]]\nkind = \"interval\"\n{bounds}\nleast_width = true\n"
        ));
        let limit = found[0].report.number("half-width of x1 in the end").unwrap();
        assert!(width <= limit && limit < 1.01 * width, "{limit}");
    }
}

/// The mode 0 of a plant in discrete time is inside the unit circle.
#[test]
fn an_unseen_mode_that_ends_in_one_step_leaves_an_observer() {
    let (why, instead) =
        refused("[plant]\na = [[0]]\nc = [[0], [0]]\ndt = 1\n[[observer]]\nkind = \"luenberger\"\npoles = [0]\n");
    assert!(why.starts_with("the plant is not observable: unobservable modes at 0"), "{why}");
    assert!(instead.contains("the plant is detectable") && !instead.contains("no observer"), "{instead}");
    // In continuous time it does not decay.
    let (_, instead) =
        refused("[plant]\na = [[0]]\nc = [[0], [0]]\n[[observer]]\nkind = \"luenberger\"\npoles = [-1]\n");
    assert!(instead.contains("no observer exists"), "{instead}");
}

/// Each pair is observable in exact arithmetic, and the pair in which floating point loses a mode has its name.
#[test]
fn a_mode_that_is_lost_to_rounding_is_one_of_a_pair_with_a_name() {
    let (why, instead) = refused(
        r#"[plant]
a = [[0, 1e-10], [150000, 0]]
c = [[1, 0]]
[[observer]]
e = [[-1], [1]]
kind = "proportional-integral"
poles = [-1, -1, -1]
"#,
    );
    let said = "the pair (A, C) of the plant with its disturbance is not observable to working precision: ";
    assert!(why.starts_with(said) && instead.contains("other units"), "{why}; {instead}");
    let (why, instead) = refused(
        r#"[plant]
a = [[0, 1, 1e-13], [0, 0, 0], [-1, -0.21, 0]]
c = [[1.9, 0, 0]]
[[observer]]
e = [[0], [-1], [0]]
kind = "proportional-integral"
poles = [-2, -2, -2, -2]
"#,
    );
    assert!(why.starts_with("the plant is not observable to working precision: "), "{why}");
    assert!(instead.contains("an observer exists"), "{instead}");
    // Half a period of an oscillation hides it.
    let (why, instead) = refused(
        r#"[plant]
a = [[0, 1], [-1, 0]]
c = [[1, 0]]
[[observer]]
gamma = 1
kind = "sampled-cubic"
poles = [-5, -6]
period = 3.141592653589793
"#,
    );
    assert!(why.starts_with("the sampled pair (Ad, C) is not observable to working precision: "), "{why}");
    assert!(instead.ends_with("hint: a shorter `period`"), "{instead}");
}

/// `T A = 0` by hand: `C E = 16`, `H = (1/16, 0)`, `T = [0 3/8; 0 1]`, and (A, C) is observable. The mode 0 that stays
/// is the invariant zero of (A, E, C): `det [A - s I, E; C, 0] = 16 s`.
#[test]
fn a_mode_of_the_decoupled_plant_is_not_said_of_the_plant() {
    let (why, instead) = refused(
        r#"[plant]
a = [[1, -1], [0, 0]]
c = [[16, -6]]
[[observer]]
e = [[1], [0]]
kalman = { v = [1], w = [6, 0] }
kind = "unknown-input"
"#,
    );
    assert!(why.starts_with("to working precision (A, E, C) has the invariant zero 0, which is not in"), "{why}");
    // The same zero hides a constant disturbance from the outputs: no proportional-integral observer is offered.
    assert!(!instead.contains("proportional-integral") && instead.contains("hint: a further output"), "{instead}");
}

/// Hurwitz's part in discrete time: A - LC is Schur, and the P of `Q = I` fails.
#[test]
fn units_refute_no_observer_in_discrete_time() {
    all_proved(
        r#"[plant]
a = [[0, 0], [-8e16, 0]]
c = [[72000000000000.0, 0.0002]]
dt = 1
[[observer]]
kind = "kalman"
v = [1]
w = [1, 0]
"#,
    );
    all_proved(
        r#"[plant]
a = [[1, 0], [-6.11e-11, 1]]
c = [[0, -4.699999999999999]]
dt = 1
[[observer]]
kind = "luenberger"
poles = [0, -0.2]
"#,
    );
}

/// `E = 0` and a gain for exact outputs: nothing reaches the error.
#[test]
fn a_disturbance_that_does_not_act_has_no_bound() {
    let (why, _) = refused(
        r#"[plant]
a = [[0]]
c = [[0], [1]]
[[observer]]
bounds = { disturbance = [1], e = [[0]] }
kind = "luenberger"
poles = [-1]
"#,
    );
    assert!(why.starts_with("no disturbance within these bounds reaches the error"), "{why}");
}

/// In floating point the slowest pole of this observer is -4.4636, by exact arithmetic -4.4572: it is said as computed.
#[test]
fn a_computed_rate_is_not_among_what_is_proved() {
    let found = all_proved(
        r#"[plant]
a = [[0, 8e-13, 0], [1, 2, 6200000000000.0], [0, 0, 0]]
c = [[520000000.0, 0.000256, 0]]
[[observer]]
decay_rate = 3
kind = "luenberger"
"#,
    );
    let statement = &found[0].report.statement;
    let proved: Vec<String> = statement.proved_sentences().map(ToString::to_string).collect();
    assert!(proved.iter().all(|sentence| !sentence.contains("4.4")) && proved[0].contains("exp(-3 t)"), "{proved:?}");
    assert!(statement.remarks().any(|remark| remark.starts_with("Computed: asymptotic rate exp(-4.4")));
}

/// `E = e2` and the column 6.2e12 e2 of A are dependent: d = 1 acts, and x3 = -1/6.2e12 at rest hides it. `E = e1` is
/// hidden by x of about (0, 1, 0), at which neither A x nor C x is 0.
#[test]
fn a_hidden_disturbance_acts() {
    let cases = [
        ("[[0], [1], [0]]", "d = (1): with x = (0, 0, -1.61e-13)"),
        ("[[1], [0], [0]]", "d = (-8e-13): with x = (-4.92e-13, 1, -3.23e-13)"),
    ];
    for (e, hidden) in cases {
        let (why, _) = refused(&format!(
            "[plant]\na = [[0, 8e-13, 0], [1, 2, 6200000000000.0], [0, 0, 0]]\nc = [[520000000.0, 0.000256, 0]]\n\
             [[observer]]\nkind = \"extended-state\"\ne = {e}\nbandwidth = 2\n"
        ));
        assert!(why.starts_with(&format!("no output sees the constant disturbance {hidden} both ")), "{why}");
    }
}

/// The first mode is hidden; the others differ in the last digit, and the output has their sum: one is lost to
/// rounding.
#[test]
fn modes_that_floating_point_hides_are_not_counted_as_hidden() {
    let both = "[plant]\na = [[-1, 0, 0], [0, 2, 0], [0, 0, 2.0000000000000004]]\nc = [[0, 1, 1]]\n[[observer]]\nkind = \"luenberger\"\npoles = [-1, -2, -3]\n";
    let (why, instead) = refused(both);
    assert!(
        why.starts_with("the plant is not observable, and to working precision its unobservable modes are at "),
        "{why}"
    );
    assert!(why.contains("-1 along x1") && why.contains("2 along x2"), "{why}");
    assert!(instead.contains("hint: an observer exists, since the plant as stored is detectable"), "{instead}");
    let (why, instead) = refused(&both.replace("2.0000000000000004", "3"));
    assert!(why.starts_with("the plant is not observable: unobservable modes at -1 along x1"), "{why}");
    assert!(instead.contains("hint: the unobservable modes are stable"), "{instead}");
}

/// Entries from 3.4e-5 to 2.2e9: in the units given, `P^-1` of the bound would leave the range in which binary64
/// inverts it.
#[test]
fn a_bound_of_a_plant_in_distant_units_is_proved() {
    all_proved(
        r#"[plant]
a = [[-14.0, 3.4e-05, 0], [0, 0, 0], [2200000000.0, -2, 0]]
c = [[0, 0, 0.71], [1, -0.016, 0]]
[[observer]]
kind = "luenberger"
bounds = { noise = [0.00046, 1.5e-13], disturbance = [0], e = [[-46000000.0], [0], [0]] }
poles = [-1, -2, -3]
"#,
    );
}
