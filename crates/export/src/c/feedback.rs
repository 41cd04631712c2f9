//! The feedback `u = r - K xhat` around the step of an observer.

use std::fmt::Write;

use super::{lengths, product, scalar};
use crate::Export;

/// The first line of the step of the observer, which with feedback is a part of the step of the block.
pub(super) fn head(export: &Export) -> String {
    let (name, number) = (&export.identifier, scalar(export));
    let linkage = if export.feedback.is_some() { "static void observe" } else { &format!("void {name}_step") };
    format!("{linkage}({name}_state *state, const {number} *u, const {number} *y, {number} *xhat)")
}

/// The feedback and the step of the block, in the source.
pub(super) fn block(text: &mut String, export: &Export) {
    if export.feedback.is_none() {
        return;
    }
    let (name, number) = (&export.identifier, scalar(export));
    let (upper, _) = lengths(export);
    let [n, m] = ["STATES", "INPUTS"].map(|what| format!("{upper}_{what}"));
    _ = write!(
        text,
        "
void {name}_input(const {name}_state *state, const {number} *r, {number} *u)
{{
    int i;
    int j;

"
    );
    product(text, number, ("K", &m, &n), "state->xhat", "u[i] = r[i] - sum;");
    _ = write!(
        text,
        "}}

void {name}_step({name}_state *state, const {number} *r, const {number} *y, {number} *u, {number} *xhat)
{{
    {number} input[{m}];

    {name}_input(state, r, input);
    observe(state, input, y, xhat);
    if (u != NULL) {{
        int i;
        for (i = 0; i < {m}; ++i) {{
            u[i] = input[i];
        }}
    }}
}}
"
    );
}

/// The declarations of both, in the header; `not_finite` says what values that are not finite do.
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
