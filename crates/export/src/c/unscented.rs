//! The step of the unscented Kalman filter in square-root form: the columns of covariances are rotated into factors.

use std::fmt::Write;

use luenberger_expression::{ExpressionPlant, Routine};
use luenberger_observers::UnscentedKalmanFilter;
use nalgebra::Dyn;

use super::plant::{self, Arguments};
use super::transition::Transition;
use super::{feedback, is_finite, lengths, root, scalar};
use crate::exportable_observer::Maps;
use crate::{Export, number};

type Filter = UnscentedKalmanFilter<ExpressionPlant, f64, Dyn, Dyn, Dyn>;

/// What the pieces of the source share.
struct Writer<'a> {
    export: &'a Export,
    maps: &'a Maps,
    filter: &'a Filter,
    number: &'static str,
    n: String,
    p: String,
}

impl Writer<'_> {
    fn literal(&self, x: f64) -> String {
        number::c(x, self.export.scalar)
    }

    fn is_negative(&self) -> bool {
        self.filter.weights().is_negative
    }

    /// f, then Df row by row.
    fn centre(&self) -> &Routine {
        self.maps.centre.as_ref().unwrap_or(&self.maps.motion)
    }

    fn is_gated(&self) -> bool {
        self.filter.gate().is_some()
    }
}

fn arguments_of(routine: &Routine) -> Arguments {
    Arguments { time: routine.uses_time(), inputs: routine.uses_inputs().then_some("u") }
}

pub(super) fn step(text: &mut String, export: &Export, maps: &Maps, filter: &Filter) {
    let number = scalar(export);
    let (upper, _) = lengths(export);
    let [n, p] = ["STATES", "OUTPUTS"].map(|what| format!("{upper}_{what}"));
    plant::functions(text, export, maps);
    let writer = Writer { export, maps, filter, number, n: n.clone(), p };
    writer.columns(text);
    writer.points(text);
    writer.joint(text);
    writer.update(text);
    writer.predict(text);
    let (forward, measured) = (arguments_of(&maps.motion), arguments_of(&maps.measurement));
    _ = write!(
        text,
        "
{head}
{{
{time}    int i;

{unused}    update(state, {}y);
    predict(state{});
    if (xhat != NULL) {{
        for (i = 0; i < {n}; ++i) {{
            xhat[i] = state->xhat[i];
        }}
    }}
{}}}
",
        measured.arguments("t"),
        super::kalman::trailing(forward, "t"),
        super::time::tick(export),
        head = feedback::head(export),
        time = super::time::time(export),
        unused = if forward.inputs.or(measured.inputs).is_some() { "" } else { "    (void)u;\n" },
    );
}

impl Writer<'_> {
    /// Columns that are added to factors, and taken away.
    fn columns(&self, text: &mut String) {
        let Self { number, n, p, .. } = self;
        let (zero, root) = (self.literal(0.0), root(self.export));
        _ = write!(
            text,
            "
/* The rotation that takes (pivot, entry) to (r, 0): r, with cosine and sine. */
static {number} rotation({number} pivot, {number} entry, {number} *c, {number} *d)
{{
    const {number} r = {root}((pivot * pivot) + (entry * entry));
    const int is_zero = (r == {zero}) ? 1 : 0;
    *c = (is_zero != 0) ? {zero} : (pivot / r);
    *d = (is_zero != 0) ? {zero} : (entry / r);
    return r;
}}

/* The lower triangular factor of s s' + v v', by rows; v is used up. */
static void add({number} *s, {number} *v, int order)
{{
    int i;
    int j;
    for (j = 0; j < order; ++j) {{
        {number} c;
        {number} d;
        const {number} r = rotation(s[(j * order) + j], v[j], &c, &d);
        if (r != {zero}) {{
            s[(j * order) + j] = r;
            for (i = j + 1; i < order; ++i) {{
                const {number} below = s[(i * order) + j];
                const {number} entry = v[i];
                s[(i * order) + j] = (c * below) + (d * entry);
                v[i] = (c * entry) - (d * below);
            }}
        }}
    }}
}}

/* The same for the factor [g, 0; m, s] and the column (a, b). */
static void add_joint({number} *g, {number} *m, {number} *s, {number} *a, {number} *b)
{{
    int i;
    int j;
    for (j = 0; j < {p}; ++j) {{
        {number} c;
        {number} d;
        const {number} r = rotation(g[(j * {p}) + j], a[j], &c, &d);
        if (r != {zero}) {{
            g[(j * {p}) + j] = r;
            for (i = j + 1; i < {p}; ++i) {{
                const {number} below = g[(i * {p}) + j];
                const {number} entry = a[i];
                g[(i * {p}) + j] = (c * below) + (d * entry);
                a[i] = (c * entry) - (d * below);
            }}
            for (i = 0; i < {n}; ++i) {{
                const {number} below = m[(i * {p}) + j];
                const {number} entry = b[i];
                m[(i * {p}) + j] = (c * below) + (d * entry);
                b[i] = (c * entry) - (d * below);
            }}
        }}
    }}
    add(s, b, {n});
}}
"
        );
        if !self.is_negative() {
            return;
        }
        _ = write!(
            text,
            "
/* The lower triangular factor of s s' - v v', by rows; v is used up. 0 if there is none. */
static int subtract({number} *s, {number} *v, int order)
{{
    int is_right = 1;
    int i;
    int j;
    for (j = 0; (j < order) && (is_right != 0); ++j) {{
        const {number} pivot = s[(j * order) + j];
        const {number} square = (pivot - v[j]) * (pivot + v[j]);
        if (v[j] != {zero}) {{
            if (square > {zero}) {{
                const {number} r = {root}(square);
                const {number} c = r / pivot;
                const {number} d = v[j] / pivot;
                s[(j * order) + j] = r;
                for (i = j + 1; i < order; ++i) {{
                    const {number} below = (s[(i * order) + j] - (d * v[i])) / c;
                    s[(i * order) + j] = below;
                    v[i] = (c * v[i]) - (d * below);
                }}
            }} else {{
                is_right = 0;
            }}
        }}
    }}
    return is_right;
}}

/* The same for the factor [g, 0; m, s] and the column (a, b). */
static int subtract_joint({number} *g, {number} *m, {number} *s, {number} *a, {number} *b)
{{
    int is_right = 1;
    int i;
    int j;
    for (j = 0; (j < {p}) && (is_right != 0); ++j) {{
        const {number} pivot = g[(j * {p}) + j];
        const {number} square = (pivot - a[j]) * (pivot + a[j]);
        if (a[j] != {zero}) {{
            if (square > {zero}) {{
                const {number} r = {root}(square);
                const {number} c = r / pivot;
                const {number} d = a[j] / pivot;
                g[(j * {p}) + j] = r;
                for (i = j + 1; i < {p}; ++i) {{
                    const {number} below = (g[(i * {p}) + j] - (d * a[i])) / c;
                    g[(i * {p}) + j] = below;
                    a[i] = (c * a[i]) - (d * below);
                }}
                for (i = 0; i < {n}; ++i) {{
                    const {number} below = (m[(i * {p}) + j] - (d * b[i])) / c;
                    m[(i * {p}) + j] = below;
                    b[i] = (c * b[i]) - (d * below);
                }}
            }} else {{
                is_right = 0;
            }}
        }}
    }}
    if (is_right != 0) {{
        is_right = subtract(s, b, {n});
    }}
    return is_right;
}}
"
        );
    }

    /// Sigma points, and what becomes of their images.
    fn points(&self, text: &mut String) {
        let Self { number, n, .. } = self;
        let weights = self.filter.weights();
        let [outer, half, centre, two] = [weights.outer, weights.half, weights.centre, 2.0].map(|x| self.literal(x));
        _ = write!(
            text,
            "
/* A sigma point: column k of s, distance times, added to x. */
static void sigma_point(const {number} *x, const {number} *s, {number} distance, int k, {number} *point)
{{
    int i;
    for (i = 0; i < {n}; ++i) {{
        point[i] = x[i];
    }}
    for (i = k; i < {n}; ++i) {{
        point[i] = x[i] + (distance * s[(i * {n}) + k]);
    }}
}}

/* The mean of one entry of the images. Left are that entry of the half differences and sums, and of the centre. */
static {number} reduce({number} *plus, {number} *minus, {number} *centre)
{{
    const {number} middle = *centre;
    {number} twice = {two} * middle;
    {number} sum = {zero};
    {number} mean;
    int k;
    for (k = 0; k < {n}; ++k) {{
        sum = sum + ((plus[k] + minus[k]) - twice);
    }}
    mean = middle + ({outer} * sum);
    twice = {two} * mean;
    for (k = 0; k < {n}; ++k) {{
        const {number} above = plus[k];
        const {number} below = minus[k];
        plus[k] = {half} * (above - below);
        minus[k] = {half} * ((above + below) - twice);
    }}
    *centre = {centre} * (middle - mean);
    return mean;
}}
",
            zero = self.literal(0.0),
        );
    }

    fn joint(&self, text: &mut String) {
        let Self { export, maps, number, n, p, .. } = self;
        let (zero, one) = (self.literal(0.0), self.literal(1.0));
        let distance = self.literal(self.filter.weights().distance);
        let call = |x: &str, out: &str| plant::call("measurement", &maps.measurement, ("t", x, out));
        let (kept, rejected) = if self.is_gated() {
            let rejected = format!(
                "    for (i = 0; i < {p}; ++i) {{
        if (kept[i] == 0) {{
            centre[i] = {zero};
            for (k = 0; k < {n}; ++k) {{
                plus[i][k] = {zero};
                minus[i][k] = {zero};
            }}
            for (k = 0; k < {p}; ++k) {{
                g[(i * {p}) + k] = {zero};
                column[k] = {zero};
            }}
            column[i] = {one};
            add(g, column, {p});
        }}
    }}
"
            );
            ("const int *kept, ", rejected)
        } else {
            ("", String::new())
        };
        let last = if self.is_negative() {
            "    is_right = subtract_joint(g, m, s, centre, rest);\n"
        } else {
            "    add_joint(g, m, s, centre, rest);\n"
        };
        _ = write!(
            text,
            "
/* The measurement that is expected, and the factor [g, 0; m, s] of its covariance and that of the state together; 0 if
 * there is none in floating point. */
static int joint(const {name}_state *state, {parameters}{kept}{number} *expected, {number} *g, {number} *m, {number} *s)
{{
    {number} centre[{p}];
    {number} plus[{p}][{n}];
    {number} minus[{p}][{n}];
    {number} point[{n}];
    {number} image[{p}];
    {number} column[{p}];
    {number} rest[{n}];
    int is_right = 1;
    int i;
    int k;

    {first}
    for (k = 0; k < {n}; ++k) {{
        sigma_point(state->xhat, &state->S[0][0], {distance}, k, point);
        {above}
        for (i = 0; i < {p}; ++i) {{
            plus[i][k] = image[i];
        }}
        sigma_point(state->xhat, &state->S[0][0], -{distance}, k, point);
        {above}
        for (i = 0; i < {p}; ++i) {{
            minus[i][k] = image[i];
        }}
    }}
    for (i = 0; i < {p}; ++i) {{
        expected[i] = reduce(plus[i], minus[i], &centre[i]);
        for (k = 0; k < {p}; ++k) {{
            g[(i * {p}) + k] = ROOT_V[i][k];
        }}
    }}
    for (i = 0; i < {n}; ++i) {{
        for (k = 0; k < {p}; ++k) {{
            m[(i * {p}) + k] = {zero};
        }}
        for (k = 0; k < {n}; ++k) {{
            s[(i * {n}) + k] = {zero};
        }}
    }}
{rejected}    for (k = 0; k < {n}; ++k) {{
        for (i = 0; i < {p}; ++i) {{
            column[i] = minus[i][k];
        }}
        add(g, column, {p});
    }}
    for (k = 0; k < {n}; ++k) {{
        for (i = 0; i < {p}; ++i) {{
            column[i] = plus[i][k];
        }}
        for (i = 0; i < {n}; ++i) {{
            rest[i] = state->S[i][k];
        }}
        add_joint(g, m, s, column, rest);
    }}
    for (i = 0; i < {n}; ++i) {{
        rest[i] = {zero};
    }}
{last}    for (i = 0; i < {p}; ++i) {{
        if (!(g[(i * {p}) + i] > {zero})) {{
            is_right = 0;
        }}
        for (k = 0; k < {p}; ++k) {{
            if (!({finite_g})) {{
                is_right = 0;
            }}
        }}
    }}
    for (i = 0; i < {n}; ++i) {{
        for (k = 0; k < {p}; ++k) {{
            if (!({finite_m})) {{
                is_right = 0;
            }}
        }}
        for (k = 0; k < {n}; ++k) {{
            if (!({finite_s})) {{
                is_right = 0;
            }}
        }}
    }}
    return is_right;
}}
",
            name = export.identifier,
            parameters = arguments_of(&maps.measurement).parameters(number),
            first = call("state->xhat", "centre"),
            above = call("point", "image"),
            finite_g = is_finite(self.export, &format!("g[(i * {p}) + k]")),
            finite_m = is_finite(self.export, &format!("m[(i * {p}) + k]")),
            finite_s = is_finite(self.export, &format!("s[(i * {n}) + k]")),
        );
    }

    fn update(&self, text: &mut String) {
        let Self { export, maps, number, n, p, .. } = self;
        let arguments = arguments_of(&maps.measurement);
        let given = arguments.arguments("t");
        let (all, declared, gate) = match self.filter.gate() {
            Some(gate) => {
                let gate = export.scalar.round(gate);
                let square = self.literal(export.scalar.multiply(gate, gate));
                let gate = format!(
                    "    for (i = 0; (i < {p}) && (is_right != 0); ++i) {{
        {number} variance = {zero};
        for (k = 0; k <= i; ++k) {{
            variance = variance + (g[i][k] * g[i][k]);
        }}
        kept[i] = ((value[i] * value[i]) <= ({square} * variance)) ? 1 : 0;
    }}
    if (is_right != 0) {{
        is_right = joint(state, {given}kept, expected, &g[0][0], &m[0][0], &s[0][0]);
        for (i = 0; i < {p}; ++i) {{
            if (kept[i] == 0) {{
                value[i] = {zero};
            }}
        }}
    }}
",
                    zero = self.literal(0.0),
                );
                let all = format!(
                    "    for (i = 0; i < {p}; ++i) {{
        kept[i] = 1;
    }}
"
                );
                (all, format!("    int kept[{p}];\n"), gate)
            }
            None => Default::default(),
        };
        _ = write!(
            text,
            "
/* The measurement update. The estimate stays as it is where there is no result: y is not finite, the covariances have no
 * factor in floating point, or a number overflows. */
static void update({name}_state *state, {parameters}const {number} *y)
{{
    {number} expected[{p}];
    {number} value[{p}];
    {number} g[{p}][{p}];
    {number} m[{n}][{p}];
    {number} s[{n}][{n}];
    {number} estimate[{n}];
{declared}    int is_right;
    int i;
    int k;

{all}    is_right = joint(state, {given}{kept}expected, &g[0][0], &m[0][0], &s[0][0]);
    for (i = 0; i < {p}; ++i) {{
        value[i] = y[i] - expected[i];
    }}
{gate}    if (is_right != 0) {{
        for (i = 0; i < {p}; ++i) {{
            for (k = 0; k < i; ++k) {{
                value[i] = value[i] - (g[i][k] * value[k]);
            }}
            value[i] = value[i] / g[i][i];
        }}
        for (i = 0; i < {n}; ++i) {{
            estimate[i] = state->xhat[i];
            for (k = 0; k < {p}; ++k) {{
                estimate[i] = estimate[i] + (m[i][k] * value[k]);
            }}
            if (!({finite})) {{
                is_right = 0;
            }}
        }}
    }}
    for (i = 0; (i < {n}) && (is_right != 0); ++i) {{
        state->xhat[i] = estimate[i];
        for (k = 0; k < {n}; ++k) {{
            state->S[i][k] = s[i][k];
        }}
    }}
}}
",
            finite = is_finite(self.export, "estimate[i]"),
            name = export.identifier,
            parameters = arguments.parameters(number),
            kept = if self.is_gated() { "kept, " } else { "" },
        );
    }

    fn predict(&self, text: &mut String) {
        let Self { export, maps, number, n, .. } = self;
        let arguments = arguments_of(&maps.motion);
        let (parameters, zero) = (arguments.parameters(number), self.literal(0.0));
        let distance = self.literal(self.filter.weights().distance);
        let substeps = self.filter.substeps();
        let noise = if let Some(substeps) = substeps {
            _ = write!(
                text,
                "
/* The slope of a sigma point. */
static void slope({parameters}const {number} *z, {number} *dz)
{{
    {motion}
}}
",
                motion = plant::call("motion", &maps.motion, ("t", "z", "dz")),
            );
            plant::runge_kutta(text, export, arguments, n);
            _ = write!(
                text,
                "
/* A sigma point at the next sample. */
static void move({parameters}{number} *z)
{{
    int k;
"
            );
            plant::advance(text, export, arguments, substeps, "");
            text.push_str("}\n");
            let transition = Transition::new(export, ("centre", self.centre()), arguments, n);
            transition.noise_factor(text, substeps);
            format!("    noise({}state->xhat, &next[0][0]);\n", arguments.arguments("t"))
        } else {
            _ = write!(
                text,
                "
/* A sigma point at the next sample. */
static void move({parameters}{number} *z)
{{
    {number} next[{n}];
    int i;
    {motion}
    for (i = 0; i < {n}; ++i) {{
        z[i] = next[i];
    }}
}}
",
                motion = plant::call("motion", &maps.motion, ("t", "z", "next")),
            );
            format!(
                "    for (i = 0; i < {n}; ++i) {{
        for (k = 0; k < {n}; ++k) {{
            next[i][k] = ROOT_W[i][k];
        }}
    }}
"
            )
        };
        let last = if self.is_negative() {
            format!("    is_right = subtract(&next[0][0], centre, {n});\n")
        } else {
            format!("    add(&next[0][0], centre, {n});\n")
        };
        let given = arguments.arguments("t");
        let trailing = super::kalman::trailing_parameters(arguments, number);
        _ = write!(
            text,
            "
/* The prediction for the next sample; NaN where its covariance has no factor in floating point. */
static void predict({name}_state *state{trailing})
{{
    {number} next[{n}][{n}];
    {number} centre[{n}];
    {number} plus[{n}][{n}];
    {number} minus[{n}][{n}];
    {number} column[{n}];
    {number} mean[{n}];
    int is_right = 1;
    int i;
    int k;

    for (i = 0; i < {n}; ++i) {{
        centre[i] = state->xhat[i];
    }}
{noise}    move({given}centre);
    for (k = 0; k < {n}; ++k) {{
        sigma_point(state->xhat, &state->S[0][0], {distance}, k, column);
        move({given}column);
        for (i = 0; i < {n}; ++i) {{
            plus[i][k] = column[i];
        }}
        sigma_point(state->xhat, &state->S[0][0], -{distance}, k, column);
        move({given}column);
        for (i = 0; i < {n}; ++i) {{
            minus[i][k] = column[i];
        }}
    }}
    for (i = 0; i < {n}; ++i) {{
        mean[i] = reduce(plus[i], minus[i], &centre[i]);
    }}
    for (k = 0; k < {n}; ++k) {{
        for (i = 0; i < {n}; ++i) {{
            column[i] = minus[i][k];
        }}
        add(&next[0][0], column, {n});
    }}
    for (k = 0; k < {n}; ++k) {{
        for (i = 0; i < {n}; ++i) {{
            column[i] = plus[i][k];
        }}
        add(&next[0][0], column, {n});
    }}
{last}    for (i = 0; i < {n}; ++i) {{
        if (!({finite_mean})) {{
            is_right = 0;
        }}
        for (k = 0; k < {n}; ++k) {{
            if (!({finite_next})) {{
                is_right = 0;
            }}
        }}
    }}
    for (i = 0; i < {n}; ++i) {{
        state->xhat[i] = (is_right != 0) ? mean[i] : ({number})NAN;
        for (k = 0; (k < {n}) && (is_right != 0); ++k) {{
            state->S[i][k] = (k <= i) ? next[i][k] : {zero};
        }}
    }}
}}
",
            name = export.identifier,
            finite_mean = is_finite(self.export, "mean[i]"),
            finite_next = is_finite(self.export, "next[i][k]"),
        );
    }
}
