//! Forged files for Coq: the file of a certificate that is proved, with the numbers of a mutant that is refuted.
//!
//! Of the mutants of [`falsify`](super::falsify) those are taken that the checker refutes. A forged file claims for the
//! mutant's numbers all that was proved of the design's: once with the margins of the design, and once with margins of
//! 2^-1000, so that only the inequality is left to be refused. `cargo xtask kernel` has Coq refuse each.

use luenberger_proof::certificate::{CertificateFile, digest};
use luenberger_proof::coq::{CoqFile, KINDS, theorems};
use serde_json::Value;

use super::{mutate, of_kind, stream};

/// A design, and two files that Coq has to refuse.
#[derive(Debug, Clone)]
pub struct Forged {
    /// The name of a module, `feedback_loop_1`.
    pub name: String,
    /// The file of the design, which Coq has to accept.
    pub design: String,
    /// All that was proved of the design, said of a refuted mutant.
    pub mutant: String,
    /// The same with margins of 2^-1000.
    pub without_margins: String,
}

/// Longer files are not taken: they would be compiled for long.
const LONGEST: usize = 40_000;

/// Theorems of two sorts, told by a definition: of an observer that converges from an ellipsoid, of data between
/// bounds, of a running observer. Designs of both are taken in turn, those without the definition first.
const SORTS: [(&str, &str); 4] = [
    ("cubic-observer", "\nDefinition level "),
    ("feedback-loop", "\nDefinition level "),
    ("discrete-polytope-of-jacobians", "\nDefinition A_low_1 "),
    ("deployed-observer", "\nDefinition limit "),
];

/// Forged files of refuted mutants of this theorem, of each of `count` designs.
///
/// # Panics
/// For a theorem that has no files for Coq, and where too few of the designs have a refuted mutant.
pub fn forged(kind: &'static str, count: usize, seed: u64) -> Vec<Forged> {
    assert!(KINDS.contains(&kind), "{kind} has no files for Coq");
    let (generator, _) = of_kind(kind);
    let mut random = stream(seed, kind, 1);
    let mut files = Vec::new();
    for _ in 0..200 * count {
        if files.len() == count {
            break;
        }
        let Some(design) = generator(&mut random).filter(|file| file.theorem().name() == kind) else { continue };
        let Some(proved) = theorems(&design).ok().filter(|file| file.text.len() <= LONGEST) else { continue };
        let sort = SORTS.iter().find(|(of, _)| *of == kind);
        if sort.is_some_and(|(_, definition)| proved.text.contains(definition) != (files.len() % 2 == 1)) {
            continue;
        }
        let document: Value = serde_json::from_str(&design.to_json()).expect("the writer writes JSON");
        let mutants = (0..100).filter_map(|_| mutate::mutant(&document, &document, &mut random));
        let Some(mutant) = mutants.filter_map(refuted).find_map(|file| spliced(&proved, &file)) else { continue };
        let name = format!("{}_{}", kind.replace('-', "_"), files.len() + 1);
        files.push(Forged { name, design: proved.text, without_margins: without_margins(&mutant), mutant });
    }
    assert_eq!(files.len(), count, "refuted mutants of {kind}");
    files
}

/// The refutation of a mutant, its words and digest made to agree with its data.
fn refuted(mut mutant: Value) -> Option<CoqFile> {
    let read = CertificateFile::read(mutant.to_string().as_bytes()).ok()?;
    mutant["statement"] = Value::String(read.theorem().words());
    mutant["sha256"] = Value::String(digest(mutant.to_string().as_bytes()).ok()?);
    let file = CertificateFile::read(mutant.to_string().as_bytes()).ok()?;
    theorems(&file).ok().filter(|file| file.is_refuted)
}

/// The paragraphs of a file, each of the definitions with its name.
fn paragraphs(text: &str) -> impl Iterator<Item = (Option<&str>, &str)> {
    text.split("\n\n").map(|paragraph| {
        let name = paragraph.lines().find_map(|line| line.strip_prefix("Definition ")?.split_whitespace().next());
        (name, paragraph)
    })
}

/// The proved file with the definitions of the refuted one; none if they agree, or a matrix has other rows.
fn spliced(proved: &CoqFile, refuted: &CoqFile) -> Option<String> {
    let mut parts = Vec::new();
    let mut is_changed = false;
    for (name, paragraph) in paragraphs(&proved.text) {
        // Margins are those that are claimed of the design.
        let of_mutant = name.filter(|name| !name.starts_with("margin")).and_then(|name| {
            paragraphs(&refuted.text).find_map(|(other, paragraph)| (other == Some(name)).then_some(paragraph))
        });
        let part = of_mutant.unwrap_or(paragraph);
        if part.lines().count() != paragraph.lines().count()
            || part.matches(';').count() != paragraph.matches(';').count()
        {
            return None;
        }
        is_changed |= part != paragraph;
        parts.push(part);
    }
    is_changed.then(|| parts.join("\n\n"))
}

/// The file with margins that claim next to nothing.
fn without_margins(text: &str) -> String {
    let line = |line: &str| match line.strip_prefix("Definition margin").and_then(|rest| rest.split_once(" : Q := ")) {
        Some((name, _)) => format!("Definition margin{name} : Q := 0x1p-1000."),
        None => line.to_owned(),
    };
    text.lines().map(line).collect::<Vec<_>>().join("\n") + "\n"
}
