//! The sampled cubic observer, with its gains as stored.
//!
//! **Hypotheses.** `P > 0`, `(A - LC)'P(A - LC) - P < 0` and `(wA + ANC)'P(wA + ANC) - w^2 P < 0`, with w > 0.
//!
//! **Theorem.** The error of the observer stated below tends to 0 exponentially, from every e(0) and at every period
//! `h > 0`, for any N and theta.
//!
//! **Proof.** One period with `g = (1 - r)/w` gives `e+ = A(e + g N C e) - r L C e = M(g) e` with
//! `M(g) = A - LC + g (AN + wL)C`. Since `q >= 0` is in the observer, `0 < r <= 1` and `0 <= g < 1/w`, whatever theta
//! is. `M(g)'P M(g) - P` is convex in g, `M(0) = A - LC` and `w M(1/w) = wA + ANC`: where it is negative definite at
//! both ends it is so between, by a margin that does not depend on e. Hence V falls at each period by a factor below 1.

use super::super::members::members;
use super::super::sentence::{Reading, Represented};
use super::{Fact, Names, PlantMatrices, Statement};
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::wording::{exact, shortest};

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledCubicConvergence {
    /// The sampled plant `x+ = A x + B u`, `y = C x`.
    pub plant: PlantMatrices,
    /// The linear gain L, n x p.
    pub l: Matrix<f64>,
    /// The cubic gain N, n x p.
    pub n: Matrix<f64>,
    /// The weight theta, p x p.
    pub theta: Matrix<f64>,
    /// The rate w of the cubic flow, positive.
    pub w: f64,
    /// The sampling period h, positive, in units of the plant's time.
    pub period: f64,
    /// P, n x n.
    pub p: Matrix<f64>,
}

impl Statement for SampledCubicConvergence {
    const NAME: &'static str = "sampled-cubic-observer";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        for (what, value) in [("w, which should be positive,", self.w), ("h, which should be positive,", self.period)] {
            if value <= 0.0 {
                return Err(ProofError::Sign { what, value });
            }
        }
        names.of(self).facts(["P > 0", "(A - LC)'P(A - LC) - P < 0", "(wA + ANC)'P(wA + ANC) - w^2 P < 0"])
    }

    fn sentence(&self, reading: &Reading<'_>, _margin: f64) -> Option<String> {
        let every = every(self.period);
        matches!(reading.plant, Represented::Itself).then(|| format!("{every}."))
    }

    fn words(&self) -> String {
        format!(
            "For the sampled plant x+ = Ax + Bu, y = Cx with {} and the sampled cubic observer xhat+ = A(xhat - g N z) + Bu + r L z, z = y - C xhat, q = max(z'theta z, 0), r = 1/sqrt(1 + 2 w h q), g = (1 - r)/w, with w = {} and the period h = {} and all numbers as given, in exact arithmetic: the error e = x - xhat obeys e+ = (A - LC + g (AN + wL)C)e with 0 <= g < 1/w, V = e'Pe falls at each step by a factor below 1, and e tends to 0 exponentially, from every e(0). Nothing is said of the rounding of its steps.",
            self.plant.size(),
            exact(self.w),
            exact(self.period)
        )
    }
}

/// What a sampled cubic observer does from sample to sample.
pub(super) fn every(period: f64) -> String {
    format!(
        "Sampled every {}: V = e'Pe decreases from sample to sample and the error tends to 0, for every initial error",
        shortest(period)
    )
}

members! { SampledCubicConvergence {
    { plant: PlantMatrices = "plant".part(); }
    "observer" {
        l = "L".matrix(plant.gain());
        n = "N".matrix(plant.gain());
        theta = "theta".matrix((plant.outputs(), plant.outputs()));
        w = "w".positive("the rate w of the cubic flow is positive");
        period = "period".positive("a sampling period is positive");
    }
    "lyapunov" { p = "P".symmetric(plant.order()); }
} }
