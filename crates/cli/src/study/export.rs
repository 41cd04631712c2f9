//! `luenberger export`: an observer of a study as source code for the target.

use super::file::{notes, read, renamed};
use crate::answer::Answer;
use crate::arguments::{ExportInput, FmiVersion, Language, Libm};
use crate::failure::Failure;
use crate::input::Source;
use luenberger_export::fmu::Version;
use luenberger_export::names;
use luenberger_study::deployment::{self, ExportOptions, ExportedObserver};
use luenberger_study::write_folder;
use serde::Serialize;
use std::path::PathBuf;

#[derive(Serialize)]
struct Written<'a> {
    observer: &'a str,
    folder: String,
    files: Vec<&'a str>,
    #[serde(flatten)]
    exported: &'a ExportedObserver,
}

pub(crate) fn export(input: &ExportInput) -> Result<Answer, Failure> {
    let options = options(input);
    options.check()?;
    let study = read(&input.study)?;
    let exported = deployment::export(&study, input.observer.as_deref(), &options)?;
    notes(&exported.notes);
    let folder = folder(input, &exported.observer);
    let moved = write_folder(folder.as_path(), input.force, "export", &study, &exported.files)?;
    renamed(&folder, &moved);

    let folder = folder.display().to_string();
    let (text, files) = (exported.in_words(&folder), exported.files.iter().map(|(name, _)| name.as_str()).collect());
    Ok(Answer::new(text, &Written { observer: &exported.observer, folder, files, exported: &exported })?)
}

fn options(input: &ExportInput) -> ExportOptions<'static> {
    ExportOptions {
        to: match input.to {
            Language::C => deployment::Language::C,
            Language::Rust => deployment::Language::Rust,
            Language::Fmu => deployment::Language::Fmu,
        },
        fmi: input.fmi.map(|version| match version {
            FmiVersion::Two => Version::Two,
            FmiVersion::Three => Version::Three,
        }),
        layout: input.layout,
        feedback: input.feedback,
        format: input.format,
        gains: input.gains,
        libm: match input.libm {
            Libm::Own => deployment::Libm::Own,
            Libm::Target => deployment::Libm::Target,
        },
        period: input.period,
        substeps: input.substeps.map(usize::from),
        test_steps: input.test_steps.into(),
        unproved: input.unproved,
        designed: None,
    }
}

/// The folder given, or by default `study-NAME-c`.
fn folder(input: &ExportInput, observer: &str) -> PathBuf {
    let stem = match &input.study {
        Source::File(path) => path.file_stem().map(|stem| stem.to_string_lossy().into_owned()),
        Source::Standard => None,
    };
    let language = match input.to {
        Language::C => "c",
        Language::Rust => "rust",
        Language::Fmu => "fmu",
    };
    let name = names::identifier(observer);
    let beside = || PathBuf::from(format!("{}-{name}-{language}", stem.unwrap_or_else(|| "study".to_owned())));
    input.output.clone().unwrap_or_else(beside)
}
