//! The steps of a study: `run`, `observe`, `design`, `certify`, `simulate`, `compare`, and `sweep` in one process.

use super::file::{folder_of, notes, read, renamed};
use super::{cost, interrupt, text_report};
use crate::answer::Answer;
use crate::arguments::StudyInput;
use crate::failure::Failure;
use crate::limit::limits;
use crate::progress::Bar;
use luenberger_study::execute::SweepOptions;
use luenberger_study::{RunOptions, Step, execute_in_part};
use std::path::PathBuf;

/// Executes one step of a study, or all.
pub(crate) fn step(step: Step, input: &StudyInput) -> Result<Answer, Failure> {
    execute(step, input, SweepOptions::default())
}

pub(super) fn execute(step: Step, input: &StudyInput, sweep: SweepOptions) -> Result<Answer, Failure> {
    let study = read(&input.study)?;
    let bar = Bar::new();
    let options = RunOptions {
        output: folder(step, input),
        force: input.force,
        limits: limits(&input.limit),
        sweep,
        progress: &|progress| bar.tell(progress.stage, progress.item, progress.done, progress.total),
        cancel: interrupt::flag(),
        threads: input.threads,
        ..RunOptions::default()
    };
    cost::announce(&study, step, &options.limits, options.thread_count(), 1)?;
    let executed = execute_in_part(&study, step, &options);
    bar.finish();
    let (results, stopped) = executed?;
    if let Some(folder) = &options.output {
        renamed(folder, &results.renamed);
    }
    notes(&results.notes);
    text_report::answer(step, &results, options.output.as_deref(), input.markdown, stopped)
}

/// Results folder: the one given, or by default that of the study if the results of the step are files.
fn folder(step: Step, input: &StudyInput) -> Option<PathBuf> {
    let leaves_files = matches!(step, Step::Run | Step::Certify | Step::Simulate | Step::Sweep);
    (leaves_files || input.output.is_some()).then(|| folder_of(input.output.as_deref(), &input.study))
}
