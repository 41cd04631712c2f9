//! Work of a thread that another thread can end.
//!
//! A time limit ends a run at an instant; a user who presses a key ends it now. Where a limit is checked, the flag of
//! the thread is checked as well.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

thread_local! {
    static FLAG: RefCell<Option<Arc<AtomicBool>>> = const { RefCell::new(None) };
}

/// The work, which `flag` ends wherever this thread asks [`is_stopped`].
///
/// ```
/// use luenberger_clock::{is_stopped, stoppable};
/// use std::sync::atomic::{AtomicBool, Ordering};
/// let flag = std::sync::Arc::default();
/// assert!(!stoppable(Some(&flag), is_stopped));
/// flag.store(true, Ordering::Relaxed);
/// assert!(stoppable(Some(&flag), is_stopped) && !is_stopped());
/// ```
pub fn stoppable<T>(flag: Option<&Arc<AtomicBool>>, work: impl FnOnce() -> T) -> T {
    let before = FLAG.replace(flag.cloned());
    let _before = Before(before);
    work()
}

/// Puts the flag back, after a panic of the work too.
struct Before(Option<Arc<AtomicBool>>);

impl Drop for Before {
    fn drop(&mut self) {
        FLAG.set(self.0.take());
    }
}

/// The flag of this thread, for threads that it starts.
pub fn stop_flag() -> Option<Arc<AtomicBool>> {
    FLAG.with_borrow(Clone::clone)
}

/// Gives a thread that has begun the flag of the one that started it.
pub fn set_stop_flag(flag: Option<Arc<AtomicBool>>) {
    FLAG.set(flag);
}

/// Whether the work of this thread is to end.
pub fn is_stopped() -> bool {
    FLAG.with_borrow(|flag| flag.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed)))
}
