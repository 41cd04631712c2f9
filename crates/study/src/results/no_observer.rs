//! Why a study does not have an observer, or its step on a target: one error, from the equation that fails to the
//! report.

use luenberger_design::kkl::ResidualWitness;
use luenberger_design::{DesignError, EnclosureError, KklError, LpvError, NumericalKklError};
use luenberger_export::kkl::KklExportError;
use luenberger_expression::{ExpressionPlantError, RecordingError};
use luenberger_linalg::LinalgError;
use luenberger_observers::ObserverError;
use luenberger_plants::PlantError;
use serde::Serialize;

use super::alternative::{Advice, Alternative, Proposal};

/// Why an observer has no design, or a design no step.
///
/// What fails is converted into it by `?`, with its numbers as the [`Cause`]. The words of a cause are those of its own
/// error until the design of a study ends, where they get the names of the study, with what to do instead.
#[derive(Debug, Clone, PartialEq, Serialize, thiserror::Error)]
#[error("{hypothesis}")]
pub struct NoObserver {
    /// The violated hypothesis, with its numbers.
    pub hypothesis: String,
    /// Observers that have a design on this plant, tried; empty if none is known.
    pub alternatives: Vec<Alternative>,
    /// What may help besides, and was not tried.
    pub hints: Vec<String>,
    /// Position of the observer in the file.
    pub line: usize,
    /// What failed, with its numbers; none for a hypothesis that a kind states in its own words.
    #[serde(skip)]
    pub cause: Option<Box<Cause>>,
    /// Alternatives to be tried.
    #[serde(skip)]
    pub(crate) proposals: Vec<Proposal>,
}

/// What failed.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Cause {
    /// The user interrupted, or the time was over.
    Interrupted,
    /// A design.
    Design(DesignError),
    /// The Jacobians of the plant have no bounds over the region.
    Enclosure(EnclosureError),
    /// A design for a polytope.
    Lpv(LpvError),
    /// The fit of a numerical KKL observer.
    NumericalKkl(NumericalKklError),
    /// The maps of a KKL observer.
    Kkl(KklError),
    /// The plant has no expressions of its own.
    Expressions(ExpressionPlantError),
    /// The body of an observer cannot be recorded.
    Recording(RecordingError),
    /// A numerical KKL observer has no step.
    KklExport(KklExportError),
    /// The design of a step, where that of the observer has succeeded.
    Step(Box<Cause>),
    /// A kind for continuous time, and a plant in discrete time.
    DiscreteTime {
        /// Its period.
        dt: f64,
    },
    /// A sampled observer with another period than its plant in discrete time.
    OtherPeriod {
        /// That of the observer.
        period: f64,
        /// That of the plant.
        dt: f64,
    },
    /// A kind for linear plants, and another plant.
    NotLinear,
    /// A kind for outputs of the state alone, and an output that depends on an input.
    Feedthrough {
        /// The output, from 0.
        output: usize,
    },
    /// phi^L does not take phi(x) back to x.
    NotLeftInverse {
        /// The state, from 0, whose error is the largest.
        state: usize,
        /// What phi^L gives for it.
        found: f64,
        /// x.
        point: Vec<f64>,
        /// t.
        time: f64,
        /// The error in half-widths of the region.
        missed: f64,
    },
    /// phi^L is not finite.
    UndefinedLeftInverse {
        /// x.
        point: Vec<f64>,
    },
    /// `D_chi beta` of an immersion and invariance observer loses rank.
    Rank {
        /// Rows of beta.
        needed: usize,
        /// Its least singular value.
        smallest: f64,
        /// x.
        point: Vec<f64>,
    },
    /// A regression that does not hold, with the worst point.
    NotRegression(ResidualWitness),
    /// A regression that the run of the study does not excite.
    NotExciting {
        /// The least eigenvalue of `int M'M` over the window.
        delta: f64,
        /// The length of the window.
        window: f64,
        /// Its start.
        from: f64,
        /// The direction of theta that is not seen.
        direction: Vec<f64>,
    },
}

impl NoObserver {
    /// A hypothesis that does not hold, in the words of its kind.
    pub fn new(hypothesis: impl Into<String>) -> Self {
        let (alternatives, hints, proposals) = (Vec::new(), Vec::new(), Vec::new());
        Self { hypothesis: hypothesis.into(), alternatives, hints, line: 0, cause: None, proposals }
    }

    /// Interrupted by the user, or by the end of its time.
    pub fn interrupted() -> Self {
        Self::new("interrupted").because(Cause::Interrupted)
    }

    /// Whether that is so.
    pub fn is_interrupted(&self) -> bool {
        self.cause.as_deref() == Some(&Cause::Interrupted)
    }

    /// With a hint.
    #[must_use]
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hints.push(hint.into());
        self
    }

    /// With what to do instead.
    #[must_use]
    pub fn advise(mut self, Advice { proposals, hints }: Advice) -> Self {
        self.proposals.extend(proposals);
        self.hints.extend(hints);
        self
    }

    /// With the cause, which `hypothesis` words.
    #[must_use]
    pub fn because(self, cause: Cause) -> Self {
        Self { cause: Some(Box::new(cause)), ..self }
    }

    /// Of the observer at this line of its file.
    #[must_use]
    pub fn at(self, line: usize) -> Self {
        Self { line, ..self }
    }

    /// Of a step, whose observer has a design.
    #[must_use]
    pub(crate) fn of_step(self) -> Self {
        Self { cause: self.cause.map(|cause| Box::new(Cause::Step(cause))), ..self }
    }

    /// The alternatives and the hints, one line each: `alternative: ..`, `hint: ..`.
    pub fn advice(&self) -> Vec<String> {
        let alternatives = self.alternatives.iter().map(|alternative| format!("alternative: {}", alternative.words()));
        alternatives.chain(self.hints.iter().map(|hint| format!("hint: {hint}"))).collect()
    }
}

/// Errors as causes, in their own words.
macro_rules! causes {
    ($($error:ty: $from:ident => $cause:expr,)*) => {
        $(impl From<$error> for NoObserver {
            fn from($from: $error) -> Self {
                Self::new($from.to_string()).because($cause)
            }
        })*
    };
}

causes! {
    DesignError: error => Cause::Design(error),
    LinalgError: error => Cause::Design(error.into()),
    PlantError: error => Cause::Design(error.into()),
    ObserverError: error => Cause::Design(error.into()),
    EnclosureError: error => Cause::Enclosure(error),
    ExpressionPlantError: error => Cause::Expressions(error),
    KklExportError: error => Cause::KklExport(error),
    LpvError: error => match error {
        LpvError::Design(error) => Cause::Design(error),
        LpvError::Enclosure(error) => Cause::Enclosure(error),
        error => Cause::Lpv(error),
    },
    KklError: error => match error {
        KklError::Design(error) => Cause::Design(error),
        KklError::Enclosure(error) => Cause::Enclosure(error),
        error => Cause::Kkl(error),
    },
}

impl From<NumericalKklError> for NoObserver {
    fn from(error: NumericalKklError) -> Self {
        let words = error.to_string();
        match error {
            NumericalKklError::Design(error) => error.into(),
            NumericalKklError::Stopped { .. } => Self::interrupted(),
            error => Self::new(words).because(Cause::NumericalKkl(error)),
        }
    }
}

impl From<RecordingError> for NoObserver {
    fn from(error: RecordingError) -> Self {
        Self::new(format!("the observer has no program: {error}")).because(Cause::Recording(error))
    }
}
