//! Observers as programs: each is made again over the scalar that records, with the same constructor and the same
//! numbers, and its body writes the program.

use luenberger_export::ExportableObserver;
use luenberger_export::extension::RecordedObserver;
use luenberger_export::step::RecordedStep;
use luenberger_expression::{Recorded, Recording};
use luenberger_observers::{Observer, ObserverDimensions, ObserverError};
use luenberger_plants::Column;
use nalgebra::{DMatrix, DVector, convert};

use crate::designed::{NonlinearStep, StepOf};
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

/// The step of an observer in discrete time with the equations of the one that `make` makes: its state is the estimate
/// at the sample, with z+ behind it. `start` has it at the start, with the names; `predicted` gives the outputs of an
/// estimate, around which test vectors are drawn.
pub(crate) fn step_at_samples<O>(
    of: &StepOf<'_>,
    make: impl FnOnce() -> Result<O, ObserverError>,
    (names, start): (Vec<String>, Vec<f64>),
    predicted: impl Fn(&[Recorded]) -> Vec<Recorded>,
) -> Result<NonlinearStep, NoObserver>
where
    O: Observer<Recorded, Input = DVector<Recorded>, Output = DVector<Recorded>, Estimate = DVector<Recorded>>,
{
    let program = of.plant.record(|recording| {
        let same = make()?;
        let own = same.dimensions();
        let count = own.estimate;
        let all = own.state + count;
        let step = |t, state: &[Recorded], u: &[Recorded], y: &[Recorded]| {
            let (u, y) = (DVector::from_column_slice(u), DVector::from_column_slice(y));
            let z = O::State::from_slice(&state[count..]);
            let (xhat, next) = (same.estimate(t, &z, &u, &y), same.derivative(t, &z, &u, &y));
            xhat.iter().chain(next.as_slice()).copied().collect()
        };
        let size = ObserverDimensions { state: all, estimate: all, ..own };
        let recorded = RecordedStep::new(recording, size, of.period, step, |_, state| predicted(&state[..count]));
        Ok::<_, NoObserver>(recorded?)
    })?;
    let step = NonlinearStep::of(of.designed, ExportableObserver::Step(program.of_sample()));
    Ok(NonlinearStep { initial: Some(start), names: Some(names), ..step })
}
