//! The sampled cubic observer with a semi-implicit cubic step, with its gains as stored.
//!
//! **Hypotheses.** `P > 0`, `F'PF - P < 0` for `F = A - LC`, `S + S' >= 0` and
//! `[(P - F'PF)/2, PN + C'S; *, N'PN] >= 0`.
//!
//! **Theorem.** The matrix `I - s C N` is invertible for every `s >= 0`, and the error of the observer stated below
//! tends to 0 exponentially, from every e(0), for any theta, at every period, and for any s >= 0 chosen at each step.
//!
//! **Proof.** One step is `e+ = F d` with `d - s N C d = e`, d being the error after the cubic part: `x - (xhat - s N
//! r) = e + s N r`, and `r = C d` because `(I - s C N) C d = C e`. Let `w = s C d`, `R = PN + C'S`. Since `2 d'C'S w =
//! s (Cd)'(S + S')(Cd) >= 0`, `(d - Nw)'P(d - Nw) >= d'Pd - 2 d'R w + w'N'PN w >= d'Pd - d'(P - F'PF)d/2` by the last
//! hypothesis. So `V(e) >= (V(d) + V(Fd))/2` for all d and s. First, `I - s N C` has no kernel: V(d) would be 0 there.
//! Hence nor has `I - s C N`, which has the same determinant. Second, `V(Fd) <= b V(d)` with some b < 1, because
//! `F'PF < P`, and `V(e+) = V(Fd) <= 2b/(1 + b) V(e)`.

use super::super::members::members;
use super::super::sentence::{Reading, Represented};
use super::sampled::every;
use super::{Fact, Names, PlantMatrices, Statement};
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::wording::exact;

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct SemiImplicitCubicConvergence {
    /// The sampled plant `x+ = A x + B u`, `y = C x`.
    pub plant: PlantMatrices,
    /// The linear gain L, n x p.
    pub l: Matrix<f64>,
    /// The cubic gain N, n x p.
    pub n: Matrix<f64>,
    /// The weight theta, p x p.
    pub theta: Matrix<f64>,
    /// The sampling period h, positive, in units of the plant's time.
    pub period: f64,
    /// P, n x n.
    pub p: Matrix<f64>,
    /// S, p x p: N is some rounding of `-P^-1 C'S`.
    pub s: Matrix<f64>,
}

impl Statement for SemiImplicitCubicConvergence {
    const NAME: &'static str = "sampled-cubic-observer-semi-implicit";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        if self.period <= 0.0 {
            return Err(ProofError::Sign { what: "h, which should be positive,", value: self.period });
        }
        names.of(self).facts([
            "P > 0",
            "(A - LC)'P(A - LC) - P < 0",
            "S + S' >= 0",
            "[(P - (A - LC)'P(A - LC))/2, PN + C'S; *, N'PN] >= 0",
        ])
    }

    fn sentence(&self, reading: &Reading<'_>, _margin: f64) -> Option<String> {
        let every = every(self.period);
        matches!(reading.plant, Represented::Itself).then(|| {
            format!("{every}. The cubic term takes a semi-implicit step, which does not increase V at any period.")
        })
    }

    fn words(&self) -> String {
        format!(
            "For the sampled plant x+ = Ax + Bu, y = Cx with {} and the semi-implicit sampled cubic observer xhat+ = A(xhat - s N r) + Bu + L r, (I - s C N) r = z, z = y - C xhat, s = h max(z'theta z, 0), with the period h = {} and all numbers as given, in exact arithmetic: I - s C N is invertible, the error e = x - xhat obeys e+ = (A - LC)d with (I - s N C)d = e, V = e'Pe falls at each step by a factor below 1, and e tends to 0 exponentially, from every e(0). The same holds with any other s >= 0 at each step. Nothing is said of the rounding of its steps.",
            self.plant.size(),
            exact(self.period)
        )
    }
}

members! { SemiImplicitCubicConvergence {
    { plant: PlantMatrices = "plant".part(); }
    "observer" {
        l = "L".matrix(plant.gain());
        n = "N".matrix(plant.gain());
        theta = "theta".matrix((plant.outputs(), plant.outputs()));
        period = "period".positive("a sampling period is positive");
    }
    "lyapunov" { p = "P".symmetric(plant.order()); s = "S".matrix((plant.outputs(), plant.outputs())); }
} }
