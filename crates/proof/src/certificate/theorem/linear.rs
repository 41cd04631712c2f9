//! The linear observer in continuous time.
//!
//! **Hypotheses.** `P > 0` and `F'P + PF + 2 rate P < 0` (12) for `F = A - LC`, `rate >= 0`.
//!
//! The error `e = x - xhat` of `xhat' = A xhat + Bu + L(y - C xhat)` has `V(t) <= exp(-2 rate t) V(0)` for `V = e'Pe`,
//! and tends to 0 exponentially, from every e(0). B is arbitrary. Where entries of A, B, C are intervals, this holds
//! for every plant within them, with the same L and P.
//!
//! **Proof.** `e' = Fe`, hence `V' <= -2 rate V - q |e|^2`, q the margin of (12), and
//! `|e(t)| <= sqrt(cond P) exp(-rate t) |e(0)|`; with rate 0 the decay is at least that of `q / (2 lambda_max(P))`.

use super::super::members::members;
use super::super::sentence::{LOOP, Reading, Represented, disturbance, has_disturbance, inputs_of_loop, tends_to_zero};
use super::{Fact, Names, PlantWithin, Statement, check_rate, decay, decrease_label, enclosed, intervals};
use crate::error::ProofError;
use crate::matrix::Matrix;

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearConvergence {
    /// The plant.
    pub plant: PlantWithin,
    /// The gain L, n x p, as stored.
    pub l: Matrix<f64>,
    /// P, n x n.
    pub p: Matrix<f64>,
    /// The rate, 0 or more.
    pub rate: f64,
}

impl Statement for LinearConvergence {
    const NAME: &'static str = "linear-observer";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        check_rate(self.rate)?;
        names.of(self).facts(["P > 0", &decrease_label(self.rate)])
    }

    fn sentence(&self, reading: &Reading<'_>, margin: f64) -> Option<String> {
        let (a, c) = (intervals(&self.plant.a), intervals(&self.plant.c));
        let falls = tends_to_zero(self.rate, &self.p, margin);
        Some(match reading.plant {
            Represented::Itself => format!("e' = (A - L C) e: for all x(0) and xhat(0) the error {falls}."),
            Represented::WithDisturbance { states, order } if has_disturbance(&a, &c, states, order) => {
                format!(
                    "For {} the errors of x and of d {}, for all x(0), xhat(0) and d.",
                    disturbance(order),
                    falls.replacen("tends", "tend", 1)
                )
            }
            Represented::Loop { states, is_linear_part: false }
                if inputs_of_loop(&a, &self.l, &c, states).is_some() =>
            {
                LOOP.to_owned()
            }
            _ => return None,
        })
    }

    fn words(&self) -> String {
        format!(
            "For the plant x' = Ax + Bu, y = Cx with {} and the observer xhat' = A xhat + Bu + L(y - C xhat), the error e = x - xhat obeys e' = (A - LC)e, and {}, from every e(0).{}",
            self.plant.size(),
            decay("e'Pe", "e", self.rate),
            enclosed([&self.plant.a, &self.plant.b, &self.plant.c], "")
        )
    }
}

members! { LinearConvergence {
    { plant: PlantWithin = "plant".part(); }
    "observer" { l = "L".matrix(plant.gain()); }
    "lyapunov" { p = "P".symmetric(plant.order()); rate = "rate".rate(); }
} }
