//! The sliding-mode observer on a target: the implicit step in closed form, of one and of two states.

use luenberger_export::step::ExpressionStep;
use luenberger_expression::ExpressionPlant;

use crate::design::sliding_mode_gains_of;
use crate::maps::{MapNames, operand};
use crate::study::{SlidingModeSpec, Study};

/// The step as expressions, in the order of `SlidingModeObserver`.
///
/// # Errors
/// Why there is none, and what to do instead.
pub(super) fn step(study: &Study, spec: &SlidingModeSpec) -> Result<ExpressionStep<f64>, (String, Vec<String>)> {
    let plain = |why: String| (why, Vec::new());
    let words = |error: &dyn std::fmt::Display| plain(error.to_string());
    let model = study.plant.model.expressions().map_err(|error| words(&error))?;
    let n = study.plant.states.len();
    let gains = sliding_mode_gains_of(spec, n).map_err(|error| words(&error))?;
    let h = spec.period;
    let f = format!("({})", model.f().last().map_or("0", |row| row.text()));
    let innovation = "(_y1 - _1)";
    let rows = match gains.as_slice() {
        [k] if spec.explicit => vec![format!("(_1 + {}*sign({innovation})) + {}*{f}", operand(h * k), operand(h))],
        [k] => vec![format!("(_1 + sat({innovation}, {}, {})) + {}*{f}", operand(-h * k), operand(h * k), operand(h))],
        [k1, k2] => {
            let corrected = |i: usize| {
                let layer = operand(k2 * h * h);
                if spec.explicit {
                    return match i {
                        0 => format!("(_1 + {}*sqrt(abs({innovation}))*sign({innovation}))", operand(h * k1)),
                        _ => format!("(_2 + {}*sign({innovation}))", operand(h * k2)),
                    };
                }
                let rest = format!("(abs({innovation}) - {layer})");
                let a = operand(h * k1);
                let square = operand((h * k1) * (h * k1));
                let root = format!("(({rest} + {rest})/({a} + sqrt({square} + 4*{rest})))");
                let (inside, outside) = match i {
                    0 => (
                        format!("({}*({innovation}/{layer}))", operand(h * h * k2)),
                        format!("(({a}*{root} + {})*sign({innovation}))", operand(h * h * k2)),
                    ),
                    _ => (
                        format!("({}*({innovation}/{layer}))", operand(h * k2)),
                        format!("({}*sign({innovation}))", operand(h * k2)),
                    ),
                };
                format!("(_{} + if({rest} > 0, {outside}, {inside}))", i + 1)
            };
            let (first, second) = (corrected(0), corrected(1));
            vec![
                format!("({first} + {}*{second}) + {}*{f}", operand(h), operand(h * h / 2.0)),
                format!("{second} + {}*{f}", operand(h)),
            ]
        }
        _ => {
            return Err((
                format!("the kind sliding-mode has an export for one and two states, and the plant has {n}"),
                vec!["kind = \"high-gain\", whose step has no equation to be solved".to_owned()],
            ));
        }
    };
    let scope = MapNames::new(&study.plant, 0).corrected().map_err(|error| words(&error))?;
    let flow = ExpressionPlant::within(&rows, &["_1".to_owned()], &scope).map_err(|error| words(&error))?;
    ExpressionStep::new(flow, study.plant.inputs.len(), h).map_err(|error| words(&error))
}
