//! The step of the moving-horizon estimator: measurement, prediction, and the arrival cost.
//!
//! The window is in arrays of fixed lengths, and every loop has a fixed bound: the Gauss-Newton steps of the study, and
//! where a bound is active as many of the interior-point method as the Rust estimator takes.
//!
//! | file | subject |
//! |---|---|
//! | `pass` | one Gauss-Newton step: a Kalman filter forward and its adjoint backward |
//! | `interior` | the interior-point method |

mod interior;
mod pass;

use std::fmt::Write;

use super::kernels::Macros;
use super::plant;
use super::{feedback, filter, is_finite, lengths, root, scalar};
use crate::exportable_observer::Maps;
use crate::moving_horizon::{Bound, MovingHorizon, bounds};
use crate::{Export, number};

/// What the pieces of the source share.
struct Writer<'a> {
    export: &'a Export,
    maps: &'a Maps,
    estimator: &'a MovingHorizon<f64>,
    bounds: Vec<Bound>,
    number: &'static str,
    n: String,
    p: String,
    window: String,
}

impl Writer<'_> {
    fn literal(&self, x: f64) -> String {
        number::c(x, self.export.scalar)
    }

    /// The sample of the window has no numbers that the plant does not have.
    fn has_inputs(&self) -> bool {
        !self.export.names.inputs.is_empty()
    }

    fn is_timed(&self) -> bool {
        self.export.observer.uses_time()
    }

    /// The time and the inputs of a sample of the window.
    fn of(&self, sample: &str) -> (String, String) {
        let time = if self.is_timed() { format!("{sample}t") } else { self.literal(0.0) };
        (time, if self.has_inputs() { format!("{sample}u") } else { "NULL".to_owned() })
    }

    /// The call of the outputs and their Jacobian.
    fn measurement(&self, sample: &str, x: &str) -> String {
        let (t, u) = self.of(sample);
        format!("measurement({t}, {x}, {u}, all);")
    }

    /// A call of `linearise`.
    fn linearise(&self, sample: &str, x: &str) -> String {
        let (t, u) = self.of(sample);
        format!("linearise({t}, {x}, {u}, z);")
    }

    /// An entry of A in the motion z = (F(x), Q, A) of `linearise`.
    fn forward(&self, row: &str, column: &str) -> String {
        let n = &self.n;
        format!("z[{}]", plant::index(&format!("{n} + ({n} * {n})"), (row, column), n))
    }

    /// The length of z.
    fn motion(&self) -> String {
        let n = &self.n;
        format!("{n} + (2 * {n} * {n})")
    }
}

pub(super) fn step(text: &mut String, export: &Export, maps: &Maps, estimator: &MovingHorizon<f64>) {
    let number = scalar(export);
    let (upper, _) = lengths(export);
    let [n, p, window] = ["STATES", "OUTPUTS", "WINDOW"].map(|what| format!("{upper}_{what}"));
    let writer = Writer { export, maps, estimator, bounds: bounds(estimator), number, n: n.clone(), p, window };
    writer.constants(text);
    plant::functions(text, export, maps);
    filter::transition(text, export, &Macros::of(export));
    writer.pass(text);
    if !writer.bounds.is_empty() {
        writer.interior(text);
    }
    writer.solve(text);
    writer.update(text);
    writer.predict(text);
    let [inputs, time] = [writer.has_inputs(), writer.is_timed()];
    _ = write!(
        text,
        "
{head}
{{
{variable}    int i;

{unused}    update(state, {given}y);
    predict(state{trailing});
    if (xhat != NULL) {{
        for (i = 0; i < {n}; ++i) {{
            xhat[i] = state->xhat[i];
        }}
    }}
{tick}}}
",
        head = feedback::head(export),
        variable = if time { super::time::time(export) } else { String::new() },
        unused = if inputs { "" } else { "    (void)u;\n" },
        given = arguments(inputs, time),
        trailing = if inputs || time {
            format!(", {}", arguments(inputs, time).trim_end_matches(", "))
        } else {
            String::new()
        },
        tick = super::time::tick(export),
    );
}

/// Time and inputs of a sample, as the step passes them.
fn arguments(inputs: bool, time: bool) -> String {
    [(time, "t, "), (inputs, "u, ")].into_iter().filter(|(has, _)| *has).map(|(_, name)| name).collect()
}

/// The rest of the state at the start.
pub(super) fn start(export: &Export) -> String {
    let (upper, _) = lengths(export);
    let [n, m, p, window] = ["STATES", "INPUTS", "OUTPUTS", "WINDOW"].map(|what| format!("{upper}_{what}"));
    let zero = number::c(0.0, export.scalar);
    let mut rest = String::new();
    for (field, length, has) in [("u", &m, !export.names.inputs.is_empty()), ("y", &p, true)] {
        if has {
            _ = write!(
                rest,
                "        for (j = 0; j < {length}; ++j) {{
            state->samples[i].{field}[j] = {zero};
        }}
"
            );
        }
    }
    if export.observer.uses_time() {
        _ = writeln!(rest, "        state->samples[i].t = {zero};");
    }
    format!(
        "    for (i = 0; i < {n}; ++i) {{
        int j;
        state->prior[i] = xhat[i];
        for (j = 0; j < {n}; ++j) {{
            state->P[i][j] = P0[i][j];
            state->prior_P[i][j] = P0[i][j];
        }}
    }}
    for (i = 0; i < {window}; ++i) {{
        int j;
        for (j = 0; j < {n}; ++j) {{
            state->samples[i].x[j] = xhat[j];
        }}
{rest}        state->samples[i].measured = 0;
    }}
    state->count = 1;
"
    )
}

impl Writer<'_> {
    /// The factor of V, and the bounds.
    fn constants(&self, text: &mut String) {
        let Self { export, number, .. } = self;
        let root = export.observer.root_of_v(export.scalar);
        text.push('\n');
        super::matrix(text, export, "ROOT_V", &root);
        if self.bounds.is_empty() {
            return;
        }
        let count = self.bounds.len();
        let list = |of: &dyn Fn(&Bound) -> String| self.bounds.iter().map(of).collect::<Vec<_>>().join(", ");
        _ = write!(
            text,
            "
/* The states that have the bounds, counted from 0; 1 for a lower bound and -1 for an upper one. */
static const int BOUNDED[{count}] = {{ {} }};
static const {number} SIDE[{count}] = {{ {} }};
",
            list(&|bound| bound.axis.to_string()),
            list(&|bound| self.literal(if bound.is_lower { 1.0 } else { -1.0 })),
        );
    }

    /// The time and the inputs of a step in the last sample of the window.
    fn known(&self) -> String {
        let (upper, _) = lengths(self.export);
        let time = if self.is_timed() { "    at->t = t;\n" } else { "" };
        let inputs = if self.has_inputs() {
            format!("    for (i = 0; i < {upper}_INPUTS; ++i) {{\n        at->u[i] = u[i];\n    }}\n")
        } else {
            String::new()
        };
        format!("{time}{inputs}")
    }

    fn parameters(&self) -> String {
        let number = self.number;
        let all = [(self.is_timed(), format!("{number} t, ")), (self.has_inputs(), format!("const {number} *u, "))];
        all.into_iter().filter(|(has, _)| *has).map(|(_, text)| text).collect()
    }

    fn update(&self, text: &mut String) {
        let Self { export, maps, number, n, p, window, .. } = self;
        let name = &export.identifier;
        let entry = |row: &str, column: &str| format!("all[{}]", plant::index(p, (row, column), n));
        _ = write!(
            text,
            "
/* Whether the covariance of the innovation is positive definite in floating point. */
static int is_definite(const {name}_state *state, const {name}_sample *at)
{{
    {number} all[{length}];
    {number} cp[{p}][{n}];
    {number} s[{p}][{p}];
    int definite = 1;
    int i;
    int j;
    int k;

{unused}    {measurement}
",
            length = maps.measurement.len(),
            unused = if self.has_inputs() || self.is_timed() { "" } else { "    (void)at;\n" },
            measurement = self.measurement("at->", "state->xhat"),
        );
        let product = |k: &str| format!("{} * state->P[{k}][j]", entry("i", k));
        plant::contraction(text, number, (p, n, n), product, "cp[i][j] = sum;");
        let product = |k: &str| format!("cp[i][{k}] * {}", entry("j", k));
        plant::contraction(text, number, (p, p, n), product, "s[i][j] = sum + V[i][j];");
        filter::factor(text, self.export, p);
        _ = write!(
            text,
            "    return definite;
}}

/* The measurement: the problem of the window is solved with it. The state stays as it was where that has no result in
 * floating point. */
static void update({name}_state *state, {parameters}const {number} *y)
{{
    {name}_sample *const at = &state->samples[state->count - 1];
    const {name}_sample before = *at;
    {number} x[{window} * {n}];
    {number} P[{n}][{n}];
    int is_right;
    int i;
    int j;

{known}    for (i = 0; i < {p}; ++i) {{
        at->y[i] = y[i];
    }}
    at->measured = 1;
    is_right = is_definite(state, at);
    if (is_right != 0) {{
        is_right = solve(state, x, &P[0][0]);
    }}
    if (is_right != 0) {{
        for (i = 0; i < state->count; ++i) {{
            for (j = 0; j < {n}; ++j) {{
                state->samples[i].x[j] = x[(i * {n}) + j];
            }}
        }}
        for (i = 0; i < {n}; ++i) {{
            state->xhat[i] = at->x[i];
            for (j = 0; j < {n}; ++j) {{
                state->P[i][j] = P[i][j];
            }}
        }}
    }} else {{
        *at = before;
    }}
}}
",
            parameters = self.parameters(),
            known = self.known(),
        );
    }

    fn predict(&self, text: &mut String) {
        let Self { export, number, n, window, .. } = self;
        let name = &export.identifier;
        let parameters = self.parameters();
        let trailing =
            if parameters.is_empty() { String::new() } else { format!(", {}", parameters.trim_end_matches(", ")) };
        _ = write!(
            text,
            "
/* The first sample of the window goes into the arrival cost. 0, and nothing changes, if that has no result. */
static int forget({name}_state *state)
{{
    filtered first;
    {number} z[{length}];
    int is_right;
    int i;

    begin(&first, state->prior, &state->prior_P[0][0]);
    is_right = measure(&state->samples[0], state->samples[0].x, &first);
    if (is_right != 0) {{
        {linearise_first}
        drift(&first, state->samples[0].x, z, state->prior);
        spread(&first.P[0][0], z, &state->prior_P[0][0]);
        for (i = 1; i < {window}; ++i) {{
            state->samples[i - 1] = state->samples[i];
        }}
        state->count = {window} - 1;
    }}
    return is_right;
}}

/* The prediction for the next sample; NaN, and the window as it was, where it has no result in floating point. */
static void predict({name}_state *state{trailing})
{{
    {name}_sample *const at = &state->samples[state->count - 1];
    const {name}_sample before = *at;
    {number} z[{length}];
    {number} P[{n}][{n}];
    int is_right = 1;
    int i;
    int j;

{known}    {linearise}
    spread(&state->P[0][0], z, &P[0][0]);
    for (i = 0; i < {n}; ++i) {{
        if (!({finite_x})) {{
            is_right = 0;
        }}
        for (j = 0; j < {n}; ++j) {{
            if (!({finite_p})) {{
                is_right = 0;
            }}
        }}
    }}
    if ((is_right != 0) && (state->count == {window})) {{
        is_right = forget(state);
    }}
    if (is_right != 0) {{
        {name}_sample *const next = &state->samples[state->count];
        next->measured = 0;
        for (i = 0; i < {n}; ++i) {{
            next->x[i] = z[i];
            state->xhat[i] = z[i];
            for (j = 0; j < {n}; ++j) {{
                state->P[i][j] = P[i][j];
            }}
        }}
        ++state->count;
    }} else {{
        *at = before;
        for (i = 0; i < {n}; ++i) {{
            state->xhat[i] = ({number})NAN;
        }}
    }}
}}
",
            length = self.motion(),
            known = self.known(),
            linearise_first = self.linearise("state->samples[0].", "state->samples[0].x"),
            linearise = self.linearise("at->", "at->x"),
            finite_x = is_finite(self.export, "z[i]"),
            finite_p = is_finite(self.export, "P[i][j]"),
        );
    }
}
