//! What a kind declares of itself.

use crate::keys::Key;
use crate::reader::{Given, Reader};
use crate::study::{ObserverKind, PlantClass};

/// A kind of observer.
pub struct Declaration {
    /// Its name in study files.
    pub name: &'static str,
    /// What it is, as a sentence.
    pub about: &'static str,
    /// Where it is from: paper and equation.
    pub source: &'static str,
    /// The plants that it is for.
    pub plant: PlantClass,
    /// The keys of its `[[observer]]`, in groups: those that it shares with other kinds, and its own.
    pub keys: &'static [&'static [Key]],
    /// Its specification as a [`Kind`](super::Kind), by [`as_kind`](super::as_kind).
    pub kind: fn(&dyn std::any::Any) -> Option<&dyn super::Kind>,
    /// Its specification from these keys; none after a mistake, which the reader has.
    pub read: fn(&Given<'_>, &mut Reader) -> Option<ObserverKind>,
    /// Whether a design takes minutes.
    pub takes_long: bool,
    /// How `luenberger advise` tunes it.
    pub tuning: Tuning,
}

impl std::fmt::Debug for Declaration {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Declaration").field("name", &self.name).finish_non_exhaustive()
    }
}

/// How `luenberger advise` tunes a kind, or why it does not.
#[derive(Debug, Clone, Copy)]
pub enum Tuning {
    /// By each of these rules.
    Rules(&'static [Rule]),
    /// It is ranked where the study has one, for this reason.
    OfStudy(&'static str),
    /// It is not ranked, for this reason.
    Never(&'static str),
}

impl Tuning {
    /// That of observers whose maps no rule can find.
    pub(super) const MAPS_BY_HAND: Self = Self::OfStudy(
        "its maps are derived by hand, and the study specifies no such observer: see docs/kkl-studies.md",
    );
}

/// A tuning rule: prior information to the keys of an `[[observer]]`.
///
/// A rule tests hypotheses that the design does not name by itself; the design then decides.
#[derive(Clone, Copy)]
pub struct Rule {
    /// The name of its row.
    pub name: &'static str,
    /// When it is tried: quick designs first.
    pub turn: u8,
    /// The rule, as a sentence.
    pub tuning: &'static str,
    /// Where the rule is from.
    pub source: &'static str,
    /// What makes it good or bad, as an engineer would explain a result.
    pub character: &'static str,
    /// What it uses of the information.
    pub information: &'static [Information],
    /// The sets of keys to try in their order, or the hypothesis that does not hold.
    pub keys: fn(&Context<'_>) -> Result<Vec<Keys>, String>,
}

impl std::fmt::Debug for Rule {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Rule").field("name", &self.name).finish_non_exhaustive()
    }
}

pub use crate::tuning::{Context, InformationKind as Information, Keys, Value};
