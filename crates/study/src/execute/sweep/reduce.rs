//! The results of a sweep from its blocks, row by row in the order of the runs.
//!
//! Memory does not grow with the number of runs: the values of all scores of a row are kept for its percentiles if they
//! fit into [`VALUES`], which takes one pass over the blocks; otherwise values are counted in four passes, for as many
//! scores at a time as there is room for.

use rayon::prelude::*;

use super::super::excursion::FirstExit;
use super::super::options::RunOptions;
use super::block::Block;
use super::percentiles::{self, Percentiles};
use super::rows::Row;
use super::runs;
use super::statistics::{Summary, fill};
use super::store::Blocks;
use crate::error::StudyError;
use crate::error::sweep::SweepError;
use crate::results::SweepRow;
use crate::statistics::Moments;

/// Bytes for the percentiles of a row by default.
const VALUES: usize = 256 << 20;

/// A row, and how its runs left the region of the design.
pub(super) struct Reduced {
    pub(super) row: SweepRow,
    /// Runs that left.
    pub(super) left: u64,
    pub(super) first: Option<FirstExit>,
}

impl Reduced {
    /// Counts the runs of a block.
    fn count(&mut self, block: &Block) {
        self.row.finished += block.left.len() - block.header.ended.len();
        self.left += block.left.iter().filter(|left| **left).count() as u64;
        let ended = block.header.ended.first().map(|ended| &ended.why);
        if let (None, Some(why)) = (&self.row.failure, block.header.failure.as_ref().or(ended)) {
            self.row.failure = Some(why.clone());
        }
        if self.first.is_none() {
            self.first.clone_from(&block.header.left);
        }
    }
}

/// Receives the lines of the runs, block by block.
pub(super) type Lines<'a> = &'a mut dyn FnMut(u64, &str) -> Result<(), StudyError>;

/// The rows of which all blocks are there.
pub(super) fn reduce(
    rows: &[Row<'_>],
    blocks: &Blocks,
    lines: Lines<'_>,
    options: &RunOptions<'_>,
) -> Result<Vec<Reduced>, StudyError> {
    let mut reduced = Vec::new();
    for (number, row) in rows.iter().enumerate() {
        if blocks.plan().of_row(number).all(|block| blocks.is_there(block)) {
            reduced.push(reduced_row(number, row, blocks, lines, options)?);
        }
        options.tell("reduce", &row.requested.name, number + 1, rows.len());
    }
    Ok(reduced)
}

/// The block, which is an error if it is damaged or has vanished.
fn read(blocks: &Blocks, block: u64) -> Result<Block, StudyError> {
    let folder = || blocks.folder().map(|folder| folder.path().to_owned()).unwrap_or_default();
    match blocks.find(block)? {
        Ok(Some(block)) => Ok(block),
        Ok(None) => {
            let missing =
                SweepError::Missing { folder: folder(), missing: vec![block], blocks: blocks.plan().blocks() };
            Err(missing.into())
        }
        Err(fault) => Err(SweepError::Fault { folder: folder(), path: blocks.name(block), fault }.into()),
    }
}

/// How the percentiles of a row are formed.
struct Room {
    /// Whether the values of all scores are kept.
    keeps_values: bool,
    /// Scores at a time.
    together: usize,
}

impl Room {
    fn of(scores: usize, ensemble: usize, bytes: Option<usize>) -> Self {
        let bytes = bytes.unwrap_or(VALUES);
        let keeps_values = ensemble.saturating_mul(8).saturating_mul(scores) <= bytes;
        let together = if keeps_values { scores } else { (bytes / percentiles::BYTES).min(scores) };
        Self { keeps_values, together: together.max(1) }
    }
}

/// Bytes for the percentiles of a row.
pub(super) fn memory(scores: usize, ensemble: usize) -> usize {
    let room = Room::of(scores, ensemble, None);
    room.together * if room.keeps_values { 8 * ensemble } else { percentiles::BYTES }
}

fn reduced_row(
    number: usize,
    row: &Row<'_>,
    blocks: &Blocks,
    lines: Lines<'_>,
    options: &RunOptions<'_>,
) -> Result<Reduced, StudyError> {
    let numbers = || blocks.plan().of_row(number);
    let names = blocks.names();
    let mut reduced = Reduced {
        row: SweepRow { observer: row.requested.name.clone(), value: row.value, ..SweepRow::default() },
        left: 0,
        first: None,
    };
    let Room { keeps_values, together } =
        Room::of(names.len(), blocks.plan().ensemble as usize, options.sweep.percentile_memory);
    let mut scores = Vec::new();
    for begin in (0..names.len()).step_by(together) {
        let some = begin..(begin + together).min(names.len());
        let mut columns: Vec<_> = some.clone().map(|_| (Percentiles::new(keeps_values), Moments::default())).collect();
        for pass in 0..Percentiles::passes(keeps_values) {
            let is_first = begin == 0 && pass == 0;
            // Read and written as text in parallel, merged in their order.
            let ahead = 2 * rayon::current_num_threads() as u64;
            for first in numbers().step_by(ahead as usize) {
                let part = (first..numbers().end.min(first + ahead)).into_par_iter().map(|number| {
                    let block = read(blocks, number)?;
                    let text = if is_first { runs::lines(&block, names) } else { String::new() };
                    Ok((number, block, text))
                });
                for (number, block, text) in part.collect::<Result<Vec<_>, StudyError>>()? {
                    if is_first {
                        lines(number, &text)?;
                        reduced.count(&block);
                    }
                    let scores = &block.scores[some.clone()];
                    scores.par_iter().zip(&mut columns).for_each(|(values, (percentiles, moments))| {
                        let values = block.finished(values);
                        percentiles.add(&values);
                        if pass == 0 {
                            *moments = moments.merge(Moments::of(&values));
                        }
                    });
                }
            }
            columns.par_iter_mut().for_each(|(percentiles, _)| percentiles.end_pass());
        }
        let summary = |(percentiles, moments): (Percentiles, _)| Summary { moments, percentiles: percentiles.finish() };
        scores.par_extend(columns.into_par_iter().map(summary));
    }
    if reduced.row.finished > 0 {
        fill(&mut reduced.row, row.study, names, &scores);
    }
    Ok(reduced)
}
