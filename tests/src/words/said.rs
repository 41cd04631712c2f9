//! What the tool says of one observer: the texts that are checked, apart from the design itself, so that a test can
//! put a lie in the place of a sentence.

use luenberger_proof::certificate::{Certificate, Theorem};
use luenberger_study::design::{Designed, NoObserver};
use luenberger_study::results::{DesignReport, NamedNumber};
use nalgebra::DMatrix;

use super::sentences::{ALTERNATIVES, EVIDENCE, HEADERS, REASONS, STATEMENTS, Sentence, split};

/// The certificate, in the words that a verdict has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sealed {
    pub is_proved: bool,
    pub is_refuted: bool,
    /// The ball of a cubic observer that does not converge from everywhere.
    pub ball: Option<f64>,
}

/// The texts of an observer.
#[derive(Debug, Clone, Default)]
pub struct Said {
    pub statement: String,
    pub verdict: String,
    pub evidence: Option<String>,
    pub numbers: Vec<NamedNumber>,
    pub sealed: Option<Sealed>,
    pub reason: Option<String>,
    pub alternatives: Vec<String>,
    pub hints: Vec<String>,
    /// The sentences of the header of exported code.
    pub header: Vec<String>,
}

impl Sealed {
    fn of(certificate: &Certificate) -> Self {
        let ball = certificate.theorems().iter().find_map(|proved| match proved.theorem() {
            Theorem::CubicConvergence(cubic) if cubic.ball().is_finite() => Some(cubic.ball()),
            _ => None,
        });
        Self {
            is_proved: certificate.is_proved(),
            is_refuted: certificate.facts().any(|fact| fact.verdict.is_refuted()),
            ball,
        }
    }
}

impl Said {
    /// What is said of a design, or of why there is none; nothing of one that was interrupted.
    pub fn of(designed: &Result<Designed, NoObserver>) -> Self {
        match designed {
            Ok(Designed { report, certificate, .. }) => Self::of_design(report, certificate.as_ref()),
            Err(none) if none.is_interrupted() => Self::default(),
            Err(none) => Self::of_refusal(none),
        }
    }

    fn of_design(report: &DesignReport, certificate: Option<&Certificate>) -> Self {
        Self {
            statement: report.statement.to_string(),
            verdict: report.verdict.word().to_owned(),
            evidence: report.evidence.clone(),
            numbers: report.numbers.clone(),
            sealed: certificate.map(Sealed::of),
            ..Self::default()
        }
    }

    fn of_refusal(failure: &NoObserver) -> Self {
        Self {
            reason: Some(failure.hypothesis.clone()),
            alternatives: failure.alternatives.iter().map(|alternative| alternative.words().to_owned()).collect(),
            hints: failure.hints.clone(),
            ..Self::default()
        }
    }

    /// The number of this name.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.numbers.iter().find(|number| number.name == name)?.value
    }

    pub fn statements(&self) -> Vec<Sentence> {
        split(&self.statement, &[STATEMENTS])
    }

    pub fn reasons(&self) -> Vec<Sentence> {
        whole(self.reason.iter(), &[REASONS])
    }

    /// All other sentences.
    pub fn others(&self) -> Vec<Sentence> {
        let mut all = whole(self.alternatives.iter().chain(&self.hints), &[ALTERNATIVES]);
        if let Some(evidence) = &self.evidence {
            all.extend(split(evidence, &[EVIDENCE]));
        }
        all
    }

    pub fn headers(&self) -> Vec<Sentence> {
        split(&self.header.join(" "), &[HEADERS, STATEMENTS])
    }
}

/// Each text as one sentence.
fn whole<'a>(texts: impl Iterator<Item = &'a String>, forms: &[&[super::sentences::Form]]) -> Vec<Sentence> {
    texts
        .flat_map(|text| {
            let found = split(text, forms);
            let is_whole = found.iter().all(|sentence| sentence.claim.is_some());
            if is_whole { found } else { vec![Sentence { text: text.clone(), claim: None, holes: Vec::new() }] }
        })
        .collect()
}

/// The matrix of this name in a report.
pub fn matrix(report: &DesignReport, name: &str) -> Option<DMatrix<f64>> {
    let rows = &report.matrices.iter().find(|matrix| matrix.name == name)?.rows;
    let columns = rows.first().map_or(0, Vec::len);
    Some(DMatrix::from_fn(rows.len(), columns, |i, j| rows[i][j]))
}
