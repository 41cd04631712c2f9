//! Long computations: without the interpreter's lock, with progress, and ended by Ctrl-C.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::thread;
use std::time::{Duration, Instant};

use luenberger_clock::stoppable;
use luenberger_study::Progress;
use pyo3::prelude::*;

use crate::error;

/// Period at which Ctrl-C is checked.
const TICK: Duration = Duration::from_millis(50);

/// Time that a cancelled computation has to end. One that takes longer ends in the background.
const STOP_TIMEOUT: Duration = Duration::from_secs(5);

/// Designs recurse over expressions.
const STACK: usize = 16 << 20;

enum Message<T> {
    Progress { stage: String, item: String, done: usize, total: usize },
    Done(T),
}

/// What a computation gets: a flag that ends it, which integrations of its thread see as well, and where it tells its
/// progress.
pub(crate) struct Context<'a> {
    pub(crate) cancel: &'a AtomicBool,
    pub(crate) progress: &'a (dyn Fn(Progress<'_>) + Sync),
}

/// The result of `work`, which runs in a thread of its own. `callback(stage, item, done, total)` is called in this
/// thread; what it raises ends the computation and comes through, as Ctrl-C does.
pub(crate) fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    callback: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Context<'_>) -> T + Send + 'static,
) -> PyResult<T> {
    let cancel = Arc::new(AtomicBool::new(false));
    let (sender, receiver) = mpsc::channel();
    let receiver = Mutex::new(receiver);
    let inner = Arc::clone(&cancel);
    let run = move || {
        let listener = Mutex::new(sender.clone());
        let progress = |progress: Progress<'_>| {
            let Progress { stage, item, done, total } = progress;
            let message = Message::Progress { stage: stage.to_owned(), item: item.to_owned(), done, total };
            // The receiver no longer exists once the time limit is over.
            _ = listener.lock().unwrap_or_else(PoisonError::into_inner).send(message);
        };
        let result = stoppable(Some(&inner), || work(&Context { cancel: &inner, progress: &progress }));
        _ = sender.send(Message::Done(result));
    };
    let spawned = thread::Builder::new().name("luenberger".to_owned()).stack_size(STACK).spawn(run);
    let worker = spawned.map_err(|why| error::plain(py, "StudyError", format!("no thread could be started: {why}")))?;
    let mut ended: Option<(PyErr, Instant)> = None;
    loop {
        let next = py.detach(|| receiver.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(TICK));
        let raised = match next {
            Ok(Message::Done(result)) => return ended.map_or(Ok(result), |(error, _)| Err(error)),
            Ok(Message::Progress { stage, item, done, total }) => match callback {
                Some(callback) if ended.is_none() => callback.call1((stage, item, done, total)).err(),
                _ => None,
            },
            Err(mpsc::RecvTimeoutError::Timeout) => None,
            Err(mpsc::RecvTimeoutError::Disconnected) => {
                return match py.detach(|| worker.join()) {
                    Err(panic) => resume_unwind(panic),
                    Ok(()) => Err(error::plain(py, "StudyError", "the computation left no result")),
                };
            }
        };
        match &ended {
            None => {
                if let Some(error) = raised.or_else(|| py.check_signals().err()) {
                    cancel.store(true, Ordering::Relaxed);
                    ended = Some((error, Instant::now()));
                }
            }
            Some((error, since)) if since.elapsed() > STOP_TIMEOUT => return Err(error.clone_ref(py)),
            Some(_) => {}
        }
    }
}
