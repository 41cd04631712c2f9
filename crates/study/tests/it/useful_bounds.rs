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
