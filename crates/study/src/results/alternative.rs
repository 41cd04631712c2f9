//! Observers in place of one that is refused, and what may be one.

use serde::Serialize;

/// An observer that has a design, in place of one that has none.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Alternative(String);

impl Alternative {
    /// For the design that succeeded with these keys.
    pub(crate) fn designed(words: String) -> Self {
        Self(words)
    }

    /// The keys to write, what they take the place of, and what is obtained: `kind = "kalman", w = 1, v = 1: ..`,
    /// `lmi = true in place of poles: ..`.
    pub fn words(&self) -> &str {
        &self.0
    }
}

/// An observer, or a change of one, that may have a design.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Proposal {
    /// Lines of TOML.
    pub(crate) keys: Vec<String>,
    /// The keys of the refused observer that these take the place of; none for all.
    pub(crate) instead: Option<&'static [&'static str]>,
    /// Whether it is for the linearisation at an operating point, which the study does not name.
    pub(crate) at_point: bool,
    pub(crate) why: &'static str,
    /// A hint, if it is refused.
    pub(crate) otherwise: Option<&'static str>,
}

impl Proposal {
    /// Another kind, with these keys.
    pub(crate) fn kind(name: &str, keys: impl IntoIterator<Item = String>, why: &'static str) -> Self {
        let keys = [format!("kind = \"{name}\"")].into_iter().chain(keys).collect();
        Self { keys, instead: None, at_point: false, why, otherwise: None }
    }

    /// The same observer with these keys in place of others.
    pub(crate) fn keys(
        keys: impl IntoIterator<Item = String>,
        instead: &'static [&'static str],
        why: &'static str,
    ) -> Self {
        Self { keys: keys.into_iter().collect(), instead: Some(instead), at_point: false, why, otherwise: None }
    }

    /// With this hint, if it is refused.
    pub(crate) fn otherwise(self, hint: Option<&'static str>) -> Self {
        Self { otherwise: hint, ..self }
    }

    /// The same for the linearisation at an operating point.
    pub(crate) fn at_point(self) -> Self {
        Self { at_point: true, ..self }
    }
}

/// What a refusal proposes and says.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Advice {
    pub(crate) proposals: Vec<Proposal>,
    pub(crate) hints: Vec<String>,
}

impl Advice {
    pub(crate) fn hint(hint: impl Into<String>) -> Self {
        Self { proposals: Vec::new(), hints: vec![hint.into()] }
    }

    pub(crate) fn of(proposals: impl IntoIterator<Item = Proposal>) -> Self {
        Self { proposals: proposals.into_iter().collect(), hints: Vec::new() }
    }

    /// Both, this one first.
    pub(crate) fn and(mut self, other: Self) -> Self {
        self.proposals.extend(other.proposals);
        self.hints.extend(other.hints);
        self
    }
}
