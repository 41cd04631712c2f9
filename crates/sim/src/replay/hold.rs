//! What an observer in continuous time sees of the outputs between the rows of a log.
//!
//! A measurement reaches from the row that measured it over its own median period, with half a period of the log as
//! tolerance, and no further than to the next row that measures it. After that, in a gap or from a missing value on,
//! there is no measurement: the observer predicts, y := h(xhat).
//!
//! Within its reach the measurement moves with the model (`moving`). For an observer of some states, and on
//! request, it is held. Straight lines, on request, join two successive measurements that are not further apart than
//! the reach.

use super::{BetweenRows, Recording};
use crate::erased::{AnyObserver, AnyPlant};
use crate::moving::output_rate;

/// What an output is taken to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Source {
    /// Measured as this value at the last row: it moves with the model, or is held.
    Measured(f64),
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
            line: recording.outputs_between() == BetweenRows::Linear,
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
            (Some((_, value)), _) => Source::Measured(value),
            (None, _) => Source::Predicted,
        }
    }
}

impl Source {
    /// The output at `t`, held; none if it was not measured.
    pub(super) fn at(self, t: f64) -> Option<f64> {
        match self {
            Self::Measured(value) => Some(value),
            Self::Line((start, from), (end, to)) => {
                Some(from + ((t - start) / (end - start)).clamp(0.0, 1.0) * (to - from))
            }
            Self::Predicted => None,
        }
    }
}

/// What an observer in continuous time sees between the rows k and k + 1, for its state with w behind it.
pub(super) struct Between<'r> {
    /// The plant, of an observer of all states, which predicts outputs.
    pub(super) plant: Option<&'r dyn AnyPlant>,
    pub(super) observer: &'r dyn AnyObserver,
    pub(super) recording: &'r Recording,
    /// The row k.
    pub(super) row: usize,
    pub(super) sources: Vec<Source>,
    /// The outputs at the row k.
    pub(super) last: &'r [f64],
    /// Length of the state of the observer.
    pub(super) own: usize,
    /// Whether measurements move with the model.
    pub(super) is_moving: bool,
}

impl Between<'_> {
    /// Input and outputs at `t`.
    pub(super) fn known(&self, t: f64, state: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (own, moving) = state.split_at(self.own);
        let (mut u, mut y) = (vec![0.0; self.recording.inputs().values().ncols()], self.last.to_vec());
        self.recording.inputs().on(self.row, t, &mut u);
        for (j, (y, source)) in y.iter_mut().zip(&self.sources).enumerate() {
            *y = match source {
                Source::Measured(_) if self.is_moving => moving[j],
                source => source.at(t).unwrap_or(*y),
            };
        }
        if let Some(plant) = self.plant
            && self.sources.contains(&Source::Predicted)
        {
            let mut h = vec![0.0; y.len()];
            plant.output(t, &self.estimate(t, own, &u, &y), &u, &mut h);
            for ((y, source), h) in y.iter_mut().zip(&self.sources).zip(&h) {
                *y = if *source == Source::Predicted { *h } else { *y };
            }
        }
        (u, y)
    }

    fn estimate(&self, t: f64, own: &[f64], u: &[f64], y: &[f64]) -> Vec<f64> {
        let mut estimate = vec![0.0; self.observer.dimensions().estimate];
        self.observer.estimate(t, own, u, y, &mut estimate);
        estimate
    }

    /// The derivative of the state of the observer, and of w.
    pub(super) fn derivative(&self, t: f64, state: &[f64], slope: &mut [f64]) {
        let (u, y) = self.known(t, state);
        let (own, moving) = slope.split_at_mut(self.own);
        self.observer.derivative(t, &state[..self.own], &u, &y, own);
        moving.fill(0.0);
        if let Some(plant) = self.plant.filter(|_| self.is_moving) {
            let xhat = self.estimate(t, &state[..self.own], &u, &y);
            let times = self.recording.times();
            let period = times[self.row + 1] - times[self.row];
            let moves = |j: usize| matches!(self.sources[j], Source::Measured(_));
            output_rate(plant, (t, &xhat, &u), period, moves, moving);
        }
    }
}
