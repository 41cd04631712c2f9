//! The exit codes. That of success is the standard library's.

/// A negative answer: the question was right, and there is no solution, or no proof.
pub(crate) const NEGATIVE: u8 = 1;

/// A wrong question: usage, files, data.
pub(crate) const WRONG: u8 = 2;

/// What a shell calls a command that Ctrl-C has ended.
pub(crate) const INTERRUPTED: u8 = 130;
