//! Certificate files: a statement, the exact numbers that prove it, and an independent checker.
//!
//! A [`CertificateFile`] is a JSON document with the plant, the observer, a [`Theorem`], the matrices that prove it, a
//! margin for each of its inequalities, and the statement as text. [`verify`] derives all of that again from the
//! plant's data: every inequality is evaluated by [`statement`](crate::statement) in exact or interval arithmetic, the
//! text is generated again and compared, and a claimed margin that exceeds the verified one by one unit in the last
//! place is rejected. A digest over the [canonical form](CertificateFile#canonical-form) detects accidental changes,
//! including those that the verification would not notice; it is not a signature, and no proof depends on it.
//! `docs/certificates.md` of the repository shows a file and lists what must be trusted.
//!
//! ```
//! use luenberger_proof::Matrix;
//! use luenberger_proof::certificate::{CertificateFile, HurwitzStability, verify};
//!
//! let a = Matrix::from_rows([[0.0, 1.0], [-2.0, -3.0]]);
//! let p = Matrix::from_rows([[5.0, 1.0], [1.0, 1.0]]);
//! let file = CertificateFile::prove("a damped oscillator", HurwitzStability::new(&a, &p)?)?.to_json();
//! let proved = verify(file.as_bytes())?;
//! assert!(proved.facts.iter().any(|fact| fact.inequality == "A'P + PA < 0"));
//! // A digit of A changed: the digest detects it, and without it the text and the margins would.
//! let forged = file.replace("-0x1.8p1", "-0x1.9p1");
//! assert!(verify(forged.as_bytes()).is_err());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
mod evidence;
mod fields;
mod jacobians;
mod json;
mod limits;
mod members;
mod sentence;
mod theorem;
mod write;

use core::fmt;

use sha2::{Digest, Sha256};

use crate::definite::Direction;
use crate::error::ProofError;
use crate::label::Names;
use crate::number::quoted;
use crate::verdict::Verdict;
use crate::wording::at_least;

pub use crate::number::{Datum, LONGEST_NUMBER, Number, NumberError};
pub use crate::polynomial::{DEEPEST_EXPRESSION, ExpressionError, LONGEST_EXPRESSION};
pub use crate::witness::Witness;
pub use error::{Fault, FileError, Rejection};
pub use evidence::{Certificate, Certified, ProvedTheorem, UnprovedTheorem};
pub use fields::{LARGEST_ORDER, MOST_ENTRIES};
pub use limits::{DEEPEST, LARGEST_FILE, MOST_MOTION, MOST_VALUES};
pub use sentence::{NO_USEFUL_BOUND, ProvedSentence, Reading, Represented, is_useful};
pub use theorem::*;

use fields::Field;
use json::{Node, canonical, parse};
use write::{Out, Written};

/// The value of the field `format` of every certificate.
pub const FORMAT: &str = "luenberger-certificate";

/// The version of the format that this crate reads and writes.
pub const VERSION: usize = 2;

/// A margin that a file claims for one inequality of its theorem.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Claim {
    /// The inequality, as the theorem writes it.
    pub inequality: String,
    /// The margin, in the units of the inequality.
    pub margin: Number,
}

/// One inequality of a theorem, with its verdict.
#[derive(Debug, Clone, PartialEq)]
pub struct Fact {
    /// The inequality, as the theory writes it.
    pub inequality: String,
    /// The vertex at which it is stated, from 0, where the theorem has a list of them.
    pub vertex: Option<usize>,
    /// Proved, refuted or undecided. A margin of 0 is that of an equation, or of a statement that has no room or no
    /// measure of it.
    pub verdict: Verdict<Witness>,
}

impl<'a> Names<'a> {
    /// And the members of a theorem, or of a part of it.
    fn of(self, members: &'a impl Written) -> Self {
        members.name_in("", false, self)
    }

    /// The fact of this label.
    pub(crate) fn fact(&self, label: impl Into<String>) -> Result<Fact, ProofError> {
        let label = label.into();
        let verdict = self.decide(&label)?;
        Ok(Fact::new(label, verdict))
    }

    /// The facts of these labels.
    pub(crate) fn facts<S: Into<String>>(&self, labels: impl IntoIterator<Item = S>) -> Result<Vec<Fact>, ProofError> {
        labels.into_iter().map(|label| self.fact(label)).collect()
    }
}

impl Fact {
    pub(crate) fn new(inequality: impl Into<String>, verdict: Verdict<Direction>) -> Self {
        Self::stated(inequality, verdict.map_witness(Witness::Direction))
    }

    pub(crate) fn stated(inequality: impl Into<String>, verdict: Verdict<Witness>) -> Self {
        Self { inequality: inequality.into(), vertex: None, verdict }
    }

    /// The inequality at a vertex, which is counted from 1 in words.
    pub(crate) fn at_vertex(inequality: &str, vertex: usize, verdict: Verdict<Direction>) -> Self {
        let fact = Self::new(format!("{inequality} at vertex {}", vertex + 1), verdict);
        Self { vertex: Some(vertex), ..fact }
    }

    /// The inequality, with the name of its vertex behind it where `vertices` has one.
    pub fn inequality_naming(&self, vertices: &[String]) -> String {
        match self.vertex.and_then(|k| vertices.get(k)) {
            Some(name) => format!("{} ({name})", self.inequality),
            None => self.inequality.clone(),
        }
    }
}

impl fmt::Display for Fact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.verdict {
            Verdict::Proved { margin } if *margin > 0.0 => {
                write!(f, "{}, margin >= {}", self.inequality, at_least(*margin, 7))
            }
            Verdict::Proved { .. } => f.write_str(&self.inequality),
            Verdict::Refuted { witness } => write!(f, "{} is false: {witness}", self.inequality),
            Verdict::Undecided { why, .. } => write!(f, "{} is not proved: {why}", self.inequality),
        }
    }
}

/// Result of verifying a file: the statement and its inequalities.
#[derive(Debug, Clone, PartialEq)]
pub struct Proved {
    /// The title of the file; it carries no claim.
    pub title: String,
    /// The statement in words, generated from the data.
    pub statement: String,
    /// The inequalities, each proved, with its margin.
    pub facts: Vec<Fact>,
}

/// The statement, and each inequality on a line of its own.
impl fmt::Display for Proved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.statement)?;
        self.facts.iter().try_for_each(|fact| write!(f, "\n{fact}"))
    }
}

/// The contents of a certificate file: title, theorem with data, statement, margins, digest.
///
/// # Canonical form
/// The JSON document without white space between tokens, the members of each object in the order of their names,
/// without the member `sha256`, in UTF-8, with no escapes in strings but `\"` and `\\`. The digest is that of this
/// text: `jq -cjS 'del(.sha256)' FILE | sha256sum`.
#[derive(Debug, Clone, PartialEq)]
pub struct CertificateFile {
    title: String,
    theorem: Theorem,
    claims: Vec<Claim>,
    statement: String,
    digest: String,
    found: Found,
}

/// Where things stood in the text that was read, and what it has for a digest.
#[derive(Debug, Clone, PartialEq)]
struct Found {
    computed: String,
    digest_line: usize,
    statement_line: usize,
    claims_line: usize,
    claim_lines: Vec<usize>,
}

/// Reads and verifies a file: its digest, its statement, and every inequality with its margin.
///
/// # Errors
/// [`Rejection`] describes the error of the text, or the inequality that fails and by how much.
pub fn verify(bytes: &[u8]) -> Result<Proved, Rejection> {
    CertificateFile::read(bytes)?.check()
}

impl CertificateFile {
    /// Proves every inequality of the theorem for these data, and makes the certificate file with the proved margins.
    ///
    /// # Errors
    /// [`Rejection::NotProved`] names the inequality that fails; [`Rejection::File`] for invalid data.
    pub fn prove(title: &str, theorem: impl Into<Theorem>) -> Result<Self, Rejection> {
        Certificate::of([theorem])?.file(title)
    }

    fn written(title: &str, theorem: &Theorem, claims: &[Claim]) -> Result<Self, FileError> {
        Self::read(sealed(title, theorem, &theorem.words(), claims)?.as_bytes())
    }

    /// Reads a certificate from the bytes of a file, without verification; see [`check`](Self::check) for that.
    ///
    /// # Errors
    /// [`FileError`] with the line and the field.
    pub fn read(bytes: &[u8]) -> Result<Self, FileError> {
        let node = parse(bytes)?;
        Field::root(&node).object(|file| {
            let format = file.take("format")?;
            if format.text()? != FORMAT {
                return Err(format.unknown_word(format.text()?, [FORMAT]));
            }
            let version = file.take("version")?;
            if version.count()? != VERSION {
                return Err(version.error(Fault::Version { found: version.count()?.to_string() }));
            }
            let title = file.take("title")?.name()?;
            let statement = file.take("statement")?;
            let theorem = Theorem::read(file)?;
            let margins = file.take("margins")?;
            let mut claim_lines = Vec::new();
            let claims = margins.list_of(|item| {
                item.object(|claim| {
                    let inequality = claim.take("inequality")?.text()?.to_owned();
                    let margin = claim.take("margin")?;
                    claim_lines.push(margin.line());
                    Ok(Claim { inequality, margin: margin.exact()? })
                })
            })?;
            let digest = file.take("sha256")?;
            Ok(Self {
                title,
                theorem,
                claims,
                statement: statement.text()?.to_owned(),
                digest: digest.text()?.to_owned(),
                found: Found {
                    computed: digest_of(&node),
                    digest_line: digest.line(),
                    statement_line: statement.line(),
                    claims_line: margins.line(),
                    claim_lines,
                },
            })
        })
    }

    /// The title of the file; it carries no claim.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// The theorem, with all its data.
    pub fn theorem(&self) -> &Theorem {
        &self.theorem
    }

    /// The margins claimed, in the order of the theorem's inequalities.
    pub fn claims(&self) -> &[Claim] {
        &self.claims
    }

    /// The statement in words, as the file has it.
    pub fn statement(&self) -> &str {
        &self.statement
    }

    /// The same certificate with other claimed margins and a matching digest. [`check`](Self::check) accepts margins
    /// that are not larger than the proved ones, and rejects others.
    ///
    /// # Errors
    /// [`FileError`] for an inequality or margin that cannot be written.
    pub fn with_claims(&self, claims: &[Claim]) -> Result<Self, FileError> {
        Self::read(sealed(&self.title, &self.theorem, &self.statement, claims)?.as_bytes())
    }

    /// The text of the file: one row of a matrix to a line.
    pub fn to_json(&self) -> String {
        draft(&self.title, &self.theorem, &self.statement, &self.claims, &self.digest)
    }

    /// Verifies the certificate; everything is derived again from the data.
    ///
    /// # Errors
    /// [`Rejection`]: the first thing that is wrong, in the order digest, words, inequalities, margins.
    pub fn check(&self) -> Result<Proved, Rejection> {
        let Found { computed, digest_line, statement_line, claims_line, claim_lines } = &self.found;
        if self.digest != *computed {
            let (found, computed) = (quoted(&self.digest), computed.clone());
            return Err(Rejection::Digest { line: *digest_line, found, computed });
        }
        let derived = self.theorem.words();
        if self.statement != derived {
            return Err(Rejection::Words { line: *statement_line, derived });
        }
        let facts = self.theorem.facts()?;
        if facts.len() != self.claims.len() {
            let (expected, found) = (facts.len(), self.claims.len());
            return Err(Rejection::Claims { line: *claims_line, expected, found });
        }
        for (index, (fact, claim)) in facts.iter().zip(&self.claims).enumerate() {
            let line = claim_lines.get(index).copied().unwrap_or(*claims_line);
            let inequality = fact.inequality.clone();
            if inequality != claim.inequality {
                return Err(Rejection::Inequality { line, index, expected: inequality });
            }
            let Some((proved_decimal, proved)) = fact.verdict.margin().and_then(|x| Some((x, Number::from_f64(x)?)))
            else {
                return Err(Rejection::NotProved { inequality, verdict: Box::new(fact.verdict.clone()) });
            };
            // The least number that the claim may be is compared with what is proved: a claim between two binary64
            // numbers counts as the upper one.
            let claimed_decimal = claim.margin.enclosure().hi();
            if claimed_decimal > proved_decimal || claim.margin.enclosure().lo() < 0.0 {
                let (claimed, proved) = (Box::new(claim.margin.clone()), Box::new(proved));
                return Err(Rejection::Margin {
                    line,
                    index,
                    inequality,
                    claimed,
                    claimed_decimal,
                    proved,
                    proved_decimal,
                });
            }
        }
        Ok(Proved { title: self.title.clone(), statement: derived, facts })
    }
}

/// The text of a file.
fn draft(title: &str, theorem: &Theorem, statement: &str, claims: &[Claim], digest: &str) -> String {
    let mut members = vec![
        ("format", Out::Text(FORMAT.to_owned())),
        ("version", Out::Count(VERSION)),
        ("title", Out::Text(title.to_owned())),
        ("statement", Out::Text(statement.to_owned())),
    ];
    members.extend(theorem.write());
    let claims = claims
        .iter()
        .map(|claim| Out::Object(vec![("inequality", claim.inequality.out()), ("margin", claim.margin.out())]));
    members.push(("margins", Out::Lines(claims.collect())));
    members.push(("sha256", Out::Text(digest.to_owned())));
    Out::Object(members).pretty()
}

/// The text of a file with the digest of its content.
fn sealed(title: &str, theorem: &Theorem, statement: &str, claims: &[Claim]) -> Result<String, FileError> {
    let unsealed = draft(title, theorem, statement, claims, "");
    Ok(draft(title, theorem, statement, claims, &digest_of(&parse(unsealed.as_bytes())?)))
}

fn digest_of(node: &Node) -> String {
    let bytes = Sha256::digest(canonical(node, "sha256").as_bytes());
    bytes.iter().flat_map(|byte| [byte >> 4, byte & 15]).filter_map(|half| char::from_digit(half.into(), 16)).collect()
}

/// The digest of a text, for certificates written by hand or by another program.
///
/// # Errors
/// [`FileError`] when the text is no JSON document.
pub fn digest(bytes: &[u8]) -> Result<String, FileError> {
    Ok(digest_of(&parse(bytes)?))
}
