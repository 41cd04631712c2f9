//! One observer: its design, its runs, its step, its files.

use std::path::PathBuf;
use std::sync::Arc;

use luenberger_export::golden;
use luenberger_study::deployment::{ExportOptions, ExportRefusal, export, program};
use luenberger_study::design::{Designed, SteppedFilter, design_until};
use luenberger_study::{Study, replay_designed, simulate_designed};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::array::{Vector, list, vector};
use crate::certificate::Certificate;
use crate::error::{self, dictionary};
use crate::export::{Request, files, refused, without_step};
use crate::run::{read, study_error, trajectory};
use crate::stepper::{Form, Stepper, Steps};
use crate::words::OF_CALL;
use crate::work::interruptible;

/// An observer with its design; the only one of its study.
#[pyclass(frozen, module = "luenberger._luenberger")]
pub(crate) struct Design {
    study: Arc<Study>,
    designed: Arc<Designed>,
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
            Some(Err(none)) => Err(error::design(py, &none, &OF_CALL)),
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
            turns = plant.turns_of(&plant.states), functions = observer.kind.functions().map(|(_, names)| names),
            disturbances = observer.kind.estimated_disturbances(),
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

    /// The estimate with the measurement of its sample.
    #[pyo3(signature = (t, state, u, y, /))]
    fn estimate_at<'py>(
        &self,
        py: Python<'py>,
        t: f64,
        state: Vector<'py>,
        u: Vector<'py>,
        y: Vector<'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (u, y) = self.vectors(py, &u, &y)?;
        answer(py, "state", self.designed.runnable.estimate_at(t, vector(&state).as_slice(), &u, &y))
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
    fn stepper(&self, py: Python<'_>, xhat: Option<Vector<'_>>, request: &Bound<'_, PyDict>) -> PyResult<Stepper> {
        let request = Request::read(request)?;
        let (study, designed, options) = (Arc::clone(&self.study), Arc::clone(&self.designed), request.options(py)?);
        let xhat = xhat.map(|xhat| vector(&xhat).as_slice().to_vec());
        let built = interruptible(py, None, move |_| {
            let options = ExportOptions { designed: Some(&designed), ..options };
            let observer = &study.observers[0];
            let exported = program(&study, None, &options, xhat.as_deref()).and_then(|export| {
                let stepper = golden::Stepper::new(&export).map_err(|error| ExportRefusal::Numbers {
                    observer: observer.name.clone(),
                    error: Box::new(error),
                })?;
                Ok((stepper, export))
            });
            match exported {
                Ok((stepper, export)) => {
                    let step = export.observer();
                    let (takes_missing, size) = (step.leaves_out_missing(), step.dimensions());
                    let is_of_plant = observer.kind.functions().is_none();
                    let form = Form {
                        plant: (!takes_missing && is_of_plant).then(|| study.plant.model.clone()),
                        takes_missing,
                        period: step.period(),
                        inputs: size.inputs,
                        outputs: size.outputs,
                        names: export.names().states.clone(),
                    };
                    Ok(Stepper::new(Steps::Program(Box::new(stepper)), form))
                }
                // A filter is stepped as on a log, where nothing is asked for that only exported code has.
                Err(refusal) => {
                    let is_own = options.period.is_none_or(|period| designed.runnable.period() == Some(period));
                    let is_plain =
                        is_own && options.substeps.is_none() && options.format == ExportOptions::default().format;
                    let start = xhat.as_ref().unwrap_or(&observer.initial);
                    let filter = SteppedFilter::new(designed.runnable.clone(), start).filter(|_| is_plain);
                    let (filter, size) = (filter.ok_or(refusal)?, designed.runnable.dimensions());
                    let form = Form {
                        plant: None,
                        takes_missing: true,
                        period: filter.period(),
                        inputs: size.inputs,
                        outputs: size.outputs,
                        names: study.plant.states.clone(),
                    };
                    Ok(Stepper::new(Steps::Filter(Box::new(filter)), form))
                }
            }
        })?;
        built.map_err(|why| without_step(py, &why))
    }

    /// The files of an export: names and bytes, what is proved, and its cost. With a study of the same plant and
    /// observer the bounds of its simulation are those of the proof.
    #[pyo3(signature = (study, folder, request, /))]
    fn export<'py>(
        &self,
        py: Python<'py>,
        study: Option<&str>,
        folder: PathBuf,
        request: &Bound<'py, PyDict>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let request = Request::read(request)?;
        let study = match study {
            Some(text) => Arc::new(read(py, text, &folder)?),
            None => Arc::clone(&self.study),
        };
        let (designed, options) = (Arc::clone(&self.designed), request.options(py)?);
        let exported = interruptible(py, None, move |_| {
            export(&study, None, &ExportOptions { designed: Some(&designed), ..options })
        })?;
        files(py, &exported.map_err(|why| refused(py, &why, &OF_CALL))?)
    }
}

fn answer<'py>(py: Python<'py>, what: &str, found: Option<Vec<f64>>) -> PyResult<Bound<'py, PyAny>> {
    if let Some(entries) = found {
        return Ok(list(py, &entries).into_any());
    }
    let numbers = dictionary!(py; what);
    Err(error::raise(py, "DimensionMismatch", format!("{what} has the wrong number of entries"), &numbers))
}
