//! An observer as designed: ready to run, with its evidence.

use luenberger_design::{Certificate, CubicDesign, LinearDesign, SampledIntervalDesign};

use crate::deployment::SampledDesign;
use crate::results::DesignReport;
use crate::runnable::Runnable;

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
    pub(crate) fn new(runnable: Runnable, report: DesignReport, certificate: Option<Certificate>) -> Self {
        Self { runnable, report, certificate, origin: Origin::Runnable }
    }

    pub(crate) fn with_continuous(self, linear: &LinearDesign, cubic: Option<&CubicDesign>) -> Self {
        let (linear, cubic) = (Box::new(linear.clone()), cubic.cloned().map(Box::new));
        Self { origin: Origin::Continuous { linear, cubic }, ..self }
    }

    /// Whether the statement of the design is proved, and not a certificate of a part of it alone.
    pub(crate) fn is_proved(&self) -> bool {
        self.certificate.is_some() && self.report.verdict.is_proved()
    }
}
