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

/// Solution of `A'P A - P + Q = 0` with its evidence.
///
/// Where the equation had to be solved in balanced units of the state (see [`stein()`]), residual, separation and
/// condition are in these units; [`forward_error`](Self::forward_error) is in those of `p`.
#[derive(Debug, Clone, PartialEq)]
pub struct Stein {
    /// The solution, exactly symmetric.
    pub p: DMatrix<f64>,
    /// `||A'P A - P + Q|| / ((||A||^2 + 1) ||P|| + ||Q||)` in the Frobenius norm.
    pub residual: f64,
    /// The separation, `min ||A'X A - X|| / ||X||`. For Schur-stable `A` in the spectral norm, where it is `1 / ||H||`
    /// with `A'H A - H + I = 0`; the number is `1 / ||H||_F`, not above it and at most sqrt(n) below. Otherwise with
    /// the sum of the absolute entries for norm, in the coordinates of the Schur form, and an estimate from above,
    /// seldom more than three times too large.
    pub separation: f64,
    /// `(||A||^2 + 1) / separation`: about how much `P` may change, relative to its norm, for a unit relative change of
    /// the data. The relative error of `P` is at most about this times `n eps`; often it is far smaller.
    pub condition: f64,
    /// The factor from an error in the norm of the separation to one of `p` in Frobenius' and the user's units.
    spread: ErrorScale,
}

impl Stein {
    /// A bound of the relative error of `P` to first order, as
    /// [`Lyapunov::forward_error`](crate::Lyapunov::forward_error).
    pub fn forward_error(&self) -> f64 {
        forward_error(self.residual, self.condition, self.p.nrows(), self.spread)
    }

    pub(crate) fn spread(&self) -> f64 {
        self.spread.norms * self.spread.units
    }
}

/// The solution alone, for iterations that need no evidence; `None` if the equation is singular to working precision.
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

    /// Becomes the equation for `a`, in the memory that is there: with a Schur stable `a` of the same order nothing is
    /// allocated, unless the state has to be balanced. After an error it is the equation of no `a`, and solutions are
    /// errors until the next `refactor`.
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
    /// [`LinalgError::UndecidedEquation`](crate::LinalgError::UndecidedEquation) where the separation is rounding and
    /// refinement does not converge for this `q`.
    pub fn solve(&mut self, q: &DMatrix<f64>) -> Result<Stein> {
        shaped("q", q, self.0.order(), self.0.order())?;
        self.solve_symmetric(symmetric("q", q)?)
    }

    /// For an exactly symmetric matrix of the right order.
    fn solve_symmetric(&mut self, mut p: DMatrix<f64>) -> Result<Stein> {
        let residual = self.0.solve_in_place(&mut p)?;
        let spread = self.0.spread(&p);
        Ok(Stein { p, residual, separation: self.0.separation(), condition: self.0.condition(), spread })
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

    /// `min ||A'X A - X||_1 / ||X||_1`, entries summed, in the coordinates of the Schur form: an estimate from above by
    /// at most eleven substitutions.
    pub fn separation_estimate(&self) -> f64 {
        self.0.estimated_separation_in_units()
    }
}

/// Solves `A'P A - P + Q = 0` for symmetric `P`.
///
/// `a` and `q` are n x n, `q` symmetric (of either sign). A unique `P` exists iff `lambda_i lambda_j != 1` for all
/// eigenvalues of `a`. Singular `a` is allowed. Where it makes the largest entry of `a` a thousand times smaller, or
/// where `P` seems not to exist otherwise, the equation is solved in units of the state (powers of two) in which rows
/// and columns of `a` are of equal size. About 32 n^3 flops for `P`, and at most 33 n^3 for the separation.
///
/// # Errors
/// [`LinalgError::SingularEquation`](crate::LinalgError::SingularEquation) names two eigenvalues that multiply to one:
/// the determinant of the equation is zero for `a` as stored, computed in integers;
/// [`LinalgError::UndecidedEquation`](crate::LinalgError::UndecidedEquation) when a pivot of the substitution vanishes
/// against its rounding or the separation is not above `n eps max(1, ||A||)`, and refinement does not converge (see
/// [`lyapunov()`](crate::lyapunov())); [`LinalgError::NotSymmetric`](crate::LinalgError::NotSymmetric) names the entry
/// of `q` that differs from its mirror image; [`LinalgError::Overflow`](crate::LinalgError::Overflow) if `a` has
/// entries beyond 2^250, whose products leave the range, or `P` does;
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
    let n = square("a", a)?;
    shaped("q", q, n, n)?;
    let q = symmetric("q", q)?;
    SteinEquation::new(a)?.solve_symmetric(q)
}
