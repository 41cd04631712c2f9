//! What the crate says of a matrix, held against what is true of it.

use luenberger_proof::{
    Direction, Entry, Matrix, UndecidedReason, Verdict, negative_definite, negative_semidefinite, positive_definite,
    positive_semidefinite,
};

use super::oracle::{Inertia, Integers, Spectrum};

/// Which definiteness was asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sense {
    PositiveDefinite,
    PositiveSemidefinite,
    NegativeDefinite,
    NegativeSemidefinite,
}

pub(crate) const SENSES: [Sense; 4] =
    [Sense::PositiveDefinite, Sense::PositiveSemidefinite, Sense::NegativeDefinite, Sense::NegativeSemidefinite];

impl Sense {
    pub(crate) fn is_negated(self) -> bool {
        matches!(self, Self::NegativeDefinite | Self::NegativeSemidefinite)
    }

    pub(crate) fn is_strict(self) -> bool {
        matches!(self, Self::PositiveDefinite | Self::NegativeDefinite)
    }

    pub(crate) fn is_true(self, inertia: Inertia) -> bool {
        let against = if self.is_negated() { inertia.positive } else { inertia.negative };
        against == 0 && (!self.is_strict() || inertia.zero == 0)
    }
}

/// Asks.
pub(crate) fn ask<T: Entry>(m: &Matrix<T>, sense: Sense) -> Verdict<Direction> {
    match sense {
        Sense::PositiveDefinite => positive_definite(m),
        Sense::PositiveSemidefinite => positive_semidefinite(m),
        Sense::NegativeDefinite => negative_definite(m),
        Sense::NegativeSemidefinite => negative_semidefinite(m),
    }
    .expect("symmetric and finite")
}

/// What verdicts were given, and which of them are wrong.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tally {
    pub(crate) cases: u64,
    pub(crate) proved: u64,
    pub(crate) refuted: u64,
    pub(crate) undecided: u64,
    /// Undecided although the truth is known and the data are single numbers, or the same for every matrix within the
    /// intervals.
    pub(crate) missed: u64,
    pub(crate) wrong: Vec<String>,
}

impl Tally {
    pub(crate) fn add(&mut self, other: Self) {
        self.cases += other.cases;
        self.proved += other.proved;
        self.refuted += other.refuted;
        self.undecided += other.undecided;
        self.missed += other.missed;
        self.wrong.extend(other.wrong);
    }

    /// Counts a verdict, of which `fault` says what is wrong with it.
    pub(crate) fn count<W: std::fmt::Debug>(
        &mut self,
        verdict: &Verdict<W>,
        could_be_decided: bool,
        what: impl std::fmt::Debug,
        fault: Option<&'static str>,
    ) {
        match verdict {
            Verdict::Proved { .. } => self.proved += 1,
            Verdict::Refuted { .. } => self.refuted += 1,
            Verdict::Undecided { .. } => {
                self.undecided += 1;
                self.missed += u64::from(could_be_decided);
            }
        }
        if let Some(fault) = fault {
            self.wrong.push(format!("{fault}: {verdict:?} of {what:?}"));
        }
    }
}

/// A symmetric matrix with its truth.
pub(crate) struct Judged {
    pub(crate) m: Integers,
    pub(crate) spectrum: Spectrum,
    pub(crate) inertia: Inertia,
}

impl Judged {
    pub(crate) fn of(m: Integers) -> Self {
        let spectrum = Spectrum::of(&m);
        let inertia = spectrum.inertia();
        Self { m, spectrum, inertia }
    }

    /// What is wrong with a verdict on this matrix.
    pub(crate) fn fault(&self, verdict: &Verdict<Direction>, sense: Sense) -> Option<&'static str> {
        let truth = sense.is_true(self.inertia);
        match verdict {
            Verdict::Proved { .. } if !truth => Some("wrongly proved"),
            Verdict::Proved { margin } => (!self.has_margin(*margin, sense)).then_some("a margin above the truth"),
            Verdict::Refuted { .. } if truth => Some("wrongly refuted"),
            Verdict::Refuted { witness } => (!refutes(&self.m, witness, sense)).then_some("a witness of nothing"),
            Verdict::Undecided { why: UndecidedReason::DataTooUncertain { .. }, .. } => {
                Some("uncertain of numbers that are given")
            }
            Verdict::Undecided { .. } => None,
        }
    }

    fn has_margin(&self, margin: f64, sense: Sense) -> bool {
        if !(margin >= 0.0 && margin.is_finite()) {
            return false;
        }
        let spectrum = if sense.is_negated() { self.spectrum.negative() } else { self.spectrum.clone() };
        spectrum.lowered(margin).inertia().negative == 0
    }
}

/// Whether `v'Mv <= value`, and the value is of the sign that refutes.
pub(crate) fn refutes(m: &Integers, witness: &Direction, sense: Sense) -> bool {
    let v = witness.exact.as_ref().map_or_else(|| Integers::column(&witness.v), |v| Integers::exact_column(v));
    let form = v.transpose().times(m).times(&v);
    let form = if sense.is_negated() { form.negative() } else { form };
    let against = form.sign() < 0 || (sense.is_strict() && form.sign() == 0);
    !v.is_zero() && against && bounds(witness.value, &form)
}

/// Whether a value, perhaps infinite, is at least as large as the number.
pub(crate) fn bounds(value: f64, form: &Integers) -> bool {
    value == f64::INFINITY || (value.is_finite() && Integers::scalar(1, value).minus(form).sign() >= 0)
}
