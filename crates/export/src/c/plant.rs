//! The right-hand sides of a nonlinear plant, and the Runge-Kutta steps of what contains them.

use std::fmt::Write;

use luenberger_expression::{Dialect, Language, Routine};

use super::scalar;
use crate::c_math;
use crate::exportable_observer::{Maps, tables};
use crate::scalar::Scalar;
use crate::{Export, number};

/// How the graphs of an export are written as C.
pub(crate) fn dialect(scalar: Scalar, prefix: &str) -> Dialect<'_> {
    let literal = |x: f64, single: bool| number::c(x, if single { Scalar::Binary32 } else { Scalar::Binary64 });
    Dialect { language: Language::C, single: scalar == Scalar::Binary32, prefix, literal }
}

/// The right-hand sides as functions, with the elementary functions and the tables that they use.
pub(super) fn functions(text: &mut String, export: &Export, maps: &Maps) {
    let prefix = format!("{}_", export.identifier);
    let dialect = dialect(export.scalar, &prefix);
    let (first, second) = (&maps.motion, &maps.measurement);
    let called: std::collections::BTreeSet<_> = maps.routines().flat_map(Routine::functions).collect();
    if !called.is_empty() {
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

/// The outputs by themselves, in another file: h, and Dh if the observer uses it.
pub(crate) fn measurement(text: &mut String, export: &Export, maps: &Maps) {
    let dialect = dialect(export.scalar, "model_");
    let called = maps.measurement.functions();
    if !called.is_empty() {
        _ = write!(text, "\n{}", c_math::source("model", export.scalar, called));
    }
    for (number, table, used) in tables(&[&maps.measurement]) {
        _ = write!(text, "\n{}", table.source(number, &dialect, used));
    }
    function(text, export, ("measurement", "h, then Dh row by row"), &maps.measurement, &dialect);
}

pub(super) fn function(
    text: &mut String,
    export: &Export,
    (name, what): (&str, &str),
    routine: &Routine,
    dialect: &Dialect,
) {
    let number = scalar(export);
    let mut parameters: Vec<String> = Vec::new();
    if routine.uses_time() {
        parameters.push(format!("{number} t"));
    }
    if routine.uses_states() {
        parameters.push(format!("const {number} *x"));
    }
    if routine.uses_inputs() {
        parameters.push(format!("const {number} *u"));
    }
    parameters.push(format!("{number} *out"));
    let body = routine.source(dialect);
    _ = write!(text, "\n/* {what}. */\nstatic void {name}({})\n{{\n{body}}}\n", parameters.join(", "));
}

/// A call of one of the two functions, as a statement.
pub(crate) fn call(name: &str, routine: &Routine, (t, x, out): (&str, &str, &str)) -> String {
    call_with(name, routine, (t, x, "u", out))
}

/// The same with inputs of another name.
pub(super) fn call_with(name: &str, routine: &Routine, (t, x, u, out): (&str, &str, &str, &str)) -> String {
    let mut arguments = Vec::new();
    if routine.uses_time() {
        arguments.push(t);
    }
    if routine.uses_states() {
        arguments.push(x);
    }
    if routine.uses_inputs() {
        arguments.push(u);
    }
    arguments.push(out);
    format!("{name}({});", arguments.join(", "))
}

/// What `slope` takes besides z and the result.
#[derive(Clone, Copy)]
pub(super) struct Arguments {
    pub(super) time: bool,
    /// The name of the inputs.
    pub(super) inputs: Option<&'static str>,
}

impl Arguments {
    pub(super) fn of(maps: &Maps, with_measurement: bool) -> Self {
        let also = |used: fn(&Routine) -> bool| used(&maps.motion) || with_measurement && used(&maps.measurement);
        Self { time: also(Routine::uses_time), inputs: also(Routine::uses_inputs).then_some("u") }
    }

    /// As parameters of a function.
    pub(super) fn parameters(self, number: &str) -> String {
        let time = if self.time { format!("{number} t, ") } else { String::new() };
        let inputs = self.inputs.map_or_else(String::new, |name| format!("const {number} *{name}, "));
        time + &inputs
    }

    /// As arguments of a call at the time `t`.
    pub(super) fn arguments(self, t: &str) -> String {
        let time = if self.time { format!("{t}, ") } else { String::new() };
        time + &self.inputs.map_or_else(String::new, |name| format!("{name}, "))
    }
}

/// One classical Runge-Kutta step of `z' = slope(t, u, z)`, with `length` entries, as a function. The order of
/// operations is `z + (k1 + (k2 + k3) 2 + k4) (tau/6)`.
pub(super) fn runge_kutta(text: &mut String, export: &Export, arguments: Arguments, length: &str) {
    let number = scalar(export);
    let literal = |x: f64| number::c(x, export.scalar);
    let [tau, middle, whole] = export.observer.increments(export.scalar).map(literal);
    let slope = |t: &str, z: &str, k: &str| format!("slope({}{z}, {k});", arguments.arguments(t));
    let moved = |from: &str, by: &str| {
        format!("for (i = 0; i < {length}; ++i) {{\n        moved[i] = z[i] + ({from}[i] * {by});\n    }}")
    };
    _ = write!(
        text,
        "
/* One step of the classical Runge-Kutta method. */
static void runge_kutta({parameters}{number} *z)
{{
    {number} k1[{length}];
    {number} k2[{length}];
    {number} k3[{length}];
    {number} k4[{length}];
    {number} moved[{length}];
    int i;

    {first}
    {half}
    {second}
    {again}
    {third}
    {full}
    {fourth}
    for (i = 0; i < {length}; ++i) {{
        z[i] = z[i] + (((k1[i] + ((k2[i] + k3[i]) * {two})) + k4[i]) * {whole});
    }}
}}
",
        parameters = arguments.parameters(number),
        first = slope("t", "z", "k1"),
        half = moved("k1", &middle),
        second = slope(&format!("t + {middle}"), "moved", "k2"),
        again = moved("k2", &middle),
        third = slope(&format!("t + {middle}"), "moved", "k3"),
        full = moved("k3", &tau),
        fourth = slope(&format!("t + {tau}"), "moved", "k4"),
        two = literal(2.0),
    );
}

/// The loop over the steps between two samples, with a statement after each.
pub(super) fn advance(text: &mut String, export: &Export, arguments: Arguments, substeps: usize, after: &str) {
    let number = scalar(export);
    let [tau, ..] = export.observer.increments(export.scalar).map(|x| number::c(x, export.scalar));
    let now = if arguments.time { format!("t + ({tau} * ({number})k)") } else { String::new() };
    _ = write!(
        text,
        "    for (k = 0; k < {substeps}; ++k) {{\n        runge_kutta({}z);\n{after}    }}\n",
        arguments.arguments(&now)
    );
}

/// `target = sum over k of term(i, j, k)`, from the first k to the last, for i and j, and `after` with the sum.
pub(super) fn contraction(
    text: &mut String,
    number: &str,
    (rows, columns, inner): (&str, &str, &str),
    term: impl Fn(&str) -> String,
    after: &str,
) {
    _ = write!(
        text,
        "    for (i = 0; i < {rows}; ++i) {{
        for (j = 0; j < {columns}; ++j) {{
            {number} sum = {};
            for (k = 1; k < {inner}; ++k) {{
                sum = sum + ({});
            }}
            {after}
        }}
    }}
",
        term("0"),
        term("k")
    );
}

/// The index of an entry of a matrix that is stored by rows behind `offset` other numbers.
pub(super) fn index(offset: &str, (row, column): (&str, &str), stride: &str) -> String {
    let row = if row == "0" { String::new() } else { format!("({row} * {stride})") };
    let column = if column == "0" { "" } else { column };
    let parts: Vec<&str> = [offset, &row, column].into_iter().filter(|part| !part.is_empty()).collect();
    if parts.is_empty() { "0".to_owned() } else { parts.join(" + ") }
}
