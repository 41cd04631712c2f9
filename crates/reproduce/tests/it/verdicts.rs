//! The rules from evidence to verdict, one by one.

use luenberger_proof::{Matrix, UndecidedReason, Verdict as Proof};
use luenberger_reproduce::evidence::{JudgeError, Judgement, judge};
use luenberger_reproduce::{Counterexample, Evidence, Hypothesis, Printed, Tolerance, Value, Verdict};

fn verdict(printed: &Printed, tolerance: Tolerance, evidence: &Evidence) -> Verdict {
    judge(printed, tolerance, evidence).unwrap().verdict
}

fn as_printed(text: &'static str, computed: impl Into<Value>) -> Verdict {
    verdict(&Printed::Decimals(text), Tolerance::AsPrinted, &Evidence::value(computed))
}

fn on_truth(evidence: &Evidence) -> (Verdict, Verdict) {
    let on = |truth| verdict(&Printed::Holds(truth), Tolerance::AsPrinted, evidence);
    (on(true), on(false))
}

use Verdict::{Refuted, Reproduced, Underspecified};

#[test]
fn a_number_is_held_to_half_a_unit_of_its_last_digit() {
    assert_eq!(as_printed("1.18", 1.1751), Reproduced);
    assert_eq!(as_printed("1.18", 1.1694), Refuted);
    assert_eq!(as_printed(".0014", 0.001_363), Reproduced);
    assert_eq!(as_printed("1.2", 1.25), Reproduced, "the edge itself, although 1.2 + 0.05 < 1.25 in binary");
    assert_eq!(as_printed("1.2", 1.250_000_1), Refuted);
    assert_eq!(as_printed("1.2", f64::NAN), Refuted);
    assert_eq!(as_printed("1.2", f64::INFINITY), Refuted);
}

#[test]
fn every_entry_of_a_matrix_is_held_to_its_own_digits() {
    let matrix = |x| nalgebra::DMatrix::from_row_slice(2, 2, &[13.5, -2.4, -2.4, x]);
    assert_eq!(as_printed("13.5 -2.4; -2.4 1.07", matrix(1.0749)), Reproduced);
    assert_eq!(as_printed("13.5 -2.4; -2.4 1.07", matrix(1.0751)), Refuted);
    assert_eq!(as_printed("7.5; 3.1", nalgebra::DMatrix::from_row_slice(2, 1, &[7.52, 3.1])), Reproduced);
}

#[test]
fn a_tolerance_may_be_stated() {
    let on = |tolerance| verdict(&Printed::Decimals("500"), tolerance, &Evidence::value(504.0));
    assert_eq!(on(Tolerance::AsPrinted), Refuted);
    assert_eq!(on(Tolerance::Absolute(5.0)), Reproduced);
    assert_eq!(on(Tolerance::Relative(0.01)), Reproduced);
    assert_eq!(on(Tolerance::Relative(0.001)), Refuted);
    let exactly =
        |computed: f64| verdict(&Printed::Exactly(3.0.into()), Tolerance::AsPrinted, &Evidence::value(computed));
    assert_eq!((exactly(3.0), exactly(3.000_001)), (Reproduced, Refuted));
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            judge(&Printed::Decimals("1"), Tolerance::Absolute(bad), &Evidence::value(1.0)),
            Err(JudgeError::Tolerance(_))
        ));
    }
}

#[test]
fn a_truth_is_held_to_the_truth_printed() {
    assert_eq!(on_truth(&Evidence::holds(true)), (Reproduced, Refuted));
    assert_eq!(on_truth(&Evidence::holds(false)), (Refuted, Reproduced));
    let Judgement { computed, tolerance, .. } =
        judge(&Printed::Holds(true), Tolerance::AsPrinted, &Evidence::holds_by(false, 0.25)).unwrap();
    assert_eq!((computed, tolerance), (Value::Number(0.25), None));
}

#[test]
fn readings_that_disagree_leave_the_claim_underspecified() {
    let readings = |values: &[f64]| {
        let named = ["last crossing", "first crossing", "another"].into_iter();
        Evidence::Readings(named.zip(values.iter().map(|&x| Value::Number(x))).collect())
    };
    let on = |values: &[f64]| judge(&Printed::Decimals("1.7"), Tolerance::AsPrinted, &readings(values)).unwrap();
    assert_eq!(on(&[1.68, 1.71]).verdict, Reproduced);
    assert_eq!(on(&[0.6, 0.7]).verdict, Refuted);
    let mixed = on(&[0.6, 1.71, 0.5]);
    assert_eq!((mixed.verdict, mixed.computed), (Underspecified, Value::Number(1.71)));
    assert_eq!(mixed.remarks[0], "Reading: last crossing: 0.6, does not agree.");
    assert_eq!(judge(&Printed::Decimals("1.7"), Tolerance::AsPrinted, &readings(&[])), Err(JudgeError::NoReadings));
}

#[test]
fn a_proof_decides_and_doubt_does_not() {
    let proved = Evidence::proof(&Proof::<f64>::Proved { margin: 0.5 });
    let refuted = Evidence::proof(&Proof::Refuted { witness: 0.25 });
    let undecided = Evidence::proof(&Proof::<f64>::Undecided { why: UndecidedReason::Overflow, best: 0.1 });
    assert_eq!(on_truth(&proved), (Reproduced, Refuted));
    assert_eq!(on_truth(&refuted), (Refuted, Reproduced));
    assert_eq!(on_truth(&undecided), (Underspecified, Underspecified));
    let shown = judge(&Printed::Holds(true), Tolerance::AsPrinted, &undecided).unwrap();
    assert!(!shown.computed.is_finite(), "an undecided statement computes no truth");
}

#[test]
fn a_counterexample_counts_only_if_it_violates_the_statement() {
    let at = |violation| Evidence::counterexample("|e| <= 1", violation, None, vec![]);
    assert_eq!(on_truth(&at(0.3)).0, Refuted);
    assert_eq!(on_truth(&at(0.0)).0, Underspecified);
    assert_eq!(on_truth(&at(f64::NAN)).0, Underspecified);
}

/// A case outside of the theorem's hypotheses is none, however far it violates the conclusion; one valid case among
/// several refutes.
#[test]
fn a_counterexample_counts_only_within_the_hypotheses() {
    let positive =
        |x: f64| Hypothesis::proof("x > 0", &luenberger_proof::positive_definite(&Matrix::from_rows([[x]])).unwrap());
    let case = |hypotheses| Counterexample {
        case: "x".to_owned(),
        what: "|e| <= 1".to_owned(),
        violation: 1.0,
        witness: None,
        hypotheses,
    };
    let open = Hypothesis { holds: None, ..positive(1.0) };
    assert_eq!((positive(1.0).word(), positive(0.0).word(), open.word()), ("holds", "fails", "undecided"));
    let of = |cases: &[&Hypothesis]| {
        Evidence::Counterexamples(cases.iter().map(|found| case(vec![(*found).clone()])).collect())
    };
    let (holds, fails) = (positive(1.0), positive(0.0));
    assert_eq!(on_truth(&of(&[&holds])).0, Refuted);
    assert_eq!(on_truth(&of(&[&fails])).0, Underspecified);
    assert_eq!(on_truth(&of(&[&open])).0, Underspecified);
    assert_eq!(on_truth(&of(&[&fails, &holds])).0, Refuted);
    assert_eq!(on_truth(&of(&[])).0, Underspecified);
    // The same for other evidence, whichever way it decides.
    for (truth, verdict) in [(false, Refuted), (true, Reproduced)] {
        let judged = || judge(&Printed::Holds(true), Tolerance::AsPrinted, &Evidence::holds(truth)).unwrap();
        assert_eq!(judged().under(std::slice::from_ref(&holds)).verdict, verdict);
        assert_eq!(judged().under(std::slice::from_ref(&fails)).verdict, Underspecified);
        assert_eq!(judged().under(&[holds.clone(), open.clone()]).verdict, Underspecified);
    }
}

#[test]
fn one_failing_case_refutes_and_no_case_shows_nothing() {
    let cases = |truths: &[Option<bool>]| Evidence::cases(truths.iter().copied());
    assert_eq!(on_truth(&cases(&[Some(true); 64])).0, Reproduced);
    assert_eq!(on_truth(&cases(&[Some(true), Some(false), None])).0, Refuted);
    assert_eq!(on_truth(&cases(&[Some(true), None])).0, Underspecified);
    assert_eq!(on_truth(&cases(&[])).0, Underspecified);
    assert_eq!(on_truth(&cases(&[Some(false)])).0, Refuted);
}

#[test]
fn what_cannot_be_compared_is_a_mistake_and_no_verdict() {
    for (printed, evidence) in [
        (Printed::Decimals("1.0"), Evidence::holds(true)),
        (Printed::Holds(true), Evidence::value(1.0)),
        (Printed::Decimals("1 2"), Evidence::value(1.0)),
        (Printed::Decimals("1 2; 3 4"), Evidence::value([1.0, 2.0, 3.0, 4.0])),
    ] {
        let judged = judge(&printed, Tolerance::AsPrinted, &evidence);
        assert!(matches!(judged, Err(JudgeError::Incomparable { .. })), "{printed:?} {evidence:?} {judged:?}");
    }
}
