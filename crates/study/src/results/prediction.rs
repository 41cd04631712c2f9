//! One-step predictions of an observer on the part of a log that is held out.

use std::fmt::Write;

use luenberger_proof::wording::significant;
use serde::Serialize;

/// How well an observer predicts the measurements of a log that it does not have yet, on the rows that are held out.
/// Observers that are compared are judged on the same rows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PredictionReport {
    /// The geometric mean over the measurements of `rms/deviation` of their outputs: 1 is no better than the mean.
    pub relative: f64,
    /// The outputs that were measured.
    pub outputs: Vec<PredictionOf>,
    /// The mean of the log-likelihood of a measurement, given those before it, of a filter that computes the covariance
    /// of its innovations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub log_likelihood: Option<f64>,
    /// The root mean square of the errors of the states that the log knows, in units of a scale, or of a single state
    /// in its own unit; none without a true state, and of several without a scale.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// The error of each of these states.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub states: Vec<ErrorOf>,
}

/// The predictions of an output.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PredictionOf {
    /// The output.
    pub output: String,
    /// How many measurements there are.
    pub samples: usize,
    /// The root mean square of y - h.
    pub rms: f64,
    /// The standard deviation of y from its mean.
    pub deviation: f64,
}

/// The error of a state on the rows that are held out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ErrorOf {
    /// The state.
    pub state: String,
    /// At how many rows it is known.
    pub samples: usize,
    /// The root mean square.
    pub rms: f64,
}

/// A sweep on a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LogSweepReport {
    /// The parameter.
    pub parameter: String,
    /// Its values.
    pub values: Vec<f64>,
    /// Which rows the observers are judged on.
    pub held_out: String,
    /// One for each observer at each value.
    pub rows: Vec<LogSweepRow>,
}

/// An observer at a value of a sweep on a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LogSweepRow {
    /// The observer.
    pub observer: String,
    /// The value.
    pub value: f64,
    /// Its scores; none without a run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on_log: Option<PredictionReport>,
    /// At how many rows of the log it leaves the region of its design.
    pub rows_outside: usize,
    /// Why there is no run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
}

impl LogSweepReport {
    /// Where each observer predicts best, a sentence each: of an observer with predictions at two values at least.
    pub fn best(&self) -> Vec<String> {
        let mut names: Vec<&str> = self.rows.iter().map(|row| row.observer.as_str()).collect();
        names.dedup();
        let sentence = |name: &str| {
            let of = || self.rows.iter().filter(|row| row.observer == name);
            let judged: Vec<(f64, &PredictionReport)> =
                of().filter_map(|row| Some((row.value, row.on_log.as_ref()?))).collect();
            if judged.len() < 2 {
                return None;
            }
            let short = |x: f64| significant(x, 4);
            let (value, best) = judged.iter().min_by(|a, b| a.1.relative.total_cmp(&b.1.relative))?;
            let parameter = &self.parameter;
            let mut text = format!(
                "{name}: the least relative innovation, {}, with {parameter} = {}",
                short(best.relative),
                short(*value)
            );
            let likely = judged.iter().filter_map(|(value, of)| Some((value, of.log_likelihood?)));
            if let Some((value, most)) = likely.max_by(|a, b| a.1.total_cmp(&b.1)) {
                _ = write!(text, "; the largest log-likelihood, {}, with {}", short(most), short(*value));
            }
            let errors = judged.iter().filter_map(|(value, of)| Some((value, of.error?)));
            if let Some((value, least)) = errors.min_by(|a, b| a.1.total_cmp(&b.1)) {
                _ = write!(text, "; the least error, {}, with {}", short(least), short(*value));
            }
            Some(text + ".")
        };
        names.into_iter().filter_map(sentence).collect()
    }
}
