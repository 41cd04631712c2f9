//! One observer: its design, its runs, its step, its files.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use luenberger_export::golden;
use luenberger_plants::Plant;
use luenberger_study::deployment::{ExportOptions, ExportRefusal, export, program};
use luenberger_study::design::{Designed, design_until};
use luenberger_study::model::Model;
use luenberger_study::{Study, replay_designed, simulate_designed};
use nalgebra::DVector;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat, PyList, PyTuple};

use crate::array::{Matrix, Vector, array, list, matrix, vector};
use crate::certificate::Certificate;
use crate::error::{self, dictionary};
use crate::export::{Request, files, refused};
use crate::run::{read, study_error, trajectory};
use crate::work::interruptible;

/// An observer with its design; the only one of its study.
#[pyclass(frozen, module = "luenberger._luenberger")]
pub(crate) struct Design {
    study: Arc<Study>,
    designed: Arc<Designed>,
}

/// Rows of an array whose columns are samples.
fn samples(array: &Matrix<'_>) -> Vec<Vec<f64>> {
    matrix(array).column_iter().map(|column| column.iter().copied().collect()).collect()
}

impl Design {
    fn vectors(&self, py: Python<'_>, u: &Vector<'_>, y: &Vector<'_>) -> PyResult<(Vec<f64>, Vec<f64>)> {
        let size = self.designed.runnable.dimensions();
        let (u, y) = (vector(u), vector(y));
        for (what, expected, found) in [("u", size.inputs, u.len()), ("y", size.outputs, y.len())] {
            if expected != found {
                let numbers = dictionary!(py; what, expected = (expected,), found = (found,));
                let message = format!("{what} must have {expected} entries, and has {found}");
                return Err(error::raise(py, "DimensionMismatch", message, &numbers));
            }
        }
        Ok((u.as_slice().to_vec(), y.as_slice().to_vec()))
    }
}

#[pymethods]
impl Design {
    /// Designs the observer of a study with one observer.
    #[new]
    #[pyo3(signature = (study, folder, /))]
    fn new(py: Python<'_>, study: &str, folder: PathBuf) -> PyResult<Self> {
        let study = Arc::new(read(py, study, &folder)?);
        let shared = Arc::clone(&study);
        let designed = interruptible(py, None, move |context| {
            shared.observers.first().map(|observer| design_until(&shared, observer, context.cancel, None))
        })?;
        match designed {
            Some(Ok(designed)) => Ok(Self { study, designed: Arc::new(designed) }),
            Some(Err(none)) if none.is_interrupted() => Err(error::plain(py, "Cancelled", "the design was ended")),
            Some(Err(none)) => Err(error::design(py, &none)),
            None => Err(error::plain(py, "InvalidArgument", "the study has no observer")),
        }
    }

    /// The design in numbers and words, as JSON.
    fn report(&self, py: Python<'_>) -> PyResult<String> {
        serde_json::to_string(&self.designed.report).map_err(|why| error::plain(py, "StudyError", why))
    }

    /// Kind, name, names of the columns, numbers of states, inputs and outputs, sampling period.
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (plant, observer) = (&self.study.plant, &self.study.observers[0]);
        let size = self.designed.runnable.dimensions();
        Ok(dictionary!(py; kind = observer.kind.name(), name = observer.name.as_str(), states = &plant.states,
            turns = plant.turns_of(&plant.states),
            inputs = &plant.inputs, outputs = &plant.outputs, order = size.state,
            period = observer.kind.period().or(self.designed.runnable.period()), initial = list(py, &observer.initial)))
    }

    /// Its certificate; none for observers whose evidence is measured, or that have none.
    fn certificate(&self) -> Option<Certificate> {
        let title = self.study.observers[0].name.clone();
        self.designed.certificate.clone().map(|proof| Certificate { proof, title })
    }

    /// The state of the observer with this estimate.
    #[pyo3(signature = (t, xhat, u, y, /))]
    fn initial<'py>(
        &self,
        py: Python<'py>,
        t: f64,
        xhat: Vector<'py>,
        u: Vector<'py>,
        y: Vector<'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (u, y) = self.vectors(py, &u, &y)?;
        answer(py, "xhat", self.designed.runnable.initial(t, vector(&xhat).as_slice(), &u, &y))
    }

    /// The derivative of the state, in discrete time the next state.
    #[pyo3(signature = (t, state, u, y, /))]
    fn motion<'py>(
        &self,
        py: Python<'py>,
        t: f64,
        state: Vector<'py>,
        u: Vector<'py>,
        y: Vector<'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (u, y) = self.vectors(py, &u, &y)?;
        answer(py, "state", self.designed.runnable.motion(t, vector(&state).as_slice(), &u, &y))
    }

    /// The estimate of a state.
    #[pyo3(signature = (t, state, u, y, /))]
    fn estimate<'py>(
        &self,
        py: Python<'py>,
        t: f64,
        state: Vector<'py>,
        u: Vector<'py>,
        y: Vector<'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (u, y) = self.vectors(py, &u, &y)?;
        answer(py, "state", self.designed.runnable.estimate(t, vector(&state).as_slice(), &u, &y))
    }

    /// The run of this observer in the simulation of a study of the same plant and observer.
    #[pyo3(signature = (study, folder, on_log, /))]
    fn run<'py>(&self, py: Python<'py>, study: &str, folder: PathBuf, on_log: bool) -> PyResult<Bound<'py, PyDict>> {
        let study = read(py, study, &folder)?;
        let designed = Arc::clone(&self.designed);
        let run = interruptible(py, None, move |_| {
            let observer = &study.observers[0];
            if on_log {
                replay_designed(&study, observer, &designed, None)
            } else {
                simulate_designed(&study, observer, &designed, None)
            }
        })?;
        trajectory(py, &run.map_err(|why| study_error(py, &why))?)
    }

    /// The observer stepped at every sample, from an estimate.
    #[pyo3(signature = (xhat, request, /))]
    fn stepper(&self, py: Python<'_>, xhat: Option<Vector<'_>>, request: Request) -> PyResult<Stepper> {
        let (study, designed, options) = (Arc::clone(&self.study), Arc::clone(&self.designed), request.options(py)?);
        let xhat = xhat.map(|xhat| vector(&xhat).as_slice().to_vec());
        let built = interruptible(py, None, move |_| {
            let options = ExportOptions { designed: Some(&designed), ..options };
            let export = program(&study, None, &options, xhat.as_deref())?;
            let stepper = golden::Stepper::new(&export).map_err(|error| ExportRefusal::Numbers {
                observer: study.observers[0].name.clone(),
                error: Box::new(error),
            })?;
            let observer = export.observer();
            let takes_missing = observer.leaves_out_missing();
            let is_of_plant = study.observers[0].kind.functions().is_none();
            let plant = (!takes_missing && is_of_plant).then(|| study.plant.model.clone());
            let (period, size) = (observer.period(), observer.dimensions());
            Ok(Stepper {
                inner: Mutex::new(stepper),
                plant,
                takes_missing,
                period,
                inputs: size.inputs,
                outputs: size.outputs,
            })
        })?;
        built.map_err(|why| refused(py, &why))
    }

    /// The files of an export: names and bytes, what is proved, and its cost. With a study of the same plant and
    /// observer the bounds of its simulation are those of the proof.
    #[pyo3(signature = (study, folder, request, /))]
    fn export<'py>(
        &self,
        py: Python<'py>,
        study: Option<&str>,
        folder: PathBuf,
        request: Request,
    ) -> PyResult<Bound<'py, PyDict>> {
        let study = match study {
            Some(text) => Arc::new(read(py, text, &folder)?),
            None => Arc::clone(&self.study),
        };
        let (designed, options) = (Arc::clone(&self.designed), request.options(py)?);
        let exported = interruptible(py, None, move |_| {
            export(&study, None, &ExportOptions { designed: Some(&designed), ..options })
        })?;
        files(py, &exported.map_err(|why| refused(py, &why))?)
    }
}

fn answer<'py>(py: Python<'py>, what: &str, found: Option<Vec<f64>>) -> PyResult<Bound<'py, PyAny>> {
    if let Some(entries) = found {
        return Ok(list(py, &entries).into_any());
    }
    let numbers = dictionary!(py; what);
    Err(error::raise(py, "DimensionMismatch", format!("{what} has the wrong number of entries"), &numbers))
}

/// An observer that is stepped sample by sample: the numbers that its exported code computes.
#[pyclass(frozen, module = "luenberger._luenberger")]
pub(crate) struct Stepper {
    inner: Mutex<golden::Stepper>,
    /// Of an observer without missed samples, the plant whose predicted output stands for a missing one.
    plant: Option<Model>,
    /// Whether a step can do without some of the outputs.
    takes_missing: bool,
    #[pyo3(get)]
    period: f64,
    inputs: usize,
    outputs: usize,
}

#[pymethods]
impl Stepper {
    /// Whether the observer has a covariance, and its step two halves.
    #[getter]
    fn is_filter(&self) -> bool {
        self.inner().is_filter()
    }

    /// Whether a NaN in y can stand for a missing value.
    #[getter]
    fn can_miss(&self) -> bool {
        self.takes_missing || self.plant.is_some()
    }

    /// The estimates for the next samples, from one column of inputs and outputs for each sample.
    #[pyo3(signature = (u, y, /))]
    fn steps<'py>(&self, py: Python<'py>, u: Matrix<'py>, y: Matrix<'py>) -> PyResult<Bound<'py, PyAny>> {
        let (u, mut y) = (samples(&u), samples(&y));
        let fits = |columns: &[Vec<f64>], rows: usize| columns.iter().all(|column| column.len() == rows);
        if u.len() != y.len() || !fits(&u, self.inputs) || !fits(&y, self.outputs) {
            let (expected, found) = ((self.inputs, self.outputs), (u.len(), y.len()));
            let message = format!("u and y must have {} and {} rows, and as many columns", self.inputs, self.outputs);
            let numbers = dictionary!(py; what = "u and y", expected, found);
            return Err(error::raise(py, "DimensionMismatch", message, &numbers));
        }
        let estimates = py.detach(|| {
            let mut inner = self.inner();
            let columns = u.iter().zip(&mut y).map(|(u, y)| nalgebra::DVector::from_vec(self.one(&mut inner, u, y)));
            columns.collect::<Vec<_>>()
        });
        let n = self.inner().estimate().len();
        let all = if estimates.is_empty() {
            nalgebra::DMatrix::zeros(n, 0)
        } else {
            nalgebra::DMatrix::from_columns(&estimates)
        };
        Ok(array(py, &all).into_any())
    }

    /// The estimate for the next sample, of one sample whose columns are numbers, lists of numbers or vectors of
    /// binary64. None for anything else: `steps` reads it, or says what is wrong.
    #[pyo3(signature = (u, y, /))]
    fn step<'py>(
        &self,
        py: Python<'py>,
        u: &Bound<'py, PyAny>,
        y: &Bound<'py, PyAny>,
    ) -> Option<Bound<'py, PyArray1<f64>>> {
        let u = if u.is_none() { vec![0.0; self.inputs] } else { column(u, self.inputs)? };
        let mut y = column(y, self.outputs)?;
        let is_whole = u.iter().chain(&y).all(|x| x.is_finite());
        is_whole.then(|| list(py, &self.one(&mut self.inner(), &u, &mut y)))
    }

    /// The update of a filter by a measurement. False where it is passed over.
    #[pyo3(signature = (u, y, /))]
    fn update(&self, u: Vector<'_>, y: Vector<'_>) -> bool {
        self.inner().update(vector(&u).as_slice(), vector(&y).as_slice())
    }

    /// The prediction of a filter for the next sample. False where it has no result.
    #[pyo3(signature = (u, /))]
    fn predict(&self, u: Vector<'_>) -> bool {
        self.inner().predict(vector(&u).as_slice())
    }

    /// The estimate for the next sample; after an update that with the measurement.
    fn estimate<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        list(py, &self.inner().estimate()).into_any()
    }

    /// The covariance of the error of the estimate, of a filter.
    fn covariance<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyAny>> {
        self.inner().covariance().map(|p| array(py, &p).into_any())
    }

    /// Its state, and how many samples it has had.
    fn position<'py>(&self, py: Python<'py>) -> (Bound<'py, PyArray1<f64>>, usize) {
        let (state, sample) = self.inner().position();
        (list(py, &state), sample)
    }

    /// Goes on from the position of another stepper of the same observer.
    #[pyo3(signature = (state, sample, /))]
    fn resume(&self, py: Python<'_>, state: Vector<'_>, sample: usize) -> PyResult<()> {
        if self.inner().resume(vector(&state).as_slice(), sample) {
            return Ok(());
        }
        Err(error::plain(py, "InvalidArgument", "the state is that of another observer"))
    }

    /// Of a filter, at the last measurement: innovation, its covariance, square and log-determinant, the outputs used.
    fn innovation<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some((innovation, used)) = self.inner().innovation() else { return Ok(None) };
        let (value, covariance) = (list(py, innovation.value.as_slice()), array(py, &innovation.covariance));
        let (square, log_determinant) = (innovation.normalized_square, innovation.log_determinant());
        Ok(Some(dictionary!(py; value, covariance, square, log_determinant, used)))
    }
}

impl Stepper {
    fn inner(&self) -> MutexGuard<'_, golden::Stepper> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A step. What is missing of y is replaced by what the estimate predicts, where the step has no missed samples.
    fn one(&self, stepper: &mut golden::Stepper, u: &[f64], y: &mut [f64]) -> Vec<f64> {
        if let Some(plant) = self.plant.as_ref().filter(|_| y.iter().any(|y| y.is_nan())) {
            let column = DVector::from_column_slice;
            let xhat = stepper.estimate();
            let t = stepper.position().1 as f64 * self.period;
            let expected = plant.output(t, &column(&xhat[..plant.size().states]), &column(u));
            for (y, expected) in y.iter_mut().zip(&expected).filter(|(y, _)| y.is_nan()) {
                *y = *expected;
            }
        }
        stepper.step(u, y)
    }
}

/// A column of so many numbers, of a number, a list or tuple of numbers, or a vector of binary64; None for others.
fn column(value: &Bound<'_, PyAny>, length: usize) -> Option<Vec<f64>> {
    let found = if let Ok(array) = value.cast::<PyArray1<f64>>() {
        array.try_readonly().ok()?.as_array().to_vec()
    } else if let Ok(number) = value.cast::<PyFloat>() {
        vec![number.value()]
    } else if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        value.extract().ok()?
    } else {
        return None;
    };
    (found.len() == length).then_some(found)
}
