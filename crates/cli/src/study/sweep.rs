//! The command `sweep`: all of a sweep, a shard of it, how far it is, and the results of its blocks.

use super::file::{self, folder_of, notes};
use super::{cost, interrupt, text_report};
use crate::answer::Answer;
use crate::arguments::{ReduceInput, StatusInput, SweepAction, SweepInput};
use crate::failure::Failure;
use crate::limit::limits;
use crate::progress::Bar;
use luenberger_proof::wording::{counted, significant};
use luenberger_study::execute::{
    BLOCKS, BlockSettings, RunsAsCsv, Shard, SharedSweep, SweepOptions, SweepStatus, duration, reduce_sweep,
    sweep_status,
};
use luenberger_study::{RunOptions, Step};
use serde_json::json;
use std::fmt::Write as _;
use std::path::Path;

pub(crate) fn sweep(input: &SweepInput) -> Result<Answer, Failure> {
    match (&input.action, &input.study, input.shard) {
        (Some(SweepAction::Status(input)), ..) => status(input),
        (Some(SweepAction::Reduce(input)), ..) => reduce(input),
        (Some(SweepAction::Script(input)), ..) => super::sweep_script::script(input),
        (None, Some(study), None) => {
            let sweep = SweepOptions {
                block_size: input.block_size,
                restart: input.restart,
                csv: input.csv.into(),
                ..SweepOptions::default()
            };
            super::step::execute(Step::Sweep, study, sweep)
        }
        (None, Some(_), Some(number)) => shard(input, number),
        (None, None, _) => Err(Failure::Usage("a study is expected: luenberger sweep STUDY")),
    }
}

/// Computes a part of the blocks.
fn shard(input: &SweepInput, shard: Shard) -> Result<Answer, Failure> {
    let Some(given) = &input.study else { return Err(Failure::Usage("--shard needs a study")) };
    let study = file::read(&given.study)?;
    let bar = Bar::new();
    let options = RunOptions {
        limits: limits(&given.limit),
        progress: &|progress| bar.tell(progress.stage, progress.item, progress.done, progress.total),
        cancel: interrupt::flag(),
        threads: given.threads,
        ..RunOptions::default()
    };
    let root = folder_of(given.output.as_deref(), &given.study);
    let settings = BlockSettings { size: input.block_size, restart: input.restart, force: given.force };
    cost::announce(&study, Step::Sweep, &options.limits, options.thread_count(), shard.of() as usize)?;
    let sweep = SharedSweep::open(study, &root, settings)?;
    let computed = sweep.compute(shard.blocks(sweep.plan()), &options);
    bar.finish();
    let computed = computed?;
    notes(&computed.recomputed());
    let status = sweep_status(&root, false)?;
    let folder = root.join(BLOCKS);
    let mut text = format!(
        "shard {shard}: {} computed ({}), {} present\n{}",
        counted(computed.computed as usize, "block"),
        counted(computed.runs as usize, "run"),
        computed.present,
        done(&status, &folder),
    );
    if status.missing.is_empty() {
        _ = writeln!(text, "next: luenberger sweep reduce {}", root.display());
    }
    let json = json!({
        "shard": shard.number(), "shards": shard.of(), "folder": folder, "computed": computed.computed,
        "runs": computed.runs, "present": computed.present, "repaired": computed.recomputed(),
        "missing": status.missing.len(),
    });
    Ok(Answer::new(text, &json)?)
}

/// How many blocks are there.
fn done(status: &SweepStatus, folder: &Path) -> String {
    let SweepStatus { done, blocks, done_runs, runs, .. } = status;
    let blocks = counted(*blocks as usize, "block");
    format!("{}: {done} of {blocks} in {} ({done_runs} of {runs} runs)\n", status.study, folder.display())
}

fn status(input: &StatusInput) -> Result<Answer, Failure> {
    const SHOWN: usize = 12;
    let status = sweep_status(&input.folder, input.verify)?;
    let mut text = done(&status, &input.folder.join(BLOCKS));
    let some = |blocks: &[u64]| {
        let shown: Vec<String> = blocks.iter().take(SHOWN).map(u64::to_string).collect();
        shown.join(", ") + if blocks.len() > SHOWN { ", .." } else { "" }
    };
    if !status.missing.is_empty() {
        _ = writeln!(text, "missing: {} ({})", status.missing.len(), some(&status.missing));
    }
    if !status.running.is_empty() {
        _ = writeln!(text, "being computed: {} ({})", status.running.len(), some(&status.running));
    }
    if let Some(rate) = status.rate {
        _ = writeln!(text, "rate: {} runs/s", significant(rate, 3));
    }
    if let (Some(seconds), false) = (status.remaining, status.missing.is_empty()) {
        _ = writeln!(text, "remaining: {}", duration(seconds));
    }
    for fault in &status.faults {
        _ = writeln!(text, "failed: {fault}");
    }
    if input.verify && status.faults.is_empty() {
        text.push_str("every block is sound\n");
    }
    Ok(Answer::new(text, &status)?.negative(!status.faults.is_empty()))
}

fn reduce(input: &ReduceInput) -> Result<Answer, Failure> {
    let bar = Bar::new();
    let options = RunOptions {
        force: input.force,
        limits: limits(&input.limit),
        sweep: SweepOptions { csv: input.csv.into(), ..SweepOptions::default() },
        progress: &|progress| bar.tell(progress.stage, progress.item, progress.done, progress.total),
        cancel: interrupt::flag(),
        threads: input.threads,
        ..RunOptions::default()
    };
    let reduced = reduce_sweep(&input.folder, &options);
    bar.finish();
    let (results, stopped) = reduced?;
    file::renamed(&input.folder, &results.renamed);
    text_report::answer(Step::Sweep, &results, Some(&input.folder), false, stopped)
}

impl From<crate::arguments::Csv> for RunsAsCsv {
    fn from(csv: crate::arguments::Csv) -> Self {
        match csv {
            crate::arguments::Csv::One => Self::One,
            crate::arguments::Csv::Blocks => Self::Blocks,
            crate::arguments::Csv::None => Self::None,
        }
    }
}
