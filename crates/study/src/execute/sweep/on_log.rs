//! A sweep on a log: each observer at each value, one run of the log for each, judged by its predictions of the part
//! that is held out. No noise is drawn, so that there is no ensemble.

use std::sync::atomic::{AtomicUsize, Ordering};

use luenberger_wording::shortest;
use rayon::prelude::*;

use super::super::options::RunOptions;
use super::super::prediction::{self, Predictions};
use super::rows::{chosen, varied};
use crate::design::attempt;
use crate::error::StudyError;
use crate::results::{LogSweepReport, LogSweepRow};
use crate::study::{Log, ObserverSpec, Study, Sweep};
use crate::trajectory::Member;

/// An observer at a value.
struct Row<'a> {
    study: &'a Study,
    requested: ObserverSpec,
    value: f64,
}

/// Its predictions, or why it has none.
type Outcome = Result<Predictions, String>;

/// The sweep, with a sentence for what was left undone. None of it if nothing was finished.
pub(in crate::execute) fn sweep(
    study: &Study,
    (log, sweep): (&Log, &Sweep),
    options: &RunOptions<'_>,
) -> Result<(LogSweepReport, Option<String>), StudyError> {
    let first = prediction::held_out(log, prediction::share(study, sweep.held_out))?;
    let mut rows = Vec::new();
    for own in chosen(study, sweep) {
        for (k, &value) in sweep.values.iter().enumerate() {
            // A number of the study is varied in the study itself.
            let study = sweep.variants.get(k).unwrap_or(study);
            let Some(requested) = study.observer(&own.name) else { continue };
            let Some(requested) = varied(requested, (None, study.plant.dt), &sweep.parameter, value) else { continue };
            rows.push(Row { study, requested, value });
        }
    }
    let done = AtomicUsize::new(0);
    let one = |row: &Row<'_>| -> Result<Option<Outcome>, StudyError> {
        if options.interrupted() {
            return Ok(None);
        }
        let outcome = match attempt(row.study, &row.requested, options.cancel, options.until) {
            Err(none) if none.is_interrupted() => return Ok(None),
            Err(none) => Err(none.hypothesis),
            Ok(designed) => {
                let member = Member { requested: &row.requested, designed: &designed };
                match Predictions::of((row.study, log), &member, first, options.until) {
                    Err(StudyError::Interrupted) => return Ok(None),
                    found => found?,
                }
            }
        };
        let count = done.fetch_add(1, Ordering::Relaxed) + 1;
        options.tell("sweep", &row.requested.name, count, rows.len());
        Ok(Some(outcome))
    };
    let outcomes = rows.par_iter().map(one).collect::<Result<Vec<_>, StudyError>>()?;
    let found = || rows.iter().zip(&outcomes).filter_map(|(row, outcome)| Some((row, outcome.as_ref()?)));
    let all: Vec<(&str, &Predictions)> =
        found().filter_map(|(row, found)| Some((row.requested.name.as_str(), found.as_ref().ok()?))).collect();
    let common = prediction::common(log, first, &all)?;
    let scale = study.simulation.as_ref().and_then(|simulation| simulation.scale.as_deref());
    let report = |(row, found): (&Row<'_>, &Outcome)| LogSweepRow {
        observer: row.requested.name.clone(),
        value: row.value,
        on_log: found.as_ref().ok().map(|one| prediction::judged((row.study, log), one, (first, &common), scale)),
        rows_outside: found.as_ref().map_or(0, |one| one.outside),
        failure: found.as_ref().err().cloned(),
    };
    let report = LogSweepReport {
        parameter: sweep.parameter.name().to_owned(),
        values: sweep.values.clone(),
        held_out: prediction::rows_in_words(log, first, &common),
        rows: found().map(report).collect(),
    };
    let open = outcomes.iter().filter(|outcome| outcome.is_none()).count();
    let open = (open > 0).then(|| format!("Not finished: {open} of {} rows of the sweep", rows.len()));
    Ok((report, open))
}

/// The scores as CSV, a line for each observer and value.
pub(in crate::execute) fn table(study: &Study, report: &LogSweepReport) -> String {
    let (outputs, states) = (&study.plant.outputs, &study.plant.states);
    let head = prediction::csv_head(outputs, states);
    let lines = report.rows.iter().map(|row| {
        let cells = prediction::csv_cells(row.on_log.as_ref(), outputs, states);
        let why = row.failure.as_deref().map(prediction::quoted).unwrap_or_default();
        format!("{},{},{cells},{why}\n", prediction::quoted(&row.observer), shortest(row.value))
    });
    format!("observer,{},{head},failure\n", report.parameter) + &lines.collect::<String>()
}
