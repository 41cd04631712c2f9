//! Observers as programs: each is made again over the scalar that records, with the same constructor and the same
//! numbers, and its body writes the program.

use luenberger_export::extension::RecordedObserver;
use luenberger_expression::{Recorded, Recording, RecordingError};
use luenberger_observers::{Observer, ObserverError};
use nalgebra::{DMatrix, DVector, convert};

use crate::designed::Refusal;

/// A matrix of constants.
pub(crate) fn cast(m: &DMatrix<f64>) -> DMatrix<Recorded> {
    m.map(convert)
}

/// The program of an observer.
pub(crate) fn recorded<O>(recording: &mut Recording, observer: &O) -> Result<RecordedObserver, Refusal>
where
    O: Observer<Recorded, Input = DVector<Recorded>, Output = DVector<Recorded>, Estimate = DVector<Recorded>>,
{
    RecordedObserver::new(recording, observer).map_err(|error| no_program(&error))
}

/// Why a body has no program.
pub(crate) fn no_program(error: &RecordingError) -> Refusal {
    (format!("the observer has no program: {error}"), Vec::new())
}

/// Why an observer cannot be made again.
pub(crate) fn refused(error: ObserverError) -> Refusal {
    (error.to_string(), Vec::new())
}
