//! Errors of judging observers on the part of a log that is held out.

use luenberger_proof::wording::counted;

/// Error of judging observers on a log.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LogError {
    /// A part of the logs has too few measurements.
    #[error(
        "{what} {} with {}, and at least {least} are needed: {advice}",
        counted(*rows, "row"), counted(*measurements, of)
    )]
    TooShort {
        /// Which part: `the part that is held out has`.
        what: &'static str,
        /// Its rows.
        rows: usize,
        /// Its measurements, or true states.
        measurements: usize,
        /// What is counted: `measurement` or `true state`.
        of: &'static str,
        /// How many are needed.
        least: usize,
        /// What can be done.
        advice: &'static str,
    },
    /// Observers have too few rows in common.
    #[error(
        "the observers have {} in common on the part of the log that is held out, and at least {least} are needed; the fewest, {count}, are predicted by {observer}, whose samples lie on few rows, or whose gate rejects them",
        counted(*measurements, "measurement")
    )]
    NoCommonRows {
        /// The measurements that all of them predict.
        measurements: usize,
        /// How many are needed.
        least: usize,
        /// The observer that predicts the fewest.
        observer: String,
        /// How many it predicts.
        count: usize,
    },
    /// Observers know later measurements.
    #[error(
        "with `interpolation = \"linear\"` in [log] observers know the next measurement, and what they expect of it is no prediction: choose \"predicted\" or \"held\""
    )]
    Linear,
    /// Nothing bounds the states.
    #[error(
        "advise on a log needs to know where the states are: `region` in [advise], columns of all true states (`states` in [log]), or an observer in the study that runs on the log"
    )]
    NoRegion,
}
