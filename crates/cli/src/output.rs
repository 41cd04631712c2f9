//! Standard output, and files. A closed pipe (as with `head`) is not an error.

use std::fs::File;
use std::io::{self, IsTerminal, Write};
use std::path::Path;

/// Prints text as it is, without adding a newline.
pub(crate) fn text(text: &str) {
    let mut out = io::stdout().lock();
    _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

/// Prints one line.
pub(crate) fn line(line: &str) {
    text(&format!("{line}\n"));
}

/// Writes a new file; overwrites an existing one only with `force`.
pub(crate) fn file(path: &Path, text: &str, force: bool) -> io::Result<()> {
    let mut file = if force { File::create(path) } else { File::create_new(path) }?;
    file.write_all(text.as_bytes())
}

/// Whether to use colours: on a terminal, unless `NO_COLOR` is set.
pub(crate) fn is_coloured(stream: &impl IsTerminal) -> bool {
    stream.is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}
