//! How far a sweep is, from the files in its folder.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde::Serialize;

use super::folder::BlockFolder;
use super::plan::Plan;
use super::{BLOCKS, names};
use crate::error::StudyError;
use crate::execute::sweep::store::Blocks;

/// Blocks of which the rate is formed, the latest ones.
const LATEST: usize = 100;

/// How far a sweep is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SweepStatus {
    /// The name of the study.
    pub study: String,
    /// Number of blocks.
    pub blocks: u64,
    /// Number of runs.
    pub runs: u64,
    /// Runs of a block.
    pub block_size: u64,
    /// Blocks that are there.
    pub done: u64,
    /// Their runs.
    pub done_runs: u64,
    /// The numbers of the blocks that are missing.
    pub missing: Vec<u64>,
    /// Those of them that a process computes now; none are known on file systems without locks.
    pub running: Vec<u64>,
    /// Blocks that are truncated, damaged or of another sweep, with what is wrong; empty unless they were looked for.
    pub faults: Vec<String>,
    /// Runs per second, from the times of the latest hundred blocks; none with less than two.
    pub rate: Option<f64>,
    /// Seconds until the missing blocks are computed at this rate; none if it is not known.
    pub remaining: Option<f64>,
}

/// How far the sweep in a results folder is. With `verify` each block is read; a faulty one counts as missing.
///
/// # Errors
/// [`StudyError::Sweep`] for a folder without a sweep, and errors of files.
pub fn sweep_status(folder: &Path, verify: bool) -> Result<SweepStatus, StudyError> {
    let path = folder.join(BLOCKS);
    let plan = BlockFolder::plan(&path)?;
    let listed = BlockFolder::list(&path)?;
    let place = BlockFolder::existing(path.clone());
    let mut done: Vec<u64> = listed.blocks.into_iter().filter(|block| *block < plan.blocks()).collect();
    let mut faults = Vec::new();
    if verify {
        plan.check_version(&path)?;
        let study = BlockFolder::study(&path, &plan)?;
        let blocks = Blocks::new(plan.clone(), names(&study), Some(place.clone()));
        let mut sound = Vec::new();
        for block in done {
            match blocks.find(block)? {
                Ok(Some(_)) => sound.push(block),
                Ok(None) => {}
                Err(fault) => faults.push(format!("{} {fault}", blocks.name(block).display())),
            }
        }
        done = sound;
    }
    let missing: Vec<u64> = (0..plan.blocks()).filter(|block| done.binary_search(block).is_err()).collect();
    let running = place.running(&listed.locks);
    let rate = rate(&plan, done.iter().map(|block| (*block, place.file(*block))));
    let left: u64 = missing.iter().map(|block| plan.count(*block)).sum();
    let done_runs = plan.runs() - left;
    Ok(SweepStatus {
        blocks: plan.blocks(),
        runs: plan.runs(),
        block_size: plan.block_size,
        done: done.len() as u64,
        done_runs,
        missing,
        running,
        faults,
        rate,
        remaining: rate.map(|rate| left as f64 / rate),
        study: plan.study.name,
    })
}

/// Runs per second between the first and the last of the latest blocks.
fn rate(plan: &Plan, files: impl Iterator<Item = (u64, PathBuf)>) -> Option<f64> {
    // A block that vanishes meanwhile has no time.
    let mut times: Vec<(SystemTime, u64)> =
        files.filter_map(|(block, file)| Some((file.metadata().ok()?.modified().ok()?, block))).collect();
    times.sort_unstable();
    let latest = &times[times.len().saturating_sub(LATEST)..];
    let ((begin, _), (end, _)) = (latest.first()?, latest.last()?);
    let seconds = end.duration_since(*begin).ok()?.as_secs_f64();
    let runs: u64 = latest[1..].iter().map(|(_, block)| plan.count(*block)).sum();
    (seconds > 0.0).then(|| runs as f64 / seconds)
}
