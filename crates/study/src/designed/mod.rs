//! An observer as designed: ready to run, with its evidence.
//!
//! | file | subject |
//! |---|---|
//! | `running` | an observer that runs, of any kind |
//! | `filter` | a filter with a covariance, of any kind: its bands, and how consistent they are |

mod filter;
mod running;

pub(crate) use filter::Filter;
pub use running::{At, Runnable, Running, StepOf};
pub(crate) use running::{continuous, rows, sampled};

use luenberger_design::{Certificate, OptimalCubicDesign};

use luenberger_export::ExportableObserver;

use crate::results::{DesignReport, Statement};

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

/// Why there is no step, and what would have one.
pub type Refusal = (String, Vec<String>);

/// An observer of a nonlinear plant with a step for each sample.
#[derive(Debug, Clone)]
pub struct NonlinearStep {
    /// The observer.
    pub observer: ExportableObserver,
    /// The first estimate, where it is not that of the study.
    pub initial: Option<Vec<f64>>,
    /// The certificate of the statement, if the statement is proved: of the step as designed in discrete time, of the
    /// observer in continuous time otherwise.
    pub certificate: Option<Certificate>,
    /// What the design says of the error.
    pub statement: Statement,
    /// What else is to be known of the step.
    pub remark: &'static str,
    /// The error of its fixed steps, measured; empty where there are none.
    pub step_error: String,
}
