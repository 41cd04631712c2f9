//! What a run shows on a terminal: the template of its progress bar, and the table of verdicts at its end.

use crate::claim::{Class, Record};
use crate::evidence::{Standing, Verdict};
use crate::summary::Summary;
use crate::value::{Value, short};
use comfy_table::{Cell, Color, ContentArrangement, Table, presets};

/// The template of the progress bar of a run, in the language of the crate `indicatif`.
pub const PROGRESS: &str = "{bar:32.cyan/dim} {pos:>3}/{len} {msg}";

/// Which claims a table shows. Empty lists exclude nothing.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Filter {
    /// Of these classes.
    pub classes: Vec<Class>,
    /// With these verdicts.
    pub verdicts: Vec<Verdict>,
}

impl Filter {
    fn shows(&self, record: &Record) -> bool {
        let verdict = record.verdict.is_none_or(|verdict| self.verdicts.is_empty() || self.verdicts.contains(&verdict));
        verdict && (self.classes.is_empty() || self.classes.contains(&record.class))
    }
}

/// The verdicts as a table, with the counts of all claims below it. Colour and the width of the terminal are used only
/// where `terminal` says that there is one.
pub fn table(summary: &Summary, filter: &Filter, terminal: bool) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_BORDERS_ONLY);
    table.set_content_arrangement(if terminal { ContentArrangement::Dynamic } else { ContentArrangement::Disabled });
    table.set_header(["claim", "class", "where", "printed", "computed", "verdict"]);
    for record in summary.records.iter().filter(|record| filter.shows(record)) {
        let cell = |value: Option<&Value>| Cell::new(value.map_or_else(|| "–".to_owned(), brief));
        let verdict = Cell::new(record.word());
        let verdict = if terminal { verdict.fg(colour(record.verdict)) } else { verdict };
        table.add_row([
            Cell::new(&record.id),
            Cell::new(record.class),
            Cell::new(&record.place),
            record
                .as_printed
                .as_ref()
                .filter(|text| is_short(text))
                .map_or_else(|| cell(record.printed.as_ref()), Cell::new),
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

/// The counts of a run: the papers' theorems by what is known of them, their examples, and the other classes apart, a
/// line each.
/// ```text
/// the papers' own claims: 64 (40 theorem, 24 example)
/// theorems: 15 proved, 14 consistent with every instance tried, 11 neither (8 refuted, 3 underspecified)
/// examples: 20 reproduced, 1 refuted, 3 underspecified
/// apart: 12 misprint (0 reproduced, 11 refuted, 1 underspecified), 9 reading (..), 20 ours (..)
/// ```
pub fn headline(summary: &Summary) -> String {
    const ALL: [Verdict; 3] = [Verdict::Reproduced, Verdict::Refuted, Verdict::Underspecified];
    let of = |classes: &[Class], verdict| summary.count_of(classes, verdict);
    let verdicts = |classes: &[Class], which: &[Verdict]| {
        which.iter().map(|&verdict| format!("{} {verdict}", of(classes, verdict))).collect::<Vec<_>>().join(", ")
    };
    let own = Class::OWN.map(|class| format!("{} {class}", summary.of(&[class]))).join(", ");
    let neither: usize = ALL[1..].iter().map(|&verdict| of(&[Class::Theorem], verdict)).sum();
    let apart: Vec<String> = Class::ALL
        .into_iter()
        .filter(|class| !Class::OWN.contains(class))
        .map(|class| format!("{} {class} ({})", summary.of(&[class]), verdicts(&[class], &ALL)))
        .collect();
    format!(
        "the papers' own claims: {} ({own})\ntheorems: {} proved, {} consistent with every instance tried, {neither} neither ({})\nexamples: {}\napart: {}\n",
        summary.of(&Class::OWN),
        summary.theorems(Standing::Proved),
        summary.theorems(Standing::Consistent),
        verdicts(&[Class::Theorem], &ALL[1..]),
        verdicts(&[Class::Example], &ALL),
        apart.join(", ")
    )
}

/// [`headline`], and how many claims were checked in what time.
pub fn counts(summary: &Summary) -> String {
    format!(
        "{}{} claims checked, {} failed ({:.1} s)",
        headline(summary),
        summary.records.len(),
        summary.failures.len(),
        summary.elapsed.as_secs_f64()
    )
}

/// At most three entries.
fn is_short(text: &str) -> bool {
    text.split([' ', ';']).filter(|entry| !entry.is_empty()).count() <= 3
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
