//! Observers as programs: each is made again over the scalar that records, with the same constructor and the same
//! numbers, and its body writes the program.

use luenberger_export::extension::RecordedObserver;
use luenberger_expression::{Recorded, Recording};
use luenberger_observers::Observer;
use nalgebra::{DMatrix, DVector, convert};

use crate::results::NoObserver;

/// A matrix of constants.
pub(crate) fn cast(m: &DMatrix<f64>) -> DMatrix<Recorded> {
    m.map(convert)
}

/// The program of an observer.
pub(crate) fn recorded<O>(recording: &mut Recording, observer: &O) -> Result<RecordedObserver, NoObserver>
where
    O: Observer<Recorded, Input = DVector<Recorded>, Output = DVector<Recorded>, Estimate = DVector<Recorded>>,
{
    Ok(RecordedObserver::new(recording, observer)?)
}
