//! Steps that are recorded where they are written: the observer is made again over the scalar that records, by the same
//! constructor with its matrices by their names, and its body writes the program.

use luenberger_expression::{ExpressionPlant, Recorded, Recording, RecordingError, Routine, record};
use luenberger_observers::{
    DiscreteLinearObserver, MatrixName, ObserverDimensions, ObserverError, SampledNonlinearObserver, SampledObserver,
    StationaryKalmanFilter, VaryingPeriodStep,
};
use nalgebra::{DMatrix, DVector, Dyn};

use crate::Export;
use crate::error::ExportError;
use crate::exportable_observer::ExportableObserver;
use crate::extension::results;
use crate::matrix::ExportedMatrix;

/// Measured minus expected output, of the time, the state, the input and the measurement.
type Innovation =
    Box<dyn Fn(Recorded, &DVector<Recorded>, &DVector<Recorded>, &DVector<Recorded>) -> DVector<Recorded>>;

/// A matrix of the observer, by the name that it has in the emitted code.
fn named(recording: &mut Recording, which: MatrixName, m: &DMatrix<f64>) -> DMatrix<Recorded> {
    recording.matrix(ExportedMatrix::from(which).name(), m)
}

/// The program of the next state, a function of the state and of (u, y). None of an observer whose step is not recorded
/// as a whole.
///
/// # Errors
/// [`ExportError::Rounded`] is not expected of an observer that was made; [`ExportError::NoStep`].
pub(crate) fn step(export: &Export) -> Result<Option<Routine>, ExportError> {
    let format = export.scalar.name();
    let refused = |error: ObserverError| ExportError::Rounded { format, error };
    let program = match &export.observer {
        ExportableObserver::Linear(observer) if !export.is_filter() => record(|recording| {
            let same = observer.map::<_, Dyn, Dyn, Dyn>(|which, m| named(recording, which, m)).map_err(refused)?;
            Ok(next(recording, &same))
        })?,
        ExportableObserver::Cubic(observer) => record(|recording| {
            let same = observer.map::<_, Dyn, Dyn, Dyn>(|which, m| named(recording, which, m)).map_err(refused)?;
            Ok(next(recording, &same))
        })?,
        ExportableObserver::Discrete(observer) => observer.plant().record(|recording| {
            let plant = observer.plant().clone();
            let same =
                observer.map::<_, Dyn, Dyn, Dyn, _>(plant, |which, m| named(recording, which, m)).map_err(refused)?;
            Ok(next(recording, &same))
        })?,
        ExportableObserver::Step(observer) => Ok(observer.routines().0),
        _ => return Ok(None),
    };
    program.map(Some).map_err(|error| ExportError::NoStep { why: error.to_string(), format })
}

/// The programs of a stationary Kalman filter with the gain K of the update: the innovation, a function of the
/// prediction and of (u, y, innovation of the outputs that arrived before), the estimate with it, a function of the
/// prediction and the innovation, and the next prediction, a function of the prediction and of (u, innovation).
///
/// # Errors
/// As [`step`].
pub(crate) fn stationary(
    export: &Export,
    observer: &DiscreteLinearObserver<f64, Dyn, Dyn, Dyn>,
    k: &DMatrix<f64>,
) -> Result<[Routine; 3], ExportError> {
    let format = export.scalar.name();
    let ObserverDimensions { state, inputs, outputs, .. } = observer.dimensions();
    let programs = record(|recording| {
        let refused = |error| ExportError::Rounded { format, error };
        let same = observer.map::<_, Dyn, Dyn, Dyn>(|which, m| named(recording, which, m)).map_err(refused)?;
        let k = recording.matrix(ExportedMatrix::Update.name(), k);
        let same = StationaryKalmanFilter::new(same, k).map_err(refused)?;
        let column = DVector::<Recorded>::from_column_slice;
        let innovation = recording.program((state, inputs + 2 * outputs), |_, x, known| {
            let (u, rest) = known.split_at(inputs);
            let (y, before) = rest.split_at(outputs);
            same.joined_innovation(&column(before), &column(x), &column(u), &column(y)).as_slice().to_vec()
        });
        let filtered =
            recording.program((state, outputs), |_, x, z| same.update(&column(x), &column(z)).as_slice().to_vec());
        let predicted = recording.program((state, inputs + outputs), |_, x, known| {
            let (u, z) = known.split_at(inputs);
            let mut next = column(x);
            same.predict(&mut next, &column(u), &column(z));
            next.as_slice().to_vec()
        });
        Ok([innovation, filtered, predicted])
    })?;
    let [innovation, filtered, predicted] =
        programs.map(|program| program.map_err(|error| ExportError::NoStep { why: error.to_string(), format }));
    Ok([innovation?, filtered?, predicted?])
}

/// The program of the slopes of the estimate and of the predicted output, functions of both and of u.
///
/// # Errors
/// As [`step`].
pub(crate) fn slope(
    export: &Export,
    observer: &SampledNonlinearObserver<ExpressionPlant, f64, Dyn, Dyn, Dyn>,
) -> Result<Routine, ExportError> {
    let format = export.scalar.name();
    let size = observer.dimensions();
    let program = observer.plant().record(|recording| {
        let same = observer
            .map::<_, Dyn, Dyn, Dyn, _>(observer.plant().clone(), |which, m| named(recording, which, m))
            .map_err(|error| ExportError::Rounded { format, error })?;
        Ok(recording.program((size.state + size.outputs, size.inputs), |t, z, u| {
            let (x, w) = z.split_at(size.state);
            let (x, w) = (DVector::from_column_slice(x), DVector::from_column_slice(w));
            let (x, w) = same.slope(t, &x, &w, &DVector::from_column_slice(u));
            x.iter().chain(w.iter()).copied().collect()
        }))
    })?;
    program.map_err(|error| ExportError::NoStep { why: error.to_string(), format })
}

/// The programs of an observer at varying periods: the first term of the series of a prediction, a function of the
/// state and of (u, tau, degree), a further one, and the state after a correction, a function of (u, y).
///
/// # Errors
/// As [`step`].
pub(crate) fn varying(
    export: &Export,
    step: &VaryingPeriodStep<f64, Dyn, Dyn, Dyn>,
) -> Result<[Routine; 3], ExportError> {
    let format = export.scalar.name();
    let ObserverDimensions { state, inputs, outputs, .. } = step.dimensions();
    let programs = record(|recording| {
        // The nominal step has matrices of its own, which no program uses.
        let numbers = |which, m: &DMatrix<f64>| match which {
            MatrixName::Ad | MatrixName::Bd | MatrixName::Ld => m.map(nalgebra::convert),
            _ => named(recording, which, m),
        };
        let refused = |error| ExportError::Rounded { format, error };
        let same = step.observer().map::<_, Dyn, Dyn, Dyn>(numbers).map_err(refused)?;
        let column = DVector::<Recorded>::from_column_slice;
        let mut term = |is_first: bool| {
            recording.program((state, inputs + 2), |_, x, known| {
                let (u, last) = known.split_at(inputs);
                let mut next = x.to_vec();
                same.term(x, is_first.then_some(u), (last[0], last[1]), &mut next);
                next
            })
        };
        let (first, further) = (term(true), term(false));
        let corrected = recording.program((state, inputs + outputs), |_, x, known| {
            let (u, y) = known.split_at(inputs);
            let (mut xhat, elapsed) = (column(x), u[inputs - 1]);
            same.correct(&mut xhat, &column(u), &column(y), elapsed);
            xhat.as_slice().to_vec()
        });
        Ok([first, further, corrected])
    })?;
    let [first, further, corrected] =
        programs.map(|program| program.map_err(|error| ExportError::NoStep { why: error.to_string(), format }));
    Ok([first?, further?, corrected?])
}

/// The program of the measured minus the expected output, a function of the state and of (u, y).
///
/// # Errors
/// As [`step`].
pub(crate) fn innovation(export: &Export) -> Result<Routine, ExportError> {
    let format = export.scalar.name();
    let size = export.observer.dimensions();
    let inputs = size.inputs;
    let known = (size.estimate, inputs + size.outputs);
    let column = DVector::<Recorded>::from_column_slice;
    let refused = |error: ObserverError| ExportError::Rounded { format, error };
    let program = record(|recording| {
        let of: Innovation = match (&export.observer, export.observer.routines()) {
            (ExportableObserver::Linear(observer), _) => {
                let same = observer.map(|which, m| named(recording, which, m)).map_err(refused)?;
                Box::new(move |_, x, u, y| same.innovation(x, u, y))
            }
            (ExportableObserver::Cubic(observer), _) => {
                let same = observer.map(|which, m| named(recording, which, m)).map_err(refused)?;
                Box::new(move |_, x, u, y| same.innovation(x, u, y))
            }
            (_, routines) => Box::new(move |t, x, u, y| {
                let expected = routines
                    .iter()
                    .flat_map(|routines| results(&routines.h, t, x.as_slice(), u.as_slice()).as_slice().to_vec());
                DVector::from_vec(y.iter().zip(expected).map(|(y, expected)| *y - expected).collect())
            }),
        };
        Ok(recording.program(known, |t, x, known| {
            let (u, y) = known.split_at(inputs);
            of(t, &column(x), &column(u), &column(y)).as_slice().to_vec()
        }))
    })?;
    program.map_err(|error| ExportError::NoStep { why: error.to_string(), format })
}

/// The state after a step.
fn next<O>(recording: &mut Recording, observer: &O) -> Result<Routine, RecordingError>
where
    O: SampledObserver<Recorded, State = DVector<Recorded>, Input = DVector<Recorded>, Output = DVector<Recorded>>,
{
    let size = observer.dimensions();
    recording.program((size.state, size.inputs + size.outputs), |t, x, known| {
        let (u, y) = known.split_at(size.inputs);
        let (u, y) = (DVector::from_column_slice(u), DVector::from_column_slice(y));
        let mut state = DVector::from_column_slice(x);
        observer.step(t, &mut state, &u, &y);
        state.as_slice().to_vec()
    })
}
