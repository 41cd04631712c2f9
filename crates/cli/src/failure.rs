//! Why a command has no answer: a plain sentence, an exit code, and an object for machines.

use crate::exit::{INTERRUPTED, NEGATIVE, WRONG};
use crate::output::{self, is_coloured};
use luenberger_linalg::LinalgError;
use luenberger_lmi::sdpa::ReadError;
use luenberger_proof::certificate::Rejection;
use luenberger_study::import::ImportError;
use luenberger_study::{Diagnostics, StudyError};
use serde_json::{Map, Value};
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;
use thiserror::Error;

/// Why a command has no answer.
#[derive(Debug, Error)]
pub(crate) enum Failure {
    /// A file cannot be read.
    #[error("{origin} cannot be read: {error}")]
    Read { origin: String, error: io::Error },
    /// More input than is taken for meant.
    #[error("{origin} is longer than {limit} bytes")]
    TooLong { origin: String, limit: u64 },
    /// Bytes that are not text.
    #[error("{origin}: line {line}, column {column}: byte {byte} of the input, {found:#04x}, is not UTF-8")]
    NotText { origin: String, line: usize, column: usize, byte: usize, found: u8 },
    /// Text that is not the JSON asked for.
    #[error("{origin}: line {line}, column {column}: {message}")]
    Json { origin: String, line: usize, column: usize, message: String },
    /// Matrices that make no problem, or a problem without a solution.
    #[error("{origin}: {error}")]
    Matrix { origin: String, error: LinalgError },
    /// Not a program in SDPA's format.
    #[error("{origin}: {error}")]
    Sdp { origin: String, error: ReadError },
    /// Not a model.
    #[error("{origin}: {error}")]
    Import { origin: String, error: ImportError },
    /// Not a certificate.
    #[error("{origin}: {error}")]
    Certificate { origin: String, error: Box<Rejection> },
    /// A study that cannot be read or executed.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// A file is there already.
    #[error("{path} is there already: give another name, or --force to write over it")]
    Exists { path: String },
    /// A file cannot be written.
    #[error("{path} cannot be written: {error}")]
    Write { path: String, error: io::Error },
    /// The answer cannot be written as JSON.
    #[error("the answer cannot be written as JSON: {0}")]
    Unwritable(#[from] serde_json::Error),
}

impl Failure {
    /// Why a file is not written.
    pub(crate) fn written(path: &Path, error: io::Error) -> Self {
        let path = path.display().to_string();
        if error.kind() == io::ErrorKind::AlreadyExists { Self::Exists { path } } else { Self::Write { path, error } }
    }

    /// A word for machines.
    fn kind(&self) -> &'static str {
        match self {
            Self::Read { .. } | Self::TooLong { .. } | Self::Exists { .. } | Self::Write { .. } => "file",
            Self::NotText { .. } | Self::Json { .. } | Self::Sdp { .. } | Self::Certificate { .. } => "syntax",
            Self::Import { error, .. } => match error {
                ImportError::Read { .. } | ImportError::TooLong { .. } => "file",
                ImportError::Json { .. } | ImportError::Damaged { .. } => "syntax",
                _ => "data",
            },
            Self::Study(error) => match error {
                StudyError::File(_) => "study",
                StudyError::Io { .. } => "file",
                StudyError::Interrupted => "interrupted",
                StudyError::Linalg(_) | StudyError::Sim(_) => "no-solution",
                StudyError::Missing { .. } | StudyError::Template { .. } => "usage",
                _ => "output",
            },
            Self::Matrix { error, .. } if is_wrong(error) => "data",
            Self::Matrix { .. } => "no-solution",
            Self::Unwritable(_) => "output",
        }
    }

    fn code(&self) -> u8 {
        match self.kind() {
            "no-solution" => NEGATIVE,
            "interrupted" => INTERRUPTED,
            _ => WRONG,
        }
    }

    /// Line and column, from 1, where there are such.
    fn place(&self) -> Option<(usize, usize)> {
        match self {
            Self::NotText { line, column, .. }
            | Self::Json { line, column, .. }
            | Self::Import { error: ImportError::Json { line, column, .. }, .. } => Some((*line, *column)),
            _ => None,
        }
    }

    /// Prints it: the sentence on standard error, and with `json` the object on standard output.
    pub(crate) fn report(&self, json: bool) -> ExitCode {
        if json {
            output::line(&self.object().to_string());
        }
        // Nobody is left to be told of a standard error that is closed.
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
            // Strings and counts: nothing that JSON could not hold.
            let located = serde_json::to_value(mistakes.located()).unwrap_or_default();
            error.insert("mistakes".to_owned(), located);
        }
        let mut object = Map::new();
        object.insert("error".to_owned(), Value::Object(error));
        Value::Object(object)
    }
}

/// The first mistake in a sentence, without its excerpt.
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

/// Whether the matrices make no problem at all; else the problem is one, and has no solution.
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
            | LinalgError::InvalidTolerance { .. }
    )
}
