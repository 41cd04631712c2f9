//! `deployed-observer`: the stored numbers in exact arithmetic, and the error of the running observer, whose steps
//! differ from the exact ones by no more than a bound.
//!
//! That the steps of the target keep this bound is shown by `docs/theory-deployed.md` on paper. It is a hypothesis of
//! the theorem in Coq, with its numbers.

use std::fmt::Write as _;

use super::discrete::{contraction, falls};
use super::{Between, CoqError, Out, points};
use crate::certificate::{DeployedObserver, Fact};
use crate::matrix::Matrix;
use crate::number::Number;
use crate::statement::{RunningBound, Step};

impl Out {
    pub(super) fn deployed(
        &mut self,
        theorem: &DeployedObserver,
        facts: &[Fact],
        claimed: &[Number],
    ) -> Result<(), CoqError> {
        let DeployedObserver { stored, step, p, .. } = theorem;
        let [nearest, positive, decrease, more @ ..] = facts else { return Ok(()) };
        // The other facts are about the numbers nearest to the plant's.
        if !nearest.verdict.is_proved() {
            return Ok(());
        }
        let (n, outputs) = (stored.a.rows(), stored.c.rows());
        let is_joined = *step == Step::Joined && stored.cubic.is_none();
        if is_joined {
            self.matrix("F", &points(&stored.a)?, "The matrix F of the step, as stored.");
        } else {
            self.matrix("A", &points(&stored.a)?, "The state matrix, as stored.");
            self.matrix("C", &points(&stored.c)?, "The output matrix, as stored.");
            self.matrix("L", &points(&stored.l)?, "The gain, as stored.");
        }
        if let Some(cubic) = &stored.cubic {
            self.matrix("N", &points(&cubic.n)?, "The cubic gain, as stored.");
            self.float("w", cubic.w, "The rate of the cubic flow, as stored.")?;
        }
        self.matrix("P", &points(p)?, "The matrix of V = e'Pe.");
        self.float("factor", 1.0, "The factor of the inequality: none.")?;
        let all = facts.iter().all(|fact| fact.verdict.is_proved());
        let running = if all { theorem.running_bound()? } else { None };
        if all {
            let between = Between::of(p, positive)?;
            self.between(&between, "")?;
            let mut exact = contraction(decrease, 1.0, between.upper);
            if let (Some(cubic), Some(end)) = (&stored.cubic, more.first()) {
                exact = exact.max(contraction(end, (cubic.w * cubic.w).next_down(), between.upper));
            }
            self.contraction(running.as_ref().map_or(exact, |running| running.contraction), decrease)?;
        }
        self.positive(n, "P", positive, claimed.get(1))?;
        if is_joined {
            self.of_map(n, decrease, claimed.get(2))?;
        } else {
            self.stein((n, outputs), decrease, claimed.get(2))?;
        }
        if let (true, Some(end)) = (stored.cubic.is_some(), more.first()) {
            self.at_the_end((n, outputs), end, claimed.get(3))?;
        }
        if !all {
            return Ok(());
        }
        let bounds = "contraction lower upper overshoot";
        if is_joined {
            self.lemma("decided", &format!("map_contracts {n} F P {bounds}"));
            self.theorem(
                "every_error",
                "Every e with e(k+1) = F e(k): V = e'Pe and the norm of e decay.",
                &format!("forall e : nat -> vector,\n  recursion {n} e (fun k => F * e k)%vector ->\n  {}", falls(n)),
                "exact (map_error_contracts _ _ _ _ _ _ _ decided).",
            );
        } else if stored.cubic.is_some() {
            self.lemma("decided", &format!("sampled_contracts {n} {outputs} A C L N P w {bounds}"));
            self.exact_cubic(n);
        } else {
            self.lemma("decided", &format!("contracts {n} {outputs} A C L P {bounds}"));
            self.exact_linear(n);
        }
        match running {
            Some(running) => self.running(theorem, (n, outputs), &running),
            None => Ok(()),
        }
    }

    /// `F'PF - P < 0` for the stored F, proved or refuted.
    fn of_map(&mut self, n: usize, decrease: &Fact, claimed: Option<&Number>) -> Result<(), CoqError> {
        let (flow, form) =
            ("let w := (F * v)%vector in\n  ", format!("quadratic {n} P w - factor ^ 2 * quadratic {n} P v"));
        if decrease.verdict.is_proved() {
            self.margin("margin_F", decrease, claimed)?;
            self.theorem(
                "stein_inequality",
                "v'(F'P F - factor^2 P)v is at most minus the margin times |v|^2.",
                &format!("0 < margin_F /\\ forall v : vector, {flow}{form} <= - margin_F * square {n} v"),
                &format!("apply (map_inequality {n} F P factor margin_F). vm_cast_no_check (eq_refl true)."),
            );
        } else if self.witness("v_F", decrease)? {
            self.theorem(
                "stein_inequality_is_false",
                "v'(F'P F - factor^2 P)v < 0 is false.",
                &format!("exists v : vector, 0 < square {n} v /\\\n  {flow}0 <= {form}"),
                &format!("apply (no_map_inequality {n} F P factor v_F). vm_cast_no_check (eq_refl true)."),
            );
        }
        Ok(())
    }

    /// The theorem about the running observer.
    fn running(
        &mut self,
        theorem: &DeployedObserver,
        (n, outputs): (usize, usize),
        bound: &RunningBound,
    ) -> Result<(), CoqError> {
        let RunningBound { added, widths, kappa, beta, limit, start, .. } = bound;
        let [constant, slope] =
            [Matrix::from_fn(n, 1, |i, _| added[(i, 0)]), Matrix::from_fn(n, n, |i, j| added[(i, j + 1)])];
        let widths = Matrix::from_row_major(n, 1, widths.clone())?;
        self.matrix("d", &points(&constant)?, "What a step adds at most whatever the error is.");
        self.matrix("D", &points(&slope)?, "What it adds at most in proportion to |e|, entry by entry.");
        self.matrix("s", &points(&widths)?, "|e_i| is at most s_i sqrt(e'Pe).");
        self.float("kappa", *kappa, "The norm of P bounds what is added in proportion by this times sqrt(e'Pe).")?;
        self.float("beta", *beta, "And the rest by this.")?;
        _ = write!(self.numbers, "\n(** Of sqrt(V), at each step. *)\nDefinition rate : Q := contraction + kappa.\n");
        self.float("limit", *limit, "At least beta / (1 - rate).")?;
        self.float("start", *start, "sqrt(V) stays below this. At least the limit.")?;
        let joined = "F * e k";
        let linear = "A * e k - L * (C * e k)";
        let cubic = format!("{linear} + g k .* (A * (N * (C * e k)) + w .* (L * (C * e k)))");
        let is_cubic = theorem.stored.cubic.is_some();
        let (step, arguments) = match theorem.step {
            _ if is_cubic => (cubic.as_str(), ("running_cubic", 9, "decided")),
            Step::Joined => (joined, ("running_joined", 1, "decided_step")),
            Step::Innovation | Step::Accumulated => (linear, ("running_linear", 4, "decided_step")),
        };
        self.lemma(
            "decided_running",
            &format!("running_is_bounded {n} P d D s lower contraction kappa rate beta limit start"),
        );
        if !is_cubic {
            let checked = match theorem.step {
                Step::Joined => format!("map_shrinks {n} F P contraction 0"),
                Step::Innovation | Step::Accumulated => format!("shrinks {n} {outputs} A C L P contraction 0"),
            };
            self.lemma("decided_step", &checked);
        }
        let (g, between) =
            if is_cubic { (" (g : nat -> R)", "(forall k, 0 <= g k /\\ w * g k <= 1) ->\n  ") } else { ("", "") };
        let root = |at: &str| format!("sqrt (quadratic {n} P (e {at}))");
        let (at_k, at_0) = (root("k"), root("0%nat"));
        let (name, count, decided) = arguments;
        let holes = |count: usize| vec!["_"; count].join(" ");
        self.theorem(
            "running",
            "Every error of which a step differs from the exact one by no more than d + D |e|, entry by entry, while sqrt(V) is\n    \
             at most start. That the rounding, the noise and the stored numbers of the target add no more is shown on paper.",
            &format!(
                "forall (e : nat -> vector){g},\n  {between}\
                 (forall k, {at_k} <= start -> forall i, (i < {n})%nat ->\n    \
                 Rabs (e (S k) i - ({step})%vector i)\n      \
                 <= real d i 0%nat + sum {n} (fun j => real D i j * Rabs (e k j))) ->\n  \
                 {at_0} <= start ->\n  \
                 0 <= rate < 1\n  \
                 /\\ (forall k, {at_k} <= start)\n  \
                 /\\ (forall k, {at_k} <= rate ^ k * {at_0} + limit)\n  \
                 /\\ (forall eps, 0 < eps -> exists K, forall k i, (K <= k)%nat -> (i < {n})%nat ->\n    \
                 Rabs (e k i) <= real s i 0%nat * (limit + eps))"
            ),
            &format!("exact ({name} {} decided_running {} {decided}).", holes(12), holes(count)),
        );
        Ok(())
    }
}
