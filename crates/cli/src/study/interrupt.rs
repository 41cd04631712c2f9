//! Ctrl-C: once ends the work after what is being done, and leaves what is finished on disk; twice ends it at once.

use crate::exit::INTERRUPTED;
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};

static INTERRUPT: AtomicBool = AtomicBool::new(false);

/// The flag that Ctrl-C sets from now on.
pub(super) fn flag() -> &'static AtomicBool {
    let handled = ctrlc::set_handler(|| {
        if INTERRUPT.swap(true, Ordering::Relaxed) {
            std::process::exit(INTERRUPTED.into());
        }
        _ = writeln!(std::io::stderr(), "interrupted: waiting for what is being done; Ctrl-C again to stop at once");
    });
    // Without a handler Ctrl-C ends the command as it ends others, and files are written whole or not at all.
    drop(handled);
    &INTERRUPT
}
