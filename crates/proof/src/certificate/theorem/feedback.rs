//! The cubic observer inside the loop `u = -K xhat`.
//!
//! **Hypotheses.** Those of the [`CubicConvergence`], `P1 > 0`, and `[He((A - BK)'P1), P1 B K; *, He((A - LC)'P)] < 0`
//! (25).
//!
//! **Theorem.** x and e tend to 0 exponentially from every x(0) and the e(0) of the observer. With the real matrix
//! `-P^-1 C'S` in place of N, `x'P1x + e'Pe` decreases, from every e(0).
//!
//! **Proof.** With that real gain the cubic term adds nothing positive to `(x'P1x + e'Pe)'`, whose quadratic part is
//! (25) (Theorem 6 and Corollary 1 with (13')). With N as stored e does not depend on x and tends to 0 exponentially;
//! `x' = (A - BK)x + BK e`, and the first diagonal block of (25) with `P1 > 0` makes `A - BK` Hurwitz.

use super::super::fields::Fields;
use super::super::members::Members;
use super::super::sentence::Reading;
use super::super::write::{Out, Written};
use super::{CubicConvergence, Fact, FileError, Names, Statement};
use crate::error::ProofError;
use crate::matrix::Matrix;

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct FeedbackLoop {
    /// The plant and its observer.
    pub observer: CubicConvergence,
    /// The feedback gain K, m x n.
    pub k: Matrix<f64>,
    /// P1, n x n.
    pub p1: Matrix<f64>,
}

impl Statement for FeedbackLoop {
    const NAME: &'static str = "feedback-loop";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        let o = &self.observer;
        let mut facts = o.facts(names.clone())?;
        let names = names.of(o).matrix("K", &self.k).symmetric("P1", &self.p1);
        let block = "[(A - BK)'P1 + P1(A - BK), P1 B K; *, (A - LC)'P + P(A - LC)] < 0 (25)";
        facts.extend(names.facts(["P1 > 0", block])?);
        Ok(facts)
    }

    fn sentence(&self, _: &Reading<'_>, _: f64) -> Option<String> {
        let from = match self.observer.within("e") {
            all if all.is_empty() => "xhat(0)".to_owned(),
            region => format!("every initial error{region}"),
        };
        Some(format!(
            "In the loop u = r - K xhat with the gains as stored and r = 0: x and xhat tend to 0 exponentially, from every x(0) and {from}."
        ))
    }

    fn words(&self) -> String {
        format!(
            "{} In the loop u = -K xhat, x and e tend to 0 exponentially from every x(0), with the gains K, L and N exactly as stored {}; with the real matrix -P^-1 C'S in place of N, x'P1x + e'Pe decreases, from every e(0).",
            self.observer.words(),
            self.observer.from()
        )
    }
}

impl Members for FeedbackLoop {
    fn read(file: &mut Fields<'_>, (): ()) -> Result<Self, FileError> {
        let observer = CubicConvergence::read(file, ())?;
        let (n, m) = observer.plant.b.shape();
        let (k, p1) = file.object("feedback", |feedback| {
            let k = feedback.take("K")?;
            let k = if m == 0 { k.any_matrix()? } else { k.matrix((m, n))? };
            Ok((k, feedback.take("P1")?.symmetric(n)?))
        })?;
        Ok(Self { observer, k, p1 })
    }

    fn write(&self) -> Vec<(&'static str, Out)> {
        let mut members = self.observer.write();
        members.push(("feedback", Out::Object(vec![("K", self.k.out()), ("P1", self.p1.out())])));
        members
    }
}
