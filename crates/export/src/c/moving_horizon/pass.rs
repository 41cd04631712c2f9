//! One Gauss-Newton step: a Kalman filter forward and its adjoint backward.

use std::fmt::Write;

use super::{Writer, is_finite};
use crate::c::plant::{contraction, index};

impl Writer<'_> {
    pub(super) fn pass(&self, text: &mut String) {
        self.correction(text);
        self.measure(text);
        if !self.bounds.is_empty() {
            self.bound(text);
        }
        self.drift(text);
        self.forward_and_backward(text);
    }

    /// A stage, and the update by one measurement.
    fn correction(&self, text: &mut String) {
        let Self { number, n, .. } = self;
        let (zero, one) = (self.literal(0.0), self.literal(1.0));
        _ = write!(
            text,
            "
/* A sample of the window in the filter: mean and covariance after its measurements, the product of the I - K C and the
 * sum of the C' S^-1 nu for the way back, and A to the next sample. */
typedef struct {{
    {number} mean[{n}];
    {number} P[{n}][{n}];
    {number} keep[{n}][{n}];
    {number} news[{n}];
    {number} forward[{n}][{n}];
}} filtered;

/* A sample with this mean and covariance before its measurements. */
static void begin(filtered *at, const {number} *mean, const {number} *P)
{{
    int i;
    int j;
    for (i = 0; i < {n}; ++i) {{
        at->mean[i] = mean[i];
        at->news[i] = {zero};
        for (j = 0; j < {n}; ++j) {{
            at->P[i][j] = P[(i * {n}) + j];
            at->keep[i][j] = (i == j) ? {one} : {zero};
            at->forward[i][j] = (i == j) ? {one} : {zero};
        }}
    }}
}}

/* The update by one measurement c x with its innovation and the variance of its noise; 0 if the innovation has no positive
 * variance. */
static int correct(filtered *at, const {number} *c, {number} innovation, {number} variance)
{{
    {number} gain[{n}];
    {number} row[{n}];
    {number} once[{n}][{n}];
    {number} product[{n}][{n}];
    {number} s = variance;
    int is_right = 0;
    int i;
    int j;
    int k;

    for (i = 0; i < {n}; ++i) {{
        {number} sum = {zero};
        for (k = 0; k < {n}; ++k) {{
            sum = sum + (at->P[i][k] * c[k]);
        }}
        gain[i] = sum;
    }}
    for (i = 0; i < {n}; ++i) {{
        s = s + (c[i] * gain[i]);
    }}
    if ((s > {zero}) && ({finite})) {{
        const {number} scale = innovation / s;
        is_right = 1;
        for (i = 0; i < {n}; ++i) {{
            {number} sum = {zero};
            for (k = 0; k < {n}; ++k) {{
                sum = sum + (at->keep[k][i] * c[k]);
            }}
            row[i] = sum;
            at->news[i] = at->news[i] + (sum * scale);
            gain[i] = gain[i] / s;
        }}
        for (i = 0; i < {n}; ++i) {{
            at->mean[i] = at->mean[i] + (gain[i] * innovation);
            for (j = 0; j < {n}; ++j) {{
                at->keep[i][j] = at->keep[i][j] - (gain[i] * row[j]);
                once[i][j] = ((i == j) ? {one} : {zero}) - (gain[i] * c[j]);
            }}
        }}
",
            finite = is_finite(self.export, "s"),
        );
        let mut rest = String::new();
        contraction(&mut rest, number, (n, n, n), |k| format!("once[i][{k}] * at->P[{k}][j]"), "product[i][j] = sum;");
        let term = |k: &str| format!("product[i][{k}] * once[j][{k}]");
        contraction(&mut rest, number, (n, n, n), term, "at->P[i][j] = sum + ((gain[i] * variance) * gain[j]);");
        rest.push_str("    symmetrise(&at->P[0][0]);\n");
        for line in rest.lines() {
            _ = writeln!(text, "    {line}");
        }
        text.push_str("    }\n    return is_right;\n}\n");
    }

    fn measure(&self, text: &mut String) {
        let Self { export, maps, number, n, p, .. } = self;
        let one = self.literal(1.0);
        let row = index(p, ("i", "0"), n);
        _ = write!(
            text,
            "
/* The update by the outputs of a sample, linearised at x; with V = G G' the entries of G^-1 y are independent. */
static int measure(const {name}_sample *sample, const {number} *x, filtered *at)
{{
    {number} all[{length}];
    int is_right = 1;
    int i;
    int j;
    int k;

    if (sample->measured != 0) {{
        {measurement}
        for (i = 0; i < {p}; ++i) {{
            all[i] = sample->y[i] - all[i];
        }}
        for (i = 0; i < {p}; ++i) {{
            for (k = 0; k < i; ++k) {{
                all[i] = all[i] - (ROOT_V[i][k] * all[k]);
                for (j = 0; j < {n}; ++j) {{
                    all[{entry}] = all[{entry}] - (ROOT_V[i][k] * all[{other}]);
                }}
            }}
            all[i] = all[i] / ROOT_V[i][i];
            for (j = 0; j < {n}; ++j) {{
                all[{entry}] = all[{entry}] / ROOT_V[i][i];
            }}
        }}
        for (i = 0; (i < {p}) && (is_right != 0); ++i) {{
            {number} innovation = all[i];
            for (j = 0; j < {n}; ++j) {{
                innovation = innovation - (all[{entry}] * (at->mean[j] - x[j]));
            }}
            is_right = correct(at, &all[{row}], innovation, {one});
        }}
    }}
    return is_right;
}}
",
            name = export.identifier,
            length = maps.measurement.len(),
            measurement = self.measurement("sample->", "x"),
            entry = index(p, ("i", "j"), n),
            other = index(p, ("k", "j"), n),
        );
    }

    /// The bounds of a sample as measurements of its states.
    fn bound(&self, text: &mut String) {
        let Self { number, n, .. } = self;
        let (zero, one, count) = (self.literal(0.0), self.literal(1.0), self.bounds.len());
        _ = write!(
            text,
            "
/* The bounds of a sample as measurements of its states, with the variance s/z of slack and multiplier. */
static int bound(filtered *at, const {number} *s, const {number} *z, {number} mu)
{{
    {number} row[{n}];
    int is_right = 1;
    int i;
    int k;

    for (k = 0; (k < {count}) && (is_right != 0); ++k) {{
        const {number} value = BOUNDS[0][k] + (SIDE[k] * (s[k] + (mu / z[k])));
        for (i = 0; i < {n}; ++i) {{
            row[i] = (i == BOUNDED[k]) ? {one} : {zero};
        }}
        is_right = correct(at, row, value - at->mean[BOUNDED[k]], s[k] / z[k]);
    }}
    return is_right;
}}
"
        );
    }

    /// The mean of the next sample.
    fn drift(&self, text: &mut String) {
        let Self { number, n, .. } = self;
        let forward = |k: &str| self.forward("i", k);
        _ = write!(
            text,
            "
/* The mean of the next sample, F(x) + A (mean - x), before its measurements. */
static void drift(const filtered *at, const {number} *x, const {number} *z, {number} *mean)
{{
    {number} away[{n}];
    int i;
    int k;

    for (k = 0; k < {n}; ++k) {{
        away[k] = at->mean[k] - x[k];
    }}
    for (i = 0; i < {n}; ++i) {{
        {number} sum = {first} * away[0];
        for (k = 1; k < {n}; ++k) {{
            sum = sum + ({other} * away[k]);
        }}
        mean[i] = z[i] + sum;
    }}
}}
",
            first = forward("0"),
            other = forward("k"),
        );
    }

    fn forward_and_backward(&self, text: &mut String) {
        let Self { export, number, n, window, .. } = self;
        let zero = self.literal(0.0);
        let count = self.bounds.len();
        let is_single = self.estimator.horizon().window == 1;
        let (parameters, bounded) = if count == 0 {
            (String::new(), String::new())
        } else {
            let parameters = format!("const {number} *s, const {number} *z_bounds, {number} mu, ");
            let bounded = format!(
                "        if ((is_right != 0) && (s != NULL)) {{
            is_right = bound(&stages[i], &s[i * {count}], &z_bounds[i * {count}], mu);
        }}
"
            );
            (parameters, bounded)
        };
        let declared = if is_single {
            String::new()
        } else {
            format!(
                "    {number} z[{}];
    {number} mean[{n}];
    {number} adjoint[{n}];
    {number} P[{n}][{n}];
    int k;
",
                self.motion()
            )
        };
        let next = if is_single {
            String::new()
        } else {
            format!(
                "        if ((is_right != 0) && ((i + 1) < state->count)) {{
            {linearise}
            drift(&stages[i], &x[i * {n}], z, mean);
            spread(&stages[i].P[0][0], z, &P[0][0]);
            begin(&stages[i + 1], mean, &P[0][0]);
            for (j = 0; j < {n}; ++j) {{
                for (k = 0; k < {n}; ++k) {{
                    stages[i].forward[j][k] = {forward};
                }}
            }}
        }}
",
                linearise = self.linearise("state->samples[i].", &format!("&x[i * {n}]")),
                forward = self.forward("j", "k"),
            )
        };
        let backward = if is_single {
            String::new()
        } else {
            format!(
                "        if ((i + 1) < state->count) {{
            for (j = 0; j < {n}; ++j) {{
                {number} sum = {zero};
                for (k = 0; k < {n}; ++k) {{
                    sum = sum + (stages[i + 1].keep[k][j] * lambda[k]);
                }}
                adjoint[j] = sum - stages[i + 1].news[j];
            }}
            for (j = 0; j < {n}; ++j) {{
                {number} sum = {zero};
                for (k = 0; k < {n}; ++k) {{
                    sum = sum + (stages[i].forward[k][j] * adjoint[k]);
                }}
                lambda[j] = sum;
            }}
        }}
"
            )
        };
        _ = write!(
            text,
            "
/* One Gauss-Newton step from x: the solution of the problem linearised along it, and the covariance of its last state; 0
 * if there is none in floating point. */
static int pass(const {name}_state *state, const {number} *x, {parameters}{number} *solution, {number} *last)
{{
    filtered stages[{window}];
    {number} lambda[{n}];
{declared}    int is_right = 1;
    int i;
    int j;
    int l;

    begin(&stages[0], state->prior, &state->prior_P[0][0]);
    for (i = 0; (i < state->count) && (is_right != 0); ++i) {{
        is_right = measure(&state->samples[i], &x[i * {n}], &stages[i]);
{bounded}{next}    }}
    for (j = 0; j < {n}; ++j) {{
        lambda[j] = {zero};
    }}
    for (i = state->count - 1; (i >= 0) && (is_right != 0); --i) {{
{backward}        for (j = 0; j < {n}; ++j) {{
            {number} entry = stages[i].mean[j];
            for (l = 0; l < {n}; ++l) {{
                entry = entry - (stages[i].P[j][l] * lambda[l]);
            }}
            solution[(i * {n}) + j] = entry;
            if (!({finite})) {{
                is_right = 0;
            }}
        }}
    }}
    if (is_right != 0) {{
        const filtered *const end = &stages[state->count - 1];
        for (j = 0; j < {n}; ++j) {{
            for (l = 0; l < {n}; ++l) {{
                last[(j * {n}) + l] = end->P[j][l];
            }}
        }}
    }}
    return is_right;
}}
",
            name = export.identifier,
            finite = is_finite(self.export, "entry"),
        );
    }
}
