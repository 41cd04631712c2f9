//! How a study is executed: where its results go, who is told of the progress, and who may interrupt.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::StudyError;

/// The steps of a study. Each does what it needs of the steps before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// What the outputs see of the states.
    Observe,
    /// The observers, with their certificates in words.
    Design,
    /// The observers, with their certificates written to files.
    Certify,
    /// The runs, with trajectories and figures.
    Simulate,
    /// The observers side by side.
    Compare,
    /// The sweep.
    Sweep,
    /// All of them, and the report.
    Run,
}

impl Step {
    /// The name of the step, which is that of the command.
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

/// How far an execution is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress<'a> {
    /// What is being done: `design`, `simulate`, `sweep`, `figures`, ...
    pub stage: &'a str,
    /// What it is done to: the name of an observer or of a file.
    pub item: &'a str,
    /// How many items are done.
    pub done: usize,
    /// Of how many.
    pub total: usize,
}

/// How a study is executed.
pub struct RunOptions<'a> {
    /// The folder of the results, which is made if it is not there; nothing is written without it.
    pub output: Option<PathBuf>,
    /// Told of every item that is done, from any thread.
    pub progress: &'a (dyn Fn(Progress<'_>) + Sync),
    /// Looked at between items, and all through a design of the kind `kkl-numerical`: true ends the execution with
    /// [`StudyError::Interrupted`].
    pub cancel: &'a AtomicBool,
    /// The number of threads; as many as there are processors without it. Results do not depend on it.
    pub threads: Option<usize>,
}

impl Default for RunOptions<'_> {
    /// Nothing is written, nobody is told, nobody interrupts.
    fn default() -> Self {
        static NEVER: AtomicBool = AtomicBool::new(false);
        Self { output: None, progress: &|_| (), cancel: &NEVER, threads: None }
    }
}

impl RunOptions<'_> {
    /// An error once the user has interrupted.
    pub(crate) fn check(&self) -> Result<(), StudyError> {
        if self.cancel.load(Ordering::Relaxed) { Err(StudyError::Interrupted) } else { Ok(()) }
    }

    pub(crate) fn interrupted(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }

    pub(crate) fn tell(&self, stage: &str, item: &str, done: usize, total: usize) {
        (self.progress)(Progress { stage, item, done, total });
    }
}
