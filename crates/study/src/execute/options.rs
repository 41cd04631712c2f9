//! Options of an execution: output folder, progress callback, interruption.

use luenberger_clock::Instant;
use luenberger_wording::setters;
use std::sync::atomic::{AtomicBool, Ordering};

use super::folder::Output;
use super::threads;
use crate::error::StudyError;
use crate::limits::Limits;

/// The steps of a study. Each includes what it needs of the steps before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// Observability analysis.
    Observe,
    /// Designs, with their certificates as text.
    Design,
    /// Designs, with their certificates written to files.
    Certify,
    /// Simulations, with trajectories and figures.
    Simulate,
    /// Comparison of the observers.
    Compare,
    /// Parameter sweep.
    Sweep,
    /// All steps, and the report.
    Run,
}

impl Step {
    /// The name of the step, equal to that of the command.
    pub fn name(self) -> &'static str {
        match self {
            Self::Observe => "observe",
            Self::Design => "design",
            Self::Certify => "certify",
            Self::Simulate => "simulate",
            Self::Compare => "compare",
            Self::Sweep => "sweep",
            Self::Run => "run",
        }
    }
}

/// Progress of an execution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress<'a> {
    /// The stage: `design`, `simulate`, `sweep`, `figures`, ...
    pub stage: &'a str,
    /// The current item: the name of an observer or a file.
    pub item: &'a str,
    /// Number of finished items.
    pub done: usize,
    /// Total number of items.
    pub total: usize,
}

/// How a sweep is computed.
#[derive(Debug, Clone, Default)]
pub struct SweepOptions {
    /// Runs of a block (default: a sixteenth of the ensemble, from 32 to 1000).
    pub block_size: Option<u64>,
    /// Whether blocks that an earlier sweep has left in the results folder are deleted. Otherwise those of the same
    /// study are used, and those of another one are an error.
    pub restart: bool,
    /// Whether missing and damaged blocks are an error, and not computed.
    pub complete: bool,
    /// Where the scores of each run are written as comma-separated values.
    pub csv: RunsAsCsv,
    /// Bytes for the percentiles of a row (default 256 MiB). They are exact in any case; where the values do not fit,
    /// the blocks are read several times.
    pub percentile_memory: Option<usize>,
}

impl SweepOptions {
    setters! { block_size: u64, restart: bool, complete: bool, csv: RunsAsCsv, percentile_memory: usize }
}

/// Where the scores of each run are written as comma-separated values.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum RunsAsCsv {
    /// All in `sweep.csv`.
    #[default]
    One,
    /// Those of each block beside it.
    Blocks,
    /// Nowhere.
    None,
}

/// How a study is executed.
pub struct RunOptions<'a> {
    /// The results folder; without it nothing is written.
    pub output: Option<Output>,
    /// Whether to write into a results folder that has files and no manifest. Its files are kept.
    pub force: bool,
    /// Whether figures are written as SVG and PNG, too (default true). The report has its own in any case.
    pub figures: bool,
    /// Bounds on time and memory.
    pub limits: Limits,
    /// How a sweep is computed.
    pub sweep: SweepOptions,
    /// An instant at which the execution stops, if its time limit has not stopped it before (default none).
    pub until: Option<Instant>,
    /// Called for every finished item, from any thread.
    pub progress: &'a (dyn Fn(Progress<'_>) + Sync),
    /// Checked between items, and continuously during a design of the kind `kkl-numerical`: true ends the execution
    /// with [`StudyError::Interrupted`]. The time limit acts within designs and integrations too.
    pub cancel: &'a AtomicBool,
    /// Number of threads (default: number of processors). Results do not depend on it.
    pub threads: Option<usize>,
}

impl Default for RunOptions<'_> {
    /// No output, no progress, no interruption.
    fn default() -> Self {
        static NEVER: AtomicBool = AtomicBool::new(false);
        Self {
            output: None,
            force: false,
            figures: true,
            limits: Limits::default(),
            sweep: SweepOptions::default(),
            until: None,
            progress: &|_| (),
            cancel: &NEVER,
            threads: None,
        }
    }
}

impl<'a> RunOptions<'a> {
    setters! {
        output: Output, force: bool, figures: bool, limits: Limits, sweep: SweepOptions, until: Instant,
        progress: &'a (dyn Fn(Progress<'_>) + Sync), cancel: &'a AtomicBool, threads: usize,
    }
}

impl RunOptions<'_> {
    /// The number of threads of the execution.
    pub fn thread_count(&self) -> usize {
        self.threads.unwrap_or_else(threads::available)
    }

    /// Returns an error once the user has interrupted, or the time is over.
    pub(crate) fn check(&self) -> Result<(), StudyError> {
        if self.interrupted() { Err(StudyError::Interrupted) } else { Ok(()) }
    }

    pub(crate) fn interrupted(&self) -> bool {
        self.cancel.load(Ordering::Relaxed) || self.until.is_some_and(|until| Instant::now() >= until)
    }

    pub(crate) fn tell(&self, stage: &str, item: &str, done: usize, total: usize) {
        (self.progress)(Progress { stage, item, done, total });
    }
}
