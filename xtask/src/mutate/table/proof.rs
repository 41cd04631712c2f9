//! Mutants of the statements that certificates prove.

use super::Kind::{Constant, Dropped, Hypothesis, OffDiagonal, Sign, Transpose, WrongOperand};
use super::{
    DEPLOYED, FILTERS, INPUT_TO_STATE, INTERVAL, KKL_BOUND, LABELS, LEFT_INVERSES, SYSTEMS, Source, TIMES, dropped,
    mutant, sign,
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
        file: "crates/proof/src/label/evaluate.rs",
        suites: &[LABELS],
        mutants: &[
            sign("labels: X + Y for X - Y", "if is_subtracted { x.difference(y) }"),
            mutant(
                "labels: no transpose",
                Transpose,
                "Term::Matrix(m) => Term::Matrix(m.transpose()),",
                "Term::Matrix(m) => Term::Matrix(m),",
            ),
            mutant(
                "labels: the block opposite as it is",
                Transpose,
                "Ok(Term::Matrix(m.transpose()))",
                "Ok(Term::Matrix(m.clone()))",
            ),
            mutant("labels: a number for its square", Dropped, "Term::Number(x.mul(&x))", "Term::Number(x)"),
            mutant(
                "labels: no shift by the rate",
                Dropped,
                "flow.sum(&Matrix::scalar(flow.rows(), number))?",
                "flow.difference(&Matrix::scalar(flow.rows(), &number.sub(number)))?",
            ),
            mutant(
                "labels: P'XP for X'PX",
                WrongOperand,
                "self.matrix(x)?.congruence(&self.matrix(p)?)",
                "self.matrix(p)?.congruence(&self.matrix(x)?)",
            ),
            mutant(
                "labels: factors in the other order",
                WrongOperand,
                "self.matrix(factor)?.product(&product)",
                "product.product(&self.matrix(factor)?)",
            ),
            dropped("labels: a coefficient without its 2", "coefficient = coefficient.add(&coefficient);"),
            dropped("labels: a matrix without its 2", "m = m.sum(&m)?;"),
            mutant(
                "labels: AX for A(wI + X)",
                Dropped,
                "&Matrix::scalar(x.rows(), &w).sum(&x)?",
                "&x.sum(&Matrix::scalar(x.rows(), &w.sub(&w)))?",
            ),
        ],
    },
    Source {
        file: "crates/proof/src/label/parse.rs",
        suites: &[LABELS],
        mutants: &[
            mutant(
                "labels: the larger side",
                WrongOperand,
                "if smaller { (right, left) } else { (left, right) }",
                "if smaller { (left, right) } else { (right, left) }",
            ),
            mutant("labels: a half", Constant, "Formula::Number(0.5)", "Formula::Number(0.25)"),
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
        file: "crates/proof/src/certificate/theorem/input_to_state.rs",
        suites: &[INPUT_TO_STATE],
        mutants: &[
            mutant("cubic part: 26/128", Constant, "number(27.0)?", "number(26.0)?"),
            mutant("cubic part: s^2", Dropped, ".mul(&square.mul(&square))", ".mul(&square)"),
            mutant("level: W_i for W_i^2", Dropped, ".mul(&w.mul(&w))", ".mul(&w)"),
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
        file: "crates/proof/src/certificate/theorem/reduced_order.rs",
        suites: &[LEFT_INVERSES, FILTERS],
        mutants: &[
            mutant("reduced order: G", WrongOperand, "x[(i, outputs + j)]", "x[(i, j)]"),
            mutant("reduced order: F'", Transpose, "x[(i, outputs + j)]", "x[(j, outputs + i)]"),
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
        file: "crates/proof/src/certificate/theorem/unknown_input.rs",
        suites: &[LEFT_INVERSES],
        mutants: &[sign("decoupling: T = I + HC", "Matrix::scalar(c.cols(), &Interval::ONE).difference(&measured)")],
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
];
