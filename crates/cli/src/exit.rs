//! Exit codes; that of success is the standard library's.

/// Negative answer: the input is valid, and there is no solution or no proof; or the output cannot be written.
pub(crate) const NEGATIVE: u8 = 1;

/// Invalid input: usage, files, data.
pub(crate) const WRONG: u8 = 2;

/// The shell's exit code of a command that Ctrl-C has ended.
pub(crate) const INTERRUPTED: u8 = 130;
