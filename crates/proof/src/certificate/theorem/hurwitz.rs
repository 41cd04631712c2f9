//! All eigenvalues of a matrix have negative real parts.
//!
//! **Hypotheses.** `P > 0` and `A'P + PA < 0`.
//!
//! **Theorem.** Every solution of `x' = Ax` tends to 0 exponentially; equivalently, all eigenvalues of A have negative
//! real parts. For an interval matrix A the two inequalities hold for every matrix in it with one P, so that `x' =
//! A(t)x` decays also when A varies in time.
//!
//! **Proof.** `V = x'Px` has `V' <= -q |x|^2`, q the margin of the second inequality. For an A of single numbers there
//! is a third condition, with a margin m such that all real parts are below -m: `A'P + PA <= -q I` and `P <= p I` give
//! `m = q / (2p)`.

use super::super::jacobians::data_contain;
use super::super::members::members;
use super::super::sentence::{Reading, Represented};
use super::{Fact, Names, Statement, are_points, bounded, data, enclosed, intervals};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::number::Datum;
use crate::statement::hurwitz;
use crate::wording::capital;

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct HurwitzStability {
    /// A, n x n.
    pub a: Matrix<Datum>,
    /// P, n x n.
    pub p: Matrix<f64>,
}

impl HurwitzStability {
    /// A matrix of numbers with its P.
    ///
    /// # Errors
    /// [`ProofError::NotFinite`].
    pub fn new(a: &Matrix<f64>, p: &Matrix<f64>) -> Result<Self, ProofError> {
        Ok(Self { a: data(a, "A")?, p: p.clone() })
    }

    /// All matrices between bounds, with one P.
    ///
    /// # Errors
    /// [`ProofError::NotFinite`] for a bound that is infinite.
    pub fn within(a: &Matrix<Interval>, p: &Matrix<f64>) -> Result<Self, ProofError> {
        Ok(Self { a: bounded(a, "A")?, p: p.clone() })
    }
}

impl Statement for HurwitzStability {
    const NAME: &'static str = "hurwitz";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        let mut facts = names.of(self).facts(["P > 0", "A'P + PA < 0"])?;
        let a = intervals(&self.a);
        if a.as_slice().iter().all(Interval::is_point) {
            facts
                .push(Fact::new("the largest real part of an eigenvalue < 0", hurwitz(&a.map(Interval::lo), &self.p)?));
        }
        Ok(facts)
    }

    fn sentence(&self, reading: &Reading<'_>, _margin: f64) -> Option<String> {
        let Represented::Distance { hypothesis, m } = reading.plant else { return None };
        data_contain(&self.a, m).then(|| {
            format!(
                "{}, the distance beta(y, chi) - phi(x) decays exponentially, and xhat = phi^L(beta(y, chi), y) is Lipschitz in it: the estimation error tends to 0.",
                capital(hypothesis)
            )
        })
    }

    fn words(&self) -> String {
        let n = self.a.rows();
        if are_points([&self.a]) {
            format!(
                "All eigenvalues of the {n} x {n} matrix A have negative real parts: every solution of x' = Ax tends to 0 exponentially."
            )
        } else {
            format!(
                "Every solution of x' = A(t)x with {n} states tends to 0 exponentially, however A(t) varies in its bounds; in particular all eigenvalues of every such A have negative real parts.{}",
                enclosed([&self.a], "")
            )
        }
    }
}

members! { HurwitzStability {
    { a = "A".square_data(); }
    "lyapunov" { p = "P".symmetric(a.rows()); }
} }
