//! Estimated cost of a study, reported before it starts and compared with the limits.

use crate::failure::Failure;
use crate::output::{self, Volume, volume};
use luenberger_proof::wording::counted;
use luenberger_study::execute::{about, bytes};
use luenberger_study::{Estimate, Limits, Step, Study, StudyError, estimate};
use std::io::IsTerminal;

/// Estimates of fewer seconds and bytes are reported on a terminal only.
const SECONDS: f64 = 10.0;
const BYTES: f64 = 1e9;

/// Reports the estimated cost of the step, or of one of so many shards of it, on standard error; an error if it takes
/// too long.
pub(super) fn announce(
    study: &Study,
    step: Step,
    limits: &Limits,
    threads: usize,
    shards: usize,
) -> Result<(), Failure> {
    let mut cost = estimate(study, step, threads);
    cost.runs = cost.runs.div_ceil(shards);
    cost.seconds /= shards as f64;
    cost.within(limits, threads).map_err(StudyError::TooExpensive)?;
    let is_wanted = std::io::stderr().is_terminal() || volume() == Volume::Verbose;
    if cost.seconds >= SECONDS || cost.memory.bytes >= BYTES || is_wanted {
        output::say(&sentence(&cost, threads));
    }
    Ok(())
}

fn sentence(cost: &Estimate, threads: usize) -> String {
    let Estimate { runs, seconds, mostly, memory } = cost;
    let share = if threads > 1 { format!(", less on {threads} threads") } else { String::new() };
    format!(
        "estimate: {} on one thread{share}, {} of memory ({}; most of the time for the {mostly})",
        about(*seconds),
        bytes(memory.bytes),
        counted(*runs, "run")
    )
}
