//! `run`: a step of a study, by default all.

use luenberger_study::{Limits, MemoryFolder, Progress, RunOptions, Step, execute_in_part};
use serde_json::{Value, json};

use crate::Host;
use crate::error::StudioError;
use crate::message::Message;
use crate::study::{self, positive, text, truth};

/// The most memory of a run, half of what WebAssembly has: the answer holds the files once more.
pub(crate) const MEMORY: f64 = 2.0 * 1024.0 * 1024.0 * 1024.0;

const STEPS: [Step; 7] =
    [Step::Run, Step::Observe, Step::Design, Step::Certify, Step::Simulate, Step::Compare, Step::Sweep];

/// The results, in part if the limit `limit_seconds` ends the run, and the files of the results folder; those below
/// `figures/` unless `figures` is false.
pub(crate) fn run(request: Message, host: &dyn Host) -> Result<Message, StudioError> {
    let wanted = text(&request, "step")?.unwrap_or("run");
    let unknown = || {
        let names: Vec<&str> = STEPS.iter().map(|step| step.name()).collect();
        StudioError::Key { key: "step", expected: names.join(", ") }
    };
    let step = STEPS.into_iter().find(|step| step.name() == wanted).ok_or_else(unknown)?;
    let figures = truth(&request, "figures", true)?;
    let limits = limits(&request)?;
    let study = study::of(request)?;
    let folder = MemoryFolder::default();
    let progress = told(host);
    let options = RunOptions::default().output(folder.clone().into()).figures(figures).limits(limits);
    let (results, stopped) = execute_in_part(&study, step, &options.progress(&progress))?;
    // Gains and proofs are in the text of the steps that have them, as in the terminal.
    let designs = matches!(step, Step::Design | Step::Certify | Step::Run);
    let failures: Vec<Value> = results
        .failures_of_observers()
        .map(|(observer, message)| json!({ "observer": observer, "message": message }))
        .collect();
    let json = json!({
        "results": serde_json::to_value(&results)?,
        "summary": results.summary(designs, false),
        "failures": failures,
        "warnings": results.warnings,
        "stopped": stopped.map(|error| error.to_string()),
    });
    Ok(Message::new(json).with(folder.take()))
}

/// The limits of a request on time and memory.
pub(crate) fn limits(request: &Message) -> Result<Limits, StudioError> {
    let limits = Limits::default().memory(MEMORY);
    Ok(positive(request, "limit_seconds")?.map_or(limits, |seconds| limits.seconds(seconds)))
}

/// What tells the host of progress.
pub(crate) fn told(host: &dyn Host) -> impl Fn(Progress<'_>) + Sync + '_ {
    |Progress { stage, item, done, total }| {
        host.progress(&json!({ "stage": stage, "what": item, "done": done, "of": total }).to_string());
    }
}
