//! What a run of the claims and figures came to.

use crate::claim::{Class, Record};
use crate::evidence::{Standing, Verdict};
use crate::figure::Figure;
use crate::paper::LiveExample;
use std::path::PathBuf;
use std::time::Duration;

/// Summary of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Every claim.
    pub records: Vec<Record>,
    /// What failed: checks, figures and datasets that returned errors, refutations that show no ground, findings that
    /// no claim supports.
    pub failures: Vec<Failure>,
    /// The output folder.
    pub out: PathBuf,
    /// The duration of the run.
    pub elapsed: Duration,
}

/// Something that failed without stopping the run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    /// The claim, figure, dataset or finding.
    pub id: String,
    /// Why.
    pub error: String,
}

impl Summary {
    /// Number of claims with this verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.records.iter().filter(|record| record.verdict == Some(verdict)).count()
    }

    /// Number of claims of these classes with this verdict.
    pub fn count_of(&self, classes: &[Class], verdict: Verdict) -> usize {
        let counts = |record: &&Record| classes.contains(&record.class) && record.verdict == Some(verdict);
        self.records.iter().filter(counts).count()
    }

    /// Number of claims of these classes.
    pub fn of(&self, classes: &[Class]) -> usize {
        self.records.iter().filter(|record| classes.contains(&record.class)).count()
    }

    /// Number of theorems with this standing.
    pub fn theorems(&self, standing: Standing) -> usize {
        self.records.iter().filter(|record| record.standing == Some(standing)).count()
    }

    /// Whether every check and figure came to an end. A refuted claim is a success of the run.
    pub fn is_complete(&self) -> bool {
        self.failures.is_empty()
    }
}

/// An example that the page runs itself.
pub(crate) struct Live {
    pub(crate) example: LiveExample,
    /// Its block of the page.
    pub(crate) html: String,
}

/// A figure that was drawn.
pub(crate) struct Drawn {
    pub(crate) id: &'static str,
    pub(crate) paper: &'static str,
    pub(crate) figure: Figure,
}
