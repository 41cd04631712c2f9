//! The results of a sweep from its blocks, row by row in the order of the trajectories.
//!
//! Memory does not grow with the number of trajectories, but for the values of which exact percentiles are formed: of a
//! row with E trajectories those of as many scores at a time as [`VALUES`] has room for, at least of one, 8 E bytes.
//! Blocks are read again for the other scores.

use rayon::prelude::*;

use super::super::excursion::Left;
use super::super::options::RunOptions;
use super::block::Block;
use super::error::SweepError;
use super::rows::Row;
use super::runs;
use super::statistics::{Moments, Summary, fill};
use super::store::Blocks;
use crate::error::StudyError;
use crate::results::SweepRow;

/// Bytes of values that are in memory for percentiles, if one score does not need more.
const VALUES: usize = 256 << 20;

/// A row, and how its runs left the region of the design.
pub(super) struct Reduced {
    pub(super) row: SweepRow,
    /// Runs that left.
    pub(super) left: u64,
    pub(super) first: Option<Left>,
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
            reduced.push(one(number, row, blocks, lines)?);
        }
        options.tell("reduce", &row.wish.name, number + 1, rows.len());
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

/// Scores of which all values are in memory at a time.
pub(super) fn together(scores: usize, ensemble: usize) -> usize {
    (VALUES / ensemble.saturating_mul(8)).clamp(1, scores.max(1))
}

fn one(number: usize, row: &Row<'_>, blocks: &Blocks, lines: Lines<'_>) -> Result<Reduced, StudyError> {
    let numbers = || blocks.plan().of_row(number);
    let names = blocks.names();
    let mut reduced = Reduced {
        row: SweepRow { observer: row.wish.name.clone(), value: row.value, ..SweepRow::default() },
        left: 0,
        first: None,
    };
    let together = together(names.len(), blocks.plan().ensemble as usize);
    let mut scores = Vec::new();
    for begin in (0..names.len()).step_by(together) {
        let some = begin..(begin + together).min(names.len());
        let mut values = vec![Vec::new(); some.len()];
        let mut moments = vec![Moments::default(); some.len()];
        // Read and written as text in parallel, merged in their order.
        let ahead = 2 * rayon::current_num_threads() as u64;
        for first in numbers().step_by(ahead as usize) {
            let part = (first..numbers().end.min(first + ahead)).into_par_iter().map(|number| {
                let block = read(blocks, number)?;
                let text = if begin == 0 { runs::lines(&block, names) } else { String::new() };
                Ok((number, block, text))
            });
            for (number, block, text) in part.collect::<Result<Vec<_>, StudyError>>()? {
                if begin == 0 {
                    lines(number, &text)?;
                    reduced.count(&block);
                }
                for ((column, values), moments) in block.scores[some.clone()].iter().zip(&mut values).zip(&mut moments)
                {
                    let finished = column.iter().enumerate().filter(|(index, _)| block.ended(*index).is_none());
                    let start = values.len();
                    values.extend(finished.map(|(_, x)| *x));
                    *moments = moments.merge(Moments::of(&values[start..]));
                }
            }
        }
        if reduced.row.finished > 0 {
            let all = values.par_iter_mut().zip(moments);
            scores.par_extend(all.map(|(values, moments)| Summary::of(moments, values)));
        }
    }
    if reduced.row.finished > 0 {
        fill(&mut reduced.row, row.study, names, &scores);
    }
    Ok(reduced)
}
