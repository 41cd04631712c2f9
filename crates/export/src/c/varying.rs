//! An observer at varying periods: its declarations in the header, and its step.

use luenberger_expression::Columns;
use luenberger_observers::varying_period::DEGREE;
use luenberger_observers::{ObserverDimensions, SampledObserver, VaryingPeriodStep};
use nalgebra::Dyn;

use super::kernels::{self, Macros};
use super::{recorded, scalar};
use crate::error::ExportError;
use crate::{Export, program};

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
 * A prediction alone, for an input that changes between two samples: the inputs u were applied for the time dt. At the
 * sample follow {name}_predict for the rest of the time and {name}_update with the time since the last sample, in place
 * of {name}_step.
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
 * @param u      Inputs applied since the last sample, {upper}_INPUTS entries{unread}.
 * @param y      Outputs measured at this sample, {upper}_OUTPUTS entries.
 * @param dt     The time since the last step, also one whose y was NAN, from 0 to {longest}; more is predicted less
 *               accurately.
 * @param xhat   Estimate at this sample, {upper}_STATES entries; may be a null pointer.
"
    )
}

/// The prediction and the correction; the time since the last call is the last input.
pub(super) fn step(
    text: &mut String,
    export: &Export,
    step: &VaryingPeriodStep<f64, Dyn, Dyn, Dyn>,
) -> Result<(), ExportError> {
    let ObserverDimensions { state, inputs, outputs, .. } = step.dimensions();
    let [first, further, corrected] = program::varying(export, step)?;
    let results = [("next", state)];
    let series = Columns { inputs: &[("u", inputs), ("tau", 1), ("degree", 1)], results: &results };
    let about = "The first term of the series of the exponential";
    recorded::function(text, export, ("first_term", about), &first, ("", series));
    let about = "A term of the series of the exponential, from the one before it";
    recorded::function(text, export, ("next_term", about), &further, ("", series));
    let correction = Columns { inputs: &[("u", inputs), ("y", outputs)], results: &results };
    recorded::function(text, export, ("corrected", "The state after a correction"), &corrected, ("", correction));
    let mut macros = Macros::of(export);
    let parts = export.observer.prediction_substeps(export.scalar);
    macros.number("PARTS", parts as f64);
    macros.integer("PART_COUNT", parts);
    macros.integer("SERIES_DEGREE", DEGREE);
    macros.write(text, kernels::VARYING);
    Ok(())
}
