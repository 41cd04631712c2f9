//! `tune`: what a filter assumes, fitted to its log.

use std::time::Duration;

use luenberger_clock::Instant;
use luenberger_study::tune::{TuneOptions, tune as fitted};
use luenberger_study::{MemoryFolder, RunOptions};
use serde_json::json;

use crate::Host;
use crate::error::StudioError;
use crate::message::Message;
use crate::run::told;
use crate::study::{self, positive};

/// The fit, and the tuned study as a file.
pub(crate) fn tune(request: Message, host: &dyn Host) -> Result<Message, StudioError> {
    let limit = positive(&request, "limit_seconds")?;
    let study = study::of(request)?;
    let folder = MemoryFolder::default();
    let progress = told(host);
    let mut run = RunOptions::default().output(folder.clone().into()).progress(&progress);
    let end = limit.and_then(|limit| Duration::try_from_secs_f64(limit).ok());
    run.until = end.and_then(|limit| Instant::now().checked_add(limit));
    let report = fitted(&study, &TuneOptions { run, write: false })?;
    let json = json!({
        "text": report.text(),
        "results": serde_json::to_value(&report)?,
        "file": report.file,
        "study": report.study,
    });
    Ok(Message::new(json).with(folder.take()))
}
