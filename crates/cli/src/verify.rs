//! `luenberger verify`: verifies certificate files as `luenberger-verify` does.

use crate::answer::Answer;
use crate::failure::Failure;
use crate::input::Source;
use luenberger_proof::Verdict;
use luenberger_proof::certificate::{LARGEST_FILE, Number, Rejection, verify as check};
use serde::Serialize;
use std::fmt::Write;

/// Result for one file.
#[derive(Serialize)]
struct Checked {
    file: String,
    outcome: Outcome,
    #[serde(skip_serializing_if = "Option::is_none")]
    title: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    statement: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    facts: Option<Vec<Fact>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    why: Option<String>,
}

#[derive(Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Outcome {
    Proved,
    Rejected,
}

#[derive(Serialize)]
struct Fact {
    inequality: String,
    margin: Option<String>,
}

#[derive(Serialize)]
struct All {
    files: Vec<Checked>,
}

/// Every file verified: success. A file rejected: negative answer. A file that is not a certificate: invalid input.
pub(crate) fn verify(sources: &[Source]) -> Result<Answer, Failure> {
    let (mut text, mut files) = (String::new(), Vec::new());
    for source in sources {
        let (report, checked) = one(source)?;
        text.push_str(&report);
        files.push(checked);
    }
    let is_negative = files.iter().any(|checked| checked.outcome != Outcome::Proved);
    Ok(Answer::new(text, &All { files })?.negative(is_negative))
}

fn one(source: &Source) -> Result<(String, Checked), Failure> {
    // One byte more than the limit, so that the checker detects a longer file.
    let bytes = source.bytes(LARGEST_FILE as u64 + 1)?;
    let file = source.to_string();
    match check(&bytes) {
        Ok(proved) => {
            let mut text = format!("{file}: Proved\n  {}\n", proved.statement);
            for fact in &proved.facts {
                _ = writeln!(text, "  {fact}");
            }
            let fact = |fact: luenberger_proof::certificate::Fact| Fact {
                margin: match fact.verdict {
                    Verdict::Proved { margin } => Number::from_f64(margin).map(|margin| margin.to_string()),
                    _ => None,
                },
                inequality: fact.inequality,
            };
            let checked = Checked {
                file,
                outcome: Outcome::Proved,
                title: Some(proved.title),
                statement: Some(proved.statement),
                facts: Some(proved.facts.into_iter().map(fact).collect()),
                why: None,
            };
            Ok((text, checked))
        }
        Err(Rejection::File(error)) if error.is_unreadable() => {
            Err(Failure::Certificate { origin: file, error: Box::new(Rejection::File(error)) })
        }
        Err(why) => {
            let text = format!("{file}: Rejected\n  {why}\n");
            let why = Some(why.to_string());
            let checked = Checked { file, outcome: Outcome::Rejected, title: None, statement: None, facts: None, why };
            Ok((text, checked))
        }
    }
}
