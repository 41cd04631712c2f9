//! An observer as designed: ready to run, with its evidence.

use luenberger_design::{Certificate, OptimalCubicDesign};

use crate::kinds::Runnable;
use crate::results::DesignReport;

/// An observer with its evidence.
#[derive(Debug, Clone)]
pub struct Designed {
    /// The observer, ready to run.
    pub runnable: Runnable,
    /// Its design in numbers and words.
    pub report: DesignReport,
    /// What is certified; none for observers without a theorem. Where the verdict is measured it is a part of what the
    /// design rests on, such as the stability of a matrix.
    pub certificate: Option<Certificate>,
    /// The result of the search of an optimal cubic observer, of which a sampled form is made without a second one.
    pub(crate) optimal: Option<Box<OptimalCubicDesign>>,
}

impl Designed {
    /// An observer with its evidence.
    pub fn new(runnable: Runnable, report: DesignReport, certificate: Option<Certificate>) -> Self {
        Self { runnable, report, certificate, optimal: None }
    }

    /// Whether the statement of the design is proved, and not a certificate of a part of it alone.
    pub(crate) fn is_proved(&self) -> bool {
        self.certificate.is_some() && self.report.verdict.is_proved()
    }
}
