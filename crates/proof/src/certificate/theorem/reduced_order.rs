//! The reduced-order observer: convergence with the T as stored.
//!
//! **Hypotheses.** `C'C + T'T > 0`; with the real matrices `M = (C'C + T'T)^-1 T'` and `F = TAM`, `P > 0` and
//! `F'P + PF + 2 rate P < 0`.
//!
//! **Theorem.** With `N = (C'C + T'T)^-1 C'` the error of `w' = Fw + TAN y + TBu`, `xhat = Mw + Ny` tends to 0
//! exponentially from every w(0).
//!
//! **Proof.** `N C + M T = I`. The error `v = w - Tx` obeys `v' = F w + TAN Cx + TBu - TAx - TBu = F w - TAM Tx = F v`,
//! since `TAN C = TA - TAM T`, and `xhat - x = M w + N C x - x = M v`. This holds exactly for the real matrices M, N, F
//! and G = TAN, which are rational functions of A, C and T. `[N M]` is the left inverse of `S = [C; T]`, so that
//! `[G F] = TA (S'S)^-1 S'` is enclosed as in `statement/left_inverse.rs`.

use super::super::members::members;
use super::super::sentence::{Reading, Represented, tends_to_zero};
use super::{Fact, Names, PlantMatrices, Statement, check_rate, counted, decay, rate_term};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::statement::times_left_inverse;

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct ReducedOrderConvergence {
    /// The plant.
    pub plant: PlantMatrices,
    /// T, q x n, as stored.
    pub t: Matrix<f64>,
    /// P, q x q.
    pub p: Matrix<f64>,
    /// The rate, 0 or more.
    pub rate: f64,
}

impl ReducedOrderConvergence {
    /// Enclosure of F, if S has full column rank; `None` if the rank cannot be proved.
    fn flow(&self, names: &Names<'_>) -> Result<Option<Matrix<Interval>>, ProofError> {
        let solution = times_left_inverse(&names.expression("TA")?, &names.expression("[C; T]")?)?;
        let (outputs, order) = (self.plant.c.rows(), self.t.rows());
        solution.iter().try_for_each(|x| x.expect_shape("[G F]", (order, outputs + order)))?;
        Ok(solution.map(|x| Matrix::from_fn(order, order, |i, j| x[(i, outputs + j)])))
    }
}

impl Statement for ReducedOrderConvergence {
    const NAME: &'static str = "reduced-order-observer";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        check_rate(self.rate)?;
        let names = names.of(self);
        let mut facts = names.facts(["C'C + T'T > 0"])?;
        let flow = if facts.iter().all(|fact| fact.verdict.is_proved()) { self.flow(&names)? } else { None };
        let decrease = format!("F'P + PF{} < 0", rate_term(self.rate, "P"));
        facts.extend(names.enclosed("F", flow.as_ref(), false).facts(["P > 0", &decrease])?);
        Ok(facts)
    }

    fn sentence(&self, reading: &Reading<'_>, margin: f64) -> Option<String> {
        if !matches!(reading.plant, Represented::Itself) {
            return None;
        }
        Some(format!(
            "w' = F w + G y + H u, xhat = M w + N y with {} of {} states: for all x(0) and w(0) the error {}, with M, N, F and G as real matrices.",
            self.t.rows(),
            self.plant.a.rows(),
            tends_to_zero(self.rate, &self.p, margin)
        ))
    }

    fn words(&self) -> String {
        format!(
            "For the plant x' = Ax + Bu, y = Cx with {} and the observer w' = Fw + TAN y + TBu, xhat = Mw + Ny with {}, T exactly as stored and the real matrices N = (C'C + T'T)^-1 C', M = (C'C + T'T)^-1 T' and F = TAM: v = w - Tx obeys v' = Fv, the error is xhat - x = Mv, and {}, from every v(0). Nothing is said of a rounding of the other matrices.",
            self.plant.size(),
            counted(self.t.rows(), "state"),
            decay("v'Pv", "v", self.rate)
        )
    }
}

members! { ReducedOrderConvergence {
    { plant: PlantMatrices = "plant".part(); }
    "observer" { t = "T".matrix_with_columns(plant.order()); }
    "lyapunov" { p = "P".symmetric(t.rows()); rate = "rate".rate(); }
} }
