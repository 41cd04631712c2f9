//! `discrete-observer`, and the Stein inequality that other theorems share.

use super::{Between, CoqError, Out, points};
use crate::certificate::{DiscreteConvergence, Fact};
use crate::number::Number;

/// A factor by which the square root of V falls at each step, from the margin of an inequality `F'PF - scale P < 0`:
/// `F'PF <= scale P - q I <= scale (1 - q / (scale upper)) P`.
pub(super) fn contraction(decrease: &Fact, scale: f64, upper: f64) -> f64 {
    let falls = (decrease.verdict.margin().unwrap_or(0.0) / (scale * upper).next_up()).next_down();
    (1.0 - falls).next_up().sqrt().next_up()
}

/// What is concluded of an error e in discrete time.
pub(super) fn falls(n: usize) -> String {
    format!(
        "(forall k, quadratic {n} P (e (S k)) <= contraction ^ 2 * quadratic {n} P (e k))\n  \
         /\\ (forall k, quadratic {n} P (e k) <= contraction ^ (2 * k) * quadratic {n} P (e 0%nat))\n  \
         /\\ (forall k, norm {n} (e k) <= overshoot * contraction ^ k * norm {n} (e 0%nat))"
    )
}

impl Out {
    /// `contraction`, which has to be below 1.
    pub(super) fn contraction(&mut self, contraction: f64, decrease: &Fact) -> Result<(), CoqError> {
        if contraction.is_nan() || contraction >= 1.0 {
            return Err(CoqError::NoMargin { inequality: decrease.inequality.clone() });
        }
        self.float("contraction", contraction, "The factor by which the square root of V falls at each step.")
    }

    /// `F'P F - factor^2 P < 0`, proved or refuted.
    pub(super) fn stein(
        &mut self,
        (n, outputs): (usize, usize),
        decrease: &Fact,
        claimed: Option<&Number>,
    ) -> Result<(), CoqError> {
        let form = format!("quadratic {n} P w - factor ^ 2 * quadratic {n} P v");
        if decrease.verdict.is_proved() {
            self.margin("margin_F", decrease, claimed)?;
            let statement = format!(
                "0 < margin_F /\\ forall v : vector, let w := (A * v - L * (C * v))%vector in\n  {form} <= - margin_F * square {n} v"
            );
            let proof = format!(
                "apply (stein_inequality {n} {outputs} A C L P factor margin_F). vm_cast_no_check (eq_refl true)."
            );
            let what = "v'(F'P F - factor^2 P)v is at most minus the margin times |v|^2, F = A - L C.";
            self.theorem("stein_inequality", what, &statement, &proof);
        } else if self.witness("v_F", decrease)? {
            let statement = format!(
                "exists v : vector, 0 < square {n} v /\\\n    let w := (A * v - L * (C * v))%vector in\n    0 <= {form}"
            );
            let proof = format!(
                "apply (no_stein_inequality {n} {outputs} A C L P factor v_F). vm_cast_no_check (eq_refl true)."
            );
            let what = "v'(F'P F - factor^2 P)v < 0 is false, F = A - L C.";
            self.theorem("stein_inequality_is_false", what, &statement, &proof);
        }
        Ok(())
    }

    pub(super) fn discrete(
        &mut self,
        theorem: &DiscreteConvergence,
        facts: &[Fact],
        claimed: &[Number],
    ) -> Result<(), CoqError> {
        let DiscreteConvergence { plant, l, p, factor } = theorem;
        let [a, b, c] = [points(&plant.a)?, points(&plant.b)?, points(&plant.c)?];
        let [positive, decrease] = facts else { return Ok(()) };
        let (n, outputs) = (a.rows(), c.rows());
        self.plant([&a, &b, &c], l, p)?;
        self.float("factor", factor.unwrap_or(1.0), "The factor of the inequality, 1 where the certificate has none.")?;
        let all = facts.iter().all(|fact| fact.verdict.is_proved());
        if all {
            let between = Between::of(p, positive)?;
            self.between(&between, "")?;
            let contraction = factor.unwrap_or_else(|| contraction(decrease, 1.0, between.upper));
            self.contraction(contraction, decrease)?;
        }
        self.positive(n, "P", positive, claimed.first())?;
        self.stein((n, outputs), decrease, claimed.get(1))?;
        if !all {
            return Ok(());
        }
        self.lemma("decided", &format!("contracts {n} {outputs} A C L P contraction lower upper overshoot"));
        self.exact_linear(n);
        let says = falls(n);
        self.theorem(
            "observer",
            "The error e = x - xhat of plant x+ = A x + B u, y = C x and observer xhat+ = A xhat + B u + L(y - C xhat), for\n    every input u.",
            &format!(
                "forall u x xhat : nat -> vector,\n  \
                 recursion {n} x (fun k => A * x k + B * u k)%vector ->\n  \
                 recursion {n} xhat (fun k => A * xhat k + B * u k + L * (C * x k - C * xhat k))%vector ->\n  \
                 let e k := (x k - xhat k)%vector in\n  {says}"
            ),
            "exact (observer_contracts _ _ _ _ _ _ _ _ _ _ decided B).",
        );
        Ok(())
    }

    /// The theorem about the error of the step.
    pub(super) fn exact_linear(&mut self, n: usize) {
        let says = falls(n);
        self.theorem(
            "every_error",
            "Every e with e(k+1) = (A - L C)e(k): V = e'Pe and the norm of e decay.",
            &format!(
                "forall e : nat -> vector,\n  recursion {n} e (fun k => A * e k - L * (C * e k))%vector ->\n  {says}"
            ),
            "exact (error_contracts _ _ _ _ _ _ _ _ _ _ decided).",
        );
    }
}
