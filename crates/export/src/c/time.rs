//! The time of a sample in the step of a plant that depends on it.

use super::scalar;
use crate::{Export, number};

/// The time of the sample as a variable of the step, if the plant depends on it.
pub(crate) fn time(export: &Export) -> String {
    if !export.observer.uses_time() {
        return String::new();
    }
    let number = scalar(export);
    let period = number::c(export.scalar.round(export.observer.period()), export.scalar);
    format!("    const {number} t = ({number})state->sample * {period};\n")
}

/// The count of the samples, if the plant depends on the time.
pub(super) fn tick(export: &Export) -> &'static str {
    if export.observer.uses_time() { "    ++state->sample;\n" } else { "" }
}
