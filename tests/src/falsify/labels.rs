//! Whether a wrong hypothesis would be noticed: each label and each definition of a theorem, changed by a typical error
//! and decided in its place.
//!
//! The changed texts follow from those of the theorem, so that a new theorem has them by having labels. One is noticed
//! where a certificate of a design is refused with it, or where the adversary contradicts the margins that it gives to
//! a certificate or to a mutant of one.

use std::cell::RefCell;
use std::collections::BTreeSet;

use luenberger_proof::certificate::{CertificateFile, Fact, Theorem};
use serde_json::{Value, json};

use super::document::hexadecimal;
use super::{Run, Tally, mutate, stream};

/// On how many certificates of designs the texts are tried first, then on three times as many, then on mutants of each.
const DESIGNS: usize = 9;
const MUTANTS: usize = 10;

/// The text of a label or a definition, and another one in its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Changed {
    /// The text.
    pub text: String,
    /// What is decided instead.
    pub by: String,
}

/// What came of the texts of one theorem.
#[derive(Debug, Clone, Default)]
pub struct Noticed {
    /// Those that are noticed.
    pub noticed: Vec<Changed>,
    /// Those that are not.
    pub missed: Vec<Changed>,
}

/// A theorem with its document, the labels and definitions that are decided of it, and whether it is proved.
struct Trial {
    theorem: Theorem,
    document: Value,
    texts: BTreeSet<String>,
    is_proved: bool,
}

impl Run {
    fn mutants_of(&mut self, designs: &[Value]) -> Vec<Value> {
        let mut documents = Vec::new();
        for (design, other) in designs.iter().zip(designs.iter().cycle().skip(1)) {
            let mutants = std::iter::repeat_with(|| mutate::mutant(design, other, &mut self.random)).flatten();
            documents.extend(mutants.take(MUTANTS));
        }
        documents
    }
}

impl Trial {
    fn of(document: Value) -> Option<Self> {
        let theorem = CertificateFile::read(document.to_string().as_bytes()).ok()?.theorem().clone();
        let texts = RefCell::new(BTreeSet::new());
        let read = |text: &str| {
            texts.borrow_mut().insert(text.to_owned());
            text.to_owned()
        };
        let is_proved = is_proved(&theorem.facts_read_by(&read).ok()?);
        Some(Self { theorem, document, texts: texts.into_inner(), is_proved })
    }
}

fn is_proved(facts: &[Fact]) -> bool {
    facts.iter().all(|fact| fact.verdict.is_proved())
}

/// The designs, more of them, and mutants: what is wrong only where a stored matrix misses its equation by much is
/// noticed on few of these.
const ROUNDS: usize = 8;

/// The labels and definitions of a theorem, each changed in every way there is.
///
/// # Panics
/// For a theorem without a generator or an adversary, and where none of 200 random designs has a certificate.
pub fn changed_labels(kind: &'static str, seed: u64) -> Noticed {
    let mut run = Run { kind, tally: Tally::default(), random: stream(seed, kind, 1) };
    let mut designs: Vec<Value> = (0..DESIGNS).map(|_| run.design()).collect();
    let mut trials: Vec<Trial> = designs.iter().cloned().filter_map(Trial::of).collect();
    let texts: BTreeSet<String> = trials.iter().flat_map(|trial| trial.texts.clone()).collect();
    let of = |text: String| changes(&text).into_iter().map(move |by| Changed { text: text.clone(), by });
    let mut found = Noticed { missed: texts.into_iter().flat_map(of).collect(), noticed: Vec::new() };
    for round in 0..ROUNDS {
        let is_noticed = |changed: &Changed| trials.iter().any(|trial| is_noticed(trial, changed, &mut run));
        let (noticed, missed): (Vec<_>, Vec<_>) = found.missed.into_iter().partition(is_noticed);
        found.missed = missed;
        found.noticed.extend(noticed);
        if found.missed.is_empty() || round + 1 == ROUNDS {
            break;
        }
        // More designs, then mutants of them all, again and again.
        let documents = if round == 0 {
            let more: Vec<Value> = (0..3 * DESIGNS).map(|_| run.design()).collect();
            designs.extend(more.iter().cloned());
            more
        } else {
            run.mutants_of(&designs)
        };
        trials = documents.into_iter().filter_map(Trial::of).collect();
    }
    found
}

fn is_noticed(trial: &Trial, changed: &Changed, run: &mut Run) -> bool {
    if !trial.texts.contains(&changed.text) {
        return false;
    }
    let read = |text: &str| if text == changed.text { &changed.by } else { text }.to_owned();
    let facts = match trial.theorem.facts_read_by(&read) {
        Ok(facts) if is_proved(&facts) => facts,
        _ => return trial.is_proved,
    };
    let margins = facts.iter().map(|fact| {
        let margin = fact.verdict.margin().map_or(Value::Null, hexadecimal);
        json!({ "inequality": fact.inequality, "margin": margin })
    });
    let mut document = trial.document.clone();
    document["margins"] = margins.collect();
    run.adversary(&document).is_err()
}

/// Names of matrices that are symmetric: their transposes are no errors.
const SYMMETRIC: [&str; 6] = ["I", "M", "P", "Q", "U", "X"];

/// The text with one typical error: a sign, a term, a factor of a number, a transpose, a square or a half, a block, or
/// the direction of the relation.
fn changes(text: &str) -> Vec<String> {
    let replaced = |at: usize, length: usize, by: &str| format!("{}{by}{}", &text[..at], &text[at + length..]);
    let mut changed = Vec::new();
    for (from, to) in
        [(" + ", " - "), (" - ", " + "), ("'", ""), ("^2", ""), ("/2", ""), (" < ", " > "), (" > ", " < ")]
    {
        // A prime behind a digit is one of the number of an equation.
        let places = text.match_indices(from).filter(|(at, _)| from != "'" || !text[..*at].ends_with(char::is_numeric));
        changed.extend(places.map(|(at, _)| replaced(at, from.len(), to)));
    }
    // A minus in front, and numbers as factors.
    for (at, c) in text.char_indices() {
        let rest = &text[at..];
        let is_first = at == 0 || text[..at].ends_with(['[', '(', ' ']);
        if c == '-' && is_first && !rest.starts_with("- ") {
            changed.push(replaced(at, 1, ""));
        }
        let length = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
        let word = &rest[..length];
        // One matrix, or the last of several that stand beside each other.
        let is_last = !rest[1.min(rest.len())..].starts_with(|c: char| c.is_ascii_alphanumeric() || "_~'".contains(c));
        let is_gram = text[..at].ends_with(&format!("{c}'"));
        if c.is_ascii_uppercase() && is_last && !is_gram && !SYMMETRIC.contains(&&rest[..1]) {
            changed.push(replaced(at, 1, &format!("{c}'")));
        }
        let is_number = !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit());
        let after = rest[length..].strip_prefix("^2").unwrap_or(&rest[length..]);
        let factor = rest.len() - after.len() + usize::from(after.starts_with(' '));
        let has_more = rest[factor..].starts_with(|c: char| c.is_ascii_alphabetic() || c == '(');
        if is_first && is_number && has_more && !["tr", "diag", "sum", "for"].contains(&word) {
            changed.push(replaced(at, factor, ""));
        }
    }
    // Terms of sums, and blocks, which end where the brackets around them do, or at the next.
    let depth = |text: &str| {
        text.chars().fold(0_i32, |depth, c| depth + i32::from("([".contains(c)) - i32::from(")]".contains(c)))
    };
    let end = |at: usize, ends: &[&str]| {
        let is_end = |k: &usize| {
            let inside = &text[at..*k];
            depth(inside) == 0 && (text[*k..].starts_with([')', ']']) || ends.iter().any(|e| text[*k..].starts_with(e)))
        };
        (at..text.len()).filter(|k| text.is_char_boundary(*k)).find(is_end).unwrap_or(text.len())
    };
    let is_diagonal = |before: &str| {
        let row = before.rfind("; ").map_or(0, |at| at + 2);
        let outer = |separator: &str, from: usize| {
            before[from..].match_indices(separator).filter(|(at, _)| depth(&before[..from + at]) == 1).count()
        };
        // A column of blocks has no diagonal.
        outer(", ", row) == outer("; ", 0) && text.contains(", ")
    };
    let terms = [" + ", " - ", ", ", "; ", " < ", " > ", " <= ", " >= ", " for "];
    for sign in [" + ", " - "] {
        for (at, _) in text.match_indices(sign) {
            let end = end(at + sign.len(), &terms);
            changed.push(replaced(at, end - at, ""));
        }
    }
    for (at, _) in text.match_indices(['[', '(']).chain(text.match_indices(", ")).chain(text.match_indices("; ")) {
        let start = at + if text[at..].starts_with(['[', '(']) { 1 } else { 2 };
        let first = end(start, &terms);
        if text[first..].starts_with(" + ") {
            changed.push(replaced(start, first + 3 - start, ""));
        }
        if !text[at..].starts_with('(') && depth(&text[..start]) == 1 {
            let end = end(start, &[", ", "; "]);
            if !["*", "0"].contains(&&text[start..end]) {
                changed.push(replaced(start, end - start, "0"));
                // Beside the diagonal a sign is that of a coordinate.
                if is_diagonal(&text[..start]) {
                    changed.push(replaced(start, end - start, &format!("-({})", &text[start..end])));
                }
            }
        }
    }
    if let Some((first, rest)) = text.split_once(" + ")
        && depth(first) == 0
    {
        changed.push(rest.to_owned());
    }
    changed.sort();
    changed.dedup();
    changed
}
