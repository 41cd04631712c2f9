//! Certificates as files for the proof assistant Coq, whose kernel then confirms them.
//!
//! The file that [`theorems`] writes has the certificate's numbers, as they are, and a `Theorem` for each claim, closed
//! by the checker of the folder `proofs/` of the repository, which is proved correct there. What this module does is
//! therefore not trusted to prove anything: a number that it copied wrongly, or a margin that is too large, is refused
//! by Coq or is visible in the file. It chooses the numbers that the proofs need in addition: bounds of the eigenvalues
//! of P, a rate of decay where the certificate names none.

use std::fmt::Write as _;

use thiserror::Error;

use crate::certificate::{
    CertificateFile, CubicConvergence, DiscreteConvergence, Fact, JacobianPolytope, LinearConvergence, PlantPolytope,
    Region, Rejection, Theorem, Vertex, Witness,
};
use crate::error::ProofError;
use crate::exact::Exact;
use crate::matrix::Matrix;
use crate::number::{Datum, Number};
use crate::ring::Ring;
use crate::statement::{largest_eigenvalue_bound, lyapunov_decrease, output_metric, overshoot_bound, positive};
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
    /// A cubic observer that converges from an ellipsoid.
    #[error("convergence from an ellipsoid of errors has no proof in Coq, only convergence from every e(0)")]
    Region,
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
pub const KINDS: [&str; 5] =
    ["linear-observer", "discrete-observer", "cubic-observer", "polytope-of-plants", "polytope-of-jacobians"];

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
    // The claims of a certificate that is false have not been decided.
    let claims = if is_refuted { &[] } else { file.claims() };
    let claimed: Vec<Number> = claims.iter().map(|claim| claim.margin.clone()).collect();
    match theorem {
        Theorem::LinearConvergence(linear) => out.linear(linear, &facts, &claimed)?,
        Theorem::CubicConvergence(cubic) => out.cubic(cubic, &facts, &claimed)?,
        Theorem::PlantPolytope(PlantPolytope { vertices, l, p, rate })
        | Theorem::JacobianPolytope(JacobianPolytope { vertices, l, p, rate }) => {
            out.polytope((vertices, l, p, *rate), &facts, &claimed)?;
        }
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

/// The largest number of outputs for which minors of N'N are formed.
const MOST_OUTPUTS: usize = 4;

/// `d^2 P~` and `d^2 S~` of the head of `statement/deployed_cubic.rs`, `d = det N'N`, times a power of two: exact
/// matrices with `P~ N = -C'S~`. P and S themselves if they have this structure.
fn exactly_structured(
    p: &Matrix<f64>,
    c: &Matrix<f64>,
    n: &Matrix<f64>,
    s: &Matrix<f64>,
) -> Result<(Matrix<Exact>, Matrix<Exact>), CoqError> {
    let embed = |m: &Matrix<f64>| Matrix::<Exact>::embed(m, "a matrix");
    let (p_exact, c_exact, n_exact, s_exact) = (embed(p)?, embed(c)?, embed(n)?, embed(s)?);
    let output = c_exact.transpose();
    let residual = p_exact.product(&n_exact)?.sum(&output.product(&s_exact)?)?;
    if residual.as_slice().iter().all(Exact::is_zero) {
        return Ok((p_exact, s_exact));
    }
    let Some(x) = output_metric(p, c).filter(|_| n.cols() <= MOST_OUTPUTS) else { return Err(CoqError::StoredGain) };
    let x = embed(&x)?;
    let gram = n_exact.transpose().product(&n_exact)?;
    let d = determinant(&gram);
    let Some(size) = d.magnitude_exponent() else { return Err(CoqError::StoredGain) };
    let outputs = n.cols();
    let adjugate = Matrix::from_fn(outputs, outputs, |i, j| {
        let minor = determinant(&without(&gram, j, i));
        if (i + j) % 2 == 0 { minor } else { minor.neg() }
    });
    // d (I - T), T the projector on the range of N.
    let projector = n_exact.product(&adjugate)?.product(&n_exact.transpose())?;
    let rest = Matrix::scalar(p.rows(), &d).difference(&projector)?;
    let metric = output.product(&x)?.product(&c_exact)?;
    let square = d.mul(&d);
    let moved = rest.product(&p_exact.difference(&metric)?)?.product(&rest)?;
    let scaled = |m: Matrix<Exact>| m.map(|entry| entry.shifted(-2 * size));
    let structured = metric.scaled(&square).sum(&moved)?;
    let accretive = x.product(&c_exact)?.product(&n_exact)?.scaled(&square.neg());
    Ok((scaled(structured), scaled(accretive)))
}

/// Determinant by expansion along the first row.
fn determinant(m: &Matrix<Exact>) -> Exact {
    let mut sum = Exact::power_of_two(0);
    if m.rows() > 0 {
        sum = Exact::zero();
        for j in 0..m.cols() {
            let term = m[(0, j)].mul(&determinant(&without(m, 0, j)));
            sum = if j % 2 == 0 { sum.add(&term) } else { sum.sub(&term) };
        }
    }
    sum
}

/// The matrix without a row and a column.
fn without(m: &Matrix<Exact>, row: usize, column: usize) -> Matrix<Exact> {
    let beyond = |k: usize, left_out: usize| k + usize::from(k >= left_out);
    Matrix::from_fn(m.rows() - 1, m.cols() - 1, |i, j| m[(beyond(i, row), beyond(j, column))].clone())
}

/// The beginning of a file: what it is about, and what it needs.
fn head(file: &CertificateFile, is_refuted: bool) -> String {
    let said = if is_refuted { "The certificate is false. It says" } else { "The certificate says" };
    format!(
        "(** {}\n\n    {said}: {}\n\n    To check it where proofs/ of luenberger is compiled: coqc -R proofs Luenberger FILE.v *)\n\n\
         From Coq Require Import Reals QArith Qreals List.\n\
         From Luenberger Require Import Vectors Definite Inequalities Decay LinearObserver DiscreteObserver CubicObserver\n  Polytope Refuted.\n\
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
            let statement = format!("0 < margin_P /\\ forall v : vector, margin_P * square {n} v <= quadratic {n} P v");
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

    /// (12), proved or refuted, for the matrices A and C with this suffix.
    fn decrease(
        &mut self,
        (n, outputs): (usize, usize),
        fact: &Fact,
        claimed: Option<&Number>,
        suffix: &str,
    ) -> Result<(), CoqError> {
        let (a, c) = (format!("A{suffix}"), format!("C{suffix}"));
        let form = format!("inner {n} w (P * v)%vector + inner {n} v (P * w)%vector + 2 * rate * quadratic {n} P v");
        let [margin, vector] = ["margin_12", "v_12"].map(|name| format!("{name}{suffix}"));
        let lemma = |name: &str, number: &str| {
            format!("apply ({name} {n} {outputs} {a} {c} L P rate {number}). vm_cast_no_check (eq_refl true).")
        };
        if fact.verdict.is_proved() {
            self.margin(&margin, fact, claimed)?;
            let statement = format!(
                "0 < {margin} /\\ forall v : vector, let w := ({a} * v - L * ({c} * v))%vector in\n  {form}\n    \
                 <= - {margin} * square {n} v"
            );
            let what =
                format!("v'(F'P + PF + 2 rate P)v is at most minus the margin times |v|^2, F = {a} - L {c}: (12).");
            self.theorem(&format!("inequality_12{suffix}"), &what, &statement, &lemma("lyapunov_inequality", &margin));
        } else if self.witness(&vector, fact)? {
            let statement = format!(
                "exists v : vector, 0 < square {n} v /\\\n    let w := ({a} * v - L * ({c} * v))%vector in\n    0 <= {form}"
            );
            let what = format!("(12) is false: v'(F'P + PF + 2 rate P)v is not negative, F = {a} - L {c}.");
            let name = format!("inequality_12{suffix}_is_false");
            self.theorem(&name, &what, &statement, &lemma("no_lyapunov_inequality", &vector));
        }
        Ok(())
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
            self.between(&between, "")?;
            self.decay(*rate, decrease, between.upper)?;
        }
        self.positive(n, positive, claimed.first())?;
        self.decrease((n, outputs), decrease, claimed.get(1), "")?;
        if !all {
            return Ok(());
        }
        self.lemma("decided", &format!("decays {n} {outputs} A C L P decay lower upper overshoot"));
        let says = says(n, "");
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

    fn cubic(&mut self, theorem: &CubicConvergence, facts: &[Fact], claimed: &[Number]) -> Result<(), CoqError> {
        let CubicConvergence { plant, l, n: gain, theta, p, s, rate, region } = theorem;
        let [a, b, c] = [points(&plant.a)?, points(&plant.b)?, points(&plant.c)?];
        let [positive, decrease, weight, accretive, _] = facts else { return Ok(()) };
        let (n, outputs) = (a.rows(), c.rows());
        self.plant([&a, &b, &c], l, p)?;
        self.matrix("N", &points(gain)?, "The cubic gain, as stored.");
        self.matrix("theta", &points(theta)?, "The weight of the cubic term.");
        self.matrix("S", &points(s)?, "The matrix of the real gain N0 = -P^-1 C'S.");
        self.float("rate", *rate, "The rate in (12).")?;
        let all = facts.iter().all(|fact| fact.verdict.is_proved());
        if all {
            if *region != Region::Everywhere {
                return Err(CoqError::Region);
            }
            let between = Between::of(p, positive)?;
            self.between(&between, "")?;
            self.decay(*rate, decrease, between.upper)?;
            self.stored(theorem)?;
        }
        self.positive(n, positive, claimed.first())?;
        self.decrease((n, outputs), decrease, claimed.get(1), "")?;
        self.semidefinite(outputs, weight, claimed.get(2), "theta")?;
        self.semidefinite(outputs, accretive, claimed.get(3), "S")?;
        if !all {
            return Ok(());
        }
        self.lemma("decided", &format!("cubic_decays {n} {outputs} A C L P theta S decay lower upper overshoot"));
        self.lemma(
            "decided_stored",
            &format!(
                "cubic_decays {n} {outputs} A C L P_stored theta S_stored decay_stored lower_stored upper_stored overshoot_stored"
            ),
        );
        self.lemma("structure_stored", &format!("is_structured {n} {outputs} C P_stored S_stored N"));
        let real = format!("forall N0 : matrix, has_structure {n} {outputs} C P S N0 ->\n  ");
        let exact = "(is_structured_correct _ _ _ _ _ _ structure_stored)";
        let real_gain = "With every real matrix N0 for which P N0 = -C'S, that is with N0 = -P^-1 C'S";
        for (name, suffix, what, before, gain, proof) in [
            (
                "real_gain",
                "",
                real_gain,
                real.as_str(),
                "N0",
                "intros N0 structure. exact (RESULT decided N0 structure BT).".to_owned(),
            ),
            (
                "stored_gain",
                "_stored",
                "With the gains L and N exactly as stored",
                "",
                "(real N)",
                format!("exact (RESULT decided_stored _ {exact} BT)."),
            ),
        ] {
            let says = says(n, suffix);
            let proof = |result: &str, b: &str| {
                let arguments = "_ _ _ _ _ _ _ _ _ _ _ _";
                proof.replace("RESULT", &format!("{result} {arguments}")).replace(" BT", b)
            };
            self.theorem(
                &format!("{name}_every_error"),
                &format!("{what}: every differentiable e with e' = (A - L C)e + (y'theta y) N y, y = C e."),
                &format!(
                    "{before}forall (T : R) (e : R -> vector),\n  \
                     solution T {n} e (fun t => let y := (C * e t)%vector in\n    \
                     (A * e t - L * y + quadratic {outputs} theta y .* apply {outputs} {gain} y)%vector) ->\n  {says}"
                ),
                &proof("cubic_error_decays", ""),
            );
            self.theorem(
                &format!("{name}_observer"),
                &format!(
                    "{what}: the error of plant x' = A x + B u, y = C x and observer\n    \
                     xhat' = A xhat + B u + L r - (r'theta r) N r, r = y - C xhat, for every input u."
                ),
                &format!(
                    "{before}forall (T : R) (u x xhat : R -> vector),\n  \
                     solution T {n} x (fun t => A * x t + B * u t)%vector ->\n  \
                     solution T {n} xhat (fun t => let r := (C * x t - C * xhat t)%vector in\n    \
                     (A * xhat t + B * u t + L * r - quadratic {outputs} theta r .* apply {outputs} {gain} r)%vector) ->\n  \
                     let e t := (x t - xhat t)%vector in\n  {says}"
                ),
                &proof("cubic_observer_decays", " B"),
            );
        }
        Ok(())
    }

    fn polytope(
        &mut self,
        (vertices, l, p, rate): (&[Vertex], &Matrix<f64>, &Matrix<f64>, f64),
        facts: &[Fact],
        claimed: &[Number],
    ) -> Result<(), CoqError> {
        let Some((positive, decreases)) = facts.split_first() else { return Ok(()) };
        let (n, outputs) = l.shape();
        for (k, Vertex { a, c }) in (1..).zip(vertices) {
            self.matrix(&format!("A_{k}"), &single(a, "A of a vertex")?, &format!("The state matrix of vertex {k}."));
            self.matrix(&format!("C_{k}"), &single(c, "C of a vertex")?, &format!("The output matrix of vertex {k}."));
        }
        let pairs: Vec<String> = (1..=vertices.len()).map(|k| format!("(A_{k}, C_{k})")).collect();
        let pairs = pairs.join("; ");
        _ = write!(self.numbers, "\n(** The vertices. *)\nDefinition vertices : list vertex := [{pairs}].\n");
        self.matrix("L", &points(l)?, "The gain of the observer.");
        self.matrix("P", &points(p)?, "The matrix of V = e'Pe.");
        self.float("rate", rate, "The rate in the inequalities.")?;
        let all = facts.iter().all(|fact| fact.verdict.is_proved());
        let least = |fact: &&Fact| fact.verdict.margin().unwrap_or(0.0);
        if let (true, Some(least)) = (all, decreases.iter().min_by(|x, y| least(x).total_cmp(&least(y)))) {
            let between = Between::of(p, positive)?;
            self.between(&between, "")?;
            self.decay(rate, least, between.upper)?;
        }
        self.positive(n, positive, claimed.first())?;
        for (k, fact) in (1..).zip(decreases) {
            self.decrease((n, outputs), fact, claimed.get(k), &format!("_{k}"))?;
        }
        if !all {
            return Ok(());
        }
        self.lemma("decided", &format!("polytope_decays {n} {outputs} vertices L P decay lower upper overshoot"));
        let (says, count) = (says(n, ""), vertices.len());
        self.theorem(
            "every_error",
            "Every differentiable e with e' = (A(t) - L C(t))e, (A(t), C(t)) the sum of the vertices with any weights w(t)\n    \
             that are not negative and have the sum 1.",
            &format!(
                "forall (T : R) (e : R -> vector) (w : R -> nat -> R),\n  (forall t, convex {count} (w t)) ->\n  \
                 solution T {n} e (fun t => hull_error vertices L (w t) (e t)) ->\n  {says}"
            ),
            "exact (polytope_error_decays _ _ _ _ _ _ _ _ _ decided).",
        );
        Ok(())
    }

    /// `theta >= 0`, or `S + S' >= 0`, proved or refuted.
    fn semidefinite(&mut self, p: usize, fact: &Fact, claimed: Option<&Number>, name: &str) -> Result<(), CoqError> {
        let (margin, vector) = (format!("margin_{name}"), format!("v_{name}"));
        let (form, positive, negative, form_name) = if name == "S" {
            ("2 * quadratic", "accretive", "not_accretive", "v'(S + S')v")
        } else {
            ("quadratic", "is_at_least_correct", "not_positive_semidefinite", "v'theta v")
        };
        if fact.verdict.is_proved() {
            let zero = Number::from(Exact::zero());
            self.number(&margin, claimed.unwrap_or(&zero), &format!("The margin of {}.", fact.inequality));
            let what = format!("{}: {form_name} is at least the margin times |v|^2.", fact.inequality);
            let statement = format!("forall v : vector, {margin} * square {p} v <= {form} {p} {name} v");
            let proof = format!("apply ({positive} {p} {name} {margin}). vm_cast_no_check (eq_refl true).");
            self.theorem(&format!("{name}_is_positive_semidefinite"), &what, &statement, &proof);
        } else if self.witness(&vector, fact)? {
            let statement = format!("exists v : vector, {form} {p} {name} v < 0");
            let proof = format!("apply ({negative} {p} {name} {vector}). vm_cast_no_check (eq_refl true).");
            let what = format!("{} is false.", fact.inequality);
            self.theorem(&format!("{name}_is_not_positive_semidefinite"), &what, &statement, &proof);
        }
        Ok(())
    }

    /// A Lyapunov matrix for which the stored N has the structure exactly, with its numbers.
    fn stored(&mut self, theorem: &CubicConvergence) -> Result<(), CoqError> {
        let CubicConvergence { plant, l, n, p, s, .. } = theorem;
        let (exact_p, exact_s) = exactly_structured(p, &plant.c, n, s)?;
        let nearest = exact_p.map(|entry| f64::midpoint(entry.round_down(), entry.round_up()));
        // The margins of the rounded matrix are reduced by more than what its rounding can change.
        let (order, upper) = (p.rows(), largest_eigenvalue_bound(&nearest) * (1.0 + 1e-9));
        let largest = |m: &Matrix<f64>| m.as_slice().iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        let flow = largest(&plant.a) + order as f64 * largest(l) * largest(&plant.c);
        let rounding = 1e-14 * order as f64 * upper;
        let lower = positive(&nearest)?.margin().unwrap_or(0.0) - rounding;
        let falls = lyapunov_decrease(&plant.a, l, &plant.c, &nearest)?.margin().unwrap_or(0.0);
        let decay = (falls - 2.0 * rounding * order as f64 * flow) / (2.0 * upper) * (1.0 - 1e-9);
        if !(lower > 0.0 && decay > 0.0 && upper.is_finite()) {
            return Err(CoqError::StoredGain);
        }
        let what = "The matrix of the function V for the gains as stored: near P, up to a factor.";
        self.matrix("P_stored", &exact_p.map(|entry| Number::from(entry.clone())), what);
        let what = "P_stored N = -C' S_stored, exactly.";
        self.matrix("S_stored", &exact_s.map(|entry| Number::from(entry.clone())), what);
        let overshoot = (upper / lower).sqrt() * (1.0 + 1e-9);
        self.between(&Between { lower, upper, overshoot }, "_stored")?;
        self.float("decay_stored", decay, "V falls at least like exp(-2 decay_stored t) with the gains as stored.")
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
            self.between(&between, "")?;
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
