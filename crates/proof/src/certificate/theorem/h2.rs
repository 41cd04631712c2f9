//! The H2 filter: a bound of the variance that white noise leaves in the errors that count.
//!
//! **Hypotheses.** `P > 0`, `F'P + PF + H'H < 0` and `tr G'PG < gamma^2` for `F = A - LC`, `G = E - LD`; in discrete
//! time
//! `F'PF - P + H'H < 0` in place of the second.
//!
//! **Theorem.** The error of `xhat' = A xhat + Bu + L(y - C xhat)` tends to 0 exponentially without w, and the transfer
//! function from w to `z = He` has an H2 norm below gamma.
//!
//! **Proof.** F is stable, and P >= W, the observability Gramian, which solves the equation: `|T|_2^2 = tr G'WG <= tr
//! G'PG`. This is the stationary variance of z for white noise w of unit intensity (unit covariance).

use super::super::fields::Fields;
use super::super::members::Members;
use super::super::sentence::{Reading, Represented};
use super::super::write::Out;
use super::{Fact, FileError, FilterProblem, Names, Statement};
use crate::error::ProofError;
use crate::statement::TimeDomain;
use crate::wording::at_most;

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct H2Filter(pub FilterProblem);

impl Statement for H2Filter {
    const NAME: &'static str = "h2-filter";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        let Self(of) = self;
        of.check()?;
        names.of(of).facts(["P > 0", &format!("{} < 0", of.decrease()), "tr (E - LD)'P(E - LD) < gamma^2"])
    }

    fn sentence(&self, reading: &Reading<'_>, _margin: f64) -> Option<String> {
        if !matches!(reading.plant, Represented::Itself) {
            return None;
        }
        let noise = match self.0.time {
            TimeDomain::Continuous => "intensity",
            TimeDomain::Discrete => "covariance",
        };
        Some(format!(
            "White noise w of unit {noise} leaves H e with variances whose sum is below gamma^2 in the end, gamma = {}. Without w the error tends to 0, for all x(0) and xhat(0).",
            at_most(self.0.gamma, 5)
        ))
    }

    fn words(&self) -> String {
        let noise = match self.0.time {
            TimeDomain::Continuous => "intensity",
            TimeDomain::Discrete => "covariance",
        };
        format!(
            "{}: under white noise w of unit {noise} the sum of the variances of the entries of z is below gamma^2 in the end.",
            self.0.bounded("H2")
        )
    }
}

impl Members for H2Filter {
    fn read(file: &mut Fields<'_>, (): ()) -> Result<Self, FileError> {
        FilterProblem::read(file, ()).map(Self)
    }

    fn write(&self) -> Vec<(&'static str, Out)> {
        self.0.write()
    }
}
