//! Standard output, and files. A closed pipe (as with `head`) is not an error; a full disk is.

use crate::exit::NEGATIVE;
use std::fs::File;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::process::ExitCode;
use std::sync::OnceLock;

/// Prints text as it is, without adding a newline.
pub(crate) fn text(text: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush())
}

/// Prints one line.
pub(crate) fn line(line: &str) -> io::Result<()> {
    text(&format!("{line}\n"))
}

/// The exit code after standard output could not be written: `otherwise` for a closed pipe, whose reader has what it
/// wanted.
pub(crate) fn failed(error: &io::Error, otherwise: ExitCode) -> ExitCode {
    if error.kind() == io::ErrorKind::BrokenPipe {
        return otherwise;
    }
    _ = writeln!(io::stderr(), "error: standard output cannot be written: {error}");
    ExitCode::from(NEGATIVE)
}

/// What is said on standard error beside errors.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Volume {
    /// Nothing.
    Quiet,
    /// Notes; progress on a terminal.
    #[default]
    Normal,
    /// Progress and estimates elsewhere too.
    Verbose,
}

static VOLUME: OnceLock<Volume> = OnceLock::new();

/// Sets what is said, once.
pub(crate) fn set_volume(volume: Volume) {
    _ = VOLUME.set(volume);
}

/// What is said.
pub(crate) fn volume() -> Volume {
    VOLUME.get().copied().unwrap_or_default()
}

/// Says something on standard error, unless nothing is to be said. What cannot be written there is lost.
pub(crate) fn say(line: &str) {
    if volume() > Volume::Quiet {
        _ = writeln!(io::stderr(), "{line}");
    }
}

/// Writes a new file; replaces an existing one only with `force`. Whatever fails, no file is incomplete.
pub(crate) fn file(path: &Path, text: &str, force: bool) -> io::Result<()> {
    if force {
        // Links and devices are written through.
        let is_other = std::fs::symlink_metadata(path).is_ok_and(|found| !found.is_file());
        return if is_other { File::create(path)?.write_all(text.as_bytes()) } else { replace(path, text) };
    }
    let mut file = File::create_new(path)?;
    let written = file.write_all(text.as_bytes());
    if written.is_err() {
        // No incomplete file is left.
        _ = std::fs::remove_file(path);
    }
    written
}

/// Puts a file in the place of an older one: whoever reads it finds the one or the other, complete.
pub(crate) fn replace(path: &Path, text: &str) -> io::Result<()> {
    let name = path.file_name().ok_or(io::ErrorKind::InvalidFilename)?;
    let aside = path.with_file_name(format!(".{}.partial", name.to_string_lossy()));
    let written = File::create(&aside).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        file.sync_all()
    });
    let replaced = written.and_then(|()| std::fs::rename(&aside, path));
    if replaced.is_err() {
        _ = std::fs::remove_file(&aside);
    }
    replaced
}

/// Whether to use colours: on a terminal, unless `NO_COLOR` is set.
pub(crate) fn is_coloured(stream: &impl IsTerminal) -> bool {
    stream.is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}
