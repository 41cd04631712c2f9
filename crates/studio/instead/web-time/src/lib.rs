//! The clock of `luenberger-clock` under the name that dependencies know.

pub use luenberger_clock::Instant;
pub use std::time::{Duration, SystemTime, SystemTimeError, TryFromFloatSecsError, UNIX_EPOCH};
