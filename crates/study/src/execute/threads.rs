//! Threads, of which there may be none: WebAssembly in a page has only the one that calls.
//!
//! Loops over observers and runs are those of `rayon`, which then runs them on that thread.

use std::io;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, Builder, Thread};
use std::time::Duration;

use crate::error::StudyError;

/// Whether a thread can be started at all. One that cannot be for the moment, for lack of memory, does not matter.
fn exist() -> bool {
    static EXIST: OnceLock<bool> = OnceLock::new();
    let is_unsupported = |error: io::Error| error.kind() == io::ErrorKind::Unsupported;
    *EXIST.get_or_init(|| !Builder::new().spawn(|| ()).is_err_and(is_unsupported))
}

/// The number of threads that the machine has for this process.
pub(super) fn available() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

/// The work on so many threads, by default those that `rayon` has started; where there are none on the one that calls.
pub(super) fn on<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T, StudyError> + Send,
) -> Result<T, StudyError> {
    match threads {
        Some(threads) if exist() => {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.map_err(|_| StudyError::Threads(threads))?.install(work)
        }
        _ => work(),
    }
}

/// The work, with a thread beside it that calls `look` from time to time; without it where no thread can be started.
pub(super) fn beside<T>(every: Duration, look: &(dyn Fn() + Sync), work: impl FnOnce() -> T) -> T {
    let done = AtomicBool::new(false);
    thread::scope(|scope| {
        let watch = Builder::new().spawn_scoped(scope, || {
            while !done.load(Ordering::Relaxed) {
                look();
                thread::park_timeout(every);
            }
        });
        let _ending = watch.as_ref().ok().map(|watch| Ending(&done, watch.thread()));
        work()
    })
}

/// Ends that thread when it is dropped, by a panic of the work too.
struct Ending<'a>(&'a AtomicBool, &'a Thread);

impl Drop for Ending<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
        self.1.unpark();
    }
}

/// Waits for another process; where there are none, not at all.
pub(super) fn pause(duration: Duration) {
    if exist() {
        thread::sleep(duration);
    }
}
