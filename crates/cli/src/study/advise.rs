//! `luenberger advise`: which observer to use for a study.

use super::file::{folder_of, read, renamed};
use super::interrupt;
use crate::answer::Answer;
use crate::arguments::AdviseInput;
use crate::failure::Failure;
use crate::progress::Bar;
use luenberger_proof::wording::counted;
use luenberger_study::RunOptions;
use luenberger_study::advise::{Advice, AdviseOptions, advise as compared};
use luenberger_study::execute::duration;
use std::fmt::Write;
use std::path::Path;

pub(crate) fn advise(input: &AdviseInput) -> Result<Answer, Failure> {
    let study = read(&input.study)?;
    let bar = Bar::new();
    let folder = input.folder.output.as_deref().map(|output| folder_of(Some(output), &input.study));
    let options = AdviseOptions {
        run: RunOptions {
            output: folder.clone().map(Into::into),
            force: input.folder.force,
            progress: &|progress| bar.tell(progress.stage, progress.item, progress.done, progress.total),
            cancel: interrupt::flag(),
            threads: input.folder.threads,
            ..RunOptions::default()
        },
        criteria: input.by.clone(),
        budget: input.budget,
        ..AdviseOptions::default()
    };
    let compared = compared(&study, &options);
    bar.finish();
    let (advice, stopped) = compared?;
    if let Some(folder) = &folder {
        renamed(folder, &advice.renamed);
    }
    let answer = Answer::new(text(&advice, input.budget, folder.as_deref(), input.folder.markdown), &advice)?;
    let answer = answer.negative(advice.ranking.is_empty());
    match stopped {
        None => Ok(answer),
        Some(error) => Err(Failure::Stopped { error, finished: Box::new(answer) }),
    }
}

fn text(advice: &Advice, budget: f64, folder: Option<&Path>, markdown: bool) -> String {
    let budget = duration(budget);
    if markdown {
        return advice.markdown(&budget);
    }
    let mut text = advice.text(&budget);
    if let Some(folder) = folder {
        _ = writeln!(text, "\n{} in {}", counted(advice.files.len() + 1, "file"), folder.display());
        if let Some(study) = advice.files.iter().find(|name| name.starts_with("study.")) {
            _ = writeln!(text, "next: luenberger run {}", folder.join(study).display());
        }
    }
    text
}
