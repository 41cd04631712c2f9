//! The table of verdicts at the end of a run.

use crate::claim::Record;
use crate::evidence::Verdict;
use crate::ledger::Summary;
use crate::value::{Value, short};
use comfy_table::{Cell, Color, ContentArrangement, Table, presets};

/// The verdicts as a table, with their counts below it. Colour and the width of the terminal are used only where
/// `terminal` says that there is one.
pub fn table(summary: &Summary, terminal: bool) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_BORDERS_ONLY);
    table.set_content_arrangement(if terminal { ContentArrangement::Dynamic } else { ContentArrangement::Disabled });
    table.set_header(["claim", "where", "printed", "computed", "verdict"]);
    for record in &summary.records {
        let cell = |value: Option<&Value>| Cell::new(value.map_or_else(|| "–".to_owned(), brief));
        let verdict = Cell::new(word(record));
        let verdict = if terminal { verdict.fg(colour(record.verdict)) } else { verdict };
        table.add_row([
            Cell::new(&record.id),
            Cell::new(&record.place),
            cell(record.printed.as_ref()),
            cell(record.computed.as_ref()),
            verdict,
        ]);
    }
    let mut text = format!("{table}\n{}\n", counts(summary));
    for failure in &summary.failures {
        text.extend(["failed: ", &failure.id, ": ", &failure.error, "\n"]);
    }
    text
}

/// `64 claims: 41 reproduced, 19 refuted, 4 underspecified (12.3 s)`.
pub fn counts(summary: &Summary) -> String {
    let count = |verdict| summary.count(verdict);
    let failed = match summary.failures.len() {
        0 => String::new(),
        n => format!(", {n} failed"),
    };
    format!(
        "{} claims: {} reproduced, {} refuted, {} underspecified{failed} ({:.1} s)",
        summary.records.len(),
        count(Verdict::Reproduced),
        count(Verdict::Refuted),
        count(Verdict::Underspecified),
        summary.elapsed.as_secs_f64()
    )
}

pub(crate) fn word(record: &Record) -> &'static str {
    record.verdict.map_or("failed", Verdict::word)
}

/// A value on one line: matrices and long vectors by their shape.
fn brief(value: &Value) -> String {
    match value {
        Value::Vector(v) if v.len() > 3 => format!("{} numbers", v.len()),
        Value::Matrix(rows) => {
            let (r, c) = value.shape();
            if r * c <= 3 {
                format!(
                    "[{}]",
                    rows.concat().iter().map(|&x| short(x)).collect::<Vec<_>>().join(if c == 1 { "; " } else { " " })
                )
            } else {
                format!("{r} x {c} matrix")
            }
        }
        _ => value.to_string(),
    }
}

fn colour(verdict: Option<Verdict>) -> Color {
    match verdict {
        Some(Verdict::Reproduced) => Color::Green,
        Some(Verdict::Refuted) => Color::Red,
        Some(Verdict::Underspecified) => Color::Yellow,
        None => Color::Magenta,
    }
}
