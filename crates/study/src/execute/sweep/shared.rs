//! A sweep that several processes compute, each some of its blocks.

use luenberger_wording::setters;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use super::super::folder::Folder;
use super::super::options::{RunOptions, Step};
use super::super::{Outcome, check, designs, execute_in_part, folder, members, within};
use super::compute::{Designs, Work};
use super::folder::BlockFolder;
use super::plan::Plan;
use super::store::Blocks;
use super::{BLOCKS, Computed, names};
use crate::error::StudyError;
use crate::error::sweep::SweepError;
use crate::results::Results;
use crate::study::Study;
use crate::trajectory::Member;

/// How the blocks of a folder are made.
#[derive(Debug, Clone, Copy, Default)]
pub struct BlockSettings {
    /// Runs of a block (default: those of the folder, or a sixteenth of the ensemble, from 32 to 1000).
    pub size: Option<u64>,
    /// Whether blocks in the folder, of this or another study, are deleted.
    pub restart: bool,
    /// Whether to use a results folder that has files and no manifest. Its files are kept.
    pub force: bool,
}

impl BlockSettings {
    setters! { size: u64, restart: bool, force: bool }
}

/// A sweep of a study with its folder.
///
/// Several processes, on several machines, may have the same folder, and compute the same or other blocks.
///
/// ```
/// use luenberger_study::execute::{BlockSettings, SharedSweep, reduce_sweep, sweep_status};
/// use luenberger_study::{Format, RunOptions, Study, template};
/// let text = template::text("double-integrator").ok_or("a template")?;
/// let study = Study::from_text("study.toml", text, Format::Toml, ".".as_ref())?;
/// # let folder = std::env::temp_dir().join(format!("luenberger-shared-{}", std::process::id()));
/// let sweep = SharedSweep::open(study, &folder, BlockSettings::default())?;
/// assert_eq!((sweep.plan().blocks(), sweep.plan().runs()), (10, 10));
/// sweep.compute([0, 3], &RunOptions::default())?;
/// assert_eq!(sweep_status(&folder, false)?.done, 2);
/// sweep.compute(0..10, &RunOptions::default())?;
/// let (results, _) = reduce_sweep(&folder, &RunOptions::default())?;
/// assert_eq!(results.sweep.ok_or("a sweep")?.rows.len(), 10);
/// # std::fs::remove_dir_all(&folder)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct SharedSweep {
    study: Study,
    blocks: Blocks,
    /// The designs of the study.
    outcomes: OnceLock<Vec<Option<Outcome>>>,
    /// The designs of rows.
    designs: Designs,
}

/// The blocks in a folder.
pub(super) fn open(study: &Study, path: PathBuf, settings: BlockSettings) -> Result<Blocks, StudyError> {
    let known = if settings.restart { None } else { BlockFolder::plan(&path).ok() };
    let size = settings.size.or(known.map(|plan| plan.block_size));
    let plan = Plan::of_study(study, size)?;
    let folder = BlockFolder::open(path, &plan, study, settings.restart)?;
    Ok(Blocks::new(plan, names(study), Some(folder)))
}

impl SharedSweep {
    /// The sweep of a study in a results folder, which is created if it is missing.
    ///
    /// # Errors
    /// [`StudyError::Missing`] for a study without a sweep, [`StudyError::Sweep`] for a folder with the blocks of
    /// another study, and errors of files.
    pub fn open(study: Study, folder: &Path, settings: BlockSettings) -> Result<Self, StudyError> {
        check(&study, Step::Sweep)?;
        folder::admit(folder, settings.force)?;
        let blocks = open(&study, folder.join(BLOCKS), settings)?;
        Ok(Self { study, blocks, outcomes: OnceLock::new(), designs: Designs::default() })
    }

    /// Its runs and blocks.
    pub fn plan(&self) -> &Plan {
        self.blocks.plan()
    }

    /// Computes those of these blocks that are not there; another process that computes one of them is waited for.
    ///
    /// Progress, interruption, limits and threads are those of the options. Observers are designed once.
    ///
    /// # Errors
    /// [`SweepError::NoBlock`] for a number that is too large, [`StudyError::Interrupted`] and
    /// [`StudyError::TimeLimit`], and errors of files. Blocks that were finished before an error stay.
    pub fn compute(
        &self,
        numbers: impl IntoIterator<Item = u64, IntoIter: Send> + Send,
        options: &RunOptions<'_>,
    ) -> Result<Computed, StudyError> {
        let (Some(sweep), Some(simulation)) = (&self.study.sweep, &self.study.simulation) else {
            return Err(StudyError::Missing { step: Step::Sweep.name(), needs: "a [sweep]" });
        };
        let numbers: Vec<u64> = numbers.into_iter().collect();
        let blocks = self.plan().blocks();
        if let Some(block) = numbers.iter().find(|number| **number >= blocks) {
            return Err(SweepError::NoBlock { block: *block, blocks }.into());
        }
        within(options, |options| {
            let outcomes = if let Some(outcomes) = self.outcomes.get() {
                outcomes
            } else {
                let outcomes = designs(&self.study, options, &Folder::open(None, false)?, false)?;
                options.check()?;
                self.outcomes.get_or_init(|| outcomes)
            };
            let members: Vec<Member<'_>> = members(&self.study, outcomes);
            let work = Work::of(&self.study, simulation, sweep, &members, &self.designs)?;
            work.compute(&self.blocks, numbers.into_iter(), options)
        })
    }
}

/// Reduces the blocks in a results folder to the results of the sweep, and writes these beside them. Missing and
/// damaged blocks are errors. The output folder of the options is not used.
///
/// # Errors
/// [`StudyError::Sweep`] for a folder without a sweep, of another version, or with blocks that are missing or damaged;
/// otherwise as [`execute_in_part`].
pub fn reduce_sweep(folder: &Path, options: &RunOptions<'_>) -> Result<(Results, Option<StudyError>), StudyError> {
    let path = folder.join(BLOCKS);
    let plan = BlockFolder::plan(&path)?;
    plan.check_version(&path)?;
    let study = BlockFolder::study(&path, &plan)?;
    let mut sweep = options.sweep.clone();
    (sweep.complete, sweep.restart, sweep.block_size) = (true, false, None);
    execute_in_part(&study, Step::Sweep, &RunOptions { output: Some(folder.into()), sweep, ..*options })
}
