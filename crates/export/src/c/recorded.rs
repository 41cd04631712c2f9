//! Recorded observers: one in continuous time with an output predicted between samples, and one whose step is recorded.

use std::fmt::Write;

use luenberger_expression::Routine;
use luenberger_observers::Observer;

use super::kernels::{self, Macros};
use super::plant;
use crate::c_math;
use crate::exportable_observer::{Maps, tables};
use crate::extension::{ExtensionMaps, SampledExtension};
use crate::{Export, number};

/// States of the observer.
pub(super) fn order(observer: &SampledExtension<f64>) -> usize {
    Observer::<f64>::dimensions(observer.observer()).state
}

/// The functions of the plant and of the observer, and its start.
pub(super) fn start(text: &mut String, export: &Export, maps: &Maps, own: &ExtensionMaps) {
    plant::functions(text, export, maps);
    let prefix = format!("{}_", export.identifier);
    let dialect = plant::dialect(export.scalar, &prefix);
    let all = [
        ("rate", "The right-hand side of the observer; its inputs are (u, y)", &own.rate),
        ("estimate", "The estimate", &own.estimate),
        ("start", "The state of the observer for an estimate; its inputs are y", &own.start),
    ];
    let jump =
        own.jump.iter().map(|jump| ("jump", "The state after the jump at a sample; its inputs are (u, y)", jump));
    for (name, what, routine) in all.into_iter().chain(jump) {
        plant::function(text, export, (name, what), routine, &dialect);
    }
    let mut macros = Macros::of(export);
    macros.option("STARTS_WITH_OUTPUT", own.start.uses_inputs());
    macros.write(text, kernels::RECORDED_START);
}

/// The step of the observer in continuous time.
pub(super) fn flow(text: &mut String, export: &Export, observer: &SampledExtension<f64>, own: &ExtensionMaps) {
    let mut macros = Macros::of(export);
    let order = order(observer);
    macros.integer("ORDER", order);
    macros.integer("LENGTH", order + export.observer.dimensions().outputs);
    macros.option("HAS_JUMP", own.jump.is_some());
    let period = number::c(export.observer.period(), export.scalar);
    macros.set("T_ESTIMATE", if own.estimate.uses_time() { format!("t + {period}") } else { "t".to_owned() });
    for kernel in [kernels::RECORDED_SLOPE, kernels::RUNGE_KUTTA, kernels::RECORDED_FLOW] {
        macros.write(text, kernel);
    }
}

/// The recorded step.
pub(super) fn step(text: &mut String, export: &Export, next: &Routine) {
    let prefix = format!("{}_", export.identifier);
    let dialect = plant::dialect(export.scalar, &prefix);
    let called = next.functions();
    if !called.is_empty() {
        _ = write!(text, "\n{}", c_math::source(&export.identifier, export.scalar, called));
    }
    for (index, table, used) in tables(&[next]) {
        _ = write!(text, "\n{}", table.source(index, &dialect, used));
    }
    plant::function(text, export, ("motion", "The next state; the inputs are (u, y)"), next, &dialect);
    Macros::of(export).write(text, kernels::RECORDED_STEP);
}
