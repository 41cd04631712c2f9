//! Samples at varying periods, of which some are missed.
//!
//! Each period is uniform between two bounds, the first from the start of the run. A sample is missed with probability
//! one half, unless as many as are allowed in a row were missed before it. The instants depend on the seed alone,
//! and in an ensemble on the member.

use luenberger_random::{Draws, Purpose, Stream};

use crate::error::{SimError, check_positive};

/// Between which bounds sampling periods vary, and how many samples in a row may be missed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleTimes {
    /// The shortest period.
    pub shortest: f64,
    /// The longest period.
    pub longest: f64,
    /// The largest number of samples missed in a row.
    pub misses: usize,
    /// The seed.
    pub seed: u64,
}

/// One sample of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleTime {
    /// When it is due.
    pub time: f64,
    /// Whether it arrives.
    pub arrives: bool,
    /// The time since the last sample that arrived, or since the start.
    pub elapsed: f64,
    /// The number of outputs that were not measured at it.
    pub absent: usize,
}

impl SampleTimes {
    pub(crate) fn check(&self) -> Result<(), SimError> {
        check_positive("the shortest sampling period of an observer", self.shortest)?;
        check_positive("the longest sampling period of an observer", self.longest)
    }
}

/// The samples of a run, one after the other.
pub(crate) struct SampleClock {
    times: SampleTimes,
    draws: Draws,
    /// When the next sample is due.
    pub(crate) next: f64,
    /// How many were missed since the last one that arrived.
    missed: usize,
    /// When the last one arrived.
    pub(crate) last: f64,
}

impl SampleClock {
    pub(crate) fn new(times: SampleTimes, member: u64, start: f64) -> Self {
        let draws = Stream::new(times.seed, Purpose::SampleTimes, 0).member(member).draws(0);
        let mut clock = Self { times, draws, next: start, missed: 0, last: start };
        clock.advance();
        clock
    }

    fn advance(&mut self) {
        let SampleTimes { shortest, longest, .. } = self.times;
        self.next += shortest + (longest - shortest) * self.draws.uniform();
    }

    /// Whether the sample that is due arrives; the next one is due then.
    pub(crate) fn arrives(&mut self) -> bool {
        let is_lost = self.draws.uniform() < 0.5 && self.missed < self.times.misses;
        self.missed = if is_lost { self.missed + 1 } else { 0 };
        self.advance();
        !is_lost
    }
}
