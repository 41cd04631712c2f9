//! The steps of a study: `run`, `observe`, `design`, `certify`, `simulate`, `compare`, and `sweep` in one process.

use super::file::{files, folder_of, notes, read, renamed};
use super::{cost, interrupt, text_report};
use crate::answer::Answer;
use crate::arguments::{RunInput, StudyInput};
use crate::failure::Failure;
use crate::input::Source;
use crate::limit::limits;
use crate::output;
use crate::progress::Bar;
use luenberger_study::execute::SweepOptions;
use luenberger_study::{RunOptions, Step, StudyError, execute_in_part};
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::{Duration, SystemTime};

/// How often the files of a study are looked at while it is watched.
const LOOK: Duration = Duration::from_millis(300);

/// Runs a study, once or whenever it or a file that it names is saved.
pub(crate) fn run(input: &RunInput) -> Result<Answer, Failure> {
    let study = &input.study;
    if !input.watch {
        return opened(step(Step::Run, study), study, input.open);
    }
    if study.study == Source::Standard {
        return Err(Failure::Usage("--watch needs a study in a file, and not on standard input"));
    }
    let interrupted = interrupt::flag();
    let mut is_open = input.open;
    loop {
        // Before they are read: what is saved during the run is run again.
        let files = files(&study.study);
        let seen = saved(&files);
        let answer = opened(step(Step::Run, study), study, is_open);
        if interrupted.load(Ordering::Relaxed) {
            return answer;
        }
        match &answer {
            Ok(answer) => _ = answer.deliver(false),
            Err(failure) => _ = failure.report(false),
        }
        is_open &= answer.is_err();
        output::say("watching: the study runs again when it is saved; Ctrl-C ends");
        while saved(&files) == seen {
            if interrupted.load(Ordering::Relaxed) {
                return Err(StudyError::Interrupted.into());
            }
            std::thread::sleep(LOOK);
        }
    }
}

/// When files were saved last; none of one that is not there.
fn saved(files: &[PathBuf]) -> Vec<Option<SystemTime>> {
    files.iter().map(|file| file.metadata().and_then(|about| about.modified()).ok()).collect()
}

/// The answer, with its report shown by the program that shows pages.
fn opened(answer: Result<Answer, Failure>, input: &StudyInput, is_open: bool) -> Result<Answer, Failure> {
    let report = folder_of(input.output.as_deref(), &input.study).join("report.html");
    if is_open
        && answer.is_ok()
        && let Err(error) = open::that_detached(&report)
    {
        output::say(&format!("note: {} cannot be opened: {error}", report.display()));
    }
    answer
}

/// Executes one step of a study, or all.
pub(crate) fn step(step: Step, input: &StudyInput) -> Result<Answer, Failure> {
    execute(step, input, SweepOptions::default())
}

pub(super) fn execute(step: Step, input: &StudyInput, sweep: SweepOptions) -> Result<Answer, Failure> {
    let study = read(&input.study)?;
    let bar = Bar::new();
    let folder = folder(step, input);
    let options = RunOptions {
        output: folder.clone().map(Into::into),
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
    if let Some(folder) = &folder {
        renamed(folder, &results.renamed);
    }
    notes(&results.notes);
    text_report::answer(step, &results, folder.as_deref(), input.markdown, stopped)
}

/// Results folder: the one given, or by default that of the study if the results of the step are files.
fn folder(step: Step, input: &StudyInput) -> Option<PathBuf> {
    let leaves_files = matches!(step, Step::Run | Step::Certify | Step::Simulate | Step::Sweep);
    (leaves_files || input.output.is_some()).then(|| folder_of(input.output.as_deref(), &input.study))
}
