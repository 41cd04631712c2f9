//! Scores of simulations and sweeps as data.

use serde::Serialize;

/// The simulations.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SimulationReport {
    /// The end time.
    pub duration: f64,
    /// The initial state x(0).
    pub x0: Vec<f64>,
    /// x at the end.
    pub x_end: Vec<f64>,
    /// The seed of the noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// How the simulated plant differs from the model that observers are designed for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth: Option<String>,
    /// When outputs are measured, and what observers make of those that are not; none if all are read at all times.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measurements: Option<String>,
    /// The samples of observers at varying periods.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sampling: Vec<SamplingReport>,
    /// Where errors are scored, and in which units.
    pub scoring: ScoringReport,
    /// One row for each designed observer.
    pub rows: Vec<RunReport>,
}

/// The samples of an observer at varying periods in a simulation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SamplingReport {
    /// Its name.
    pub observer: String,
    /// How many samples were due.
    pub samples: usize,
    /// How many of them were missed.
    pub missed: usize,
    /// The largest number missed in a row.
    pub missed_in_a_row: usize,
    /// The shortest period.
    pub shortest: f64,
    /// The longest period.
    pub longest: f64,
    /// The seed of the samples.
    pub seed: u64,
    /// Whether all are within the periods and misses of the design.
    pub within_design: bool,
    /// The same as a sentence, with what is proved of it.
    pub words: String,
}

/// Where errors are scored, the same for all observers, and in which units their norm is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScoringReport {
    /// The period of the scores; none in continuous time.
    pub period: Option<f64>,
    /// The scale of each state, by which its error is divided in the norm |e|; none if no norm is formed.
    pub scale: Option<Vec<f64>>,
    /// The settling band of the norm, as a fraction of |e(0)|.
    pub band: f64,
    /// Which estimates of filters are scored: `filtered`, after the measurement of a sample, or `predicted`, before it.
    pub estimates: &'static str,
    /// The same as sentences.
    pub words: Vec<String>,
}

/// Result of one observer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunReport {
    /// The observer.
    pub observer: String,
    /// The estimate it is given at the start.
    pub initial: Vec<f64>,
    /// The scores; none if the run ended early.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub merits: Option<MeritsReport>,
    /// Why the run ended early.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
}

/// Scores of an error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeritsReport {
    /// Those of the norm; none without a scale.
    #[serde(flatten)]
    pub norm: Option<NormReport>,
    /// The root mean square for each state.
    pub rms_by_state: Vec<f64>,
    /// The scores of each state.
    pub states: Vec<StateReport>,
}

/// Scores of the error norm |e| in units of the scale.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NormReport {
    /// |e(0)|.
    pub initial: f64,
    /// The settling band.
    pub band: f64,
    /// The first time at which |e| is within the band.
    pub settling_first: Option<f64>,
    /// The time from which |e| stays in the band.
    pub settling_last: Option<f64>,
    /// The maximum of |e|.
    pub peak: f64,
    /// The root mean square of |e|.
    pub rms: f64,
    /// |e| at the end time.
    pub last: f64,
    /// The root mean square of |e| over the second half of the run.
    pub steady_rms: f64,
}

/// Scores of the error of one state, in its unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StateReport {
    /// The state.
    pub state: String,
    /// Its unit, if the file gives one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// The error at the start.
    pub initial: f64,
    /// The root mean square.
    pub rmse: f64,
    /// The largest magnitude.
    pub peak: f64,
    /// The largest magnitude after the first change of sign; 0 if the sign never changes.
    pub overshoot: f64,
    /// The time from which the magnitude stays within 5 % of that at the start; none if it does not, or if the error
    /// starts at 0.
    pub settling_5: Option<f64>,
    /// Likewise for 2 %.
    pub settling_2: Option<f64>,
    /// The magnitude at the end.
    pub last: f64,
    /// The root mean square over the second half of the run.
    pub steady_rmse: f64,
}

/// The sweep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SweepReport {
    /// The swept parameter.
    pub parameter: String,
    /// Runs at each value.
    pub ensemble: usize,
    /// Its values.
    pub values: Vec<f64>,
    /// Where errors are scored, and in which units.
    pub scoring: ScoringReport,
    /// One row for each observer and value.
    pub rows: Vec<SweepRow>,
}

/// One observer at one value.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct SweepRow {
    /// The observer.
    pub observer: String,
    /// The value.
    pub value: f64,
    /// Number of runs of the ensemble that finished.
    pub finished: usize,
    /// Median over the ensemble of the settling time, from which |e| stays in the band; none if most runs do not
    /// settle, or without a scale.
    pub settling: Option<f64>,
    /// Median of the root mean square of |e|.
    pub rms: Option<f64>,
    /// Median and maximum over the ensemble of max |e|.
    pub peak: Option<f64>,
    /// Median of |e| at the end time.
    pub last: Option<f64>,
    /// Median of the root mean square of |e| over the second half of the run.
    pub steady_rms: Option<f64>,
    /// Medians of the scores of each state; empty if no run finished.
    pub states: Vec<StateReport>,
    /// The 5th and the 95th percentile of the same scores over an ensemble; empty for one run.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub percentiles: Vec<PercentileReport>,
    /// Count, mean, standard deviation and extremes of each score over an ensemble; empty for one run.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub statistics: Vec<ScoreStatistics>,
    /// Why there is no run, if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
}

/// A score over an ensemble.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScoreStatistics {
    /// The score, as in the head of `sweep.csv`.
    pub score: String,
    /// Number of runs that have it: those that finished, and of a settling time those that settle.
    pub count: u64,
    /// Its mean over these runs.
    pub mean: Option<f64>,
    /// Its standard deviation, with the divisor count - 1.
    pub deviation: Option<f64>,
    /// The smallest value.
    pub min: Option<f64>,
    /// The largest value.
    pub max: Option<f64>,
}

/// A percentile of the scores over an ensemble.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PercentileReport {
    /// 5 or 95.
    pub percent: u8,
    /// Settling time; none if it is infinite, or without a scale.
    pub settling: Option<f64>,
    /// Root mean square of |e|.
    pub rms: Option<f64>,
    /// Largest |e|.
    pub peak: Option<f64>,
    /// |e| at the end time.
    pub last: Option<f64>,
    /// Root mean square of |e| over the second half of the run.
    pub steady_rms: Option<f64>,
    /// The scores of each state.
    pub states: Vec<StateReport>,
}
