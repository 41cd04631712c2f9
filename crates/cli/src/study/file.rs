//! The study file that is read, the folder of its results, and the files that had to make way for them.

use crate::failure::Failure;
use crate::input::Source;
use luenberger_study::{Format, Study};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Tells which files of others, or changed ones, had to make way.
pub(super) fn renamed(folder: &Path, files: &[(String, String)]) {
    for (name, other) in files {
        let (path, other) = (folder.join(name), folder.join(other));
        _ = writeln!(
            std::io::stderr(),
            "note: {} was not written by luenberger, or was changed since; it is now {}",
            path.display(),
            other.display()
        );
    }
}

/// The study in a file or on standard input, where a text that begins with `{` is JSON.
pub(super) fn read(source: &Source) -> Result<Study, Failure> {
    match source {
        Source::File(path) => Ok(Study::from_path(path)?),
        Source::Standard => {
            let text = source.text()?;
            let format = if text.trim_start().starts_with('{') { Format::Json } else { Format::Toml };
            Ok(Study::from_text(&source.to_string(), &text, format, Path::new("."))?)
        }
    }
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
        _ = writeln!(std::io::stderr(), "note: {note}");
    }
}
