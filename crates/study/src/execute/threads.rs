//! Threads, of which there may be none: WebAssembly in a page has only the one that calls.
//!
//! Loops over observers and runs are those of `rayon`, which then runs them on that thread.

use std::io;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, Builder, Thread};
use std::time::Duration;

use luenberger_clock::{set_stop_flag, stop_flag};

use crate::error::StudyError;

/// Designs recurse over expressions.
const STACK: usize = 16 << 20;

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

/// The work on so many threads, by default as many as there are processors; where there are none on the one that
/// calls.
///
/// They are started for this work and end with it: those that `rayon` starts for a whole process are missing in a
/// process that is forked later, and work for them would never be done. Their work ends where that of the thread that
/// calls is to end.
pub(super) fn on<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T, StudyError> + Send,
) -> Result<T, StudyError> {
    match threads {
        // Work within such work has its threads.
        None if rayon::current_thread_index().is_some() => work(),
        threads if exist() => {
            let flag = stop_flag();
            let builder = rayon::ThreadPoolBuilder::new().stack_size(STACK);
            let builder = builder.start_handler(move |_| set_stop_flag(flag.clone()));
            // No number is that of `rayon`, with what the environment says of it.
            let pool = builder.num_threads(threads.unwrap_or(0)).build();
            pool.map_err(|_| StudyError::Threads(threads.unwrap_or_else(available)))?.install(work)
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
