//! The study file that is read, and the files that had to make way for the results.

use crate::failure::Failure;
use crate::input::Source;
use luenberger_study::{Format, Study};
use std::io::Write;
use std::path::Path;

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
