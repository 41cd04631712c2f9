//! The numbers of a curve as a page stores them: multiples of a step that a screen does not show, each as the
//! difference of its count from the one before.

use super::Scale;
use super::ticks::Axis;
use serde_json::{Value as Json, json};

/// The largest step, in parts of the axis: a tenth of a pixel.
pub const STEP: f64 = 1e-4;

/// The largest count: sums and differences of counts up to it are exact in the page.
const COUNT: f64 = 9e15;

/// `{ of, by }` with the step `of`, and `log` where the multiples are decimal logarithms; null stays null. A curve that
/// leaves the axis by more than that many steps stays an array of numbers with five digits.
pub fn numbers(values: impl IntoIterator<Item = Option<f64>>, axis: &Axis) -> Json {
    let log = axis.scale == Scale::Log;
    let step = step(if log { (axis.to / axis.from).log10() } else { axis.to - axis.from });
    let values: Vec<Option<f64>> = values.into_iter().collect();
    let count = |value: f64| ((if log { value.log10() } else { value }) / step).round();
    if values.iter().flatten().any(|value| count(*value).abs() > COUNT) {
        return json!(values.iter().map(|value| value.map(digits)).collect::<Vec<_>>());
    }
    let mut before = 0.0;
    let by = values.iter().map(|value| {
        let count = count((*value)?);
        let by = count - before;
        before = count;
        Some(by as i64)
    });
    let by: Vec<Option<i64>> = by.collect();
    if log { json!({ "of": step, "by": by, "log": true }) } else { json!({ "of": step, "by": by }) }
}

/// Five significant digits.
pub(super) fn digits(x: f64) -> f64 {
    // What is printed in this form always reads back.
    format!("{x:.4e}").parse().unwrap_or(x)
}

/// The largest of 1, 2 and 5 times a power of ten that is at most [`STEP`] of the span.
pub fn step(span: f64) -> f64 {
    let most = STEP * span;
    let exponent = most.log10().floor() as i32;
    // Read as decimals, so that the page has few digits and not their rounding errors.
    let of = |factor: u32, exponent: i32| format!("{factor}e{exponent}").parse().unwrap_or(most);
    let candidates = [of(5, exponent), of(2, exponent), of(1, exponent)];
    candidates.into_iter().find(|step: &f64| *step <= most).unwrap_or(most)
}
