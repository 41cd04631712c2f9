//! Recorded observers: one in continuous time with an output predicted between samples, and one whose step is recorded.

use std::fmt::Write;

use luenberger_expression::{Columns, Routine};
use luenberger_observers::{Observer, ObserverDimensions};

use super::kernels::{self, Macros};
use super::{plant, scalar};
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
    let dialect = plant::dialect(export, &prefix);
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
    let dimensions = export.observer.dimensions();
    let results = [("next", dimensions.state)];
    let inputs = [("u", dimensions.inputs), ("y", dimensions.outputs)];
    let prefix = format!("{}_", export.identifier);
    called(text, export, next, &prefix);
    let about = ("advance", "The state after a step");
    function(text, export, about, next, (&prefix, Columns { inputs: &inputs, results: &results }));
    Macros::of(export).write(text, kernels::RECORDED_STEP);
}

/// Update and prediction of a stationary Kalman filter, and its step.
pub(super) fn stationary(text: &mut String, export: &Export, [innovation, filtered, predicted]: &[Routine; 3]) {
    let ObserverDimensions { state, inputs, outputs, .. } = export.observer.dimensions();
    let columns = [("u", inputs), ("y", outputs), ("before", outputs)];
    let about = ("innovate", "The innovation of a sample, what was before of an output that is not finite");
    let results = [("innovation", outputs)];
    function(text, export, about, innovation, ("", Columns { inputs: &columns, results: &results }));
    let (inputs_of_update, results) = ([("innovation", outputs)], [("xhat", state)]);
    let about = ("updated", "The estimate at a sample, for its prediction and innovation");
    function(text, export, about, filtered, ("", Columns { inputs: &inputs_of_update, results: &results }));
    let (columns, results) = ([("u", inputs), ("innovation", outputs)], [("next", state)]);
    let about = ("advance", "The prediction for the next sample");
    function(text, export, about, predicted, ("", Columns { inputs: &columns, results: &results }));
    Macros::of(export).write(text, kernels::STATIONARY_STEP);
}

/// The step of the copy of a nonlinear plant with a constant gain: Runge-Kutta steps with a recorded slope.
pub(super) fn copy(text: &mut String, export: &Export, slope: &Routine) {
    let ObserverDimensions { state, inputs, outputs, .. } = export.observer.dimensions();
    let prefix = format!("{}_", export.identifier);
    called(text, export, slope, &prefix);
    let columns = Columns { inputs: &[("u", inputs)], results: &[("slopes", state), ("slopes", outputs)] };
    let about = "The slopes of the estimate and of the predicted output";
    function(text, export, ("slope", about), slope, (&prefix, columns));
    let mut macros = Macros::of(export);
    macros.integer("LENGTH", state + outputs);
    macros.write(text, kernels::RUNGE_KUTTA);
    macros.write(text, kernels::CONSTANT_GAIN_STEP);
}

/// The elementary functions and the tables that a program uses, with names that begin so.
pub(crate) fn called(text: &mut String, export: &Export, program: &Routine, prefix: &str) {
    let called = program.functions();
    if !called.is_empty() && !export.functions_of_target {
        _ = write!(text, "\n{}", c_math::source(prefix.trim_end_matches('_'), export.scalar, called));
    }
    for (index, table, used) in tables(&[program]) {
        _ = write!(text, "\n{}", table.source(index, &plant::dialect(export, prefix), used));
    }
}

/// A function of t, x and columns, whatever of them the program reads, that writes columns.
pub(crate) fn function(
    text: &mut String,
    export: &Export,
    (name, about): (&str, &str),
    program: &Routine,
    (prefix, columns): (&str, Columns<'_>),
) {
    let number = scalar(export);
    let mut results: Vec<&str> = columns.results.iter().map(|(name, _)| *name).collect();
    results.dedup();
    let inputs = columns.inputs.iter().map(|(name, _)| format!("const {number} *{name}"));
    let results = results.iter().map(|name| format!("{number} *{name}"));
    let first = [format!("{number} t"), format!("const {number} *x")];
    let parameters = first.into_iter().chain(inputs).chain(results).collect::<Vec<_>>().join(", ");
    _ = write!(text, "\n/* {about}. */\nstatic void {name}({parameters})\n{{\n");
    let mut unused: Vec<&str> = [(program.uses_time(), "t"), (program.uses_states(), "x")]
        .into_iter()
        .filter_map(|(is_used, name)| (!is_used).then_some(name))
        .collect();
    let mut first = 0;
    for (name, length) in columns.inputs {
        if !program.uses_inputs_in(first..first + length) {
            unused.push(name);
        }
        first += length;
    }
    for name in unused {
        _ = writeln!(text, "    (void){name};");
    }
    _ = writeln!(text, "{}}}", program.loops(&plant::dialect(export, prefix), columns));
}
