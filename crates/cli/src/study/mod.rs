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
mod sweep;
mod sweep_script;
mod text_log;
mod text_report;

use crate::answer::Answer;
use crate::arguments::StudyInput;
use crate::failure::Failure;
use crate::input::Source;
use crate::limit::limits;
use crate::progress::Bar;
use file::{read, renamed};
use luenberger_study::execute::SweepOptions;
use luenberger_study::{RunOptions, Step, execute_in_part};
use std::path::{Path, PathBuf};

pub(crate) use export::export;
pub(crate) use new::new;
pub(crate) use sweep::sweep;

/// Executes one step of a study, or all.
pub(crate) fn step(step: Step, input: &StudyInput) -> Result<Answer, Failure> {
    execute(step, input, SweepOptions::default())
}

fn execute(step: Step, input: &StudyInput, sweep: SweepOptions) -> Result<Answer, Failure> {
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
    cost::announce(&study, step, &options.limits, options.threads(), 1)?;
    let executed = execute_in_part(&study, step, &options);
    bar.finish();
    let (results, stopped) = executed?;
    if let Some(folder) = &options.output {
        renamed(folder, &results.renamed);
    }
    sweep::notes(&results.notes);
    text_report::answer(step, &results, options.output.as_deref(), stopped)
}

/// Results folder: the one given, or by default that of the study if the results of the step are files.
fn folder(step: Step, input: &StudyInput) -> Option<PathBuf> {
    let leaves_files = matches!(step, Step::Run | Step::Certify | Step::Simulate | Step::Sweep);
    (leaves_files || input.output.is_some()).then(|| folder_of(input.output.as_deref(), &input.study))
}

/// The results folder that is given, or by default `study-results` for `study.toml` and for standard input.
fn folder_of(output: Option<&Path>, study: &Source) -> PathBuf {
    let stem = match study {
        Source::File(path) => path.file_stem(),
        Source::Standard => None,
    };
    let stem = stem.map_or_else(|| "study".into(), |stem| stem.to_string_lossy());
    output.map_or_else(|| PathBuf::from(format!("{stem}-results")), Path::to_owned)
}
