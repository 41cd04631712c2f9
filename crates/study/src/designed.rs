//! An observer as designed: ready to run, with its evidence.

use luenberger_design::{Certificate, OptimalCubicDesign};

use crate::results::DesignReport;
use crate::runnable::Runnable;

/// An observer with its evidence.
#[derive(Debug, Clone)]
pub struct Designed {
    /// The observer, ready to run.
    pub runnable: Runnable,
    /// Its design in numbers and words.
    pub report: DesignReport,
    /// The certificate of the design; none for observers with measured evidence or without evidence.
    pub certificate: Option<Certificate>,
    /// The result of the search of an optimal cubic observer, of which a sampled form is made without a second one.
    pub(crate) optimal: Option<Box<OptimalCubicDesign>>,
}

impl Designed {
    pub(crate) fn new(runnable: Runnable, report: DesignReport, certificate: Option<Certificate>) -> Self {
        Self { runnable, report, certificate, optimal: None }
    }
}
