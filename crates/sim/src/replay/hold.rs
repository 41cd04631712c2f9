//! What an observer in continuous time sees of the outputs between the rows of a log.
//!
//! An output is held from the row that measured it for its own median period, with half a period of the log as
//! tolerance, and no longer than until the next row that measures it. After that, in a gap or from a missing value on,
//! there is no measurement: the observer predicts, y := h(xhat). Straight lines, where asked for, join two successive
//! measurements that are not further apart than this.

use super::Recording;
use crate::samples::SampleInterpolation;

/// What an output is taken to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Source {
    /// Held at this value.
    Held(f64),
    /// On the straight line through two points (t, y).
    Line((f64, f64), (f64, f64)),
    /// Not measured: h(xhat).
    Predicted,
}

/// How long a measurement of an output holds, and how far apart two are that a line joins.
pub(super) fn reach(recording: &Recording, output: usize) -> f64 {
    recording.output_period(output) + recording.median_period() / 2.0
}

/// The rule for one output, advanced from row to row.
pub(super) struct Hold {
    output: usize,
    /// How long a measurement holds.
    reach: f64,
    /// How old a measurement may be at the start of a row that does not repeat it.
    stale: f64,
    line: bool,
    /// The last row that measured it, with its value.
    last: Option<(f64, f64)>,
    /// The next measurement after the last one, for lines.
    next: Option<(f64, f64)>,
}

impl Hold {
    pub(super) fn new(recording: &Recording, output: usize) -> Self {
        let (own, rows) = (recording.output_period(output), recording.median_period());
        Self {
            output,
            reach: reach(recording, output),
            stale: own - rows / 2.0,
            line: recording.outputs().between() == SampleInterpolation::Linear,
            last: None,
            next: None,
        }
    }

    /// Arrives at row k.
    pub(super) fn arrive(&mut self, recording: &Recording, k: usize) {
        let (times, outputs) = (recording.times(), recording.outputs());
        let Some(value) = outputs.value(k, self.output) else { return };
        self.last = Some((times[k], value));
        if self.line {
            let point = |k: usize| Some((times[k], outputs.value(k, self.output)?));
            self.next = (k + 1..times.len()).find_map(point);
        }
    }

    /// Until when the output is measured in the interval from `start` to `end`, which begins at a row; `start` if it is
    /// not.
    pub(super) fn until(&self, start: f64, end: f64) -> f64 {
        match (self.last, self.next) {
            (Some((from, _)), Some((to, _))) if to - from <= self.reach && to >= end => end,
            (Some((from, _)), _) if from >= start || start - from < self.stale => {
                let until = from + self.reach;
                // Not for the sake of a rounding error.
                if until >= end - 1e-6 * self.reach { end } else { until.max(start) }
            }
            _ => start,
        }
    }

    /// What it is in an interval that ends at `end`, for `until` of [`until`](Self::until).
    pub(super) fn source(&self, end: f64, until: f64) -> Source {
        match (self.last, self.next) {
            _ if until < end => Source::Predicted,
            (Some(from), Some(to)) if to.0 - from.0 <= self.reach => Source::Line(from, to),
            (Some((_, value)), _) => Source::Held(value),
            (None, _) => Source::Predicted,
        }
    }
}

impl Source {
    /// The output at `t`; none if it was not measured.
    pub(super) fn at(self, t: f64) -> Option<f64> {
        match self {
            Self::Held(value) => Some(value),
            Self::Line((start, from), (end, to)) => {
                Some(from + ((t - start) / (end - start)).clamp(0.0, 1.0) * (to - from))
            }
            Self::Predicted => None,
        }
    }
}
