//! Limits of the files that are read.

/// The largest file in bytes.
pub const LARGEST_FILE: usize = 8 << 20;

/// How deep arrays and objects may be nested: a certificate needs seven.
pub const DEEPEST: usize = 16;

/// The most values, arrays and objects among them, in a file: what reading takes is proportional to it.
pub const MOST_VALUES: usize = 1 << 21;
