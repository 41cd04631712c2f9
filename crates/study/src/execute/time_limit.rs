//! The time limit of an execution.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Thread;
use std::time::{Duration, Instant};

use super::options::{Progress, RunOptions};
use crate::error::StudyError;

/// How often the time is compared with its limit.
const POLL: Duration = Duration::from_millis(20);

/// Ends the thread that watches the time when it is dropped, by a panic of the work too.
struct Ending<'a>(&'a AtomicBool, &'a Thread);

impl Drop for Ending<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
        self.1.unpark();
    }
}

/// The work with the time limit of its options.
pub(super) fn timed<T>(
    options: &RunOptions<'_>,
    work: impl FnOnce(&RunOptions<'_>) -> Result<T, StudyError>,
) -> Result<T, StudyError> {
    let (start, limit) = (Instant::now(), options.limits.seconds);
    let limited = Duration::try_from_secs_f64(limit).ok().and_then(|limit| start.checked_add(limit));
    let Some(end) = limited.into_iter().chain(options.until).min() else { return work(options) };
    let limit = if limited == Some(end) { limit } else { end.saturating_duration_since(start).as_secs_f64() };
    let (stop, done) = (AtomicBool::new(false), AtomicBool::new(false));
    let pass_on = || {
        if options.cancel.load(Ordering::Relaxed) {
            stop.store(true, Ordering::Relaxed);
        }
    };
    let progress = |progress: Progress<'_>| {
        (options.progress)(progress);
        pass_on();
    };
    std::thread::scope(|scope| {
        let watch = scope.spawn(|| {
            while !done.load(Ordering::Relaxed) {
                pass_on();
                if Instant::now() >= end {
                    stop.store(true, Ordering::Relaxed);
                }
                std::thread::park_timeout(POLL);
            }
        });
        let ending = Ending(&done, watch.thread());
        let inner = RunOptions {
            output: options.output.clone(),
            sweep: options.sweep.clone(),
            progress: &progress,
            cancel: &stop,
            until: Some(end),
            ..*options
        };
        let result = work(&inner);
        drop(ending);
        match result {
            Err(StudyError::Interrupted) if !options.cancel.load(Ordering::Relaxed) => {
                Err(StudyError::TimeLimit { limit })
            }
            result => result,
        }
    })
}
