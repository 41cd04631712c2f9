//! Claims of the cubic paper that are false, as files for Coq: the theorems of `proofs/CubicPaper.v` with the numbers
//! of the examples.
//!
//! Numbers that the paper prints are fractions here, 267/1000 for .267, not the binary64 numbers near them:
//! [`Number::of_decimal`].

use super::{CoqError, CoqFile, Out, quiet};
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::number::Number;
use crate::polynomial::Rational;

/// Theorem 2 as printed: with (14), `P N C + C'N'P < 0` (13). With fewer outputs than states it never holds, for any
/// real matrices P, N and C.
pub fn never_strict(claim: &str) -> CoqFile {
    let mut out = Out::new();
    out.theorem(
        "inequality_13_is_never_strict",
        "With fewer outputs than states there is for all real matrices P, N and C a v, not 0, at which v'(P N C + C'N'P)v is\n    \
         0: no N fulfils (13) as a strict inequality.",
        "forall (n p : nat) (P N C : matrix), (p < n)%nat ->\n  \
         exists v : vector, 0 < square n v /\\\n    \
         let d := apply p N (apply n C v) in inner n v (apply n P d) + inner n d (apply n P v) = 0",
        "exact CubicPaper.inequality_13_is_never_strict.",
    );
    out.into_refutation(claim)
}

/// A plant with one output, an observer and a cubic gain N with `C N > 0`.
#[derive(Debug, Clone, Copy)]
pub struct WrongSign<'a> {
    /// The state matrix, n x n.
    pub a: &'a Matrix<Number>,
    /// The output matrix, 1 x n.
    pub c: &'a Matrix<Number>,
    /// The linear gain, n x 1.
    pub l: &'a Matrix<Number>,
    /// The cubic gain, n x 1.
    pub n: &'a Matrix<Number>,
    /// The weight, 1 x 1.
    pub theta: &'a Matrix<Number>,
}

/// Example 3 as printed: no P > 0 fulfils `P N C + C'N'P <= 0` (13'), and an error that is not 0 stands still, so that
/// (11) is violated.
///
/// # Errors
/// [`CoqError`] for shapes that do not fit and an `A - LC` that is singular.
pub fn wrong_sign(claim: &str, data: &WrongSign<'_>) -> Result<CoqFile, CoqError> {
    let WrongSign { a, c, l, n, theta } = *data;
    let states = a.rows();
    let rational = |m: &Matrix<Number>| m.map(|x: &Number| Rational::from(x));
    let (left, l_exact, c_exact) = (rational(a), rational(l), rational(c));
    let flow =
        Matrix::from_fn(states, states, |i, j| left[(i, j)].plus(&l_exact[(i, 0)].times(&c_exact[(0, j)]).negative()));
    let direction = solution(&flow, &rational(n)).ok_or(ProofError::Empty { what: "the inverse of A - LC" })?;
    let direction = Matrix::from_row_major(states, 1, direction.into_iter().map(Number::from).collect())?;
    let mut out = Out::new();
    out.matrix("A", a, "The state matrix, as printed.");
    out.matrix("C", c, "The output matrix, as printed.");
    out.matrix("L", l, "The linear gain, as printed.");
    out.matrix("N", n, "The cubic gain, with the sign that is printed.");
    out.matrix("theta", theta, "The weight, as printed.");
    out.matrix("w", &direction, "(A - L C)w = N.");
    out.theorem(
        "no_matrix_for_13",
        "No positive definite P fulfils (13'): v'(P N C + C'N'P)v is positive for some v.",
        &format!(
            "forall P : matrix, (forall v : vector, 0 < square {states} v -> 0 < form {states} P v) ->\n  \
             exists v : vector, let d := apply 1 (real N) (apply {states} (real C) v) in\n  \
             0 < inner {states} v (apply {states} P d) + inner {states} d (apply {states} P v)"
        ),
        &format!("refine (CubicPaper.no_matrix_for_13 {states} C N _). vm_cast_no_check (eq_refl true)."),
    );
    out.theorem(
        "error_stands_still",
        "There is an error, not 0, that is a solution of e' = (A - L C)e + (y'theta y) N y, y = C e, as it stands: (11) is\n    \
         violated, and the error does not tend to 0.",
        &format!(
            "exists v : vector, 0 < square {states} v /\\ forall T,\n  \
             solution T {states} (fun _ => v) (fun _ => let y := (C * v)%vector in\n    \
             (A * v - L * y + quadratic 1 theta y .* (N * y))%vector)"
        ),
        &format!("refine (CubicPaper.error_stands_still {states} A C L N theta w _). vm_cast_no_check (eq_refl true)."),
    );
    Ok(out.into_refutation(claim))
}

/// Matrices for which every hypothesis of Theorem 5 holds, (23) with equality.
#[derive(Debug, Clone, Copy)]
pub struct AtEquality<'a> {
    /// The nominal state matrix, n x n.
    pub a: &'a Matrix<Number>,
    /// The output matrix, p x n.
    pub c: &'a Matrix<Number>,
    /// The linear gain, n x p.
    pub l: &'a Matrix<Number>,
    /// The cubic gain, n x p.
    pub n: &'a Matrix<Number>,
    /// P, n x n.
    pub p: &'a Matrix<Number>,
    /// Q of the Lyapunov equation (9), n x n.
    pub q: &'a Matrix<Number>,
    /// The weight, p x p.
    pub theta: &'a Matrix<Number>,
    /// The bound of (23), `least / (2 largest)`.
    pub eps: &'a Number,
    /// A lower bound of the eigenvalues of P, positive.
    pub positive: &'a Number,
    /// The smallest eigenvalue of Q.
    pub least: &'a Number,
    /// The largest eigenvalue of P.
    pub largest: &'a Number,
    /// A margin of (13), positive.
    pub margin: &'a Number,
    /// An error that stands still, n x 1.
    pub error: &'a Matrix<Number>,
}

/// Theorem 5 as printed, with `<=` in (23): all its hypotheses hold, and an error that is not 0 stands still.
pub fn equality(claim: &str, data: &AtEquality<'_>) -> CoqFile {
    let AtEquality { a, c, l, n, p, q, theta, eps, positive, least, largest, margin, error } = *data;
    let (states, outputs) = (a.rows(), c.rows());
    let mut out = Out::new();
    for (name, matrix, what) in [
        ("A", a, "The nominal state matrix; the plant has A + eps I."),
        ("C", c, "The output matrix."),
        ("L", l, "The linear gain."),
        ("N", n, "The cubic gain."),
        ("P", p, "The matrix of V = e'Pe."),
        ("Q0", q, "Q of the Lyapunov equation (9)."),
        ("theta", theta, "The weight."),
        ("e0", error, "The error that stands still."),
    ] {
        out.matrix(name, matrix, what);
    }
    for (name, number, what) in [
        ("eps", eps, "The bound of (23)."),
        ("positive", positive, "All eigenvalues of P are at least this."),
        ("least", least, "All eigenvalues of Q are at least this."),
        ("largest", largest, "All eigenvalues of P are at most this."),
        ("margin", margin, "The margin of (13)."),
    ] {
        out.number(name, number, what);
    }
    out.theorem(
        "equality_does_not_suffice",
        "P > 0; Q > 0; (9), hence (12); (13), strictly; theta >= 0; (23) with equality; and an error, not 0, that is a\n    \
         solution of e' = (A + eps I - L C)e + (y'theta y) N y, y = C e, as it stands.",
        &format!(
            "(0 < positive /\\ forall v, positive * square {states} v <= quadratic {states} P v)\n  \
             /\\ (0 < least /\\ forall v, least * square {states} v <= quadratic {states} Q0 v)\n  \
             /\\ (forall v : vector, let w := (A * v - L * (C * v))%vector in\n       \
             inner {states} w (P * v)%vector + inner {states} v (P * w)%vector = - quadratic {states} Q0 v)\n  \
             /\\ (0 < margin /\\ forall v : vector, let d := (N * (C * v))%vector in\n       \
             inner {states} v (P * d)%vector + inner {states} d (P * v)%vector <= - margin * square {states} v)\n  \
             /\\ (forall y, 0 <= quadratic {outputs} theta y)\n  \
             /\\ (2 * eps * largest = least /\\ forall v, quadratic {states} P v <= largest * square {states} v)\n  \
             /\\ exists e : vector, 0 < square {states} e /\\ forall T,\n     \
             solution T {states} (fun _ => e) (fun _ => let y := (C * e)%vector in\n       \
             (A * e + eps .* e - L * y + quadratic {outputs} theta y .* (N * y))%vector)"
        ),
        &format!(
            "refine (CubicPaper.equality_does_not_suffice {states} {outputs} A C L N P Q0 theta eps positive least largest margin e0 _).\n  \
             vm_cast_no_check (eq_refl true)."
        ),
    );
    out.into_refutation(claim)
}

impl Out {
    /// The file with this comment at its head.
    fn into_refutation(self, claim: &str) -> CoqFile {
        let text = format!(
            "(** {}\n\n    To check it where proofs/ of luenberger is compiled: coqc -R proofs Luenberger FILE.v *)\n\n\
             From Coq Require Import Reals QArith Qreals List.\n\
             From Luenberger Require Import Vectors Definite Inequalities Decay LinearObserver CubicObserver.\n\
             From Luenberger Require CubicPaper.\n\
             Import ListNotations.\n\n\
             Local Coercion Q2R : Q >-> R.\n\
             Local Open Scope Q_scope.\n{}\nLocal Open Scope R_scope.\n{}",
            quiet(claim),
            self.numbers,
            self.proved
        );
        CoqFile { text, theorems: self.theorems, is_refuted: true }
    }
}

/// The column x with `m x = b`, by elimination; none where m is singular.
fn solution(m: &Matrix<Rational>, b: &Matrix<Rational>) -> Option<Vec<Rational>> {
    let n = m.rows();
    let row = |i: usize| (0..n).map(|j| m[(i, j)].clone()).chain([b[(i, 0)].clone()]).collect::<Vec<_>>();
    let mut rows: Vec<Vec<Rational>> = (0..n).map(row).collect();
    for k in 0..n {
        let pivot = (k..n).find(|&i| !rows[i][k].is_zero())?;
        rows.swap(k, pivot);
        let inverse = rows[k][k].inverse()?;
        rows[k] = rows[k].iter().map(|x| x.times(&inverse)).collect();
        let pivotal = rows[k].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(i, _)| *i != k) {
            let factor = row[k].negative();
            for (x, y) in row.iter_mut().zip(&pivotal) {
                *x = x.plus(&y.times(&factor));
            }
        }
    }
    rows.into_iter().map(|mut row| row.pop()).collect()
}
