//! Studies and trajectories.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use luenberger_plants::StateSpace;
use luenberger_study::execute::{Limits, SweepOptions};
use luenberger_study::results::{ObserverRun, Results};
use luenberger_study::tune::{TuneOptions, tune};
use luenberger_study::{Format, RunOptions, Step, Study, StudyError, execute_in_part};
use nalgebra::DMatrix;
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::argument::{COUNT, given};
use crate::array::{array, columns, list};
use crate::error::{self, dictionary};
use crate::words::{in_python, of_calls, of_tables};
use crate::work::interruptible;

/// The study in a text that this package has written: a mistake is one of an argument.
pub(crate) fn read(py: Python<'_>, text: &str, folder: &Path) -> PyResult<Study> {
    Study::from_text("study", text, Format::Json, folder).map_err(|why| {
        let Some(mistakes) = why.diagnostics() else { return study_error(py, &why) };
        let sentence = |mistake: &luenberger_study::Diagnostic| {
            let help = mistake.help.as_ref().map(|help| format!("; {}", of_calls(help))).unwrap_or_default();
            format!("{}: {}{help}", of_tables(&mistake.message), of_calls(&mistake.expected))
        };
        let sentences: Vec<String> = mistakes.list().iter().map(sentence).collect();
        error::plain(py, "InvalidArgument", sentences.join("\n"))
    })
}

/// The names of the plant of a study, and its operating point, if it names one.
#[pyfunction]
#[pyo3(signature = (study, /))]
pub(crate) fn check<'py>(py: Python<'py>, study: &str) -> PyResult<Bound<'py, PyDict>> {
    let study = read(py, study, ".".as_ref())?;
    let plant = study.plant;
    let turns = plant.turns_of(&plant.states);
    let found = dictionary!(py; states = plant.states, inputs = plant.inputs, outputs = plant.outputs, turns);
    if let Some(point) = study.operating_point {
        let StateSpace { a, b, c, d } = &point.linear;
        let at = dictionary!(py;
            x = list(py, point.x.as_slice()),
            u = list(py, point.u.as_slice()),
            y = list(py, point.y.as_slice()),
            residual = point.residual,
            A = array(py, a),
            B = array(py, b),
            C = array(py, c),
            D = d.as_ref().map(|d| array(py, d)),
        );
        found.set_item("at", at)?;
    }
    Ok(found)
}

pub(crate) fn study_error(py: Python<'_>, why: &StudyError) -> PyErr {
    let raised = || -> PyResult<PyErr> {
        Ok(match why {
            StudyError::File(diagnostics) => {
                let one = |at: &luenberger_study::diagnostic::Located| -> PyResult<Bound<'_, PyDict>> {
                    Ok(dictionary!(py; file = at.file.as_str(), line = at.line, column = at.column,
                        message = at.message.as_str(), expected = at.expected.as_str(), help = at.help.as_deref()))
                };
                let list = diagnostics.located().iter().map(one).collect::<PyResult<Vec<_>>>()?;
                let numbers = dictionary!(py; diagnostics = PyList::new(py, list)?);
                error::raise(py, "StudyFileError", why.to_string(), &numbers)
            }
            StudyError::Linalg(error) => error::linalg(py, error),
            StudyError::Sim(_) => error::plain(py, "SimulationError", why),
            StudyError::Interrupted | StudyError::TimeLimit { .. } => {
                error::plain(py, "Cancelled", in_python(&why.to_string()))
            }
            StudyError::Io { path, error } => {
                let message = (error.raw_os_error().unwrap_or(0), said(error), path.display().to_string());
                PyErr::from_value(py.import("builtins")?.getattr("OSError")?.call1(message)?)
            }
            _ => error::plain(py, "StudyError", in_python(&why.to_string())),
        })
    };
    raised().unwrap_or_else(|error| error)
}

/// What the system says, without its number, which the exception has.
fn said(error: &std::io::Error) -> String {
    let text = error.to_string();
    text.split_once(" (os error ").map_or(text.as_str(), |(said, _)| said).to_owned()
}

/// Arrays with one column for each time, as python-control has them.
pub(crate) fn trajectory<'py>(py: Python<'py>, run: &ObserverRun) -> PyResult<Bound<'py, PyDict>> {
    Ok(dictionary!(py;
        observer = run.observer.as_str(),
        on_log = run.on_log,
        t = list(py, &run.t),
        x = columns(py, &run.x),
        u = columns(py, &run.u),
        y = columns(py, &run.y),
        xhat = run.estimate.as_ref().map(|estimate| columns(py, estimate)),
        functions = named(py, run.functions.as_ref()),
        deviation = run.deviation.as_ref().map(|deviation| columns(py, deviation)),
        smoothed = run.smoothed.as_ref().map(|(estimate, _)| columns(py, estimate)),
        smoothed_deviation = run.smoothed.as_ref().map(|(_, deviation)| columns(py, deviation)),
        half_width = run.half_width.as_ref().map(|half_width| columns(py, half_width)),
        disturbances = named(py, run.disturbance.as_ref()),
        models = named(py, run.modes.as_ref()),
        warnings = run.warnings.iter().map(|warning| in_python(warning)).collect::<Vec<_>>(),
    ))
}

/// Names and rows of what a run has besides the states.
fn named<'py>(
    py: Python<'py>,
    of: Option<&(Vec<String>, DMatrix<f64>)>,
) -> Option<(Vec<String>, Bound<'py, PyArray2<f64>>)> {
    of.map(|(names, rows)| (names.clone(), columns(py, rows)))
}

/// What an execution leaves: the results as JSON, the trajectories, and what failed.
pub(crate) fn answer(
    py: Python<'_>,
    executed: Result<(Results, Option<StudyError>), StudyError>,
) -> PyResult<Bound<'_, PyDict>> {
    let (results, stopped) = executed.map_err(|why| study_error(py, &why))?;
    if let Some(why) = stopped {
        return Err(study_error(py, &why));
    }
    let json = results.to_json().map_err(|why| study_error(py, &why))?;
    let runs = results.runs.iter().map(|run| trajectory(py, run)).collect::<PyResult<Vec<_>>>()?;
    Ok(dictionary!(py; json, runs = PyList::new(py, runs)?, failures = results.failures()))
}

/// A study file.
#[pyclass(frozen, module = "luenberger._luenberger")]
pub(crate) struct StudyFile {
    pub(crate) study: Arc<Study>,
}

fn step_named(name: &str) -> Option<Step> {
    let all = [Step::Observe, Step::Design, Step::Certify, Step::Simulate, Step::Compare, Step::Sweep, Step::Run];
    all.into_iter().find(|step| step.name() == name)
}

#[pymethods]
impl StudyFile {
    /// Reads a file.
    #[new]
    #[pyo3(signature = (path, /))]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let study = py.detach(|| Study::from_path(&path)).map_err(|why| study_error(py, &why))?;
        Ok(Self { study: Arc::new(study) })
    }

    /// Reads a text, TOML or JSON.
    #[staticmethod]
    #[pyo3(signature = (text, is_json, folder, /))]
    fn from_text(py: Python<'_>, text: &str, is_json: bool, folder: PathBuf) -> PyResult<Self> {
        let format = if is_json { Format::Json } else { Format::Toml };
        let study = Study::from_text("study", text, format, &folder).map_err(|why| study_error(py, &why))?;
        Ok(Self { study: Arc::new(study) })
    }

    /// Title, description, and the names of states, inputs, outputs and observers.
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (study, plant) = (&self.study, &self.study.plant);
        let observers: Vec<&str> = study.observers.iter().map(|observer| observer.name.as_str()).collect();
        Ok(dictionary!(py; title = study.title.as_str(), about = study.about.as_str(), states = &plant.states,
            units = plant.units_of(&plant.states), turns = plant.turns_of(&plant.states), inputs = &plant.inputs, outputs = &plant.outputs, observers))
    }

    /// Executes a step: the results as JSON, the trajectories, and why it ended early, if it did.
    #[pyo3(signature = (step, output, force, threads, time_limit, memory_limit, block_size, restart, progress, /))]
    #[expect(clippy::too_many_arguments, reason = "the options of an execution")]
    fn execute<'py>(
        &self,
        py: Python<'py>,
        step: &str,
        output: Option<PathBuf>,
        force: bool,
        threads: Option<Bound<'py, PyAny>>,
        time_limit: Option<f64>,
        memory_limit: Option<f64>,
        block_size: Option<Bound<'py, PyAny>>,
        restart: bool,
        progress: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let Some(step) = step_named(step) else {
            return Err(error::plain(py, "InvalidArgument", format!("there is no step {step:?}")));
        };
        let threads = given("threads", threads.as_ref(), COUNT)?;
        let block_size = given("block_size", block_size.as_ref(), COUNT)?;
        let mut limits = Limits::default();
        limits.seconds = time_limit.unwrap_or(limits.seconds);
        limits.memory = memory_limit.unwrap_or(limits.memory);
        let study = Arc::clone(&self.study);
        let executed = interruptible(py, progress.as_ref(), move |context| {
            let options = RunOptions {
                output: output.map(Into::into),
                force,
                limits,
                threads,
                sweep: SweepOptions { block_size, restart, ..SweepOptions::default() },
                progress: context.progress,
                cancel: context.cancel,
                ..RunOptions::default()
            };
            execute_in_part(&study, step, &options)
        })?;
        answer(py, executed)
    }

    /// Fits what [tune] names: the fit as JSON, and the tuned study.
    #[pyo3(signature = (output, force, threads, write, progress, /))]
    fn tune<'py>(
        &self,
        py: Python<'py>,
        output: Option<PathBuf>,
        force: bool,
        threads: Option<Bound<'py, PyAny>>,
        write: bool,
        progress: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let threads = given("threads", threads.as_ref(), COUNT)?;
        let study = Arc::clone(&self.study);
        let tuned = interruptible(py, progress.as_ref(), move |context| {
            let (progress, cancel) = (context.progress, context.cancel);
            let output = output.map(Into::into);
            let run = RunOptions { output, force, threads, progress, cancel, ..RunOptions::default() };
            tune(&study, &TuneOptions { run, write })
        })?;
        let report = tuned.map_err(|why| study_error(py, &why))?;
        let json = serde_json::to_string(&report).map_err(|why| error::plain(py, "StudyError", why))?;
        Ok(dictionary!(py; json, study = report.study.as_str(), text = report.text()))
    }
}
