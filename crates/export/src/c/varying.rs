//! An observer at varying periods in the header.

use super::scalar;
use crate::Export;

/// The declaration of the prediction and the comment of the step, in the header.
pub(super) fn declarations(export: &Export) -> String {
    let (name, number) = (&export.identifier, scalar(export));
    let upper = name.to_uppercase();
    let unread = if export.names.inputs.is_empty() { "; not read, may be a null pointer" } else { "" };
    let longest = export.observer.scalars().iter().find(|(name, _)| *name == "LONGEST").map_or(0.0, |(_, x)| *x);
    // Six digits: a product of bounds has rounding in the others.
    let longest = format!("{longest:.5e}").parse().unwrap_or(longest);
    format!(
        "
/**
 * A prediction alone, for an input that changes between two samples: the inputs u were applied for the time dt. The next
 * step then takes the time since this call.
 *
 * @param state  State, read and written.
 * @param u      Inputs applied for this time, {upper}_INPUTS entries{unread}.
 * @param dt     The time, from 0 to {longest}; more is predicted less accurately.
 */
void {name}_predict({name}_state *state, const {number} *u, {number} dt);

/**
 * One step, at a sample that has arrived: the prediction over the time that has passed, and the correction. For a sample
 * that is missed there is no call; the next one takes the longer time.
 *
 * @param state  State, read and written.
 * @param u      Inputs applied since the last call, {upper}_INPUTS entries{unread}.
 * @param y      Outputs measured at this sample, {upper}_OUTPUTS entries.
 * @param dt     The time since the last call, from 0 to {longest}; more is predicted less accurately.
 * @param xhat   Estimate at this sample, {upper}_STATES entries; may be a null pointer.
"
    )
}
