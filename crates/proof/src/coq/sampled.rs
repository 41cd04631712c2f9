//! `sampled-cubic-observer`.

use super::discrete::{contraction, falls};
use super::{Between, CoqError, Out, points};
use crate::certificate::{Fact, SampledCubicConvergence};
use crate::number::Number;

impl Out {
    pub(super) fn sampled(
        &mut self,
        theorem: &SampledCubicConvergence,
        facts: &[Fact],
        claimed: &[Number],
    ) -> Result<(), CoqError> {
        let SampledCubicConvergence { plant, l, n: gain, theta, w, period, p } = theorem;
        let [a, b, c] = [points(&plant.a)?, points(&plant.b)?, points(&plant.c)?];
        let [positive, decrease, end] = facts else { return Ok(()) };
        let (n, outputs) = (a.rows(), c.rows());
        self.plant([&a, &b, &c], l, p)?;
        self.matrix("N", &points(gain)?, "The cubic gain.");
        self.matrix("theta", &points(theta)?, "The weight of the cubic term.");
        self.float("w", *w, "The rate of the cubic flow.")?;
        self.float("period", *period, "The sampling period.")?;
        self.float("factor", 1.0, "The factor of the inequality of A - L C: none.")?;
        let all = facts.iter().all(|fact| fact.verdict.is_proved());
        if all {
            let between = Between::of(p, positive)?;
            self.between(&between, "")?;
            // The larger factor of the two ends.
            let scale = (w * w).next_down();
            let (first, last) = (contraction(decrease, 1.0, between.upper), contraction(end, scale, between.upper));
            let slower = if last > first { end } else { decrease };
            self.contraction(first.max(last), slower)?;
        }
        self.positive(n, "P", positive, claimed.first())?;
        self.stein((n, outputs), decrease, claimed.get(1))?;
        self.at_the_end((n, outputs), end, claimed.get(2))?;
        if !all {
            return Ok(());
        }
        self.lemma(
            "decided",
            &format!("sampled_contracts {n} {outputs} A C L N P w contraction lower upper overshoot"),
        );
        self.exact_cubic(n);
        let says = falls(n);
        self.theorem(
            "observer",
            "The error e = x - xhat of plant x+ = A x + B u, y = C x and observer xhat+ = A(xhat - g N z) + B u + r L z,\n    \
             z = y - C xhat, q = max(z'theta z, 0), r = 1/sqrt(1 + 2 w period q), g = (1 - r)/w, for every input u.",
            &format!(
                "forall u x xhat : nat -> vector,\n  \
                 recursion {n} x (fun k => A * x k + B * u k)%vector ->\n  \
                 recursion {n} xhat (fun k => let z := (C * x k - C * xhat k)%vector in\n    \
                 let q := Rmax (quadratic {outputs} theta z) 0 in\n    \
                 let r := / sqrt (1 + 2 * w * period * q) in let g := (1 - r) / w in\n    \
                 (A * (xhat k - g .* (N * z)) + B * u k + r .* (L * z))%vector) ->\n  \
                 let e k := (x k - xhat k)%vector in\n  {says}"
            ),
            "exact (fun u x xhat => sampled_observer_contracts _ _ _ _ _ _ _ _ _ _ _ _ decided B theta period u x xhat\n  \
             (is_positive_correct period eq_refl)).",
        );
        Ok(())
    }

    /// `(w A + A N C)'P(w A + A N C) - w^2 P < 0`, proved or refuted.
    pub(super) fn at_the_end(
        &mut self,
        (n, outputs): (usize, usize),
        end: &Fact,
        claimed: Option<&Number>,
    ) -> Result<(), CoqError> {
        let v = "v : vector, ";
        let f = "let f := (w .* (A * v) + A * (N * (C * v)))%vector in\n  ";
        let form = format!("quadratic {n} P f - w ^ 2 * quadratic {n} P v");
        if end.verdict.is_proved() {
            self.margin("margin_w", end, claimed)?;
            self.theorem(
                "inequality_at_the_end",
                "v'((w A + A N C)'P(w A + A N C) - w^2 P)v is at most minus the margin times |v|^2.",
                &format!("0 < margin_w /\\ forall {v}{f}{form} <= - margin_w * square {n} v"),
                &format!("apply (end_inequality {n} {outputs} A C N P w margin_w). vm_cast_no_check (eq_refl true)."),
            );
        } else if self.witness("v_w", end)? {
            self.theorem(
                "inequality_at_the_end_is_false",
                "v'((w A + A N C)'P(w A + A N C) - w^2 P)v < 0 is false.",
                &format!("exists {v}0 < square {n} v /\\\n  {f}0 <= {form}"),
                &format!("apply (no_end_inequality {n} {outputs} A C N P w v_w). vm_cast_no_check (eq_refl true)."),
            );
        }
        Ok(())
    }

    /// The theorem about the error of the exact step, for every g.
    pub(super) fn exact_cubic(&mut self, n: usize) {
        let says = falls(n);
        self.theorem(
            "every_error",
            "Every e with e(k+1) = (A - L C + g(k) (A N + w L)C)e(k), for any numbers g(k) from 0 to 1/w.",
            &format!(
                "forall (e : nat -> vector) (g : nat -> R),\n  \
                 (forall k, 0 <= g k /\\ w * g k <= 1) ->\n  \
                 recursion {n} e (fun k =>\n    \
                 A * e k - L * (C * e k) + g k .* (A * (N * (C * e k)) + w .* (L * (C * e k))))%vector ->\n  {says}"
            ),
            "exact (sampled_error_contracts _ _ _ _ _ _ _ _ _ _ _ _ decided).",
        );
    }
}
