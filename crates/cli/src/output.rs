//! Standard output, and files. A reader that closes the pipe has seen enough: that is no error, and no panic.

use crate::failure::Failure;
use std::fs::File;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;

/// Prints text that ends its own lines.
pub(crate) fn text(text: &str) {
    let mut out = std::io::stdout().lock();
    _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

/// Prints one line.
pub(crate) fn line(line: &str) {
    text(&format!("{line}\n"));
}

/// Writes a new file; over one that is there only with `force`.
pub(crate) fn file(path: &Path, text: &str, force: bool) -> Result<(), Failure> {
    let name = || path.display().to_string();
    let opened = if force { File::create(path) } else { File::create_new(path) };
    opened.and_then(|mut file| file.write_all(text.as_bytes())).map_err(|error| {
        if error.kind() == ErrorKind::AlreadyExists {
            Failure::Exists { path: name() }
        } else {
            Failure::Write { path: name(), error }
        }
    })
}

/// Whether colours are welcome: on a terminal, unless `NO_COLOR` is set to anything.
pub(crate) fn is_coloured(stream: &impl IsTerminal) -> bool {
    stream.is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}
