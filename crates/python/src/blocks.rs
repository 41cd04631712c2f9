//! Sweeps in blocks on disk, which several processes compute.

use std::path::PathBuf;
use std::sync::Arc;

use luenberger_study::RunOptions;
use luenberger_study::execute::{BlockSettings, Limits, SharedSweep, reduce_sweep, sweep_status};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::argument::{COUNT, given};
use crate::error;
use crate::run::{StudyFile, answer, study_error};
use crate::work::interruptible;

/// A sweep with its folder, of which this process computes some blocks.
#[pyclass(frozen, module = "luenberger._luenberger")]
pub(crate) struct Blocks {
    sweep: Arc<SharedSweep>,
}

#[pymethods]
impl Blocks {
    /// Opens the folder, which is created if it is missing.
    #[new]
    #[pyo3(signature = (study, folder, block_size, restart, force, /))]
    fn new(
        py: Python<'_>,
        study: &StudyFile,
        folder: PathBuf,
        block_size: Option<Bound<'_, PyAny>>,
        restart: bool,
        force: bool,
    ) -> PyResult<Self> {
        let block_size = given("block_size", block_size.as_ref(), COUNT)?;
        let study = study.study.as_ref().clone();
        let settings = BlockSettings { size: block_size, restart, force };
        let sweep = py.detach(|| SharedSweep::open(study, &folder, settings)).map_err(|why| study_error(py, &why))?;
        Ok(Self { sweep: Arc::new(sweep) })
    }

    /// The numbers of blocks and runs.
    fn count(&self) -> (u64, u64) {
        (self.sweep.plan().blocks(), self.sweep.plan().runs())
    }

    /// Computes those of these blocks that are not there; how many blocks and runs that were.
    #[pyo3(signature = (blocks, threads, progress, /))]
    fn compute(
        &self,
        py: Python<'_>,
        blocks: Vec<u64>,
        threads: Option<Bound<'_, PyAny>>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<(u64, u64)> {
        let threads = given("threads", threads.as_ref(), COUNT)?;
        let sweep = Arc::clone(&self.sweep);
        let computed = interruptible(py, progress.as_ref(), move |context| {
            let options = RunOptions {
                threads,
                limits: Limits::NONE,
                progress: context.progress,
                cancel: context.cancel,
                ..RunOptions::default()
            };
            sweep.compute(blocks, &options)
        })?;
        computed.map(|done| (done.computed, done.runs)).map_err(|why| study_error(py, &why))
    }
}

/// How far the sweep in a folder is, as JSON.
#[pyfunction]
#[pyo3(signature = (folder, verify, /))]
pub(crate) fn status(py: Python<'_>, folder: PathBuf, verify: bool) -> PyResult<String> {
    let status = py.detach(|| sweep_status(&folder, verify)).map_err(|why| study_error(py, &why))?;
    serde_json::to_string(&status).map_err(|why| error::plain(py, "StudyError", why))
}

/// Reduces the blocks in a folder: as the execution of a step, with the names of the plant.
#[pyfunction]
#[pyo3(signature = (folder, threads, force, progress, /))]
pub(crate) fn reduce<'py>(
    py: Python<'py>,
    folder: PathBuf,
    threads: Option<Bound<'py, PyAny>>,
    force: bool,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let threads = given("threads", threads.as_ref(), COUNT)?;
    let reduced = interruptible(py, progress.as_ref(), move |context| {
        let options = RunOptions {
            threads,
            force,
            limits: Limits::NONE,
            progress: context.progress,
            cancel: context.cancel,
            ..RunOptions::default()
        };
        reduce_sweep(&folder, &options)
    })?;
    answer(py, reduced)
}
