//! `verify`: whether a certificate holds.

use luenberger_proof::Verdict;
use luenberger_proof::certificate::{Number, Rejection, verify as check};
use serde_json::{Value, json};

use crate::error::StudioError;
use crate::message::Message;

/// Verifies the one file of the request.
pub(crate) fn verify(request: Message) -> Result<Message, StudioError> {
    let (name, bytes) = one(request, "the bytes of a certificate")?;
    let json = match check(&bytes) {
        Ok(proved) => {
            let margin = |verdict: &Verdict<_>| match verdict {
                Verdict::Proved { margin } => Number::from_f64(*margin).map(|margin| margin.to_string()),
                _ => None,
            };
            let facts: Vec<Value> = proved
                .facts
                .iter()
                .map(|fact| json!({ "inequality": fact.inequality, "margin": margin(&fact.verdict) }))
                .collect();
            json!({
                "verdict": "proved",
                "rendered": format!("{name}: Proved\n  {}\n", proved.to_string().replace('\n', "\n  ")),
                "title": proved.title,
                "statement": proved.statement,
                "facts": facts,
            })
        }
        Err(Rejection::File(why)) if why.is_unreadable() => {
            let rendered = format!("{name}: Unreadable\n  {why}\n");
            json!({ "verdict": "unreadable", "rendered": rendered, "why": why.to_string() })
        }
        Err(why) => {
            let rendered = format!("{name}: Rejected\n  {why}\n");
            json!({ "verdict": "rejected", "rendered": rendered, "why": why.to_string() })
        }
    };
    Ok(Message::new(json))
}

/// The only file of a request.
pub(crate) fn one(request: Message, expected: &str) -> Result<(String, Vec<u8>), StudioError> {
    let mut files = request.files;
    match (files.pop(), files.is_empty()) {
        (Some(file), true) => Ok(file),
        _ => Err(StudioError::Key { key: "files", expected: format!("one file, {expected}") }),
    }
}
