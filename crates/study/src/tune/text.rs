//! The tuned study as text: the study with other numbers, each with a comment that says where it comes from.

use std::fmt::Write;

use luenberger_proof::wording::{counted, significant};

use super::report::{Judged, TuneReport};
use crate::error::tune::TuneError;
use crate::read::{self, Edit, Editable};
use crate::study::{Format, Study};

/// The text of the study with these changes; everything else of it stays, with its comments.
pub(super) fn tuned(
    study: &Study,
    (editable, edits): (&Editable<'_>, &[Edit]),
    report: &TuneReport,
) -> Result<String, TuneError> {
    let failed = |why: &str| TuneError::Text { why: why.to_owned() };
    let text = study.source.text();
    // Positions with what is written there in place of how many bytes.
    let mut changes = Vec::new();
    for edit in edits {
        let found = editable.replacement(edit);
        let (span, new) = found.ok_or_else(|| failed(&format!("there is no place for `{}`", edit.key)))?;
        if study.format == Format::Toml {
            let line = text[..span.start].rfind('\n').map_or(0, |k| k + 1);
            let indent: String = text[line..].chars().take_while(|c| *c == ' ' || *c == '\t').collect();
            let comments = edit.of.iter().map(|k| format!("{indent}# {}\n", comment(report, *k)));
            changes.push((line..line, comments.collect::<String>()));
        }
        changes.push((span, new));
    }
    if study.format == Format::Toml {
        // A line `#:schema` has to stay the first.
        let start = if text.starts_with("#:") { text.find('\n').map_or(text.len(), |k| k + 1) } else { 0 };
        changes.push((start..start, head(study, report)));
    }
    // Of one position the first stays first.
    changes.sort_by_key(|(span, _)| (span.start, span.end));
    let (mut written, mut end) = (String::new(), 0);
    for (span, new) in changes {
        written += text.get(end..span.start).ok_or_else(|| failed("its numbers overlap"))?;
        written += &new;
        end = span.end;
    }
    written += &text[end..];
    read::study(&report.file, &written, study.format, &study.data).map_err(|error| failed(&error.to_string()))?;
    Ok(written)
}

fn head(study: &Study, report: &TuneReport) -> String {
    let logs: Vec<String> = report
        .logs
        .iter()
        .map(|log| format!("{} of {} of {}", counted(log.fitted, "row"), log.fitted + log.held_out, log.file))
        .collect();
    let mut text = format!(
        "# luenberger tune {}: {} by {} on the first {}.\n",
        study.file_name(),
        report.observer,
        report.by(),
        logs.join(" and the first ")
    );
    let (name, [before, after], digits) = match report.relative {
        Some(relative) => (report.relative_name(), relative, 4),
        None => ("log-likelihood", [report.log_likelihood_before, report.log_likelihood], 8),
    };
    let [before, after] = [before, after].map(|x| significant(x, digits));
    let first = name[..1].to_uppercase();
    _ = write!(text, "# {first}{} {after}, before {before}.", &name[1..]);
    if let Some(held_out) = &report.held_out {
        let number = |judged: &Judged| judged.relative.or(judged.log_likelihood);
        let [before, after] = [&held_out.before, &held_out.after]
            .map(|judged| number(judged).map_or_else(|| "none".to_owned(), |x| significant(x, digits)));
        _ = write!(text, " On the rows that were held out {after}, before {before}.");
    }
    text + "\n"
}

fn comment(report: &TuneReport, k: usize) -> String {
    let Some(one) = report.parameters.get(k) else { return String::new() };
    let [before, after] = [one.before, one.after].map(|x| significant(x, 6));
    let percent = if one.interval.is_some() { "95 % " } else { "" };
    format!("luenberger tune: {} = {after}, before {before}; {percent}{}.", one.name, one.interval_in_words())
}
