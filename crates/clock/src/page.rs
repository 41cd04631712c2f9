//! The clock of a program that has none of its own: a function that it registers.

use std::ops::{Add, Sub};
use std::sync::OnceLock;
use std::time::Duration;

/// The registered function.
static CLOCK: OnceLock<fn() -> f64> = OnceLock::new();

/// Registers the clock: milliseconds since any fixed instant, never decreasing. Later calls change nothing.
///
/// Where the standard library has a clock, that one is read all the same.
pub fn set_clock(now: fn() -> f64) {
    _ = CLOCK.set(now);
}

/// An instant of the registered clock, with the operations of [`std::time::Instant`] that time limits need.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Instant(Duration);

impl Instant {
    /// The present; without a clock always the same instant.
    pub fn now() -> Self {
        let milliseconds = CLOCK.get().map_or(0.0, |now| now());
        Self(Duration::try_from_secs_f64(1e-3 * milliseconds).unwrap_or_default())
    }

    /// The instant a duration later; none if it is too far away to be written.
    pub fn checked_add(&self, duration: Duration) -> Option<Self> {
        self.0.checked_add(duration).map(Self)
    }

    /// The time since an earlier instant; zero if it is later.
    pub fn saturating_duration_since(&self, earlier: Self) -> Duration {
        self.0.saturating_sub(earlier.0)
    }

    /// The same, as [`std::time::Instant::duration_since`].
    pub fn duration_since(&self, earlier: Self) -> Duration {
        self.saturating_duration_since(earlier)
    }

    /// The time since this instant.
    pub fn elapsed(&self) -> Duration {
        Self::now().saturating_duration_since(*self)
    }
}

impl Add<Duration> for Instant {
    type Output = Self;

    /// The instant a duration later, or the last one that can be written.
    fn add(self, duration: Duration) -> Self {
        Self(self.0.saturating_add(duration))
    }
}

impl Sub for Instant {
    type Output = Duration;

    fn sub(self, earlier: Self) -> Duration {
        self.saturating_duration_since(earlier)
    }
}
