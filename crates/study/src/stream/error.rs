//! Why a row of a stream is passed over, or the stream ends; why a saved state is refused.

use luenberger_proof::wording::significant;

use crate::table::TableError;

/// Why a row has no estimate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StreamError {
    /// The columns that are needed are not there.
    #[error(transparent)]
    Columns(TableError),
    /// A row that cannot be read.
    #[error(transparent)]
    Row(#[from] TableError),
    /// A row whose time is not later than that of the row before.
    #[error(
        "line {line}: the time {now} is not after {before}, the time of the row before; each row of a stream is one sample"
    )]
    Backwards {
        /// The line.
        line: u64,
        /// Its time.
        now: f64,
        /// The time of the row before.
        before: f64,
    },
    /// A row that comes before its sample.
    #[error(
        "line {line}: the time {now} is only {} after the row before, less than half a period ({period})",
        significant(*elapsed, 6)
    )]
    TooEarly {
        /// The line.
        line: u64,
        /// Its time.
        now: f64,
        /// Time since the row before.
        elapsed: f64,
        /// The period.
        period: f64,
    },
    /// A row long after the row before.
    #[error(
        "line {line}: the time {now} is {} after the row before, {periods} periods: the clock has jumped",
        significant(*elapsed, 6)
    )]
    Jump {
        /// The line.
        line: u64,
        /// Its time.
        now: f64,
        /// Time since the row before.
        elapsed: f64,
        /// The same in periods.
        periods: f64,
    },
    /// An input that has no value yet.
    #[error("line {line}: the input `{name}` has no value yet; a stream begins with a row that has all inputs")]
    NoInput {
        /// The line.
        line: u64,
        /// The column.
        name: String,
    },
    /// No output has a value, where a row is a sample that has arrived.
    #[error(
        "line {line}: no output has a value, and a row of an observer at varying periods is a sample that has arrived"
    )]
    NoOutput {
        /// The line.
        line: u64,
    },
    /// An estimate that is not finite.
    #[error(
        "line {line}: the estimate of {observer} is no longer finite: it diverges, or the model is not defined there"
    )]
    Diverged {
        /// The line.
        line: u64,
        /// The observer.
        observer: String,
    },
}

impl StreamError {
    /// Whether no later row can have an estimate.
    pub fn ends_stream(&self) -> bool {
        matches!(self, Self::Columns(_) | Self::Diverged { .. })
    }
}

/// Why a stream does not go on from a saved state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ResumeError {
    /// A text that is no saved state.
    #[error("it is no saved state of a stream, or only a part of one")]
    NotSaved,
    /// Content that its digest does not fit.
    #[error("its content is not what was saved: its digest differs")]
    Damaged,
    /// A state of another study, observer or version.
    #[error("it was saved by another study, observer, period or version of the program")]
    Other,
}
