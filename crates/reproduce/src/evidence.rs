//! Rules from evidence to verdict; verdicts are computed only here.
//!
//! | evidence | reproduced | refuted | underspecified |
//! |---|---|---|---|
//! | [`Evidence::Value`] | every entry within the tolerance | otherwise | never |
//! | [`Evidence::Holds`] | the truth found is the truth printed | otherwise | never |
//! | [`Evidence::Readings`] | every admissible reading agrees | none does | some do and some do not |
//! | [`Evidence::Proof`] | proved (where truth is printed) | refuted | undecided |
//! | [`Evidence::Counterexamples`] | never (where truth is printed) | one is valid: violated, and every hypothesis holds there | none is |
//! | [`Evidence::Cases`] | every case holds | one fails | none fails, but some are undecided, or there is none |
//!
//! A statement about all cases is not established by the cases of a run: for a theorem "reproduced" is either proved or
//! consistent with the instances tried, its [`Standing`].
//!
//! A statement is void where its hypotheses do not hold: evidence is underspecified if a hypothesis named with it fails
//! or is undecided.

use crate::value::{Printed, PrintedError, Value, short};
use luenberger_proof::Verdict as ProofVerdict;
use serde::Serialize;
use std::fmt;

/// Verdict on a claim. Computed by [`judge`] only.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The computed value agrees with the printed one.
    Reproduced,
    /// The computed value contradicts the printed one.
    Refuted,
    /// The paper does not specify enough: admissible readings disagree, or a proof is undecided.
    Underspecified,
}

impl Verdict {
    /// One word for tables, as in the JSON.
    pub fn word(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::Refuted => "refuted",
            Self::Underspecified => "underspecified",
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.word())
    }
}

/// What is known of a statement about all cases whose check agrees with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Standing {
    /// There is a proof, and a test of its statement.
    Proved,
    /// None of the instances that were tried contradicts it.
    Consistent,
}

impl Standing {
    /// That of a theorem with this verdict; none unless it is reproduced.
    pub fn of(verdict: Verdict, has_proof: bool) -> Option<Self> {
        (verdict == Verdict::Reproduced).then_some(if has_proof { Self::Proved } else { Self::Consistent })
    }

    /// One word for tables, as in the JSON.
    pub fn word(self) -> &'static str {
        match self {
            Self::Proved => "proved",
            Self::Consistent => "consistent",
        }
    }
}

/// Tolerance between a computed entry and the printed one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tolerance {
    /// Half a unit of the last printed digit of each entry; exact values must be met to rounding.
    AsPrinted,
    /// The same distance for every entry, in its unit.
    Absolute(f64),
    /// A multiple of the absolute value of each printed entry.
    Relative(f64),
}

/// Result of a check. Everything except the numbers is derived from it by [`judge`].
#[derive(Debug, Clone, PartialEq)]
pub enum Evidence {
    /// A value to be compared with the printed one, entry by entry.
    Value(Value),
    /// A statement that was tested, and the quantity that decided it (shown as computed in the ledger).
    Holds {
        /// The truth value found.
        holds: bool,
        /// The quantity that decided, if it is worth showing.
        measured: Option<Value>,
    },
    /// The paper is ambiguous. Each admissible reading, named by its assumption, gives a value (or a truth value).
    Readings(Vec<(&'static str, Value)>),
    /// A statement verified by `luenberger-proof`.
    Proof(Proof),
    /// Candidate counterexamples to a general statement of the paper. A valid one refutes it.
    Counterexamples(Vec<Counterexample>),
    /// A general statement tested on many cases.
    Cases {
        /// Number of cases that hold.
        hold: usize,
        /// Number of cases that fail.
        fail: usize,
        /// Number of undecided cases.
        undecided: usize,
    },
}

/// A candidate counterexample to a general statement of the paper.
#[derive(Debug, Clone, PartialEq)]
pub struct Counterexample {
    /// The case in a few words, empty where there is only one.
    pub case: String,
    /// The violated inequality and where it is evaluated, in one line.
    pub what: String,
    /// Amount of the violation; if it is not positive, the statement is not violated.
    pub violation: f64,
    /// The data of the case, for instance an initial error.
    pub witness: Option<Value>,
    /// Every hypothesis of the statement, evaluated for this case.
    pub hypotheses: Vec<Hypothesis>,
}

impl Counterexample {
    /// Whether the statement is violated and every hypothesis of it holds.
    pub fn is_valid(&self) -> bool {
        self.violation > 0.0 && self.hypotheses.iter().all(|hypothesis| hypothesis.holds == Some(true))
    }
}

/// A hypothesis of a theorem, evaluated: `null` in JSON if undecided.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Hypothesis {
    /// The case for which it is evaluated, empty if there is only one.
    pub case: String,
    /// The hypothesis as in the paper.
    pub hypothesis: String,
    /// Whether it holds; absent if undecided.
    pub holds: Option<bool>,
    /// The method of evaluation, and the set where it holds if not everywhere.
    pub how: String,
}

impl Hypothesis {
    /// Decided by `luenberger-proof`.
    pub fn proof<W: fmt::Display>(hypothesis: &str, verdict: &ProofVerdict<W>) -> Self {
        let (holds, how) = match verdict {
            ProofVerdict::Proved { margin } => (Some(true), format!("proved, with margin {}", short(*margin))),
            ProofVerdict::Refuted { witness } => (Some(false), format!("refuted by {witness}")),
            ProofVerdict::Undecided { why, .. } => (None, format!("undecided: {why}")),
        };
        Self { case: String::new(), hypothesis: hypothesis.to_owned(), holds, how }
    }

    /// Decided by comparing numbers exactly, or within their rounding errors; `how` names them.
    pub fn computed(hypothesis: &str, holds: bool, how: impl Into<String>) -> Self {
        Self { case: String::new(), hypothesis: hypothesis.to_owned(), holds: Some(holds), how: how.into() }
    }

    /// The same, where it was evaluated on this set only.
    #[must_use]
    pub fn only(mut self, domain: &str) -> Self {
        self.how.push_str(", ");
        self.how.push_str(domain);
        self
    }

    /// `holds`, `fails` or `undecided`.
    pub fn word(&self) -> &'static str {
        match self.holds {
            Some(true) => "holds",
            Some(false) => "fails",
            None => "undecided",
        }
    }
}

/// A proof verdict with its witness as text.
#[derive(Debug, Clone, PartialEq)]
pub enum Proof {
    /// Proved with this margin.
    Proved(f64),
    /// Refuted; the words describe the witness.
    Refuted(String),
    /// Undecided; the text has the reason.
    Undecided(String),
}

impl Evidence {
    /// A value to be compared with the printed one.
    pub fn value(value: impl Into<Value>) -> Self {
        Self::Value(value.into())
    }

    /// A statement that was tested.
    pub fn holds(holds: bool) -> Self {
        Self::Holds { holds, measured: None }
    }

    /// A statement that was tested, with the quantity that decided it.
    pub fn holds_by(holds: bool, measured: impl Into<Value>) -> Self {
        Self::Holds { holds, measured: Some(measured.into()) }
    }

    /// A verdict of `luenberger-proof` on the statement as printed.
    pub fn proof<W: fmt::Display>(verdict: &ProofVerdict<W>) -> Self {
        Self::Proof(match verdict {
            ProofVerdict::Proved { margin } => Proof::Proved(*margin),
            ProofVerdict::Refuted { witness } => Proof::Refuted(witness.to_string()),
            ProofVerdict::Undecided { why, .. } => Proof::Undecided(why.to_string()),
        })
    }

    /// A single counterexample, with every hypothesis of the statement evaluated for it.
    pub fn counterexample(
        what: impl Into<String>,
        violation: f64,
        witness: Option<Value>,
        hypotheses: Vec<Hypothesis>,
    ) -> Self {
        let case = Counterexample { case: String::new(), what: what.into(), violation, witness, hypotheses };
        Self::Counterexamples(vec![case])
    }

    /// The hypotheses that its counterexamples evaluate, each with the name of its case.
    pub fn hypotheses(&self) -> Vec<Hypothesis> {
        let Self::Counterexamples(cases) = self else { return Vec::new() };
        let named = |case: &Counterexample| {
            let name = case.case.clone();
            case.hypotheses.clone().into_iter().map(move |found| Hypothesis { case: name.clone(), ..found })
        };
        cases.iter().flat_map(named).collect()
    }

    /// The cases of a general statement, counted from the truths found (`None` is undecided).
    pub fn cases(truths: impl IntoIterator<Item = Option<bool>>) -> Self {
        let (mut hold, mut fail, mut undecided) = (0, 0, 0);
        for truth in truths {
            *match truth {
                Some(true) => &mut hold,
                Some(false) => &mut fail,
                None => &mut undecided,
            } += 1;
        }
        Self::Cases { hold, fail, undecided }
    }
}

/// The verdict with its basis.
#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    /// The printed value as numbers.
    pub printed: Value,
    /// The computed value shown in the ledger: of several readings, the first that agrees, otherwise the first.
    pub computed: Value,
    /// The tolerance of each entry: one number if all are equal; absent for truths.
    pub tolerance: Option<Value>,
    /// The verdict.
    pub verdict: Verdict,
    /// Details of the evidence: the readings with their values, a margin, a witness, counts.
    pub remarks: Vec<String>,
}

/// Evidence that cannot be compared with the printed value.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum JudgeError {
    /// The printed value could not be read.
    #[error(transparent)]
    Printed(#[from] PrintedError),
    /// A number was computed where a truth is printed, or the shapes differ.
    #[error("printed is {}, computed is {}", describe(.printed), describe(.computed))]
    Incomparable {
        /// The printed value.
        printed: Value,
        /// The computed value.
        computed: Value,
    },
    /// The tolerance is negative or not finite.
    #[error("the tolerance {0} is not a finite number >= 0")]
    Tolerance(f64),
    /// The claim has no readings to compare.
    #[error("the evidence lists no reading")]
    NoReadings,
}

fn describe(value: &Value) -> String {
    match value {
        Value::Truth(_) => "a truth value".to_owned(),
        Value::Number(_) => "a number".to_owned(),
        Value::Vector(v) => format!("a vector of {}", v.len()),
        Value::Matrix(_) => format!("a {} x {} matrix", value.shape().0, value.shape().1),
    }
}

/// The verdict on `evidence`, given the printed value and its tolerance.
///
/// A computed entry that is not finite never agrees. The comparison grants two units of rounding of the printed entry,
/// because a decimal such as 1.2 + 0.05 is not a binary number.
/// # Errors
/// [`JudgeError`] if the two cannot be compared: an error in the claim, not a verdict on the paper.
pub fn judge(printed: &Printed, tolerance: Tolerance, evidence: &Evidence) -> Result<Judgement, JudgeError> {
    let reading = printed.read()?;
    let printed = reading.value;
    let expected = printed.entries();
    let tolerances = match tolerance {
        Tolerance::AsPrinted => reading.half_units,
        Tolerance::Absolute(t) => vec![checked(t)?; expected.len()],
        Tolerance::Relative(t) => {
            let t = checked(t)?;
            expected.iter().map(|x| t * x.abs()).collect()
        }
    };
    let agrees = |computed: &Value| match (&printed, computed) {
        (Value::Truth(said), Value::Truth(found)) => Ok(said == found),
        _ if !printed.comparable(computed) => {
            Err(JudgeError::Incomparable { printed: printed.clone(), computed: computed.clone() })
        }
        _ => Ok(expected
            .iter()
            .zip(computed.entries())
            .zip(&tolerances)
            .all(|((&p, c), &t)| (c - p).abs() <= t + 2.0 * f64::EPSILON * p.abs())),
    };
    let said = match printed {
        Value::Truth(said) => Ok(said),
        _ => Err(JudgeError::Incomparable { printed: printed.clone(), computed: Value::Truth(true) }),
    };
    let decide = |found: Option<bool>, said: bool| match found {
        Some(found) if found == said => Verdict::Reproduced,
        Some(_) => Verdict::Refuted,
        None => Verdict::Underspecified,
    };
    // A statement that stayed undecided computed no truth; the ledger shows a number that is not one (null in JSON).
    let shown = |found: Option<bool>| found.map_or(Value::Number(f64::NAN), Value::Truth);
    let (verdict, computed, remarks) = match evidence {
        Evidence::Value(value) => {
            let verdict = if agrees(value)? { Verdict::Reproduced } else { Verdict::Refuted };
            (verdict, value.clone(), Vec::new())
        }
        Evidence::Holds { holds, measured } => {
            (decide(Some(*holds), said?), measured.clone().unwrap_or(Value::Truth(*holds)), Vec::new())
        }
        Evidence::Readings(readings) => {
            let truths = readings.iter().map(|(_, value)| agrees(value)).collect::<Result<Vec<_>, _>>()?;
            let first = truths.iter().position(|&t| t).unwrap_or(0);
            let computed = readings.get(first).ok_or(JudgeError::NoReadings)?.1.clone();
            let verdict = match (truths.contains(&true), truths.contains(&false)) {
                (true, false) => Verdict::Reproduced,
                (true, true) => Verdict::Underspecified,
                _ => Verdict::Refuted,
            };
            let remarks = readings
                .iter()
                .zip(&truths)
                .map(|((assumption, value), agrees)| {
                    format!("Reading: {assumption}: {value}, {}.", if *agrees { "agrees" } else { "does not agree" })
                })
                .collect();
            (verdict, computed, remarks)
        }
        Evidence::Proof(proof) => {
            let (found, remark) = match proof {
                Proof::Proved(margin) => (Some(true), format!("Proved, with margin {}.", short(*margin))),
                Proof::Refuted(witness) => (Some(false), format!("Refuted by {witness}.")),
                Proof::Undecided(why) => (None, format!("Undecided: {why}.")),
            };
            (decide(found, said?), shown(found), vec![remark])
        }
        Evidence::Counterexamples(cases) => {
            let found = cases.iter().any(Counterexample::is_valid).then_some(false);
            (decide(found, said?), shown(found), cases.iter().map(remark).collect())
        }
        Evidence::Cases { hold, fail, undecided } => {
            let found = match (hold, fail, undecided) {
                (0, 0, _) => None,
                (_, 0, 0) => Some(true),
                (_, 0, _) => None,
                _ => Some(false),
            };
            let total = hold + fail + undecided;
            let remark = format!("{total} cases: {hold} hold, {fail} fail, {undecided} undecided.");
            (decide(found, said?), shown(found), vec![remark])
        }
    };
    let tolerance = match (&printed, tolerances.first()) {
        (Value::Truth(_), _) | (_, None) => None,
        (_, Some(&first)) if tolerances.iter().all(|&t| t == first) => Some(Value::Number(first)),
        (Value::Matrix(rows), _) => {
            let width = rows.first().map_or(1, Vec::len).max(1);
            Some(Value::Matrix(tolerances.chunks(width).map(<[f64]>::to_vec).collect()))
        }
        _ => Some(Value::Vector(tolerances)),
    };
    Ok(Judgement { printed, computed, tolerance, verdict, remarks })
}

/// The text of a counterexample.
fn remark(example: &Counterexample) -> String {
    let Counterexample { case, what, violation, witness, hypotheses } = example;
    let name = if case.is_empty() { String::new() } else { format!(", {case}") };
    let at = witness.as_ref().map_or_else(String::new, |w| format!(" at {w}"));
    let size = short(*violation);
    // Not a number violates nothing.
    if violation.is_nan() || *violation <= 0.0 {
        return format!("No counterexample{name}{at}: {what} is not violated ({size}).");
    }
    match hypotheses.iter().find(|hypothesis| hypothesis.holds != Some(true)) {
        None => format!("Counterexample{name}{at}: {what}, violated by {size}."),
        Some(open) => format!(
            "No counterexample{name}{at}: {what}, violated by {size}, but the hypothesis \"{}\": {} ({}).",
            open.hypothesis,
            open.word(),
            open.how
        ),
    }
}

impl Judgement {
    /// The same judgement if these hypotheses of the statement were evaluated: where they fail, the statement is void.
    #[must_use]
    pub fn under(mut self, hypotheses: &[Hypothesis]) -> Self {
        if let Some(open) = hypotheses.iter().find(|hypothesis| hypothesis.holds != Some(true)) {
            self.remarks.push(format!(
                "Not {}, because the hypothesis \"{}\" {} here ({}).",
                self.verdict,
                open.hypothesis,
                if open.holds.is_none() { "stays undecided" } else { "fails" },
                open.how
            ));
            self.verdict = Verdict::Underspecified;
        }
        self
    }
}

fn checked(tolerance: f64) -> Result<f64, JudgeError> {
    if tolerance.is_finite() && tolerance >= 0.0 { Ok(tolerance) } else { Err(JudgeError::Tolerance(tolerance)) }
}
