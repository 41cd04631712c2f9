//! The mutants: formulas of the papers and of the theorems in `docs/theory-*.md` in their code form, and their changed
//! versions.

use std::fmt;

use super::suite::{MODULES, Suite};

/// One change of one formula.
pub(super) struct Mutant {
    /// Its own name.
    pub(super) name: &'static str,
    pub(super) kind: Kind,
    /// Exactly once in its file.
    pub(super) fragment: &'static str,
    pub(super) replacement: &'static str,
    /// Why no test can notice, where none can.
    pub(super) equivalent: Option<&'static str>,
}

/// The mutants of one file, and the tests that have to notice, the quick ones first.
pub(super) struct Source {
    pub(super) file: &'static str,
    pub(super) suites: &'static [Suite],
    pub(super) mutants: &'static [Mutant],
}

/// Defect of a mutant.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    Sign,
    Transpose,
    /// A factor or a term is missing.
    Dropped,
    /// Only the diagonal of a matrix, or a multiple of I, is used.
    OffDiagonal,
    /// Another number.
    Constant,
    /// Another matrix or vector in its place, or the factors in the other order.
    WrongOperand,
    /// A hypothesis is not checked, or another one is.
    Hypothesis,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Sign => "sign",
            Self::Transpose => "transpose",
            Self::Dropped => "dropped",
            Self::OffDiagonal => "off-diagonal",
            Self::Constant => "constant",
            Self::WrongOperand => "wrong operand",
            Self::Hypothesis => "hypothesis",
        })
    }
}

const fn mutant(name: &'static str, kind: Kind, fragment: &'static str, replacement: &'static str) -> Mutant {
    Mutant { name, kind, fragment, replacement, equivalent: None }
}

impl Mutant {
    const fn equivalent(self, reason: &'static str) -> Self {
        Self { equivalent: Some(reason), ..self }
    }
}

use Kind::{Constant, Dropped, Hypothesis, OffDiagonal, Sign, Transpose, WrongOperand};

const OBSERVERS: Suite = Suite { package: "luenberger-observers", binaries: &["--lib", "--test", "it"], only: &[] };
const DESIGNS: Suite = Suite { package: MODULES, binaries: &["--test", "designs"], only: &[] };
const DESIGN_UNITS: Suite = Suite { package: "luenberger-design", binaries: &["--lib"], only: &["positive_real::"] };
const CUBIC: Suite = Suite { package: MODULES, binaries: &["--test", "cubic"], only: &[] };
const INPUT_TO_STATE: Suite = Suite { package: MODULES, binaries: &["--test", "input_to_state"], only: &[] };
const FILTERS: Suite = Suite { package: MODULES, binaries: &["--test", "filters"], only: &[] };
const INTERVAL: Suite = Suite { package: MODULES, binaries: &["--test", "interval"], only: &[] };
const SLIDING: Suite = Suite { package: MODULES, binaries: &["--test", "sliding_mode"], only: &[] };
const SAMPLED: Suite = Suite { package: MODULES, binaries: &["--test", "sampled"], only: &[] };
const UNCERTAIN: Suite = Suite { package: MODULES, binaries: &["--test", "uncertain"], only: &[] };
const OPTIMAL: Suite = Suite { package: MODULES, binaries: &["--test", "optimal_cubic"], only: &[] };
const MEAN_VALUE: Suite = Suite { package: MODULES, binaries: &["--test", "mean_value"], only: &[] };
const KKL: Suite = Suite { package: MODULES, binaries: &["--test", "kkl"], only: &[] };

const DEPLOYED: Suite = Suite { package: "luenberger-proof", binaries: &["--test", "it"], only: &["deployed::"] };
const TIMES: Suite = Suite {
    package: "luenberger-proof",
    binaries: &["--lib", "--test", "it"],
    only: &["varying_periods::", "exponential::"],
};
const KKL_BOUND: Suite = Suite { package: "luenberger-proof", binaries: &["--test", "it"], only: &["kkl::"] };

/// All of them.
pub(super) const SOURCES: &[Source] = &[
    Source {
        file: "crates/proof/src/certificate/theorem/kkl.rs",
        suites: &[KKL_BOUND],
        mutants: &[
            mutant(
                "KKL bound: rate limit^2 >= residual'|P| residual",
                Dropped,
                "product(&[self.rate, self.rate, *limit, *limit])",
                "product(&[self.rate, *limit, *limit])",
            ),
            mutant(
                "KKL bound: residual'P residual",
                Sign,
                "product(&[self.p[(i, j)].abs(), *left, *right])",
                "product(&[self.p[(i, j)], *left, *right])",
            ),
            mutant(
                "KKL bound: limit <= start",
                Hypothesis,
                "room.signum() >= 0 && limit < start",
                "room.signum() >= 0 && limit <= start",
            ),
            mutant(
                "KKL bound: eventual >= lipschitz limit",
                Dropped,
                "product(&[lipschitz[k], *limit]).add(&product(&[defect[k]]))",
                "product(&[lipschitz[k], *limit])",
            ),
            mutant(
                "KKL bound: |e_i| <= W_ii start",
                Dropped,
                "(w[(i, i)].max(0.0).sqrt().next_up() * start)",
                "(w[(i, i)].max(0.0).next_up() * start)",
            ),
            mutant(
                "KKL bound: W >= 0",
                Hypothesis,
                "_ => f64::from(u8::from(i.abs_diff(j) == q))",
                "_ => f64::from(u8::from(i.abs_diff(j) > 2 * q))",
            ),
        ],
    },
    Source {
        file: "crates/proof/src/statement/kkl.rs",
        suites: &[KKL_BOUND],
        mutants: &[
            mutant("KKL bound: residual + B", Sign, "let mut sum = b_i.negative();", "let mut sum = b_i.clone();"),
            mutant(
                "KKL bound: residual + Lambda phi",
                Sign,
                "sum = sum.minus(&arena.product(&lambda[i * q + j], phi_j)?);",
                "sum = sum.plus(&arena.product(&lambda[i * q + j], phi_j)?);",
            ),
            mutant(
                "KKL bound: residual with Lambda'",
                Transpose,
                "arena.product(&lambda[i * q + j], phi_j)",
                "arena.product(&lambda[j * q + i], phi_j)",
            ),
            mutant(
                "KKL bound: phi^L on phi(x) only",
                Dropped,
                "phi.iter().zip(e).map(|(phi, e)| phi.plus(e))",
                "phi.iter().zip(e).map(|(phi, e)| phi.plus(&e.scaled(&Rational::integer(0))))",
            ),
            mutant(
                "KKL bound: g'diag(W)g",
                OffDiagonal,
                "Rational::from_f64(w[(i, j)])",
                "Rational::from_f64(if i == j { w[(i, j)] } else { 0.0 })",
            ),
            mutant(
                "KKL bound: the residual from above only",
                Dropped,
                "Verdict::Proved { .. } => self.at_most(&p.negative(), -of.lo(), axes, entry),",
                "Verdict::Proved { margin } => Verdict::Proved { margin },",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/linear.rs",
        suites: &[OBSERVERS, CUBIC],
        mutants: &[
            mutant("linear observer: - B u", Sign, "+ entry(&self.b, i, u)", "- entry(&self.b, i, u)"),
            mutant(
                "linear observer: - L y~",
                Sign,
                "+ entry(&self.l, i, innovation)",
                "- entry(&self.l, i, innovation)",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/cubic.rs",
        suites: &[OBSERVERS, CUBIC],
        mutants: &[
            mutant(
                "cubic observer: + N y~ (y~'theta y~)",
                Sign,
                "- entry(&self.n, i, cubic)",
                "+ entry(&self.n, i, cubic)",
            ),
            mutant(
                "cubic observer: - L y~",
                Sign,
                "+ entry(&self.l, i, innovation)",
                "- entry(&self.l, i, innovation)",
            ),
            mutant("cubic observer: no B u", Dropped, " + entry(&self.b, i, u)", ""),
            mutant(
                "cubic observer: theta = I",
                Dropped,
                "weight_of(&self.theta, innovation)",
                "sum(innovation.len(), |i| innovation[i] * innovation[i])",
            ),
            mutant(
                "saturated weight: one factor of the bound",
                Dropped,
                "quadratic(theta, shortened) * bound * bound",
                "quadratic(theta, shortened) * bound",
            ),
            mutant("cubic flow: w t y'theta y without the 2", Constant, "two * q * t", "q * t"),
            mutant("cubic flow: no w", Dropped, "(w * drive).sqrt()", "drive.sqrt()"),
            mutant("cubic flow: 1 + reach", Dropped, "(one + reach * reach).sqrt()", "(one + reach).sqrt()"),
            mutant("cubic flow: impulse of Euler's step", Dropped, "size / (one + hypot)", "size / two"),
            mutant(
                "cubic flow: impulse of a far start doubled",
                Constant,
                "(one / root, one / root)",
                "(one / root, two / root)",
            ),
            mutant(
                "cubic flow: a negative weight flows back",
                Hypothesis,
                "quadratic(theta, direction).max(zero)",
                "quadratic(theta, direction)",
            ),
            mutant(
                "sampled observer: Ld y~ without r",
                Dropped,
                "*innovation = *direction * left",
                "*innovation = *direction * size",
            ),
            mutant("rate of a radial gain: + trace(C N)/p", Sign, "-trace / count", "trace / count"),
            mutant("rate of a radial gain: - trace(C N)", Dropped, "-trace / count(c.nrows())", "-trace"),
        ],
    },
    Source {
        file: "crates/observers/src/cubic_sampled.rs",
        suites: &[OBSERVERS, CUBIC],
        mutants: &[
            mutant("sampled observer: + N impulse", Sign, "*xhat -= entry(n", "*xhat += entry(n"),
            mutant(
                "sampled observer: no cubic step",
                Dropped,
                "*xhat -= entry(n, i, impulse)",
                "let _ = (xhat, entry(n, i, impulse))",
            ),
            mutant(
                "sampled observer: y~ = y + C xhat",
                Sign,
                "(c, self.d.as_ref(), (xhat, u, y)",
                "(&(-c), self.d.as_ref(), (xhat, u, y)",
            ),
            mutant(
                "sampled observer: the flow of two periods",
                Constant,
                "self.flow(*period, innovation",
                "self.flow(*period + *period, innovation",
            ),
            mutant(
                "radial gain: C N off its diagonal is not looked at",
                OffDiagonal,
                "for j in 0..c.nrows()",
                "for j in i..=i",
            ),
            mutant("radial gain: C N - w I", Sign, "if i == j { w }", "if i == j { -w }"),
        ],
    },
    Source {
        file: "crates/observers/src/semi_implicit.rs",
        suites: &[SAMPLED],
        mutants: &[
            mutant("semi-implicit step: G = C N", Sign, "|i, j| -entry_of_product", "|i, j| entry_of_product"),
            mutant("semi-implicit step: no h", Dropped, ".max(zero) * t * size * size", ".max(zero) * size * size"),
            mutant("semi-implicit step: s of |y~|", Dropped, "* t * size * size", "* t * size"),
            mutant("semi-implicit step: I - s G", Sign, "{ one + entry } else", "{ one - entry } else"),
            mutant("semi-implicit step: impulse r", Dropped, "*impulse *= s;", "let _ = s;"),
            mutant(
                "semi-implicit step: the diagonal of G",
                OffDiagonal,
                "{ one + entry } else { entry }",
                "{ one + entry } else { zero }",
            ),
            mutant(
                "semi-implicit step: explicit innovation",
                Dropped,
                "*innovation = *impulse;",
                "let _ = innovation;",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/varying_period.rs",
        suites: &[SAMPLED],
        mutants: &[
            mutant("prediction: no input", Dropped, "slope + entry(&self.b, i, u.as_slice())", "slope"),
            mutant("prediction: no factorial", Dropped, "slope * tau / degree", "slope * tau"),
            mutant("correction: - K r", Sign, "+ entry(&self.k, i, innovation)", "- entry(&self.k, i, innovation)"),
            mutant("correction: + N i", Sign, "- entry(n, i, impulse)", "+ entry(n, i, impulse)"),
        ],
    },
    Source {
        file: "crates/proof/src/statement/semi_implicit.rs",
        suites: &[SAMPLED],
        mutants: &[
            mutant(
                "stored N: P N - C'S",
                Sign,
                "p.product(&n)?.sum(&c.transpose()",
                "p.product(&n)?.difference(&c.transpose()",
            ),
            mutant("stored N: C'S'", Transpose, "c.transpose().product(&s)?", "c.transpose().product(&s.transpose())?"),
            mutant("stored N: N N' for N'PN", WrongOperand, "&n.congruence(p)?", "&n.congruence(p)?.negative()"),
        ],
    },
    Source {
        file: "crates/proof/src/statement/varying_periods.rs",
        suites: &[TIMES],
        mutants: &[
            mutant("decrease over times: + X'PX", Sign, "self.level.difference(&x", "self.level.sum(&x"),
            mutant("decrease over times: factor P", Dropped, "p.scaled(&factor.mul(&factor))", "p.scaled(&factor)"),
            mutant(
                "decrease over times: the middles of the cells",
                Dropped,
                "&self.form(x)?.sum(&slope)?",
                "&self.form(x)?",
            ),
            mutant("decrease over times: no map", Dropped, "exponential.product(self.map)?", "exponential"),
        ],
    },
    Source {
        file: "crates/proof/src/statement/exponential.rs",
        suites: &[TIMES],
        mutants: &[
            mutant(
                "exponential: no factorial",
                Dropped,
                "let inverse = 1.0 / f64::from(degree);",
                "let inverse = 1.0;",
            ),
            mutant("exponential: doubled, not squared", WrongOperand, "power.product(&power)?", "power.sum(&power)?"),
            mutant(
                "exponential: the remainder of another degree",
                Constant,
                "const DEGREE: u32 = 20;",
                "const DEGREE: u32 = 5;",
            ),
        ],
    },
    Source {
        file: "crates/proof/src/statement/deployed/disturbance.rs",
        suites: &[DEPLOYED],
        mutants: &[mutant("deployed: the plant does not deviate", Dropped, ".sum(&self.deviation(&x, &u)?)?", "")],
    },
    Source {
        file: "crates/design/src/uncertain.rs",
        suites: &[UNCERTAIN],
        mutants: &[
            mutant(
                "sampled deviation: rounding only",
                Dropped,
                "(with - without).max(0.0) + rounding",
                "with.min(without).min(0.0) + rounding",
            ),
            mutant("sampled deviation: signs of the vertices", Dropped, "most.max(entry.abs())", "most.max(*entry)"),
            mutant(
                "sampled deviation: A for |A|",
                WrongOperand,
                "(plant.a.abs(), plant.b.abs())",
                "(-plant.a.abs(), plant.b.abs())",
            ),
            mutant("norm-bounded: signs of H", Dropped, "(h.abs() * DVector", "(h * DVector"),
        ],
    },
    Source {
        file: "crates/design/src/optimal_cubic/cost.rs",
        suites: &[OPTIMAL],
        mutants: &[
            mutant("cost: the sum over the first errors", Dropped, ".p.trace() / n as f64", ".p.trace()"),
            mutant("cost: process noise of intensity W", Dropped, "(&self.process / self.period)", "(&self.process)"),
            mutant("linear optimum: no mean", Dropped, "shares / (n as f64 * self.horizon)", "shares / self.horizon"),
        ],
    },
    Source {
        file: "crates/design/src/optimal_cubic/flow.rs",
        suites: &[OPTIMAL],
        mutants: &[
            mutant("error flow: linear in r", Dropped, "q * row_times(&self.gain", "row_times(&self.gain"),
            mutant(
                "error flow: no rest",
                Dropped,
                "(sum + rest).is_finite().then_some(sum + rest)",
                "(sum + rest).is_finite().then_some(sum)",
            ),
        ],
    },
    Source {
        file: "crates/design/src/varying_periods.rs",
        suites: &[SAMPLED],
        mutants: &[
            mutant("varying periods: I + K C", Sign, "- &k * o.c() }", "+ &k * o.c() }"),
            mutant(
                "varying periods: one period only",
                Dropped,
                "count as f64 * (shortest + share",
                "(shortest + share",
            ),
            mutant("varying periods: exp(A t) alone", Dropped, "? * &self.after)", "?)"),
            mutant(
                "varying periods: K = Ld",
                WrongOperand,
                "let k = correction_gain(o.ad(), o.ld())?;",
                "let k = o.ld().clone();",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/semidefinite.rs",
        suites: &[OBSERVERS],
        mutants: &[
            mutant(
                "theta >= 0 asked of theta, not of its symmetric part",
                Transpose,
                "(rest[(i, j)] + rest[(j, i)]) * half",
                "(rest[(i, j)] + rest[(i, j)]) * half",
            ),
            mutant(
                "semidefinite: the rest plus its pivot's part",
                Sign,
                "- factor * at(&rest, k, j)",
                "+ factor * at(&rest, k, j)",
            ),
            mutant(
                "semidefinite: the rest off the diagonal is not looked at",
                OffDiagonal,
                "(0..order).all(|j| j == i ||",
                "(0..i).all(|j| j <= i ||",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/discrete_linear.rs",
        suites: &[OBSERVERS, CUBIC],
        mutants: &[
            mutant("sampled observer: no Bd u", Dropped, "entry(b, i, u) + ", ""),
            mutant("sampled observer: - L y~", Sign, "+ entry(l, i, z)", "- entry(l, i, z)"),
        ],
    },
    Source {
        file: "crates/observers/src/runge_kutta.rs",
        suites: &[OBSERVERS],
        mutants: &[
            mutant(
                "Runge-Kutta: the third stage from the first",
                WrongOperand,
                "let k3 = slope(t + middle, &(&*x + &k2 * middle));",
                "let k3 = slope(t + middle, &(&*x + &k1 * middle));",
            ),
            mutant("Runge-Kutta: the fourth stage half a step", Constant, "&w3 * tau", "&w3 * middle"),
            mutant("Runge-Kutta: the weights of the middle stages", Constant, "(w2 + w3) * two", "(w2 + w3)"),
        ],
    },
    Source {
        file: "crates/observers/src/kalman.rs",
        suites: &[OBSERVERS],
        mutants: &[
            mutant("Kalman: S = H P H'", Dropped, "times_transpose(&hp, &h) + &v", "times_transpose(&hp, &h)"),
            mutant("Kalman: xhat - K y~", Sign, "xhat += times(&gain", "xhat -= times(&gain"),
            mutant("Kalman: I + K H", Sign, "order) - times(&gain, &h)", "order) + times(&gain, &h)"),
            mutant("Kalman: no K V K'", Dropped, " + times_transpose(&times(&gain, &v), &gain)", ""),
            mutant(
                "Kalman: (I - K H) P + K V K'",
                Dropped,
                "times_transpose(&times(&keep, p), &keep)",
                "times(&keep, p)",
            ),
            mutant("Kalman: a gate of variances", Dropped, "gate * gate * self", "gate * self"),
            mutant("Kalman: V of a silent output", Dropped, "v[(i, i)] = T::one();", ""),
            mutant("Kalman: V correlated with a silent output", OffDiagonal, "v.row_mut(i).fill(T::zero());", ""),
            mutant("Kalman: P' = F P + P F'", Dropped, "fp.transpose() + fp + w", "fp.transpose() + fp"),
            mutant("Kalman: P' = 2 F P + W", Transpose, "fp.transpose() + fp", "&fp + &fp"),
            mutant(
                "Kalman: h not divided by the sub-steps",
                Dropped,
                "let tau = duration / convert::<f64, T>(substeps as f64);\n        for k",
                "let tau = duration;\n        for k",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/discrete_kalman.rs",
        suites: &[OBSERVERS],
        mutants: &[
            mutant("discrete Kalman: no W", Dropped, ", ad) + w;", ", ad);"),
            mutant(
                "discrete Kalman: Ad' P Ad",
                Transpose,
                "times_transpose(&times(ad, &belief.covariance()), ad)",
                "times(&ad.transpose(), &times(&belief.covariance(), ad))",
            ),
            mutant("discrete Kalman: no Bd u", Dropped, " + bd * u;", ";"),
            mutant("discrete Kalman: y + C xhat", Sign, "y - c * belief.estimate()", "y + c * belief.estimate()"),
        ],
    },
    Source {
        file: "crates/observers/src/mean_value/mod.rs",
        suites: &[OBSERVERS, MEAN_VALUE],
        mutants: &[
            mutant(
                "mean value: alpha_k without its column",
                Dropped,
                "sum + d[(k, j)].abs() + d[(j, k)].abs()",
                "sum + d[(k, j)].abs()",
            ),
            mutant(
                "mean value: alpha_k without its row",
                Dropped,
                "sum + d[(k, j)].abs() + d[(j, k)].abs()",
                "sum + d[(j, k)].abs()",
            ),
            mutant(
                "mean value: alpha_k with signs",
                Sign,
                "d[(k, j)].abs() + d[(j, k)].abs()",
                "d[(k, j)] + d[(j, k)]",
            ),
            mutant("mean value: no eta", Dropped, "self.eta * gain(&d, k)", "gain(&d, k)"),
            mutant("mean value: xhat' = f - G e", Sign, "slope[k] += g * e1", "slope[k] -= g * e1"),
            mutant("mean value: e' = D e + G e", Sign, "error_slope[k] -= g * e[k]", "error_slope[k] += g * e[k]"),
            mutant("mean value: e1 = xhat - y", Sign, "{ y[k] - xhat[k] } else", "{ xhat[k] - y[k] } else"),
            mutant("mean value: unmeasured rows not corrected", Dropped, "else { e[k] };", "else { T::zero() };"),
            mutant(
                "mean value: measured rows corrected by e",
                WrongOperand,
                "if k < y.nrows() { y[k] - xhat[k] } else { e[k] }",
                "e[k]",
            ),
            mutant(
                "repair: G_m left in the error",
                Sign,
                "error_slope[k] -= g * (e1 - e[k])",
                "error_slope[k] += g * (e1 - e[k])",
            ),
            mutant("repair: - L surprise", Sign, "error_slope += l * surprise", "error_slope -= l * surprise"),
            mutant("repair: surprise y - C xhat", Dropped, "y[k] - xhat[k] - e[k]", "y[k] - xhat[k]"),
            mutant(
                "mean value: z = xhat - e",
                Sign,
                "self.estimate() + self.error()",
                "self.estimate() - self.error()",
            ),
            mutant("mean value: eta > 1", Hypothesis, "eta + eta > T::one()", "eta > T::one()"),
        ],
    },
    Source {
        file: "crates/observers/src/mean_value/integral.rs",
        suites: &[OBSERVERS, MEAN_VALUE],
        mutants: &[
            mutant(
                "integral mean: from xhat to xhat - e",
                Sign,
                "let at = xhat + e * convert",
                "let at = xhat - e * convert",
            ),
            mutant("integral mean: weights 1", Dropped, "u) * convert::<f64, T>(weight)", "u)"),
            mutant(
                "integral mean: D e = f(xhat) - f(xhat + e)",
                Sign,
                "plant.derivative(t, &(xhat + e), u) - plant.derivative(t, xhat, u),",
                "plant.derivative(t, xhat, u) - plant.derivative(t, &(xhat + e), u),",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/mean_value/beta.rs",
        suites: &[OBSERVERS, MEAN_VALUE],
        mutants: &[
            mutant(
                "mean value theorem: beta = 1/2 in every row",
                Constant,
                "_ => plant.state_jacobian(t, &(xhat + e * beta[i]), u)",
                "_ => plant.state_jacobian(t, &(xhat + e * half), u)",
            ),
            mutant("mean value theorem: D'e", Transpose, "&jacobian * e", "jacobian.transpose() * e"),
            mutant(
                "mean value theorem: 1/2 where X(1/2) is not 0",
                Hypothesis,
                "middle[i].abs() <= negligible[i] || ",
                "middle[i].abs() <= negligible[i] + T::one() || ",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/mean_value/mapped.rs",
        suites: &[OBSERVERS, MEAN_VALUE],
        mutants: &[
            mutant(
                "mapped observer: xhat = T^-1 zhat",
                WrongOperand,
                "&self.matrix * self.observer",
                "&self.inverse * self.observer",
            ),
            mutant(
                "mapped observer: zhat(0) = T xhat(0)",
                WrongOperand,
                "&self.inverse * estimate",
                "&self.matrix * estimate",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/kkl.rs",
        suites: &[OBSERVERS, KKL],
        mutants: &[
            mutant(
                "KKL: - Lambda xi + B",
                Sign,
                "self.lambda(t, u, y) * xi + self",
                "-self.lambda(t, u, y) * xi + self",
            ),
            mutant(
                "KKL: Lambda'xi + B",
                Transpose,
                "self.lambda(t, u, y) * xi",
                "self.lambda(t, u, y).transpose() * xi",
            ),
            mutant("KKL: Lambda xi - B", Sign, "* xi + self.injection", "* xi - self.injection"),
            mutant("linear KKL: no E u", Dropped, "&self.b * y + &self.e * u", "&self.b * y"),
            mutant("linear KKL: E u - B y", Sign, "&self.b * y + &self.e * u", "&self.e * u - &self.b * y"),
        ],
    },
    Source {
        file: "crates/observers/src/kkl_peb.rs",
        suites: &[OBSERVERS, KKL],
        mutants: &[
            mutant("[KKL+PEB]: phi^L(xi - missing)", Sign, "&parts.xi + self.map", "&parts.xi - self.map"),
            mutant(
                "[KKL+PEB]: xi(0) = phi + missing",
                Sign,
                "estimate, y) - self.map.missing",
                "estimate, y) + self.map.missing",
            ),
            mutant(
                "[KKL+PEB]: Y = W[s] + F[g]",
                Sign,
                "&self.map.signal(t, y)) - parts.known",
                "&self.map.signal(t, y)) + parts.known",
            ),
            mutant("[KKL+PEB]: w(0) = 0", Dropped, "xi.iter().chain(signal.iter())", "xi.iter()"),
            mutant("[KKL+PEB]: F[g] filters s", WrongOperand, "&self.map.known(t, xi, u, y)", "&self.map.signal(t, y)"),
            mutant(
                "[KKL+PEB]: theta_hat not held in its domain",
                Hypothesis,
                ".map_or(theta, |bound| theta.max(bound))",
                ".map_or(theta, |_| theta)",
            ),
            mutant(
                "[KKL+PEB]: projected when it rises",
                Sign,
                "&& slope[offset + i] < T::zero()",
                "&& slope[offset + i] > T::zero()",
            ),
            mutant(
                "[KKL+PEB]: leaves its domain in 1/alpha, other sign",
                Sign,
                "(bound - value) >= rate / self",
                "(bound - value) <= rate / self",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/filters.rs",
        suites: &[OBSERVERS, KKL],
        mutants: &[
            mutant(
                "filters: f' = alpha (f - g)",
                Sign,
                "(signal - state) * self.alpha",
                "(state - signal) * self.alpha",
            ),
            mutant("filters: f' = g - f", Dropped, "(signal - state) * self.alpha", "signal - state"),
            mutant("filters: W without alpha", Dropped, "self.rate(state, signal)", "signal - state"),
        ],
    },
    Source {
        file: "crates/observers/src/high_gain.rs",
        suites: &[OBSERVERS, KKL],
        mutants: &[
            mutant(
                "high gain: alpha_i/r^(j - 1)",
                Constant,
                "(0..map.place(i).position)",
                "(1..map.place(i).position)",
            ),
            mutant("high gain: y + head", Sign, "error[output] -= xi[i]", "error[output] += xi[i]"),
            mutant("high gain: b - s alpha/r^j (y - head)", Sign, "slope[i] += shape", "slope[i] -= shape"),
            mutant("high gain: no shape", Dropped, "shape[i] * self.gain[i]", "self.gain[i]"),
        ],
    },
    Source {
        file: "crates/observers/src/immersion_invariance.rs",
        suites: &[OBSERVERS, KKL],
        mutants: &[
            mutant(
                "I&I: Dphi f + D_y beta Dh f",
                Sign,
                "&f) - self.map.beta_directional",
                "&f) + self.map.beta_directional",
            ),
            mutant(
                "I&I: no D_y beta Dh f",
                Dropped,
                "self.map.beta_directional(y, chi, &output_rate, &still)",
                "self.map.beta_directional(y, chi, &output_rate, &still) * T::zero()",
            ),
            mutant("I&I: - rho", Sign, "wanted += rho", "wanted -= rho"),
            mutant("I&I: Q not projected", Dropped, "(wanted - seen)", "wanted"),
            mutant("I&I: I + projector", Sign, "(wanted - seen)", "(wanted + seen)"),
            mutant("I&I: no Q in the kernel", Dropped, "free + pseudo_inverse", "pseudo_inverse"),
            mutant(
                "I&I: f at the output's rate 0",
                WrongOperand,
                "output_directional(t, &xhat, u, &f).1",
                "output_directional(t, &xhat, u, &f).0",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/estimator/gradient.rs",
        suites: &[OBSERVERS],
        mutants: &[
            mutant("gradient: Y + M theta_hat", Sign, "y - m * leading", "y + m * leading"),
            mutant("gradient: no Gamma", Dropped, "&self.gain * m.tr_mul(&residual)", "m.tr_mul(&residual)"),
            mutant(
                "gradient: the diagonal of Gamma alone",
                OffDiagonal,
                "&self.gain * m.tr_mul(&residual)",
                "OMatrix::from_diagonal(&self.gain.diagonal()) * m.tr_mul(&residual)",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/estimator/drem.rs",
        suites: &[OBSERVERS, KKL],
        mutants: &[
            mutant(
                "DREM: no Delta in front",
                Dropped,
                "self.gain[i] * mixed.determinant * (v[i]",
                "self.gain[i] * (v[i]",
            ),
            mutant("DREM: v - theta_hat", Dropped, "v[i] - mixed.determinant * theta", "v[i] - theta"),
            mutant("DREM: v + Delta theta_hat", Sign, "v[i] - mixed.determinant", "v[i] + mixed.determinant"),
            mutant("DREM: adj(Phi)'Z", Transpose, "&mixed.adjugate * z", "mixed.adjugate.transpose() * z"),
            mutant("DREM: one gamma for all", OffDiagonal, "self.gain[i] * mixed", "self.gain[0] * mixed"),
            mutant("Kreisselmeier: + a Phi", Sign, "source - state * self.a", "source + state * self.a"),
            mutant("Kreisselmeier: a = 1", Dropped, "source - state * self.a", "source - state"),
            mutant(
                "Kreisselmeier: Z' = a (M'Y - Z), Phi as before",
                Dropped,
                "let (right, gram) = (m.tr_mul(y), m.tr_mul(m))",
                "let (right, gram) = (m.tr_mul(y) * self.a, m.tr_mul(m))",
            ),
            mutant("filters of DREM: no beta", Dropped, "(*source - state[at]) * beta", "*source - state[at]"),
            mutant(
                "filters of DREM: the normal equations of the present alone",
                Dropped,
                "(0..rows).fold(T::zero(), |sum, row|",
                "(0..r).fold(T::zero(), |sum, row|",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/estimator/excitation.rs",
        suites: &[OBSERVERS, KKL],
        mutants: &[
            mutant("excitation: + mu E", Sign, "seen - gram * self.mu", "seen + gram * self.mu"),
            mutant("excitation: det E/trace E^(q-1)", Dropped, "product * count", "product"),
            mutant(
                "excitation: q in the place of q - 1",
                Constant,
                "nalgebra::convert(others as f64)",
                "nalgebra::convert(gram.nrows() as f64)",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/estimator/adjugate.rs",
        suites: &[OBSERVERS],
        mutants: &[
            mutant(
                "adjugate: no sign of the permutation of columns",
                Sign,
                "columns.swap_rows(k, column);\n            sign = -sign;",
                "columns.swap_rows(k, column);",
            ),
            mutant("adjugate: + sum/u", Sign, "middle[(i, j)] = -sum", "middle[(i, j)] = sum"),
        ],
    },
    Source {
        file: "crates/design/src/cubic.rs",
        suites: &[DESIGNS, CUBIC],
        mutants: &[
            mutant("(14): N = P^-1 C'S", Sign, "let n = -(p_inverse_ct * &s)", "let n = p_inverse_ct * &s"),
            mutant(
                "(14): N = -P^-1 C'S'",
                Transpose,
                "let n = -(p_inverse_ct * &s)",
                "let n = -(p_inverse_ct * s.transpose())",
            ),
            mutant(
                "(14): N = -P C'S",
                WrongOperand,
                "check::solve_definite(\"P\", &linear.p, &o.c.transpose())?",
                "&linear.p * o.c.transpose()",
            ),
            mutant("(14): no gamma", Dropped, "theta * *gamma", "theta.clone()"),
            mutant(
                "cubic design: any symmetric theta",
                Hypothesis,
                "check::positive_semidefinite(\"theta\", theta, outputs)",
                "check::symmetric(\"theta\", theta, outputs)",
            ),
            mutant(
                "cubic design: any S",
                Hypothesis,
                "check::positive_semidefinite(\"S + S'\", &(s + s.transpose()), outputs)?;",
                "",
            ),
            mutant("cubic design: S = S' >= 0 asked", Hypothesis, "&(s + s.transpose())", "&(s + s)"),
            mutant(
                "radial S: no w",
                Dropped,
                "&(DMatrix::identity(outputs, outputs) * w)",
                "&DMatrix::identity(outputs, outputs)",
            ),
            mutant(
                "radial S: w C P^-1 C'",
                WrongOperand,
                "check::solve_definite(\"C P^-1 C'\", &symmetric_part(&gram), \
                 &(DMatrix::identity(outputs, outputs) * w))",
                "Ok(gram * w)",
            ),
            mutant("cubic design: F = A + L C", Sign, "&self.observer.a - &self", "&self.observer.a + &self"),
        ],
    },
    Source {
        file: "crates/proof/src/statement/input_to_state.rs",
        suites: &[INPUT_TO_STATE],
        mutants: &[
            mutant("cubic part: 26/128", Constant, "number(27.0)?", "number(26.0)?"),
            mutant("cubic part: s^2", Dropped, ".mul(&square.mul(&square))", ".mul(&square)"),
            mutant("theta <= kappa (S + S')", Constant, ".difference(&theta.sum(&theta)?)", ".difference(&theta)"),
            mutant("noise: D'S without the 2", Constant, "&corner.sum(&corner)?, &s.plus", "&corner, &s.plus"),
            mutant(
                "noise: diag(mu) doubled",
                Constant,
                "first.sum(&first)?.bordered(",
                "first.sum(&first)?.sum(&first)?.sum(&first)?.bordered(",
            ),
            mutant("disturbances: G = E + LD", Sign, "&e.difference(&l.product(&d)?)?", "&e.sum(&l.product(&d)?)?"),
            mutant("decrease: no rate", Dropped, "?.sum(&Matrix::scalar(p.rows(), &rate))?", "?"),
            mutant("components: limsup for its square", Dropped, "p.scaled(&limsup.mul(&limsup))", "p.scaled(&limsup)"),
            mutant("level: W_i for W_i^2", Dropped, ".mul(&w.mul(&w))", ".mul(&w)"),
        ],
    },
    Source {
        file: "crates/proof/src/statement/system_norm.rs",
        suites: &[FILTERS],
        mutants: &[
            mutant("norms: F = A + LC", Sign, "\"A\")?.difference(", "\"A\")?.sum("),
            mutant("norms: G = E + LD", Sign, "\"E\")?.difference(", "\"E\")?.sum("),
            mutant("norms: no H'H", Dropped, "let first = first.sum(&seen)?;", ""),
            mutant("H-infinity: gamma", Dropped, "g.cols(), &gamma.mul(&gamma))", "g.cols(), &gamma)"),
            mutant(
                "H-infinity: no corner",
                Dropped,
                "first.bordered(&corner,",
                "first.bordered(&corner.difference(&corner)?,",
            ),
            mutant("discrete H-infinity: PG for F'PG", Dropped, "f.transpose().product(&driven)?, g", "driven, g"),
            mutant("discrete H-infinity: no G'PG", Dropped, "g.congruence(&p)?)", "Matrix::zeros(g.cols(), g.cols()))"),
            mutant("discrete: F'PF without P", Dropped, "f.congruence(&p)?.difference(&p)?", "f.congruence(&p)?"),
            mutant("H2: gamma", Dropped, "fold(gamma.mul(&gamma)", "fold(gamma.clone()"),
            mutant("H2: gamma^2 + tr", Sign, "room.sub(&spent", "room.add(&spent"),
        ],
    },
    Source {
        file: "crates/proof/src/statement/reduced_order.rs",
        suites: &[FILTERS],
        mutants: &[
            mutant(
                "reduced order: F = TA (C'C + T'T)^-1",
                Dropped,
                ".product(&a)?.product(&inverse)?.product(",
                ".product(&a)?.product(",
            ),
            mutant("reduced order: no rate", Dropped, "flow.sum(&Matrix::scalar(order, &rate))?", "flow"),
            mutant(
                "reduced order: T'T alone",
                Dropped,
                "square(self.c, \"C\")?.sum(&square(self.t, \"T\")?)",
                "square(self.t, \"T\")",
            ),
        ],
    },
    Source {
        file: "crates/design/src/norm_filter/programs.rs",
        suites: &[FILTERS],
        mutants: &[
            mutant("filters: YC", Sign, "&p * &plant.a - &y * &plant.c", "&p * &plant.a + &y * &plant.c"),
            mutant("filters: YD", Sign, "&p * &of.e - &y * &of.d", "&p * &of.e + &y * &of.d"),
            mutant("H-infinity design: no H'H", Dropped, "block![[he(flow) + seen, driven", "block![[he(flow), driven"),
        ],
    },
    Source {
        file: "crates/proof/src/statement/interval_observer.rs",
        suites: &[INTERVAL],
        mutants: &[
            mutant(
                "interval: half of the spectral norm",
                Dropped,
                "Interval::of(turned).add(&Interval::of(mirrored)).hi() / 2.0",
                "turned / 2.0",
            ),
            mutant(
                "interval: mu without the spread",
                Dropped,
                "a.add(d).add(&Interval::of(spread)).hi() / 2.0",
                "a.add(d).hi() / 2.0",
            ),
            mutant(
                "interval: the norm in place of mu",
                WrongOperand,
                "if k == j { logarithmic_norm(",
                "if k == j && k > m.rows() { logarithmic_norm(",
            ),
            mutant(
                "interval: no noise in g",
                Dropped,
                ".sum(&forced(&l, &v)?)?.sum(&rounded_noise)?",
                ".sum(&rounded_noise)?",
            ),
            mutant(
                "interval: no disturbance in g",
                Dropped,
                "forced(&e, &w)?.sum(&forced(&l, &v)?)?",
                "forced(&l, &v)?",
            ),
            mutant(
                "interval: T F in place of T F T^-1",
                Dropped,
                "self.t.product(f)?.product(&self.inverse)",
                "self.t.product(f)?.product(&Matrix::scalar(self.order(), &Interval::point(1.0)))",
            ),
            mutant(
                "interval: H of T",
                WrongOperand,
                "norm(&self.inverse, (i, 1), self.blocks[k])",
                "norm(&self.t, (i, 1), self.blocks[k])",
            ),
            mutant(
                "interval: a disturbance held over the period",
                Dropped,
                "chain(rest.as_slice().iter().copied())",
                "chain(rest.as_slice().iter().map(|_| 0.0))",
            ),
        ],
    },
    Source {
        file: "crates/design/src/interval/gain.rs",
        suites: &[INTERVAL],
        mutants: &[
            mutant("least width: no bounds W", Dropped, "let term = bounds[j] * &bound;", "let term = 1.0 * &bound;"),
            mutant("least width: E + LD", Sign, "&weight * e - &y * d", "&weight * e + &y * d"),
        ],
    },
    Source {
        file: "crates/observers/src/interval.rs",
        suites: &[INTERVAL],
        mutants: &[
            mutant("interval observer: no g", Dropped, "entry(k, i, rho) + g[i]", "entry(k, i, rho)"),
            mutant("interval step: y + C xhat", Sign, "*y - entry(&g.c, i, xhat)", "*y + entry(&g.c, i, xhat)"),
            mutant(
                "interval step: no constant",
                Dropped,
                "entry(&g.blocks, k, rho) + g.constant.get(k).copied().unwrap_or_else(T::zero)",
                "entry(&g.blocks, k, rho)",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/sliding_mode.rs",
        suites: &[SLIDING],
        mutants: &[
            mutant(
                "sliding mode: the sign in the layer",
                Hypothesis,
                "return (zero, z / layer);",
                "return (zero, sign);",
            ),
            mutant("sliding mode: layer h^n", Dropped, "|layer, _| layer * self.h)", "|layer, _| layer)"),
            mutant("sliding mode: half the root", Constant, "(rest + rest) / (a +", "rest / (a +"),
            mutant("sliding mode: correction to the explicit power", Constant, "for j in i..n {", "for j in i..=i {"),
            mutant("sliding mode: no Newton step", Dropped, "for _ in 0..NEWTON {", "for _ in 0..0 * NEWTON {"),
            mutant("sliding mode: weight without 1/degree!", Dropped, "weight * self.h / degree;", "weight * self.h;"),
            mutant(
                "Levant: gains of the recursive form",
                Dropped,
                "convert::<f64, T>(RECURSIVE[n - 1 - i]) * c.powf(exponent)",
                "convert::<f64, T>(RECURSIVE[n - 1 - i]) + (c - c).powf(exponent)",
            ),
        ],
    },
    Source {
        file: "crates/proof/src/statement/super_twisting.rs",
        suites: &[SLIDING],
        mutants: &[
            mutant("super-twisting: k2 for 2 k2", Dropped, "k2.add(&k2).neg()", "k2.neg()"),
            mutant(
                "super-twisting: bound for its square",
                Dropped,
                "let square = bound.mul(&bound);",
                "let square = bound.clone();",
            ),
            mutant("super-twisting: c for its square", Dropped, "scaled(&c.mul(&c))", "scaled(&c)"),
        ],
    },
    Source {
        file: "crates/design/src/sliding_mode.rs",
        suites: &[SLIDING],
        mutants: &[
            mutant("super-twisting: alpha unscaled", Dropped, "(alpha * root, c *", "(alpha, c *"),
            mutant("super-twisting: half the time", Constant, "2.0 * self.c / self.alpha", "self.c / self.alpha"),
            mutant(
                "reaching time: a quarter turn",
                Constant,
                "k1 / (4.0 * square.sqrt())",
                "k1 / (8.0 * square.sqrt())",
            ),
            mutant("reaching time: against d", Sign, "(k - d * e.signum())", "(k + d * e.signum())"),
        ],
    },
    Source {
        file: "crates/observers/src/unknown_input.rs",
        suites: &[INPUT_TO_STATE],
        mutants: &[
            mutant(
                "unknown input: xhat = z",
                Dropped,
                "T::one(), estimate.as_mut_slice()",
                "T::zero(), estimate.as_mut_slice()",
            ),
            mutant(
                "unknown input: the flow at z",
                WrongOperand,
                "derivative(t, &estimate, u, y)",
                "derivative(t, state, u, y)",
            ),
        ],
    },
    Source {
        file: "crates/design/src/unknown_input.rs",
        suites: &[INPUT_TO_STATE],
        mutants: &[
            mutant(
                "unknown input: T = I + HC",
                Sign,
                "DMatrix::identity(n, n) - &h * &of.c",
                "DMatrix::identity(n, n) + &h * &of.c",
            ),
            mutant(
                "unknown input: H = E (CE)'",
                Dropped,
                "e * check::solve_definite(\"(CE)'CE\", &gram, &image.transpose())?",
                "e * image.transpose()",
            ),
            mutant("unknown input: any zeros", Hypothesis, "zero.re >= 0.0)", "zero.re >= f64::INFINITY)"),
        ],
    },
    Source {
        file: "crates/design/src/proportional_integral.rs",
        suites: &[INPUT_TO_STATE, DESIGNS],
        mutants: &[
            mutant(
                "proportional-integral: x' = Ax + Bu - Ed",
                Sign,
                "n + q => e[(i, j - n)]",
                "n + q => -e[(i, j - n)]",
            ),
            mutant("extended state: d' = -d_rate", Sign, "if j == i + q => 1.0", "if j == i + q => -1.0"),
            mutant(
                "proportional-integral: no rank condition",
                Hypothesis,
                "has_full_column_rank(&check::exactly(&system)?)? == Some(false)",
                "false",
            ),
        ],
    },
    Source {
        file: "crates/design/src/error_bound/mod.rs",
        suites: &[INPUT_TO_STATE],
        mutants: &[
            mutant("error bound: S for S' in mu", Transpose, "s.transpose() * &self.d;", "&s * &self.d;")
                .equivalent("S'S_s^-1 S = S S_s^-1 S' for S = S_s + K, S_s = S_s', K = -K': both are S_s - K S_s^-1 K"),
            mutant("error bound: 27/256", Constant, "27.0 / 128.0 * kappa", "27.0 / 256.0 * kappa"),
            mutant("error bound: G = E + LD", Sign, "(e - &self.l * &self.d)", "(e + &self.l * &self.d)"),
            mutant(
                "error bound: sqrt(U) (P^-1)_kk",
                Dropped,
                "(level * z[(k, k)]).sqrt() * up",
                "level.sqrt() * z[(k, k)] * up",
            ),
            mutant("error bound: 2 alpha dropped", Constant, "/ (2.0 * rate) * up", "/ rate * up"),
        ],
    },
    Source {
        file: "crates/design/src/feedback.rs",
        suites: &[DESIGNS, CUBIC],
        mutants: &[
            mutant("Theorem 6: A + B K", Sign, "(&o.a, &o.b, k))?", "(&o.a, &-&o.b, k))?"),
            mutant(
                "Theorem 6: four times the mu",
                Constant,
                "0.5 * lambda_min(&observer.q)?",
                "2.0 * lambda_min(&observer.q)?",
            ),
            mutant("Theorem 6: no lambda_min(Q) in mu", Dropped, "0.5 * lambda_min(&observer.q)?", "0.5"),
            mutant("Theorem 6: P1 = P0", Dropped, "let p1 = p0 * mu", "let p1 = p0"),
            mutant("Theorem 6: |B K| in the place of |P0 B K|", Dropped, "&p0 * &o.b * k", "&o.b * k"),
            mutant(
                "Theorem 6: lambda_max of the other Gram matrix",
                Transpose,
                "&(coupling.transpose() * &coupling)",
                "&(&coupling * coupling.transpose())",
            )
            .equivalent("M'M and MM' have the same largest eigenvalue"),
        ],
    },
    Source {
        file: "crates/design/src/joint.rs",
        suites: &[DESIGNS, CUBIC],
        mutants: &[
            mutant("joint design: S + S' < 0", Sign, "he(&s) >> 0.0", "he(&s) << 0.0"),
            mutant("joint design: |S| not scaled", Dropped, "(gamma / s.norm())", "gamma"),
            mutant("joint design: stability only", Dropped, "rate, lmi, &GainOptions", "0.0, lmi, &GainOptions"),
            mutant("joint design: S'", Transpose, "CubicGain::General(s)", "CubicGain::General(s.transpose())")
                .equivalent(
                    "S stands in the inequality as S + S' alone: with S, S' is a solution too, and nothing \
                 distinguishes the two",
                ),
        ],
    },
    Source {
        file: "crates/design/src/gain_lmi.rs",
        suites: &[DESIGNS, CUBIC],
        mutants: &[
            mutant("gain by LMI: + Y C", Sign, "&*p * a - &*y * c", "&*p * a + &*y * c"),
            mutant("gain by LMI: rate P in the place of 2 rate P", Constant, "(2.0 * rate)", "rate"),
            mutant("gain by LMI: - 2 rate P", Sign, ") + (2.0 * rate)", ") - (2.0 * rate)"),
            mutant(
                "gain by LMI: L = Y",
                Dropped,
                "let l = check::solve_definite(\"P\", &p, &value(\"Y\"))?",
                "let l = value(\"Y\")",
            ),
        ],
    },
    Source {
        file: "crates/design/src/sampled.rs",
        suites: &[DESIGNS, CUBIC],
        mutants: &[
            mutant("sampled design: z = h s", WrongOperand, "(s * h).exp()", "s * h"),
            mutant("sampled design: Fd = Ad + Ld C", Sign, "&ad - &ld * &c", "&ad + &ld * &c"),
            mutant(
                "sampled design: Fd P Fd' - P",
                Transpose,
                "let mut equation = SteinEquation::new(&f)?",
                "let mut equation = SteinEquation::new(&f.transpose())?",
            ),
            mutant("sampled design: Q = I", Dropped, "&(DMatrix::identity(n, n) * h)", "&DMatrix::identity(n, n)"),
            mutant(
                "sampled design: N = P^-1 C'S",
                Sign,
                "let gain = -(p_inverse_ct * &s)",
                "let gain = p_inverse_ct * &s",
            ),
            mutant(
                "sampled form of a design: the strength 1",
                Dropped,
                "&o.theta, luenberger_observers::cubic::rate(&o.c, &o.n)",
                "&o.theta, 1.0",
            ),
        ],
    },
    Source {
        file: "crates/design/src/check.rs",
        suites: &[DESIGNS, CUBIC],
        mutants: &[
            mutant(
                "(9): F P + P F'",
                Transpose,
                "LyapunovEquation::new(&f);",
                "LyapunovEquation::new(&f.transpose());",
            ),
            mutant("(9): F = A + L C", Sign, "let f = a - l * c;", "let f = a + l * c;"),
        ],
    },
    Source {
        file: "crates/design/src/linear.rs",
        suites: &[DESIGNS, CUBIC],
        mutants: &[
            mutant("(9): Q = I whatever rho", Dropped, "DMatrix::identity(n, n) * rho", "DMatrix::identity(n, n)"),
            mutant(
                "information: P = Sigma",
                WrongOperand,
                "let p = symmetric_part(&inverse)",
                "let p = symmetric_part(&(&inverse * covariance * covariance))",
            ),
            mutant("poles on the imaginary axis", Hypothesis, "pole.re >= 0.0", "pole.re > 0.0"),
            mutant(
                "(9): Q of the LMI with F'P alone",
                Transpose,
                "let half = &p * &f;\n        let q = -(&half + half.transpose())",
                "let half = &p * &f;\n        let q = -(&half + &half)",
            ),
        ],
    },
    Source {
        file: "crates/design/src/conditions.rs",
        suites: &[DESIGNS, CUBIC],
        mutants: &[
            mutant(
                "(13): P N C + C'N'P > 0",
                Sign,
                "negative_definite(&product)",
                "luenberger_proof::positive_definite(&product)",
            ),
            mutant(
                "(13): - P N C",
                Sign,
                "Matrix::embed(&theorem.n, \"N\")",
                "Matrix::embed(&proof_matrix(&-n), \"N\")",
            ),
        ],
    },
    Source {
        file: "crates/design/src/weights.rs",
        suites: &[DESIGNS, CUBIC],
        mutants: &[
            mutant("cost shares: F M + M F'", Transpose, "lyapunov(&f, ", "lyapunov(&f.transpose(), "),
            mutant("cost shares: trace(M)", Dropped, "m.trace() / n as f64", "m.trace()")
                .equivalent("the factor 1/n, common to all outputs, cancels in J_i/sum J_j"),
            mutant("cost shares: trace 1", Dropped, "(scale / total)", "(1.0 / total)"),
            mutant(
                "importance: negative indices",
                Hypothesis,
                "check::positive_semidefinite(\"theta\", &theta, importance.len())?;",
                "",
            ),
        ],
    },
    Source {
        file: "crates/design/src/robust/bounds.rs",
        suites: &[DESIGNS, CUBIC],
        mutants: &[
            mutant("(23): no 2", Constant, "(2.0 * lambda_max(p)?)", "lambda_max(p)?"),
            mutant("(23): lambda_min(P)", WrongOperand, "(2.0 * lambda_max(p)?)", "(2.0 * lambda_min(p)?)"),
            mutant("(23): lambda_max(Q)", WrongOperand, "Ok(lambda_min(q)? /", "Ok(lambda_max(q)? /"),
            mutant("margin of P: no 1/2", Constant, "Some(0.5 * lambda_min", "Some(1.0 * lambda_min"),
            mutant("margin of P: G^-2 Q", Transpose, "solve(&half.transpose())", "solve(&half)"),
            mutant("redesigned margin: the abscissa", Sign, "Ok(-abscissa)", "Ok(abscissa)"),
            mutant(
                "input to state: no root",
                Dropped,
                "(lambda_max(p)? / lambda_min(p)?).sqrt()",
                "(lambda_max(p)? / lambda_min(p)?)",
            ),
            mutant("input to state: sqrt(cond P) alpha", WrongOperand, ".sqrt() / alpha", ".sqrt() * alpha"),
            mutant(
                "input to state: no cond P",
                Dropped,
                "(lambda_max(p)? / lambda_min(p)?).sqrt() / alpha",
                "1.0 / alpha",
            ),
        ],
    },
    Source {
        file: "crates/design/src/robust/fixed_gain.rs",
        suites: &[DESIGNS, CUBIC],
        mutants: &[
            mutant("fixed gain: eps P in the place of 2 eps P", Constant, "(2.0 * eps)", "eps"),
            mutant("fixed gain: - 2 eps P", Sign, "he(half) + (2.0", "he(half) - (2.0"),
            mutant(
                "fixed gain: S + S' < 0",
                Sign,
                "he(&g * c * self.n_gain) << 0.0",
                "he(&g * c * self.n_gain) >> 0.0",
            ),
            mutant(
                "fixed gain: any S",
                Hypothesis,
                "lmi.constrain(\"S + S' > 0\", he(&g * c * self.n_gain) << 0.0);",
                "",
            ),
            mutant("fixed gain: S = G C N", Sign, "let s = -(g * &self.cn)", "let s = g * &self.cn"),
            mutant("fixed gain: S'", Transpose, "let s = -(g * &self.cn)", "let s = -(g * &self.cn).transpose()"),
            mutant("fixed gain: P = C'G C - T'Y T", Sign, "p += self.t", "p -= self.t"),
            mutant("fixed gain: A + L C", Sign, "- &p * self.l * c", "+ &p * self.l * c"),
            mutant("fixed gain: T N = 0 with the other sign", Sign, "-n_gain[(j, 0)]", "n_gain[(j, 0)]"),
        ],
    },
    Source {
        file: "crates/design/src/robust/polytope.rs",
        suites: &[DESIGNS, CUBIC],
        mutants: &[
            mutant(
                "Theorem 4: the nominal plant left out",
                Dropped,
                "std::iter::once(nominal.a.clone()).chain(vertices.iter().cloned())",
                "vertices.iter().cloned()",
            ),
            mutant(
                "Theorem 4: the last vertex left out",
                Dropped,
                "chain(vertices.iter().cloned())",
                "chain(vertices.iter().skip(1).cloned())",
            ),
            mutant("Theorem 4: stability only", Dropped, "&all, rate, Problem", "&all, 0.0, Problem"),
        ],
    },
    Source {
        file: "crates/design/src/robust/positive_real.rs",
        suites: &[DESIGNS, DESIGN_UNITS],
        mutants: &[
            mutant("positive real: signs of i^j (-i)^k", Sign, "j.abs_diff(k) % 4 == 0", "j.abs_diff(k) % 2 == 0"),
            mutant("positive real: C (s I - A)^-1 B", Sign, "-(c * &adjugate * b)", "(c * &adjugate * b)"),
            mutant(
                "positive real: Faddeev and LeVerrier without 1/k",
                Dropped,
                "-product.trace() / k as f64",
                "-product.trace()",
            ),
            mutant("positive real: q' without its powers", Dropped, "k as f64 * a)", "*a)"),
            mutant(
                "positive real: companion of the other sign",
                Sign,
                "subdiagonal - polynomial[i]",
                "subdiagonal + polynomial[i]",
            ),
            mutant(
                "positive real: the leading coefficient not asked",
                Hypothesis,
                "q.last().is_none_or(|&leading| leading <= 0.0)",
                "q.is_empty()",
            ),
        ],
    },
    // General theta >= 0 is a hypothesis of every theorem: the properties of the theorems themselves have to notice.
    Source {
        file: "crates/observers/src/cubic.rs",
        suites: &[CUBIC],
        mutants: &[
            mutant(
                "cubic observer: the diagonal of theta alone",
                OffDiagonal,
                "*left * entry(theta, i, v)",
                "*left * theta[(i, i)] * v[i]",
            ),
            mutant(
                "cubic observer: theta11 I",
                OffDiagonal,
                "*left * entry(theta, i, v)",
                "*left * theta[(0, 0)] * v[i]",
            ),
        ],
    },
    Source {
        file: "crates/design/src/cubic.rs",
        suites: &[CUBIC],
        mutants: &[
            mutant(
                "(14): the diagonal of theta in S",
                OffDiagonal,
                "theta * *gamma",
                "DMatrix::from_diagonal(&theta.diagonal()) * *gamma",
            ),
            mutant(
                "(14): theta11 I in S",
                OffDiagonal,
                "theta * *gamma",
                "DMatrix::identity(outputs, outputs) * (theta[(0, 0)] * *gamma)",
            ),
            mutant(
                "(5): the diagonal of theta in the observer",
                OffDiagonal,
                "o.l.clone(), n, theta.clone())",
                "o.l.clone(), n, DMatrix::from_diagonal(&theta.diagonal()))",
            ),
            mutant(
                "(5): theta11 I in the observer",
                OffDiagonal,
                "o.l.clone(), n, theta.clone())",
                "o.l.clone(), n, DMatrix::identity(outputs, outputs) * theta[(0, 0)])",
            ),
            mutant(
                "cubic design: the diagonal of theta everywhere",
                OffDiagonal,
                "&check::positive_semidefinite(\"theta\", theta, outputs)?",
                "&DMatrix::from_diagonal(&check::positive_semidefinite(\"theta\", theta, outputs)?.diagonal())",
            ),
            mutant(
                "cubic design: theta11 I everywhere",
                OffDiagonal,
                "&check::positive_semidefinite(\"theta\", theta, outputs)?",
                "&(DMatrix::identity(outputs, outputs) * check::positive_semidefinite(\"theta\", theta, \
                 outputs)?[(0, 0)])",
            ),
        ],
    },
    Source {
        file: "crates/design/src/sampled.rs",
        suites: &[CUBIC],
        mutants: &[
            mutant(
                "sampled design: the diagonal of theta",
                OffDiagonal,
                "theta: theta.clone(),",
                "theta: DMatrix::from_diagonal(&theta.diagonal()),",
            ),
            mutant(
                "sampled design: theta11 I",
                OffDiagonal,
                "theta: theta.clone(),",
                "theta: DMatrix::identity(outputs, outputs) * theta[(0, 0)],",
            ),
        ],
    },
];
