//! Lyapunov and Stein inequalities, `F'P + PF + 2 alpha P < 0` and `F'PF - P < 0`, and their consequences for the
//! spectrum of F.

use super::{Expression, embed, embed_symmetric, number};
use crate::definite::{self, Direction, Sense};
use crate::error::ProofError;
use crate::exact::Exact;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::{UndecidedReason, Verdict};

/// `F = A - LC`.
pub(super) fn error_matrix<R: Ring>(
    a: &Matrix<f64>,
    l: &Matrix<f64>,
    c: &Matrix<f64>,
) -> Result<Matrix<R>, ProofError> {
    let n = a.rows();
    let (a, c) = (embed::<R>(a, "A", (n, n))?, embed::<R>(c, "C", (c.rows(), n))?);
    let l = embed::<R>(l, "L", (n, c.rows()))?;
    a.difference(&l.product(&c)?)
}

struct Decrease<'a> {
    a: &'a Matrix<f64>,
    output_injection: Option<(&'a Matrix<f64>, &'a Matrix<f64>)>,
    p: &'a Matrix<f64>,
    alpha: f64,
    what_p: &'static str,
}

impl Decrease<'_> {
    fn flow<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        match self.output_injection {
            Some((l, c)) => error_matrix(self.a, l, c),
            None => embed(self.a, "A", (self.a.rows(), self.a.rows())),
        }
    }
}

impl Expression for Decrease<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let p = embed_symmetric::<R>(self.p, self.what_p, self.a.rows())?;
        let alpha = number::<R>(self.alpha, "alpha")?;
        left_hand_side(&self.flow::<R>()?, &p, &alpha)
    }
}

/// `F'P + PF + 2 alpha P`, computed as `P (F + alpha I)` plus its transpose.
fn left_hand_side<R: Ring>(f: &Matrix<R>, p: &Matrix<R>, alpha: &R) -> Result<Matrix<R>, ProofError> {
    p.product(&f.sum(&Matrix::scalar(f.rows(), alpha))?)?.plus_transpose()
}

/// `(A - LC)'P + P(A - LC) < 0` (Share Pasand, eq. 12): `V = e'Pe` decreases along the error of the observer with gain
/// `L`.
///
/// Proved with margin q: `V' <= -q |e|^2`. With [`positive`] of `P` it proves `A - LC` Hurwitz.
/// # Errors
/// [`ProofError`] for inconsistent shapes, entries that are not finite, or a `P` that is not symmetric.
/// ```
/// use luenberger_proof::{Matrix, statement::lyapunov_decrease};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// // A double integrator, its position measured, poles at -2 and -5.
/// let a = Matrix::from_rows([[0.0, 1.0], [0.0, 0.0]]);
/// let (l, c) = (Matrix::from_rows([[7.0], [10.0]]), Matrix::from_rows([[1.0, 0.0]]));
/// // F'P + PF = -14 I, up to nothing: the residual is 0.
/// let p = Matrix::from_rows([[11.0, -7.0], [-7.0, 6.0]]);
/// let margin = lyapunov_decrease(&a, &l, &c, &p)?.margin().expect("proved");
/// assert!((margin - 14.0).abs() < 1e-9 && margin <= 14.0);
/// # Ok(())
/// # }
/// ```
pub fn lyapunov_decrease(
    a: &Matrix<f64>,
    l: &Matrix<f64>,
    c: &Matrix<f64>,
    p: &Matrix<f64>,
) -> Result<Verdict<Direction>, ProofError> {
    decay_rate(a, l, c, p, 0.0)
}

/// `F'P + PF + 2 alpha P < 0` with `F = A - LC`: `V = e'Pe` decreases faster than `exp(-2 alpha t)`. With `P > 0` the
/// spectral abscissa of `F` is below `-alpha`. The margin is in the units of the left-hand side.
/// # Errors
/// As [`lyapunov_decrease`], and for an `alpha` that is not finite.
pub fn decay_rate(
    a: &Matrix<f64>,
    l: &Matrix<f64>,
    c: &Matrix<f64>,
    p: &Matrix<f64>,
    alpha: f64,
) -> Result<Verdict<Direction>, ProofError> {
    Decrease { a, output_injection: Some((l, c)), p, alpha, what_p: "P" }.decide(Sense::NegativeDefinite)
}

/// [`decay_rate`] for every `A` and every `C` within the bounds: `(A - LC)'P + P(A - LC) + 2 alpha P < 0`, with the
/// gain and `P` as stored.
///
/// The inequality is linear in `(A, C)`: proved for boxes around the vertices of a polytope, it holds on their convex
/// hull. If all data are single numbers, the decision is that of [`decay_rate`], exact if necessary.
/// # Errors
/// As [`decay_rate`].
/// ```
/// use luenberger_proof::{Interval, Matrix, statement::decay_rate_within};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// // x' = a x with a between -1.1 and -0.9 decays at the rate 0.8, without any output.
/// let a = Matrix::from_rows([[Interval::new(-1.1, -0.9).expect("in order")]]);
/// let (l, p) = (Matrix::from_rows([[0.0]]), Matrix::from_rows([[1.0]]));
/// let c = Matrix::from_rows([[Interval::UNBOUNDED]]);
/// assert!(decay_rate_within(&a, &l, &c, &p, 0.8)?.is_proved());
/// assert!(!decay_rate_within(&a, &l, &c, &p, 1.0)?.is_proved());
/// # Ok(())
/// # }
/// ```
pub fn decay_rate_within(
    a: &Matrix<Interval>,
    l: &Matrix<f64>,
    c: &Matrix<Interval>,
    p: &Matrix<f64>,
    alpha: f64,
) -> Result<Verdict<Direction>, ProofError> {
    if a.as_slice().iter().chain(c.as_slice()).all(Interval::is_point) {
        return decay_rate(&a.map(Interval::lo), l, &c.map(Interval::lo), p, alpha);
    }
    let n = a.rows();
    a.expect_shape("A", (n, n))?;
    c.expect_shape("C", (c.rows(), n))?;
    let l = embed::<Interval>(l, "L", (n, c.rows()))?;
    let p = embed_symmetric::<Interval>(p, "P", n)?;
    let alpha = number::<Interval>(alpha, "alpha")?;
    definite::decide(&left_hand_side(&a.difference(&l.product(c)?)?, &p, &alpha)?, Sense::NegativeDefinite)
}

/// `P > 0`.
/// # Errors
/// As [`lyapunov_decrease`].
pub fn positive(p: &Matrix<f64>) -> Result<Verdict<Direction>, ProofError> {
    embed_symmetric::<Interval>(p, "P", p.rows())?;
    definite::decide(p, Sense::PositiveDefinite)
}

pub(super) struct Stein<'a> {
    pub(super) a: &'a Matrix<f64>,
    pub(super) l: &'a Matrix<f64>,
    pub(super) c: &'a Matrix<f64>,
    pub(super) p: &'a Matrix<f64>,
    /// By how much V falls at least; none for any decrease.
    pub(super) factor: Option<f64>,
}

impl Expression for Stein<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let p = embed_symmetric::<R>(self.p, "P", self.a.rows())?;
        let next = error_matrix::<R>(self.a, self.l, self.c)?.congruence(&p)?;
        match self.factor {
            None => next.difference(&p),
            Some(factor) => {
                let factor = number::<R>(factor, "the factor")?;
                next.difference(&p.scaled(&factor.mul(&factor)))
            }
        }
    }
}

/// `(A - LC)'P(A - LC) - P < 0`: in discrete time, `V = e'Pe` decreases at each step. With [`positive`] of `P` it
/// proves that all eigenvalues of `A - LC` lie inside the unit circle.
/// # Errors
/// As [`lyapunov_decrease`].
pub fn stein_decrease(
    a: &Matrix<f64>,
    l: &Matrix<f64>,
    c: &Matrix<f64>,
    p: &Matrix<f64>,
) -> Result<Verdict<Direction>, ProofError> {
    Stein { a, l, c, p, factor: None }.decide(Sense::NegativeDefinite)
}

/// `(A - LC)'P(A - LC) - factor^2 P < 0`: in discrete time, `V = e'Pe` falls at each step by more than `factor^2`. With
/// [`positive`] of `P` it proves that all eigenvalues of `A - LC` are of modulus below `factor`.
/// # Errors
/// As [`lyapunov_decrease`].
pub fn stein_decrease_by(
    a: &Matrix<f64>,
    l: &Matrix<f64>,
    c: &Matrix<f64>,
    p: &Matrix<f64>,
    factor: f64,
) -> Result<Verdict<Direction>, ProofError> {
    Stein { a, l, c, p, factor: Some(factor) }.decide(Sense::NegativeDefinite)
}

struct Contraction<'a> {
    a: &'a Matrix<f64>,
    l: &'a Matrix<f64>,
    c: &'a Matrix<f64>,
    p: &'a Matrix<f64>,
    factor: f64,
}

impl Expression for Contraction<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let p = embed_symmetric::<R>(self.p, "P", self.a.rows())?;
        let factor = number::<R>(self.factor, "the factor")?;
        contraction(&error_matrix::<R>(self.a, self.l, self.c)?, &p, &factor)
    }
}

/// `[factor^2 P, F'P; PF, P]`.
fn contraction<R: Ring>(f: &Matrix<R>, p: &Matrix<R>, factor: &R) -> Result<Matrix<R>, ProofError> {
    p.scaled(&factor.mul(factor)).bordered(&p.product(f)?.transpose(), p)
}

/// `[factor^2 P, F'P; PF, P] > 0` with `F = A - LC` for every `A` and every `C` within the bounds, with the gain and
/// `P` as stored: by the Schur complement `V(e+) < factor^2 V(e)`, `V = e'Pe`, in discrete time. The margin is in the
/// units of the block matrix.
///
/// The inequality is linear in `(A, C)`: proved for boxes around the vertices of a polytope, it holds on their convex
/// hull. If all data are single numbers, the decision is exact if necessary.
/// # Errors
/// As [`lyapunov_decrease`], and for a `factor` that is not finite.
/// ```
/// use luenberger_proof::{Interval, Matrix, statement::contraction_within};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// // x+ = a x with a between 0.5 and 0.7 falls by the factor 0.75, without any output.
/// let a = Matrix::from_rows([[Interval::new(0.5, 0.7).expect("in order")]]);
/// let (l, p) = (Matrix::from_rows([[0.0]]), Matrix::from_rows([[1.0]]));
/// let c = Matrix::from_rows([[Interval::of(1.0)]]);
/// assert!(contraction_within(&a, &l, &c, &p, 0.75)?.is_proved());
/// assert!(!contraction_within(&a, &l, &c, &p, 0.65)?.is_proved());
/// # Ok(())
/// # }
/// ```
pub fn contraction_within(
    a: &Matrix<Interval>,
    l: &Matrix<f64>,
    c: &Matrix<Interval>,
    p: &Matrix<f64>,
    factor: f64,
) -> Result<Verdict<Direction>, ProofError> {
    if a.as_slice().iter().chain(c.as_slice()).all(Interval::is_point) {
        let (a, c) = (a.map(Interval::lo), c.map(Interval::lo));
        return Contraction { a: &a, l, c: &c, p, factor }.decide(Sense::PositiveDefinite);
    }
    let n = a.rows();
    a.expect_shape("A", (n, n))?;
    c.expect_shape("C", (c.rows(), n))?;
    let l = embed::<Interval>(l, "L", (n, c.rows()))?;
    let p = embed_symmetric::<Interval>(p, "P", n)?;
    let factor = number::<Interval>(factor, "the factor")?;
    definite::decide(&contraction(&a.difference(&l.product(c)?)?, &p, &factor)?, Sense::PositiveDefinite)
}

/// `A` is Hurwitz (all eigenvalues in the open left half plane), by the Lyapunov matrix `P`.
///
/// - Proved if `A'P + PA < 0` and `P > 0` are proved. The margin is a lower bound of minus the spectral abscissa:
///   `lambda_min(-(A'P + PA)) / (2 lambda_max(P))`.
/// - Refuted if `A'P + PA < 0` is proved and `P > 0` refuted: the solution that starts at the witness `v` has
///   `V = v'Pv <= 0`, decreasing, and cannot tend to 0.
/// - Undecided otherwise, since another `P` may prove it.
/// # Errors
/// As [`lyapunov_decrease`].
pub fn hurwitz(a: &Matrix<f64>, p: &Matrix<f64>) -> Result<Verdict<Direction>, ProofError> {
    let decrease =
        Decrease { a, output_injection: None, p, alpha: 0.0, what_p: "P" }.decide(Sense::NegativeDefinite)?;
    stable_by(decrease, p, |margin| (margin / (2.0 * largest_eigenvalue_bound(p))).next_down().max(0.0))
}

/// Stability from the verdict on the decrease of `V = x'Px` and the verdict on P. `margin` converts the margin of a
/// proved decrease to that of stability.
pub(super) fn stable_by(
    decrease: Verdict<Direction>,
    p: &Matrix<f64>,
    margin: impl FnOnce(f64) -> f64,
) -> Result<Verdict<Direction>, ProofError> {
    let decreases = match decrease {
        Verdict::Proved { margin } => margin,
        Verdict::Refuted { witness } => {
            let why = UndecidedReason::NotByThisMatrix { name: "P" };
            return Ok(Verdict::Undecided { why, best: -witness.value });
        }
        undecided @ Verdict::Undecided { .. } => return Ok(undecided),
    };
    Ok(match positive(p)? {
        Verdict::Proved { .. } => Verdict::Proved { margin: margin(decreases) },
        other => other,
    })
}

/// Upper bound of `sqrt(cond P)`: with `V = e'Pe <= exp(-2 rate t) V(0)`, `|e(t)| <= sqrt(cond P) exp(-rate t) |e(0)|`.
/// Infinite if `P > 0` is not proved.
///
/// # Errors
/// [`ProofError`] for a `P` that is not square, symmetric and finite.
/// ```
/// use luenberger_proof::{Matrix, statement::overshoot_bound};
/// let bound = overshoot_bound(&Matrix::from_rows([[9.0, 0.0], [0.0, 1.0]]))?;
/// assert!(bound >= 3.0 && bound < 3.0 + 1e-7);
/// # Ok::<(), luenberger_proof::ProofError>(())
/// ```
pub fn overshoot_bound(p: &Matrix<f64>) -> Result<f64, ProofError> {
    Ok(match positive(p)? {
        Verdict::Proved { margin } if margin > 0.0 => {
            (largest_eigenvalue_bound(p) / margin).next_up().sqrt().next_up().max(1.0)
        }
        _ => f64::INFINITY,
    })
}

/// Upper bound of the largest eigenvalue of a symmetric matrix, usually tight to about 1e-9; otherwise the largest sum
/// of absolute values of a row.
pub(crate) fn largest_eigenvalue_bound(p: &Matrix<f64>) -> f64 {
    let n = p.rows();
    let mut bound = 0.0_f64;
    for i in 0..n {
        bound =
            bound.max(p.row(i).iter().fold(0.0, |sum: f64, x| if *x == 0.0 { sum } else { (sum + x.abs()).next_up() }));
    }
    // bound I - P >= margin I proves the smaller bound (bound - margin).
    let gap = Matrix::from_fn(n, n, |i, j| {
        let entry = Exact::from_f64(p[(i, j)]).unwrap_or(Exact::zero()).neg();
        if i == j { entry.add(&Exact::from_f64(bound).unwrap_or(Exact::zero())) } else { entry }
    });
    match definite::decide(&gap, Sense::PositiveSemidefinite) {
        Ok(Verdict::Proved { margin }) if bound.is_finite() && margin < bound => (bound - margin).next_up(),
        _ => bound,
    }
}
