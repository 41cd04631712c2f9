//! What the trajectories of a sweep are, and how they are divided into blocks and shards.
//!
//! The rows of a sweep are its observers at its values. Each row has an ensemble of trajectories, and a block is a part
//! of one row: block b of a sweep with k blocks per row has the trajectories (b mod k) B, (b mod k) B + 1, .. of row b
//! / k, B of them, or what is left of the row.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::rows::rows;
use crate::digest::{self, FileDigest};
use crate::error::StudyError;
use crate::error::sweep::SweepError;
use crate::execute::Step;
use crate::read::Format;
use crate::study::Study;

/// The version of the format of blocks.
pub(super) const FORMAT: u32 = 1;

/// The largest number of blocks, which are files of one folder.
const MOST_BLOCKS: u64 = 1_000_000;

/// The largest number of trajectories of a block, which is in memory.
const LARGEST_BLOCK: u64 = 1_000_000;

/// Blocks of an ensemble by default, and the bounds of their sizes.
const PARTS: u64 = 16;
const SMALLEST: u64 = 32;
const LARGEST: u64 = 1000;

/// The trajectories of a sweep, and their division into blocks: content of `plan.json`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Plan {
    /// The version of the format of blocks.
    pub format: u32,
    /// The version of luenberger.
    pub luenberger: String,
    /// The study.
    pub study: FileDigest,
    /// Whether the study is JSON, and not TOML.
    pub json: bool,
    /// The files of data that the study reads.
    pub files: Vec<FileDigest>,
    /// Number of rows: observers times values.
    pub rows: u64,
    /// Trajectories of each row.
    pub ensemble: u64,
    /// Trajectories of a block; the last one of a row may have fewer.
    pub block_size: u64,
}

/// The trajectories of a block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Part {
    /// The row.
    pub(super) row: usize,
    /// The numbers of the trajectories in their ensemble.
    pub(super) runs: Range<u64>,
}

impl Plan {
    /// The plan of the sweep of a study; the block size is by default a sixteenth of the ensemble, from 32 to 1000.
    ///
    /// # Errors
    /// [`StudyError::Missing`] for a study without a sweep, and block sizes that are not possible.
    pub fn of_study(study: &Study, block_size: Option<u64>) -> Result<Self, StudyError> {
        let missing = |needs| Err(StudyError::Missing { step: Step::Sweep.name(), needs });
        let (sweep, simulation) = match (&study.sweep, &study.simulation) {
            (Some(sweep), _) if sweep.on_log => {
                return missing(
                    "a [sweep] in a simulation for blocks and shards: one on a log has one run at each value",
                );
            }
            (Some(sweep), Some(simulation)) => (sweep, simulation),
            _ => return missing("a [sweep]"),
        };
        Ok(Self::of(study, rows(study, simulation, sweep).len(), sweep.ensemble, block_size)?)
    }

    /// The plan of a sweep; the block size is by default a sixteenth of the ensemble, from 32 to 1000.
    pub(super) fn of(study: &Study, rows: usize, ensemble: usize, block_size: Option<u64>) -> Result<Self, SweepError> {
        let (rows, ensemble) = (rows as u64, ensemble as u64);
        let block_size = block_size.unwrap_or_else(|| ensemble.div_ceil(PARTS).clamp(SMALLEST, LARGEST)).min(ensemble);
        let plan = Self {
            format: FORMAT,
            luenberger: env!("CARGO_PKG_VERSION").to_owned(),
            study: FileDigest { name: study.file_name(), sha256: digest::sha256(study.source.text().as_bytes()) },
            json: study.format == Format::Json,
            files: study.files.clone(),
            rows,
            ensemble,
            block_size,
        };
        if !(1..=LARGEST_BLOCK).contains(&block_size) {
            return Err(SweepError::BlockSize { size: block_size, largest: LARGEST_BLOCK });
        }
        if plan.blocks() > MOST_BLOCKS {
            let least = rows.saturating_mul(ensemble).div_ceil(MOST_BLOCKS);
            return Err(SweepError::TooManyBlocks { blocks: plan.blocks(), most: MOST_BLOCKS, least });
        }
        Ok(plan)
    }

    /// The digest of all that decides the content of the blocks.
    pub fn digest(&self) -> String {
        // Names, numbers and digests: there is nothing that JSON does not have.
        digest::sha256(&serde_json::to_vec(self).unwrap_or_default())
    }

    /// Checks that this version has written the blocks of a folder.
    pub(super) fn check_version(&self, folder: &std::path::Path) -> Result<(), SweepError> {
        let this = env!("CARGO_PKG_VERSION");
        if self.format == FORMAT && self.luenberger == this {
            return Ok(());
        }
        let what = format!("they are of luenberger {}, and this is {this}", self.luenberger);
        Err(SweepError::Other { folder: folder.to_owned(), what })
    }

    /// Blocks of each row.
    fn per_row(&self) -> u64 {
        self.ensemble.div_ceil(self.block_size)
    }

    /// Number of blocks.
    pub fn blocks(&self) -> u64 {
        self.rows.saturating_mul(self.per_row())
    }

    /// Number of runs.
    pub fn runs(&self) -> u64 {
        self.rows.saturating_mul(self.ensemble)
    }

    /// The trajectories of a block.
    pub(super) fn part(&self, block: u64) -> Part {
        let first = block % self.per_row() * self.block_size;
        Part { row: (block / self.per_row()) as usize, runs: first..(first + self.block_size).min(self.ensemble) }
    }

    /// Number of trajectories of a block.
    pub(super) fn count(&self, block: u64) -> u64 {
        let runs = self.part(block).runs;
        runs.end - runs.start
    }

    /// The blocks of a row.
    pub(super) fn of_row(&self, row: usize) -> Range<u64> {
        row as u64 * self.per_row()..(row as u64 + 1) * self.per_row()
    }
}

/// Part I of N of the blocks of a sweep: I, I + N, I + 2N, .., so that rows that take longer are shared by all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    number: u64,
    of: u64,
}

impl Shard {
    /// All blocks.
    pub const ALL: Self = Self { number: 1, of: 1 };

    /// Its number, from 1.
    pub fn number(self) -> u64 {
        self.number
    }

    /// The number of shards.
    pub fn of(self) -> u64 {
        self.of
    }

    /// The numbers of its blocks.
    pub fn blocks(self, plan: &Plan) -> impl Iterator<Item = u64> + use<> {
        (self.number - 1..plan.blocks()).step_by(self.of as usize)
    }
}

impl FromStr for Shard {
    type Err = String;

    /// `I/N`, with I from 1 to N.
    fn from_str(word: &str) -> Result<Self, String> {
        const EXPECTED: &str = "expected I/N, such as 1/4 for the first of four shards";
        let digits = |word: &str| word.parse::<u32>().ok().filter(|_| word.bytes().all(|byte| byte.is_ascii_digit()));
        let (number, of) = word.split_once('/').ok_or(EXPECTED)?;
        let (number, of) = digits(number).zip(digits(of)).ok_or(EXPECTED)?;
        match (number, of) {
            (_, 0) => Err("the number of shards is 0, expected at least 1".to_owned()),
            (number, of) if !(1..=of).contains(&number) => {
                Err(format!("there is no shard {number} of {of}: they are numbered from 1 to {of}"))
            }
            (number, of) => Ok(Self { number: number.into(), of: of.into() }),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}
