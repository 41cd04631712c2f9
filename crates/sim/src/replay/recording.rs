//! Recorded inputs and outputs at the times of a log.

use std::borrow::Cow;

use luenberger_plants::Dimensions;
use nalgebra::DMatrix;

use crate::error::SimError;
use crate::samples::{SampleInterpolation, Samples};

/// Without a row for longer than this many median periods, a log has a gap.
const GAP: f64 = 5.0;

/// Inputs and outputs that were recorded at common times.
///
/// A value that was not measured is missing ([`Recording::with_missing`]): it corrects no estimate.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    inputs: Samples,
    outputs: Samples,
    between: BetweenRows,
}

/// What an observer in continuous time sees of an output between the rows that measured it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BetweenRows {
    /// The measurement, moved by the model along the estimate: causal, with an error of the order of the square of the
    /// period. An observer of some states sees the measurement held.
    #[default]
    Predicted,
    /// The measurement, held: causal, late by half a period on average.
    Held,
    /// Straight lines from row to row: not causal. They are for observers of a fixed period, too.
    Linear,
}

impl From<Recording> for Cow<'_, Recording> {
    fn from(recording: Recording) -> Self {
        Self::Owned(recording)
    }
}

impl<'a> From<&'a Recording> for Cow<'a, Recording> {
    fn from(recording: &'a Recording) -> Self {
        Self::Borrowed(recording)
    }
}

impl Recording {
    /// The recording of the inputs `u` (N x m) and the outputs `y` (N x p) at N increasing times.
    ///
    /// Between the rows inputs are held: an input is what a digital controller has sent, and it was held. An output is
    /// known at its rows. What an observer sees in between depends on its kind, and never on a later row: the
    /// [module](super) says what, and [`between`](Self::between) selects it.
    ///
    /// # Errors
    /// As [`Samples::new`].
    pub fn new(t: Vec<f64>, u: DMatrix<f64>, y: DMatrix<f64>) -> Result<Self, SimError> {
        Ok(Self {
            inputs: Samples::new(t.clone(), u, SampleInterpolation::ZeroOrderHold)?,
            outputs: Samples::new(t, y, SampleInterpolation::ZeroOrderHold)?,
            between: BetweenRows::Predicted,
        })
    }

    /// As [`new`](Self::new), with `None` for what was not measured: sensors of different rates, dropouts. A missing
    /// input is the last one that was sent.
    ///
    /// # Errors
    /// As [`Samples::new`]; [`SimError::NoInput`] for an input that is missing in the first row.
    pub fn with_missing(t: Vec<f64>, u: &DMatrix<Option<f64>>, y: &DMatrix<Option<f64>>) -> Result<Self, SimError> {
        let inputs = Samples::with_missing(t.clone(), u, SampleInterpolation::ZeroOrderHold)?;
        if let Some(input) = (0..u.ncols()).find(|&j| inputs.value(0, j).is_none()) {
            return Err(SimError::NoInput { input, time: inputs.times()[0] });
        }
        let outputs = Samples::with_missing(t, y, SampleInterpolation::ZeroOrderHold)?;
        Ok(Self { inputs, outputs, between: BetweenRows::Predicted })
    }

    /// The same with other rules for what is between the rows. Outputs on straight lines are for observers that run in
    /// continuous time or at their own period; a line joins two successive measurements, and none crosses a gap or a
    /// missing value.
    #[must_use]
    pub fn between(self, inputs: SampleInterpolation, outputs: BetweenRows) -> Self {
        Self { inputs: self.inputs.with(inputs), between: outputs, ..self }
    }

    /// What observers in continuous time see of the outputs between the rows.
    pub fn outputs_between(&self) -> BetweenRows {
        self.between
    }

    /// The times.
    pub fn times(&self) -> &[f64] {
        self.inputs.times()
    }

    /// The inputs.
    pub fn inputs(&self) -> &Samples {
        &self.inputs
    }

    /// The outputs.
    pub fn outputs(&self) -> &Samples {
        &self.outputs
    }

    /// The median time from one row to the next.
    pub fn median_period(&self) -> f64 {
        median(self.times()).unwrap_or(f64::INFINITY)
    }

    /// The median time from one measurement of an output to the next: a multiple of
    /// [`median_period`](Self::median_period) for a slow sensor.
    pub fn output_period(&self, output: usize) -> f64 {
        median(&self.measured_times(output)).unwrap_or_else(|| self.median_period())
    }

    /// The gaps: first and last time of each interval without a row that is longer than five median periods.
    pub fn gaps(&self) -> Vec<(f64, f64)> {
        gaps(self.times(), self.median_period())
    }

    /// The gaps in the measurements of one output, by its own median period.
    pub fn output_gaps(&self, output: usize) -> Vec<(f64, f64)> {
        gaps(&self.measured_times(output), self.output_period(output))
    }

    fn measured_times(&self, output: usize) -> Vec<f64> {
        let measured = |(k, t): (usize, &f64)| self.outputs.value(k, output).map(|_| *t);
        self.times().iter().enumerate().filter_map(measured).collect()
    }

    /// Checks that it is one of a plant of this size.
    pub(super) fn check(&self, size: Dimensions) -> Result<(), SimError> {
        for (what, expected, samples) in [
            ("a recording, in inputs,", size.inputs, &self.inputs),
            ("a recording, in outputs,", size.outputs, &self.outputs),
        ] {
            let found = samples.values().ncols();
            if found != expected {
                return Err(SimError::Length { what: what.to_owned(), expected, found });
            }
        }
        Ok(())
    }
}

/// The median difference of increasing times; none for fewer than two.
fn median(t: &[f64]) -> Option<f64> {
    let mut periods: Vec<f64> = t.windows(2).map(|pair| pair[1] - pair[0]).collect();
    periods.sort_by(f64::total_cmp);
    periods.get(periods.len() / 2).copied()
}

fn gaps(t: &[f64], period: f64) -> Vec<(f64, f64)> {
    t.windows(2).filter(|pair| pair[1] - pair[0] > GAP * period).map(|pair| (pair[0], pair[1])).collect()
}
