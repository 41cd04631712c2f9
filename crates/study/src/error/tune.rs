//! Errors of fitting a filter to a log.

use std::path::PathBuf;

use luenberger_proof::wording::{counted, significant};

/// Error of fitting a filter to a log.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TuneError {
    /// The observer does not run with the values of the study.
    #[error("{observer} cannot be judged on the log with the values of the study: {why}")]
    NoStart {
        /// The observer.
        observer: String,
        /// Why.
        why: String,
    },
    /// The gate leaves too few measurements.
    #[error(
        "with the values of the study the gate of {observer} rejects {} of {} on the rows that are {part}, and at least {least} have to be left: tune without `gate` first, or with larger `w` or `v`",
        counted(*rejected, "measurement"), measurements + rejected
    )]
    Gate {
        /// The observer.
        observer: String,
        /// What is done with these rows: `fitted` or `held out`.
        part: &'static str,
        /// Measurements that are rejected.
        rejected: usize,
        /// Those that are left.
        measurements: usize,
        /// How many are needed.
        least: usize,
    },
    /// The likelihood does not depend on a parameter.
    #[error(
        "no sign that the log depends on {name}: the log-likelihood is {} at {} and at {} as at {}{because}; leave it out of `parameters`, or use a log in which it matters",
        significant(*log_likelihood, 9), significant(*low, 4), significant(*high, 4), significant(*value, 4)
    )]
    NoInformation {
        /// The parameter.
        name: String,
        /// The log-likelihood.
        log_likelihood: f64,
        /// The value of the study.
        value: f64,
        /// A lower value.
        low: f64,
        /// A higher value.
        high: f64,
        /// What the log lacks, such as an input that is not constant.
        because: String,
    },
    /// The likelihood grows without bound.
    #[error(
        "no maximum of the likelihood was found: it still grows where {name} {} {} ({} more over the last factor of 10): {advice}",
        if *falls { "falls to" } else { "rises to" }, significant(*at, 4), significant(*gain, 3)
    )]
    NoMaximum {
        /// The parameter.
        name: String,
        /// Whether it falls; otherwise it rises.
        falls: bool,
        /// The value at the bound.
        at: f64,
        /// What the log-likelihood gains.
        gain: f64,
        /// What can be done.
        advice: &'static str,
    },
    /// The file of the tuned study exists.
    #[error("{} exists: --force writes over it", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// The tuned study cannot be written as text.
    #[error("the tuned values cannot be written into the text of the study: {why}")]
    Text {
        /// Why.
        why: String,
    },
}
