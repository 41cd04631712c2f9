//! One gain and one P for a convex hull of matrices in discrete time: of the Jacobians of `x+ = f(k, x, u)`.
//!
//! **Hypotheses.** `0 < factor <= 1`, `P > 0`, and at every vertex k, of which there is at least one,
//! ```text
//! [ factor^2 P    F_k'P ]
//! [ P F_k         P     ] > 0,     F_k = A_k - L C_k.
//! ```
//!
//! **Theorem.** `V = e'Pe` falls at each step by more than the factor `factor^2` along `e+ = (A(k) - L C(k))e` for
//! every pair (A(k), C(k)) in the convex hull of the vertices, fixed or varying from step to step; e tends to 0
//! exponentially.
//!
//! **Proof.** The inequality is linear in (A, C), so that it holds on the hull. There, by the Schur complement,
//! `F'PF < factor^2 P`. The hull is compact, so that some smaller factor serves all of it, also where factor = 1.
//!
//! For `x+ = f(k, x, u)`, `y = h(k, x)` and the copy with the gain L, `e+ = (Fbar - L Hbar)e` with the mean Jacobians
//! over the segment from xhat to x. *That* they lie in the hull must be shown separately, as `design::enclosure` does:
//! a certificate is about matrices only.

use super::super::members::members;
use super::super::sentence::{Reading, Represented, envelope};
use super::polytope::{Vertex, at_vertices, hull};
use super::{Fact, Names, Statement};
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::wording::{at_most, capital, exact};

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct DiscreteJacobianPolytope {
    /// The corners, pairs of the same shapes.
    pub vertices: Vec<Vertex>,
    /// The gain L, n x p, as stored.
    pub l: Matrix<f64>,
    /// P, n x n.
    pub p: Matrix<f64>,
    /// The factor, above 0 and at most 1.
    pub factor: f64,
}

/// A factor above 1 says nothing of convergence.
fn is_factor(factor: f64) -> bool {
    factor > 0.0 && factor <= 1.0
}

impl Statement for DiscreteJacobianPolytope {
    const NAME: &'static str = "discrete-polytope-of-jacobians";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        if !is_factor(self.factor) {
            return Err(ProofError::Sign {
                what: "a factor, which should be above 0 and at most 1,",
                value: self.factor,
            });
        }
        let contraction = "[factor^2 P, (A - LC)'P; *, P] > 0";
        at_vertices(self, &names, "P > 0", &self.vertices, &[contraction], |names| names)
    }

    fn sentence(&self, reading: &Reading<'_>, _margin: f64) -> Option<String> {
        let Represented::Jacobians { hypothesis, estimate, .. } = reading.plant else { return None };
        let envelope = envelope(&self.p, estimate, "k")?;
        let falls = match self.factor {
            1.0 => ", and the error tends to 0 exponentially".to_owned(),
            factor => format!(" q^k with q = {} at each sample k", at_most(factor, 6)),
        };
        Some(format!("{}, {envelope}{falls}.", capital(hypothesis)))
    }

    fn words(&self) -> String {
        let falls = if self.factor == 1.0 {
            "V = e'Pe falls at each step by a factor below 1, and e tends to 0 exponentially".to_owned()
        } else {
            format!(
                "V = e'Pe satisfies V(k) <= factor^(2k) V(0) with factor = {}, so that e tends to 0 at least like factor^k",
                exact(self.factor)
            )
        };
        format!(
            "For all matrices (A(k), C(k)) in {}, and every solution of e(k+1) = (A(k) - L C(k))e(k), {falls}. Hence for a plant x(k+1) = f(k, x, u), y = h(k, x) and the observer xhat(k+1) = f(k, xhat, u) + L(y - h(k, xhat)), as long as the mean Jacobians of f and h between xhat and x lie in this hull: that they do is a hypothesis, of which this certificate says nothing.",
            hull(&self.vertices)
        )
    }
}

members! { DiscreteJacobianPolytope {
    { vertices = "vertices".by(Vertex::read_list); }
    "observer" { l = "L".matrix(Vertex::gain(&vertices)); }
    "lyapunov" {
        p = "P".symmetric(l.rows());
        factor = "factor".number(is_factor, "a factor is above 0 and at most 1");
    }
} }
