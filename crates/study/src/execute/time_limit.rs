//! The time limit of an execution.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use luenberger_clock::Instant;

use super::options::{Progress, RunOptions};
use super::threads;
use crate::error::StudyError;

/// How often the time is compared with its limit.
const POLL: Duration = Duration::from_millis(20);

/// The work with the time limit of its options.
pub(super) fn timed<T>(
    options: &RunOptions<'_>,
    work: impl FnOnce(&RunOptions<'_>) -> Result<T, StudyError>,
) -> Result<T, StudyError> {
    let (start, limit) = (Instant::now(), options.limits.seconds);
    let limited = Duration::try_from_secs_f64(limit).ok().and_then(|limit| start.checked_add(limit));
    let Some(end) = limited.into_iter().chain(options.until).min() else { return work(options) };
    let limit = if limited == Some(end) { limit } else { end.saturating_duration_since(start).as_secs_f64() };
    let stop = AtomicBool::new(false);
    let look = || {
        if options.cancel.load(Ordering::Relaxed) || Instant::now() >= end {
            stop.store(true, Ordering::Relaxed);
        }
    };
    let progress = |progress: Progress<'_>| {
        (options.progress)(progress);
        look();
    };
    threads::beside(POLL, &look, || {
        let inner = RunOptions {
            output: options.output.clone(),
            sweep: options.sweep.clone(),
            progress: &progress,
            cancel: &stop,
            until: Some(end),
            ..*options
        };
        match work(&inner) {
            Err(StudyError::Interrupted) if !options.cancel.load(Ordering::Relaxed) => {
                Err(StudyError::TimeLimit { limit })
            }
            result => result,
        }
    })
}
