//! What a kind declares of itself.

use crate::kinds::ObserverKind;
use crate::read::{Given, Reader};
use crate::schema::Key;

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
    /// The keys of its `[[observer]]`.
    pub keys: &'static [Key],
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

/// Whether a kind takes plants that are linear only.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlantClass {
    /// Linear plants.
    Linear(Time),
    /// Linear plants, and the linearisation of others at the operating point of the study.
    AtPoint(Time),
    /// Nonlinear plants, linear ones among them.
    Nonlinear(Time),
}

/// The time of the plants that a kind takes, and whether their outputs may depend on the inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Time {
    /// Whether a plant may be in discrete time.
    pub discrete: bool,
    /// Whether an output may depend on an input.
    pub feedthrough: bool,
}

impl Time {
    /// Continuous or discrete time, any outputs.
    pub const ANY: Self = Self { discrete: true, feedthrough: true };
    /// Continuous time, any outputs.
    pub const CONTINUOUS: Self = Self { discrete: false, feedthrough: true };
    /// Continuous time, outputs of the state alone.
    pub const OF_STATE: Self = Self { discrete: false, feedthrough: false };
}

impl std::fmt::Display for PlantClass {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let which = match self {
            Self::Linear(_) => "linear",
            Self::AtPoint(_) => "linear, others at an operating point",
            Self::Nonlinear(_) => "any",
        };
        let Time { discrete, feedthrough } = self.time();
        let time = if discrete { "continuous or discrete time" } else { "continuous time" };
        let outputs = if feedthrough { "" } else { ", outputs of the state alone" };
        write!(f, "{which}; {time}{outputs}")
    }
}

impl PlantClass {
    /// Time and outputs.
    pub fn time(self) -> Time {
        match self {
            Self::Linear(time) | Self::AtPoint(time) | Self::Nonlinear(time) => time,
        }
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

pub use crate::advise::block::{Keys, Value};
pub use crate::advise::information::InformationKind as Information;
pub use crate::advise::tuning::Context;
