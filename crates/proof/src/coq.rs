//! Certificates as files for the proof assistant Coq, whose kernel then confirms them.
//!
//! The file that [`theorems`] writes has the certificate's numbers, as they are, and a `Theorem` for each claim, closed
//! by the checker of the folder `proofs/` of the repository, which is proved correct there. What this module does is
//! therefore not trusted to prove anything: a number that it copied wrongly, or a margin that is too large, is refused
//! by Coq or is visible in the file. It chooses the numbers that the proofs need in addition: bounds of the eigenvalues
//! of P, a rate of decay where the certificate names none.

use std::fmt::Write as _;

use thiserror::Error;

use crate::certificate::{CertificateFile, DiscreteConvergence, Fact, LinearConvergence, Rejection, Theorem, Witness};
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
    /// Whether the certificate is false: the theorems say of which inequalities, and the others are left out.
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
        crate::coq::KINDS.map(|kind| format!("\"{kind}\"")).join(" and ")
    )]
    Kind {
        /// Its name.
        theorem: &'static str,
    },
    /// Entries that stand for all numbers between two.
    #[error("{matrix} has an entry that stands for all numbers between two bounds, which the proofs in Coq do not cover")]
    Bounds {
        /// The matrix.
        matrix: &'static str,
    },
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
pub const KINDS: [&str; 2] = ["linear-observer", "discrete-observer"];

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
    let facts = match file.check() {
        Ok(proved) => proved.facts,
        Err(Rejection::NotProved { verdict, .. }) if matches!(*verdict, Verdict::Refuted { .. }) => theorem.facts()?,
        Err(rejection) => return Err(rejection.into()),
    };
    let is_refuted = facts.iter().any(|fact| !fact.verdict.is_proved());
    let mut out = Out { numbers: String::new(), proved: String::new(), theorems: Vec::new() };
    let claimed: Vec<Number> = file.claims().iter().map(|claim| claim.margin.clone()).collect();
    match theorem {
        Theorem::LinearConvergence(linear) => out.linear(linear, &facts, &claimed)?,
        Theorem::DiscreteConvergence(discrete) => out.discrete(discrete, &facts, &claimed)?,
        other => return Err(CoqError::Kind { theorem: other.name() }),
    }
    let Out { numbers, proved, theorems } = out;
    let text = format!("{}{numbers}\nLocal Open Scope R_scope.\n{proved}", head(file, is_refuted));
    Ok(CoqFile { text, theorems, is_refuted })
}

/// The two parts of a file.
struct Out {
    /// The certificate's numbers, and those of the proof.
    numbers: String,
    /// The theorems about them.
    proved: String,
    /// The names of the theorems.
    theorems: Vec<String>,
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
         From Luenberger Require Import Vectors Definite Inequalities Decay LinearObserver DiscreteObserver Refuted.\n\
         Import ListNotations.\n\n\
         Local Coercion Q2R : Q >-> R.\n\
         Local Open Scope Q_scope.\n",
        quiet(file.title()),
        quiet(file.statement())
    )
}

impl Out {
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
        _ = write!(
            self.proved,
            "\nLemma {name} : {statement} = true.\nProof. vm_cast_no_check (eq_refl true). Qed.\n"
        );
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

    /// `P > 0`, proved or refuted.
    fn positive(&mut self, n: usize, fact: &Fact, claimed: Option<&Number>) -> Result<(), CoqError> {
        if fact.verdict.is_proved() {
            let statement =
                format!("0 < margin_P /\\ forall v : vector, margin_P * square {n} v <= quadratic {n} P v");
            let what = "P > 0: v'Pv is at least the margin times |v|^2.";
            let proof = format!("apply (positive_definite {n} P margin_P). vm_cast_no_check (eq_refl true).");
            self.margin("margin_P", fact, claimed)?;
            self.theorem("P_is_positive_definite", what, &statement, &proof);
        } else if self.witness("v_P", fact)? {
            let statement = format!("exists v : vector, 0 < square {n} v /\\ quadratic {n} P v <= 0");
            let proof = format!("apply (not_positive_definite {n} P v_P). vm_cast_no_check (eq_refl true).");
            self.theorem("P_is_not_positive_definite", "P > 0 is false.", &statement, &proof);
        }
        Ok(())
    }

    fn margin(&mut self, name: &str, fact: &Fact, claimed: Option<&Number>) -> Result<(), CoqError> {
        self.number(name, &margin(fact, claimed)?, &format!("The margin of {}.", fact.inequality));
        Ok(())
    }

    fn between(&mut self, between: &Between) -> Result<(), CoqError> {
        self.float("lower", between.lower, "All eigenvalues of P are at least this.")?;
        self.float("upper", between.upper, "All eigenvalues of P are at most this.")?;
        self.float("overshoot", between.overshoot, "The square root of upper / lower, rounded up.")
    }

    fn linear(&mut self, theorem: &LinearConvergence, facts: &[Fact], claimed: &[Number]) -> Result<(), CoqError> {
        let LinearConvergence { plant, l, p, rate } = theorem;
        let [a, b, c] = [single(&plant.a, "A")?, single(&plant.b, "B")?, single(&plant.c, "C")?];
        let [positive, decrease] = facts else { return Ok(()) };
        let (n, outputs) = (a.rows(), c.rows());
        self.plant([&a, &b, &c], l, p)?;
        self.float("rate", *rate, "The rate in (12).")?;
        let all = facts.iter().all(|fact| fact.verdict.is_proved());
        if all {
            let between = Between::of(p, positive)?;
            self.between(&between)?;
            if *rate == 0.0 {
                // F'P + PF <= -q I <= -(q / upper) P.
                let decay = (decrease.verdict.margin().unwrap_or(0.0) / (2.0 * between.upper)).next_down();
                if decay.is_nan() || decay <= 0.0 {
                    return Err(CoqError::NoMargin { inequality: decrease.inequality.clone() });
                }
                self.float("decay", decay, "A rate at which V falls, from the margin of (12).")?;
            } else {
                self.float("decay", *rate, "The rate at which V falls.")?;
            }
        }
        self.positive(n, positive, claimed.first())?;
        let form = format!("inner {n} w (P * v)%vector + inner {n} v (P * w)%vector + 2 * rate * quadratic {n} P v");
        if decrease.verdict.is_proved() {
            self.margin("margin_12", decrease, claimed.get(1))?;
            let statement = format!(
                "0 < margin_12 /\\ forall v : vector, let w := (A * v - L * (C * v))%vector in\n  {form}\n    <= - margin_12 * square {n} v"
            );
            let proof = format!(
                "apply (lyapunov_inequality {n} {outputs} A C L P rate margin_12). vm_cast_no_check (eq_refl true)."
            );
            let what = "(12): v'(F'P + PF + 2 rate P)v is at most minus the margin times |v|^2, F = A - L C.";
            self.theorem("inequality_12", what, &statement, &proof);
        } else if self.witness("v_12", decrease)? {
            let statement = format!(
                "exists v : vector, 0 < square {n} v /\\\n    let w := (A * v - L * (C * v))%vector in\n    0 <= {form}"
            );
            let proof = format!(
                "apply (no_lyapunov_inequality {n} {outputs} A C L P rate v_12). vm_cast_no_check (eq_refl true)."
            );
            let what = "(12) is false: v'(F'P + PF + 2 rate P)v is not negative, F = A - L C.";
            self.theorem("inequality_12_is_false", what, &statement, &proof);
        }
        if !all {
            return Ok(());
        }
        self.lemma("decided", &format!("decays {n} {outputs} A C L P decay lower upper overshoot"));
        let says = format!(
            "(forall s t, 0 <= s -> s <= t -> t < T ->\n    quadratic {n} P (e t) <= exp (- (2 * decay) * (t - s)) * quadratic {n} P (e s))\n  \
             /\\ (forall t, 0 <= t -> t < T -> norm {n} (e t) <= overshoot * exp (- decay * t) * norm {n} (e 0))"
        );
        self.theorem(
            "every_error",
            "Every differentiable e with e' = (A - L C)e, on any interval from 0 to T: V = e'Pe and the norm of e decay.",
            &format!(
                "forall (T : R) (e : R -> vector),\n  solution T {n} e (fun t => A * e t - L * (C * e t))%vector ->\n  {says}"
            ),
            "exact (error_decays _ _ _ _ _ _ _ _ _ _ decided).",
        );
        self.theorem(
            "observer",
            "The error e = x - xhat of plant x' = A x + B u, y = C x and observer xhat' = A xhat + B u + L(y - C xhat), for\n    every input u.",
            &format!(
                "forall (T : R) (u x xhat : R -> vector),\n  \
                 solution T {n} x (fun t => A * x t + B * u t)%vector ->\n  \
                 solution T {n} xhat (fun t => A * xhat t + B * u t + L * (C * x t - C * xhat t))%vector ->\n  \
                 let e t := (x t - xhat t)%vector in\n  {says}"
            ),
            "exact (observer_decays _ _ _ _ _ _ _ _ _ _ decided B).",
        );
        Ok(())
    }

    fn discrete(&mut self, theorem: &DiscreteConvergence, facts: &[Fact], claimed: &[Number]) -> Result<(), CoqError> {
        let DiscreteConvergence { plant, l, p, factor } = theorem;
        let [a, b, c] = [points(&plant.a)?, points(&plant.b)?, points(&plant.c)?];
        let [positive, decrease] = facts else { return Ok(()) };
        let (n, outputs) = (a.rows(), c.rows());
        self.plant([&a, &b, &c], l, p)?;
        self.float("factor", factor.unwrap_or(1.0), "The factor of the inequality, 1 where the certificate has none.")?;
        let all = facts.iter().all(|fact| fact.verdict.is_proved());
        if all {
            let between = Between::of(p, positive)?;
            self.between(&between)?;
            let contraction = factor.unwrap_or_else(|| {
                // F'PF <= P - q I <= (1 - q / upper) P.
                let falls = (decrease.verdict.margin().unwrap_or(0.0) / between.upper).next_down();
                (1.0 - falls).next_up().sqrt().next_up()
            });
            if contraction.is_nan() || contraction >= 1.0 {
                return Err(CoqError::NoMargin { inequality: decrease.inequality.clone() });
            }
            self.float("contraction", contraction, "The factor by which the square root of V falls at each step.")?;
        }
        self.positive(n, positive, claimed.first())?;
        let form = format!("quadratic {n} P w - factor ^ 2 * quadratic {n} P v");
        if decrease.verdict.is_proved() {
            self.margin("margin_F", decrease, claimed.get(1))?;
            let statement = format!(
                "0 < margin_F /\\ forall v : vector, let w := (A * v - L * (C * v))%vector in\n  {form} <= - margin_F * square {n} v"
            );
            let proof = format!(
                "apply (stein_inequality {n} {outputs} A C L P factor margin_F). vm_cast_no_check (eq_refl true)."
            );
            let what = "v'(F'P F - factor^2 P)v is at most minus the margin times |v|^2, F = A - L C.";
            self.theorem("stein_inequality", what, &statement, &proof);
        } else if self.witness("v_F", decrease)? {
            let statement = format!(
                "exists v : vector, 0 < square {n} v /\\\n    let w := (A * v - L * (C * v))%vector in\n    0 <= {form}"
            );
            let proof = format!(
                "apply (no_stein_inequality {n} {outputs} A C L P factor v_F). vm_cast_no_check (eq_refl true)."
            );
            let what = "v'(F'P F - factor^2 P)v < 0 is false, F = A - L C.";
            self.theorem("stein_inequality_is_false", what, &statement, &proof);
        }
        if !all {
            return Ok(());
        }
        self.lemma("decided", &format!("contracts {n} {outputs} A C L P contraction lower upper overshoot"));
        let says = format!(
            "(forall k, quadratic {n} P (e (S k)) <= contraction ^ 2 * quadratic {n} P (e k))\n  \
             /\\ (forall k, quadratic {n} P (e k) <= contraction ^ (2 * k) * quadratic {n} P (e 0%nat))\n  \
             /\\ (forall k, norm {n} (e k) <= overshoot * contraction ^ k * norm {n} (e 0%nat))"
        );
        self.theorem(
            "every_error",
            "Every e with e(k+1) = (A - L C)e(k): V = e'Pe and the norm of e decay.",
            &format!(
                "forall e : nat -> vector,\n  recursion {n} e (fun k => A * e k - L * (C * e k))%vector ->\n  {says}"
            ),
            "exact (error_contracts _ _ _ _ _ _ _ _ _ _ decided).",
        );
        self.theorem(
            "observer",
            "The error e = x - xhat of plant x+ = A x + B u, y = C x and observer xhat+ = A xhat + B u + L(y - C xhat), for\n    every input u.",
            &format!(
                "forall u x xhat : nat -> vector,\n  \
                 recursion {n} x (fun k => A * x k + B * u k)%vector ->\n  \
                 recursion {n} xhat (fun k => A * xhat k + B * u k + L * (C * x k - C * xhat k))%vector ->\n  \
                 let e k := (x k - xhat k)%vector in\n  {says}"
            ),
            "exact (observer_contracts _ _ _ _ _ _ _ _ _ _ decided B).",
        );
        Ok(())
    }
}
