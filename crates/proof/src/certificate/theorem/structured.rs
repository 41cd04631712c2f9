//! The cubic observer with the real gain `N = -P^-1 C'S`.
//!
//! **Hypotheses.** `P > 0`, `F'P + PF + 2 rate P < 0` (12) for `F = A - LC`, `theta >= 0`, and `P N C + C'N'P <= 0`
//! (13') for the real matrix `N = -P^-1 C'S`.
//!
//! **Theorem.** `V = e'Pe` of the cubic observer's error decays as fast as that of the linear observer, from every e(0)
//! (Theorem 2 with S for gamma theta). This does not cover a stored N, which is a rounding of that matrix: for it see
//! `cubic.rs`.
//!
//! **Proof.** `V' = e'(F'P + PF)e + (y'theta y) e'(P N C + C'N'P)e` with `y = Ce`, and the last term is not positive.

use super::super::members::members;
use super::super::sentence::{Reading, Represented, disturbance, has_disturbance};
use super::cubic::of_real_gain;
use super::{Fact, Names, PlantMatrices, Statement, check_rate, decay, decrease_label};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::statement::cubic_dissipation_structured;

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct StructuredCubicConvergence {
    /// The plant.
    pub plant: PlantMatrices,
    /// The linear gain L, n x p, as stored.
    pub l: Matrix<f64>,
    /// The weight theta, p x p.
    pub theta: Matrix<f64>,
    /// P, n x n.
    pub p: Matrix<f64>,
    /// S, p x p, which defines N.
    pub s: Matrix<f64>,
    /// The rate, 0 or more.
    pub rate: f64,
}

impl Statement for StructuredCubicConvergence {
    const NAME: &'static str = "cubic-observer-with-structured-gain";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        check_rate(self.rate)?;
        let mut facts = names.of(self).facts(["P > 0", &decrease_label(self.rate), "theta >= 0"])?;
        let dissipation = cubic_dissipation_structured(&self.p, &self.s, &self.plant.c)?;
        facts.push(Fact::new("P N C + C'N'P <= 0 for N = -P^-1 C'S (13')", dissipation));
        Ok(facts)
    }

    fn sentence(&self, reading: &Reading<'_>, margin: f64) -> Option<String> {
        let error = match reading.plant {
            Represented::Itself => "the error tends to 0".to_owned(),
            Represented::WithDisturbance { states, order } => {
                let (a, c) = (self.plant.a.map(|x| Interval::of(*x)), self.plant.c.map(|x| Interval::of(*x)));
                if !has_disturbance(&a, &c, states, order) {
                    return None;
                }
                format!("for {} the errors of x and of d tend to 0", disturbance(order))
            }
            _ => return None,
        };
        Some(format!(
            "{} So {error}; convergence with the gains as stored is not certified.",
            of_real_gain(self.rate, &self.p, margin)
        ))
    }

    fn words(&self) -> String {
        format!(
            "For the plant x' = Ax + Bu, y = Cx with {} and the cubic observer xhat' = A xhat + Bu + L r - (r'theta r) N r, r = y - C xhat, with the real gain N = -P^-1 C'S: the error e = x - xhat obeys e' = (A - LC)e + (e'C'theta C e) N C e, and {}, from every e(0). Nothing is said of a rounding of N.",
            self.plant.size(),
            decay("e'Pe", "e", self.rate)
        )
    }
}

members! { StructuredCubicConvergence {
    { plant: PlantMatrices = "plant".part(); }
    "observer" {
        l = "L".matrix(plant.gain());
        theta = "theta".symmetric(plant.outputs());
        s = "S".matrix((plant.outputs(), plant.outputs()));
    }
    "lyapunov" { p = "P".symmetric(plant.order()); rate = "rate".rate(); }
} }
