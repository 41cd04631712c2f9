//! The plant over a period: the next state, its Jacobian, and the covariance of the noise.

use std::fmt::Write;

use super::Writer;
use crate::c::plant::{self, Arguments};

impl Writer<'_> {
    /// A call of `linearise` for a sample of the window.
    pub(super) fn linearise(&self, sample: &str, x: &str, z: &str) -> String {
        let arguments = Arguments::of(self.maps, false);
        let time = if arguments.time { format!("{sample}.t, ") } else { String::new() };
        let inputs = if arguments.inputs.is_some() { format!("{sample}.u, ") } else { String::new() };
        format!("linearise({time}{inputs}{x}, {z});")
    }

    /// Entries of the motion z = (F(x), Q, A) of `linearise`.
    pub(super) fn noise(&self, row: &str, column: &str) -> String {
        let n = &self.n;
        format!("z[{}]", plant::index(n, (row, column), n))
    }

    pub(super) fn forward(&self, row: &str, column: &str) -> String {
        let n = &self.n;
        format!("z[{}]", plant::index(&format!("{n} + ({n} * {n})"), (row, column), n))
    }

    /// The length of z.
    pub(super) fn motion(&self) -> String {
        let n = &self.n;
        format!("{n} + (2 * {n} * {n})")
    }

    /// F, its Jacobian and the noise over a period.
    pub(super) fn linearised(&self, text: &mut String) {
        let Self { export, maps, number, n, .. } = self;
        let arguments = Arguments::of(maps, false);
        let parameters = arguments.parameters(number);
        let (zero, one) = (self.literal(0.0), self.literal(1.0));
        let length = self.motion();
        let all = |row: &str, column: &str| format!("all[{}]", plant::index(n, (row, column), n));
        let described = "F(x) at the next sample, the covariance Q of the noise, and the Jacobian A of F, in z";
        let Some(substeps) = self.estimator.substeps() else {
            _ = write!(
                text,
                "
/* {described}. */
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
            {forward} = {derivative};
        }}
    }}
}}
",
                maps.motion.len(),
                motion = plant::call("motion", &maps.motion, ("t", "x", "all")),
                noise = self.noise("i", "j"),
                forward = self.forward("i", "j"),
                derivative = all("i", "j"),
            );
            self.spread(text);
            return;
        };
        _ = write!(
            text,
            "
/* The slopes of z = (x, Q, A). */
static void slope({parameters}const {number} *z, {number} *dz)
{{
    {number} all[{}];
    {number} fq[{n}][{n}];
    int i;
    int j;
    int k;

    {motion}
",
            maps.motion.len(),
            motion = plant::call("motion", &maps.motion, ("t", "z", "all")),
        );
        let product = |k: &str| format!("{} * {}", all("i", k), self.noise(k, "j"));
        plant::contraction(text, number, (n, n, n), product, "fq[i][j] = sum;");
        _ = write!(
            text,
            "    for (i = 0; i < {n}; ++i) {{
        dz[i] = all[i];
        for (j = 0; j < {n}; ++j) {{
            d{} = (fq[j][i] + fq[i][j]) + W[i][j];
        }}
    }}
",
            self.noise("i", "j")
        );
        let product = |k: &str| format!("{} * {}", all("i", k), self.forward(k, "j"));
        plant::contraction(text, number, (n, n, n), product, &format!("d{} = sum;", self.forward("i", "j")));
        text.push_str("}\n");
        plant::runge_kutta(text, export, arguments, &length);
        _ = write!(
            text,
            "
/* {described}. */
static void linearise({parameters}const {number} *x, {number} *z)
{{
    int i;
    int j;
    int k;

    for (i = 0; i < {n}; ++i) {{
        z[i] = x[i];
        for (j = 0; j < {n}; ++j) {{
            {noise} = {zero};
            {forward} = (i == j) ? {one} : {zero};
        }}
    }}
",
            noise = self.noise("i", "j"),
            forward = self.forward("i", "j"),
        );
        plant::advance(text, export, arguments, substeps, &format!("        symmetrise(&z[{n}]);\n"));
        text.push_str("}\n");
        self.spread(text);
    }

    /// `A P A' + Q`.
    fn spread(&self, text: &mut String) {
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
        let product = |k: &str| format!("{} * P[{}]", self.forward("i", k), plant::index("", (k, "j"), n));
        plant::contraction(text, number, (n, n, n), product, "ap[i][j] = sum;");
        let product = |k: &str| format!("ap[i][{k}] * {}", self.forward("j", k));
        let after = format!("next[(i * {n}) + j] = sum + {};", self.noise("i", "j"));
        plant::contraction(text, number, (n, n, n), product, &after);
        text.push_str("    symmetrise(next);\n}\n");
    }
}
