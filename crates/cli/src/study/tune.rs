//! `luenberger tune`: what a filter assumes, fitted to its log.

use super::file::{folder_of, read, renamed};
use super::interrupt;
use crate::answer::Answer;
use crate::arguments::TuneInput;
use crate::failure::Failure;
use crate::progress::Bar;
use luenberger_proof::wording::counted;
use luenberger_study::RunOptions;
use luenberger_study::tune::{TuneOptions, tune as fitted};
use std::fmt::Write;

pub(crate) fn tune(input: &TuneInput) -> Result<Answer, Failure> {
    let study = read(&input.study)?;
    let bar = Bar::new();
    let folder = input.folder.output.as_deref().map(|output| folder_of(Some(output), &input.study));
    let options = TuneOptions {
        run: RunOptions {
            output: folder.clone().map(Into::into),
            force: input.folder.force,
            progress: &|progress| bar.tell(progress.stage, progress.item, progress.done, progress.total),
            cancel: interrupt::flag(),
            threads: input.folder.threads,
            ..RunOptions::default()
        },
        write: true,
    };
    let fitted = fitted(&study, &options);
    bar.finish();
    let report = fitted?;
    if let Some(folder) = &folder {
        renamed(folder, &report.renamed);
    }
    let path = study.data.path(&report.file);
    let text = if input.folder.markdown {
        report.markdown()
    } else {
        let mut text = report.text();
        if let Some(folder) = &folder {
            let (files, page) = (counted(report.files.len(), "file"), folder.join("report.html"));
            _ = writeln!(text, "\n{files} in {}\nreport: {}", folder.display(), page.display());
        }
        let next = path.strip_prefix(".").unwrap_or(&path).display().to_string();
        _ = writeln!(text, "{}next: luenberger run {next}", if folder.is_some() { "" } else { "\n" });
        text
    };
    Ok(Answer::new(text, &report)?)
}
