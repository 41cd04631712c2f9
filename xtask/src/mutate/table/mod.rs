//! The mutants: formulas of the papers and of the theorems in `docs/theory-*.md` in their code form, and their changed
//! versions.

mod design;
mod observers;
mod proof;

use std::fmt;

use super::suite::{MODULES, Suite};

/// One change of one formula.
pub(super) struct Mutant {
    /// Its own name.
    pub(super) name: &'static str,
    pub(super) kind: Kind,
    /// Exactly once in its file.
    pub(super) fragment: &'static str,
    /// Of a changed sign none: the fragment has it.
    replacement: Option<&'static str>,
    /// Why no test can notice, where none can.
    pub(super) equivalent: Option<&'static str>,
}

/// The mutants of one file, and the tests that have to notice, the quick ones first.
pub(super) struct Source {
    pub(super) file: &'static str,
    pub(super) suites: &'static [Suite],
    pub(super) mutants: &'static [Mutant],
}

/// Defect of a mutant.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    Sign,
    Transpose,
    /// A factor or a term is missing.
    Dropped,
    /// Only the diagonal of a matrix, or a multiple of I, is used.
    OffDiagonal,
    /// Another number.
    Constant,
    /// Another matrix or vector in its place, or the factors in the other order.
    WrongOperand,
    /// A hypothesis is not checked, or another one is.
    Hypothesis,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Sign => "sign",
            Self::Transpose => "transpose",
            Self::Dropped => "dropped",
            Self::OffDiagonal => "off-diagonal",
            Self::Constant => "constant",
            Self::WrongOperand => "wrong operand",
            Self::Hypothesis => "hypothesis",
        })
    }
}

const fn mutant(name: &'static str, kind: Kind, fragment: &'static str, replacement: &'static str) -> Mutant {
    Mutant { name, kind, fragment, replacement: Some(replacement), equivalent: None }
}

/// The first operation of the fragment is the opposite one.
const fn sign(name: &'static str, fragment: &'static str) -> Mutant {
    Mutant { name, kind: Kind::Sign, fragment, replacement: None, equivalent: None }
}

/// The fragment is missing.
const fn dropped(name: &'static str, fragment: &'static str) -> Mutant {
    mutant(name, Kind::Dropped, fragment, "")
}

/// Operations and their opposites.
const OPPOSITES: [(&str, &str); 3] = [("+", "-"), (".plus(", ".minus("), (".sum(", ".difference(")];

impl Mutant {
    /// What takes the place of the fragment.
    pub(super) fn replacement(&self) -> String {
        if let Some(given) = self.replacement {
            return given.to_owned();
        }
        let both = OPPOSITES.into_iter().flat_map(|(one, other)| [(one, other), (other, one)]);
        let first = both.filter_map(|(one, other)| Some((self.fragment.find(one)?, one, other))).min();
        first.map_or_else(String::new, |(_, one, other)| self.fragment.replacen(one, other, 1))
    }

    const fn equivalent(self, reason: &'static str) -> Self {
        Self { equivalent: Some(reason), ..self }
    }
}

const OBSERVERS: Suite = Suite { package: "luenberger-observers-tests", binaries: &["--test", "it"], only: &[] };
const DESIGNS: Suite = Suite { package: MODULES, binaries: &["--test", "designs"], only: &[] };
const POSITIVE_REAL: Suite = Suite { package: MODULES, binaries: &["--test", "positive_real"], only: &[] };
const CUBIC: Suite = Suite { package: MODULES, binaries: &["--test", "cubic"], only: &[] };
const INPUT_TO_STATE: Suite = Suite { package: MODULES, binaries: &["--test", "input_to_state"], only: &[] };
const FILTERS: Suite = Suite { package: MODULES, binaries: &["--test", "filters"], only: &[] };
const INTERVAL: Suite = Suite { package: MODULES, binaries: &["--test", "interval"], only: &[] };
const SLIDING: Suite = Suite { package: MODULES, binaries: &["--test", "sliding_mode"], only: &[] };
const SAMPLED: Suite = Suite { package: MODULES, binaries: &["--test", "sampled"], only: &[] };
const UNCERTAIN: Suite = Suite { package: MODULES, binaries: &["--test", "uncertain"], only: &[] };
const OPTIMAL: Suite = Suite { package: MODULES, binaries: &["--test", "optimal_cubic"], only: &[] };
const MEAN_VALUE: Suite = Suite { package: MODULES, binaries: &["--test", "mean_value"], only: &[] };
const KKL: Suite = Suite { package: MODULES, binaries: &["--test", "kkl"], only: &[] };

const DEPLOYED: Suite = Suite { package: "luenberger-proof", binaries: &["--test", "it"], only: &["deployed::"] };
const LABELS: Suite = Suite { package: "luenberger-proof", binaries: &["--test", "it"], only: &["label::"] };
const LEFT_INVERSES: Suite =
    Suite { package: "luenberger-proof", binaries: &["--test", "it"], only: &["left_inverses::"] };
const SYSTEMS: Suite =
    Suite { package: "luenberger-proof", binaries: &["--test", "it"], only: &["left_inverses::", "equations::"] };
const TIMES: Suite =
    Suite { package: "luenberger-proof", binaries: &["--test", "it"], only: &["varying_periods::", "exponential::"] };
const RECORDINGS: Suite =
    Suite { package: "luenberger-expression", binaries: &["--test", "it"], only: &["recording::"] };
const KKL_BOUND: Suite = Suite { package: "luenberger-proof", binaries: &["--test", "it"], only: &["kkl::"] };

/// All of them.
pub(super) fn sources() -> impl Iterator<Item = &'static Source> {
    [observers::SOURCES, design::SOURCES, proof::SOURCES].into_iter().flatten()
}
