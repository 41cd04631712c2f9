//! `advise`: which observer to use.

use luenberger_study::advise::{AdviseOptions, BUDGET, advise as compared};
use luenberger_study::execute::duration;
use luenberger_study::{MemoryFolder, RunOptions};
use serde_json::json;

use crate::Host;
use crate::error::StudioError;
use crate::message::Message;
use crate::run::told;
use crate::study::{self, positive};

/// The ranking of all kinds that apply, within `limit_seconds`.
pub(crate) fn advise(request: Message, host: &dyn Host) -> Result<Message, StudioError> {
    let budget = positive(&request, "limit_seconds")?.unwrap_or(BUDGET);
    let study = study::of(request)?;
    let folder = MemoryFolder::default();
    let progress = told(host);
    let run = RunOptions::default().output(folder.clone().into()).progress(&progress);
    let (advice, stopped) = compared(&study, &AdviseOptions::default().run(run).budget(budget))?;
    let json = json!({
        "text": advice.text(&duration(budget)),
        "results": serde_json::to_value(&advice)?,
        "study": advice.study,
        "stopped": stopped.map(|error| error.to_string()),
    });
    Ok(Message::new(json).with(folder.take()))
}
