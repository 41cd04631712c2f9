//! The study file that is read, the folder of its results, and the files that had to make way for them.

use crate::failure::Failure;
use crate::input::Source;
use crate::output;
use luenberger_study::{Format, Study};
use std::fs;
use std::path::{Path, PathBuf};

/// Tells which files of others, or changed ones, had to make way.
pub(super) fn renamed(folder: &Path, files: &[(String, String)]) {
    for (name, other) in files {
        let (path, other) = (folder.join(name), folder.join(other));
        output::say(&format!(
            "note: {} was not written by luenberger, or was changed since; it is now {}",
            path.display(),
            other.display()
        ));
    }
}

/// The study in a file, in the `study.toml` of a folder, or on standard input, where a text that begins with `{` is
/// JSON.
pub(super) fn read(source: &Source) -> Result<Study, Failure> {
    match source {
        Source::File(folder) if folder.is_dir() => Ok(Study::from_path(&in_folder(folder)?)?),
        Source::File(path) => Ok(Study::from_path(path)?),
        Source::Standard => {
            let text = source.text()?;
            let format = if text.trim_start().starts_with('{') { Format::Json } else { Format::Toml };
            Ok(Study::from_text(&source.to_string(), &text, format, Path::new("."))?)
        }
    }
}

/// The study in a folder: `study.toml`, or the only file in TOML.
fn in_folder(folder: &Path) -> Result<PathBuf, Failure> {
    let origin = || folder.display().to_string();
    let study = folder.join("study.toml");
    if study.is_file() {
        return Ok(study);
    }
    let entries = fs::read_dir(folder).map_err(|error| Failure::Read { origin: origin(), error })?;
    let mut found: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    found.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    found.sort();
    match &found[..] {
        [study] => Ok(study.clone()),
        _ => Err(Failure::NoStudy { folder: origin(), found: found.len() }),
    }
}

/// The file of a study and those that it names; the first alone where it cannot be read.
pub(super) fn files(source: &Source) -> Vec<PathBuf> {
    let Source::File(path) = source else { return Vec::new() };
    let study = if path.is_dir() { in_folder(path).unwrap_or_else(|_| path.clone()) } else { path.clone() };
    let named = Study::from_path(&study).map(|study| study.files).unwrap_or_default();
    let beside = |name: String| study.with_file_name(name);
    let named: Vec<PathBuf> = named.into_iter().map(|file| beside(file.name)).collect();
    std::iter::once(study).chain(named).collect()
}

/// The results folder that is given, or by default `study-results` for `study.toml` and for standard input.
pub(super) fn folder_of(output: Option<&Path>, study: &Source) -> PathBuf {
    let stem = match study {
        Source::File(path) => path.file_stem(),
        Source::Standard => None,
    };
    let stem = stem.map_or_else(|| "study".into(), |stem| stem.to_string_lossy());
    output.map_or_else(|| PathBuf::from(format!("{stem}-results")), Path::to_owned)
}

/// What is said beside the results, on standard error.
pub(super) fn notes(notes: &[String]) {
    for note in notes {
        output::say(&format!("note: {note}"));
    }
}
