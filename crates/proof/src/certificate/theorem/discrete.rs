//! The linear observer in discrete time.
//!
//! **Hypotheses.** `P > 0` and `F'PF - P < 0` for `F = A - LC`.
//!
//! **Theorem.** The error of `xhat+ = A xhat + Bu + L(y - C xhat)` tends to 0 exponentially, from every e(0).
//!
//! **Proof.** `e+ = Fe`, and `V = e'Pe` falls at each step by at least `q |e|^2`, q the margin of the second
//! inequality: by a factor below 1 that is the same for all e.

use super::super::members::members;
use super::super::sentence::{LOOP, Reading, Represented, inputs_of_loop};
use super::{Fact, PlantMatrices, Statement, names};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct DiscreteConvergence {
    /// The plant `x+ = A x + B u`, `y = C x`.
    pub plant: PlantMatrices,
    /// The gain L, n x p, as stored.
    pub l: Matrix<f64>,
    /// P, n x n.
    pub p: Matrix<f64>,
}

impl Statement for DiscreteConvergence {
    const NAME: &'static str = "discrete-observer";

    fn facts(&self) -> Result<Vec<Fact>, ProofError> {
        names(self).facts(["P > 0", "(A - LC)'P(A - LC) - P < 0"])
    }

    fn sentence(&self, reading: &Reading<'_>, _margin: f64) -> Option<String> {
        let (a, c) = (self.plant.a.map(|x| Interval::of(*x)), self.plant.c.map(|x| Interval::of(*x)));
        Some(match reading.plant {
            Represented::Itself => "e+ = (A - L C) e: for all x(0) and xhat(0) the error tends to 0.".to_owned(),
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
        format!(
            "For the discrete-time plant x+ = Ax + Bu, y = Cx with {} and the observer xhat+ = A xhat + Bu + L(y - C xhat), the error e = x - xhat obeys e+ = (A - LC)e, V = e'Pe decreases at each step, and e tends to 0 exponentially, from every e(0).",
            self.plant.size()
        )
    }
}

members! { DiscreteConvergence {
    { plant: PlantMatrices = "plant".part(); }
    "observer" { l = "L".matrix(plant.gain()); }
    "lyapunov" { p = "P".symmetric(plant.order()); }
} }
