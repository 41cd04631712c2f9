//! Why there is no export.

use luenberger_export::ExportError;
use thiserror::Error;

use crate::error::StudyError;
use crate::results::NoObserver;
use crate::study::ObserverSpec;

/// Why an observer of a study is not exported.
#[derive(Debug, Error)]
pub enum ExportRefusal {
    /// Options that do not go together.
    #[error("{0}")]
    Options(&'static str),
    /// A study without an observer.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// An observer that the study does not have.
    #[error("the study has no observer {name:?}; it has {known}")]
    UnknownObserver {
        /// The name.
        name: String,
        /// The names of the study.
        known: String,
    },
    /// Several observers, and none is chosen.
    #[error("the study has several observers: choose one with --observer NAME, of {known}")]
    SeveralObservers {
        /// The names of the study.
        known: String,
    },
    /// An observer without a step, or whose step is not stable in the format.
    #[error("{observer} cannot be exported: {}{}", why.hypothesis, lines(&why.advice()))]
    Design {
        /// The observer.
        observer: String,
        /// The violated hypothesis, alternatives and hints.
        why: Box<NoObserver>,
    },
    /// An observer without a stability certificate.
    #[error("{observer} cannot be exported: {why}\n  hint: --unproved exports it all the same, and the header says so")]
    Unproved {
        /// The observer.
        observer: String,
        /// What has no certificate.
        why: String,
    },
    /// Numbers or names that the target does not take.
    #[error("{observer} cannot be exported: {error}")]
    Numbers {
        /// The observer.
        observer: String,
        /// What the target does not take.
        error: Box<ExportError>,
    },
}

/// One line for each alternative and hint.
fn lines(advice: &[String]) -> String {
    advice.iter().fold(String::new(), |lines, text| lines + "\n  " + text)
}

impl ExportRefusal {
    pub(crate) fn design(observer: &ObserverSpec, why: NoObserver) -> Self {
        Self::Design { observer: observer.name.clone(), why: Box::new(why.at(observer.place.line)) }
    }

    pub(super) fn numbers(observer: &ObserverSpec, error: ExportError) -> Self {
        Self::Numbers { observer: observer.name.clone(), error: Box::new(error) }
    }

    /// The reason, without the name of the observer and without advice.
    pub(crate) fn reason(&self) -> String {
        match self {
            Self::Design { why, .. } => why.hypothesis.clone(),
            Self::Unproved { why, .. } => why.clone(),
            Self::Numbers { error, .. } => error.to_string(),
            other => other.to_string(),
        }
    }
}
