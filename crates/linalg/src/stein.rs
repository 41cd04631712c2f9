//! Discrete Lyapunov (Stein) equation `A'P A - P + Q = 0`.
//!
//! `P` exists and is unique iff no two eigenvalues of `A` multiply to one. For Schur-stable `A` and `Q > 0` it is
//! positive definite, and `V(e) = e'Pe` decreases along `e+ = A e` by `e'Qe` at each step. The transposed equation
//! `A P A' - P + Q = 0` (Gramian, covariance) is this one with `A'` for `A`.
//!
//! Method: real Schur form `A = U T U'`, then `T'Y T - Y = -U'Q U` by recursive substitution (Kitagawa, Int. J. Control
//! 25, 1977; Jonsson and Kagstrom, ACM TOMS 28, 2002).

use crate::Result;
use crate::argument::{RealMatrixView, owned, shaped, square, symmetric};
use crate::forward_error::{ErrorScale, forward_error};
use crate::schur_operator::{Kind, SchurEquation};
use nalgebra::{Complex, DMatrix};

/// Solution of `A'P A - P + Q = 0` with residual, separation and condition.
///
/// If the equation was solved in balanced units of the state (see [`stein()`]), residual, separation and condition are
/// in those units; [`forward_error`](Self::forward_error) is in the units of `p`.
#[derive(Debug, Clone, PartialEq)]
pub struct Stein {
    /// The solution, exactly symmetric.
    pub p: DMatrix<f64>,
    /// `||A'P A - P + Q|| / ((||A||^2 + 1) ||P|| + ||Q||)` in the Frobenius norm.
    pub residual: f64,
    /// Separation `min ||A'X A - X|| / ||X||`. For Schur-stable `A`, in the spectral norm, it is `1 / ||H||` with
    /// `A'H A - H + I = 0`; the value returned is `1 / ||H||_F`, too small by at most a factor of sqrt(n). Otherwise
    /// the norm is the sum of the absolute entries in the coordinates of the Schur form, and the value is an estimate
    /// from above, seldom more than three times too large.
    pub separation: f64,
    /// Condition number `(||A||^2 + 1) / separation`: to first order, the relative change of `P` per relative change of
    /// the data. The relative error of `P` is at most about this times `n eps`; often it is far smaller.
    pub condition: f64,
    /// Factor from an error in the norm of the separation to one of `p` in the Frobenius norm and the user's units.
    spread: ErrorScale,
}

impl Stein {
    /// First-order bound of the relative error of `P`, as [`Lyapunov::forward_error`](crate::Lyapunov::forward_error).
    pub fn forward_error(&self) -> f64 {
        forward_error(self.residual, self.condition, self.p.nrows(), self.spread)
    }

    pub(crate) fn spread(&self) -> f64 {
        self.spread.norms * self.spread.units
    }
}

/// The solution without residual and condition; `None` if the equation is singular to working precision.
pub(crate) fn stein_step(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<Option<DMatrix<f64>>> {
    SchurEquation::step(Kind::Stein, a, q)
}

/// `A'P A - P + Q = 0` for one `A` and any number of `Q`: the Schur form is computed once, each solution costs about
/// `14 n^3`.
/// ```
/// use luenberger_linalg::SteinEquation;
/// use nalgebra::dmatrix;
/// let a = dmatrix![0.5, 1.0; 0.0, -0.5];
/// let mut equation = SteinEquation::new(&a)?;
/// for q in [dmatrix![1.0, 0.0; 0.0, 1.0], dmatrix![0.0, 0.0; 0.0, 1.0]] {
///     assert!(equation.solve(&q)?.residual <= 10.0 * 2.0 * f64::EPSILON);
/// }
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SteinEquation(SchurEquation);

impl SteinEquation {
    /// The equation for `a` (n x n).
    /// # Errors
    /// As [`stein()`]: whether the equation has a unique solution does not depend on `Q`.
    pub fn new(a: &DMatrix<f64>) -> Result<Self> {
        SchurEquation::new(Kind::Stein, a).map(Self)
    }

    /// Replaces the equation by that for `a`, in the same memory: with a Schur-stable `a` of the same order nothing is
    /// allocated, unless the state has to be balanced. After an error, solutions are errors until the next successful
    /// `refactor`.
    /// # Errors
    /// As [`new`](Self::new).
    pub fn refactor(&mut self, a: &DMatrix<f64>) -> Result<()> {
        self.0.refactor(a)
    }

    /// The solution for the symmetric n x n matrix `q`.
    /// # Errors
    /// [`LinalgError::DimensionMismatch`](crate::LinalgError::DimensionMismatch),
    /// [`LinalgError::NotFinite`](crate::LinalgError::NotFinite),
    /// [`LinalgError::NotSymmetric`](crate::LinalgError::NotSymmetric),
    /// [`LinalgError::Overflow`](crate::LinalgError::Overflow);
    /// [`LinalgError::UndecidedEquation`](crate::LinalgError::UndecidedEquation) if the separation is at rounding level
    /// and refinement does not converge for this `q`.
    pub fn solve(&mut self, q: &DMatrix<f64>) -> Result<Stein> {
        shaped("Q", q, self.0.order(), self.0.order())?;
        let mut p = symmetric("Q", q)?;
        let residual = self.0.solve_in_place(&mut p)?;
        Ok(self.solution(p, residual))
    }

    /// What is known of the solution `p`, found with this residual.
    fn solution(&self, p: DMatrix<f64>, residual: f64) -> Stein {
        let spread = self.0.spread(&p);
        Stein { p, residual, separation: self.0.separation(), condition: self.0.condition(), spread }
    }

    /// As [`solve`](Self::solve), into `p`, and returns the relative residual. Allocates nothing if `p` is n x n
    /// already (unless the state had to be balanced).
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn solve_into(&mut self, q: &DMatrix<f64>, p: &mut DMatrix<f64>) -> Result<f64> {
        self.0.solve_into(q, p)
    }

    /// One step of iterative refinement of `p`, in place, as
    /// [`LyapunovEquation::refine`](crate::LyapunovEquation::refine): returns the size of the correction relative to
    /// `p`.
    /// # Errors
    /// As [`solve`](Self::solve), and for a `p` that is not symmetric.
    pub fn refine(&mut self, q: &DMatrix<f64>, p: &mut DMatrix<f64>) -> Result<f64> {
        self.0.refine(q, p)
    }

    /// The eigenvalues of `a`.
    pub fn eigenvalues(&self) -> Vec<Complex<f64>> {
        self.0.eigenvalues()
    }

    /// Whether all eigenvalues of `a` lie inside the unit circle.
    pub fn is_stable(&self) -> bool {
        self.0.is_stable()
    }

    /// Separation `min ||A'X A - X||_1 / ||X||_1`, entries summed, in the coordinates of the Schur form: an estimate
    /// from above by at most eleven substitutions.
    pub fn separation_estimate(&self) -> f64 {
        self.0.estimated_separation_in_units()
    }
}

/// Solves `A'P A - P + Q = 0` for symmetric `P`.
///
/// `a` and `q` are n x n, `q` symmetric (definite or not). A unique `P` exists iff `lambda_i lambda_j != 1` for all
/// eigenvalues of `a`. Singular `a` is allowed. The equation is solved in balanced units of the state (powers of two,
/// rows and columns of `a` of equal size) if that makes the largest entry of `a` a thousand times smaller, or if the
/// equation seems singular otherwise. About 32 n^3 flops for `P`, and at most 33 n^3 for the separation.
///
/// # Errors
/// [`LinalgError::SingularEquation`](crate::LinalgError::SingularEquation) names two eigenvalues whose product is one:
/// the determinant of the equation is zero for `a` as stored, computed in exact integer arithmetic;
/// [`LinalgError::UndecidedEquation`](crate::LinalgError::UndecidedEquation) if a pivot of the substitution is at
/// rounding level or the separation is at most `n eps max(1, ||A||)`, and refinement does not converge (see
/// [`lyapunov()`](crate::lyapunov())); [`LinalgError::NotSymmetric`](crate::LinalgError::NotSymmetric) names the entry
/// of `q` that differs from its mirror image; [`LinalgError::Overflow`](crate::LinalgError::Overflow) if entries of `a`
/// exceed 2^250 or `P` overflows;
/// [`LinalgError::NotSquare`](crate::LinalgError::NotSquare),
/// [`LinalgError::DimensionMismatch`](crate::LinalgError::DimensionMismatch),
/// [`LinalgError::NotFinite`](crate::LinalgError::NotFinite), and those of [`schur()`](crate::schur()).
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let a = dmatrix![0.5, 1.0; 0.0, -0.5];
/// let q = dmatrix![1.0, 0.0; 0.0, 1.0];
/// let stein = luenberger_linalg::stein(&a, &q)?;
/// let defect = a.transpose() * &stein.p * &a - &stein.p + q;
/// println!("residual {:e}, {:e}", stein.residual, defect.norm());
/// assert!(stein.residual <= 10.0 * 2.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Kitagawa, Int. J. Control 25, 1977; SLICOT SB03MD (DICO = 'D').
pub fn stein<'a>(a: impl Into<RealMatrixView<'a>>, q: impl Into<RealMatrixView<'a>>) -> Result<Stein> {
    solved(&owned(a), &owned(q))
}

fn solved(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<Stein> {
    let n = square("A", a)?;
    shaped("Q", q, n, n)?;
    let mut q = symmetric("Q", q)?;
    let (equation, residual) = SchurEquation::solved(Kind::Stein, a, &mut q)?;
    Ok(SteinEquation(equation).solution(q, residual))
}
