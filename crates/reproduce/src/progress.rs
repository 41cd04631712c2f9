//! Progress on standard error: a bar on a terminal, one plain line per step elsewhere.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use crate::terminal::PROGRESS;

/// The steps of one run, which several threads take.
pub(crate) struct Progress {
    /// Absent off the terminal.
    bar: Option<ProgressBar>,
    lines: Mutex<Lines>,
}

/// Lines in the order of the steps: one that ends before an earlier one waits for it.
struct Lines {
    ended: Vec<Option<String>>,
    written: usize,
}

impl Progress {
    pub(crate) fn new(total: usize) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::with_draw_target(Some(total as u64), ProgressDrawTarget::stderr());
            // The template is constant, and a test reads it; a bad one would only cost the looks.
            if let Ok(style) = ProgressStyle::with_template(PROGRESS) {
                bar.set_style(style);
            }
            bar.enable_steady_tick(Duration::from_millis(100));
            bar
        });
        Self { bar, lines: Mutex::new(Lines { ended: vec![None; total], written: 0 }) }
    }

    /// A step begins.
    pub(crate) fn begin(&self, name: &str) {
        if let Some(bar) = &self.bar {
            bar.set_message(name.to_owned());
        }
    }

    /// Step `number`, counted from 0, has ended with this word after this time.
    pub(crate) fn end(&self, number: usize, name: &str, word: &str, after: Duration) {
        if let Some(bar) = &self.bar {
            bar.inc(1);
            return;
        }
        let Lines { ended, written } = &mut *self.lines.lock().unwrap_or_else(PoisonError::into_inner);
        ended[number] = Some(format!("{name:<40} {word:<14} {:6.2} s", after.as_secs_f64()));
        while let Some(line) = ended.get(*written).and_then(Option::as_ref) {
            *written += 1;
            eprintln!("[{written:>3}/{}] {line}", ended.len());
        }
    }

    /// All steps have ended: nothing is left on the terminal.
    pub(crate) fn finish(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}
