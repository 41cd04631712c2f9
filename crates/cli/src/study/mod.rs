//! The commands on study files: `new`, and the steps `run`, `observe`, `design`, `certify`, `simulate`, `compare`,
//! `sweep`.

mod columns;
mod cost;
mod export;
mod export_fmu;
mod export_numbers;
mod file;
mod interrupt;
mod new;
mod text_log;
mod text_report;

use crate::answer::Answer;
use crate::arguments::StudyInput;
use crate::failure::Failure;
use crate::input::Source;
use crate::limit::limits;
use crate::progress::Bar;
use file::{read, renamed};
use luenberger_study::{RunOptions, Step, execute_in_part};
use std::path::PathBuf;

pub(crate) use export::export;
pub(crate) use new::new;

/// Executes one step of a study, or all.
pub(crate) fn step(step: Step, input: &StudyInput) -> Result<Answer, Failure> {
    let study = read(&input.study)?;
    let bar = Bar::new();
    let options = RunOptions {
        output: folder(step, input),
        force: input.force,
        limits: limits(&input.limit),
        progress: &|progress| bar.tell(progress.stage, progress.item, progress.done, progress.total),
        cancel: interrupt::flag(),
        threads: input.threads,
        ..RunOptions::default()
    };
    cost::announce(&study, step, &options.limits, options.threads())?;
    let executed = execute_in_part(&study, step, &options);
    bar.finish();
    let (results, stopped) = executed?;
    if let Some(folder) = &options.output {
        renamed(folder, &results.renamed);
    }
    let failures = results.failures();
    let text = text_report::results(step, &results, &failures, options.output.as_deref());
    let answer = Answer::new(text, &results)?.negative(!failures.is_empty());
    match stopped {
        None => Ok(answer),
        Some(error) => Err(Failure::Stopped { error, finished: Box::new(answer) }),
    }
}

/// Results folder: the one given, or by default `study-results` for `study.toml` and for standard input, if the results
/// of the step are files.
fn folder(step: Step, input: &StudyInput) -> Option<PathBuf> {
    let leaves_files = matches!(step, Step::Run | Step::Certify | Step::Simulate | Step::Sweep);
    let stem = match &input.study {
        Source::File(path) => path.file_stem(),
        Source::Standard => None,
    };
    let stem = stem.map_or_else(|| "study".into(), |stem| stem.to_string_lossy());
    let beside = || PathBuf::from(format!("{stem}-results"));
    input.output.clone().or_else(|| leaves_files.then(beside))
}
