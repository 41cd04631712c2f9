//! Theorem 1 of the cubic paper, for gains from any source.
//!
//! **Hypotheses.** `P > 0`, `F'P + PF < 0` (12) for `F = A - LC`, `theta >= 0`, and `P N C + C'N'P <= 0` (13') exactly
//! for L and N as stored.
//!
//! **Theorem.** `V = e'Pe` decreases along the error of the cubic observer with the stored N, from every e(0). An N
//! that was rounded does not satisfy (13'): for those see `cubic.rs`.
//!
//! **Proof.** As in `structured.rs`.

use super::super::members::members;
use super::{Fact, Names, PlantMatrices, Statement, decay};
use crate::error::ProofError;
use crate::matrix::Matrix;

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct CubicTheorem1 {
    /// The plant.
    pub plant: PlantMatrices,
    /// The linear gain L, n x p.
    pub l: Matrix<f64>,
    /// The cubic gain N, n x p.
    pub n: Matrix<f64>,
    /// The weight theta, p x p.
    pub theta: Matrix<f64>,
    /// P, n x n.
    pub p: Matrix<f64>,
}

impl Statement for CubicTheorem1 {
    const NAME: &'static str = "cubic-observer-theorem-1";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        names.of(self).facts(["P > 0", "(A - LC)'P + P(A - LC) < 0 (12)", "theta >= 0", "P N C + C'N'P <= 0 (13')"])
    }

    fn words(&self) -> String {
        format!(
            "For the plant x' = Ax + Bu, y = Cx with {} and the cubic observer xhat' = A xhat + Bu + L r - (r'theta r) N r, r = y - C xhat, with L and N exactly as stored: the error e = x - xhat obeys e' = (A - LC)e + (e'C'theta C e) N C e, and {}, from every e(0).",
            self.plant.size(),
            decay("e'Pe", "e", 0.0)
        )
    }
}

members! { CubicTheorem1 {
    { plant: PlantMatrices = "plant".part(); }
    "observer" {
        l = "L".matrix(plant.gain());
        n = "N".matrix(plant.gain());
        theta = "theta".symmetric(plant.outputs());
    }
    "lyapunov" { p = "P".symmetric(plant.order()); }
} }
