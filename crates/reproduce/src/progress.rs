//! Progress on standard error: a bar on a terminal, one plain line per step elsewhere.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

use crate::terminal::PROGRESS;

/// The steps of one run.
pub(crate) struct Progress {
    /// Absent off the terminal.
    bar: Option<ProgressBar>,
    total: usize,
    done: usize,
    began: Instant,
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
        Self { bar, total, done: 0, began: Instant::now() }
    }

    /// A step begins.
    pub(crate) fn begin(&mut self, name: &str) {
        self.began = Instant::now();
        if let Some(bar) = &self.bar {
            bar.set_message(name.to_owned());
        }
    }

    /// A step has ended with this word.
    pub(crate) fn end(&mut self, name: &str, word: &str) {
        self.done += 1;
        if let Some(bar) = &self.bar {
            bar.inc(1);
        } else {
            let seconds = self.began.elapsed().as_secs_f64();
            eprintln!("[{:>3}/{}] {name:<40} {word:<14} {seconds:6.2} s", self.done, self.total);
        }
    }

    /// All steps have ended: nothing is left on the terminal.
    pub(crate) fn finish(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}
