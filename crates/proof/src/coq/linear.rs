//! `linear-observer`, and the Lyapunov inequality that other theorems share.

use super::bounds::{Data, are_bounds, between_bounds};
use super::{Between, CoqError, Out, points, says, single};
use crate::certificate::{Fact, LinearConvergence};
use crate::number::Number;

impl Out {
    /// (12), proved or refuted, for the matrices A and C with this suffix.
    pub(super) fn decrease(
        &mut self,
        (n, outputs): (usize, usize),
        fact: &Fact,
        claimed: Option<&Number>,
        suffix: &str,
    ) -> Result<(), CoqError> {
        let (a, c) = (format!("A{suffix}"), format!("C{suffix}"));
        let form = format!("inner {n} w (P * v)%vector + inner {n} v (P * w)%vector + 2 * rate * quadratic {n} P v");
        let [margin, vector] = ["margin_12", "v_12"].map(|name| format!("{name}{suffix}"));
        let lemma = |name: &str, number: &str| {
            format!("apply ({name} {n} {outputs} {a} {c} L P rate {number}). vm_cast_no_check (eq_refl true).")
        };
        if fact.verdict.is_proved() {
            self.margin(&margin, fact, claimed)?;
            let statement = format!(
                "0 < {margin} /\\ forall v : vector, let w := ({a} * v - L * ({c} * v))%vector in\n  {form}\n    \
                 <= - {margin} * square {n} v"
            );
            let what =
                format!("v'(F'P + PF + 2 rate P)v is at most minus the margin times |v|^2, F = {a} - L {c}: (12).");
            self.theorem(&format!("inequality_12{suffix}"), &what, &statement, &lemma("lyapunov_inequality", &margin));
        } else if self.witness(&vector, fact)? {
            let statement = format!(
                "exists v : vector, 0 < square {n} v /\\\n    let w := ({a} * v - L * ({c} * v))%vector in\n    0 <= {form}"
            );
            let what = format!("(12) is false: v'(F'P + PF + 2 rate P)v is not negative, F = {a} - L {c}.");
            let name = format!("inequality_12{suffix}_is_false");
            self.theorem(&name, &what, &statement, &lemma("no_lyapunov_inequality", &vector));
        }
        Ok(())
    }

    pub(super) fn linear(
        &mut self,
        theorem: &LinearConvergence,
        facts: &[Fact],
        claimed: &[Number],
    ) -> Result<(), CoqError> {
        let LinearConvergence { plant, l, p, rate } = theorem;
        if are_bounds([&plant.a, &plant.b, &plant.c]) {
            return self.linear_within(theorem, facts, claimed);
        }
        let [a, b, c] = [single(&plant.a, "A")?, single(&plant.b, "B")?, single(&plant.c, "C")?];
        let [positive, decrease] = facts else { return Ok(()) };
        let (n, outputs) = (a.rows(), c.rows());
        self.plant([&a, &b, &c], l, p)?;
        self.float("rate", *rate, "The rate in (12).")?;
        let all = facts.iter().all(|fact| fact.verdict.is_proved());
        if all {
            let between = Between::of(p, positive)?;
            self.between(&between, "")?;
            self.decay(*rate, decrease, between.upper)?;
        }
        self.positive(n, "P", positive, claimed.first())?;
        self.decrease((n, outputs), decrease, claimed.get(1), "")?;
        if !all {
            return Ok(());
        }
        self.lemma("decided", &format!("decays {n} {outputs} A C L P decay lower upper overshoot"));
        let says = says(n, "");
        self.theorem(
            "every_error",
            "Every differentiable e with e' = (A - L C)e, on any interval from 0 to T: V = e'Pe and the norm of e decay.",
            &format!(
                "forall (T : R) (e : R -> vector),\n  solution T {n} e (fun t => A * e t - L * (C * e t))%vector ->\n  {says}"
            ),
            "exact (error_decays _ _ _ _ _ _ _ _ _ _ decided).",
        );
        self.theorem(
            "observer",
            "The error e = x - xhat of plant x' = A x + B u, y = C x and observer xhat' = A xhat + B u + L(y - C xhat), for\n    every input u.",
            &format!(
                "forall (T : R) (u x xhat : R -> vector),\n  \
                 solution T {n} x (fun t => A * x t + B * u t)%vector ->\n  \
                 solution T {n} xhat (fun t => A * xhat t + B * u t + L * (C * x t - C * xhat t))%vector ->\n  \
                 let e t := (x t - xhat t)%vector in\n  {says}"
            ),
            "exact (observer_decays _ _ _ _ _ _ _ _ _ _ decided B).",
        );
        self.theorem(
            "errors_exist",
            "From every e(0) there is an e with e' = (A - L C)e, for all times.",
            &format!(
                "forall e0 : vector, exists e : R -> vector,\n  \
                 (forall i, (i < {n})%nat -> e 0 i = e0 i) /\\\n  \
                 forall T, solution T {n} e (fun t => A * e t - L * (C * e t))%vector"
            ),
            &format!("refine (error_exists {n} {outputs} A C L _). vm_cast_no_check (eq_refl true)."),
        );
        Ok(())
    }

    /// The same for data between bounds.
    fn linear_within(
        &mut self,
        theorem: &LinearConvergence,
        facts: &[Fact],
        claimed: &[Number],
    ) -> Result<(), CoqError> {
        let LinearConvergence { plant, l, p, rate } = theorem;
        let [positive, decrease] = facts else { return Ok(()) };
        let (n, inputs, outputs) = (plant.a.rows(), plant.b.cols(), plant.c.rows());
        let data = Data { a: &plant.a, c: &plant.c, l, p };
        self.bounds(&plant.a, &plant.c, "");
        self.matrix("L", &points(l)?, "The gain of the observer.");
        self.matrix("P", &points(p)?, "The matrix of V = e'Pe.");
        self.float("rate", *rate, "The rate in (12).")?;
        let all = facts.iter().all(|fact| fact.verdict.is_proved());
        if all {
            let between = Between::of(p, positive)?;
            self.between(&between, "")?;
            self.decay(*rate, decrease, between.upper)?;
        }
        self.positive(n, "P", positive, claimed.first())?;
        self.decrease_within(&data, *rate, decrease, claimed.get(1), "")?;
        if !all {
            return Ok(());
        }
        self.lemma(
            "decided",
            &format!("decays_within {n} {outputs} A_low A_high C_low C_high L P decay lower upper overshoot"),
        );
        let says = says(n, "");
        self.theorem(
            "every_error",
            "Every differentiable e with e' = (A(t) - L C(t))e and A(t), C(t) between the bounds, on any interval from 0 to T.",
            &format!(
                "forall (T : R) (e : R -> vector) (A C : R -> matrix),\n  \
                 (forall t, within {n} {n} A_low A_high (A t)) -> (forall t, within {outputs} {n} C_low C_high (C t)) ->\n  \
                 solution T {n} e (fun t => apply {n} (A t) (e t) - L * apply {n} (C t) (e t))%vector ->\n  {says}"
            ),
            "exact (within_error_decays _ _ _ _ _ _ _ _ _ _ _ _ decided).",
        );
        self.theorem(
            "observer",
            "The error e = x - xhat of plant x' = A x + B u, y = C x and observer xhat' = A xhat + B u + L(y - C xhat), for all\n    \
             A and C between the bounds, every B and every input u.",
            &format!(
                "forall (A B C : matrix) (T : R) (u x xhat : R -> vector),\n  {}\n  \
                 solution T {n} x (fun t => apply {n} A (x t) + apply {inputs} B (u t))%vector ->\n  \
                 solution T {n} xhat (fun t =>\n    \
                 apply {n} A (xhat t) + apply {inputs} B (u t) + L * (apply {n} C (x t) - apply {n} C (xhat t)))%vector ->\n  \
                 let e t := (x t - xhat t)%vector in\n  {says}",
                between_bounds((n, outputs), "")
            ),
            &format!("exact (within_observer_decays _ _ _ _ _ _ _ _ _ _ _ _ decided {inputs})."),
        );
        Ok(())
    }
}
