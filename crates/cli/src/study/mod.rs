//! The commands on study files: `new`, and the steps `run`, `observe`, `design`, `certify`, `simulate`, `compare`,
//! `sweep`.

mod cost;
mod interrupt;
mod new;
mod text_log;
mod text_report;

use crate::answer::Answer;
use crate::arguments::StudyInput;
use crate::failure::Failure;
use crate::progress::Bar;
use luenberger_study::{RunOptions, Step, Study, execute};
use std::path::{Path, PathBuf};

pub(crate) use new::new;

/// Executes one step of a study, or all.
pub(crate) fn step(step: Step, input: &StudyInput) -> Result<Answer, Failure> {
    let study = Study::from_path(&input.study)?;
    cost::announce(&study, step, input.threads);
    let bar = Bar::new();
    let options = RunOptions {
        output: folder(step, input),
        progress: &|progress| bar.tell(progress.stage, progress.item, progress.done, progress.total),
        cancel: interrupt::flag(),
        threads: input.threads,
    };
    let executed = execute(&study, step, &options);
    bar.finish();
    let results = executed?;
    let failures = results.failures();
    let text = text_report::results(step, &results, &failures, options.output.as_deref());
    Ok(Answer::new(text, &results)?.negative(!failures.is_empty()))
}

/// Output folder: the one given, or by default `study-results` for `study.toml` if the results of the step are files.
fn folder(step: Step, input: &StudyInput) -> Option<PathBuf> {
    let leaves_files = matches!(step, Step::Run | Step::Certify | Step::Simulate | Step::Sweep);
    let stem = input.study.file_stem().unwrap_or_else(|| Path::new("study").as_os_str());
    let beside = || PathBuf::from(format!("{}-results", stem.to_string_lossy()));
    input.output.clone().or_else(|| leaves_files.then(beside))
}
