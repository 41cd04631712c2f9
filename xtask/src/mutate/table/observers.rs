//! Mutants of the observers.

use super::Kind::{Constant, Dropped, Hypothesis, OffDiagonal, Sign, Transpose, WrongOperand};
use super::{
    CUBIC, INPUT_TO_STATE, INTERVAL, KKL, MEAN_VALUE, OBSERVERS, RECORDINGS, SAMPLED, SLIDING, Source, dropped, mutant,
    sign,
};

pub(super) const SOURCES: &[Source] = &[
    Source {
        file: "crates/observers/src/linear.rs",
        suites: &[OBSERVERS, CUBIC],
        mutants: &[
            sign("linear observer: - B u", "+ entry(&self.b, i, u)"),
            sign("linear observer: - L y~", "+ entry(&self.l, i, innovation)"),
        ],
    },
    Source {
        file: "crates/observers/src/cubic.rs",
        suites: &[OBSERVERS, CUBIC],
        mutants: &[
            sign("cubic observer: + N y~ (y~'theta y~)", "- entry(&self.n, i, cubic)"),
            sign("cubic observer: - L y~", "+ entry(&self.l, i, innovation)"),
            dropped("cubic observer: no B u", " + entry(&self.b, i, u)"),
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
            mutant("cubic flow: 1 + reach", Dropped, "(one + near * near).sqrt()", "(one + near).sqrt()"),
            mutant(
                "cubic flow: impulse of Euler's step",
                Dropped,
                "choose(is_near, one + hypot, root)",
                "choose(is_near, two, root)",
            ),
            mutant(
                "cubic flow: impulse of a far start doubled",
                Constant,
                "choose(is_near, one + hypot, root)",
                "choose(is_near, one + hypot, root / two)",
            ),
            mutant("cubic flow: a negative weight flows back", Hypothesis, "let q = larger(q, zero);", ""),
            mutant(
                "sampled observer: Ld y~ without r",
                Dropped,
                "choose(|| size <= zero, before, along * left)",
                "choose(|| size <= zero, before, along * size)",
            ),
            mutant("rate of a radial gain: + trace(C N)/p", Sign, "-trace / count", "trace / count"),
            mutant("rate of a radial gain: - trace(C N)", Dropped, "-trace / count(c.nrows())", "-trace"),
        ],
    },
    Source {
        file: "crates/observers/src/cubic_sampled.rs",
        suites: &[OBSERVERS, CUBIC],
        mutants: &[
            sign("sampled observer: + N impulse", "*xhat -= entry(n"),
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
            mutant("semi-implicit step: no h", Dropped, ", zero) * t * size * size", ", zero) * size * size"),
            mutant("semi-implicit step: s of |y~|", Dropped, "* t * size * size", "* t * size"),
            sign("semi-implicit step: I - s G", "{ one + entry } else"),
            mutant("semi-implicit step: impulse r", Dropped, "solution * s, zero", "solution, zero"),
            mutant(
                "semi-implicit step: the diagonal of G",
                OffDiagonal,
                "{ one + entry } else { entry }",
                "{ one + entry } else { zero }",
            ),
            mutant(
                "semi-implicit step: explicit innovation",
                Dropped,
                "*innovation = choose(|| solved > zero, solution, before);",
                "*innovation = choose(|| solved > zero, before, before);",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/varying_period.rs",
        suites: &[SAMPLED],
        mutants: &[
            mutant("prediction: no input", Dropped, "slope + entry(&self.b, i, u))", "slope)"),
            mutant("prediction: no factorial", Dropped, "slope * tau / degree", "slope * tau"),
            sign("correction: - K r", "+ entry(&self.k, i, innovation)"),
            sign("correction: + N i", "- entry(n, i, impulse)"),
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
            sign("semidefinite: the rest plus its pivot's part", "- factor * at(&rest, k, j)"),
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
            mutant("sampled observer: no Bd u", Dropped, "moved + entry(b, i, u)", "moved"),
            sign("sampled observer: - L y~", "+ entry(l, i, z)"),
        ],
    },
    Source {
        file: "crates/observers/src/runge_kutta.rs",
        suites: &[OBSERVERS],
        mutants: &[
            mutant(
                "Runge-Kutta: the third stage from the first",
                WrongOperand,
                "let (k3, w3) = slope(t + middle, &(&*x + &k2 * middle), &(&*w + &w2 * middle));",
                "let (k3, w3) = slope(t + middle, &(&*x + &k1 * middle), &(&*w + &w2 * middle));",
            ),
            mutant("Runge-Kutta: the fourth stage half a step", Constant, "&w3 * tau", "&w3 * middle"),
            mutant("Runge-Kutta: the weights of the middle stages", Constant, "(w2 + w3) * two", "(w2 + w3)"),
        ],
    },
    Source {
        file: "crates/observers/src/gaussian.rs",
        suites: &[OBSERVERS],
        mutants: &[
            mutant("Kalman: S = H P H'", Dropped, "times_transpose(&hp, h) + v", "times_transpose(&hp, h)"),
            sign("Kalman: xhat - K y~", "let xhat = xbar + times(&gain"),
            sign("Kalman: I + K H", "order) - times(&gain.k, &h)"),
            dropped("Kalman: no K V K'", " + times_transpose(&times(&gain.k, &v), &gain.k)"),
            dropped("Kalman: no H (xbar - x)", "error -= times(&h, &(xbar - x));"),
            mutant(
                "Kalman: linearised at xbar again",
                WrongOperand,
                "of_measured(again(&x))",
                "of_measured(again(xbar))",
            ),
            dropped("Kalman: the gain of the first linearisation", "        gain = Gain::new(&h, p, &v)?;\n"),
            sign("Kalman: x = xbar - K y~", "let x = xbar + times(&gain"),
            mutant(
                "Kalman: (I - K H) P + K V K'",
                Dropped,
                "times_transpose(&times(&keep, p), &keep)",
                "times(&keep, p)",
            ),
            dropped("Kalman: V of a silent output", "v[(i, i)] = T::one();"),
            mutant("Kalman: V correlated with a silent output", OffDiagonal, "v.row_mut(i).fill(T::zero());", ""),
            mutant(
                "Kalman: an estimate that is NaN",
                Dropped,
                "(are_finite(xhat.as_slice()) && are_finite(p.as_slice())).then_some(",
                "are_finite(p.as_slice()).then_some(",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/kalman.rs",
        suites: &[OBSERVERS],
        mutants: &[
            mutant(
                "Kalman: innovations of angles as they are",
                Dropped,
                "(h, angles::difference(&self.turns, y, &expected))",
                "(h, y - expected)",
            ),
            mutant("Kalman: a gate of variances", Dropped, "gate * gate * variance", "gate * variance"),
            mutant(
                "Kalman: a gate that lets NaN pass",
                WrongOperand,
                "innovation * innovation <= gate * gate * variance",
                "!(innovation * innovation > gate * gate * variance)",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/transition.rs",
        suites: &[OBSERVERS],
        mutants: &[
            mutant("prediction: Phi P Phi' without Q", Dropped, "&self.phi) + &self.noise;", "&self.phi);"),
            mutant(
                "prediction: Q without its middle",
                Dropped,
                "((whole + middle * four) + self.w)",
                "(whole + self.w)",
            ),
            mutant(
                "prediction: H by the first half",
                WrongOperand,
                "let a = (f3 + f4) * quarter;",
                "let a = (&f1 + f3) * quarter;",
            ),
            mutant(
                "prediction: steps not divided",
                Dropped,
                "let tau = duration / convert::<f64, T>(count as f64);\n        let mut way = Transition::none(x);\n        for k in 0..count {\n            let ClassicalStep { next, phi, halfway } =\n                self.classical_step(t + tau * convert::<f64, T>(k as f64), tau, &way.next);\n            if !self",
                "let tau = duration;\n        let mut way = Transition::none(x);\n        for k in 0..count {\n            let ClassicalStep { next, phi, halfway } =\n                self.classical_step(t + tau * convert::<f64, T>(k as f64), tau, &way.next);\n            if !self",
            ),
            mutant(
                "prediction: every step accepted",
                Dropped,
                "let is_within = excess <= T::one();",
                "let is_within = true;",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/exponential.rs",
        suites: &[OBSERVERS],
        mutants: &[
            mutant(
                "exponential: growth without its double",
                Dropped,
                "growth + growth + times(growth, growth)",
                "growth + times(growth, growth)",
            ),
            mutant("exponential: noise once", Dropped, "noise: noise + noise + &carried", "noise: noise + &carried"),
            mutant("exponential: F W alone", Dropped, "(product.transpose() + product) / k", "product / k"),
            mutant("exponential: units left out", Dropped, "noise[(i, j)] * scale[i] * scale[j]", "noise[(i, j)]"),
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
                "times_transpose(&times(ad, &estimate.covariance()), ad)",
                "times(&ad.transpose(), &times(&estimate.covariance(), ad))",
            ),
            mutant("discrete Kalman: no Bd u", Dropped, " + bd * u;", ";"),
            sign("discrete Kalman: y + C xhat", "y - c * estimate.estimate()"),
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
            sign("mean value: xhat' = f - G e", "slope[k] += g * e1"),
            sign("mean value: e' = D e + G e", "error_slope[k] -= g * e[k]"),
            mutant("mean value: e1 = xhat - y", Sign, "{ y[k] - xhat[k] } else", "{ xhat[k] - y[k] } else"),
            mutant("mean value: unmeasured rows not corrected", Dropped, "else { e[k] };", "else { T::zero() };"),
            mutant(
                "mean value: measured rows corrected by e",
                WrongOperand,
                "if k < y.nrows() { y[k] - xhat[k] } else { e[k] }",
                "e[k]",
            ),
            sign("injection: G_m left in the error", "error_slope[k] -= g * (e1 - e[k])"),
            sign("injection: - L (y - C xhat - C e)", "error_slope += l * innovation"),
            mutant("injection: innovation y - C xhat", Dropped, "y[k] - xhat[k] - e[k]", "y[k] - xhat[k]"),
            sign("mean value: z = xhat - e", "self.estimate() + self.error()"),
            mutant("mean value: eta > 1", Hypothesis, "eta + eta > T::one()", "eta > T::one()"),
        ],
    },
    Source {
        file: "crates/observers/src/mean_value/integral.rs",
        suites: &[OBSERVERS, MEAN_VALUE],
        mutants: &[
            sign("integral mean: from xhat to xhat - e", "let at = xhat + e * convert"),
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
            sign("KKL: Lambda xi - B", "* xi + self.injection"),
            mutant("linear KKL: no E u", Dropped, "&self.b * y + &self.e * u", "&self.b * y"),
            mutant("linear KKL: E u - B y", Sign, "&self.b * y + &self.e * u", "&self.e * u - &self.b * y"),
        ],
    },
    Source {
        file: "crates/observers/src/parameter_estimation/kkl_peb.rs",
        suites: &[OBSERVERS, KKL],
        mutants: &[
            sign("[KKL+PEB]: phi^L(xi - missing)", "&parts.xi + self.map"),
            sign("[KKL+PEB]: xi(0) = phi + missing", "estimate, y) - self.map.missing"),
            sign("[KKL+PEB]: Y = W[s] + F[g]", "&self.map.signal(t, y)) - parts.known"),
            mutant("[KKL+PEB]: w(0) = 0", Dropped, "xi.iter().chain(signal.iter())", "xi.iter()"),
            mutant("[KKL+PEB]: F[g] filters s", WrongOperand, "&self.map.known(t, xi, u, y)", "&self.map.signal(t, y)"),
            mutant(
                "[KKL+PEB]: theta_hat not held in its domain",
                Hypothesis,
                ".map_or(theta, |bound| larger(theta, bound))",
                ".map_or(theta, |_| theta)",
            ),
            mutant(
                "[KKL+PEB]: projected when it rises",
                Sign,
                "&& rate < T::zero(), T::zero(), rate",
                "&& rate > T::zero(), T::zero(), rate",
            ),
            mutant(
                "[KKL+PEB]: leaves its domain in 1/alpha, other sign",
                Sign,
                "(bound - value) >= rate / self",
                "(bound - value) <= rate / self",
            ),
            sign("reset: xi - missing(theta_hat)", "after[i] += behind[i]"),
            mutant("reset: no missing(theta_0)", Dropped, "behind[i] - ahead[i]", "behind[i]"),
            mutant("reset: F[g] - F[m] delta", Sign, "after[z + r + i] += parts", "after[z + r + i] -= parts"),
            mutant(
                "reset: F[m]' delta",
                Transpose,
                "parts.regressor[(i, j)] * delta[j]",
                "parts.regressor[(j, i)] * delta[j]",
            ),
            mutant("reset: W[s] + F[m] delta", WrongOperand, "after[z + r + i] +=", "after[z + i] +="),
            dropped(
                "reset: the extension of the estimator stays",
                "self.estimator.shift(&mut after.as_mut_slice()[filters..], &delta);",
            ),
            mutant(
                "reset: theta_hat stays",
                WrongOperand,
                "after[filters + j] = first[j]",
                "after[filters + j] = held[j]",
            ),
            mutant(
                "reset: filters restarted with w = 0",
                Dropped,
                "{ signal[i] } else",
                "{ signal[i] * T::zero() } else",
            ),
            mutant("reset: the level of xi, not of |xi|", Sign, "xi.abs() > level", "*xi > level"),
            mutant(
                "reset: the level of the KKL part too",
                Hypothesis,
                "self.map.is_open(i) && xi",
                "(self.map.is_open(i) || i == 0) && xi",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/parameter_estimation/filters.rs",
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
            sign("high gain: y + head", "error[output] -= xi[i]"),
            sign("high gain: b - s alpha/r^j (y - head)", "slope[i] += shape"),
            mutant("high gain: no shape", Dropped, "shape[i] * self.gain[i]", "self.gain[i]"),
        ],
    },
    Source {
        file: "crates/observers/src/sampled_jumps.rs",
        suites: &[OBSERVERS],
        mutants: &[
            mutant("jumps at samples: not counted", Dropped, "samples + T::one()", "samples"),
            mutant(
                "jumps at samples: counted from 0",
                Constant,
                "u, y).as_slice(), T::one())",
                "u, y).as_slice(), T::zero())",
            ),
        ],
    },
    Source {
        file: "crates/expression/src/graph/recording.rs",
        suites: &[RECORDINGS],
        mutants: &[
            mutant("recording: the other branch", WrongOperand, "yes.0, no.0)", "no.0, yes.0)"),
            mutant(
                "recording: a number that is none is the largest",
                Dropped,
                "graph.or(better, none)",
                "graph.or(better, better)",
            ),
        ],
    },
    Source {
        file: "crates/observers/src/parameter_estimation/immersion_invariance.rs",
        suites: &[OBSERVERS, KKL],
        mutants: &[
            sign("I&I: Dphi f + D_y beta Dh f", "&f) - self.map.beta_directional"),
            mutant(
                "I&I: no D_y beta Dh f",
                Dropped,
                "self.map.beta_directional(y, chi, &output_rate, &still)",
                "self.map.beta_directional(y, chi, &output_rate, &still) * T::zero()",
            ),
            sign("I&I: - rho", "wanted += rho"),
            mutant("I&I: Q not projected", Dropped, "(wanted - seen)", "wanted"),
            sign("I&I: I + projector", "(wanted - seen)"),
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
        file: "crates/observers/src/parameter_estimation/estimator/gradient.rs",
        suites: &[OBSERVERS],
        mutants: &[
            sign("gradient: Y + M theta_hat", "y - m * leading"),
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
        file: "crates/observers/src/parameter_estimation/estimator/drem.rs",
        suites: &[OBSERVERS, KKL],
        mutants: &[
            mutant(
                "DREM: no Delta in front",
                Dropped,
                "self.gain[i] * mixed.determinant * (v[i]",
                "self.gain[i] * (v[i]",
            ),
            mutant("DREM: v - theta_hat", Dropped, "v[i] - mixed.determinant * theta", "v[i] - theta"),
            sign("DREM: v + Delta theta_hat", "v[i] - mixed.determinant"),
            mutant("DREM: adj(Phi)'Z", Transpose, "&mixed.adjugate * z", "mixed.adjugate.transpose() * z"),
            mutant("DREM: one gamma for all", OffDiagonal, "self.gain[i] * mixed", "self.gain[0] * mixed"),
            sign("reset of Kreisselmeier's Z: + Phi delta", "state[i] -= moved"),
            mutant(
                "reset of Kreisselmeier's Z: Phi'delta",
                Transpose,
                "state[q + i + q * j] * delta[j]",
                "state[q + j + q * i] * delta[j]",
            ),
            mutant(
                "reset of the filters of DREM: + M delta",
                Sign,
                "state[block + i] -= moved",
                "state[block + i] += moved",
            ),
            sign("Kreisselmeier: + a Phi", "source - state * self.a"),
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
        file: "crates/observers/src/parameter_estimation/estimator/excitation.rs",
        suites: &[OBSERVERS, KKL],
        mutants: &[
            sign("excitation: + mu E", "seen - gram * self.mu"),
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
        file: "crates/observers/src/parameter_estimation/estimator/adjugate.rs",
        suites: &[OBSERVERS],
        mutants: &[
            mutant(
                "adjugate: no sign of the permutation of columns",
                Sign,
                "sign = choose(is_column, -sign, sign);",
                "",
            ),
            mutant("adjugate: + sum/u", Sign, "zero, -sum / pivot", "zero, sum / pivot"),
        ],
    },
    Source {
        file: "crates/observers/src/interval.rs",
        suites: &[INTERVAL],
        mutants: &[
            mutant("interval observer: no g", Dropped, "entry(k, i, rho) + g[i]", "entry(k, i, rho)"),
            sign("interval step: y + C xhat", "*y - entry(&g.c, i, xhat)"),
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
                "(r, choose(|| rest > zero, sign, z / layer))",
                "(r, sign)",
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
];
