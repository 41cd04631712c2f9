//! Parameter sweep: every observer at every value, with an ensemble of noise seeds and initial errors.
//!
//! A sweep is computed in blocks of runs ([`plan`]) that are written to a folder, by one process or by several, and
//! then reduced to its results ([`reduce`]). Each run depends only on the study, the value and its number in the
//! ensemble, and statistics are merged in the order of the blocks: the results do not depend on threads, processes and
//! interruptions.
//!
//! | file | subject |
//! |---|---|
//! | [`plan`] | runs, blocks and shards |
//! | [`rows`] | observers at values, with their designs |
//! | [`compute`] | computes blocks |
//! | [`block`], [`folder`], [`store`] | form of a block; folder of blocks that several processes write; folder or memory |
//! | [`runs`], [`statistics`], [`percentiles`], [`reduce`] | scores of a run; of an ensemble; from blocks to results |
//! | [`status`] | how far a sweep is |
//! | [`on_log`] | a sweep on a log, which has one run at each value and no blocks |

mod block;
mod compute;
mod folder;
pub(super) mod on_log;
pub(crate) mod percentiles;
mod plan;
mod reduce;
mod rows;
mod runs;
mod shared;
mod statistics;
mod status;
mod store;

use std::path::{Path, PathBuf};

use luenberger_proof::wording::counted;

use super::folder::Folder;
use super::options::{RunOptions, RunsAsCsv, Step};
use super::scores;
use crate::error::StudyError;
use crate::error::sweep::{Fault, SweepError};
use crate::results::SweepReport;
use crate::study::{Simulation, Study, Sweep};
use crate::trajectory::Member;
use compute::{Designs, Work};
use folder::BlockFolder;
use reduce::Reduced;
pub(super) use rows::initial as ensemble_initial;
pub(super) use store::Blocks;

pub use super::folder::BLOCKS;
pub use plan::{Plan, Shard};
pub use shared::{BlockSettings, SharedSweep, reduce_sweep};
pub use status::{SweepStatus, sweep_status};

/// What has become of some blocks.
#[derive(Debug, Default)]
pub struct Computed {
    /// Blocks that were computed.
    pub computed: u64,
    /// Their runs.
    pub runs: u64,
    /// Blocks that were there already, or that another process has computed meanwhile.
    pub present: u64,
    /// Files that were not the block they should be, which was computed again.
    pub faults: Vec<(PathBuf, Fault)>,
}

/// Number of runs of a sweep.
pub(super) fn runs(study: &Study, sweep: &Sweep) -> usize {
    rows::chosen(study, sweep).len() * sweep.values.len() * sweep.ensemble
}

/// The runs of a sweep in the simulation of a study.
pub(super) fn simulated(study: &Study, sweep: &Sweep) -> usize {
    if sweep.on_log { 0 } else { runs(study, sweep) }
}

/// Bytes of the reduction of a sweep: a block, and the values of percentiles.
pub(super) fn memory(study: &Study, sweep: &Sweep) -> f64 {
    if let (true, Some(log)) = (sweep.on_log, &study.log) {
        // Innovations and errors of each row that is held out.
        let (n, p) = (study.plant.states.len(), study.plant.outputs.len());
        return 16.0 * (n + p + 4) as f64 * runs(study, sweep) as f64 * log.recording.times().len() as f64;
    }
    let (scores, ensemble) = (names(study).len(), sweep.ensemble);
    let block = Plan::of_study(study, None).map_or(0, |plan| plan.block_size) as f64;
    8.0 * scores as f64 * block + reduce::memory(scores, ensemble) as f64
}

/// The blocks of a study's sweep for a step: in the results folder for `sweep`, where they stay; in its temporary part
/// for the other steps; in memory without a folder.
pub(super) fn blocks(
    study: &Study,
    step: Step,
    options: &RunOptions<'_>,
    folder: &Folder,
) -> Result<Option<Blocks>, StudyError> {
    if study.sweep.as_ref().is_none_or(|sweep| sweep.on_log) {
        return Ok(None);
    }
    match (step, folder.root()) {
        (Step::Sweep, Some(root)) => {
            let (size, restart) = (options.sweep.block_size, options.sweep.restart);
            let settings = BlockSettings { size, restart, force: options.force };
            shared::open(study, root.join(BLOCKS), settings).map(Some)
        }
        (Step::Sweep | Step::Run, _) => {
            let temporary = folder.temporary(BLOCKS).map(BlockFolder::temporary).transpose()?;
            let plan = Plan::of_study(study, options.sweep.block_size)?;
            Ok(Some(Blocks::new(plan, names(study), temporary)))
        }
        _ => Ok(None),
    }
}

/// The names of the scores.
fn names(study: &Study) -> Vec<String> {
    let scale = study.simulation.as_ref().and_then(|simulation| scores::scale(study, simulation));
    runs::names(&study.plant.states, scale.is_some())
}

/// What a sweep leaves.
pub(super) struct Outcome {
    pub(super) report: SweepReport,
    pub(super) warnings: Vec<String>,
    /// Blocks that were computed again.
    pub(super) notes: Vec<String>,
}

/// Computes what is missing of a sweep, and reduces it. After an interruption the rows that are complete are reduced.
pub(super) fn sweep_all(
    study: &Study,
    (simulation, sweep): (&Simulation, &Sweep),
    members: &[Member<'_>],
    blocks: &Blocks,
    (folder, options): (&Folder, &RunOptions<'_>),
) -> Result<Outcome, StudyError> {
    let designs = Designs::default();
    let work = Work::of(study, simulation, sweep, members, &designs)?;
    let numbers = 0..blocks.plan().blocks();
    let mut notes = Vec::new();
    if options.sweep.complete {
        let missing: Vec<u64> = numbers.filter(|block| !blocks.is_there(*block)).collect();
        if !missing.is_empty() {
            let folder = folder.root().map(Path::to_owned).unwrap_or_default();
            return Err(SweepError::Missing { folder, missing, blocks: blocks.plan().blocks() }.into());
        }
    } else {
        match work.compute(blocks, numbers, options) {
            Ok(computed) => notes = computed.recomputed(),
            Err(StudyError::Interrupted) => {}
            Err(error) => return Err(error),
        }
    }
    let mut table = match options.sweep.csv {
        RunsAsCsv::One => Some(folder.stream("sweep.csv")?),
        RunsAsCsv::Blocks | RunsAsCsv::None => None,
    };
    let head = runs::head(sweep.parameter.name(), blocks.names());
    if let Some(table) = &mut table {
        table.write(head.as_bytes())?;
    }
    let mut lines = |block: u64, lines: &str| match (&mut table, options.sweep.csv) {
        (Some(table), _) => table.write(lines.as_bytes()),
        (None, RunsAsCsv::Blocks) => blocks.put_csv(block, &format!("{head}{lines}")),
        (None, _) => Ok(()),
    };
    let reduced = reduce::reduce(&work.rows, blocks, &mut lines, options)?;
    if let Some(table) = table {
        folder.finish_stream(table)?;
    }
    let mut warnings = excursions(&reduced, sweep.parameter.name());
    if reduced.len() < work.rows.len() {
        let (open, all) = (work.rows.len() - reduced.len(), work.rows.len());
        warnings.push(format!("Not finished: {open} of {} of the sweep", counted(all, "row")));
    }
    let report = SweepReport {
        parameter: sweep.parameter.name().to_owned(),
        ensemble: sweep.ensemble,
        values: sweep.values.clone(),
        scoring: work.scoring.report(study),
        rows: reduced.into_iter().map(|reduced| reduced.row).collect(),
    };
    Ok(Outcome { report, warnings, notes })
}

/// One sentence for each observer whose runs leave the region of its design.
fn excursions(reduced: &[Reduced], parameter: &str) -> Vec<String> {
    let mut names: Vec<&str> = reduced.iter().map(|reduced| reduced.row.observer.as_str()).collect();
    names.dedup();
    let sentence = |name: &str| {
        let rows = || reduced.iter().filter(|reduced| reduced.row.observer == name);
        let (count, all) = (rows().map(|row| row.left).sum(), rows().map(|row| row.row.finished).sum());
        let (value, first) = rows().find_map(|row| Some((row.row.value, row.first.as_ref()?)))?;
        Some(first.in_sweep(name, count, all, parameter, value))
    };
    names.into_iter().filter_map(sentence).collect()
}

impl Computed {
    /// A sentence for each block that was computed again.
    pub fn recomputed(&self) -> Vec<String> {
        self.faults.iter().map(|(path, fault)| format!("{} {fault}: computed again", path.display())).collect()
    }
}
