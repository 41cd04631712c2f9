//! `cubic-observer`, `cubic-observer-with-structured-gain` and `cubic-observer-theorem-1`.

use super::{Between, CoqError, Out, points, says};
use crate::certificate::CubicTheorem1;
use crate::certificate::{CubicConvergence, Fact, Region, StructuredCubicConvergence};
use crate::exact::Exact;
use crate::matrix::Matrix;
use crate::number::Number;
use crate::ring::Ring;
use crate::statement::{
    deployed_cubic, largest_eigenvalue_bound, lyapunov_decrease, norm_bound, output_metric, positive,
};

/// The largest number of outputs for which minors of N'N are formed.
pub(super) const MOST_OUTPUTS: usize = 4;

/// `d^2 P~` and `d^2 S~` of the head of `statement/deployed_cubic.rs`, `d = det N'N`, times a power of two: exact
/// matrices with `P~ N = -C'S~`. P and S themselves if they have this structure.
fn exactly_structured(
    p: &Matrix<f64>,
    c: &Matrix<f64>,
    n: &Matrix<f64>,
    s: &Matrix<f64>,
) -> Result<(Matrix<Exact>, Matrix<Exact>), CoqError> {
    let embed = |m: &Matrix<f64>| Matrix::<Exact>::embed(m, "a matrix");
    let (p_exact, c_exact, n_exact, s_exact) = (embed(p)?, embed(c)?, embed(n)?, embed(s)?);
    let output = c_exact.transpose();
    let residual = p_exact.product(&n_exact)?.sum(&output.product(&s_exact)?)?;
    if residual.as_slice().iter().all(Exact::is_zero) {
        return Ok((p_exact, s_exact));
    }
    let Some(x) = output_metric(p, c).filter(|_| n.cols() <= MOST_OUTPUTS) else { return Err(CoqError::StoredGain) };
    let x = embed(&x)?;
    let gram = n_exact.transpose().product(&n_exact)?;
    let d = determinant(&gram);
    let Some(size) = d.magnitude_exponent() else { return Err(CoqError::StoredGain) };
    let outputs = n.cols();
    let adjugate = Matrix::from_fn(outputs, outputs, |i, j| {
        let minor = determinant(&without(&gram, j, i));
        if (i + j) % 2 == 0 { minor } else { minor.neg() }
    });
    // d (I - T), T the projector on the range of N.
    let projector = n_exact.product(&adjugate)?.product(&n_exact.transpose())?;
    let rest = Matrix::scalar(p.rows(), &d).difference(&projector)?;
    let metric = output.product(&x)?.product(&c_exact)?;
    let square = d.mul(&d);
    let moved = rest.product(&p_exact.difference(&metric)?)?.product(&rest)?;
    let scaled = |m: Matrix<Exact>| m.map(|entry| entry.shifted(-2 * size));
    let structured = metric.scaled(&square).sum(&moved)?;
    let accretive = x.product(&c_exact)?.product(&n_exact)?.scaled(&square.neg());
    Ok((scaled(structured), scaled(accretive)))
}

/// Determinant by expansion along the first row.
fn determinant(m: &Matrix<Exact>) -> Exact {
    let mut sum = Exact::power_of_two(0);
    if m.rows() > 0 {
        sum = Exact::zero();
        for j in 0..m.cols() {
            let term = m[(0, j)].mul(&determinant(&without(m, 0, j)));
            sum = if j % 2 == 0 { sum.add(&term) } else { sum.sub(&term) };
        }
    }
    sum
}

/// The matrix without a row and a column.
fn without(m: &Matrix<Exact>, row: usize, column: usize) -> Matrix<Exact> {
    let beyond = |k: usize, left_out: usize| k + usize::from(k >= left_out);
    Matrix::from_fn(m.rows() - 1, m.cols() - 1, |i, j| m[(beyond(i, row), beyond(j, column))].clone())
}

/// The Lyapunov matrix for the stored N, rounded, with what its rounding changes at most.
pub(super) struct StoredGain {
    /// `P_stored`, to nearest.
    pub(super) p: Matrix<f64>,
    /// All eigenvalues of `P_stored` are at least this,
    pub(super) lower: f64,
    /// and at most this.
    pub(super) upper: f64,
    /// By how much a rate of decay of the rounded matrix may be too high.
    pub(super) slower: f64,
}

/// What a loop around the observer needs of its stored gain.
pub(super) enum Stored {
    /// It converges from everywhere, with a Lyapunov matrix of its own.
    Everywhere(StoredGain),
    /// It converges from an ellipsoid, with P: `F'P + PF <= -q I`, `P <= upper I`.
    Within {
        /// q.
        q: f64,
        /// The bound of P.
        upper: f64,
    },
}

/// The names of the numbers of the theorem about an ellipsoid.
pub(super) const REGION: &str = "q lower upper overshoot mu t rho kappa level decay_stored";

/// A gain of the cubic term, and how its theorems are said and proved.
struct Gain<'a> {
    /// The beginning of the names of its theorems.
    name: &'a str,
    /// The end of the names of its numbers.
    suffix: &'a str,
    /// In words.
    what: &'a str,
    /// What is assumed of it.
    quantified: &'a str,
    /// The matrix.
    matrix: &'a str,
    /// The beginning of the proof.
    proof: &'a str,
    /// The matrix and the proof that it dissipates.
    dissipates: &'a str,
}

/// The real gain in words.
pub(super) const REAL_GAIN: &str = "With every real matrix N0 for which P N0 = -C'S, that is with N0 = -P^-1 C'S";

/// The stored gain with the proof that it dissipates.
pub(super) const STORED: &str =
    "_ (structure_dissipates _ _ _ _ _ _ accretive_stored (is_structured_correct _ _ _ _ _ _ structure_stored))";

/// What is assumed of the real gain.
pub(super) fn structured_gain(n: usize, outputs: usize) -> String {
    format!("forall N0 : matrix, has_structure {n} {outputs} C P S N0 ->\n  ")
}

/// What is said of the errors that exist, with this matrix as N.
fn exists_error(n: usize, outputs: usize, gain: &str) -> String {
    format!(
        "exists e : R -> vector,\n  \
         (forall i, (i < {n})%nat -> e 0 i = e0 i) /\\\n  \
         forall T, solution T {n} e (fun t => let y := (C * e t)%vector in\n    \
         (A * e t - L * y + quadratic {outputs} theta y .* apply {outputs} {gain} y)%vector)"
    )
}

impl Out {
    /// The theorem; for a loop around the observer, what it needs if the theorem holds.
    pub(super) fn cubic(
        &mut self,
        theorem: &CubicConvergence,
        facts: &[Fact],
        claimed: &[Number],
    ) -> Result<Option<Stored>, CoqError> {
        let CubicConvergence { plant, l, n: gain, theta, p, s, rate, region } = theorem;
        let [a, b, c] = [points(&plant.a)?, points(&plant.b)?, points(&plant.c)?];
        let [positive, decrease, weight, accretive, _] = facts else { return Ok(None) };
        let (n, outputs) = (a.rows(), c.rows());
        self.plant([&a, &b, &c], l, p)?;
        self.matrix("N", &points(gain)?, "The cubic gain, as stored.");
        self.matrix("theta", &points(theta)?, "The weight of the cubic term.");
        self.matrix("S", &points(s)?, "The matrix of the real gain N0 = -P^-1 C'S.");
        self.float("rate", *rate, "The rate in (12).")?;
        let mut stored = None;
        if facts.iter().all(|fact| fact.verdict.is_proved()) {
            let between = Between::of(p, positive)?;
            self.between(&between, "")?;
            self.decay(*rate, decrease, between.upper)?;
            match *region {
                Region::Everywhere => stored = Some(Stored::Everywhere(self.stored(theorem)?)),
                Region::Within(level) => {
                    let q = self.region(theorem, [decrease, accretive], between.upper, level)?;
                    stored = Some(Stored::Within { q, upper: between.upper });
                }
            }
        }
        self.positive(n, "P", positive, claimed.first())?;
        self.decrease((n, outputs), decrease, claimed.get(1), "")?;
        self.semidefinite(outputs, weight, claimed.get(2), "theta")?;
        self.semidefinite(outputs, accretive, claimed.get(3), "S")?;
        if facts.iter().any(|fact| !fact.verdict.is_proved()) {
            return Ok(None);
        }
        self.lemma("decided", &format!("cubic_decays {n} {outputs} A C L P theta decay lower upper overshoot"));
        self.lemma("accretive_S", &format!("is_accretive {outputs} S"));
        self.real_gain_exists(n, outputs);
        self.observed(
            n,
            outputs,
            &Gain {
                name: "real_gain",
                suffix: "",
                what: REAL_GAIN,
                quantified: &structured_gain(n, outputs),
                matrix: "N0",
                proof: "intros N0 structure. ",
                dissipates: "N0 (structure_dissipates _ _ _ _ _ _ accretive_S structure)",
            },
        );
        if let Some(Stored::Within { .. }) = stored {
            self.over_region(n, outputs);
            return Ok(stored);
        }
        self.lemma(
            "decided_stored",
            &format!(
                "cubic_decays {n} {outputs} A C L P_stored theta decay_stored lower_stored upper_stored overshoot_stored"
            ),
        );
        self.lemma("accretive_stored", &format!("is_accretive {outputs} S_stored"));
        self.lemma("structure_stored", &format!("is_structured {n} {outputs} C P_stored S_stored N"));
        self.observed(
            n,
            outputs,
            &Gain {
                name: "stored_gain",
                suffix: "_stored",
                what: "With the gains L and N exactly as stored",
                quantified: "",
                matrix: "(real N)",
                proof: "",
                dissipates: STORED,
            },
        );
        Ok(stored)
    }

    /// The numbers of the theorem about the stored gain from an ellipsoid, those of the head of
    /// `statement/deployed_cubic.rs`; q.
    fn region(
        &mut self,
        theorem: &CubicConvergence,
        [decrease, accretive]: [&Fact; 2],
        upper: f64,
        level: f64,
    ) -> Result<f64, CoqError> {
        let CubicConvergence { plant, l, n, theta, p, s, .. } = theorem;
        let deployed = deployed_cubic(&plant.a, l, &plant.c, p, n, s, theta)?;
        let q = deployed.decrease.margin().unwrap_or(0.0);
        let mu = deployed.accretive.margin().unwrap_or(0.0);
        let decay = (q / (2.0 * upper)).next_down();
        for (number, fact) in [(decay, decrease), (mu, accretive)] {
            if number.is_nan() || number <= 0.0 {
                return Err(CoqError::NoMargin { inequality: fact.inequality.clone() });
            }
        }
        let kappa = norm_bound(&Matrix::embed(&plant.c, "C")?);
        self.float("level", level, "The stored gain converges from the errors with e'Pe below this.")?;
        self.float("q", q, "F'P + PF is at most -q I.")?;
        self.float("mu", mu, "S + S' is at least mu I.")?;
        self.float("t", largest_eigenvalue_bound(theta), "theta is at most t I.")?;
        self.float("rho", deployed.residual, "The norm of P N + C'S is at most this.")?;
        self.float("kappa", kappa, "The norm of C is at most this.")?;
        self.float("decay_stored", decay, "V falls at least like exp(-2 decay_stored t) from small errors.")?;
        Ok(q)
    }

    /// The theorem about the stored gain from an ellipsoid.
    fn over_region(&mut self, n: usize, outputs: usize) {
        self.lemma("decided_region", &format!("region_decays {n} {outputs} A C L N P theta S {REGION}"));
        self.theorem(
            "stored_gain_every_error",
            "With the gains L and N exactly as stored, every differentiable e with e' = (A - L C)e + (y'theta y) N y, y = C e,\n    \
             from V(0) = e(0)'P e(0) below the level: V decays at a rate that V(0) reduces.",
            &format!(
                "forall (T : R) (e : R -> vector),\n  \
                 solution T {n} e (fun t => let y := (C * e t)%vector in\n    \
                 (A * e t - L * y + quadratic {outputs} theta y .* apply {outputs} (real N) y)%vector) ->\n  \
                 quadratic {n} P (e 0) < level ->\n  \
                 let a := decay_stored * (1 - quadratic {n} P (e 0) / level) in\n  \
                 0 < a\n  \
                 /\\ (forall s t, 0 <= s -> s <= t -> t < T ->\n    \
                 quadratic {n} P (e t) <= exp (- (2 * a) * (t - s)) * quadratic {n} P (e s))\n  \
                 /\\ (forall t, 0 <= t -> t < T -> norm {n} (e t) <= overshoot * exp (- a * t) * norm {n} (e 0))"
            ),
            "exact (region_error_decays _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ decided_region).",
        );
        self.theorem(
            "stored_gain_errors_exist",
            "With the gains as stored, from every e(0) below the level there is such an e, for all times.",
            &format!("forall e0 : vector, quadratic {n} P e0 < level -> {}", exists_error(n, outputs, "(real N)")),
            "exact (region_errors_exist _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ decided_region).",
        );
    }

    /// That there is a real gain N0.
    fn real_gain_exists(&mut self, n: usize, outputs: usize) {
        self.theorem(
            "real_gain_exists",
            "There is a real matrix N0 with P N0 = -C'S.",
            &format!("exists N0 : matrix, has_structure {n} {outputs} C P S N0"),
            &format!("apply (structured_gain_exists {n} {outputs} C P S margin_P). vm_cast_no_check (eq_refl true)."),
        );
    }

    /// The theorems about trajectories, for one gain.
    fn observed(&mut self, n: usize, outputs: usize, gain: &Gain<'_>) {
        let Gain { name, suffix, what, quantified, matrix: gain, proof: intros, dissipates } = *gain;
        let says = says(n, suffix);
        let proof = |result: &str, more: &str| {
            format!("{intros}exact ({result} _ _ _ _ _ _ _ _ _ _ _ decided{suffix} {dissipates}{more}).")
        };
        self.theorem(
            &format!("{name}_every_error"),
            &format!("{what}: every differentiable e with e' = (A - L C)e + (y'theta y) N y, y = C e."),
            &format!(
                "{quantified}forall (T : R) (e : R -> vector),\n  \
                 solution T {n} e (fun t => let y := (C * e t)%vector in\n    \
                 (A * e t - L * y + quadratic {outputs} theta y .* apply {outputs} {gain} y)%vector) ->\n  {says}"
            ),
            &proof("cubic_error_decays", ""),
        );
        self.theorem(
            &format!("{name}_observer"),
            &format!(
                "{what}: the error of plant x' = A x + B u, y = C x and observer\n    \
                 xhat' = A xhat + B u + L r - (r'theta r) N r, r = y - C xhat, for every input u."
            ),
            &format!(
                "{quantified}forall (T : R) (u x xhat : R -> vector),\n  \
                 solution T {n} x (fun t => A * x t + B * u t)%vector ->\n  \
                 solution T {n} xhat (fun t => let r := (C * x t - C * xhat t)%vector in\n    \
                 (A * xhat t + B * u t + L * r - quadratic {outputs} theta r .* apply {outputs} {gain} r)%vector) ->\n  \
                 let e t := (x t - xhat t)%vector in\n  {says}"
            ),
            &proof("cubic_observer_decays", " B"),
        );
        self.theorem(
            &format!("{name}_errors_exist"),
            &format!("{what}: from every e(0) there is such an e, for all times."),
            &format!("{quantified}forall e0 : vector, {}", exists_error(n, outputs, gain)),
            &format!(
                "{intros}refine (cubic_errors_exist _ _ _ _ _ _ _ _ _ _ _ decided{suffix} _ {dissipates}).\n  \
                 vm_cast_no_check (eq_refl true)."
            ),
        );
    }

    pub(super) fn structured(
        &mut self,
        theorem: &StructuredCubicConvergence,
        facts: &[Fact],
        claimed: &[Number],
    ) -> Result<(), CoqError> {
        let StructuredCubicConvergence { plant, l, theta, p, s, rate } = theorem;
        let [a, b, c] = [points(&plant.a)?, points(&plant.b)?, points(&plant.c)?];
        let [positive, decrease, weight, dissipation] = facts else { return Ok(()) };
        let (n, outputs) = (a.rows(), c.rows());
        self.plant([&a, &b, &c], l, p)?;
        self.matrix("theta", &points(theta)?, "The weight of the cubic term.");
        self.matrix("S", &points(s)?, "The matrix of the real gain N0 = -P^-1 C'S.");
        self.float("rate", *rate, "The rate in (12).")?;
        let all = facts.iter().all(|fact| fact.verdict.is_proved());
        if all {
            let between = Between::of(p, positive)?;
            self.between(&between, "")?;
            self.decay(*rate, decrease, between.upper)?;
        }
        self.positive(n, "P", positive, claimed.first())?;
        self.decrease((n, outputs), decrease, claimed.get(1), "")?;
        self.semidefinite(outputs, weight, claimed.get(2), "theta")?;
        let form = format!("2 * quadratic {outputs} S y");
        if dissipation.verdict.is_proved() {
            let zero = Number::from(Exact::zero());
            self.number(
                "margin_S",
                claimed.get(3).unwrap_or(&zero),
                &format!("The margin of {}.", dissipation.inequality),
            );
            self.theorem(
                "inequality_13",
                "-v'(P N0 C + C'N0'P)v is 2 y'S y, y = C v: at least the margin times |y|^2.",
                &format!("forall v : vector, let y := (C * v)%vector in margin_S * square {outputs} y <= {form}"),
                &format!("apply (accretive_on_outputs {n} {outputs} C S margin_S). vm_cast_no_check (eq_refl true)."),
            );
        } else if positive.verdict.is_proved() && self.witness("v_S", dissipation)? {
            self.theorem(
                "inequality_13_is_false",
                "-v'(P N0 C + C'N0'P)v = 2 y'S y, y = C v, is negative for some v.",
                &format!("exists v : vector, let y := (C * v)%vector in {form} < 0"),
                &format!("apply (not_accretive_on_outputs {n} {outputs} C S v_S). vm_cast_no_check (eq_refl true)."),
            );
        }
        if !all {
            return Ok(());
        }
        self.lemma("decided", &format!("cubic_decays {n} {outputs} A C L P theta decay lower upper overshoot"));
        self.lemma("accretive_S", &format!("has_accretive_outputs {n} {outputs} C S margin_S"));
        self.real_gain_exists(n, outputs);
        self.observed(
            n,
            outputs,
            &Gain {
                name: "real_gain",
                suffix: "",
                what: REAL_GAIN,
                quantified: &structured_gain(n, outputs),
                matrix: "N0",
                proof: "intros N0 structure. ",
                dissipates: "N0 (structure_on_outputs_dissipates _ _ _ _ _ _ _ accretive_S structure)",
            },
        );
        Ok(())
    }

    pub(super) fn theorem1(
        &mut self,
        theorem: &CubicTheorem1,
        facts: &[Fact],
        claimed: &[Number],
    ) -> Result<(), CoqError> {
        let CubicTheorem1 { plant, l, n: gain, theta, p } = theorem;
        let [a, b, c] = [points(&plant.a)?, points(&plant.b)?, points(&plant.c)?];
        let [positive, decrease, weight, dissipation] = facts else { return Ok(()) };
        let (n, outputs) = (a.rows(), c.rows());
        self.plant([&a, &b, &c], l, p)?;
        self.matrix("N", &points(gain)?, "The cubic gain, as stored.");
        self.matrix("theta", &points(theta)?, "The weight of the cubic term.");
        self.float("rate", 0.0, "The rate in (12): none.")?;
        let all = facts.iter().all(|fact| fact.verdict.is_proved());
        if all {
            let between = Between::of(p, positive)?;
            self.between(&between, "")?;
            self.decay(0.0, decrease, between.upper)?;
        }
        self.positive(n, "P", positive, claimed.first())?;
        self.decrease((n, outputs), decrease, claimed.get(1), "")?;
        self.semidefinite(outputs, weight, claimed.get(2), "theta")?;
        let (d, form) = (
            "let d := (N * (C * v))%vector in\n  ",
            format!("inner {n} v (P * d)%vector + inner {n} d (P * v)%vector"),
        );
        if dissipation.verdict.is_proved() {
            let zero = Number::from(Exact::zero());
            self.number(
                "margin_13",
                claimed.get(3).unwrap_or(&zero),
                &format!("The margin of {}.", dissipation.inequality),
            );
            self.theorem(
                "inequality_13",
                "v'(P N C + C'N'P)v is at most minus the margin times |v|^2: (13').",
                &format!("forall v : vector, {d}{form} <= - margin_13 * square {n} v"),
                &format!("apply (dissipation {n} {outputs} C P N margin_13). vm_cast_no_check (eq_refl true)."),
            );
        } else if self.witness("v_13", dissipation)? {
            self.theorem(
                "inequality_13_is_false",
                "(13') is false: v'(P N C + C'N'P)v is positive for some v.",
                &format!("exists v : vector, {d}0 < {form}"),
                &format!("apply (not_dissipative {n} {outputs} C P N v_13). vm_cast_no_check (eq_refl true)."),
            );
        }
        if !all {
            return Ok(());
        }
        self.lemma("decided", &format!("cubic_decays {n} {outputs} A C L P theta decay lower upper overshoot"));
        self.lemma("dissipates_N", &format!("is_stored_dissipative {n} {outputs} C P N margin_13"));
        self.observed(
            n,
            outputs,
            &Gain {
                name: "stored_gain",
                suffix: "",
                what: "With the gains L and N exactly as stored",
                quantified: "",
                matrix: "(real N)",
                proof: "",
                dissipates: "_ (stored_dissipates _ _ _ _ _ _ dissipates_N)",
            },
        );
        Ok(())
    }

    /// `theta >= 0`, or `S + S' >= 0`, proved or refuted.
    pub(super) fn semidefinite(
        &mut self,
        p: usize,
        fact: &Fact,
        claimed: Option<&Number>,
        name: &str,
    ) -> Result<(), CoqError> {
        let (margin, vector) = (format!("margin_{name}"), format!("v_{name}"));
        let (form, positive, negative, form_name) = if name == "S" {
            ("2 * quadratic", "accretive", "not_accretive", "v'(S + S')v")
        } else {
            ("quadratic", "is_at_least_correct", "not_positive_semidefinite", "v'theta v")
        };
        if fact.verdict.is_proved() {
            let zero = Number::from(Exact::zero());
            self.number(&margin, claimed.unwrap_or(&zero), &format!("The margin of {}.", fact.inequality));
            let what = format!("{}: {form_name} is at least the margin times |v|^2.", fact.inequality);
            let statement = format!("forall v : vector, {margin} * square {p} v <= {form} {p} {name} v");
            let proof = format!("apply ({positive} {p} {name} {margin}). vm_cast_no_check (eq_refl true).");
            self.theorem(&format!("{name}_is_positive_semidefinite"), &what, &statement, &proof);
        } else if self.witness(&vector, fact)? {
            let statement = format!("exists v : vector, {form} {p} {name} v < 0");
            let proof = format!("apply ({negative} {p} {name} {vector}). vm_cast_no_check (eq_refl true).");
            let what = format!("{} is false.", fact.inequality);
            self.theorem(&format!("{name}_is_not_positive_semidefinite"), &what, &statement, &proof);
        }
        Ok(())
    }

    /// A Lyapunov matrix for which the stored N has the structure exactly, with its numbers.
    fn stored(&mut self, theorem: &CubicConvergence) -> Result<StoredGain, CoqError> {
        let CubicConvergence { plant, l, n, p, s, .. } = theorem;
        let (exact_p, exact_s) = exactly_structured(p, &plant.c, n, s)?;
        let nearest = exact_p.map(|entry| f64::midpoint(entry.round_down(), entry.round_up()));
        // The margins of the rounded matrix are reduced by more than what its rounding can change.
        let (order, upper) = (p.rows(), largest_eigenvalue_bound(&nearest) * (1.0 + 1e-9));
        let largest = |m: &Matrix<f64>| m.as_slice().iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        let flow = largest(&plant.a) + order as f64 * largest(l) * largest(&plant.c);
        let rounding = 1e-14 * order as f64 * upper;
        let lower = positive(&nearest)?.margin().unwrap_or(0.0) - rounding;
        let falls = lyapunov_decrease(&plant.a, l, &plant.c, &nearest)?.margin().unwrap_or(0.0);
        let decay = (falls - 2.0 * rounding * order as f64 * flow) / (2.0 * upper) * (1.0 - 1e-9);
        if !(lower > 0.0 && decay > 0.0 && upper.is_finite()) {
            return Err(CoqError::StoredGain);
        }
        let what = "The matrix of the function V for the gains as stored: near P, up to a factor.";
        self.matrix("P_stored", &exact_p.map(|entry| Number::from(entry.clone())), what);
        let what = "P_stored N = -C' S_stored, exactly.";
        self.matrix("S_stored", &exact_s.map(|entry| Number::from(entry.clone())), what);
        let overshoot = (upper / lower).sqrt() * (1.0 + 1e-9);
        self.between(&Between { lower, upper, overshoot }, "_stored")?;
        self.float("decay_stored", decay, "V falls at least like exp(-2 decay_stored t) with the gains as stored.")?;
        // |F'E + EF| <= 2 |F| |E| for the rounding E of P.
        let slower = 2.0 * rounding * order as f64 * flow / lower;
        Ok(StoredGain { p: nearest, lower, upper, slower })
    }
}
