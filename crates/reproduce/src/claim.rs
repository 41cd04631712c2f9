//! A claim of a paper: a row of data with the printed value and its place, and a function that computes.
//!
//! The verdict is never part of the row. It follows from `printed`, `tolerance` and what `check` returns, by the rules
//! of [`crate::evidence`].
//!
//! # Adding a claim
//! Write the row and its function in the file of the example or theorem, and list the row in that file's `claims()`.
//! The row has the [`Class`] of the claim. A claim of the paper that is not reproduced must quote the paper's sentence
//! and its interpretation ([`Claim::quoting`]), and the refutation of a theorem must show its hypotheses as evaluated
//! ([`Outcome::given`], [`Counterexample`](crate::evidence::Counterexample)): the run fails otherwise.
//!
//! A theorem speaks of all cases, and a check runs some: the row of a theorem that is proved names the proof
//! ([`Claim::proved_in`]), and every other one counts its instances ([`Outcome::instances`], [`Evidence::cases`]). Its
//! [`Standing`] follows.
//! ```
//! use luenberger_reproduce::{Claim, Class, Context, Evidence, Outcome, CheckError, Printed, Tolerance, Verdict};
//!
//! const SETTLING: Claim = Claim {
//!     id: "demo.settling",
//!     class: Class::Example,
//!     place: "Example 1, Fig. 4",
//!     statement: "the error settles to 5% after 2.3 s",
//!     printed: Printed::Decimals("2.3"),
//!     tolerance: Tolerance::AsPrinted,
//!     assumptions: &["xhat(0) = 0", "settling is the last time |e| = 0.05"],
//!     quote: None,
//!     proof: None,
//!     check: settling,
//! };
//!
//! /// e' = -1.3 e from e(0) = 1 reaches 0.05 at ln(20)/1.3.
//! fn settling(_: &Context) -> Result<Outcome, CheckError> {
//!     Ok(Outcome::new(Evidence::value(20.0_f64.ln() / 1.3)).note("closed form"))
//! }
//! let record = SETTLING.examine("demo", &Context::new("."));
//! assert_eq!(record.verdict, Some(Verdict::Reproduced));
//! ```

use crate::context::Context;
use crate::evidence::{Evidence, Hypothesis, Standing, Tolerance, Verdict, judge};
use crate::value::{Printed, Value};
use serde::Serialize;
use std::fmt;

pub use crate::context::CheckError;

/// Origin and kind of a claim. [`Class::Theorem`] and [`Class::Example`] are the paper's own claims; the others are
/// counted separately.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// A general claim of the paper: a theorem, a remark, a formula, a sentence of its introduction.
    Theorem,
    /// A number or a figure of an example, or a statement of the text about it.
    Example,
    /// A misprint: a sign, a letter, a digit or a word that the rest of the paper contradicts.
    Misprint,
    /// A detail that the paper does not specify: the claim shows the effect of the choice, or runs a variant of the
    /// example.
    Reading,
    /// Not in the paper: a corrected statement, or an observer added here.
    Ours,
}

impl Class {
    /// All of them, in the order of the tables.
    pub const ALL: [Self; 5] = [Self::Theorem, Self::Example, Self::Misprint, Self::Reading, Self::Ours];
    /// The paper's own claims.
    pub const OWN: [Self; 2] = [Self::Theorem, Self::Example];

    /// One word for tables, as in the JSON.
    pub fn word(self) -> &'static str {
        match self {
            Self::Theorem => "theorem",
            Self::Example => "example",
            Self::Misprint => "misprint",
            Self::Reading => "reading",
            Self::Ours => "ours",
        }
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.word())
    }
}

/// A sentence or formula of the paper, and its interpretation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Quote {
    /// The exact quotation.
    pub text: &'static str,
    /// Its interpretation.
    pub reading: &'static str,
}

/// Where a theorem is proved: a page of the repository, and the test that states it over random instances of its
/// hypotheses or decides it rigorously.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct DocProof {
    /// The page, as `theory-cubic.md` of `docs/`.
    pub page: &'static str,
    /// Words of the page at which the proof stands.
    pub at: &'static str,
    /// The file of the test, from the root of the repository.
    pub tests: &'static str,
    /// The name of the test.
    pub property: &'static str,
}

/// One claim of a paper.
#[derive(Debug, Clone)]
pub struct Claim {
    /// Unique name: paper, place, subject, such as `cubic.ex1.gain`.
    pub id: &'static str,
    /// Origin and kind.
    pub class: Class,
    /// Place in the paper: equation, theorem, figure, example.
    pub place: &'static str,
    /// The claim of the paper, in one sentence.
    pub statement: &'static str,
    /// The printed value.
    pub printed: Printed,
    /// The accuracy of the comparison.
    pub tolerance: Tolerance,
    /// Assumptions needed because the paper does not print the data.
    pub assumptions: &'static [&'static str],
    /// The quotation, if the verdict depends on its wording.
    pub quote: Option<Quote>,
    /// The proof of a theorem, if there is one.
    pub proof: Option<DocProof>,
    /// Computes the evidence.
    pub check: fn(&Context) -> Result<Outcome, CheckError>,
}

/// Result of a check.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The evidence, which determines the verdict.
    pub evidence: Evidence,
    /// A note for the reader.
    pub note: String,
    /// Numbers for the reader, too many for sentences.
    pub table: Option<NoteTable>,
    /// The hypotheses of the statement, evaluated where it was tested; counterexamples have their own.
    pub hypotheses: Vec<Hypothesis>,
    /// The number of instances of the statement that were tried.
    pub instances: usize,
}

/// A table that belongs to a note: a head, and rows with as many cells.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NoteTable {
    /// The head.
    pub head: Vec<String>,
    /// The rows.
    pub rows: Vec<Vec<String>>,
}

impl Outcome {
    /// An outcome without a note. The instances are the cases of the evidence, one if it does not count any.
    pub fn new(evidence: Evidence) -> Self {
        let instances = match evidence {
            Evidence::Cases { hold, fail, undecided } => hold + fail + undecided,
            _ => 1,
        };
        Self { evidence, note: String::new(), table: None, hypotheses: Vec::new(), instances }
    }

    /// The same outcome with the number of instances of the statement that were tried.
    #[must_use]
    pub fn instances(mut self, count: usize) -> Self {
        self.instances = count;
        self
    }

    /// The same outcome with a note: full sentences, with the numbers that explain it.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }

    /// The same outcome with a table.
    #[must_use]
    pub fn table(mut self, head: Vec<String>, rows: Vec<Vec<String>>) -> Self {
        self.table = Some(NoteTable { head, rows });
        self
    }

    /// The same outcome with the hypotheses of the statement as evaluated where it was tested.
    #[must_use]
    pub fn given(mut self, hypotheses: Vec<Hypothesis>) -> Self {
        self.hypotheses.extend(hypotheses);
        self
    }
}

impl From<Evidence> for Outcome {
    fn from(evidence: Evidence) -> Self {
        Self::new(evidence)
    }
}

/// The refutation of a claim as a file for Coq.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct KernelTheorems {
    /// The file, below the folder of the run.
    pub file: String,
    /// Its theorems.
    pub theorems: Vec<String>,
}

/// A claim after its check: one entry of `claims.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Record {
    /// The claim's name.
    pub id: String,
    /// The key of the paper.
    pub paper: String,
    /// Origin and kind.
    pub class: Class,
    /// Place in the paper.
    #[serde(rename = "where")]
    pub place: String,
    /// The claim.
    pub statement: String,
    /// The printed value, as numbers.
    pub printed: Option<Value>,
    /// The computed value.
    pub computed: Option<Value>,
    /// The tolerance of each entry, one number where they are all equal, null for truths.
    pub tolerance: Option<Value>,
    /// The printed value letter by letter, entries by spaces and rows by semicolons; absent for truths.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub as_printed: Option<String>,
    /// The verdict; absent if the check failed.
    pub verdict: Option<Verdict>,
    /// What is known of a theorem that is reproduced; absent for all else.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standing: Option<Standing>,
    /// The number of instances of a theorem that were tried; absent for all else.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instances: Option<usize>,
    /// The proof of a theorem, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub proof: Option<DocProof>,
    /// The theorems of the refutation for Coq, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kernel: Option<KernelTheorems>,
    /// Assumptions.
    pub assumptions: Vec<String>,
    /// The quotation and its interpretation.
    pub quote: Option<Quote>,
    /// The hypotheses of the statement, as evaluated.
    pub hypotheses: Vec<Hypothesis>,
    /// The note of the check, with what its evidence adds.
    pub note: String,
    /// Numbers that belong to the note.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table: Option<NoteTable>,
    /// The parts of the note: what the check says, and each counterexample or reading.
    #[serde(skip)]
    pub parts: Vec<String>,
    /// Why the check failed, if it did.
    #[serde(skip)]
    pub error: Option<String>,
}

impl Record {
    /// What is missing in a claim of the paper that is not reproduced, or in a proof, if anything.
    pub fn owes(&self) -> Option<&'static str> {
        let refuted = match self.verdict {
            None => return None,
            Some(Verdict::Reproduced) => {
                return (self.proof.is_some() && self.class != Class::Theorem)
                    .then_some("it names a proof and is no theorem");
            }
            Some(verdict) => verdict == Verdict::Refuted,
        };
        match (self.class, &self.quote) {
            (Class::Ours, _) if refuted => Some("a claim of ours is refuted"),
            (Class::Ours, _) => Some("a claim of ours is not decided"),
            (_, None) => Some("it is not reproduced and quotes no sentence of the paper"),
            (Class::Theorem, _) if refuted && self.hypotheses.is_empty() => {
                Some("it refutes a theorem and evaluates none of its hypotheses")
            }
            _ if self.proof.is_some() => Some("it names a proof and is not reproduced"),
            _ => None,
        }
    }

    /// The verdict in one word, that of a theorem which is reproduced by its standing.
    pub fn word(&self) -> &'static str {
        match (self.standing, self.verdict) {
            (Some(standing), _) => standing.word(),
            (None, Some(verdict)) => verdict.word(),
            (None, None) => "failed",
        }
    }
}

impl Claim {
    /// A statement that the paper makes without a number: it is printed as true.
    pub const fn holds(
        class: Class,
        id: &'static str,
        place: &'static str,
        statement: &'static str,
        assumptions: &'static [&'static str],
        check: fn(&Context) -> Result<Outcome, CheckError>,
    ) -> Self {
        Self {
            id,
            class,
            place,
            statement,
            printed: Printed::Holds(true),
            tolerance: Tolerance::AsPrinted,
            assumptions,
            quote: None,
            proof: None,
            check,
        }
    }

    /// The same claim with the quotation and its interpretation.
    #[must_use]
    pub const fn quoting(mut self, text: &'static str, reading: &'static str) -> Self {
        self.quote = Some(Quote { text, reading });
        self
    }

    /// The same theorem with its proof: the page of `docs/` and words at which it stands, and the test of it.
    #[must_use]
    pub const fn proved_in(
        mut self,
        page: &'static str,
        at: &'static str,
        tests: &'static str,
        property: &'static str,
    ) -> Self {
        self.proof = Some(DocProof { page, at, tests, property });
        self
    }

    /// Runs the check and judges its evidence. A check that fails gives a record without a verdict.
    pub fn examine(&self, paper: &str, context: &Context) -> Record {
        let mut record = Record {
            id: self.id.to_owned(),
            paper: paper.to_owned(),
            class: self.class,
            place: self.place.to_owned(),
            statement: self.statement.to_owned(),
            printed: None,
            computed: None,
            tolerance: None,
            as_printed: self.printed.text(),
            verdict: None,
            standing: None,
            instances: None,
            proof: self.proof,
            kernel: None,
            assumptions: self.assumptions.iter().map(|&a| a.to_owned()).collect(),
            quote: self.quote,
            hypotheses: Vec::new(),
            note: String::new(),
            table: None,
            parts: Vec::new(),
            error: None,
        };
        let judged = (self.check)(context).and_then(|outcome| {
            let judgement = judge(&self.printed, self.tolerance, &outcome.evidence)?.under(&outcome.hypotheses);
            Ok((outcome, judgement))
        });
        match judged {
            Ok((outcome, judgement)) => {
                record.hypotheses = [outcome.hypotheses, outcome.evidence.hypotheses()].concat();
                let mut sentences = vec![outcome.note];
                sentences.extend(judgement.remarks);
                if !judgement.computed.is_finite() {
                    let entries = judgement.computed.entries();
                    let list = entries.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
                    sentences.push(format!("Not every computed entry is a finite number ({list}): null in JSON."));
                }
                sentences.retain(|s| !s.is_empty());
                record.note = sentences.join(" ");
                record.parts = sentences;
                record.table = outcome.table;
                record.printed = Some(judgement.printed);
                record.computed = Some(judgement.computed);
                record.tolerance = judgement.tolerance;
                record.verdict = Some(judgement.verdict);
                if self.class == Class::Theorem {
                    record.standing = Standing::of(judgement.verdict, self.proof.is_some());
                    record.instances = Some(outcome.instances);
                }
            }
            Err(error) => {
                record.printed = self.printed.value().ok();
                record.note = format!("The check failed: {error}.");
                record.parts = vec![record.note.clone()];
                record.error = Some(error.to_string());
            }
        }
        record
    }
}
