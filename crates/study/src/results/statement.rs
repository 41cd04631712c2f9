//! What is said of a design: sentences that its certificate proves, and remarks; and its verdict, which is the
//! certificate's.

use std::fmt;
use std::ops::Deref;

use luenberger_design::Certificate;
use luenberger_proof::Verdict;
use luenberger_proof::certificate::ProvedSentence;
use serde::{Serialize, Serializer};

/// Sentences on a design. What is proved is made by `luenberger-proof` of a proved theorem; all else is a remark: a
/// description, or a number that was computed or measured.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Statement {
    parts: Vec<Part>,
    /// All sentences, in their order.
    text: String,
}

#[derive(Debug, Clone, PartialEq)]
enum Part {
    Proved(ProvedSentence),
    Remark(String),
}

impl Part {
    fn text(&self) -> &str {
        match self {
            Self::Proved(sentence) => sentence.as_str(),
            Self::Remark(remark) => remark,
        }
    }
}

impl Statement {
    /// A remark alone.
    pub fn of(remark: impl Into<String>) -> Self {
        Self::default().remark(remark)
    }

    /// What is proved; that convergence is not, where nothing is.
    pub fn of_proved(sentences: impl IntoIterator<Item = ProvedSentence>) -> Self {
        let statement = Self::default().proved(sentences);
        if statement.parts.is_empty() { statement.remark("Convergence is not proved.") } else { statement }
    }

    /// With the sentences of proved theorems behind.
    #[must_use]
    pub fn proved(self, sentences: impl IntoIterator<Item = ProvedSentence>) -> Self {
        sentences.into_iter().fold(self, |all, sentence| all.with(Part::Proved(sentence)))
    }

    /// With a remark behind; an empty one changes nothing.
    #[must_use]
    pub fn remark(self, remark: impl Into<String>) -> Self {
        let remark = remark.into();
        if remark.is_empty() { self } else { self.with(Part::Remark(remark)) }
    }

    /// With all parts of another one behind.
    #[must_use]
    pub fn and(self, other: &Self) -> Self {
        other.parts.iter().cloned().fold(self, Self::with)
    }

    fn with(mut self, part: Part) -> Self {
        if !self.text.is_empty() {
            self.text.push(' ');
        }
        self.text.push_str(part.text());
        self.parts.push(part);
        self
    }

    /// The sentences that are proved.
    pub fn proved_sentences(&self) -> impl Iterator<Item = &ProvedSentence> {
        self.parts.iter().filter_map(|part| if let Part::Proved(sentence) = part { Some(sentence) } else { None })
    }

    /// The others.
    pub fn remarks(&self) -> impl Iterator<Item = &str> {
        self.parts.iter().filter_map(|part| if let Part::Remark(remark) = part { Some(remark.as_str()) } else { None })
    }
}

impl Deref for Statement {
    type Target = str;

    fn deref(&self) -> &str {
        &self.text
    }
}

impl fmt::Display for Statement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Serialize for Statement {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.text)
    }
}

/// The verdict on a design, or on one of its conditions. `proved` and `undecided` are those of a certificate, `refuted`
/// is that of a condition.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DesignVerdict(Word);

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Word {
    Proved,
    Refuted,
    Undecided,
    Measured,
    #[default]
    None,
}

impl DesignVerdict {
    /// No theorem certifies the observer; its errors were measured.
    pub const MEASURED: Self = Self(Word::Measured);

    /// No theorem certifies the observer.
    pub const NONE: Self = Self(Word::None);

    /// That of a certificate. A false inequality is one of its P, and says nothing about the observer: one that is
    /// shown to be unstable has no design.
    pub fn of(certificate: &Certificate) -> Self {
        Self(if certificate.is_proved() { Word::Proved } else { Word::Undecided })
    }

    /// That of an inequality.
    pub fn of_fact<W>(verdict: &Verdict<W>) -> Self {
        Self(match verdict {
            Verdict::Proved { .. } => Word::Proved,
            Verdict::Refuted { .. } => Word::Refuted,
            Verdict::Undecided { .. } => Word::Undecided,
        })
    }

    /// That of a condition that was verified over a whole region.
    pub(super) fn of_region() -> Self {
        Self(Word::Proved)
    }

    /// The verdicts on designs: the heading of a list of observers, and what it means.
    pub(crate) const MEANINGS: [(Self, &'static str, &'static str); 4] = [
        (
            Self(Word::Proved),
            "Proved",
            "The statement holds for the gains as stored: every condition was verified with all rounding errors enclosed.",
        ),
        (
            Self(Word::Undecided),
            "Undecided",
            "A condition is not verified with these numbers, which does not mean that the observer fails.",
        ),
        (Self::MEASURED, "Errors are measured, not proved", "Errors were measured in simulations; nothing is proved."),
        (Self::NONE, "No certificate", "No theorem certifies this observer for this plant."),
    ];

    /// The word in reports.
    pub fn word(self) -> &'static str {
        match self.0 {
            Word::Proved => "proved",
            Word::Refuted => "refuted",
            Word::Undecided => "undecided",
            Word::Measured => "measured",
            Word::None => "none",
        }
    }

    /// Whether all theorems of the certificate are proved, or the condition is.
    pub fn is_proved(self) -> bool {
        self.0 == Word::Proved
    }

    /// Whether a condition is verified to be false.
    pub fn is_refuted(self) -> bool {
        self.0 == Word::Refuted
    }
}

impl fmt::Display for DesignVerdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.word())
    }
}

impl Serialize for DesignVerdict {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.word())
    }
}
