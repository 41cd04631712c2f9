//! All eigenvalues of a matrix lie inside the unit circle.
//!
//! **Hypotheses.** `P > 0` and `A'PA - P < 0`.
//!
//! **Theorem.** Every solution of `x+ = Ax` tends to 0 exponentially; equivalently, all eigenvalues of A lie inside the
//! unit circle.
//!
//! **Proof.** `V = x'Px` decreases at each step by a factor below 1 that is the same for all x.

use super::super::members::members;
use super::{Fact, Names, Statement};
use crate::error::ProofError;
use crate::matrix::Matrix;

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct SchurStability {
    /// A, n x n.
    pub a: Matrix<f64>,
    /// P, n x n.
    pub p: Matrix<f64>,
}

impl Statement for SchurStability {
    const NAME: &'static str = "schur";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        names.of(self).facts(["P > 0", "A'PA - P < 0"])
    }

    fn words(&self) -> String {
        let n = self.a.rows();
        format!(
            "All eigenvalues of the {n} x {n} matrix A lie inside the unit circle: every solution of x+ = Ax tends to 0 exponentially."
        )
    }
}

members! { SchurStability {
    { a = "A".square(); }
    "lyapunov" { p = "P".symmetric(a.rows()); }
} }
