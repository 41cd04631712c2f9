//! Why a request has no result.

use luenberger_study::deployment::ExportRefusal;
use luenberger_study::table::TableError;
use luenberger_study::{Diagnostics, StudyError};
use serde_json::{Value, json};

use crate::message::MessageError;

/// Why a request has no result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudioError {
    /// The request is no message.
    #[error(transparent)]
    Message(#[from] MessageError),
    /// The request asks for what there is not.
    #[error(
        "there is no request {wanted:?}; there are about, check, run, export, verify, advise, tune, columns and zip"
    )]
    Unknown {
        /// What it asks for.
        wanted: String,
    },
    /// A part of the request is missing or not what it should be.
    #[error("the request needs {key}: {expected}")]
    Key {
        /// The key.
        key: &'static str,
        /// What is expected.
        expected: String,
    },
    /// A study that is too long for an editor.
    #[error(
        "the study has {found} bytes, and at most {limit} are read here: put long tables into files, or run it with luenberger run"
    )]
    Long {
        /// Its bytes.
        found: usize,
        /// The most.
        limit: usize,
    },
    /// The study cannot be read or executed.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// The observer is not exported.
    #[error(transparent)]
    Export(ExportRefusal),
    /// The file is no table.
    #[error("{name}: {error}")]
    Table {
        /// The file.
        name: String,
        /// Why.
        error: TableError,
    },
    /// The archive cannot be made.
    #[error("the archive cannot be made: {0}")]
    Archive(#[from] zip::result::ZipError),
    /// The results cannot be written as JSON.
    #[error("the results cannot be written: {0}")]
    Json(#[from] serde_json::Error),
}

impl From<ExportRefusal> for StudioError {
    fn from(refusal: ExportRefusal) -> Self {
        match refusal {
            ExportRefusal::Study(error) => Self::Study(error),
            refusal => Self::Export(refusal),
        }
    }
}

impl StudioError {
    /// What the command says: all mistakes of a study with their lines, or the error.
    fn rendered(&self) -> String {
        match self.mistakes() {
            Some(mistakes) => mistakes.render(false),
            None => format!("error: {self}\n"),
        }
    }

    fn mistakes(&self) -> Option<&Diagnostics> {
        match self {
            Self::Study(error) => error.diagnostics(),
            _ => None,
        }
    }

    /// In one sentence; of a study with mistakes the first.
    fn sentence(&self) -> String {
        let located = self.mistakes().map(Diagnostics::located).unwrap_or_default();
        let Some(first) = located.first() else { return self.to_string() };
        let more =
            if located.len() > 1 { format!(" (the first of {} mistakes)", located.len()) } else { String::new() };
        let (file, line, column) = (&first.file, first.line, first.column);
        format!("{file}: line {line}, column {column}: {}, {}{more}", first.message, first.expected)
    }

    /// The answer that says so.
    pub(crate) fn to_json(&self) -> Value {
        let diagnostics = self.mistakes().map(located).unwrap_or_default();
        json!({
            "error": { "message": self.sentence(), "diagnostics": diagnostics },
            "rendered": self.rendered(),
        })
    }
}

/// The mistakes with their places.
pub(crate) fn located(mistakes: &Diagnostics) -> Vec<Value> {
    let length = mistakes.source().text().len();
    let one = |mistake: &luenberger_study::Diagnostic| {
        let place = mistakes.source().place(mistake.span.start);
        let from = mistake.span.start.min(length);
        json!({
            "from": from,
            "to": mistake.span.end.clamp(from, length),
            "line": place.line,
            "column": place.column,
            "message": mistake.message,
            "expected": mistake.expected,
            "help": mistake.help,
            "severity": "error",
        })
    };
    mistakes.list().iter().map(one).collect()
}
