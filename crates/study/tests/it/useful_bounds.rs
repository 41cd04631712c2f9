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
