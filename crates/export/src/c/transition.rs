//! The plant over a period, as filters predict: the next state, the transition matrix Phi, and the covariance Q of the
//! noise, by a fixed number of steps of the classical Runge-Kutta method. The operations are those of the filters in
//! Rust, in the same order.

use std::fmt::Write;

use luenberger_expression::Routine;

use super::plant::{self, Arguments, contraction, index};
use super::scalar;
use crate::{Export, number};

/// What is emitted, and of which plant.
pub(super) struct Transition<'a> {
    export: &'a Export,
    /// The function with f, then Df row by row.
    function: (&'a str, &'a Routine),
    arguments: Arguments,
    number: &'static str,
    n: &'a str,
}

impl<'a> Transition<'a> {
    pub(super) fn new(export: &'a Export, function: (&'a str, &'a Routine), arguments: Arguments, n: &'a str) -> Self {
        Self { export, function, arguments, number: scalar(export), n }
    }

    fn literal(&self, x: f64) -> String {
        number::c(x, self.export.scalar)
    }

    fn at(&self, what: &str, row: &str, column: &str) -> String {
        format!("{what}[{}]", index(self.n, (row, column), self.n))
    }

    /// The length of z = (x, Q, Phi).
    pub(super) fn length(&self) -> String {
        let n = self.n;
        format!("{n} + (2 * {n} * {n})")
    }

    /// Entries of Q and Phi in z.
    pub(super) fn noise(&self, row: &str, column: &str) -> String {
        self.at("z", row, column)
    }

    pub(super) fn phi(&self, row: &str, column: &str) -> String {
        let n = self.n;
        format!("z[{}]", index(&format!("{n} + ({n} * {n})"), (row, column), n))
    }

    /// One step of the classical method: next, Phi, and H from the middle of the step to its end.
    pub(super) fn classical(&self, text: &mut String) {
        let Self { export, number, n, arguments, function: (name, routine), .. } = self;
        let [tau, middle, whole] = export.observer.increments(export.scalar).map(|x| self.literal(x));
        let quarter = self.literal(export.observer.increments(export.scalar)[1] * 0.5);
        let [zero, one, two, half, third] = [0.0, 1.0, 2.0, 0.5, 1.0 / 3.0].map(|x| self.literal(x));
        let call = |t: &str, x: &str, out: &str| plant::call(name, routine, (t, x, out));
        let moved = |by: &str, stage: &str| {
            format!("for (i = 0; i < {n}; ++i) {{\n        point[i] = x[i] + ({stage}[i] * {by});\n    }}")
        };
        _ = write!(
            text,
            "
/* One step of the classical Runge-Kutta method: the next state, its Jacobian phi, and the Jacobian h from the middle of
 * the step to its end, by rows. */
static void classical({parameters}const {number} *x, {number} *next, {number} *phi, {number} *h)
{{
    {number} f1[{length}];
    {number} f2[{length}];
    {number} f3[{length}];
    {number} f4[{length}];
    {number} point[{n}];
    {number} m2[{n}][{n}];
    {number} m3[{n}][{n}];
    {number} m4[{n}][{n}];
    int i;
    int j;
    int k;

    {first}
    {to_second}
    {second}
    {to_third}
    {third_stage}
    {to_fourth}
    {fourth}
    for (i = 0; i < {n}; ++i) {{
        next[i] = x[i] + (((f1[i] + ((f2[i] + f3[i]) * {two})) + f4[i]) * {whole});
    }}
",
            parameters = arguments.parameters(number),
            length = routine.len(),
            first = call("t", "x", "f1"),
            to_second = moved(&middle, "f1"),
            second = call(&format!("t + {middle}"), "point", "f2"),
            to_third = moved(&middle, "f2"),
            third_stage = call(&format!("t + {middle}"), "point", "f3"),
            to_fourth = moved(&tau, "f3"),
            fourth = call(&format!("t + {tau}"), "point", "f4"),
        );
        let square = (*n, *n, *n);
        let of = |what: &str| self.at(what, "i", "j");
        let product =
            |left: &str, right: &dyn Fn(&str) -> String, k: &str| format!("{} * {}", self.at(left, "i", k), right(k));
        let f1 = |k: &str| self.at("f1", k, "j");
        let m2 = |k: &str| format!("m2[{k}][j]");
        let m3 = |k: &str| format!("m3[{k}][j]");
        contraction(
            text,
            number,
            square,
            |k| product("f2", &f1, k),
            &format!("m2[i][j] = {} + (sum * {middle});", of("f2")),
        );
        contraction(
            text,
            number,
            square,
            |k| product("f3", &m2, k),
            &format!("m3[i][j] = {} + (sum * {middle});", of("f3")),
        );
        contraction(
            text,
            number,
            square,
            |k| product("f4", &m3, k),
            &format!("m4[i][j] = {} + (sum * {tau});", of("f4")),
        );
        let entry = |what: &str| format!("{what}[{}]", index("", ("i", "j"), n));
        let identity = format!("((i == j) ? {one} : {zero})");
        // a in place of m2, and what it is multiplied by in m3.
        _ = write!(
            text,
            "    for (i = 0; i < {n}; ++i) {{
        for (j = 0; j < {n}; ++j) {{
            {phi} = {identity} + ((({f1} + ((m2[i][j] + m3[i][j]) * {two})) + m4[i][j]) * {whole});
            m2[i][j] = ({f3} + {f4}) * {quarter};
            m3[i][j] = {identity} + (m2[i][j] * {third});
        }}
    }}
",
            phi = entry("phi"),
            f1 = of("f1"),
            f3 = of("f3"),
            f4 = of("f4"),
        );
        let product = |k: &str| format!("m2[i][{k}] * m3[{k}][j]");
        contraction(text, number, square, product, &format!("m4[i][j] = {identity} + (sum * {half});"));
        let product = |k: &str| format!("m2[i][{k}] * m4[{k}][j]");
        contraction(text, number, square, product, &format!("{} = {identity} + sum;", entry("h")));
        text.push_str("}\n");
    }

    /// The start of a step of the loop over all of them.
    fn call(&self, substeps: usize, x: &str) -> String {
        let [tau, ..] = self.export.observer.increments(self.export.scalar).map(|x| self.literal(x));
        let now = match (self.arguments.time, substeps) {
            (true, 1) => format!("t + ({tau} * {})", self.literal(0.0)),
            (true, _) => format!("t + ({tau} * ({})step)", self.number),
            (false, _) => String::new(),
        };
        format!("classical({}{x}, next, &phi[0][0], &h[0][0]);", self.arguments.arguments(&now))
    }

    /// `linearise`: the next state, Q and Phi over a period, in z.
    pub(super) fn linearise(&self, text: &mut String, substeps: usize) {
        let Self { export, number, n, arguments, .. } = self;
        let [_, _, whole] = export.observer.increments(export.scalar).map(|x| self.literal(x));
        let square = (*n, *n, *n);
        self.classical(text);
        let mut body = String::new();
        _ = writeln!(body, "    {}", self.call(substeps, "z"));
        let by_w = |what: &str| format!("{what}[i][");
        for (what, after) in [
            ("phi", "q[i][j] = sum;".to_owned()),
            ("h", format!("q[i][j] = ((q[i][j] + (sum * {})) + W[i][j]) * {whole};", self.literal(4.0))),
        ] {
            contraction(&mut body, number, square, |k| format!("{}{k}] * W[{k}][j]", by_w(what)), "left[i][j] = sum;");
            contraction(&mut body, number, square, |k| format!("left[i][{k}] * {what}[j][{k}]"), &after);
        }
        body.push_str("    symmetrise(&q[0][0]);\n");
        let stored = |q: &str, phi: &str| {
            format!(
                "    for (i = 0; i < {n}; ++i) {{
        z[i] = next[i];
        for (j = 0; j < {n}; ++j) {{
            {} = {q}[i][j];
            {} = {phi}[i][j];
        }}
    }}
",
                self.noise("i", "j"),
                self.phi("i", "j"),
            )
        };
        let (mut declared, indent) = (String::new(), if substeps == 1 { "" } else { "    " });
        let mut all = String::new();
        if substeps == 1 {
            all.push_str(&body);
            all.push_str(&stored("q", "phi"));
        } else {
            _ = writeln!(declared, "    {number} total[{n}][{n}];\n    int step;");
            let mut then = String::new();
            contraction(
                &mut then,
                number,
                square,
                |k| format!("phi[i][{k}] * {}", self.noise(k, "j")),
                "left[i][j] = sum;",
            );
            contraction(
                &mut then,
                number,
                square,
                |k| format!("left[i][{k}] * phi[j][{k}]"),
                "total[i][j] = sum + q[i][j];",
            );
            then.push_str("    symmetrise(&total[0][0]);\n");
            contraction(
                &mut then,
                number,
                square,
                |k| format!("phi[i][{k}] * {}", self.phi(k, "j")),
                "left[i][j] = sum;",
            );
            then.push_str(&stored("total", "left"));
            _ = writeln!(all, "    for (step = 0; step < {substeps}; ++step) {{");
            for line in body.lines() {
                _ = writeln!(all, "{indent}{line}");
            }
            _ = writeln!(all, "        if (step == 0) {{");
            for line in stored("q", "phi").lines() {
                _ = writeln!(all, "        {line}");
            }
            _ = writeln!(all, "        }} else {{");
            for line in then.lines() {
                _ = writeln!(all, "        {line}");
            }
            _ = writeln!(all, "        }}\n    }}");
        }
        _ = write!(
            text,
            "
/* F(x) at the next sample, the covariance Q of the noise, and the Jacobian A of F, in z. */
static void linearise({parameters}const {number} *x, {number} *z)
{{
    {number} next[{n}];
    {number} phi[{n}][{n}];
    {number} h[{n}][{n}];
    {number} left[{n}][{n}];
    {number} q[{n}][{n}];
{declared}    int i;
    int j;
    int k;

    for (i = 0; i < {n}; ++i) {{
        z[i] = x[i];
    }}
{all}}}
",
            parameters = arguments.parameters(number),
        );
    }

    /// `linearise` of a plant in discrete time: the noise of a sample is W.
    pub(super) fn linearise_discrete(&self, text: &mut String) {
        let Self { number, n, arguments, function: (name, routine), .. } = self;
        _ = write!(
            text,
            "
/* F(x) at the next sample, the covariance Q of the noise, and the Jacobian A of F, in z. */
static void linearise({parameters}const {number} *x, {number} *z)
{{
    {number} all[{}];
    int i;
    int j;

    {motion}
    for (i = 0; i < {n}; ++i) {{
        z[i] = all[i];
        for (j = 0; j < {n}; ++j) {{
            {noise} = W[i][j];
            {phi} = {derivative};
        }}
    }}
}}
",
            routine.len(),
            parameters = arguments.parameters(number),
            motion = plant::call(name, routine, ("t", "x", "all")),
            noise = self.noise("i", "j"),
            phi = self.phi("i", "j"),
            derivative = self.at("all", "i", "j"),
        );
    }

    /// `spread`: `Phi P Phi' + Q`.
    pub(super) fn spread(&self, text: &mut String) {
        let Self { number, n, .. } = self;
        _ = write!(
            text,
            "
/* The covariance next = A P A' + Q. */
static void spread(const {number} *P, const {number} *z, {number} *next)
{{
    {number} ap[{n}][{n}];
    int i;
    int j;
    int k;

"
        );
        let product = |k: &str| format!("{} * P[{}]", self.phi("i", k), index("", (k, "j"), n));
        contraction(text, number, (n, n, n), product, "ap[i][j] = sum;");
        let product = |k: &str| format!("ap[i][{k}] * {}", self.phi("j", k));
        let after = format!("next[(i * {n}) + j] = sum + {};", self.noise("i", "j"));
        contraction(text, number, (n, n, n), product, &after);
        text.push_str("    symmetrise(next);\n}\n");
    }

    /// `noise`: the factor of Q over a period, whose columns are added one by one, in s.
    pub(super) fn noise_factor(&self, text: &mut String, substeps: usize) {
        let Self { export, number, n, arguments, .. } = self;
        let weight = export.observer.noise_weight(export.scalar);
        let (weight, twice) = (self.literal(weight), self.literal(2.0 * weight));
        let square = (*n, *n, *n);
        self.classical(text);
        let mut body = String::new();
        _ = write!(
            body,
            "        {}
        for (i = 0; i < {n}; ++i) {{
            for (j = 0; j < {n}; ++j) {{
                total[i][j] = ROOT_W[i][j] * {weight};
            }}
        }}
",
            self.call(2, "x")
        );
        let added = format!(
            "        for (j = 0; j < {n}; ++j) {{
            for (i = 0; i < {n}; ++i) {{
                column[i] = left[i][j];
            }}
            add(&total[0][0], column, {n});
        }}
"
        );
        for (what, weight) in [("h", &twice), ("phi", &weight)] {
            let mut product = String::new();
            let after = format!("left[i][j] = sum * {weight};");
            contraction(&mut product, number, square, |k| format!("{what}[i][{k}] * ROOT_W[{k}][j]"), &after);
            for line in product.lines() {
                _ = writeln!(body, "    {line}");
            }
            body.push_str(&added);
        }
        if substeps > 1 {
            let mut product = String::new();
            let before = |k: &str| format!("phi[i][{k}] * s[{}]", index("", (k, "j"), n));
            contraction(&mut product, number, square, before, "left[i][j] = sum;");
            _ = writeln!(body, "        if (step > 0) {{");
            for line in product.lines().chain(added.lines()) {
                let extra =
                    if line.starts_with("        for (j = 0") || added.contains(line) { "    " } else { "        " };
                _ = writeln!(body, "{extra}{line}");
            }
            _ = writeln!(body, "        }}");
        }
        _ = write!(
            text,
            "
/* The lower triangular factor of the covariance of the noise over a period, along the estimate, by rows in s. */
static void noise({parameters}const {number} *xhat, {number} *s)
{{
    {number} x[{n}];
    {number} next[{n}];
    {number} phi[{n}][{n}];
    {number} h[{n}][{n}];
    {number} left[{n}][{n}];
    {number} total[{n}][{n}];
    {number} column[{n}];
    int step;
    int i;
    int j;
    int k;

    for (i = 0; i < {n}; ++i) {{
        x[i] = xhat[i];
    }}
    for (step = 0; step < {substeps}; ++step) {{
{body}        for (i = 0; i < {n}; ++i) {{
            x[i] = next[i];
            for (j = 0; j < {n}; ++j) {{
                s[(i * {n}) + j] = total[i][j];
            }}
        }}
    }}
}}
",
            parameters = arguments.parameters(number),
        );
    }
}
