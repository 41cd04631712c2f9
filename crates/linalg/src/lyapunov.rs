//! Continuous Lyapunov equation `A'P + P A + Q = 0`.
//!
//! `P` exists and is unique iff no two eigenvalues of `A` add to zero. For Hurwitz `A` and `Q > 0` it is positive
//! definite, and `V(e) = e'Pe` decreases along `e' = A e` at the rate `e'Qe`: this is how every observer in this
//! workspace gets its certificate. The transposed equation `A P + P A' + Q = 0`, whose solution is a Gramian or a
//! covariance, is this one with `A'` for `A`.
//!
//! Method: real Schur form `A = U T U'`, then `T'Y + Y T = -U'Q U` by recursive substitution (Bartels and Stewart, CACM
//! 15, 1972; Jonsson and Kagstrom, ACM TOMS 28, 2002), in which only the upper triangle of the symmetric Y is computed.

use crate::Result;
use crate::argument::{RealMatrixView, owned, shaped, square, symmetric};
use crate::forward_error::{ErrorScale, forward_error};
use crate::schur_operator::{Kind, SchurEquation};
use nalgebra::{Complex, DMatrix};

/// Solution of `A'P + P A + Q = 0`, or of `A'P A - P + Q = 0` ([`Stein`](crate::Stein)), with its evidence.
///
/// Where the equation had to be solved in balanced units of the state (see [`lyapunov()`]), residual, separation and
/// condition are in these units; [`forward_error`](Self::forward_error) is in those of `p`. Of two formulas the second
/// is that of the Stein equation.
#[derive(Debug, Clone, PartialEq)]
pub struct Lyapunov {
    /// The solution, exactly symmetric.
    pub p: DMatrix<f64>,
    /// `||A'P + P A + Q|| / (2 ||A|| ||P|| + ||Q||)` or `||A'P A - P + Q|| / ((||A||^2 + 1) ||P|| + ||Q||)`, in the
    /// Frobenius norm.
    pub residual: f64,
    /// The separation, `min ||A'X + X A|| / ||X||` or `min ||A'X A - X|| / ||X||`. For a stable `A` (Hurwitz, or Schur
    /// stable) in the spectral norm, where it is `1 / ||H||` with the solution H for `Q = I`; the number is
    /// `1 / ||H||_F`, not above it and at most sqrt(n) below. Otherwise with the sum of the absolute entries for norm,
    /// in the coordinates of the Schur form, and an estimate from above, seldom more than three times too large.
    pub separation: f64,
    /// `2 ||A||_F / separation` or `(||A||_F^2 + 1) / separation`: about how much `P` may change, relative to its norm,
    /// for a unit relative change of the data. The relative error of `P` is at most about this times `n eps`; often it
    /// is far smaller.
    pub condition: f64,
    /// The factor from an error in the norm of the separation to one of `p` in Frobenius' and the user's units.
    spread: ErrorScale,
}

impl Lyapunov {
    /// A bound of `||P - P*|| / ||P*||` (to first order) in the Frobenius norm: `(2 ||A|| + ||Q||/||P||) / separation`,
    /// or with `||A||^2 + 1` for `2 ||A||`, times the relative residual and the rounding in it, and the factor between
    /// the norms. P* is the solution for `A` and `Q` as given. For a stable A it holds with the separation; otherwise
    /// as far as the estimate of it is right
    /// to a factor of three. Where that is no bound, and the solution was refined instead (see [`lyapunov()`]): ten
    /// times the last correction, over one minus the factor by which a refinement shrinks errors. Infinite where no
    /// digit is known.
    ///
    /// ```
    /// use nalgebra::dmatrix;
    /// let (a, q) = (dmatrix![0.0, 1.0; -2.0, -3.0], dmatrix![1.0, 0.0; 0.0, 1.0]);
    /// let lyapunov = luenberger_linalg::lyapunov(&a, &q)?;
    /// let error = (&lyapunov.p - dmatrix![1.25, 0.25; 0.25, 0.25]).norm() / 1.3;
    /// assert!(error <= lyapunov.forward_error());
    /// # Ok::<(), luenberger_linalg::LinalgError>(())
    /// ```
    pub fn forward_error(&self) -> f64 {
        forward_error(self.residual, self.condition, self.p.nrows(), self.spread)
    }

    pub(crate) fn spread(&self) -> f64 {
        self.spread.norms * self.spread.units
    }
}

/// `A'P + P A + Q = 0` for one `A` and any number of `Q`: the Schur form is computed once, `25 n^3` flops or more; each
/// solution costs about `9 n^3`.
/// ```
/// use luenberger_linalg::LyapunovEquation;
/// use nalgebra::{DMatrix, dmatrix};
/// let a = dmatrix![0.0, 1.0; -2.0, -3.0];
/// let mut equation = LyapunovEquation::new(&a)?;
/// let mut p = DMatrix::zeros(2, 2);
/// for q in [dmatrix![1.0, 0.0; 0.0, 1.0], dmatrix![0.0, 0.0; 0.0, 1.0]] {
///     let residual = equation.solve_into(&q, &mut p)?; // allocates nothing
///     assert!(residual <= 10.0 * 2.0 * f64::EPSILON);
///     assert!((a.transpose() * &p + &p * &a + q).norm() <= 1e-14);
/// }
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub type LyapunovEquation = SymmetricEquation<false>;

/// The equation of Lyapunov, or that of Stein where `DISCRETE`, for one `A` and any number of `Q`.
#[derive(Debug, Clone, PartialEq)]
pub struct SymmetricEquation<const DISCRETE: bool>(SchurEquation);

impl<const DISCRETE: bool> SymmetricEquation<DISCRETE> {
    /// The equation for `a` (n x n).
    /// # Errors
    /// As [`lyapunov()`] or [`stein()`](crate::stein()): whether the equation has a unique solution does not depend on
    /// `Q`.
    pub fn new(a: &DMatrix<f64>) -> Result<Self> {
        SchurEquation::new(Kind::of_time(DISCRETE), a).map(Self)
    }

    /// The solution for `q`.
    pub(crate) fn solved(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<Lyapunov> {
        let n = square("A", a)?;
        shaped("Q", q, n, n)?;
        // Before the Schur form is paid for.
        let mut q = symmetric("Q", q)?;
        let (equation, residual) = SchurEquation::solved(Kind::of_time(DISCRETE), a, &mut q)?;
        Ok(Self(equation).solution(q, residual))
    }

    /// Becomes the equation for `a`, in the memory that is there: with a stable `a` of the same order nothing is
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
    pub fn solve(&mut self, q: &DMatrix<f64>) -> Result<Lyapunov> {
        shaped("Q", q, self.0.order(), self.0.order())?;
        let mut p = symmetric("Q", q)?;
        let residual = self.0.solve_in_place(&mut p)?;
        Ok(self.solution(p, residual))
    }

    /// What is known of the solution `p`, found with this residual.
    fn solution(&self, p: DMatrix<f64>, residual: f64) -> Lyapunov {
        let spread = self.0.spread(&p);
        Lyapunov { p, residual, separation: self.0.separation(), condition: self.0.condition(), spread }
    }

    /// As [`solve`](Self::solve), into `p`, and returns the relative residual. Allocates nothing if `p` is n x n
    /// already (unless the state had to be balanced).
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn solve_into(&mut self, q: &DMatrix<f64>, p: &mut DMatrix<f64>) -> Result<f64> {
        self.0.solve_into(q, p)
    }

    /// One step of iterative refinement of `p`, in place: the defect of `p`, computed in twice the working precision,
    /// is solved for and added. Returns the size of that correction relative to `p`, an estimate of the error `p` had.
    ///
    /// A solution in working precision has a small residual and an error of about `condition * n eps`. Where the data
    /// are exact as they stand (and not measured to a few digits, when the digits gained mean nothing), each step
    /// multiplies the error by about `condition * n eps` until `p` is the rounded exact solution; one or two steps do.
    /// A correction as large as `p` is not applied: the equation is singular for this precision. About `25 n^3` flops,
    /// and it allocates.
    /// ```
    /// use luenberger_linalg::LyapunovEquation;
    /// use nalgebra::dmatrix;
    /// // P = [1 1; 1 3] exactly; the condition is 1e9.
    /// let (a, p) = (dmatrix![-1.0, 1e3; 0.0, -2.0], dmatrix![1.0, 1.0; 1.0, 3.0]);
    /// let q = -(a.transpose() * &p + &p * &a);
    /// let mut equation = LyapunovEquation::new(&a)?;
    /// let mut found = equation.solve(&q)?.p;
    /// equation.refine(&q, &mut found)?;
    /// assert!((found - p).amax() <= 2.0 * f64::EPSILON);
    /// # Ok::<(), luenberger_linalg::LinalgError>(())
    /// ```
    /// # Errors
    /// As [`solve`](Self::solve), and for a `p` that is not symmetric.
    pub fn refine(&mut self, q: &DMatrix<f64>, p: &mut DMatrix<f64>) -> Result<f64> {
        self.0.refine(q, p)
    }

    /// The eigenvalues of `a`.
    pub fn eigenvalues(&self) -> Vec<Complex<f64>> {
        self.0.eigenvalues()
    }

    /// Whether all eigenvalues of `a` have a negative real part, or are inside the unit circle.
    pub fn is_stable(&self) -> bool {
        self.0.is_stable()
    }

    /// `min ||A'X + X A||_1 / ||X||_1` or `min ||A'X A - X||_1 / ||X||_1`, entries summed, in the coordinates of the
    /// Schur form: an estimate from above by at most eleven substitutions, seldom more than three times too large
    /// (SLICOT SB03QD).
    pub fn separation_estimate(&self) -> f64 {
        self.0.estimated_separation_in_units()
    }
}

/// Solves `A'P + P A + Q = 0` for symmetric `P`.
///
/// `a` and `q` are n x n, `q` symmetric (of either sign: definiteness is not asked for). The answer does not depend on
/// the units of `a` or `q`. A unique `P` exists iff `lambda_i + lambda_j != 0` for all eigenvalues of `a`. Where it
/// makes the largest entry of `a` a thousand times smaller, or where `P` seems not to exist otherwise, the equation is
/// solved in units of the state (powers of two) in which rows and columns of `a` are of equal size. The Schur form (25
/// n^3 flops), 10 n^3 for the solution and its evidence, and where `a` is not Hurwitz at most 22 n^3 more for the
/// separation. For several `q` see [`LyapunovEquation`], for `Q = C'C` see [`lyapunov_factor`](crate::lyapunov_factor).
///
/// # Errors
/// [`LinalgError::SingularEquation`](crate::LinalgError::SingularEquation) names two eigenvalues that add to zero: the
/// determinant of the equation is zero for `a` as stored, computed in integers.
/// [`LinalgError::UndecidedEquation`](crate::LinalgError::UndecidedEquation) when the separation is not above
/// `n eps ||A||`, in the units of `a` nor in units of the state that balance it (a change of `A` within its own
/// rounding makes the equation singular), and refinement with the defect in twice the working precision does not
/// converge. Where it does, it is part of the solution. [`LinalgError::NotSymmetric`](crate::LinalgError::NotSymmetric)
/// names the entry of `q` that differs from its mirror image;
/// [`LinalgError::NotSquare`](crate::LinalgError::NotSquare),
/// [`LinalgError::DimensionMismatch`](crate::LinalgError::DimensionMismatch),
/// [`LinalgError::NotFinite`](crate::LinalgError::NotFinite), [`LinalgError::Overflow`](crate::LinalgError::Overflow),
/// and those of [`schur()`](crate::schur()).
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let a = dmatrix![0.0, 1.0; -2.0, -3.0];
/// let q = dmatrix![1.0, 0.0; 0.0, 1.0];
/// let lyapunov = luenberger_linalg::lyapunov(&a, &q)?;
/// println!("P = {}residual {:e}, condition {:.1}", lyapunov.p, lyapunov.residual, lyapunov.condition);
/// assert!(lyapunov.residual <= 10.0 * 2.0 * f64::EPSILON);
/// assert!((&lyapunov.p - dmatrix![1.25, 0.25; 0.25, 0.25]).amax() <= lyapunov.condition * 2.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Bartels and Stewart, CACM 15, 1972; SLICOT SB03MD, SB03QD.
pub fn lyapunov<'a>(a: impl Into<RealMatrixView<'a>>, q: impl Into<RealMatrixView<'a>>) -> Result<Lyapunov> {
    LyapunovEquation::solved(&owned(a), &owned(q))
}
