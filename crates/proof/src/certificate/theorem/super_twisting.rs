//! The super-twisting observer: its error is 0 after a finite time, for every bounded disturbance.
//!
//! **Hypotheses.** With `A = [-k1 1; -2 k2 0]`, `B = (0, 1)`, `C = (1, 0)`, twice the matrices of the error in the
//! coordinates z below, so that no entry is rounded: `P > 0`, `[A'P + PA + 2 alpha P + 2 bound^2
//! C'C, 2PB; *, -2] < 0`, and `c^2 P - C'C >= 0`, with positive k1, k2, bound, alpha and c.
//!
//! **Theorem.** Let `e1' = e2 - k1 |e1|^(1/2) sign(e1)`, `e2' = F - k2 sign(e1)` with `|F(t)| <= bound`. Then e1 and e2
//! are 0 from a time of at most `(2c/alpha) V(0)^(1/2)` on, `V = z'Pz`, `z = (|e1|^(1/2) sign(e1), e2)`.
//!
//! **Proof.** Where e1 is not 0, `z' = (A z/2 + B w)/|z1|` with `w = |z1| F`, so that `w^2 <= bound^2 z1^2` and `|z1|
//! V' = z'(A'P + PA)z/2 + 2 z'PB w <= -alpha V - bound^2 z1^2 + w^2 <= -alpha V`. By the last inequality `|z1| <= c
//! V^(1/2)`, hence `V' <= -(alpha/c) V^(1/2)`. e1 = 0 with e2 not 0 holds at isolated times only, since e1' = e2 there,
//! and V is absolutely continuous along solutions in the sense of Filippov (Moreno and Osorio); so `V^(1/2)` falls at
//! least at the rate alpha/(2c) until it is 0, and stays 0.
//!
//! Source: J. A. Moreno, M. Osorio, Strict Lyapunov functions for the super-twisting algorithm, IEEE TAC 57, 2012.

use super::super::members::members;
use super::super::sentence::Reading;
use super::{Fact, Names, Statement};
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::wording::{exact, if_at_most};

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct SuperTwistingConvergence {
    /// k1, positive.
    pub k1: f64,
    /// k2, positive.
    pub k2: f64,
    /// The bound of |F|, positive.
    pub bound: f64,
    /// P, 2 x 2.
    pub p: Matrix<f64>,
    /// alpha, positive.
    pub alpha: f64,
    /// c, positive.
    pub c: f64,
}

impl Statement for SuperTwistingConvergence {
    const NAME: &'static str = "super-twisting-observer";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        for (what, value) in [
            ("k1, which should be positive,", self.k1),
            ("k2, which should be positive,", self.k2),
            ("the bound, which should be positive,", self.bound),
            ("alpha, which should be positive,", self.alpha),
            ("c, which should be positive,", self.c),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(ProofError::Sign { what, value });
            }
        }
        self.p.expect_shape("P", (2, 2))?;
        let names = names.of(self).number("bound", self.bound).define("A", "[-k1, 1; -2 k2, 0]")?;
        // Entry by entry, so that no product with a 0 or a 1 is rounded: the margin may be as small.
        let names =
            names.number("p12", self.p[(0, 1)]).number("p22", self.p[(1, 1)]).define("2PB", "[2 p12; 2 p22]")?;
        let names = names.define("2 bound^2 C'C", "[2 bound^2, 0; 0, 0]")?.define("C'C", "[1, 0; 0, 0]")?;
        names.facts(["P > 0", "[A'P + PA + 2 alpha P + 2 bound^2 C'C, 2PB; *, -2] < 0", "c^2 P - C'C >= 0"])
    }

    fn sentence(&self, reading: &Reading<'_>, _margin: f64) -> Option<String> {
        let [_, last] = reading.states else { return None };
        Some(format!(
            "In continuous time the error is 0 after a finite time, for every disturbance up to {} in {last}' (model errors included) and without noise. Nothing is said of a sampled observer.",
            if_at_most(self.bound, 6)
        ))
    }

    fn words(&self) -> String {
        format!(
            "For the error e1' = e2 - k1 |e1|^(1/2) sign(e1), e2' = F - k2 sign(e1) of a super-twisting observer in continuous time with k1 = {}, k2 = {} and every F with |F(t)| <= {}: V = z'Pz, z = (|e1|^(1/2) sign(e1), e2), satisfies V' <= -(alpha/c) V^(1/2) almost everywhere with alpha = {} and c = {}, so that e1 and e2 are 0 from a time of at most (2 c/alpha) V(0)^(1/2) on, from every initial error. Nothing is said of a sampled observer.",
            exact(self.k1),
            exact(self.k2),
            exact(self.bound),
            exact(self.alpha),
            exact(self.c)
        )
    }
}

const POSITIVE: &str = "gains, bounds and constants of a super-twisting observer are positive";

members! { SuperTwistingConvergence {
    "observer" { k1 = "k1".positive(POSITIVE); k2 = "k2".positive(POSITIVE); }
    "bounds" { bound = "F".positive(POSITIVE); }
    "lyapunov" { p = "P".symmetric(2); alpha = "alpha".positive(POSITIVE); c = "c".positive(POSITIVE); }
} }
