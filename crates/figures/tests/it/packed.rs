//! The numbers of a curve in a page.

use luenberger_figures::figure::Scale;
use luenberger_figures::internals::{Axis, STEP, numbers, step};
use serde_json::{Value as Json, json};

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
