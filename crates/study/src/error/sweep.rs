//! Errors of the blocks of a sweep.

use std::fmt;
use std::path::PathBuf;

use luenberger_proof::wording::counted;

/// The plan of a sweep in its folder.
pub(crate) const PLAN: &str = "plan.json";

/// Error of the blocks of a sweep.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SweepError {
    /// A folder without a sweep.
    #[error("{} has no sweep: there is no {}", folder.display(), PLAN)]
    NoSweep {
        /// The folder.
        folder: PathBuf,
    },
    /// The plan of a folder cannot be understood.
    #[error(
        "{} is damaged: restore it, or begin again with --restart, which deletes the blocks of the folder",
        path.display()
    )]
    Plan {
        /// The file.
        path: PathBuf,
    },
    /// The folder has the blocks of another study.
    #[error(
        "{} has blocks of another sweep: {what}; choose another folder with -o, or delete these blocks with --restart",
        folder.display()
    )]
    Other {
        /// The folder.
        folder: PathBuf,
        /// What differs.
        what: String,
    },
    /// A size that no block has.
    #[error("a block of {} is not possible: expected 1 to {largest}", counted(*size as usize, "run"))]
    BlockSize {
        /// The size.
        size: u64,
        /// The largest one.
        largest: u64,
    },
    /// More blocks than a folder should have files.
    #[error("the sweep has {blocks} blocks (limit {most}): --block-size {least} or larger")]
    TooManyBlocks {
        /// Number of blocks.
        blocks: u64,
        /// The largest number.
        most: u64,
        /// The least block size.
        least: u64,
    },
    /// Blocks are missing.
    #[error(
        "{} of {blocks} blocks {} missing ({}): complete the sweep with: luenberger sweep STUDY -o {}",
        missing.len(), if missing.len() == 1 { "is" } else { "are" }, some(missing), folder.display()
    )]
    Missing {
        /// The folder.
        folder: PathBuf,
        /// Their numbers.
        missing: Vec<u64>,
        /// The number of all blocks.
        blocks: u64,
    },
    /// A block that is truncated, damaged or of another sweep.
    #[error("{} {fault}: compute it again with: luenberger sweep STUDY -o {}", path.display(), folder.display())]
    Fault {
        /// The folder.
        folder: PathBuf,
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        fault: Fault,
    },
    /// A block cannot be written.
    #[error("{}: {error}; finished blocks are kept, and the same command resumes", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        error: std::io::Error,
    },
    /// A block that a sweep does not have.
    #[error("there is no block {block}: the sweep has {blocks}, numbered from 0")]
    NoBlock {
        /// The block.
        block: u64,
        /// Number of blocks.
        blocks: u64,
    },
    /// Another process computes blocks of the folder.
    #[error("{} is in use: another process computes its blocks", folder.display())]
    InUse {
        /// The folder.
        folder: PathBuf,
    },
}

/// Why a file is not the block it should be.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fault {
    /// It does not end with a digest.
    Truncated,
    /// Its bytes have not the digest at its end.
    Damaged,
    /// It is a block of another study, or another version.
    Foreign,
    /// It is another block of the same sweep.
    Other {
        /// Its number.
        block: u64,
    },
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Truncated => write!(f, "is cut short, or is no block of a sweep"),
            Self::Damaged => write!(f, "is damaged (its checksum does not match)"),
            Self::Foreign => write!(f, "is a block of another study, or of another version"),
            Self::Other { block } => write!(f, "is a copy of block {block}"),
        }
    }
}

/// The first ones of some numbers.
fn some(numbers: &[u64]) -> String {
    const SHOWN: usize = 8;
    let shown: Vec<String> = numbers.iter().take(SHOWN).map(u64::to_string).collect();
    shown.join(", ") + if numbers.len() > SHOWN { ", .." } else { "" }
}
