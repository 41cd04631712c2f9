//! Limits of the files that are read.

/// The largest file in bytes.
pub const LARGEST_FILE: usize = 8 << 20;

/// How deep arrays and objects may be nested: a certificate needs seven.
pub const DEEPEST: usize = 16;

/// The most work of the facts of a `sampled-observer-at-varying-periods`: the cube of the number of states for each
/// number of periods between two corrections, 1 to misses + 1, and each of the maps (two of the radial step).
pub const MOST_MOTION: usize = 1 << 22;

/// The most values, arrays and objects among them, in a file: what reading takes is proportional to it.
pub const MOST_VALUES: usize = 1 << 21;
