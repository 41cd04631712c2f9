//! The H-infinity filter: a bound of the gain in L2 from disturbances and noise to the errors that count.
//!
//! **Hypotheses.** `P > 0` and `[F'P + PF + H'H, PG; *, -gamma^2 I] < 0` for `F = A - LC`, `G = E - LD`; in discrete
//! time
//! `[F'PF - P + H'H, F'PG; *, G'PG - gamma^2 I] < 0`.
//!
//! **Theorem.** The error of `xhat' = A xhat + Bu + L(y - C xhat)` tends to 0 exponentially without w, and the transfer
//! function from w to `z = He` has an H-infinity norm below gamma.
//!
//! **Proof** (bounded real lemma). With `V = e'Pe` the quadratic form at (e, w) is `V' + |z|^2 - gamma^2 |w|^2` (`V(e+)
//! - V(e)` in place of V'), hence at most `-q (|w|^2 + |e|^2)` for some q > 0. For w = 0, V decreases, and F is stable.
//! Integrated from 0 to T with `V(T) >= 0`, the integral of `|z|^2` is at most V(0) plus `gamma^2 - q` times that of
//! `|w|^2`; for e(0) = 0 the L2 gain from w to z is below gamma.

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
pub struct HInfinityFilter(pub FilterProblem);

impl Statement for HInfinityFilter {
    const NAME: &'static str = "h-infinity-filter";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        let Self(of) = self;
        of.check()?;
        let inequality = match of.time {
            TimeDomain::Continuous => format!("[{}, P(E - LD); *, -gamma^2 I] < 0", of.decrease()),
            TimeDomain::Discrete => {
                format!("[{}, (A - LC)'P(E - LD); *, (E - LD)'P(E - LD) - gamma^2 I] < 0", of.decrease())
            }
        };
        names.of(of).facts(["P > 0", &inequality])
    }

    fn sentence(&self, reading: &Reading<'_>, _margin: f64) -> Option<String> {
        if !matches!(reading.plant, Represented::Itself) {
            return None;
        }
        let energy = match self.0.time {
            TimeDomain::Continuous => "the integral",
            TimeDomain::Discrete => "the sum",
        };
        Some(format!(
            "For every w {energy} of |H e|^2 is at most gamma^2 times that of |w|^2 plus e(0)'P e(0), gamma = {}. Without w the error tends to 0, for all x(0) and xhat(0).",
            at_most(self.0.gamma, 5)
        ))
    }

    fn words(&self) -> String {
        let energy = match self.0.time {
            TimeDomain::Continuous => "the integral of |z|^2 from 0 to any T",
            TimeDomain::Discrete => "the sum of |z|^2 from the first sample to any other",
        };
        format!(
            "{}: {energy} is at most e(0)'Pe(0) plus gamma^2 times that of |w|^2, for every w and e(0).",
            self.0.bounded("H-infinity")
        )
    }
}

impl Members for HInfinityFilter {
    fn read(file: &mut Fields<'_>, (): ()) -> Result<Self, FileError> {
        FilterProblem::read(file, ()).map(Self)
    }

    fn write(&self) -> Vec<(&'static str, Out)> {
        self.0.write()
    }
}
