//! The time of a sample in the step of a plant that depends on it.

use super::scalar;
use crate::{Export, number};

/// The time of the sample as a variable of the step; 0 if the plant does not depend on it.
pub(crate) fn time(export: &Export) -> String {
    let number = scalar(export);
    if !export.observer.uses_time() {
        return format!("    const {number} t = {};\n", number::c(0.0, export.scalar));
    }
    let period = number::c(export.scalar.round(export.observer.period()), export.scalar);
    format!("    const {number} t = ({number})state->sample * {period};\n")
}

/// The count of the samples, if the plant depends on the time.
pub(super) fn tick(export: &Export) -> &'static str {
    if export.observer.uses_time() { "    ++state->sample;\n" } else { "" }
}
