//! Bounds of errors that a constant estimate has too are no results.

use luenberger_study::deployment::{ExportOptions, Precision, export};

use crate::studies::{designed, read};

/// `x'' = -x - x'/2` from (1, 0): x1 swings from 1 to -exp(-pi/4/sqrt(15/16)) = -0.44, half of its range is 0.72.
fn swinging(noise: f64) -> String {
    format!(
        "[plant]\na = [[0, 1], [-1, -0.5]]\nc = [[1, 0]]\n[simulation]\nx0 = [1, 0]\nduration = 20\n\
         [[observer]]\nkind = \"luenberger\"\nname = \"gain\"\npoles = [-4, -5]\nbounds = {{ noise = [{noise}] }}\n"
    )
}

/// The gain is (8.5, 14.75): noise of 10 leaves bounds of several units, noise of 0.001 of thousandths.
#[test]
fn a_bound_above_half_of_the_range_is_not_printed() {
    for (noise, is_useful) in [(10.0, false), (0.001, true)] {
        let found = designed(&read(&swinging(noise)).unwrap()).unwrap();
        let said = found.report.statement.to_string();
        assert_eq!(found.report.verdict.word(), "proved");
        for state in ["x1", "x2"] {
            assert_eq!(said.contains(&format!("{state}: no useful bound")), !is_useful, "{noise}: {said}");
            let number = found.report.number(&format!("bound of the error of {state}"));
            assert_eq!(number.is_some(), is_useful, "{noise}: {number:?}");
        }
        let why = "No useful bound of x1, x2: along the study's simulation a constant estimate has a smaller error";
        assert_eq!(said.contains(why) && said.contains("What may give one"), !is_useful, "{said}");
    }
    // Without a simulation there is no range.
    let alone = swinging(10.0).replace("[simulation]\nx0 = [1, 0]\nduration = 20\n", "");
    let found = designed(&read(&alone).unwrap()).unwrap();
    assert!(found.report.number("bound of the error of x1").unwrap() > 1.0);
}

/// Whatever is added to a state, the judgement is the same, and in other units too: x1 in thousandths.
#[test]
fn units_do_not_change_what_is_useful() {
    let scaled = swinging(10.0).replace("[[0, 1], [-1, -0.5]]", "[[0, 1000], [-0.001, -0.5]]");
    let scaled = scaled.replace("x0 = [1, 0]", "x0 = [1000, 0]").replace("noise = [10]", "noise = [10000]");
    let said = |text: &str| designed(&read(text).unwrap()).unwrap().report.statement.to_string();
    let marks = |text: &str| said(text).matches("no useful bound").count();
    assert_eq!((marks(&scaled), marks(&swinging(10.0))), (2, 2));
}

/// The motor of a user: with noise at its bounds in every sample the sampled cubic observer is proved to stay within
/// 25200 A, where the current is at most 11 A. In Q6.26 the speed of 68.3 rad/s needs 8 bits before the point.
#[test]
fn an_export_says_why_a_bound_is_not_useful_and_which_bits_are_missing() {
    let motor = "[plant]\na = [[0, 1, 0], [0, -3, 25], [0, -10, -200]]\nb = [[0], [0], [500]]\nc = [[1, 0, 0]]\n\
         states = [\"theta\", \"omega\", \"current\"]\n[input]\nexpressions = [\"5*sin(4*t)\"]\n\
         [simulation]\nx0 = [0.5, 0, 0]\nduration = 3\nsamples = 3001\nhold = 0.001\n\
         noise = { distribution = \"gaussian\", amplitude = [0.001], period = 0.001, seed = 3 }\n\
         [[observer]]\nname = \"kf\"\nkind = \"kalman\"\nw = [[1e-6, 0, 0], [0, 1, 0], [0, 0, 1]]\nv = [[1e-6]]\n\
         [[observer]]\nname = \"cubic\"\nkind = \"sampled-cubic\"\npoles = [-30, -40, -210]\ngamma = 1\nperiod = 0.001\n";
    let study = read(motor).unwrap();
    let said = |observer: &str, format: &str| {
        // Coarse gains would not stabilise.
        let gains = (format == "q16.2").then(|| Precision::fixed_point("q10.22").unwrap());
        let options = ExportOptions { format: format.parse::<Precision>().unwrap(), gains, ..ExportOptions::default() };
        export(&study, Some(observer), &options).unwrap().statement.join(" ")
    };
    let cubic = said("cubic", "f64");
    assert!(cubic.contains("current: no useful bound") && !cubic.contains("current 2"), "{cubic}");
    assert!(cubic.contains("It comes from the measurement noise, at its bound in every sample."), "{cubic}");
    let coarse = said("kf", "q16.2");
    assert!(
        coarse.contains("omega: no useful bound") && coarse.contains("It comes from the rounding to Q16.2."),
        "{coarse}"
    );
    assert!(coarse.contains("What may give one: a format with more bits after the point."), "{coarse}");
    assert!(!said("kf", "f64").contains("no useful bound"));
    let narrow = said("kf", "q6.26");
    assert!(narrow.contains("Q8.24 has the bits before the point"), "{narrow}");
}

/// A position of 20 in Q4.28, whose range ends at 8: the estimates are far from those of the study because they are cut
/// off, at any period. A range of 128 holds it.
#[test]
fn a_difference_of_saturation_is_no_reason_for_a_shorter_period() {
    let study = read(&swinging(0.001).replace("x0 = [1, 0]", "x0 = [20, 0]")).unwrap();
    let said = |format: &str| {
        let format = format.parse::<Precision>().unwrap();
        let options = ExportOptions { format, period: Some(0.01), unproved: true, ..ExportOptions::default() };
        export(&study, None, &options).unwrap().statement.join(" ")
    };
    let (cut, whole) = (said("q4.28"), said("q8.24"));
    assert!(cut.contains("of the run a value is beyond the range of Q4.28 and cut off at its end"), "{cut}");
    assert!(!cut.contains("a shorter period brings"), "{cut}");
    assert!(!whole.contains("beyond the range"), "{whole}");
}

/// An option without an effect is named.
#[test]
fn substeps_of_a_linear_observer_are_said_to_change_nothing() {
    let study = read(&swinging(0.001)).unwrap();
    let notes = |substeps| {
        let options = ExportOptions { period: Some(0.01), unproved: true, substeps, ..ExportOptions::default() };
        export(&study, None, &options).unwrap().notes
    };
    assert_eq!(notes(None), [""; 0]);
    assert_eq!(notes(Some(3)), ["--substeps changes nothing: the step of gain has no Runge-Kutta steps"]);
}

/// Twelve integrators in a chain, with poles from -1 to -12: the design is proved, and the gain of its step at short
/// periods is lost in rounding. The refusal says what may help; a longer period does.
#[test]
fn a_step_whose_gain_is_lost_in_rounding_has_a_hint() {
    let row = |i: usize| {
        (0..12)
            .map(|j| {
                if j == i + 1 {
                    "1"
                } else if i == 11 && j == 11 {
                    "-1"
                } else {
                    "0"
                }
            })
            .collect::<Vec<_>>()
    };
    let a: Vec<String> = (0..12).map(|i| format!("[{}]", row(i).join(", "))).collect();
    let (a, c) = (a.join(", "), format!("[[1{}]]", ", 0".repeat(11)));
    let poles = (1..=12).map(|i| format!("-{i}")).collect::<Vec<_>>().join(", ");
    let text = format!("[plant]\na = [{a}]\nc = {c}\n[[observer]]\nkind = \"luenberger\"\npoles = [{poles}]\n");
    let study = read(&text).unwrap();
    for period in [0.01, 1e-6] {
        let refused = export(&study, None, &ExportOptions::default().period(period)).unwrap_err().to_string();
        assert!(refused.contains("is not inside the unit circle") && refused.contains("a longer one too"), "{refused}");
        assert!(refused.contains("a Kalman filter"), "{refused}");
    }
    assert!(export(&study, None, &ExportOptions::default().period(0.1)).is_ok());
}
