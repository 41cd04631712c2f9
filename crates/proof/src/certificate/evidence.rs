//! Verification results of the theorems of a design, computed once and stored with their data.

use core::fmt;

use super::{CertificateFile, Claim, Fact, Region, Rejection, Theorem};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::number::Number;
use crate::verdict::{UndecidedReason, Verdict};

/// A theorem with its data, all of whose inequalities are proved. It can only be constructed by the proof, and is
/// immutable.
#[derive(Debug, Clone, PartialEq)]
pub struct ProvedTheorem {
    theorem: Theorem,
    facts: Vec<Fact>,
}

/// A theorem with its data, at least one of whose inequalities is not proved.
#[derive(Debug, Clone, PartialEq)]
pub struct UnprovedTheorem {
    theorem: Theorem,
    facts: Vec<Fact>,
}

/// The part of a margin that a file does not claim. A program whose sums are in another order, or whose bounds of
/// rounding errors are a little larger, finds another margin for the same numbers, and still accepts the file.
const ROOM: f64 = 1.0 / (1 << 20) as f64;

/// The margin that a file claims of one that is proved.
fn claimed(margin: f64) -> f64 {
    // The product is exact, but for the smallest numbers.
    (margin - ROOM * margin).next_down().max(0.0)
}

/// The theorems that a design claims, each verified as proved or not proved.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Certificate {
    proved: Vec<ProvedTheorem>,
    unproved: Vec<UnprovedTheorem>,
}

/// A design with a certificate.
pub trait Certified {
    /// The certificate: its proved and unproved theorems.
    fn certificate(&self) -> &Certificate;

    /// The theorems that are proved of it, the most comprehensive first; empty where none is.
    fn theorems(&self) -> &[ProvedTheorem] {
        self.certificate().theorems()
    }

    /// The first theorem as a certificate file, which `luenberger-verify` checks without this program.
    ///
    /// # Errors
    /// [`Rejection::NotProved`] names the inequality that is not proved; [`Rejection::File`] for data beyond the limits
    /// of a file, [`Rejection::Nothing`] for a design that claims nothing.
    fn certificate_file(&self, title: &str) -> Result<CertificateFile, Rejection> {
        self.certificate().file(title)
    }
}

impl ProvedTheorem {
    /// The theorem.
    pub fn theorem(&self) -> &Theorem {
        &self.theorem
    }

    /// Its inequalities, each proved, with its margin.
    pub fn facts(&self) -> &[Fact] {
        &self.facts
    }

    /// What is proved, in words generated from the data.
    pub fn words(&self) -> String {
        self.theorem.words()
    }

    /// The certificate file, with the margins that were proved, less 2^-20 of each.
    ///
    /// # Errors
    /// [`Rejection::File`] for data beyond the limits of a file.
    pub fn file(&self, title: &str) -> Result<CertificateFile, Rejection> {
        let mut claims = Vec::with_capacity(self.facts.len());
        for Fact { inequality, verdict, .. } in &self.facts {
            let Some(margin) = verdict.margin().map(claimed).and_then(Number::from_f64) else {
                let (inequality, verdict) = (inequality.clone(), Box::new(verdict.clone()));
                return Err(Rejection::NotProved { inequality, verdict });
            };
            claims.push(Claim { inequality: inequality.clone(), margin });
        }
        Ok(CertificateFile::written(title, &self.theorem, &claims)?)
    }
}

impl UnprovedTheorem {
    /// The theorem.
    pub fn theorem(&self) -> &Theorem {
        &self.theorem
    }

    /// Its inequalities, each with its verdict.
    pub fn facts(&self) -> &[Fact] {
        &self.facts
    }

    /// The first inequality that is not proved.
    fn rejection(&self) -> Rejection {
        match self.facts.iter().find(|fact| !fact.verdict.is_proved()) {
            Some(Fact { inequality, verdict, .. }) => {
                Rejection::NotProved { inequality: inequality.clone(), verdict: Box::new(verdict.clone()) }
            }
            None => Rejection::Nothing,
        }
    }
}

impl Certificate {
    /// Verifies these theorems.
    ///
    /// # Errors
    /// [`ProofError`] for shapes that do not fit and entries that are not finite.
    pub fn of<T: Into<Theorem>>(theorems: impl IntoIterator<Item = T>) -> Result<Self, ProofError> {
        let mut certificate = Self::default();
        for theorem in theorems {
            let theorem = theorem.into();
            let facts = theorem.facts()?;
            certificate.add(theorem, facts);
        }
        Ok(certificate)
    }

    /// Verifies a theorem about the Jacobians of a plant that lie between the bounds `a` (n x n) and `c` (p x n). It is
    /// proved only if its data [contain](Theorem::contains_jacobians) all of them.
    ///
    /// # Errors
    /// As [`of`](Self::of).
    pub fn of_jacobians(
        theorem: impl Into<Theorem>,
        a: &Matrix<Interval>,
        c: &Matrix<Interval>,
    ) -> Result<Self, ProofError> {
        let theorem = theorem.into();
        let mut facts = theorem.facts()?;
        if !theorem.contains_jacobians(a, c) {
            let undecided = Verdict::Undecided { why: UndecidedReason::OutsideTheData, best: f64::NAN };
            facts.push(Fact::stated("every Jacobian between the bounds is one of the theorem", undecided));
        }
        let mut certificate = Self::default();
        certificate.add(theorem, facts);
        Ok(certificate)
    }

    pub(super) fn add(&mut self, theorem: Theorem, facts: Vec<Fact>) {
        if !facts.is_empty() && facts.iter().all(|fact| fact.verdict.is_proved()) {
            self.proved.push(ProvedTheorem { theorem, facts });
        } else {
            self.unproved.push(UnprovedTheorem { theorem, facts });
        }
    }

    /// The theorems of both, those of this one first.
    #[must_use]
    pub fn and(mut self, other: Self) -> Self {
        self.proved.extend(other.proved);
        self.unproved.extend(other.unproved);
        self
    }

    /// The theorems that are proved.
    pub fn theorems(&self) -> &[ProvedTheorem] {
        &self.proved
    }

    /// The theorems that are not proved, with the verdicts of their inequalities.
    pub fn unproved(&self) -> &[UnprovedTheorem] {
        &self.unproved
    }

    /// Whether every theorem is proved, and there is one.
    pub fn is_proved(&self) -> bool {
        self.unproved.is_empty() && !self.proved.is_empty()
    }

    /// Whether a cubic observer with its gains exactly as stored is proved to converge from every error.
    pub fn converges_from_everywhere(&self) -> bool {
        self.proved.iter().any(|proved| match &proved.theorem {
            Theorem::CubicConvergence(observer) => observer.region == Region::Everywhere,
            #[cfg(feature = "all-theorems")]
            Theorem::FeedbackLoop(theorem) => theorem.observer.region == Region::Everywhere,
            Theorem::SampledCubicConvergence(_) | Theorem::SemiImplicitCubicConvergence(_) => true,
            #[cfg(feature = "all-theorems")]
            Theorem::CubicTheorem1(_) | Theorem::VaryingPeriodConvergence(_) => true,
            _ => false,
        })
    }

    /// The inequalities of all theorems, those of the proved ones first.
    pub fn facts(&self) -> impl Iterator<Item = &Fact> {
        let unproved = self.unproved.iter().flat_map(|theorem| &theorem.facts);
        self.proved.iter().flat_map(|theorem| &theorem.facts).chain(unproved)
    }

    /// The first theorem as a certificate file.
    ///
    /// # Errors
    /// As [`Certified::certificate_file`].
    pub fn file(&self, title: &str) -> Result<CertificateFile, Rejection> {
        match (self.unproved.first(), self.proved.first()) {
            (Some(unproved), _) => Err(unproved.rejection()),
            (None, Some(proved)) => proved.file(title),
            (None, None) => Err(Rejection::Nothing),
        }
    }
}

impl fmt::Display for Certificate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for fact in self.facts() {
            writeln!(f, "{:<9}  {fact}", fact.verdict.word())?;
        }
        Ok(())
    }
}
