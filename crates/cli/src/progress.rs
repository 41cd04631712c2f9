//! Progress indicators on standard error, on a terminal only.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use luenberger_proof::wording::significant;

use crate::output::{self, Volume, volume};
use std::fmt::Write;
use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Whether progress is drawn: on a terminal, unless lines are asked for, or nothing.
fn is_shown() -> bool {
    std::io::stderr().is_terminal() && volume() == Volume::Normal
}

/// A spinner that is erased when dropped.
pub(crate) struct Spinner {
    /// `None` if standard error is not a terminal.
    bar: Option<ProgressBar>,
}

impl Spinner {
    pub(crate) fn new(message: &str) -> Self {
        let bar = is_shown().then(|| {
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
            bar.set_message(message.to_owned());
            bar.enable_steady_tick(Duration::from_millis(100));
            bar
        });
        Self { bar }
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// A progress bar with a known number of items, updated from any thread and erased when dropped. It is not drawn before
/// the first report, so that a line printed before is not on its line.
pub(crate) struct Bar {
    /// `None` if standard error is not a terminal.
    bar: Option<ProgressBar>,
    /// The stage that is shown.
    stage: Mutex<String>,
}

const TEMPLATE: &str = "{bar:32} {pos:>3}/{len} {msg}, {per_sec}, {eta} left";

impl Bar {
    pub(crate) fn new() -> Self {
        let bar = is_shown().then(|| {
            let bar = ProgressBar::with_draw_target(Some(0), ProgressDrawTarget::hidden());
            // The template is constant and covered by a test; an invalid one would only affect the appearance.
            if let Ok(style) = ProgressStyle::with_template(TEMPLATE) {
                bar.set_style(style.with_key("per_sec", |state: &ProgressState, text: &mut dyn Write| {
                    _ = write!(text, "{}/s", significant(state.per_sec(), 3));
                }));
            }
            bar
        });
        Self { bar, stage: Mutex::new(String::new()) }
    }

    /// Reports that `done` of `total` items of a stage are finished.
    pub(crate) fn tell(&self, stage: &str, item: &str, done: usize, total: usize) {
        if volume() == Volume::Verbose {
            output::say(format!("{stage} {item}: {done} of {total}").trim_start());
        }
        if let Some(bar) = &self.bar {
            // Rate and remaining time are those of the stage.
            let mut shown = self.stage.lock().unwrap_or_else(PoisonError::into_inner);
            let is_first = shown.is_empty();
            if *shown != stage {
                stage.clone_into(&mut shown);
                bar.reset();
            }
            bar.set_length(total as u64);
            bar.set_position(done as u64);
            bar.set_message(format!("{stage} {item}"));
            if is_first {
                bar.set_draw_target(ProgressDrawTarget::stderr());
                bar.enable_steady_tick(Duration::from_millis(100));
            }
        }
    }
}

impl Bar {
    /// Erases the bar.
    pub(crate) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
