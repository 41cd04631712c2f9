//! Ctrl-C: the first one stops the work after the current item and keeps its results; the second stops at once.

use crate::exit::INTERRUPTED;
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};

static INTERRUPT: AtomicBool = AtomicBool::new(false);

/// Installs the handler; returns the flag that Ctrl-C sets.
pub(super) fn flag() -> &'static AtomicBool {
    let handled = ctrlc::set_handler(|| {
        if INTERRUPT.swap(true, Ordering::Relaxed) {
            std::process::exit(INTERRUPTED.into());
        }
        _ = writeln!(std::io::stderr(), "interrupted: finishing the current item; Ctrl-C again stops at once");
    });
    // Without a handler Ctrl-C ends the command as usual, and the results folder stays as it was.
    drop(handled);
    &INTERRUPT
}
