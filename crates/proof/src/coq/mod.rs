//! Certificates as files for the proof assistant Coq, whose kernel then confirms them.
//!
//! The file that [`theorems`] writes has the certificate's numbers, as they are, and a `Theorem` for each claim, closed
//! by the checker of the folder `proofs/` of the repository, which is proved correct there. What this module does is
//! therefore not trusted to prove anything: a number that it copied wrongly, or a margin that is too large, is refused
//! by Coq or is visible in the file. It chooses the numbers that the proofs need in addition: bounds of the eigenvalues
//! of P, a rate of decay where the certificate names none.

mod bounds;
mod cubic;
pub mod cubic_paper;
mod deployed;
mod discrete;
mod feedback;
mod linear;
mod polytope;
mod sampled;

use std::fmt::Write as _;

use cubic::MOST_OUTPUTS;
use thiserror::Error;

use crate::certificate::{CertificateFile, Fact, Rejection, Theorem, Witness};
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::number::{Datum, Number};
use crate::statement::{largest_eigenvalue_bound, overshoot_bound};
use crate::verdict::Verdict;

/// A file for Coq.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CoqFile {
    /// The text.
    pub text: String,
    /// The names of its theorems.
    pub theorems: Vec<String>,
    /// Whether the certificate is false: its theorems then are the refutations, and the facts that hold.
    pub is_refuted: bool,
}

/// Why a certificate has no file for Coq.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CoqError {
    /// The certificate is rejected, and not for an inequality that is false.
    #[error(transparent)]
    Rejected(#[from] Rejection),
    /// No theorem of `proofs/` has this statement.
    #[error(
        "the theorem \"{theorem}\" has no proof in Coq: of {} there is one",
        KINDS.map(|kind| format!("\"{kind}\"")).join(", ")
    )]
    Kind {
        /// Its name.
        theorem: &'static str,
    },
    /// Entries that stand for all numbers between two.
    #[error(
        "{matrix} has an entry that stands for all numbers between two bounds, which the proofs in Coq do not cover"
    )]
    Bounds {
        /// The matrix.
        matrix: &'static str,
    },
    /// The stored cubic gain.
    #[error(
        "for the stored N no Lyapunov matrix with P N = -C'S exactly is found that has room (it is sought for up to {MOST_OUTPUTS} outputs and an N of full column rank)"
    )]
    StoredGain,
    /// An inequality holds with so little room that binary64 has no margin for it.
    #[error("{inequality} is proved with the margin 0, and the proofs in Coq need a positive one")]
    NoMargin {
        /// The inequality.
        inequality: String,
    },
}

impl From<ProofError> for CoqError {
    fn from(error: ProofError) -> Self {
        Self::Rejected(error.into())
    }
}

/// The theorems of certificates that are proved in Coq.
pub const KINDS: [&str; 11] = [
    "linear-observer",
    "discrete-observer",
    "cubic-observer",
    "cubic-observer-with-structured-gain",
    "cubic-observer-theorem-1",
    "sampled-cubic-observer",
    "feedback-loop",
    "polytope-of-plants",
    "polytope-of-jacobians",
    "discrete-polytope-of-jacobians",
    "deployed-observer",
];

/// The certificate as a file for Coq: of a proved one the facts with their margins and the statement about all
/// trajectories, of one with inequalities that are false a theorem for each of these, with a vector that shows it.
///
/// # Errors
/// [`CoqError`]: a certificate that is rejected for another reason, or is none of those that are proved in Coq.
/// ```
/// use luenberger_proof::certificate::{CertificateFile, DiscreteConvergence, PlantMatrices};
/// use luenberger_proof::{Matrix, coq};
///
/// let [a, b, c] = [0.5, 1.0, 1.0].map(|entry| Matrix::from_rows([[entry]]));
/// let (l, p) = (Matrix::from_rows([[0.25]]), Matrix::from_rows([[1.0]]));
/// let theorem = DiscreteConvergence { plant: PlantMatrices { a, b, c }, l, p, factor: None };
/// let file = coq::theorems(&CertificateFile::prove("a tank", theorem)?)?;
/// assert!(file.text.contains("Definition L : list (list Q) := [\n  [0x1p-2]]."));
/// assert_eq!(file.theorems, ["P_is_positive_definite", "stein_inequality", "every_error", "observer"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn theorems(file: &CertificateFile) -> Result<CoqFile, CoqError> {
    let theorem = file.theorem();
    if !KINDS.contains(&theorem.name()) {
        return Err(CoqError::Kind { theorem: theorem.name() });
    }
    let (facts, rejection) = match file.check() {
        Ok(proved) => (proved.facts, None),
        Err(rejection @ Rejection::NotProved { .. }) if is_refutable(theorem, &rejection) => {
            (theorem.facts()?, Some(rejection))
        }
        Err(rejection) => return Err(rejection.into()),
    };
    let is_refuted = facts.iter().any(|fact| !fact.verdict.is_proved());
    let mut out = Out::new();
    // The claims of a certificate that is false have not been decided.
    let claims = if is_refuted { &[] } else { file.claims() };
    let claimed: Vec<Number> = claims.iter().map(|claim| claim.margin.clone()).collect();
    match theorem {
        Theorem::LinearConvergence(linear) => out.linear(linear, &facts, &claimed)?,
        Theorem::DiscreteConvergence(discrete) => out.discrete(discrete, &facts, &claimed)?,
        Theorem::CubicConvergence(cubic) => out.cubic(cubic, &facts, &claimed).map(|_| ())?,
        Theorem::StructuredCubicConvergence(cubic) => out.structured(cubic, &facts, &claimed)?,
        Theorem::SampledCubicConvergence(sampled) => out.sampled(sampled, &facts, &claimed)?,
        Theorem::PlantPolytope(plants) => {
            out.polytope(&plants.vertices, [&plants.l, &plants.p], plants.rate, &facts, &claimed)?;
        }
        Theorem::JacobianPolytope(jacobians) => {
            out.polytope(&jacobians.vertices, [&jacobians.l, &jacobians.p], jacobians.rate, &facts, &claimed)?;
        }
        Theorem::DiscreteJacobianPolytope(jacobians) => out.discrete_polytope(jacobians, &facts, &claimed)?,
        Theorem::DeployedObserver(deployed) => out.deployed(deployed, &facts, &claimed)?,
        Theorem::CubicTheorem1(cubic) => out.theorem1(cubic, &facts, &claimed)?,
        Theorem::FeedbackLoop(feedback) => out.feedback(feedback, &facts, &claimed)?,
        other => return Err(CoqError::Kind { theorem: other.name() }),
    }
    let Out { numbers, proved, theorems, refutes } = out;
    // Of data between bounds, no matrices are found for which an inequality is false.
    if let Some(rejection) = rejection.filter(|_| !refutes) {
        return Err(rejection.into());
    }
    let text = format!("{}{numbers}\nLocal Open Scope R_scope.\n{proved}", head(file, is_refuted));
    Ok(CoqFile { text, theorems, is_refuted })
}

/// Whether a refutation may be found: of an inequality that is false, or that is undecided for all data between bounds.
fn is_refutable(theorem: &Theorem, rejection: &Rejection) -> bool {
    match rejection {
        Rejection::NotProved { verdict, .. } => {
            matches!(**verdict, Verdict::Refuted { .. }) || bounds::has_bounds(theorem)
        }
        _ => false,
    }
}

/// The two parts of a file.
struct Out {
    /// The certificate's numbers, and those of the proof.
    numbers: String,
    /// The theorems about them.
    proved: String,
    /// The names of the theorems.
    theorems: Vec<String>,
    /// Whether one of them is a refutation.
    refutes: bool,
}

/// A text from outside, in a comment: neither its end nor the beginning of a string, which Coq reads there too.
fn quiet(text: &str) -> String {
    luenberger_wording::visible(text).replace('"', "'").replace("(*", "( *").replace("*)", "* )")
}

/// Numbers of binary64, as the certificate writes them.
fn points(m: &Matrix<f64>) -> Result<Matrix<Number>, ProofError> {
    let mut entries = Vec::with_capacity(m.as_slice().len());
    for (k, &value) in m.as_slice().iter().enumerate() {
        let (row, column) = (k / m.cols(), k % m.cols());
        let not_finite = ProofError::NotFinite { what: "a matrix", row, column, value };
        entries.push(Number::from_f64(value).ok_or(not_finite)?);
    }
    Matrix::from_row_major(m.rows(), m.cols(), entries)
}

/// Data of which each entry is one number.
fn single(m: &Matrix<Datum>, matrix: &'static str) -> Result<Matrix<Number>, CoqError> {
    let numbers = m.as_slice().iter().map(|datum| match datum {
        Datum::Number(number) if datum.is_point() => Some(number.clone()),
        _ => None,
    });
    let numbers: Option<Vec<Number>> = numbers.collect();
    Ok(Matrix::from_row_major(m.rows(), m.cols(), numbers.ok_or(CoqError::Bounds { matrix })?)?)
}

/// The margin that is claimed, or where that is 0 the one that is proved.
fn margin(fact: &Fact, claimed: Option<&Number>) -> Result<Number, CoqError> {
    let claimed = claimed.filter(|number| number.enclosure().lo() > 0.0);
    let proved = || Number::from_f64(fact.verdict.margin()?).filter(|number| number.enclosure().lo() > 0.0);
    claimed.cloned().or_else(proved).ok_or_else(|| CoqError::NoMargin { inequality: fact.inequality.clone() })
}

/// Numbers that bound V by the norm: `lower I <= P <= upper I` and `upper <= overshoot^2 lower`.
struct Between {
    lower: f64,
    upper: f64,
    overshoot: f64,
}

impl Between {
    fn of(p: &Matrix<f64>, fact: &Fact) -> Result<Self, CoqError> {
        let (lower, upper) = (fact.verdict.margin().unwrap_or(0.0), largest_eigenvalue_bound(p));
        let overshoot = overshoot_bound(p)?;
        if lower > 0.0 && upper.is_finite() && overshoot.is_finite() {
            Ok(Self { lower, upper, overshoot })
        } else {
            Err(CoqError::NoMargin { inequality: fact.inequality.clone() })
        }
    }
}

/// The beginning of a file: what it is about, and what it needs.
fn head(file: &CertificateFile, is_refuted: bool) -> String {
    let said = if is_refuted { "The certificate is false. It says" } else { "The certificate says" };
    format!(
        "(** {}\n\n    {said}: {}\n\n    To check it where proofs/ of luenberger is compiled: coqc -R proofs Luenberger FILE.v *)\n\n\
         From Coq Require Import Reals QArith Qreals List.\n\
         From Luenberger Require Import Vectors Definite Inequalities Decay LinearObserver Existence Boxes DiscreteObserver\n  CubicObserver CubicRegion SampledCubic FeedbackLoop CubicExistence LoopRegion Polytope\n  BoxPolytope DiscretePolytope DiscreteBoxPolytope Refuted BoxRefuted\n  Perturbed.\n\
         Import ListNotations.\n\n\
         Local Coercion Q2R : Q >-> R.\n\
         Local Open Scope Q_scope.\n",
        quiet(file.title()),
        quiet(file.statement())
    )
}

/// What is concluded of a solution e in continuous time, with the matrix and the numbers of this suffix.
fn says(n: usize, suffix: &str) -> String {
    let [p, decay, overshoot] = ["P", "decay", "overshoot"].map(|name| format!("{name}{suffix}"));
    format!(
        "(forall s t, 0 <= s -> s <= t -> t < T ->\n    \
         quadratic {n} {p} (e t) <= exp (- (2 * {decay}) * (t - s)) * quadratic {n} {p} (e s))\n  \
         /\\ (forall t, 0 <= t -> t < T -> norm {n} (e t) <= {overshoot} * exp (- {decay} * t) * norm {n} (e 0))"
    )
}

impl Out {
    fn new() -> Self {
        Self { numbers: String::new(), proved: String::new(), theorems: Vec::new(), refutes: false }
    }

    /// A matrix of numbers, a row to a line.
    fn matrix(&mut self, name: &str, m: &Matrix<Number>, what: &str) {
        let row = |i: usize| m.row(i).iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
        let rows: Vec<String> = (0..m.rows()).map(|i| format!("[{}]", row(i))).collect();
        let rows = rows.join(";\n  ");
        _ = write!(self.numbers, "\n(** {what} *)\nDefinition {name} : list (list Q) := [\n  {rows}].\n");
    }

    fn number(&mut self, name: &str, number: &Number, what: &str) {
        _ = write!(self.numbers, "\n(** {what} *)\nDefinition {name} : Q := {number}.\n");
    }

    fn float(&mut self, name: &str, x: f64, what: &str) -> Result<(), CoqError> {
        let what_is = ProofError::Sign { what: "a number of the proof", value: x };
        self.number(name, &Number::from_f64(x).ok_or(what_is)?, what);
        Ok(())
    }

    fn lemma(&mut self, name: &str, statement: &str) {
        _ = write!(self.proved, "\nLemma {name} : {statement} = true.\nProof. vm_cast_no_check (eq_refl true). Qed.\n");
    }

    fn theorem(&mut self, name: &str, what: &str, statement: &str, proof: &str) {
        self.theorems.push(name.to_owned());
        _ = write!(self.proved, "\n(** {what} *)\nTheorem {name} :\n  {statement}.\nProof. {proof} Qed.\n");
    }

    /// The vector of a refutation, as a column; none where the fact is not refuted.
    fn witness(&mut self, name: &str, fact: &Fact) -> Result<bool, CoqError> {
        let Verdict::Refuted { witness: Witness::Direction(direction) } = &fact.verdict else { return Ok(false) };
        let numbers = match &direction.exact {
            Some(exact) => exact.iter().cloned().map(Number::from).collect(),
            None => points(&Matrix::from_row_major(direction.v.len(), 1, direction.v.clone())?)?.as_slice().to_vec(),
        };
        let column = Matrix::from_row_major(numbers.len(), 1, numbers)?;
        self.matrix(name, &column, &format!("A vector that shows that {} is false.", fact.inequality));
        self.refutes = true;
        Ok(true)
    }

    /// The matrices that both times have, B as the plant has it.
    fn plant(&mut self, [a, b, c]: [&Matrix<Number>; 3], l: &Matrix<f64>, p: &Matrix<f64>) -> Result<(), CoqError> {
        let (states, inputs, outputs) = (a.rows(), b.cols(), c.rows());
        self.matrix("A", a, &format!("The state matrix of the plant, {states} x {states}."));
        self.matrix("B", b, &format!("The input matrix, {states} x {inputs}."));
        self.matrix("C", c, &format!("The output matrix, {outputs} x {states}."));
        self.matrix("L", &points(l)?, "The gain of the observer.");
        self.matrix("P", &points(p)?, "The matrix of V = e'Pe.");
        Ok(())
    }

    /// `P > 0`, proved or refuted, for the matrix with this name.
    fn positive(&mut self, n: usize, p: &str, fact: &Fact, claimed: Option<&Number>) -> Result<(), CoqError> {
        let (margin, vector) = (format!("margin_{p}"), format!("v_{p}"));
        if fact.verdict.is_proved() {
            let statement =
                format!("0 < {margin} /\\ forall v : vector, {margin} * square {n} v <= quadratic {n} {p} v");
            let what = format!("{p} > 0: v'{p} v is at least the margin times |v|^2.");
            let proof = format!("apply (positive_definite {n} {p} {margin}). vm_cast_no_check (eq_refl true).");
            self.margin(&margin, fact, claimed)?;
            self.theorem(&format!("{p}_is_positive_definite"), &what, &statement, &proof);
        } else if self.witness(&vector, fact)? {
            let statement = format!("exists v : vector, 0 < square {n} v /\\ quadratic {n} {p} v <= 0");
            let proof = format!("apply (not_positive_definite {n} {p} {vector}). vm_cast_no_check (eq_refl true).");
            let what = format!("{p} > 0 is false.");
            self.theorem(&format!("{p}_is_not_positive_definite"), &what, &statement, &proof);
        }
        Ok(())
    }

    fn margin(&mut self, name: &str, fact: &Fact, claimed: Option<&Number>) -> Result<(), CoqError> {
        self.number(name, &margin(fact, claimed)?, &format!("The margin of {}.", fact.inequality));
        Ok(())
    }

    fn between(&mut self, between: &Between, suffix: &str) -> Result<(), CoqError> {
        let name = |name: &str| format!("{name}{suffix}");
        let of_p = |what: &str| format!("All eigenvalues of P{suffix} are at {what} this.");
        self.float(&name("lower"), between.lower, &of_p("least"))?;
        self.float(&name("upper"), between.upper, &of_p("most"))?;
        self.float(
            &name("overshoot"),
            between.overshoot,
            &format!("At least the square root of upper{suffix} / lower{suffix}."),
        )
    }

    /// A rate at which V falls: that of the certificate, or one from the margin of (12).
    fn decay(&mut self, rate: f64, decrease: &Fact, upper: f64) -> Result<(), CoqError> {
        // F'P + PF <= -q I <= -(q / upper) P.
        let fastest = (decrease.verdict.margin().unwrap_or(0.0) / (2.0 * upper)).next_down();
        let decay = if rate > 0.0 { rate } else { fastest };
        if decay.is_nan() || decay <= 0.0 {
            return Err(CoqError::NoMargin { inequality: decrease.inequality.clone() });
        }
        self.float("decay", decay, "V falls at least like exp(-2 decay t).")
    }
}
