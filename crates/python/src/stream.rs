//! An observer on rows that arrive one after the other.

use std::sync::{Mutex, PoisonError};

use luenberger_study::stream::{Stream, StreamError, StreamOptions};
use luenberger_study::table::Form;
use pyo3::prelude::*;

use crate::argument::{COUNT, given};
use crate::error;
use crate::export::refused;
use crate::run::StudyFile;
use crate::words::OF_STUDY;
use crate::work::interruptible;

/// The stream of an observer of a study: JSON objects in, JSON objects out.
#[pyclass(frozen, module = "luenberger._luenberger")]
pub(crate) struct RowStream {
    inner: Mutex<(Stream, u64)>,
}

impl RowStream {
    /// Called without the interpreter's lock: another thread may have the stream for as long as a row takes.
    fn with<T>(&self, work: impl FnOnce(&mut (Stream, u64)) -> T) -> T {
        work(&mut self.inner.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

#[pymethods]
impl RowStream {
    #[new]
    #[pyo3(signature = (study, observer, dt, substeps, timed, predicted, /))]
    fn new(
        py: Python<'_>,
        study: &StudyFile,
        observer: Option<String>,
        dt: Option<f64>,
        substeps: Option<Bound<'_, PyAny>>,
        timed: bool,
        predicted: Option<bool>,
    ) -> PyResult<Self> {
        let substeps = given("substeps", substeps.as_ref(), COUNT)?;
        let study = std::sync::Arc::clone(&study.study);
        let options = StreamOptions { form: Some(Form::Json), timed, predicted, period: dt, substeps };
        let stream = interruptible(py, None, move |_| Stream::new(&study, observer.as_deref(), &options))?;
        let stream = stream.map_err(|why| refused(py, &why, &OF_STUDY))?;
        Ok(Self { inner: Mutex::new((stream, 0)) })
    }

    /// The names of the results, the time first.
    fn columns(&self, py: Python<'_>) -> Vec<String> {
        py.detach(|| self.with(|(stream, _)| stream.columns().to_vec()))
    }

    /// Samples so far, missed ones included.
    fn samples(&self, py: Python<'_>) -> u64 {
        py.detach(|| self.with(|(stream, _)| stream.samples()))
    }

    /// The results of a row.
    #[pyo3(signature = (row, /))]
    fn step(&self, py: Python<'_>, row: &str) -> PyResult<String> {
        let answer = py.detach(|| {
            self.with(|(stream, rows)| {
                *rows += 1;
                let answer = stream.line(*rows, row.as_bytes());
                if answer.is_ok() {
                    stream.deliver();
                }
                answer
            })
        });
        match answer {
            Ok(text) => Ok(text.unwrap_or_default()),
            Err(why @ StreamError::Diverged { .. }) => Err(error::plain(py, "SimulationError", in_rows(&why))),
            Err(why) => Err(error::plain(py, "InvalidArgument", in_rows(&why))),
        }
    }

    /// The state after the last row.
    fn saved(&self, py: Python<'_>) -> String {
        py.detach(|| self.with(|(stream, _)| stream.saved()))
    }

    /// Goes on from a saved state.
    #[pyo3(signature = (text, /))]
    fn resume(&self, py: Python<'_>, text: &str) -> PyResult<()> {
        py.detach(|| self.with(|(stream, _)| stream.resume(text)))
            .map_err(|why| error::plain(py, "InvalidArgument", why))
    }
}

/// A message in which lines are rows.
fn in_rows(why: &StreamError) -> String {
    why.to_string().replacen("line ", "row ", 1)
}
