//! Verdicts in arithmetic that cannot lie: definiteness and matrix inequalities, proved or refuted.

pub mod verdict;

pub use verdict::{Doubt, Verdict};
