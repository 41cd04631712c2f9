//! The state of a moving-horizon estimator as one column of numbers.
//!
//! `xhat, P (by columns), count, prior mean, prior covariance (by columns)`, and then for each stage of the window, the
//! oldest first, `x, u, y, measured (1 or 0 for each output), t, duration`. Where predictions without a measurement
//! between them are joined, then whether the way to the next stage is a joined one, the state from which it starts,
//! where it leads, and its A and Q by columns.

use nalgebra::{RealField, convert};

/// The lengths of states, inputs and outputs, and the most stages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    pub(super) n: usize,
    pub(super) m: usize,
    pub(super) p: usize,
    pub(super) stages: usize,
    /// Whether predictions without a measurement between them are joined.
    pub(super) joins: bool,
}

/// Where a stage has its numbers.
#[derive(Clone, Copy)]
pub(super) enum Part {
    State,
    Input,
    Output,
    Measured,
    Time,
    Duration,
    /// 1 where the way to the next stage is joined of several predictions.
    IsJoined,
    /// The state from which a joined way starts, and where it leads.
    From,
    To,
    /// A and Q of a joined way.
    Forward,
    Noise,
}

impl Layout {
    const fn head(self) -> usize {
        2 * (self.n + self.n * self.n) + 1
    }

    const fn stage(self) -> usize {
        let joined = if self.joins { 1 + 2 * (self.n + self.n * self.n) } else { 0 };
        self.n + self.m + 2 * self.p + 2 + joined
    }

    /// All numbers.
    pub(super) const fn len(self) -> usize {
        self.head() + self.stages * self.stage()
    }

    pub(super) fn estimate(self) -> core::ops::Range<usize> {
        0..self.n
    }

    pub(super) fn covariance(self) -> core::ops::Range<usize> {
        self.n..self.n + self.n * self.n
    }

    pub(super) fn prior_mean(self) -> core::ops::Range<usize> {
        let start = self.n + self.n * self.n + 1;
        start..start + self.n
    }

    pub(super) fn prior_covariance(self) -> core::ops::Range<usize> {
        let start = 2 * self.n + self.n * self.n + 1;
        start..start + self.n * self.n
    }

    /// Stages in use.
    pub(super) fn count<T: RealField + Copy>(self, state: &[T]) -> usize {
        let stored = state.get(self.n + self.n * self.n).copied().unwrap_or_else(T::zero);
        (1..self.stages).find(|k| stored < convert::<f64, T>(*k as f64 + 0.5)).unwrap_or(self.stages)
    }

    pub(super) fn set_count<T: RealField + Copy>(self, state: &mut [T], count: usize) {
        if let Some(stored) = state.get_mut(self.n + self.n * self.n) {
            *stored = convert(count as f64);
        }
    }

    /// Where a stage has this part.
    pub(super) fn part(self, stage: usize, part: Part) -> core::ops::Range<usize> {
        let Self { n, m, p, .. } = self;
        let (offset, length) = match part {
            Part::State => (0, n),
            Part::Input => (n, m),
            Part::Output => (n + m, p),
            Part::Measured => (n + m + p, p),
            Part::Time => (n + m + 2 * p, 1),
            Part::Duration => (n + m + 2 * p + 1, 1),
            Part::IsJoined => (n + m + 2 * p + 2, 1),
            Part::From => (n + m + 2 * p + 3, n),
            Part::To => (2 * n + m + 2 * p + 3, n),
            Part::Forward => (3 * n + m + 2 * p + 3, n * n),
            Part::Noise => (3 * n + n * n + m + 2 * p + 3, n * n),
        };
        let start = self.head() + stage * self.stage() + offset;
        start..start + length
    }

    /// Forgets the oldest stage.
    pub(super) fn shift<T: Copy>(self, state: &mut [T]) {
        let (head, stage) = (self.head(), self.stage());
        if state.len() >= head + stage {
            state.copy_within(head + stage.., head);
        }
    }
}

/// Length of the estimator's state for these numbers of states, inputs and outputs and this window length:
/// `2 n (n + 1) + 1 + window (n + m + 2 p + 2)`.
pub const fn state_length(states: usize, inputs: usize, outputs: usize, window: usize) -> usize {
    Layout { n: states, m: inputs, p: outputs, stages: window, joins: false }.len()
}
