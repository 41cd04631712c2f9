//! The right-hand sides of a nonlinear plant, as functions of (t, x, u).

use std::fmt::Write;

use luenberger_expression::{Dialect, Language, Routine};

use super::scalar;
use crate::c_math;
use crate::exportable_observer::{Maps, tables};
use crate::scalar::Scalar;
use crate::{Export, number};

/// How the graphs of an export are written as C.
pub(crate) fn dialect<'a>(export: &Export, prefix: &'a str) -> Dialect<'a> {
    let literal = |x: f64, single: bool| number::c(x, if single { Scalar::Binary32 } else { Scalar::Binary64 });
    let (single, of_target) = (export.scalar == Scalar::Binary32, export.functions_of_target);
    Dialect { language: Language::C, single, prefix, of_target, literal }
}

/// The right-hand sides as functions, with the elementary functions and the tables that they use.
pub(super) fn functions(text: &mut String, export: &Export, maps: &Maps) {
    let prefix = format!("{}_", export.identifier);
    let dialect = dialect(export, &prefix);
    let (first, second) = (&maps.motion, &maps.measurement);
    let called = maps.functions();
    if !called.is_empty() && !export.functions_of_target {
        _ = write!(text, "\n{}", c_math::source(&export.identifier, export.scalar, called));
    }
    for (number, table, used) in tables(&maps.routines().collect::<Vec<_>>()) {
        _ = write!(text, "\n{}", table.source(number, &dialect, used));
    }
    let size = export.observer.dimensions();
    let motion = if first.len() > size.estimate { "f, then Df row by row" } else { "f" };
    let measurement = if second.len() > size.outputs { "h, then Dh row by row" } else { "h" };
    function(text, export, ("motion", motion), first, &dialect);
    function(text, export, ("measurement", measurement), second, &dialect);
    if let Some(centre) = &maps.centre {
        function(text, export, ("centre", "f, then Df row by row"), centre, &dialect);
    }
}

/// A function of (t, x, u), whatever of them the routine reads.
pub(super) fn function(
    text: &mut String,
    export: &Export,
    (name, what): (&str, &str),
    routine: &Routine,
    dialect: &Dialect,
) {
    let number = scalar(export);
    _ = write!(
        text,
        "\n/* {what}. */\nstatic void {name}({number} t, const {number} *x, const {number} *u, {number} *out)\n{{\n"
    );
    let used = [(routine.uses_time(), "t"), (routine.uses_states(), "x"), (routine.uses_inputs(), "u")];
    for (_, name) in used.iter().filter(|(is_used, _)| !is_used) {
        _ = writeln!(text, "    (void){name};");
    }
    _ = writeln!(text, "{}}}", routine.source(dialect));
}
