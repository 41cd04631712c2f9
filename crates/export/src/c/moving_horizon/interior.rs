//! The interior-point method, and the choice between it and the Gauss-Newton steps.

use std::fmt::Write;

use luenberger_observers::moving_horizon::{FRACTION_TO_BOUNDARY, INTERIOR_POINT_STEPS};

use super::{Writer, is_finite, root};
use crate::scalar::Scalar;

impl Writer<'_> {
    /// The constants of the method, as they are computed in the format: the least mu and the least variance, the share
    /// of the way to a bound, and what is left of it.
    fn numbers(&self) -> [String; 4] {
        let of = match self.export.scalar {
            Scalar::Binary32 => {
                let (least, share) = (f32::EPSILON * 1e3, FRACTION_TO_BOUNDARY as f32);
                [least, least * least, share, 1.0 - share].map(f64::from)
            }
            Scalar::Binary64 => {
                let least = f64::EPSILON * 1e3;
                [least, least * least, FRACTION_TO_BOUNDARY, 1.0 - FRACTION_TO_BOUNDARY]
            }
        };
        of.map(|x| self.literal(x))
    }

    pub(super) fn interior(&self, text: &mut String) {
        let Self { export, number, n, window, .. } = self;
        let count = self.bounds.len();
        let [zero, one, half, tenth] = [0.0, 1.0, 0.5, 0.1].map(|x| self.literal(self.export.scalar.round(x)));
        let [least, variance, share, rest] = self.numbers();
        _ = write!(
            text,
            "
/* The larger of two numbers, the second where they are equal. */
static {number} larger({number} x, {number} y)
{{
    return (x > y) ? x : y;
}}

/* Whether all states of a trajectory are within the bounds. */
static int is_within(int count, const {number} *x)
{{
    int within = 1;
    int i;
    int k;
    for (i = 0; i < count; ++i) {{
        for (k = 0; k < {count}; ++k) {{
            const {number} entry = x[(i * {n}) + BOUNDED[k]];
            if ((SIDE[k] > {zero}) ? (!(BOUNDS[0][k] <= entry)) : (!(entry <= BOUNDS[0][k]))) {{
                within = 0;
            }}
        }}
    }}
    return within;
}}

/* The trajectory with what violates a bound at the bound. */
static void clamp(int count, {number} *x)
{{
    int i;
    int k;
    for (i = 0; i < count; ++i) {{
        for (k = 0; k < {count}; ++k) {{
            const int at = (i * {n}) + BOUNDED[k];
            if (SIDE[k] > {zero}) {{
                x[at] = (x[at] > BOUNDS[0][k]) ? x[at] : BOUNDS[0][k];
            }} else {{
                x[at] = (x[at] < BOUNDS[0][k]) ? x[at] : BOUNDS[0][k];
            }}
        }}
    }}
}}

/* The steps of a slack and its multiplier, for the state in the solution and the bound number k. */
static void direction({number} x, int k, const {number} *s, const {number} *z, {number} mu, {number} *steps)
{{
    steps[0] = (SIDE[k] * (x - BOUNDS[0][k])) - *s;
    steps[1] = ((mu / *s) - *z) - ((*z / *s) * steps[0]);
}}

/* The share of a step after which a positive number is still positive, at most alpha. */
static {number} shortened({number} value, {number} step, {number} alpha)
{{
    return ((value + (alpha * step)) < ({rest} * value)) ? ((-{share} * value) / step) : alpha;
}}

/* The primal-dual interior-point method from x on, in a fixed number of steps. */
static int interior(const {name}_state *state, {number} *x, {number} *P)
{{
    {number} s[{window} * {count}];
    {number} z[{window} * {count}];
    {number} solution[{window} * {n}];
    {number} steps[2];
    {number} mu = {one};
    int is_right = 1;
    int step;
    int i;
    int k;

    clamp(state->count, x);
    for (i = 0; i < state->count; ++i) {{
        for (k = 0; k < {count}; ++k) {{
            const int j = BOUNDED[k];
            const {number} gap = SIDE[k] * (x[(i * {n}) + j] - BOUNDS[0][k]);
            const {number} deviation = {root}(larger(state->P[j][j], {variance}));
            s[(i * {count}) + k] = ({finite}) ? larger(gap, deviation) : {one};
            z[(i * {count}) + k] = {one} / s[(i * {count}) + k];
        }}
    }}
    for (step = 0; (step < {INTERIOR_POINT_STEPS}) && (is_right != 0); ++step) {{
        is_right = pass(state, x, s, z, mu, solution, P);
        if (is_right != 0) {{
            {number} alpha = {one};
            {number} sum = {zero};
            {number} mean;
            for (i = 0; i < state->count; ++i) {{
                for (k = 0; k < {count}; ++k) {{
                    const int at = (i * {count}) + k;
                    direction(solution[(i * {n}) + BOUNDED[k]], k, &s[at], &z[at], mu, steps);
                    alpha = shortened(s[at], steps[0], alpha);
                    alpha = shortened(z[at], steps[1], alpha);
                }}
            }}
            for (i = 0; i < state->count; ++i) {{
                for (k = 0; k < {count}; ++k) {{
                    const int at = (i * {count}) + k;
                    direction(solution[(i * {n}) + BOUNDED[k]], k, &s[at], &z[at], mu, steps);
                    s[at] = s[at] + (alpha * steps[0]);
                    z[at] = z[at] + (alpha * steps[1]);
                    sum = sum + (s[at] * z[at]);
                }}
            }}
            mean = sum / ({number})(state->count * {count});
            for (i = 0; i < (state->count * {n}); ++i) {{
                x[i] = x[i] + (alpha * (solution[i] - x[i]));
            }}
            mu = larger((alpha > {half}) ? ({tenth} * mean) : ({half} * mean), {least});
        }}
    }}
    clamp(state->count, x);
    return is_right;
}}
",
            name = export.identifier,
            root = root(self.export),
            finite = is_finite(self.export, "gap"),
        );
    }

    /// The problem of the window.
    pub(super) fn solve(&self, text: &mut String) {
        let Self { export, number, n, window, .. } = self;
        let iterations = self.estimator.horizon().iterations;
        let is_bounded = !self.bounds.is_empty();
        let without = if is_bounded { format!("NULL, NULL, {}, ", self.literal(0.0)) } else { String::new() };
        let (declared, more) = if is_bounded {
            (
                format!("    {number} other[{n}][{n}];\n"),
                "    if (is_right == 0) {
        stored(state, x);
        is_right = interior(state, x, P);
    } else if (is_within(state->count, x) == 0) {
        is_right = interior(state, x, &other[0][0]);
    } else {
        /* No bound is active. */
    }
",
            )
        } else {
            Default::default()
        };
        _ = write!(
            text,
            "
/* The trajectory of the sample before. */
static void stored(const {name}_state *state, {number} *x)
{{
    int i;
    int j;
    for (i = 0; i < {window}; ++i) {{
        for (j = 0; j < {n}; ++j) {{
            x[(i * {n}) + j] = state->samples[i].x[j];
        }}
    }}
}}

/* The trajectory that solves the problem of the window, and the covariance of its last state without regard to bounds; 0
 * if there is none in floating point. */
static int solve(const {name}_state *state, {number} *x, {number} *P)
{{
    {number} solution[{window} * {n}];
{declared}    int is_right = 1;
    int step;
    int i;

    stored(state, x);
    for (step = 0; (step < {iterations}) && (is_right != 0); ++step) {{
        is_right = pass(state, x, {without}solution, P);
        for (i = 0; (i < (state->count * {n})) && (is_right != 0); ++i) {{
            x[i] = solution[i];
        }}
    }}
{more}    return is_right;
}}
",
            name = export.identifier,
        );
    }
}
