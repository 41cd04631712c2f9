//! The feedback `u = r - K xhat` around the step of an observer.

use super::scalar;
use crate::Export;

/// The declarations of the feedback and of the step of the block, in the header; `not_finite` says what values that are
/// not finite do.
pub(super) fn declarations(export: &Export) -> String {
    let (name, number) = (&export.identifier, scalar(export));
    let upper = name.to_uppercase();
    format!(
        "
/**
 * The input to apply from this sample to the next, u = r - K xhat. It is that of the step, before its measurement is
 * there: the plant need not wait for the step.
 *
 * @param state  State, read.
 * @param r      References, {upper}_INPUTS entries; zeros for u = -K xhat.
 * @param u      Inputs to apply, {upper}_INPUTS entries.
 */
void {name}_input(const {name}_state *state, const {number} *r, {number} *u);

/**
 * One step, from the sample at t to the estimate at t + period, with u = r - K xhat. The plant must get this u: one that
 * an actuator limits makes the estimate wrong.
 *
 * @param state  State, read and written.
 * @param r      References, {upper}_INPUTS entries; zeros for u = -K xhat.
 * @param y      Outputs measured at this sample, {upper}_OUTPUTS entries.
 * @param u      Inputs applied from this sample to the next, {upper}_INPUTS entries; may be a null pointer.
 * @param xhat   Estimate for the next sample, {upper}_STATES entries; may be a null pointer.
"
    )
}
