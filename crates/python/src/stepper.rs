//! An observer that is stepped sample by sample.

use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::{Duration, Instant};

use luenberger_export::golden;
use luenberger_plants::Plant;
use luenberger_study::design::SteppedFilter;
use luenberger_study::model::Model;
use nalgebra::{DMatrix, DVector};
use numpy::{PyArray1, PyArrayMethods, PyUntypedArray};
use pyo3::prelude::*;
use pyo3::type_object::PyTypeInfo;
use pyo3::types::{PyDict, PyFloat, PyInt, PyList, PyTuple};

use crate::array::{Matrix, Vector, array, list, matrix, vector};
use crate::error::{self, dictionary};

/// Period at which Ctrl-C is checked within many steps.
const TICK: Duration = Duration::from_millis(50);

/// The steps of an observer.
#[derive(Debug)]
pub(crate) enum Steps {
    /// The numbers that its exported code computes.
    Program(Box<golden::Stepper>),
    /// The steps of a filter without such code, as on a log.
    Filter(Box<SteppedFilter>),
}

/// The same of either.
macro_rules! of {
    ($steps:expr, $stepper:ident => $what:expr) => {
        match $steps {
            Steps::Program($stepper) => $what,
            Steps::Filter($stepper) => $what,
        }
    };
}

impl Steps {
    fn step(&mut self, u: &[f64], y: &[f64]) -> Vec<f64> {
        of!(self, stepper => stepper.step(u, y))
    }

    fn estimate(&self) -> Vec<f64> {
        of!(self, stepper => stepper.estimate())
    }

    fn position(&self) -> (Vec<f64>, usize) {
        of!(self, stepper => stepper.position())
    }

    fn resume(&mut self, state: &[f64], sample: usize) -> bool {
        of!(self, stepper => stepper.resume(state, sample))
    }

    fn is_filter(&self) -> bool {
        match self {
            Self::Program(stepper) => stepper.is_filter(),
            Self::Filter(_) => true,
        }
    }
}

/// What a step takes and returns.
#[derive(Debug)]
pub(crate) struct Form {
    /// Of an observer without missed samples, the plant whose predicted output stands for a missing one.
    pub(crate) plant: Option<Model>,
    /// Whether a step can do without some of the outputs.
    pub(crate) takes_missing: bool,
    pub(crate) period: f64,
    pub(crate) inputs: usize,
    pub(crate) outputs: usize,
    /// Names of the entries of the estimate.
    pub(crate) names: Vec<String>,
}

/// An observer that is stepped sample by sample.
#[pyclass(frozen, module = "luenberger._luenberger")]
pub(crate) struct Stepper {
    steps: Mutex<Steps>,
    form: Form,
}

/// Rows of an array whose columns are samples.
fn samples(array: &Matrix<'_>) -> Vec<Vec<f64>> {
    matrix(array).column_iter().map(|column| column.iter().copied().collect()).collect()
}

#[pymethods]
impl Stepper {
    /// Whether the observer has a covariance, and its step two halves.
    #[getter]
    fn is_filter(&self, py: Python<'_>) -> bool {
        self.steps(py).is_filter()
    }

    /// Whether its steps are those of exported code.
    #[getter]
    fn is_exported(&self, py: Python<'_>) -> bool {
        matches!(&*self.steps(py), Steps::Program(_))
    }

    /// Whether a NaN in y can stand for a missing value.
    #[getter]
    fn can_miss(&self) -> bool {
        self.form.takes_missing || self.form.plant.is_some()
    }

    /// The sampling period; of an observer at varying periods the nominal one.
    #[getter]
    fn period(&self) -> f64 {
        self.form.period
    }

    /// Names of the entries of the estimate.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.form.names.clone()
    }

    /// The estimates for the next samples, from one column of inputs and outputs for each sample. Ctrl-C ends it, and
    /// the observer is then where it was before.
    #[pyo3(signature = (u, y, /))]
    fn steps_of<'py>(&self, py: Python<'py>, u: Matrix<'py>, y: Matrix<'py>) -> PyResult<Bound<'py, PyAny>> {
        let (u, mut y) = (samples(&u), samples(&y));
        let Form { inputs, outputs, .. } = self.form;
        let fits = |columns: &[Vec<f64>], rows: usize| columns.iter().all(|column| column.len() == rows);
        if u.len() != y.len() || !fits(&u, inputs) || !fits(&y, outputs) {
            let (expected, found) = ((inputs, outputs), (u.len(), y.len()));
            let message = format!("u and y must have {inputs} and {outputs} rows, and as many columns");
            let numbers = dictionary!(py; what = "u and y", expected, found);
            return Err(error::raise(py, "DimensionMismatch", message, &numbers));
        }
        let estimates = py.detach(|| {
            // Held from the first sample to the last: those of another thread do not come in between.
            let mut steps = self.steps.lock().unwrap_or_else(PoisonError::into_inner);
            let start = steps.position();
            let mut looked = Instant::now();
            let mut estimates = Vec::with_capacity(u.len());
            for (u, y) in u.iter().zip(&mut y) {
                if looked.elapsed() > TICK {
                    #[expect(clippy::redundant_closure_for_method_calls, reason = "of any lifetime")]
                    let looked_at = Python::attach(|py| py.check_signals());
                    if let Err(raised) = looked_at {
                        steps.resume(&start.0, start.1);
                        return Err(raised);
                    }
                    looked = Instant::now();
                }
                estimates.push(DVector::from_vec(self.one(&mut steps, u, y)));
            }
            Ok(estimates)
        })?;
        let all = if estimates.is_empty() {
            DMatrix::zeros(self.steps(py).estimate().len(), 0)
        } else {
            DMatrix::from_columns(&estimates)
        };
        Ok(array(py, &all).into_any())
    }

    /// The estimate for the next sample, of one sample whose columns are numbers, lists of numbers or vectors of
    /// numbers. None for anything else: `steps_of` reads it, or says what is wrong.
    #[pyo3(signature = (u, y, /))]
    fn step<'py>(
        &self,
        py: Python<'py>,
        u: &Bound<'py, PyAny>,
        y: &Bound<'py, PyAny>,
    ) -> Option<Bound<'py, PyArray1<f64>>> {
        let u = if u.is_none() { vec![0.0; self.form.inputs] } else { column(u, self.form.inputs)? };
        let mut y = if y.is_none() { vec![f64::NAN; self.form.outputs] } else { column(y, self.form.outputs)? };
        let can_miss = self.can_miss();
        let fits = u.iter().all(|u| u.is_finite()) && y.iter().all(|y| y.is_finite() || (can_miss && y.is_nan()));
        fits.then(|| list(py, &self.one(&mut self.steps(py), &u, &mut y)))
    }

    /// The update of a filter by a measurement. False where it is passed over.
    #[pyo3(signature = (u, y, /))]
    fn update(&self, py: Python<'_>, u: Vector<'_>, y: Vector<'_>) -> bool {
        let (u, y) = (vector(&u), vector(&y));
        of!(&mut *self.steps(py), stepper => stepper.update(u.as_slice(), y.as_slice()))
    }

    /// The prediction of a filter for the next sample. False where it has no result.
    #[pyo3(signature = (u, /))]
    fn predict(&self, py: Python<'_>, u: Vector<'_>) -> bool {
        let u = vector(&u);
        of!(&mut *self.steps(py), stepper => stepper.predict(u.as_slice()))
    }

    /// The estimate for the next sample; after an update that with the measurement.
    fn estimate<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        list(py, &self.steps(py).estimate()).into_any()
    }

    /// The covariance of the error of the estimate, of a filter.
    fn covariance<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyAny>> {
        let covariance = of!(&*self.steps(py), stepper => stepper.covariance());
        covariance.map(|p| array(py, &p).into_any())
    }

    /// Its state, and how many samples it has had.
    fn position<'py>(&self, py: Python<'py>) -> (Bound<'py, PyArray1<f64>>, usize) {
        let (state, sample) = self.steps(py).position();
        (list(py, &state), sample)
    }

    /// Goes on from the position of another stepper of the same observer.
    #[pyo3(signature = (state, sample, /))]
    fn resume(&self, py: Python<'_>, state: Vector<'_>, sample: usize) -> PyResult<()> {
        if self.steps(py).resume(vector(&state).as_slice(), sample) {
            return Ok(());
        }
        Err(error::plain(py, "InvalidArgument", "the state is that of another observer"))
    }

    /// Of a filter, at the last measurement: innovation, its square and log-determinant, the outputs used, and its
    /// covariance where the steps are those of exported code.
    fn innovation<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let found = match &*self.steps(py) {
            Steps::Program(stepper) => stepper.innovation().map(|(of, used)| {
                let log_determinant = Some(of.log_determinant());
                (of.value, Some(of.covariance), of.normalized_square, log_determinant, used)
            }),
            Steps::Filter(stepper) => {
                stepper.innovation().map(|of| (of.value, None, of.square, of.log_determinant, of.used))
            }
        };
        let Some((value, covariance, square, log_determinant, used)) = found else { return Ok(None) };
        let (value, covariance) = (list(py, value.as_slice()), covariance.map(|s| array(py, &s)));
        Ok(Some(dictionary!(py; value, covariance, square, log_determinant, used)))
    }
}

impl Stepper {
    pub(crate) fn new(steps: Steps, form: Form) -> Self {
        Self { steps: Mutex::new(steps), form }
    }

    /// The steps. While another thread has them, the interpreter runs others.
    fn steps(&self, py: Python<'_>) -> MutexGuard<'_, Steps> {
        loop {
            match self.steps.try_lock() {
                Ok(steps) => return steps,
                Err(TryLockError::Poisoned(steps)) => return steps.into_inner(),
                Err(TryLockError::WouldBlock) => py.detach(|| drop(self.steps.lock())),
            }
        }
    }

    /// A step. What is missing of y is replaced by what the estimate predicts, where the step has no missed samples.
    fn one(&self, steps: &mut Steps, u: &[f64], y: &mut [f64]) -> Vec<f64> {
        if let Some(plant) = self.form.plant.as_ref().filter(|_| y.iter().any(|y| y.is_nan())) {
            let column = DVector::from_column_slice;
            let xhat = steps.estimate();
            let t = steps.position().1 as f64 * self.form.period;
            let expected = plant.output(t, &column(&xhat[..plant.size().states]), &column(u));
            for (y, expected) in y.iter_mut().zip(&expected).filter(|(y, _)| y.is_nan()) {
                *y = *expected;
            }
        }
        steps.step(u, y)
    }
}

/// A column of so many numbers, of a number, a list or tuple of numbers, or a vector of real numbers; None for others.
/// A subclass of numpy's arrays may mean something else, as one with a mask does.
fn column(value: &Bound<'_, PyAny>, length: usize) -> Option<Vec<f64>> {
    let found = if let Ok(number) = value.cast::<PyFloat>() {
        vec![number.value()]
    } else if value.is_instance_of::<PyInt>() {
        vec![value.extract().ok()?]
    } else if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        value.extract().ok()?
    } else if !value.get_type().is(PyUntypedArray::type_object(value.py())) {
        return None;
    } else if let Ok(array) = value.cast::<PyArray1<f64>>() {
        array.try_readonly().ok()?.as_array().to_vec()
    } else if let Ok(array) = value.cast::<PyArray1<f32>>() {
        array.try_readonly().ok()?.as_array().iter().map(|x| f64::from(*x)).collect()
    } else {
        // Beyond 2^53 an integer is rounded, as numpy does.
        let array = value.cast::<PyArray1<i64>>().ok()?;
        array.try_readonly().ok()?.as_array().iter().map(|x| *x as f64).collect()
    };
    (found.len() == length).then_some(found)
}
