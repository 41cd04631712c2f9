//! Results of observers on a measured log, and of filters wherever they run.

use luenberger_sim::replay::Consistency;
use serde::Serialize;

/// Observers on a measured log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LogReport {
    /// Number of rows.
    pub samples: usize,
    /// First time.
    pub start: f64,
    /// Last time.
    pub end: f64,
    /// The median time from one row to the next.
    pub median_period: f64,
    /// The gaps: [last row before it, first row after it].
    pub gaps: Vec<[f64; 2]>,
    /// What observers in continuous time see of an output between the rows: `predicted`, as the model moves it, `held`,
    /// or `linear`, straight lines, which know the future.
    pub interpolation: &'static str,
    /// Which estimates of filters have the errors: `filtered`, after the measurement of a row, or `predicted`, before.
    pub estimates: &'static str,
    /// The outputs that are not measured in every row.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub columns: Vec<LogColumn>,
    /// One row for each designed observer.
    pub rows: Vec<InnovationReport>,
}

/// An output that is not measured in every row of the log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LogColumn {
    /// The output.
    pub output: String,
    /// In how many rows it is measured.
    pub samples: usize,
    /// The median time from one measurement to the next.
    pub median_period: f64,
}

/// One observer on the log. Innovations, NIS and NEES are over the second half of the log, which excludes the initial
/// transient; the errors are over the whole log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InnovationReport {
    /// The observer.
    pub observer: String,
    /// One for each output that was measured.
    pub outputs: Vec<InnovationOf>,
    /// The estimate at the end time.
    pub estimate: Vec<f64>,
    /// For a Kalman filter: the standard deviations of this estimate.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub deviation: Vec<f64>,
    /// For a Kalman filter: the mean of nu' S^-1 nu, as in `nis`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normalised: Option<f64>,
    /// For a Kalman filter: normalised innovation squared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nis: Option<ConsistencyReport>,
    /// For a Kalman filter on a log with true states: normalised estimation error squared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nees: Option<ConsistencyReport>,
    /// The errors of the states whose true values are in the log.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<StateScore>,
    /// With `smooth`: the estimates from the whole log.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smoothed: Option<SmoothedReport>,
    /// For an observer at varying periods: the rows as its samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sampling: Option<LogSampling>,
    /// How many rows of the log the observer has used.
    pub rows_used: usize,
    /// Samples of a sampled-data observer that were interpolated between rows; 0 unless `interpolation` is `linear`.
    pub interpolated: usize,
    /// Why the run ended early.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
}

/// The rows of a log as the samples of an observer at varying periods.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LogSampling {
    /// Rows that corrected its estimate.
    pub corrections: usize,
    /// The shortest time between two corrections.
    pub shortest: f64,
    /// The longest time between two corrections.
    pub longest: f64,
    /// The fewest samples that were missed at the longest period of the design.
    pub missed: usize,
    /// The largest number of them in a row.
    pub missed_in_a_row: usize,
    /// Corrections that are not within the periods and misses of the design, or of which an output is missing.
    pub outside: usize,
    /// The same as a sentence, with what is proved of it.
    pub words: String,
}

/// The smoothed estimates of a filter, over the whole log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SmoothedReport {
    /// The estimate at the first time.
    pub estimate: Vec<f64>,
    /// One for each state.
    pub deviations: Vec<SmoothedDeviation>,
    /// On a log with true states: normalised estimation error squared, over the second half.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nees: Option<ConsistencyReport>,
    /// The errors of the states whose true values are in the log.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<StateScore>,
}

/// The root mean square over the log of the standard deviations that a filter computes for the error of a state.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SmoothedDeviation {
    /// The state.
    pub state: String,
    /// Of the estimates from the measurements up to their time.
    pub filtered: f64,
    /// Of those from the whole log.
    pub smoothed: f64,
}

impl LogReport {
    /// Which estimates of filters have the errors.
    pub fn estimates_in_words(&self) -> &'static str {
        if self.estimates == "predicted" {
            "of filters before the measurement of a row (predicted)"
        } else {
            "of filters after the measurement of a row (filtered)"
        }
    }
}

impl InnovationReport {
    /// The errors by the name of the estimates: the observer's own, and `NAME, smoothed`.
    pub fn errors_of_estimates(&self) -> impl Iterator<Item = (String, &StateScore)> {
        let own = self.errors.iter().map(|error| (self.observer.clone(), error));
        let smoothed = self.smoothed.iter().flat_map(|smoothed| &smoothed.errors);
        own.chain(smoothed.map(|error| (format!("{}, smoothed", self.observer), error)))
    }

    /// The tests of consistency likewise, of a filter; the smoothed estimates have no innovation.
    pub fn tests_of_estimates(&self) -> impl Iterator<Item = FilterReport> {
        let own = self.nis.as_ref().map(|nis| FilterReport {
            observer: self.observer.clone(),
            nis: Some(nis.clone()),
            nees: self.nees.clone(),
            stationary: false,
        });
        let smoothed = self.smoothed.as_ref().and_then(|smoothed| smoothed.nees.as_ref()).map(|nees| FilterReport {
            observer: format!("{}, smoothed", self.observer),
            nis: None,
            nees: Some(nees.clone()),
            stationary: false,
        });
        own.into_iter().chain(smoothed)
    }
}

/// The innovation of one output.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InnovationOf {
    /// The output.
    pub output: String,
    /// Over how many measurements, without the rejected ones.
    pub samples: usize,
    /// How many the gate of the filter has rejected as outliers.
    #[serde(skip_serializing_if = "is_zero")]
    pub rejected: usize,
    /// The mean, which shows a bias of a sensor or of the model.
    pub mean: f64,
    /// The root mean square.
    pub rms: f64,
    /// The largest magnitude.
    pub peak: f64,
    /// p-value of the Ljung-Box test of whiteness; none for fewer than 20 samples.
    pub white: Option<f64>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// The error x - xhat of one state.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StateScore {
    /// The state.
    pub state: String,
    /// Over how many true values.
    pub samples: usize,
    /// The root mean square.
    pub rmse: f64,
    /// The largest magnitude.
    pub peak: f64,
    /// The last error.
    pub last: f64,
}

/// A chi-squared test of consistency: whether the covariance of a filter is that of its innovations (NIS) or errors
/// (NEES).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConsistencyReport {
    /// The mean of the normalised squares; 0 without samples.
    pub mean: f64,
    /// Its expected value: the mean number of degrees of freedom per sample, which is the rank of the covariance.
    pub expected: f64,
    /// The acceptance region of the mean, two-sided, 95 %: [low, high].
    pub region: [f64; 2],
    /// Over how many samples: those with a degree of freedom.
    pub samples: usize,
    /// In how many samples the covariance is singular; its pseudo-inverse takes the place of the inverse.
    #[serde(skip_serializing_if = "is_zero")]
    pub singular: usize,
    /// In how many of these the error has a component for which the filter has no variance.
    #[serde(skip_serializing_if = "is_zero")]
    pub outside: usize,
    /// How many samples have no square: the covariance is not finite, or the update had no result.
    #[serde(skip_serializing_if = "is_zero")]
    pub left_out: usize,
    /// Whether the mean lies in the region, and no error is without variance.
    pub accepted: bool,
}

/// A filter in the simulation, over all its samples; a stationary one over those of the second half.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FilterReport {
    /// The observer.
    pub observer: String,
    /// Normalised innovation squared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nis: Option<ConsistencyReport>,
    /// Normalised estimation error squared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nees: Option<ConsistencyReport>,
    /// Whether its covariance is the stationary one.
    #[serde(skip_serializing_if = "is_false")]
    pub stationary: bool,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_false(is: &bool) -> bool {
    !*is
}

/// How an interval observer enclosed the state in the simulation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct IntervalReport {
    /// The observer.
    pub observer: String,
    /// The share of the rows at which every state was within its bounds, from 0 to 1.
    pub coverage: f64,
    /// The mean width of the bounds of each state, upper minus lower.
    pub mean_width: Vec<f64>,
    /// The width at the end of the run.
    pub final_width: Vec<f64>,
}

impl IntervalReport {
    /// The widths of a run, by rows of x, xhat and the half-widths.
    pub(crate) fn of(
        observer: &str,
        (x, xhat): (&nalgebra::DMatrix<f64>, &nalgebra::DMatrix<f64>),
        half: &nalgebra::DMatrix<f64>,
    ) -> Option<Self> {
        let rows = x.nrows();
        if rows == 0 || xhat.shape() != x.shape() || half.shape() != x.shape() {
            return None;
        }
        let within = |k: &usize| (0..x.ncols()).all(|i| (x[(*k, i)] - xhat[(*k, i)]).abs() <= half[(*k, i)]);
        let enclosed = (0..rows).filter(within).count();
        Some(Self {
            observer: observer.to_owned(),
            coverage: enclosed as f64 / rows as f64,
            mean_width: half.column_iter().map(|column| 2.0 * column.mean()).collect(),
            final_width: half.row(rows - 1).iter().map(|half| 2.0 * half).collect(),
        })
    }

    /// `100 %`, rounded down: 100 only if every row is enclosed.
    pub fn coverage_in_words(&self) -> String {
        format!("{} %", luenberger_proof::wording::at_least(100.0 * self.coverage, 4))
    }
}

impl From<Consistency> for ConsistencyReport {
    fn from(test: Consistency) -> Self {
        let (low, high) = test.bounds;
        Self {
            mean: test.mean,
            expected: test.expected,
            region: [low, high],
            samples: test.samples,
            singular: test.singular,
            outside: test.outside,
            left_out: test.left_out,
            accepted: test.accepted(),
        }
    }
}

impl ConsistencyReport {
    /// `1.04, in [0.91, 1.09]`: the mean with its acceptance region, and in brackets what limits it. A mean may be in
    /// the region where the test is not accepted, because an error is without variance.
    pub fn in_words(&self) -> String {
        use luenberger_proof::wording::significant;
        let word = if self.mean > self.region[1] {
            "above"
        } else if self.mean < self.region[0] {
            "below"
        } else {
            "in"
        };
        let [low, high] = self.region.map(|end| significant(end, 3));
        let all = self.samples.max(self.singular) + self.left_out;
        let counts = [
            (self.singular, "P is singular"),
            (self.outside, "an error has no variance"),
            (self.left_out, "there is no result"),
        ];
        let limits: Vec<String> = counts
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{what} at {count} of {all} samples"))
            .collect();
        let limits = if limits.is_empty() { String::new() } else { format!(" ({})", limits.join(", ")) };
        if self.samples == 0 {
            return format!("-{limits}");
        }
        format!("{}, {word} [{low}, {high}]{limits}", significant(self.mean, 3))
    }
}

impl InnovationOf {
    /// `1450 (6 rejected)`: over how many measurements.
    pub fn samples_in_words(&self) -> String {
        match self.rejected {
            0 => self.samples.to_string(),
            rejected => format!("{} ({rejected} rejected)", self.samples),
        }
    }

    /// `3.7e-169 (rejected)`: the p-value of the test of whiteness, at the level 5 %.
    pub fn whiteness_in_words(&self) -> Option<String> {
        self.white.map(whiteness)
    }
}

/// `3.7e-169 (rejected)`: a p-value at the level 5 %.
pub(crate) fn whiteness(p: f64) -> String {
    let digits = luenberger_proof::wording::significant(p, 2);
    format!("{digits} ({})", if p < 0.05 { "rejected" } else { "not rejected" })
}

/// How probable a model was, of a filter that decides between several, over the rows of a simulation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ModelReport {
    /// The filter.
    pub observer: String,
    /// The model.
    pub model: String,
    /// The mean of its probability.
    pub mean: f64,
    /// The share of the rows in which it is the most probable one.
    pub most_probable: f64,
    /// Its probability at the end.
    pub last: f64,
}
