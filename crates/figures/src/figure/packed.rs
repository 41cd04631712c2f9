//! The numbers of a curve as a page stores them: multiples of a step that a screen does not show, each as the
//! difference of its count from the one before.

use super::Scale;
use super::ticks::Axis;
use serde_json::{Value as Json, json};

/// The largest step, in parts of the axis: a tenth of a pixel.
const STEP: f64 = 1e-4;

/// The largest count: sums and differences of counts up to it are exact in the page.
const COUNT: f64 = 9e15;

/// `{ of, by }` with the step `of`, and `log` where the multiples are decimal logarithms; null stays null. A curve that
/// leaves the axis by more than that many steps stays an array of numbers with five digits.
pub(super) fn numbers(values: impl IntoIterator<Item = Option<f64>>, axis: &Axis) -> Json {
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
fn step(span: f64) -> f64 {
    let most = STEP * span;
    let exponent = most.log10().floor() as i32;
    // Read as decimals, so that the page has few digits and not their rounding errors.
    let of = |factor: u32, exponent: i32| format!("{factor}e{exponent}").parse().unwrap_or(most);
    let candidates = [of(5, exponent), of(2, exponent), of(1, exponent)];
    candidates.into_iter().find(|step: &f64| *step <= most).unwrap_or(most)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the script of the page makes of it.
    fn unpacked(packed: &Json) -> Vec<Option<f64>> {
        let (mut count, step) = (0, packed["of"].as_f64().unwrap());
        let log = packed["log"] == true;
        let of = |by: &Json| {
            count += by.as_i64()?;
            let value = count as f64 * step;
            Some(if log { 10_f64.powf(value) } else { value })
        };
        packed["by"].as_array().unwrap().iter().map(of).collect()
    }

    #[test]
    fn every_number_is_within_half_a_step() {
        for (axis, values) in [
            (Axis { from: -3.0, to: 4.5, scale: Scale::Linear }, [-3.0, 4.5, 0.1234567, -0.7, 4.4999]),
            (Axis { from: 1e6, to: 1e6 + 1e-3, scale: Scale::Linear }, [1e6, 1e6 + 5e-4, 1e6 + 1e-3, 1e6, 1e6 + 1e-4]),
            (Axis { from: 1e-12, to: 10.0, scale: Scale::Log }, [1e-12, 10.0, 3.3e-7, 0.02, 9.99]),
        ] {
            let packed = numbers(values.map(Some), &axis);
            for (value, found) in values.iter().zip(unpacked(&packed)) {
                let apart = (axis.place(found.unwrap()) - axis.place(*value)).abs();
                assert!(apart <= 0.51 * STEP, "{value} became {found:?}");
            }
        }
    }

    #[test]
    fn steps_are_round_and_gaps_stay() {
        assert_eq!([1.0, 2.0, 7.0, 30.0].map(step), [1e-4, 2e-4, 5e-4, 2e-3]);
        let packed = numbers([Some(0.5), None, Some(0.25)], &Axis { from: 0.0, to: 1.0, scale: Scale::Linear });
        assert_eq!(packed, json!({ "of": 1e-4, "by": [5000, null, -2500] }));
        // A curve that runs away, of which the axis shows the beginning.
        let packed = numbers([Some(0.5), Some(1e20)], &Axis { from: 0.0, to: 1.0, scale: Scale::Linear });
        assert_eq!(packed, json!([0.5, 1e20]));
    }
}
