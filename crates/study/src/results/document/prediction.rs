//! The scores on the part of a log that is held out, as columns of a table.

use crate::results::{PlantSummary, PredictionReport};

/// Errors of at most so many states have columns.
const MOST_STATES: usize = 6;

/// A number of the table.
pub(crate) struct Score {
    pub(crate) value: Option<f64>,
    /// Whether a larger value is better.
    pub(crate) is_gain: bool,
}

/// The columns that a table of these scores has.
pub(crate) struct Columns {
    outputs: Vec<String>,
    states: Vec<String>,
    has_likelihood: bool,
    /// Whether there is a norm of the errors of several states.
    has_norm: bool,
}

impl Columns {
    /// Those that some of the scores have.
    pub(crate) fn of<'a>(all: impl Iterator<Item = &'a PredictionReport>) -> Self {
        let all: Vec<&PredictionReport> = all.collect();
        let first = || all.first();
        let states = first().map_or(0, |of| of.states.len());
        Self {
            outputs: first().iter().flat_map(|of| &of.outputs).map(|of| of.output.clone()).collect(),
            states: first().iter().flat_map(|of| &of.states).take(MOST_STATES).map(|of| of.state.clone()).collect(),
            has_likelihood: all.iter().any(|of| of.log_likelihood.is_some()),
            has_norm: states > 1 && all.iter().any(|of| of.error.is_some()),
        }
    }

    /// Their titles.
    pub(crate) fn head(&self, plant: &PlantSummary) -> Vec<String> {
        let mut head = vec!["relative innovation".to_owned()];
        head.extend(self.outputs.iter().map(|name| format!("rms {}", plant.labelled(name))));
        head.extend(self.has_likelihood.then(|| "log-likelihood".to_owned()));
        head.extend(self.has_norm.then(|| "rms |e|".to_owned()));
        head.extend(self.states.iter().map(|name| format!("error of {}", plant.labelled(name))));
        head
    }

    /// The numbers of a row; of an observer without a run none is known.
    pub(crate) fn scores(&self, of: Option<&PredictionReport>) -> Vec<Score> {
        let less = |value: Option<f64>| Score { value, is_gain: false };
        let mut scores = vec![less(of.map(|of| of.relative))];
        let output = |name: &String| of?.outputs.iter().find(|one| one.output == *name).map(|one| one.rms);
        scores.extend(self.outputs.iter().map(output).map(less));
        let likelihood = || Score { value: of.and_then(|of| of.log_likelihood), is_gain: true };
        scores.extend(self.has_likelihood.then(likelihood));
        scores.extend(self.has_norm.then(|| less(of.and_then(|of| of.error))));
        let state = |name: &String| of?.states.iter().find(|one| one.state == *name).map(|one| one.rms);
        scores.extend(self.states.iter().map(state).map(less));
        scores
    }

    /// What the numbers are.
    pub(crate) fn words(&self) -> Vec<String> {
        let innovation = "Relative innovation: rms of y - h as predicted from the row before, over the deviation of the output from its mean, the geometric mean of all measurements; 1 is no better than the mean.";
        let likelihood = "Log-likelihood: the mean of that of a measurement, given those before it, of filters that compute its covariance.";
        let norm = "Norm |e| of the states that the log knows, in units of their scale.";
        let mut words = vec![innovation.to_owned()];
        words.extend(self.has_likelihood.then(|| likelihood.to_owned()));
        words.extend(self.has_norm.then(|| norm.to_owned()));
        words
    }
}
