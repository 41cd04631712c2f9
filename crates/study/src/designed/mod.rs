//! An observer as designed: ready to run, with its evidence.
//!
//! | file | subject |
//! |---|---|
//! | `running` | an observer that runs, of any kind |
//! | `stepped` | a filter that is stepped sample by sample without a program |
//! | `adapted` | filters with noises that depend on their estimates or are correlated, and with bounds |
//! | `filter` | a filter with a covariance, of any kind: its bands, and how consistent they are |

mod adapted;
mod filter;
mod running;
mod stepped;

pub use adapted::{Along, RowVariances};
pub(crate) use adapted::{Intensity, ProcessNoise, adapted, correlated, decorrelated, with_variances};
pub(crate) use filter::Filter;
pub use filter::Innovation;
pub use running::{At, LinearForm, Runnable, Running, StepOf};
pub(crate) use running::{continuous, rows, runs_as_filter, sampled};
pub use stepped::SteppedFilter;

use luenberger_design::{
    Certificate, CubicDesign, DiscreteDesign, LinearDesign, SampledCubicDesign, SampledIntervalDesign,
    VaryingPeriodDesign,
};

use luenberger_export::ExportableObserver;

use crate::results::{DesignReport, NoObserver, Statement};

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
    /// What a sampled form is made of, without a second design.
    pub(crate) origin: Origin,
}

/// What the sampled form of a design is made of.
#[derive(Debug, Clone)]
pub(crate) enum Origin {
    /// The observer as it runs.
    Runnable,
    /// The designs of a linear plant, or of the linearisation, in continuous time.
    Continuous { linear: Box<LinearDesign>, cubic: Option<Box<CubicDesign>> },
    /// A sampled design.
    Sampled(SampledDesign),
    /// The interval observer of a plant in discrete time, in binary64.
    Interval(Box<SampledIntervalDesign>),
}

impl Designed {
    /// An observer with its evidence.
    pub fn new(runnable: Runnable, report: DesignReport, certificate: Option<Certificate>) -> Self {
        Self { runnable, report, certificate, origin: Origin::Runnable }
    }

    pub(crate) fn with_continuous(self, linear: &LinearDesign, cubic: Option<&CubicDesign>) -> Self {
        let (linear, cubic) = (Box::new(linear.clone()), cubic.cloned().map(Box::new));
        Self { origin: Origin::Continuous { linear, cubic }, ..self }
    }

    /// The linear design in continuous time that it is made of.
    pub(crate) fn linear(&self) -> Option<&LinearDesign> {
        if let Origin::Continuous { linear, .. } = &self.origin { Some(linear) } else { None }
    }

    /// The cubic design in continuous time that it is made of.
    pub(crate) fn cubic(&self) -> Option<&CubicDesign> {
        if let Origin::Continuous { cubic, .. } = &self.origin { cubic.as_deref() } else { None }
    }

    /// The sampled design that it is.
    pub(crate) fn sampled(&self) -> Option<&SampledDesign> {
        if let Origin::Sampled(design) = &self.origin { Some(design) } else { None }
    }

    /// Whether the statement of the design is proved, and not a certificate of a part of it alone.
    pub(crate) fn is_proved(&self) -> bool {
        self.certificate.is_some() && self.report.verdict.is_proved()
    }
}

/// An observer of a nonlinear plant with a step for each sample.
#[derive(Debug, Clone)]
pub struct NonlinearStep {
    /// The observer.
    pub observer: ExportableObserver,
    /// The first estimate, where it is not that of the study.
    pub initial: Option<Vec<f64>>,
    /// The names of its states, where they are not those of the plant.
    pub names: Option<Vec<String>>,
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

/// A sampled design with its certificate.
#[derive(Debug, Clone)]
pub enum SampledDesign {
    /// Linear.
    Linear(Box<DiscreteDesign>),
    /// Cubic.
    Cubic(Box<SampledCubicDesign>),
    /// Cubic, at varying periods.
    Varying(Box<VaryingPeriodDesign>),
    /// Of a nonlinear plant.
    Nonlinear(Box<NonlinearStep>),
    /// The interval observer.
    Interval(Box<IntervalDeployment>),
}

/// The designs for both formats: the entries that cover rounding depend on it.
#[derive(Debug, Clone)]
pub struct IntervalDeployment {
    pub(crate) binary32: Result<SampledIntervalDesign, NoObserver>,
    pub(crate) binary64: SampledIntervalDesign,
}
