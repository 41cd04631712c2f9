//! Mutants of the statements that certificates prove.

use super::Kind::{Constant, Dropped, Hypothesis, OffDiagonal, Sign, Transpose, WrongOperand};
use super::{
    DEPLOYED, FILTERS, INPUT_TO_STATE, INTERVAL, KKL_BOUND, LEFT_INVERSES, SAMPLED, SLIDING, SYSTEMS, Source, TIMES,
    dropped, mutant, sign,
};

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
            sign("KKL bound: residual + Lambda phi", "sum = sum.minus(&arena.product(&lambda[i * q + j], phi_j)?);"),
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
        file: "crates/proof/src/statement/semi_implicit.rs",
        suites: &[SAMPLED],
        mutants: &[
            sign("stored N: P N - C'S", "p.product(&n)?.sum(&c.transpose()"),
            mutant("stored N: C'S'", Transpose, "c.transpose().product(&s)?", "c.transpose().product(&s.transpose())?"),
            mutant("stored N: N N' for N'PN", WrongOperand, "&n.congruence(p)?", "&n.congruence(p)?.negative()"),
        ],
    },
    Source {
        file: "crates/proof/src/statement/varying_periods.rs",
        suites: &[TIMES],
        mutants: &[
            sign("decrease over times: + X'PX", "self.level.difference(&x"),
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
                "let inverse = 1.0_f64;",
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
            sign("disturbances: G = E + LD", "&e.difference(&l.product(&d)?)?"),
            mutant("decrease: no rate", Dropped, "?.sum(&Matrix::scalar(p.rows(), &rate))?", "?"),
            mutant("components: limsup for its square", Dropped, "p.scaled(&limsup.mul(&limsup))", "p.scaled(&limsup)"),
            mutant("level: W_i for W_i^2", Dropped, ".mul(&w.mul(&w))", ".mul(&w)"),
        ],
    },
    Source {
        file: "crates/proof/src/statement/system_norm.rs",
        suites: &[FILTERS],
        mutants: &[
            sign("norms: F = A + LC", "\"A\")?.difference("),
            sign("norms: G = E + LD", "\"E\")?.difference("),
            dropped("norms: no H'H", "let first = first.sum(&seen)?;"),
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
        file: "crates/proof/src/statement/linear_system.rs",
        suites: &[SYSTEMS],
        mutants: &[
            sign("linear system: I + GM", ".difference(&g.product(m)?)"),
            mutant("linear system: h", Hypothesis, "h.is_nan() || h >= 1.0", "h.is_nan() || h >= 0.0"),
            mutant(
                "linear system: no |E| y",
                Dropped,
                "x[(i, j)].add(&Interval::new(-bound, bound)",
                "x[(i, j)].add(&Interval::new(0.0, 0.0)",
            ),
            mutant("linear system: y of x", Dropped, "self.weights.scaled(&reach)", "self.weights.clone()"),
        ],
    },
    Source {
        file: "crates/proof/src/statement/reduced_order.rs",
        suites: &[LEFT_INVERSES, FILTERS],
        mutants: &[
            mutant("reduced order: G", WrongOperand, "x[(i, outputs + j)]", "x[(i, j)]"),
            mutant("reduced order: F'", Transpose, "x[(i, outputs + j)]", "x[(j, outputs + i)]"),
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
        file: "crates/proof/src/statement/left_inverse.rs",
        suites: &[LEFT_INVERSES],
        mutants: &[
            mutant("left inverse: D of B", Dropped, "b[(j, i)].mul(&units[i])", "b[(j, i)].clone()"),
            mutant("left inverse: D of S", Dropped, "s[(i, j)].mul(&units[j])", "s[(i, j)].clone()"),
            mutant("left inverse: the error", Dropped, ".map(Exact::enclosure).sum(&error)?", ".map(Exact::enclosure)"),
            mutant(
                "left inverse: the second part",
                Dropped,
                "near = near.sum(",
                "near = Matrix::zeros(near.rows(), near.cols()).sum(",
            ),
        ],
    },
    Source {
        file: "crates/proof/src/statement/unknown_input.rs",
        suites: &[LEFT_INVERSES],
        mutants: &[
            sign("decoupling: T = I + HC", "Matrix::scalar(c.cols(), &Interval::ONE).difference(&measured)"),
            mutant("decoupling: no rate", Dropped, "flow.sum(&Matrix::scalar(n, &rate))?", "flow"),
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
];
