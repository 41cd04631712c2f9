//! Sylvester equation `A X + X B = C`.
//!
//! `X` exists and is unique iff no eigenvalue of `A` is the negative of one of `B`. It is the change of coordinates
//! that decouples a block-triangular system, and the one that brings a plant into the coordinates of a Luenberger
//! observer with prescribed dynamics.
//!
//! The discrete form `A X B - X + C = 0` is in `discrete.rs`; what both have in common is here and in `pair.rs`.
//!
//! Method: real Schur forms `A = U S U'`, `B = V T V'`, then `S Y + Y T = U'C V` by recursive substitution (Bartels and
//! Stewart, CACM 15, 1972; Jonsson and Kagstrom, ACM TOMS 28, 2002).

mod discrete;
mod pair;

pub use discrete::{DiscreteSylvester, DiscreteSylvesterEquation, discrete_sylvester};

use crate::Result;
use crate::argument::{RealMatrixView, owned};
use crate::triangular::Equation;
use nalgebra::DMatrix;
use pair::{SchurPair, error_bound};

/// Solution of `A X + X B = C`, or of `A X B - X + C = 0` ([`DiscreteSylvester`]), with residual, separation and
/// condition. Of two formulas the second is that of the discrete form.
#[derive(Debug, Clone, PartialEq)]
pub struct Sylvester {
    /// The solution, n x m.
    pub x: DMatrix<f64>,
    /// `||A X + X B - C|| / ((||A|| + ||B||) ||X|| + ||C||)` or
    /// `||A X B - X + C|| / ((||A|| ||B|| + 1) ||X|| + ||C||)`, in the Frobenius norm.
    pub residual: f64,
    /// Estimate of the separation, `min ||A X + X B||_1 / ||X||_1` or `min ||A X B - X||_1 / ||X||_1` (entries summed,
    /// in the coordinates of the Schur forms), by three substitutions; by at most eleven if the equation may be
    /// singular. An upper bound, seldom more than three times too large.
    pub separation: f64,
    /// Condition number `(||A|| + ||B||) / separation` or `(||A|| ||B|| + 1) / separation`: to first order, the
    /// relative change of `X` per relative change of the data.
    pub condition: f64,
    /// Relative error measured by refinement, if the separation is at rounding level.
    refined: Option<f64>,
    /// What balanced units bring to the error.
    growth: f64,
}

impl Sylvester {
    /// First-order bound of `||X - X*|| / ||X*||` in the Frobenius norm, X* the exact solution for the data as given:
    /// as [`Lyapunov::forward_error`](crate::Lyapunov::forward_error). Valid if the estimate of the separation is right
    /// within a factor of three.
    ///
    /// ```
    /// use nalgebra::dmatrix;
    /// let (a, b) = (dmatrix![1.0, 1e6; 0.0, 2.0], dmatrix![1.0]);
    /// let x = dmatrix![1.0; 3.0];
    /// let found = luenberger_linalg::sylvester(&a, &b, &(&a * &x + &x * &b))?;
    /// assert!((&found.x - &x).norm() / x.norm() <= found.forward_error());
    /// # Ok::<(), luenberger_linalg::LinalgError>(())
    /// ```
    pub fn forward_error(&self) -> f64 {
        error_bound(self.x.shape(), self.residual, self.condition, (self.growth, self.refined))
    }
}

/// `A X + X B = C` for one pair `(A, B)` and any number of `C`: the Schur forms are computed once, each solution costs
/// about `5 n m (n + m)`.
/// ```
/// use luenberger_linalg::SylvesterEquation;
/// use nalgebra::dmatrix;
/// let (a, b) = (dmatrix![0.0, 1.0; -2.0, -3.0], dmatrix![-4.0]);
/// let mut equation = SylvesterEquation::new(&a, &b)?;
/// for c in [dmatrix![1.0; 2.0], dmatrix![0.0; 1.0]] {
///     assert!(equation.solve(&c)?.residual <= 10.0 * 2.0 * f64::EPSILON);
/// }
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub type SylvesterEquation = PairEquation<false>;

/// The Sylvester equation, or its discrete form where `DISCRETE`, for one pair `(A, B)` and any number of `C`.
#[derive(Debug, Clone, PartialEq)]
pub struct PairEquation<const DISCRETE: bool>(SchurPair);

impl<const DISCRETE: bool> PairEquation<DISCRETE> {
    const EQUATION: Equation = if DISCRETE { Equation::Stein } else { Equation::Sylvester };

    /// The equation for `a` (n x n) and `b` (m x m).
    /// # Errors
    /// As [`sylvester()`] or [`discrete_sylvester`]: whether the equation has a unique solution does not depend on `C`.
    pub fn new(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Result<Self> {
        SchurPair::new(Self::EQUATION, a, b).map(Self)
    }

    fn solved(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<Sylvester> {
        SchurPair::solved(Self::EQUATION, [a, b, c], |pair| Self(pair).solve(c).map(|found| (found.residual, found)))
    }

    /// The solution for the n x m matrix `c`.
    /// # Errors
    /// [`LinalgError::DimensionMismatch`](crate::LinalgError::DimensionMismatch),
    /// [`LinalgError::NotFinite`](crate::LinalgError::NotFinite),
    /// [`LinalgError::Overflow`](crate::LinalgError::Overflow);
    /// [`LinalgError::UndecidedEquation`](crate::LinalgError::UndecidedEquation) if the separation is at rounding level
    /// and refinement does not converge for this `c`.
    pub fn solve(&mut self, c: &DMatrix<f64>) -> Result<Sylvester> {
        let mut x = DMatrix::zeros(c.nrows(), c.ncols());
        let residual = self.solve_into(c, &mut x)?;
        Ok(Sylvester {
            growth: self.0.growth(&x),
            x,
            residual,
            separation: self.0.separation(),
            condition: self.0.condition(),
            refined: self.0.refined(),
        })
    }

    /// As [`solve`](Self::solve), into `x`, and returns the relative residual. Allocates nothing if `x` is n x m
    /// already.
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn solve_into(&mut self, c: &DMatrix<f64>, x: &mut DMatrix<f64>) -> Result<f64> {
        self.0.solve_into(c, x)
    }

    /// One step of iterative refinement of `x`, in place, as
    /// [`LyapunovEquation::refine`](crate::LyapunovEquation::refine): returns the size of the correction relative to
    /// `x`.
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn refine(&mut self, c: &DMatrix<f64>, x: &mut DMatrix<f64>) -> Result<f64> {
        self.0.refine(c, x)
    }

    /// The separation by the full iteration of Hager and Higham (SLICOT SB03QD): at most eleven substitutions instead
    /// of the three of [`Sylvester::separation`].
    pub fn separation_estimate(&self) -> f64 {
        self.0.separation_estimate()
    }
}

/// Solves `A X + X B = C`.
///
/// `a` is n x n, `b` m x m, `c` n x m. A unique `X` exists iff `lambda_i(A) + lambda_j(B) != 0` for all i, j. The
/// result does not depend on the units of the data. About `25 (n^3 + m^3) + 5 n m (n + m)` flops, and `3 n m (n + m)`
/// for the separation. For several `c` see [`SylvesterEquation`].
///
/// # Errors
/// [`SingularEquation`](crate::LinalgError::SingularEquation) names eigenvalues of `a` and `b` whose sum is zero: the
/// determinant of the equation is zero for the coefficients as stored, computed in exact integer arithmetic;
/// [`UndecidedEquation`](crate::LinalgError::UndecidedEquation) if the separation is at most
/// `max(n, m) eps (||A|| + ||B||)` and refinement does not converge (see [`lyapunov()`](crate::lyapunov()));
/// [`NotSquare`](crate::LinalgError::NotSquare), [`DimensionMismatch`](crate::LinalgError::DimensionMismatch),
/// [`NotFinite`](crate::LinalgError::NotFinite), [`Overflow`](crate::LinalgError::Overflow), and those of
/// [`schur()`](crate::schur()).
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let a = dmatrix![0.0, 1.0; -2.0, -3.0];
/// let b = dmatrix![-4.0];
/// let c = dmatrix![1.0; 2.0];
/// let sylvester = luenberger_linalg::sylvester(&a, &b, &c)?;
/// let defect = &a * &sylvester.x + &sylvester.x * &b - &c;
/// println!("residual {:e}, {:e}", sylvester.residual, defect.norm());
/// assert!(sylvester.residual <= 10.0 * 2.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Bartels and Stewart, CACM 15, 1972; Golub and Van Loan, Matrix Computations, 7.6.3; SLICOT SB04MD.
pub fn sylvester<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
) -> Result<Sylvester> {
    SylvesterEquation::solved(&owned(a), &owned(b), &owned(c))
}
