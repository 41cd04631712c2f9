//! Errors of a command: message, exit code, and JSON object.

use crate::answer::Answer;
use crate::exit::{INTERRUPTED, NEGATIVE, WRONG};
use crate::output::{self, is_coloured};
use luenberger_linalg::LinalgError;
use luenberger_lmi::sdpa::ReadError;
use luenberger_proof::certificate::Rejection;
use luenberger_proof::coq::CoqError;
use luenberger_proof::wording::counted;
use luenberger_study::deployment::ExportRefusal;
use luenberger_study::error::is_storage;
use luenberger_study::import::ImportError;
use luenberger_study::stream::{ResumeError, StreamError};
use luenberger_study::{Diagnostics, StudyError, SweepError};
use serde_json::{Map, Value};
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;
use thiserror::Error;

/// Error of a command.
#[derive(Debug, Error)]
pub(crate) enum Failure {
    /// A file cannot be read.
    #[error("{origin} cannot be read: {error}")]
    Read { origin: String, error: io::Error },
    /// A folder in place of a study.
    #[error("{folder} is a folder with {} in TOML and no study.toml: name the study", counted(*.found, "file"))]
    NoStudy { folder: String, found: usize },
    /// The input is longer than the limit.
    #[error("{origin} is longer than {limit} bytes")]
    TooLong { origin: String, limit: u64 },
    /// The input is not UTF-8 text.
    #[error("{origin}: line {line}, column {column}: byte {byte} of the input, {found:#04x}, is not UTF-8")]
    NotText { origin: String, line: usize, column: usize, byte: usize, found: u8 },
    /// The input is not JSON of the expected form.
    #[error("{origin}: line {line}, column {column}: {message}")]
    Json { origin: String, line: usize, column: usize, message: String },
    /// Invalid matrices, or a problem without a solution.
    #[error("{origin}: {error}")]
    Matrix { origin: String, error: LinalgError },
    /// Not a program in SDPA's format.
    #[error("{origin}: {error}")]
    Sdp { origin: String, error: ReadError },
    /// Not a state-space model.
    #[error("{origin}: {error}")]
    Import { origin: String, error: ImportError },
    /// Not a certificate.
    #[error("{origin}: {error}")]
    Certificate { origin: String, error: Box<Rejection> },
    /// A certificate without a file for Coq.
    #[error("{origin}: {error}")]
    Coq { origin: String, error: Box<CoqError> },
    /// Options or inputs that do not fit together.
    #[error("{0}")]
    Usage(&'static str),
    /// Matrices on the command line that are not those of the command.
    #[error("{0}")]
    Given(String),
    /// A study that cannot be read or executed.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// A study that was interrupted or ran into its time limit, and what it has finished.
    #[error("{error}")]
    Stopped { error: StudyError, finished: Box<Answer> },
    /// An observer that is not exported.
    #[error(transparent)]
    Export(ExportRefusal),
    /// A row of a stream that cannot be used.
    #[error(transparent)]
    Row(#[from] StreamError),
    /// A line that is too long for a row.
    #[error("line {line} is longer than {limit} bytes")]
    Line { line: u64, limit: usize },
    /// Rows of which none could be used.
    #[error("no row could be used: {} passed over", counted(*.refused as usize, "line"))]
    NoRow { refused: u64 },
    /// A state from which a stream does not go on.
    #[error("{path}: {error}. The file is as it was; without it the stream begins anew")]
    State { path: String, error: ResumeError },
    /// The output file exists already.
    #[error("{path} exists: choose another name, or overwrite it with --force")]
    Exists { path: String },
    /// A file cannot be written.
    #[error("{path} cannot be written: {error}")]
    Write { path: String, error: io::Error },
    /// The answer cannot be written as JSON.
    #[error("the answer cannot be written as JSON: {0}")]
    Unwritable(#[from] serde_json::Error),
}

impl From<ExportRefusal> for Failure {
    fn from(refusal: ExportRefusal) -> Self {
        match refusal {
            ExportRefusal::Study(error) => error.into(),
            refusal => Self::Export(refusal),
        }
    }
}

impl Failure {
    /// Why a file cannot be written.
    pub(crate) fn written(path: &Path, error: io::Error) -> Self {
        let path = path.display().to_string();
        if error.kind() == io::ErrorKind::AlreadyExists { Self::Exists { path } } else { Self::Write { path, error } }
    }

    /// Error kind for the JSON object.
    fn kind(&self) -> &'static str {
        match self {
            Self::Write { error, .. } if is_storage(error) => "storage",
            Self::Read { .. }
            | Self::NoStudy { .. }
            | Self::TooLong { .. }
            | Self::Exists { .. }
            | Self::Write { .. } => "file",
            Self::NotText { .. } | Self::Json { .. } | Self::Sdp { .. } | Self::Certificate { .. } => "syntax",
            Self::Import { error, .. } => match error {
                ImportError::Read { .. } | ImportError::TooLong { .. } => "file",
                ImportError::Json { .. } | ImportError::Text { .. } | ImportError::Damaged { .. } => "syntax",
                _ => "data",
            },
            Self::Study(error) | Self::Stopped { error, .. } => match error {
                StudyError::File(_) => "study",
                StudyError::Missing { .. }
                | StudyError::Template { .. }
                | StudyError::Sweep(SweepError::BlockSize { .. } | SweepError::TooManyBlocks { .. }) => "usage",
                error if error.is_storage() => "storage",
                StudyError::Io { .. }
                | StudyError::NotAFolder { .. }
                | StudyError::ForeignFolder { .. }
                | StudyError::FolderInUse { .. }
                | StudyError::Sweep(_) => "file",
                StudyError::Interrupted => "interrupted",
                StudyError::TooExpensive(_) => "limit",
                StudyError::TimeLimit { .. } => "time-limit",
                StudyError::Linalg(_) | StudyError::Sim(_) => "no-solution",
                _ => "output",
            },
            Self::Matrix { error, .. } if is_wrong(error) => "data",
            Self::Matrix { .. } | Self::Coq { .. } | Self::Row(StreamError::Diverged { .. }) => "no-solution",
            Self::Export(refusal) => match refusal {
                ExportRefusal::Design { .. } | ExportRefusal::Unproved { .. } => "no-solution",
                ExportRefusal::Numbers { .. } => "data",
                _ => "usage",
            },
            Self::Row(_) | Self::Line { .. } | Self::NoRow { .. } | Self::State { .. } => "data",
            Self::Usage(_) | Self::Given(_) => "usage",
            Self::Unwritable(_) => "output",
        }
    }

    fn code(&self) -> u8 {
        match self.kind() {
            "no-solution" | "storage" | "time-limit" => NEGATIVE,
            "interrupted" => INTERRUPTED,
            _ => WRONG,
        }
    }

    /// Line and column, from 1, if known.
    fn place(&self) -> Option<(usize, usize)> {
        match self {
            Self::NotText { line, column, .. }
            | Self::Json { line, column, .. }
            | Self::Import { error: ImportError::Json { line, column, .. }, .. } => Some((*line, *column)),
            _ => None,
        }
    }

    /// Prints the error: the message on standard error, and with `json` the object on standard output.
    pub(crate) fn report(&self, json: bool) -> ExitCode {
        if json {
            // The exit code says that there is an error, even if its object cannot be written.
            _ = output::line(&self.object().to_string());
        }
        if let (Self::Stopped { finished, .. }, false) = (self, json) {
            _ = output::text(finished.text());
        }
        // A failure to write to standard error cannot be reported.
        _ = match self {
            // All mistakes of the file, each with its excerpt.
            Self::Study(StudyError::File(mistakes)) => {
                writeln!(io::stderr(), "{}", mistakes.render(is_coloured(&io::stderr())).trim_end())
            }
            _ => writeln!(io::stderr(), "error: {self}"),
        };
        ExitCode::from(self.code())
    }

    fn object(&self) -> Value {
        let mut error = Map::new();
        error.insert("kind".to_owned(), self.kind().into());
        let message = match self {
            Self::Study(StudyError::File(mistakes)) => first(mistakes),
            _ => self.to_string(),
        };
        error.insert("message".to_owned(), message.into());
        if let Some((line, column)) = self.place() {
            error.insert("line".to_owned(), line.into());
            error.insert("column".to_owned(), column.into());
        }
        if let Self::Study(StudyError::File(mistakes)) = self {
            // Only strings and counts, so that serialization cannot fail.
            let located = serde_json::to_value(mistakes.located()).unwrap_or_default();
            error.insert("mistakes".to_owned(), located);
        }
        let mut object = Map::new();
        object.insert("error".to_owned(), Value::Object(error));
        if let Self::Stopped { finished, .. } = self {
            object.insert("finished".to_owned(), finished.json());
        }
        Value::Object(object)
    }
}

/// The first mistake as one sentence, without its excerpt.
fn first(mistakes: &Diagnostics) -> String {
    let located = mistakes.located();
    let count = located.len();
    located.first().map_or_else(
        || mistakes.to_string(),
        |mistake| {
            let (file, line, column) = (&mistake.file, mistake.line, mistake.column);
            let more = if count > 1 { format!(" (the first of {count} mistakes)") } else { String::new() };
            format!("{file}: line {line}, column {column}: {}, {}{more}", mistake.message, mistake.expected)
        },
    )
}

/// Whether the input is invalid; otherwise it is valid and the problem has no solution.
fn is_wrong(error: &LinalgError) -> bool {
    matches!(
        error,
        LinalgError::NotSquare { .. }
            | LinalgError::DimensionMismatch { .. }
            | LinalgError::Empty { .. }
            | LinalgError::NotFinite { .. }
            | LinalgError::NotSymmetric { .. }
            | LinalgError::NotPositiveDefinite { .. }
            | LinalgError::NotPositiveSemidefinite { .. }
            | LinalgError::PoleCount { .. }
            | LinalgError::PoleNotFinite { .. }
            | LinalgError::PoleUnpaired { .. }
            | LinalgError::PoleMultiplicity { .. }
            | LinalgError::InvalidPeriod { .. }
            | LinalgError::InvalidDelay { .. }
            | LinalgError::InvalidTolerance { .. }
            | LinalgError::InvalidFrequency { .. }
            | LinalgError::InvalidSpecification { .. }
    )
}
