//! Where the blocks of a sweep are: in a folder, or in memory where a study is executed without one.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use super::block::Block;
use super::folder::{BlockFolder, Claim};
use super::plan::Plan;
use crate::error::StudyError;
use crate::error::sweep::Fault;

/// The blocks of a sweep.
pub(in crate::execute) struct Blocks {
    plan: Plan,
    digest: String,
    names: Vec<String>,
    place: Place,
}

enum Place {
    Memory(Mutex<BTreeMap<u64, Vec<u8>>>),
    Folder(BlockFolder),
}

/// The answer to a claim.
pub(super) enum Claimed {
    /// The block may be written; in memory there is nothing to claim.
    Mine(Option<Claim>),
    /// Another process computes it.
    Held,
    /// It is there.
    Present,
}

impl Blocks {
    /// Blocks in a folder, or in memory; the scores have these names.
    pub(super) fn new(plan: Plan, names: Vec<String>, folder: Option<BlockFolder>) -> Self {
        let place = folder.map_or_else(|| Place::Memory(Mutex::default()), Place::Folder);
        Self { digest: plan.digest(), plan, names, place }
    }

    pub(super) fn plan(&self) -> &Plan {
        &self.plan
    }

    pub(super) fn digest(&self) -> &str {
        &self.digest
    }

    /// The names of the scores.
    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    /// The file of a block.
    pub(super) fn name(&self, block: u64) -> PathBuf {
        match &self.place {
            Place::Memory(_) => PathBuf::new(),
            Place::Folder(folder) => folder.file(block),
        }
    }

    /// The folder, if there is one.
    pub(super) fn folder(&self) -> Option<&BlockFolder> {
        match &self.place {
            Place::Memory(_) => None,
            Place::Folder(folder) => Some(folder),
        }
    }

    /// The block, if it is there, or what is wrong with its file.
    pub(super) fn find(&self, block: u64) -> Result<Result<Option<Block>, Fault>, StudyError> {
        let decoded = |bytes: &[u8]| Block::decode(bytes, block, &self.digest, &self.names);
        match &self.place {
            Place::Memory(blocks) => {
                let blocks = blocks.lock().unwrap_or_else(PoisonError::into_inner);
                Ok(blocks.get(&block).map(|bytes| decoded(bytes)).transpose())
            }
            Place::Folder(folder) => Ok(folder.read(block)?.map(|bytes| decoded(&bytes)).transpose()),
        }
    }

    /// Whether there is a file of the block, or the block in memory.
    pub(super) fn is_there(&self, block: u64) -> bool {
        match &self.place {
            Place::Memory(blocks) => blocks.lock().unwrap_or_else(PoisonError::into_inner).contains_key(&block),
            Place::Folder(folder) => folder.file(block).exists(),
        }
    }

    /// Writes the runs of a block as comma-separated values beside it.
    pub(super) fn put_csv(&self, block: u64, lines: &str) -> Result<(), StudyError> {
        match &self.place {
            Place::Memory(_) => Ok(()),
            Place::Folder(folder) => folder.publish(&folder.file(block).with_extension("csv"), lines.as_bytes()),
        }
    }

    /// The right to write a block that is missing.
    pub(super) fn claim(&self, block: u64) -> Result<Claimed, StudyError> {
        let Place::Folder(folder) = &self.place else { return Ok(Claimed::Mine(None)) };
        let Some(claim) = folder.claim(block)? else { return Ok(Claimed::Held) };
        // Another process may have written it since it was missed.
        if let Ok(Some(_)) = self.find(block)? {
            folder.release(&claim);
            return Ok(Claimed::Present);
        }
        Ok(Claimed::Mine(Some(claim)))
    }

    /// Writes a block.
    pub(super) fn put(&self, claim: Option<&Claim>, block: &Block) -> Result<(), StudyError> {
        let number = block.header.block;
        let failed = |error: zip::result::ZipError| StudyError::Output {
            what: format!("block {number}"),
            why: error.to_string(),
        };
        let bytes = block.encode(&self.names).map_err(failed)?;
        match &self.place {
            Place::Folder(folder) => folder.put(number, claim, &bytes),
            Place::Memory(blocks) => {
                blocks.lock().unwrap_or_else(PoisonError::into_inner).insert(number, bytes);
                Ok(())
            }
        }
    }
}
