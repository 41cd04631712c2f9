//! Errors of reading and executing a study.

pub(crate) mod log;
pub(crate) mod sweep;
pub(crate) mod tune;

use std::path::{Path, PathBuf};

use crate::diagnostic::Diagnostics;
use crate::limits::{Excess, duration};
use log::LogError;
use sweep::SweepError;
use tune::TuneError;

/// Error of reading or executing a study.
///
/// An observer that is not applicable to its plant, or a simulation that diverges, is not an error but a result in
/// [`Results`](crate::Results).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// The file has mistakes.
    #[error(transparent)]
    File(#[from] Diagnostics),
    /// A file could not be read or written.
    #[error("{}: {error}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        error: std::io::Error,
    },
    /// The results folder is not a folder.
    #[error("{} is not a folder", path.display())]
    NotAFolder {
        /// Its path.
        path: PathBuf,
    },
    /// The results folder has files, and none is known to be a result.
    #[error("{} has files and no manifest.json: choose a new or empty folder with -o, or write into this one with --force, which deletes none of its files", path.display())]
    ForeignFolder {
        /// Its path.
        path: PathBuf,
    },
    /// Another run writes into the results folder.
    #[error("{} is in use by another run of luenberger: wait until it has finished, or choose another folder with -o", path.display())]
    FolderInUse {
        /// Its path.
        path: PathBuf,
    },
    /// The estimated cost exceeds a limit.
    #[error("{0}")]
    TooExpensive(Excess),
    /// The time limit was reached. Finished files are on disk.
    #[error("stopped at the time limit ({}): finished results are kept; a longer limit: --limit time=48h", duration(*.limit))]
    TimeLimit {
        /// The limit in seconds.
        limit: f64,
    },
    /// A step needs a table that the study does not have.
    #[error("{step} needs {needs}, and the study has none")]
    Missing {
        /// The step.
        step: &'static str,
        /// What it needs.
        needs: &'static str,
    },
    /// A template that does not exist.
    #[error("there is no template {name:?}; {hint}")]
    Template {
        /// The requested name.
        name: String,
        /// The nearest name, or all names.
        hint: String,
    },
    /// The observability could not be analysed.
    #[error(transparent)]
    Linalg(#[from] luenberger_linalg::LinalgError),
    /// The plant could not be simulated.
    #[error("the plant could not be run: {0}")]
    Sim(#[from] luenberger_sim::SimError),
    /// The results could not be written as JSON.
    #[error("the results could not be written: {0}")]
    Json(#[from] serde_json::Error),
    /// A figure could not be drawn, or a table could not be written.
    #[error("{what}: {why}")]
    Output {
        /// The file.
        what: String,
        /// Why.
        why: String,
    },
    /// The requested threads could not be started.
    #[error("{0} threads could not be started")]
    Threads(usize),
    /// The blocks of a sweep.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// Observers on the part of a log that is held out.
    #[error(transparent)]
    OnLog(#[from] LogError),
    /// The fit of a filter to a log.
    #[error(transparent)]
    Tune(#[from] TuneError),
    /// The user interrupted. Finished files are on disk.
    #[error("interrupted: finished results are kept")]
    Interrupted,
}

/// Whether the output could not take the data: a full disk, a quota, a limit of file sizes.
pub fn is_storage(error: &std::io::Error) -> bool {
    use std::io::ErrorKind::{FileTooLarge, QuotaExceeded, StorageFull, WriteZero};
    matches!(error.kind(), StorageFull | QuotaExceeded | FileTooLarge | WriteZero)
}

impl StudyError {
    pub(crate) fn io(path: &Path, error: std::io::Error) -> Self {
        Self::Io { path: path.to_owned(), error }
    }

    /// Whether the output could not take the data: a full disk, a quota, a limit of file sizes.
    pub fn is_storage(&self) -> bool {
        matches!(self, Self::Io { error, .. } | Self::Sweep(SweepError::Write { error, .. }) if is_storage(error))
    }

    /// The mistakes of the file, for excerpts in colour.
    pub fn diagnostics(&self) -> Option<&Diagnostics> {
        match self {
            Self::File(diagnostics) => Some(diagnostics),
            _ => None,
        }
    }
}
