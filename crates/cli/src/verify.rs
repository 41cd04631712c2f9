//! `luenberger verify`: verifies certificate files as `luenberger-verify` does, or writes one for Coq.

use crate::answer::Answer;
use crate::arguments::VerifyInput;
use crate::failure::Failure;
use crate::input::Source;
use crate::output;
use luenberger_proof::Verdict;
use luenberger_proof::certificate::{CertificateFile, LARGEST_FILE, Number, Rejection, verify as check};
use luenberger_proof::coq::theorems;
use luenberger_proof::wording::counted;
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;

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

/// The file for Coq.
#[derive(Serialize)]
struct Written {
    file: String,
    outcome: Outcome,
    /// The file written, or the text itself if the output is standard output.
    coq: String,
    theorems: Vec<String>,
}

/// Every file verified: success. A file rejected: negative answer. A file that is not a certificate: invalid input.
pub(crate) fn verify(input: &VerifyInput) -> Result<Answer, Failure> {
    if let Some(output) = &input.output {
        let [source] = input.files.as_slice() else {
            return Err(Failure::Usage("--coq writes the file of one certificate: name one"));
        };
        return for_coq(source, output, input.force);
    }
    let (mut text, mut files) = (String::new(), Vec::new());
    for source in &input.files {
        let (report, checked) = one(source)?;
        text.push_str(&report);
        files.push(checked);
    }
    let is_negative = files.iter().any(|checked| checked.outcome != Outcome::Proved);
    Ok(Answer::new(text, &All { files })?.negative(is_negative))
}

/// One certificate as a file for Coq. One that is false is a negative answer, with theorems that say so.
fn for_coq(source: &Source, path: &Path, force: bool) -> Result<Answer, Failure> {
    let (bytes, file) = (source.bytes(LARGEST_FILE as u64 + 1)?, source.to_string());
    let unreadable = |error| Failure::Certificate { origin: file.clone(), error: Box::new(Rejection::File(error)) };
    let written = theorems(&CertificateFile::read(&bytes).map_err(unreadable)?);
    let written = written.map_err(|error| Failure::Coq { origin: file.clone(), error: Box::new(error) })?;
    let is_standard = path.as_os_str() == "-";
    if !is_standard {
        output::file(path, &written.text, force).map_err(|error| Failure::written(path, error))?;
    }
    let outcome = if written.is_refuted { Outcome::Rejected } else { Outcome::Proved };
    let text = if is_standard {
        written.text.clone()
    } else {
        let said = if written.is_refuted { "Rejected" } else { "Proved" };
        let number = counted(written.theorems.len(), "theorem");
        format!("{file}: {said}\n  {}: {number} for Coq ({})\n", path.display(), written.theorems.join(", "))
    };
    let coq = if is_standard { written.text } else { path.display().to_string() };
    let answer = Answer::new(text, &Written { file, outcome, coq, theorems: written.theorems })?;
    Ok(answer.negative(written.is_refuted))
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
