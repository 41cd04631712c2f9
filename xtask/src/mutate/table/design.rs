//! Mutants of the designs.

use super::Kind::{Constant, Dropped, Hypothesis, OffDiagonal, Sign, Transpose, WrongOperand};
use super::{
    CUBIC, DESIGNS, FILTERS, INPUT_TO_STATE, INTERVAL, OPTIMAL, POSITIVE_REAL, SAMPLED, SLIDING, Source, UNCERTAIN,
    mutant, sign,
};

pub(super) const SOURCES: &[Source] = &[
    Source {
        file: "crates/design/src/uncertain.rs",
        suites: &[UNCERTAIN],
        mutants: &[
            mutant(
                "sampled deviation: rounding only",
                Dropped,
                "with[(i, j)].sub(&without[(i, j)]).add(&rounding).hi().max(0.0)",
                "with[(i, j)].sub(&with[(i, j)]).add(&rounding).hi().max(0.0)",
            ),
            mutant("sampled deviation: signs of the vertices", Dropped, "most.max(entry.abs())", "most.max(entry)"),
            mutant(
                "sampled deviation: A for |A|",
                WrongOperand,
                "let (a, b) = (plant.a.abs(), plant.b.abs());",
                "let (a, b) = (-plant.a.abs(), plant.b.abs());",
            ),
            mutant("norm-bounded: signs of H", Dropped, "(h.abs() * DVector", "(h * DVector"),
        ],
    },
    Source {
        file: "crates/design/src/optimal_cubic/cost.rs",
        suites: &[OPTIMAL],
        mutants: &[
            mutant("cost: the sum over the first errors", Dropped, "tail.trace() / n as f64", "tail.trace()"),
            mutant("cost: process noise of intensity W", Dropped, "(&self.process / self.period)", "(&self.process)"),
            mutant("linear optimum: no mean", Dropped, "shares / (n as f64 * self.horizon)", "shares / self.horizon"),
        ],
    },
    Source {
        file: "crates/design/src/optimal_cubic/flow.rs",
        suites: &[OPTIMAL],
        mutants: &[
            mutant("error flow: linear in r", Dropped, "q[lane] * cubic[lane]", "cubic[lane]"),
            mutant("error flow: no rest", Dropped, "sum[lane] + rest[lane]", "sum[lane]"),
            mutant(
                "error flow: over where r passes 0",
                Hypothesis,
                "self.output_gain * ahead[lane] <= 1e-3",
                "stiffness[lane] <= 1e-3",
            ),
        ],
    },
    Source {
        file: "crates/design/src/varying_periods.rs",
        suites: &[SAMPLED],
        mutants: &[
            sign("varying periods: I + K C", "- &k * o.c() }"),
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
            sign("cubic design: F = A + L C", "&self.observer.a - self.l()"),
        ],
    },
    Source {
        file: "crates/design/src/norm_filter/programs.rs",
        suites: &[FILTERS],
        mutants: &[
            sign("filters: YC", "&p * &plant.a - &y * &plant.c"),
            sign("filters: YD", "&p * &of.e - &y * &of.d"),
            mutant("H-infinity design: no H'H", Dropped, "block![[he(flow) + seen, driven", "block![[he(flow), driven"),
        ],
    },
    Source {
        file: "crates/design/src/interval/gain.rs",
        suites: &[INTERVAL],
        mutants: &[
            mutant("least width: no bounds W", Dropped, "let term = bounds[j] * &bound;", "let term = 1.0 * &bound;"),
            sign("least width: E + LD", "&weight * e - &y * d"),
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
            sign("reaching time: against d", "(k - d * e.signum())"),
        ],
    },
    Source {
        file: "crates/design/src/unknown_input.rs",
        suites: &[INPUT_TO_STATE],
        mutants: &[
            sign("unknown input: T = I + HC", "DMatrix::identity(n, n) - &h * &of.c"),
            mutant(
                "unknown input: H = E (CE)'",
                Dropped,
                "e * check::solve_definite(\"(CE)'CE\", &gram, &image.transpose())?",
                "e * image.transpose()",
            ),
            mutant("unknown input: any zeros", Hypothesis, "excess(zero) >= 0.0)", "excess(zero) >= f64::INFINITY)"),
            sign("unknown input of the outputs: J = L - G", "l + both.columns(p, p)"),
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
            mutant("extended state: d' = -d_rate", Sign, "if later == q => 1.0", "if later == q => -1.0"),
            mutant(
                "proportional-integral: no rank condition",
                Hypothesis,
                "has_full_column_rank(&check::exactly(&system)?.difference(&identity)?)? == Some(false)",
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
            sign("error bound: G = E + LD", "(e - &self.l * &self.d)"),
            mutant(
                "error bound: sqrt(U) (P^-1)_kk",
                Dropped,
                "(level * z[(k, k)]).sqrt() * UP",
                "level.sqrt() * z[(k, k)] * UP",
            ),
            mutant("error bound: 2 alpha dropped", Constant, "/ (2.0 * rate) * UP", "/ rate * UP"),
        ],
    },
    Source {
        file: "crates/design/src/feedback.rs",
        suites: &[DESIGNS, CUBIC],
        mutants: &[
            mutant("Theorem 6: A + B K", Sign, "(a, b, k))?", "(a, &-b, k))?"),
            mutant("Theorem 6: four times the mu", Constant, "0.5 * lambda_min(q)?", "2.0 * lambda_min(q)?"),
            mutant("Theorem 6: no lambda_min(Q) in mu", Dropped, "0.5 * lambda_min(q)?", "0.5"),
            mutant("Theorem 6: P1 = P0", Dropped, "let p1 = p0 * mu", "let p1 = p0"),
            mutant("Theorem 6: |B K| in the place of |P0 B K|", Dropped, "&p0 * b * k", "b * k"),
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
            sign("gain by LMI: + Y C", "&*p * a - &*y * c"),
            mutant("gain by LMI: rate P in the place of 2 rate P", Constant, "(2.0 * rate)", "rate"),
            sign("gain by LMI: - 2 rate P", ") + (2.0 * rate)"),
            mutant(
                "gain by LMI: L = Y",
                Dropped,
                "let l = check::solve_definite(\"P\", &p, &value(\"Y\"))?",
                "let l = value(\"Y\")",
            ),
        ],
    },
    Source {
        file: "crates/design/src/discrete.rs",
        suites: &[DESIGNS, CUBIC],
        mutants: &[mutant("sampled design: z = h s", WrongOperand, "(s * h).exp()", "s * h")],
    },
    Source {
        file: "crates/design/src/sampled.rs",
        suites: &[DESIGNS, CUBIC],
        mutants: &[
            sign("sampled design: Fd = Ad + Ld C", "&ad - &ld * &c"),
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
            sign("(9): F = A + L C", "let f = a - l * c;"),
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
                "let half = p * f;\n    -(&half + half.transpose())",
                "let half = p * f;\n    -(&half + &half)",
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
            sign("fixed gain: - 2 eps P", "he(half) + (2.0"),
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
            sign("fixed gain: P = C'G C - T'Y T", "p += self.t"),
            sign("fixed gain: A + L C", "- &p * self.l * c"),
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
        suites: &[DESIGNS, POSITIVE_REAL],
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
            sign("positive real: companion of the other sign", "subdiagonal - polynomial[i]"),
            mutant(
                "positive real: the leading coefficient not asked",
                Hypothesis,
                "q.last().is_none_or(|&leading| leading <= 0.0)",
                "q.is_empty()",
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
