//! The linear observer in discrete time.
//!
//! **Hypotheses.** `P > 0` and `F'PF - P < 0` for `F = A - LC`; where a factor, `0 < factor < 1`, is given,
//! `F'PF - factor^2 P < 0`.
//!
//! **Theorem.** The error of `xhat+ = A xhat + Bu + L(y - C xhat)` tends to 0 exponentially, from every e(0), and with
//! a factor `V(k) <= factor^(2k) V(0)` for `V = e'Pe`.
//!
//! **Proof.** `e+ = Fe`, and V falls at each step by at least `q |e|^2`, q the margin of the second inequality: by a
//! factor below 1 that is the same for all e. With a factor, `V(e+) <= factor^2 V(e)`.

use super::super::members::members;
use super::super::sentence::{LOOP, Reading, Represented, disturbance, has_sampled_disturbance, inputs_of_loop};
use super::{Fact, Names, PlantMatrices, Statement};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::wording::{at_most, exact};

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct DiscreteConvergence {
    /// The plant `x+ = A x + B u`, `y = C x`.
    pub plant: PlantMatrices,
    /// The gain L, n x p, as stored.
    pub l: Matrix<f64>,
    /// P, n x n.
    pub p: Matrix<f64>,
    /// The factor by which `sqrt V` falls at each step, above 0 and below 1; none where V falls by any.
    pub factor: Option<f64>,
}

fn is_factor(factor: f64) -> bool {
    factor > 0.0 && factor < 1.0
}

impl Statement for DiscreteConvergence {
    const NAME: &'static str = "discrete-observer";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        let decrease = match self.factor {
            None => "(A - LC)'P(A - LC) - P < 0",
            Some(factor) if is_factor(factor) => "(A - LC)'P(A - LC) - factor^2 P < 0",
            Some(value) => {
                return Err(ProofError::Sign { what: "a factor, which should be above 0 and below 1,", value });
            }
        };
        names.of(self).facts(["P > 0", decrease])
    }

    fn sentence(&self, reading: &Reading<'_>, _margin: f64) -> Option<String> {
        let (a, c) = (self.plant.a.map(|x| Interval::of(*x)), self.plant.c.map(|x| Interval::of(*x)));
        let falls = self.factor.map(|factor| format!(", at least as fast as {}^k", at_most(factor, 6)));
        let falls = falls.unwrap_or_default();
        Some(match reading.plant {
            Represented::Itself => {
                format!("e+ = (A - L C) e: for all x(0) and xhat(0) the error tends to 0{falls}.")
            }
            Represented::WithDisturbance { states, order }
                if has_sampled_disturbance(&self.plant.a, &self.plant.c, states, order) =>
            {
                format!(
                    "For {} the errors of x and of d tend to 0{falls}, for all x(0), xhat(0) and d.",
                    disturbance(order)
                )
            }
            Represented::Loop { states, is_linear_part } if inputs_of_loop(&a, &self.l, &c, states).is_some() => {
                if is_linear_part {
                    "In the loop u = r - K xhat with r = 0: x and xhat tend to 0 exponentially, if they start near 0."
                        .to_owned()
                } else {
                    LOOP.to_owned()
                }
            }
            _ => return None,
        })
    }

    fn words(&self) -> String {
        let falls = match self.factor {
            None => "V = e'Pe decreases at each step, and e tends to 0 exponentially".to_owned(),
            Some(factor) => format!(
                "V = e'Pe satisfies V(k) <= factor^(2k) V(0) with factor = {}, and e tends to 0 at least like factor^k",
                exact(factor)
            ),
        };
        format!(
            "For the discrete-time plant x+ = Ax + Bu, y = Cx with {} and the observer xhat+ = A xhat + Bu + L(y - C xhat), the error e = x - xhat obeys e+ = (A - LC)e, {falls}, from every e(0).",
            self.plant.size()
        )
    }
}

members! { DiscreteConvergence {
    { plant: PlantMatrices = "plant".part(); }
    "observer" { l = "L".matrix(plant.gain()); }
    "lyapunov" {
        p = "P".symmetric(plant.order());
        factor = optional "factor".number(is_factor, "a factor is above 0 and below 1");
    }
} }
