//! Algebraic Riccati equations of the linear-quadratic regulator and, by duality, of the steady-state Kalman filter.
//!
//! ```text
//! continuous   A'X + X A - X B R^-1 B'X + Q = 0                      K = R^-1 B'X                   A - B K Hurwitz
//! discrete     A'X A - X - A'X B (R + B'X B)^-1 B'X A + Q = 0        K = (R + B'X B)^-1 B'X A      A - B K Schur stable
//! ```
//!
//! For `Q >= 0`, `R > 0` a stabilizing solution exists iff `(A, B)` is stabilizable and no eigenvalue of `A` on the
//! stability boundary is unobservable through `Q`; it is unique, symmetric and positive semidefinite. For an indefinite
//! `Q`, as in H-infinity control and positive-real conditions, both conditions are necessary but not sufficient; a
//! stabilizing solution is unique and may be indefinite. So it is for an indefinite, regular `R`, as of H-infinity
//! filters: it exists iff no eigenvalue of the Hamiltonian (symplectic) pencil is on the stability boundary and the
//! stable subspace `[X1; X2]` has a regular X1. Newton's iteration is then not monotone; a solution is returned only
//! where the equation is verified to have one within the error bound (`riccati/condition.rs`).
//!
//! Method, continuous: ordered real Schur form of the Hamiltonian matrix (Laub, IEEE TAC 24, 1979), in
//! `riccati/hamiltonian.rs`. Discrete: the structure-preserving doubling algorithm (Chu, Fan, Lin and Wang, Int. J.
//! Control 77, 2004), which never inverts `A`, in `riccati/doubling.rs`; for an indefinite R the stable subspace of the
//! extended pencil (Van Dooren, SIAM J. Sci. Stat. Comput. 2, 1981), which does not invert R, in `riccati/bilinear.rs`.
//! All are followed by Newton's iteration
//! (Kleinman, IEEE TAC 13, 1968; Hewer, IEEE TAC 16, 1971; `riccati/newton.rs`) as long as it lowers the residual. If
//! the residual stays above rounding level, or no stabilizing solution is found, the equation is solved in coordinates
//! of the state in which `X` is near the identity (`riccati/normalized.rs`).

mod bilinear;
mod condition;
mod coordinates;
mod doubling;
mod generalized;
mod hamiltonian;
mod input_weight;
mod kalman;
mod newton;
mod normalized;
mod popov;
mod scaled;

use crate::argument::{RealMatrixView, owned};
use crate::definite::positive_semidefinite;
use crate::forward_error::of_exact;
use crate::{LinalgError, Result};
use nalgebra::{Complex, DMatrix};
use scaled::{Data, Scaled, Weight};

pub use generalized::{generalized_care, generalized_dare};
pub use kalman::{
    Kalman, MeasurementUpdate, correlated_kalman_gain, discrete_correlated_kalman_gain, discrete_kalman_gain,
    kalman_gain, measurement_update,
};

/// Stabilizing solution of a Riccati equation, with residual, condition and error bound.
#[derive(Debug, Clone, PartialEq)]
pub struct Riccati {
    /// The solution, exactly symmetric: `x'X x` is the cost from the state `x`. Its entries are rounded: eigenvalues
    /// below eps times the largest are lost, including their signs. Then do not compute the gain from `x`; use `k`.
    pub x: DMatrix<f64>,
    /// The feedback gain, m x n, of `u = -K x`. It is not computed from the rounded `x`, and it stabilizes as stored.
    pub k: DMatrix<f64>,
    /// Eigenvalues of `A - B K` (of the pencil with E, if there is one), all stable. If K is so large that A is lost
    /// when `A - B K` is formed entry by entry, these are the poles of the exact closed loop; the matrix formed in
    /// double precision may have others, even unstable ones.
    pub poles: Vec<Complex<f64>>,
    /// Frobenius norm of the defect of the equation, relative to the sum of the norms of its terms, in units of the
    /// state (powers of two) that balance the plant and its weights.
    pub residual: f64,
    /// Condition number: to first order, the relative change of `X` per relative change of `A`, `B R^-1 B'` and `Q`
    /// (Kenney and Hewer, SIAM J. Control Optim. 28, 1990). It grows as the separation of the closed loop shrinks. In
    /// the units of `residual`.
    pub condition: f64,
    /// Bound of `||X - X*|| / ||X*||` in the Frobenius norm and the user's units, X* being the exact solution for the
    /// data as given: the defect, including its rounding error, times the norm of the inverse of the derivative.
    /// Infinite if the defect is too large for this bound, or if no digit is known.
    pub forward_error: f64,
}

/// Continuous algebraic Riccati equation `A'X + X A - X B R^-1 B'X + Q = 0`: the stabilizing solution.
///
/// `a` is n x n, `b` n x m, `q` n x n symmetric, `r` m x m symmetric and regular. For `q >= 0` and `r > 0` the input
/// `u = -K x`, `K = R^-1 B'X`, minimises the integral of `x'Q x + u'R u` along `x' = A x + B u` ([`lqr`] requires
/// both). A common factor of `q` and `r` does not change K. About 300 n^3 flops with the condition, up to 50 n^3
/// for each Newton step (three at most), and another 300 n^3 for each change of coordinates (six at most) if the
/// eigenvalues of X differ so much that one is needed.
///
/// An indefinite `r` has the same equation, without a change of sign: that of the H-infinity filter of
/// `x' = A x + E w`, `y = C x + v`, `z = H x` is `care(A', [C' H'], EE', diag(I, -gamma^2 I))`; its X is the P of
/// `A P + P A' - P (C'C - H'H/gamma^2) P + EE' = 0`, and the first rows of K are the transposed gain. The filter exists
/// if X is also positive semidefinite, which is not implied. The bounded-real equation of (A, B, C) has
/// `Q = C'C`, `R = -gamma^2 I`. The solution is verified to exist, with a finite `forward_error`.
///
/// # Errors
/// [`LinalgError::NotPositiveDefinite`] (a semidefinite, singular `r`, with its smallest eigenvalue);
/// [`LinalgError::Singular`] for an indefinite `r` that is singular to working precision, and [`LinalgError::NotGraph`]
/// for one with which the stable subspace has no X; [`LinalgError::NotStabilizable`] names an eigenvalue that no input
/// moves, [`LinalgError::NotWeighted`] one on the imaginary axis that is unobservable through `q`;
/// [`LinalgError::NotStabilizing`] if the closed loop is not stable, and [`LinalgError::NoStabilizingSolution`] if
/// there is none: for `q >= 0`, `r > 0` only because of rounding, otherwise also because no stabilizing solution
/// exists; [`LinalgError::NotConverged`] if the relative residual exceeds sqrt(eps); [`LinalgError::NotSquare`],
/// [`LinalgError::DimensionMismatch`], [`LinalgError::NotFinite`], [`LinalgError::NotSymmetric`],
/// [`LinalgError::Overflow`].
///
/// # Example
/// ```
/// use nalgebra::{Matrix1, Matrix2, Vector2, dmatrix};
/// // Double integrator.
/// let (a, b) = (Matrix2::new(0.0, 1.0, 0.0, 0.0), Vector2::new(0.0, 1.0));
/// let (q, r) = (Matrix2::new(1.0, 0.0, 0.0, 2.0), Matrix1::new(1.0));
/// let riccati = luenberger_linalg::care(&a, &b, &q, &r)?;
/// println!("X = {}K = {}residual {:e}", riccati.x, riccati.k, riccati.residual);
/// assert!(riccati.residual <= 20.0 * 2.0 * f64::EPSILON);
/// assert!((riccati.x - dmatrix![2.0, 1.0; 1.0, 2.0]).amax() <= 100.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Laub, IEEE TAC 24, 1979; SLICOT SB02MD, whose example this is.
pub fn care<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    q: impl Into<RealMatrixView<'a>>,
    r: impl Into<RealMatrixView<'a>>,
) -> Result<Riccati> {
    let (a, b, q, r) = (owned(a), owned(b), owned(q), owned(r));
    continuous(&Data { a: &a, b: &b, q: &q, r: &r, weight: Weight::Symmetric })
}

fn continuous(data: &Data<'_>) -> Result<Riccati> {
    finish(&Scaled::new(data, false)?, hamiltonian::solve)
}

/// Discrete algebraic Riccati equation `A'X A - X - A'X B (R + B'X B)^-1 B'X A + Q = 0`: the stabilizing solution.
///
/// `a` is n x n and may be singular, `b` n x m, `q` n x n symmetric, `r` m x m symmetric and regular, or semidefinite
/// if `R + B'X B > 0` ([`generalized_dare`] is then used). For `q >= 0`, `r > 0` the input `u = -K x`,
/// `K = (R + B'X B)^-1 B'X A`, minimises the sum of `x'Q x + u'R u` along `x+ = A x + B u` ([`dlqr`] requires `q >= 0`
/// and `r > 0`). For an indefinite `q` or `r` a solution is found if `R + B'X B` is regular, of whatever signs: it is a
/// minimum only if `R + B'X B > 0`, and that of an H-infinity filter must be checked to have the signs of `r`. Such a
/// solution is verified to exist, with a finite `forward_error`, unless `R + B'X B > 0`. About 15 n^3 flops
/// for each doubling (usually ten, at most 60), up to 60 n^3 for each Newton step (three at most), and 400 n^3 for each
/// change of coordinates (six at most) if the eigenvalues of X differ so much that one is needed.
///
/// # Errors
/// As [`care`], with the unit circle as stability boundary; [`LinalgError::Overflow`] also if entries of `a` exceed
/// 2^100.
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// // Double integrator, sampled; and X = (1 + sqrt 5)/2 for a = b = q = r = 1.
/// let (a, b) = (dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1]);
/// let (q, r) = (dmatrix![1.0, 0.0; 0.0, 0.0], dmatrix![1.0]);
/// let riccati = luenberger_linalg::dare(&a, &b, &q, &r)?;
/// println!("K = {}residual {:e}", riccati.k, riccati.residual);
/// assert!(riccati.residual <= 20.0 * 2.0 * f64::EPSILON);
/// assert!(riccati.poles.iter().all(|pole| pole.norm() < 1.0));
/// let one = dmatrix![1.0];
/// let golden = luenberger_linalg::dare(&one, &one, &one, &one)?.x[(0, 0)];
/// assert!((golden - (1.0 + 5.0_f64.sqrt()) / 2.0).abs() <= 10.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Chu, Fan, Lin and Wang, Int. J. Control 77, 2004; Hewer, IEEE TAC 16, 1971.
pub fn dare<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    q: impl Into<RealMatrixView<'a>>,
    r: impl Into<RealMatrixView<'a>>,
) -> Result<Riccati> {
    let (a, b, q, r) = (owned(a), owned(b), owned(q), owned(r));
    discrete_or_singular(&Data { a: &a, b: &b, q: &q, r: &r, weight: Weight::Symmetric })
}

/// R may be singular: an input without a weight is decided by its effect.
fn discrete_or_singular(data: &Data<'_>) -> Result<Riccati> {
    discrete(data).or_else(|error| {
        let Data { a, b, q, r, weight } = *data;
        if !matches!(error, LinalgError::NotPositiveDefinite { .. }) || positive_semidefinite("R", r).is_err() {
            return Err(error);
        }
        if weight == Weight::Semidefinite {
            positive_semidefinite("Q", q)?;
        }
        let (s, e) = (DMatrix::zeros(b.nrows(), b.ncols()), DMatrix::identity(a.nrows(), a.nrows()));
        generalized_dare(a, b, q, r, &s, &e)
    })
}

fn discrete(data: &Data<'_>) -> Result<Riccati> {
    let problem = Scaled::new(data, true)?;
    if !problem.is_definite() {
        return finish(&problem, bilinear::solve);
    }
    finish(&problem, doubling::solve).or_else(|failure| {
        // With an indefinite Q there may be a solution whose R + B'X B has eigenvalues of other signs than R.
        let may_have_another = matches!(
            failure,
            LinalgError::NoStabilizingSolution
                | LinalgError::NotStabilizing { .. }
                | LinalgError::NotConverged { .. }
                | LinalgError::Overflow { .. }
        ) && positive_semidefinite("Q", &problem.q).is_err();
        let other = if may_have_another { problem.with_any_signs() } else { None };
        other.and_then(|problem| finish(&problem, bilinear::solve).ok()).ok_or(failure)
    })
}

/// Continuous linear-quadratic regulator: [`care`] for `q` positive semidefinite.
///
/// # Errors
/// Those of [`care`], and [`LinalgError::NotPositiveSemidefinite`] (`q`).
pub fn lqr<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    q: impl Into<RealMatrixView<'a>>,
    r: impl Into<RealMatrixView<'a>>,
) -> Result<Riccati> {
    let (a, b, q, r) = (owned(a), owned(b), owned(q), owned(r));
    continuous(&Data { a: &a, b: &b, q: &q, r: &r, weight: Weight::Semidefinite })
}

/// Discrete linear-quadratic regulator: [`dare`] for `q` positive semidefinite.
///
/// # Errors
/// Those of [`dare`], and [`LinalgError::NotPositiveSemidefinite`] (`q`).
pub fn dlqr<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    q: impl Into<RealMatrixView<'a>>,
    r: impl Into<RealMatrixView<'a>>,
) -> Result<Riccati> {
    let (a, b, q, r) = (owned(a), owned(b), owned(q), owned(r));
    discrete(&Data { a: &a, b: &b, q: &q, r: &r, weight: Weight::Semidefinite })
}

/// Poles, residual, condition and error bound of a solution, in the units of computation.
struct Evidence {
    poles: Vec<Complex<f64>>,
    residual: f64,
    condition: f64,
    forward_error: f64,
}

/// A stabilizing solution in the units of computation.
struct Outcome {
    x: DMatrix<f64>,
    k: DMatrix<f64>,
    evidence: Evidence,
}

/// Solves by `method`, and in other coordinates of the state if the residual is too large. Returns only a solution that
/// satisfies the equation and stabilizes.
fn finish(problem: &Scaled, method: fn(&Scaled) -> Result<DMatrix<f64>>) -> Result<Riccati> {
    // Residual of a good method followed by a Newton step.
    let good = 10.0 * problem.a.nrows() as f64 * f64::EPSILON;
    let outcome = match method(problem).and_then(|x| newton::settle(problem, x)) {
        Ok(plain) if plain.evidence.residual <= good && is_verified(problem, &plain) => plain,
        Ok(plain) => match normalized::solve(problem, Some(&plain.x))? {
            // The entries of X are rounded: its error bound says more than its residual.
            Some(better) if better.evidence.forward_error <= plain.evidence.forward_error => solved(problem, better)?,
            _ => solved(problem, plain)?,
        },
        // No eigenvalue of the plant explains the failure; rounding may be the cause.
        Err(failure @ (LinalgError::NotStabilizing { .. } | LinalgError::NoStabilizingSolution)) => {
            match normalized::solve(problem, None)?.filter(|found| is_verified(problem, found)) {
                // Rounded entries of X can have a large residual beside a gain that stabilizes, if the equations of its
                // closed loop can be solved.
                Some(found) if found.evidence.condition.is_finite() => found,
                Some(found) => solved(problem, found)?,
                None => return Err(failure),
            }
        }
        Err(failure) => return Err(failure),
    };
    exists(problem, &outcome)?;
    delivered(problem, outcome)
}

/// The solution in coordinates in which it is near the identity, also where those of the problem would do.
///
/// # Errors
/// Those of [`care`] for the data.
#[doc(hidden)]
pub fn near_identity(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
    discrete: bool,
) -> Result<Option<Riccati>> {
    let problem = Scaled::new(&Data { a, b, q, r, weight: Weight::Symmetric }, discrete)?;
    normalized::solve(&problem, None)?.map(|outcome| delivered(&problem, outcome)).transpose()
}

/// A solution in the user's units.
fn delivered(problem: &Scaled, outcome: Outcome) -> Result<Riccati> {
    let Outcome { x, k, evidence: Evidence { poles, residual, condition, forward_error } } = outcome;
    let (x, k) = problem.in_user_units(&x, &k).ok_or(LinalgError::Overflow { what: "the solution x or the gain k" })?;
    let poles = poles.into_iter().map(|l| l / problem.time).collect();
    let growth = problem.growth(&x);
    let forward_error = if forward_error == 0.0 { 0.0 } else { of_exact(forward_error * growth) };
    Ok(Riccati { x, k, poles, residual, condition, forward_error })
}

/// Error if no digit of the solution is known, Q is indefinite, and a pole is as near to the boundary as the defect
/// leaves open: there may be no stabilizing solution.
fn exists(problem: &Scaled, Outcome { k, evidence, .. }: &Outcome) -> Result<()> {
    if evidence.forward_error.is_finite() || positive_semidefinite("Q", &problem.q).is_ok() {
        return Ok(());
    }
    let terms = problem.a.norm() + problem.b.norm() * k.norm();
    let size = if problem.discrete { terms.max(1.0) } else { terms };
    popov::resolved(problem, &evidence.poles, double_root(evidence.residual, problem.a.nrows(), size))
}

/// How far from the boundary the poles may be found that a double eigenvalue on it has become, by a relative defect of
/// the equation for a closed loop of this size: its root.
fn double_root(defect: f64, n: usize, size: f64) -> f64 {
    10.0 * defect.max(f64::EPSILON).sqrt() * n as f64 * size
}

/// For an indefinite R only a solution that is verified to exist is returned: its error has a bound. For a definite
/// one, the closed loop says enough.
fn is_verified(problem: &Scaled, outcome: &Outcome) -> bool {
    problem.is_definite() || outcome.evidence.forward_error.is_finite()
}

/// Why an X of this norm is not verified: X1 is nearly singular, or else the pole nearest to the boundary, given with
/// its distance, may be on it.
fn unverified(size: f64, (eigenvalue, distance): (Complex<f64>, f64)) -> LinalgError {
    let sigma_min = hamiltonian::sigma_min(size);
    if sigma_min <= f64::EPSILON.sqrt() {
        LinalgError::NotGraph { sigma_min }
    } else {
        LinalgError::NotStabilizing { eigenvalue, distance }
    }
}

/// Error if the solution is not verified, or if the relative residual exceeds sqrt(eps): rounding alone does not
/// explain it.
fn solved(problem: &Scaled, outcome: Outcome) -> Result<Outcome> {
    if !is_verified(problem, &outcome) {
        let nearest = popov::nearest(problem, &outcome.evidence.poles).unwrap_or_default();
        return Err(unverified(outcome.x.norm(), (nearest.0 / problem.time, nearest.1 / problem.time)));
    }
    let (residual, allowed) = (outcome.evidence.residual, f64::EPSILON.sqrt());
    if residual <= allowed {
        return Ok(outcome);
    }
    Err(LinalgError::NotConverged {
        method: "Newton's iteration for the Riccati equation",
        iterations: newton::NEWTON_STEPS,
        remaining: residual,
        allowed,
    })
}
