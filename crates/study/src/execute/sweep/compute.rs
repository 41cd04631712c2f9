//! Computes blocks: trajectories in parallel, each depending on the study, the value and its number in the ensemble
//! only.

use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use luenberger_sim::SimError;
use rayon::prelude::*;

use super::super::excursion::{self, FirstExit};
use super::super::options::RunOptions;
use super::super::scores::Scoring;
use super::super::stopped::why;
use super::super::threads;
use super::block::{Block, Ended, Header};
use super::folder::Claim;
use super::plan::{FORMAT, Part};
use super::rows::{Row, RowDesign, initial, rows};
use super::store::{Blocks, Claimed};
use super::{Computed, runs};
use crate::design::Designed;
use crate::error::StudyError;
use crate::study::{ObserverSpec, Simulation, Study, Sweep, Swept};
use crate::trajectory::{self, Member, Variation};

/// Runs that are started together, for each thread: enough that the threads end at about the same time.
const PER_THREAD: usize = 16;

/// How long to wait for blocks that another process computes before looking again.
const PAUSE: Duration = Duration::from_millis(200);

/// The designs of rows, which several blocks need.
pub(super) type Designs = Mutex<BTreeMap<usize, Arc<RowDesign>>>;

/// What all blocks of a sweep have in common.
pub(super) struct Work<'a> {
    pub(super) sweep: &'a Sweep,
    pub(super) rows: Vec<Row<'a>>,
    pub(super) scoring: Scoring,
    members: &'a [Member<'a>],
    designs: &'a Designs,
}

impl<'a> Work<'a> {
    pub(super) fn of(
        study: &'a Study,
        simulation: &'a Simulation,
        sweep: &'a Sweep,
        members: &'a [Member<'a>],
        designs: &'a Designs,
    ) -> Result<Self, StudyError> {
        let rows = rows(study, simulation, sweep);
        let compared = rows.iter().map(|row| row.requested.name.as_str());
        let compared: Vec<&Member<'_>> =
            members.iter().filter(|m| compared.clone().any(|n| n == m.requested.name)).collect();
        let scoring = Scoring::of(study, simulation, compared.into_iter(), members)?;
        Ok(Self { sweep, rows, scoring, members, designs })
    }

    /// Computes those of the blocks that are not there. Blocks that another process computes are waited for.
    pub(super) fn compute(
        &self,
        blocks: &Blocks,
        numbers: impl Iterator<Item = u64>,
        options: &RunOptions<'_>,
    ) -> Result<Computed, StudyError> {
        let mut computed = Computed::default();
        let mut missing = VecDeque::new();
        for number in numbers {
            options.check()?;
            match blocks.find(number)? {
                Ok(Some(_)) => {
                    blocks.folder().map_or(Ok(()), |folder| folder.tidy(number))?;
                    computed.present += 1;
                }
                Ok(None) => missing.push_back(number),
                Err(fault) => {
                    computed.faults.push((blocks.name(number), fault));
                    missing.push_back(number);
                }
            }
        }
        let total = missing.iter().map(|number| blocks.plan().count(*number) as usize).sum();
        let progress = Progress { options, done: AtomicUsize::new(0), total };
        let mut held = VecDeque::new();
        while !missing.is_empty() || !held.is_empty() {
            options.check()?;
            if missing.is_empty() {
                threads::pause(PAUSE);
                std::mem::swap(&mut missing, &mut held);
            }
            let mut claims = Vec::new();
            for number in self.wave(blocks, &mut missing, options) {
                match blocks.claim(number)? {
                    Claimed::Mine(claim) => claims.push((number, claim)),
                    Claimed::Held => held.push_back(number),
                    Claimed::Present => {
                        computed.present += 1;
                        progress.report(
                            &self.rows[blocks.plan().part(number).row].requested.name,
                            blocks.plan().count(number),
                        );
                    }
                }
            }
            let designs = self.designs(claims.iter().map(|(number, _)| blocks.plan().part(*number).row), options)?;
            let one = |(number, claim): &(u64, Option<Claim>)| {
                let part = blocks.plan().part(*number);
                let block = self.block(blocks, *number, &part, &designs[&part.row], &progress)?;
                blocks.put(claim.as_ref(), &block)
            };
            claims.par_iter().map(one).collect::<Result<(), StudyError>>()?;
            computed.computed += claims.len() as u64;
            computed.runs += claims.iter().map(|(number, _)| blocks.plan().count(*number)).sum::<u64>();
        }
        Ok(computed)
    }

    /// The next blocks that are computed together: enough trajectories, or designs, for all threads.
    fn wave(&self, blocks: &Blocks, missing: &mut VecDeque<u64>, options: &RunOptions<'_>) -> Vec<u64> {
        let (mut wave, mut count) = (Vec::new(), 0);
        let least = if self.sweep.parameter.redesigns() { options.thread_count() } else { 1 };
        while (count < PER_THREAD * options.thread_count() || wave.len() < least)
            && let Some(number) = missing.pop_front()
        {
            wave.push(number);
            count += blocks.plan().count(number) as usize;
        }
        wave
    }

    /// The designs of some rows. Those of other rows are not kept.
    fn designs(
        &self,
        rows: impl Iterator<Item = usize>,
        options: &RunOptions<'_>,
    ) -> Result<BTreeMap<usize, Arc<RowDesign>>, StudyError> {
        let rows: std::collections::BTreeSet<usize> = rows.collect();
        let known = self.designs.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let one = |row: usize| match known.get(&row) {
            Some(design) => Ok((row, Arc::clone(design))),
            None => Ok((row, Arc::new(RowDesign::of(&self.rows[row], &self.sweep.parameter, options)?))),
        };
        let designs: BTreeMap<_, _> = rows.into_par_iter().map(one).collect::<Result<_, StudyError>>()?;
        self.designs.lock().unwrap_or_else(PoisonError::into_inner).clone_from(&designs);
        Ok(designs)
    }

    fn block(
        &self,
        blocks: &Blocks,
        number: u64,
        part: &Part,
        designs: &RowDesign,
        progress: &Progress<'_>,
    ) -> Result<Block, StudyError> {
        let row = &self.rows[part.row];
        let mut header = Header {
            format: FORMAT,
            plan: blocks.digest().to_owned(),
            block: number,
            first: part.runs.start,
            count: part.runs.end - part.runs.start,
            observer: row.requested.name.clone(),
            parameter: self.sweep.parameter.name().to_owned(),
            value: row.value,
            failure: None,
            ended: Vec::new(),
            left: None,
        };
        let mut scores = vec![Vec::new(); blocks.names().len()];
        let designed = match designs.own(row, self.members) {
            Ok(designed) => designed,
            Err(why) => {
                progress.report(&row.requested.name, header.count);
                header.failure = Some(why.to_owned());
                header.count = 0;
                return Ok(Block { header, left: Vec::new(), scores });
            }
        };
        let others = designs.others(self.members);
        let ran = part.runs.clone().into_par_iter().map(|run| self.run(row, designed, &others, run, progress));
        let mut left = Vec::new();
        for (index, run) in ran.collect::<Result<Vec<_>, StudyError>>()?.into_iter().enumerate() {
            match run {
                Ok(run) => {
                    for (column, score) in scores.iter_mut().zip(run.scores) {
                        column.push(score);
                    }
                    left.push(run.left.is_some());
                    header.left = header.left.or(run.left);
                }
                Err(why) => {
                    for column in &mut scores {
                        column.push(f64::NAN);
                    }
                    left.push(false);
                    header.ended.push(Ended { index, why });
                }
            }
        }
        Ok(Block { header, left, scores })
    }

    /// One run: its scores and how it left the region, or why it ended early.
    fn run(
        &self,
        row: &Row<'_>,
        designed: &Designed,
        others: &[Member<'_>],
        number: u64,
        progress: &Progress<'_>,
    ) -> Result<Result<Ran, String>, StudyError> {
        let options = progress.options;
        options.check()?;
        let Row { study, simulation, requested, value } = row;
        let initial = initial(requested, simulation, self.scoring.scale(), self.sweep.seed, number);
        let requested = ObserverSpec { initial, ..requested.clone() };
        let member = Member { requested: &requested, designed };
        let factor = if self.sweep.parameter == Swept::Noise { *value } else { 1.0 };
        let variation = Variation { noise: factor, member: number };
        let outcome = trajectory::run(study, simulation, others, Some(&member), variation, options.until).and_then(
            |trajectory| {
                let merits = self.scoring.merits(study, &trajectory, &requested)?;
                let left = excursion::of_simulation(study, &requested, &trajectory)?;
                Ok(Ran { scores: runs::scores(&merits), left: left.map(|left| left.first_exit()) })
            },
        );
        progress.report(&requested.name, 1);
        match outcome {
            Ok(finished) => Ok(Ok(finished)),
            Err(SimError::TimeLimit { .. }) => Err(StudyError::Interrupted),
            Err(error) if error.ends_run() => Ok(Err(why(study, &error))),
            Err(error) => Err(error.into()),
        }
    }
}

/// A run that finished.
struct Ran {
    scores: Vec<f64>,
    left: Option<FirstExit>,
}

/// Runs that are done, of all.
struct Progress<'a> {
    options: &'a RunOptions<'a>,
    done: AtomicUsize,
    total: usize,
}

impl Progress<'_> {
    fn report(&self, name: &str, runs: u64) {
        let count = self.done.fetch_add(runs as usize, Ordering::Relaxed) + runs as usize;
        self.options.tell("sweep", name, count, self.total);
    }
}
