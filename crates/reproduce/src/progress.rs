//! Progress on standard error: a bar on a terminal, one plain line per step elsewhere.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

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
        Self::on(total, std::io::stderr().is_terminal())
    }

    fn on(total: usize, terminal: bool) -> Self {
        let bar = terminal.then(|| {
            let bar = ProgressBar::with_draw_target(Some(total as u64), ProgressDrawTarget::stderr());
            // The template is constant, and a test reads it; a bad one would only cost the looks.
            if let Ok(style) = ProgressStyle::with_template(TEMPLATE) {
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
        match &self.bar {
            Some(bar) => bar.inc(1),
            None => eprintln!("{}", self.line(name, word)),
        }
    }

    fn line(&self, name: &str, word: &str) -> String {
        let seconds = self.began.elapsed().as_secs_f64();
        format!("[{:>3}/{}] {name:<40} {word:<14} {seconds:6.2} s", self.done, self.total)
    }

    /// All steps have ended: nothing is left on the terminal.
    pub(crate) fn finish(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}

const TEMPLATE: &str = "{bar:32.cyan/dim} {pos:>3}/{len} {msg}";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_no_bar_off_the_terminal() {
        let mut progress = Progress::on(12, false);
        progress.begin("cubic.ex1.gain");
        assert!(progress.bar.is_none());
        progress.end("cubic.ex1.gain", "reproduced");
        let line = progress.line("cubic.ex1.gain", "reproduced");
        assert!(line.starts_with("[  1/12] cubic.ex1.gain ") && line.contains("reproduced"), "{line}");
        assert!(!line.contains('\u{1b}') && !line.contains('\r'), "{line:?}");
    }

    #[test]
    fn the_template_is_well_formed() {
        assert!(ProgressStyle::with_template(TEMPLATE).is_ok());
    }
}
