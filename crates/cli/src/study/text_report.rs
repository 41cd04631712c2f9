//! Results as text: the document of the study, failures, and the files written.

use crate::answer::Answer;
use crate::failure::Failure;
use crate::output;
use luenberger_proof::wording::counted;
use luenberger_study::{Results, Step, StudyError};
use std::fmt::Write;
use std::path::Path;

/// The results with their text, or with why they are not complete.
pub(super) fn answer(
    step: Step,
    results: &Results,
    folder: Option<&Path>,
    markdown: bool,
    stopped: Option<StudyError>,
) -> Result<Answer, Failure> {
    let failures = results.failures();
    // Gains and proofs are printed by `design`, `certify` and `run` only.
    let designs = matches!(step, Step::Design | Step::Certify | Step::Run);
    let text = if markdown { results.markdown(designs) } else { text(designs, results, folder) };
    let answer = Answer::new(text, results)?.negative(!failures.is_empty());
    match stopped {
        None => Ok(answer),
        Some(error) => Err(Failure::Stopped { error, finished: Box::new(answer) }),
    }
}

fn text(designs: bool, results: &Results, folder: Option<&Path>) -> String {
    let coloured = output::is_coloured(&std::io::stdout());
    let mut text = results.summary(designs, coloured);
    if let Some(folder) = folder {
        _ = writeln!(text, "\n{} in {}", counted(results.files.len() + 2, "file"), folder.display());
        if results.files.iter().any(|file| file == "report.html") {
            _ = writeln!(text, "report: {}", folder.join("report.html").display());
        }
    }
    text
}
