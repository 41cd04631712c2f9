//! The fit as data.

use std::fmt;

use luenberger_proof::wording::significant;
use serde::{Serialize, Serializer};

use crate::results::{ConsistencyReport, PlantSummary};

/// What was fitted to the logs, and how good it is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TuneReport {
    /// The title of the study.
    pub title: String,
    /// The plant.
    pub plant: PlantSummary,
    /// The filter.
    pub observer: String,
    /// Its kind.
    pub kind: String,
    /// What was fitted by: `likelihood`, `innovations` or `errors`.
    pub criterion: &'static str,
    /// The states whose errors were fitted; empty for another criterion.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub reference: Vec<String>,
    /// The logs.
    pub logs: Vec<TunedLog>,
    /// Measurements that the gate of the filter rejects with the values of the study, left out for all values.
    pub rejected: usize,
    /// The log-likelihood of what is fitted, with the values of the study; of prediction errors, and errors of states
    /// in units of their deviations, that of a normal distribution with the variances that they have.
    pub log_likelihood_before: f64,
    /// The same, with the fitted values.
    pub log_likelihood: f64,
    /// The rms of the errors that are fitted relative to the deviations of the outputs or states, before and after;
    /// none for the likelihood of a filter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative: Option<[f64; 2]>,
    /// Searches, and how many of them ended within 0.01 of the largest log-likelihood.
    pub starts: usize,
    /// See [`starts`](Self::starts).
    pub agreeing: usize,
    /// Evaluations of the likelihood.
    pub evaluations: usize,
    /// The parameters, as the study names them.
    pub parameters: Vec<TunedParameter>,
    /// The same variances by autocovariance least squares, with the plant and the gain of the fit; empty where the
    /// method does not apply.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub autocovariances: Vec<ByAutocovariances>,
    /// What the data do not determine, and what else is to be known of the fit, in words.
    pub remarks: Vec<String>,
    /// The part of the logs that was not fitted; none if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held_out: Option<HeldOut>,
    /// Where the filter with the fitted values is inconsistent on that part, and what can be done.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// The profile likelihoods; empty if none were asked for.
    pub profiles: Vec<Profile>,
    /// The name of the file of the tuned study.
    pub file: String,
    /// The tuned study.
    #[serde(skip)]
    pub study: String,
    /// The files that were written into the results folder.
    pub files: Vec<String>,
    /// Files that stood in the way: their names, and the names they have now.
    #[serde(skip)]
    pub renamed: Vec<(String, String)>,
}

/// A variance by autocovariance least squares.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ByAutocovariances {
    /// The parameter.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// The standard error; none of a value that is 0, the least that is allowed.
    pub standard_error: Option<f64>,
}

/// A log.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct TunedLog {
    /// The file.
    pub file: String,
    /// Rows that are fitted.
    pub fitted: usize,
    /// Rows that are held out, the last ones.
    pub held_out: usize,
    /// Measurements that are fitted.
    pub measurements: usize,
}

/// A parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TunedParameter {
    /// Its name, such as `w[soc]`.
    pub name: String,
    /// Its unit, if the study gives one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Its value in the study.
    pub before: f64,
    /// The fitted value.
    pub after: f64,
    /// The standard error, from the observed information.
    pub standard_error: Option<f64>,
    /// The 95 % interval, from the observed information in the coordinate of the search.
    pub interval: Option<[f64; 2]>,
    /// The 95 % interval of the profile likelihood; an end is none where the profile does not reach it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile_interval: Option<[Option<f64>; 2]>,
    /// Why it has no interval.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub without: Option<NoInterval>,
}

impl TuneReport {
    /// What it was fitted by, in words.
    pub(super) fn by(&self) -> String {
        match self.criterion {
            "likelihood" => "the maximum likelihood of its innovations".to_owned(),
            "innovations" => "the least errors of its one-step predictions (innovations)".to_owned(),
            _ => format!("the least errors of {}", self.reference.join(", ")),
        }
    }

    /// The name of what is relative.
    pub(super) fn relative_name(&self) -> &'static str {
        if self.reference.is_empty() { "relative innovation" } else { "relative error" }
    }
}

impl TunedParameter {
    /// The 95 % interval, or why there is none.
    pub(super) fn interval_in_words(&self) -> String {
        match (self.interval, self.without) {
            (Some([low, high]), _) => format!("{} to {}", significant(low, 4), significant(high, 4)),
            (None, Some(why)) => why.to_string(),
            (None, None) => "-".to_owned(),
        }
    }
}

/// Why a parameter has no interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoInterval {
    /// It is at the lower bound that the study gives.
    AtLowerBound,
    /// It is at the upper bound that the study gives.
    AtUpperBound,
    /// It is at the least value that the search tries.
    Smallest,
    /// It is at the largest value that the search tries.
    Largest,
    /// The log does not determine it.
    Undetermined,
}

impl NoInterval {
    /// At the lower end (`sign` < 0) or the upper end of what is searched, which the study gives or not.
    pub(super) fn at_end(sign: f64, is_given: bool) -> Self {
        match (sign < 0.0, is_given) {
            (true, true) => Self::AtLowerBound,
            (false, true) => Self::AtUpperBound,
            (true, false) => Self::Smallest,
            (false, false) => Self::Largest,
        }
    }

    /// What the criterion does there, of a parameter at an end; `beyond` is what it does beyond a bound.
    pub(super) fn at_end_does(self, beyond: &str) -> Option<String> {
        match self {
            Self::AtLowerBound | Self::AtUpperBound => Some(format!("{beyond} beyond it")),
            Self::Smallest | Self::Largest => Some("is flat there".to_owned()),
            Self::Undetermined => None,
        }
    }
}

impl fmt::Display for NoInterval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::AtLowerBound => "at its lower bound",
            Self::AtUpperBound => "at its upper bound",
            Self::Smallest => "as small as the search allows",
            Self::Largest => "as large as the search allows",
            Self::Undetermined => "not determined by the log",
        })
    }
}

impl Serialize for NoInterval {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// The filter on what was held out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HeldOut {
    /// With the values of the study.
    pub before: Judged,
    /// With the fitted values.
    pub after: Judged,
}

/// How good a filter is on what was held out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judged {
    /// The log-likelihood; none if the filter failed.
    pub log_likelihood: Option<f64>,
    /// The rms of the errors relative to the deviations of the outputs or states; none for the likelihood of a filter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative: Option<f64>,
    /// Whether the innovations have the covariance that the filter computes.
    pub nis: Option<ConsistencyReport>,
    /// The innovations of each output of each log.
    pub innovations: Vec<JudgedOutput>,
    /// The root mean square errors of the states that the logs know.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<JudgedState>,
}

/// The innovations of an output.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JudgedOutput {
    /// The log.
    pub file: String,
    /// The output.
    pub output: String,
    /// How many there are.
    pub samples: usize,
    /// Their mean.
    pub mean: f64,
    /// Their root mean square.
    pub rms: f64,
    /// The p-value of the whiteness test of Ljung and Box; none for too few.
    pub white: Option<f64>,
}

/// The error of a state.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JudgedState {
    /// The state.
    pub state: String,
    /// At how many rows it is known.
    pub samples: usize,
    /// The root mean square.
    pub rms: f64,
}

/// The profile likelihood of a parameter: the largest log-likelihood for each of its values, less that of all.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Profile {
    /// The parameter.
    pub name: String,
    /// Its values.
    pub values: Vec<f64>,
    /// The log-likelihood less the largest.
    pub log_likelihood: Vec<f64>,
    /// What a normal distribution with the standard error would have; empty without one.
    pub parabola: Vec<f64>,
    /// Whether the values are spaced by ratios.
    pub is_log: bool,
}
