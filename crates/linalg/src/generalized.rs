//! Generalised Lyapunov equation `A'P E + E'P A + Q = 0` of the descriptor plant `E x' = A x`, and generalised Stein
//! equation `A'P A - E'P E + Q = 0` of `E x+ = A x`, E regular.
//!
//! With `F = A E^-1` and `W = E^-T Q E^-1` they are `F'P + P F + W = 0` and `F'P F - P + W = 0`. Multiplying out by
//! `E^-1` costs digits by the condition of E: the answer carries it. All of this is done with the equations and the
//! states in units in which the rows and columns of E have entries of about one: `R E C`, `R A C`, `C Q C` and `R^-1 P
//! R^-1`.

use crate::argument::{RealMatrixView, owned, shaped, square, symmetric, symmetric_part};
use crate::definite::in_units;
use crate::equilibration::Equilibrated;
use crate::forward_error::{of_exact, relative};
use crate::separation::norm;
use crate::units::shift;
use crate::{LinalgError, Lyapunov, Result, Stein, lyapunov, stein};
use nalgebra::DMatrix;

/// Solution of `A'P E + E'P A + Q = 0` with its evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct GeneralizedLyapunov {
    /// The solution, exactly symmetric.
    pub p: DMatrix<f64>,
    /// `||A'P E + E'P A + Q|| / (2 ||A|| ||P|| ||E|| + ||Q||)` in the Frobenius norm, in the units of the head.
    pub residual: f64,
    /// `||E|| ||E^-1||` in the Frobenius norm, in those units.
    pub condition_e: f64,
    /// The equation `F'P + P F + W = 0` that was solved in those units, with its separation.
    pub standard: Lyapunov,
    /// See [`forward_error`](Self::forward_error).
    forward_error: f64,
}

impl GeneralizedLyapunov {
    /// A bound of `||P - P*|| / ||P*||` in the Frobenius norm, P* the solution for the data as given. The error solves
    /// the equation for the defect D, and `E^-T D E^-1` in the standard one: at most `||E^-1||^2 ||D||` over its
    /// separation, D known up to the rounding of its three products. For a pencil that is not stable, as far as the
    /// estimate of the separation is right to a factor of three.
    pub fn forward_error(&self) -> f64 {
        self.forward_error
    }
}

/// Solves `A'P E + E'P A + Q = 0` for symmetric P: `V = x'E'P E x` decreases along `E x' = A x` at the rate `x'Q x`.
///
/// `a`, `e` and `q` are n x n, `e` regular, `q` symmetric. A unique P exists iff no two eigenvalues of the pencil
/// `A - lambda E` add to zero. About 50 n^3 flops.
/// # Errors
/// [`LinalgError::Singular`] for an `e` whose condition leaves no digits, [`LinalgError::Overflow`] where squares of
/// the entries leave the range, and those of [`lyapunov()`] for `A E^-1`, of which none says that the equation is
/// singular: `A E^-1` is rounded.
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let (a, e) = (dmatrix![-1.0, 2.0; 0.0, -3.0], dmatrix![2.0, 0.0; 1.0, 1.0]);
/// let q = dmatrix![1.0, 0.0; 0.0, 1.0];
/// let found = luenberger_linalg::generalized_lyapunov(&a, &e, &q)?;
/// let defect = a.transpose() * &found.p * &e + e.transpose() * &found.p * &a + q;
/// println!("residual {:e}, {:e}", found.residual, defect.norm());
/// assert!(found.residual <= 10.0 * 2.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
/// Source: Penzl, Adv. Comput. Math. 8, 1998 (SLICOT SG03AD), for the equation; the reduction is the definition.
pub fn generalized_lyapunov<'a>(
    a: impl Into<RealMatrixView<'a>>,
    e: impl Into<RealMatrixView<'a>>,
    q: impl Into<RealMatrixView<'a>>,
) -> Result<GeneralizedLyapunov> {
    solved_lyapunov(&owned(a), &owned(e), &owned(q))
}

fn solved_lyapunov(a: &DMatrix<f64>, e: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<GeneralizedLyapunov> {
    let Reduced { a, e, q, inverse, condition_e, f, w, rows } = Reduced::new(a, e, q)?;
    let standard = lyapunov(&f, &w).map_err(rounded)?;
    let p = standard.p.clone();
    let half = e.tr_mul(&p) * &a;
    let defect = (half.transpose() + half + &q).norm();
    let size = 2.0 * a.norm() * p.norm() * e.norm() + q.norm();
    let residual = relative(defect, size);
    if residual.is_nan() || !size.is_finite() {
        return Err(LinalgError::Overflow { what: "the defect of the generalised Lyapunov equation" });
    }
    let factor = 2.0 * inverse.norm().powi(2) * standard.spread() / standard.separation;
    let forward_error = error_bound(residual, size, factor, &p, standard.forward_error());
    let (p, forward_error) = in_given_units(&p, forward_error, &rows)?;
    Ok(GeneralizedLyapunov { p, residual, condition_e, standard, forward_error })
}

/// Solution of `A'P A - E'P E + Q = 0` with its evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct GeneralizedStein {
    /// The solution, exactly symmetric.
    pub p: DMatrix<f64>,
    /// `||A'P A - E'P E + Q|| / ((||A||^2 + ||E||^2) ||P|| + ||Q||)` in the Frobenius norm, in the units of the head.
    pub residual: f64,
    /// `||E|| ||E^-1||` in the Frobenius norm, in those units.
    pub condition_e: f64,
    /// The equation `F'P F - P + W = 0` that was solved in those units, with its separation.
    pub standard: Stein,
    /// See [`forward_error`](Self::forward_error).
    forward_error: f64,
}

impl GeneralizedStein {
    /// A bound of `||P - P*|| / ||P*||` in the Frobenius norm, P* the solution for the data as given: as
    /// [`GeneralizedLyapunov::forward_error`].
    pub fn forward_error(&self) -> f64 {
        self.forward_error
    }
}

/// Solves `A'P A - E'P E + Q = 0` for symmetric P: `V = x'E'P E x` decreases along `E x+ = A x` by `x'Q x` at each
/// step.
///
/// `a`, `e` and `q` are n x n, `e` regular, `q` symmetric. A unique P exists iff no two eigenvalues of the pencil
/// `A - lambda E` multiply to one. About 55 n^3 flops.
/// # Errors
/// [`LinalgError::Singular`] for an `e` whose condition leaves no digits, [`LinalgError::Overflow`] where squares of
/// the entries leave the range, and those of [`stein()`] for `A E^-1`, as there.
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let (a, e) = (dmatrix![0.5, 1.0; 0.0, -0.25], dmatrix![2.0, 0.0; 1.0, 1.0]);
/// let q = dmatrix![1.0, 0.0; 0.0, 1.0];
/// let found = luenberger_linalg::generalized_stein(&a, &e, &q)?;
/// let defect = a.transpose() * &found.p * &a - e.transpose() * &found.p * &e + q;
/// println!("residual {:e}, {:e}", found.residual, defect.norm());
/// assert!(found.residual <= 10.0 * 2.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
/// Source: Penzl, Adv. Comput. Math. 8, 1998 (SLICOT SG03AD, DICO = 'D'), for the equation; the reduction is the
/// definition.
pub fn generalized_stein<'a>(
    a: impl Into<RealMatrixView<'a>>,
    e: impl Into<RealMatrixView<'a>>,
    q: impl Into<RealMatrixView<'a>>,
) -> Result<GeneralizedStein> {
    solved_stein(&owned(a), &owned(e), &owned(q))
}

fn solved_stein(a: &DMatrix<f64>, e: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<GeneralizedStein> {
    let Reduced { a, e, q, inverse, condition_e, f, w, rows } = Reduced::new(a, e, q)?;
    let standard = stein(&f, &w).map_err(rounded)?;
    let p = standard.p.clone();
    let defect = (a.tr_mul(&p) * &a - e.tr_mul(&p) * &e + &q).norm();
    let size = (a.norm().powi(2) + e.norm().powi(2)) * p.norm() + q.norm();
    let residual = relative(defect, size);
    if residual.is_nan() || !size.is_finite() {
        return Err(LinalgError::Overflow { what: "the defect of the generalised Stein equation" });
    }
    let factor = 2.0 * inverse.norm().powi(2) * standard.spread() / standard.separation;
    let forward_error = error_bound(residual, size, factor, &p, standard.forward_error());
    let (p, forward_error) = in_given_units(&p, forward_error, &rows)?;
    Ok(GeneralizedStein { p, residual, condition_e, standard, forward_error })
}

/// The equation in balanced units, and the standard one for `F = A E^-1` and `W = E^-T Q E^-1` there.
struct Reduced {
    a: DMatrix<f64>,
    e: DMatrix<f64>,
    q: DMatrix<f64>,
    inverse: DMatrix<f64>,
    condition_e: f64,
    f: DMatrix<f64>,
    w: DMatrix<f64>,
    /// Powers of two of R.
    rows: Vec<i32>,
}

impl Reduced {
    fn new(a: &DMatrix<f64>, e: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<Self> {
        let n = square("A", a)?;
        shaped("E", e, n, n)?;
        shaped("Q", q, n, n)?;
        let q = symmetric("Q", q)?;
        let Equilibrated { matrix: e, rows, columns } = Equilibrated::new(e);
        let a = DMatrix::from_fn(n, n, |i, j| shift(a[(i, j)], rows[i] + columns[j]));
        let q = in_units(&q, &columns);
        let inverse = e.clone().lu().try_inverse().filter(|m| m.iter().all(|x| x.is_finite()));
        let condition_e = inverse.as_ref().map_or(f64::INFINITY, |inverse| norm(inverse) * norm(&e));
        let Some(inverse) = inverse.filter(|_| n == 0 || condition_e * n as f64 * f64::EPSILON < 1.0) else {
            return Err(LinalgError::Singular { what: "E", condition: condition_e });
        };
        let w = symmetric_part(&(inverse.tr_mul(&q) * &inverse));
        Ok(Self { f: &a * &inverse, a, e, q, inverse, condition_e, w, rows })
    }
}

/// `P = R P^ R`, and what its relative error, in the Frobenius norm, may grow to: with `|E_ij| <= ||E||`,
/// `||R E R|| <= ||E|| tr(R^2)`.
fn in_given_units(p: &DMatrix<f64>, forward_error: f64, rows: &[i32]) -> Result<(DMatrix<f64>, f64)> {
    let back = in_units(p, rows);
    if !back.iter().all(|x| x.is_finite()) || (norm(&back) == 0.0 && norm(p) > 0.0) {
        return Err(LinalgError::Overflow { what: "the solution p" });
    }
    let size = norm(&back);
    if size == 0.0 || rows.iter().all(|&e| e == rows[0]) || forward_error == 0.0 {
        return Ok((back, forward_error));
    }
    let trace: f64 = rows.iter().map(|&e| shift(1.0, 2 * e)).sum();
    Ok((back, of_exact(forward_error * norm(p) * trace / size)))
}

/// `A E^-1` is rounded: that its equation is singular does not say that the one given is.
fn rounded(error: LinalgError) -> LinalgError {
    match error {
        LinalgError::SingularEquation { equation, first, second, gap } => LinalgError::UndecidedEquation {
            equation,
            regular: false,
            first,
            second,
            gap,
            separation: 0.0,
            condition: f64::INFINITY,
            digits: None,
        },
        // Nor that it is regular.
        LinalgError::UndecidedEquation { equation, first, second, gap, separation, condition, digits, .. } => {
            LinalgError::UndecidedEquation {
                equation,
                regular: false,
                first,
                second,
                gap,
                separation,
                condition,
                digits,
            }
        }
        other => other,
    }
}

/// `factor` takes a defect to an error: `||E^-1||^2` over the separation, twice for what the rounding of F moves it.
/// The defect is known up to the rounding of its products, relative to their `size`.
fn error_bound(residual: f64, size: f64, factor: f64, p: &DMatrix<f64>, standard: f64) -> f64 {
    let known = (residual + 3.0 * p.nrows() as f64 * f64::EPSILON) * size;
    // As in the standard equation: beyond one, rounding decides the separation too.
    if standard < 1.0 { of_exact(relative(factor * known, p.norm())) } else { f64::INFINITY }
}
