//! Sylvester equation `A X + X B = C`.
//!
//! `X` exists and is unique iff no eigenvalue of `A` is the negative of one of `B`. It is the change of coordinates that
//! decouples a block-triangular system, and what turns a plant into the coordinates of a Luenberger observer with prescribed dynamics.
//!
//! Method: real Schur forms `A = U S U'`, `B = V T V'`, then `S Y + Y T = U'C V` by recursive substitution (Bartels and Stewart, CACM 15, 1972;
//! Jonsson and Kagstrom, ACM TOMS 28, 2002).

use crate::argument::{finite, shaped, square, unit_scale};
use crate::compensated;
use crate::lyapunov::{Spread, forward_error};
use crate::product::{multiply, view, view_mut};
use crate::separation::{nearly_singular, relative, rescale, separation};
use crate::triangular::{self, Coefficient, Equation};
use crate::{LinalgError, Result, Schur, schur};
use faer::Accum;
use nalgebra::{Complex, DMatrix};
use std::cell::Cell;

/// Solution of `A X + X B = C` with its evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Sylvester {
    /// The solution, n x m.
    pub x: DMatrix<f64>,
    /// `||A X + X B - C|| / ((||A|| + ||B||) ||X|| + ||C||)` in the Frobenius norm.
    pub residual: f64,
    /// Estimate of the separation of `A` and `-B`, `min ||A X + X B||_1 / ||X||_1` (entries summed, in the coordinates of the
    /// Schur forms). An upper bound, seldom more than three times too large.
    pub separation: f64,
    /// `(||A|| + ||B||) / separation`: about how much `X` may change, relative to its norm, for a unit relative change of `A` and `B`.
    pub condition: f64,
}

impl Sylvester {
    /// A bound of `||X - X*|| / ||X*||` (to first order) in the Frobenius norm, X* the solution for the data as given: as [`Lyapunov::forward_error`](crate::Lyapunov::forward_error), as
    /// far as the estimate of the separation is right to a factor of three.
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
        let (n, m) = self.x.shape();
        let spread = Spread { norms: 3.0 * ((n * m) as f64).sqrt(), units: 1.0 };
        forward_error(self.residual, self.condition, n.max(m), spread)
    }
}

/// `A X + X B = C` for one pair `(A, B)` and any number of `C`: the Schur forms are computed once, each solution costs about `5 n m (n + m)`.
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
#[derive(Debug, Clone, PartialEq)]
pub struct SylvesterEquation {
    /// A and B in one unit, that of the larger, and the sum of their norms.
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    size: f64,
    units: f64,
    left: Schur,
    right: Schur,
    separation: f64,
    half: DMatrix<f64>,
    defect: DMatrix<f64>,
}

impl SylvesterEquation {
    /// The equation for `a` (n x n) and `b` (m x m).
    /// # Errors
    /// As [`sylvester()`]: whether the equation has a unique solution does not depend on `C`.
    pub fn new(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Result<Self> {
        let (n, m) = (square("a", a)?, square("b", b)?);
        // A coefficient of order zero, or zero, has no unit.
        let units = match (a.amax() > 0.0, b.amax() > 0.0) {
            (true, true) => unit_scale(a).min(unit_scale(b)),
            (true, false) => unit_scale(a),
            _ => unit_scale(b),
        };
        let (a, b) = (a * units, b * units);
        let (left, right) = (schur(&a)?, schur(&b)?);
        let size = a.norm() + b.norm();
        let (half, defect) = (DMatrix::zeros(n, m), DMatrix::zeros(n, m));
        let mut equation = Self { a, b, size, units, left, right, separation: f64::INFINITY, half, defect };
        let (s, t) = (view(&equation.left.t), view(&equation.right.t));
        let regular = Cell::new(true);
        let solve = |s, t, d: &mut DMatrix<f64>| {
            regular.set(triangular::solve(Equation::Sylvester, s, t, view_mut(d), &mut []) && regular.get());
        };
        let found = separation(
            n,
            m,
            |d| solve(Coefficient::plain(s), Coefficient::plain(t), d),
            |d| solve(Coefficient::transposed(s), Coefficient::transposed(t), d),
        );
        equation.separation = found;
        if n * m > 0 && (!regular.get() || found.is_nan() || found <= n.max(m) as f64 * f64::EPSILON * size) {
            let (first, second) = (equation.eigenvalues_of(&equation.left), equation.eigenvalues_of(&equation.right));
            return Err(nearly_singular("Sylvester", &first, &second, found / units, |x, y| (x + y).norm()));
        }
        Ok(equation)
    }

    fn eigenvalues_of(&self, form: &Schur) -> Vec<Complex<f64>> {
        form.eigenvalues().iter().map(|lambda| lambda / self.units).collect()
    }

    /// The solution for the n x m matrix `c`.
    /// # Errors
    /// [`LinalgError::DimensionMismatch`], [`LinalgError::NotFinite`], [`LinalgError::Overflow`].
    pub fn solve(&mut self, c: &DMatrix<f64>) -> Result<Sylvester> {
        let mut x = DMatrix::zeros(c.nrows(), c.ncols());
        let residual = self.solve_into(c, &mut x)?;
        Ok(Sylvester { x, residual, separation: self.separation / self.units, condition: self.size / self.separation })
    }

    /// As [`solve`](Self::solve), into `x`, and returns the relative residual. Allocates nothing if `x` is n x m already.
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn solve_into(&mut self, c: &DMatrix<f64>, x: &mut DMatrix<f64>) -> Result<f64> {
        let (n, m) = (self.a.nrows(), self.b.nrows());
        if c.shape() != (n, m) {
            return Err(LinalgError::DimensionMismatch { what: "c", expected: (n, m), found: c.shape() });
        }
        finite("c", c)?;
        if x.shape() != (n, m) {
            *x = DMatrix::zeros(n, m);
        }
        let units_c = unit_scale(c);
        x.copy_from(c);
        *x *= units_c;
        let size_c = x.norm();
        self.defect.copy_from(x);
        self.substitute(x);
        multiply(view_mut(&mut self.defect), Accum::Add, -1.0, view(&self.a), view(x));
        multiply(view_mut(&mut self.defect), Accum::Add, -1.0, view(x), view(&self.b));
        let residual = relative(self.defect.norm(), self.size * x.norm() + size_c);
        rescale(x, self.units, units_c);
        if residual.is_nan() || x.iter().any(|e| !e.is_finite()) {
            return Err(LinalgError::Overflow { what: "the solution x" });
        }
        Ok(residual)
    }

    /// From the right-hand side in `x` to the solution, in the units of the coefficients.
    fn substitute(&mut self, x: &mut DMatrix<f64>) {
        let (u, v) = (view(&self.left.q), view(&self.right.q));
        let (s, t) = (Coefficient::plain(view(&self.left.t)), Coefficient::plain(view(&self.right.t)));
        let half = &mut self.half;
        multiply(view_mut(half), Accum::Replace, 1.0, u.transpose(), view(x));
        multiply(view_mut(x), Accum::Replace, 1.0, view(half), v);
        triangular::solve(Equation::Sylvester, s, t, view_mut(x), &mut []);
        multiply(view_mut(half), Accum::Replace, 1.0, u, view(x));
        multiply(view_mut(x), Accum::Replace, 1.0, view(half), v.transpose());
    }

    /// One step of iterative refinement of `x`, in place, as [`LyapunovEquation::refine`](crate::LyapunovEquation::refine): returns the size of the correction
    /// relative to `x`.
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn refine(&mut self, c: &DMatrix<f64>, x: &mut DMatrix<f64>) -> Result<f64> {
        let (n, m) = (self.a.nrows(), self.b.nrows());
        shaped("c", c, n, m)?;
        shaped("x", x, n, m)?;
        let units_c = unit_scale(c);
        let (c, mut better) = (c * units_c, x.clone());
        rescale(&mut better, units_c, self.units);
        let (left, rest) = compensated::product(&self.a, &better);
        let (right, more) = compensated::product(&better, &self.b);
        let mut correction = DMatrix::from_fn(n, m, |i, j| {
            compensated::sum(&[c[(i, j)], -left[(i, j)], -right[(i, j)], -rest[(i, j)], -more[(i, j)]])
        });
        self.substitute(&mut correction);
        let moved = relative(correction.norm(), better.norm());
        if moved >= 1.0 {
            return Ok(moved);
        }
        better += correction;
        rescale(&mut better, self.units, units_c);
        if moved.is_nan() || better.iter().any(|e| !e.is_finite()) {
            return Err(LinalgError::Overflow { what: "the correction of x" });
        }
        x.copy_from(&better);
        Ok(moved)
    }
}

/// Solves `A X + X B = C`.
///
/// `a` is n x n, `b` m x m, `c` n x m. A unique `X` exists iff `lambda_i(A) + lambda_j(B) != 0` for all i, j. The answer does not depend on the
/// units of the data. About `25 (n^3 + m^3) + 5 n m (n + m)` flops, and at most `11 n m (n + m)` for the separation. For several `c` see [`SylvesterEquation`].
///
/// # Errors
/// [`NearlySingular`](crate::LinalgError::NearlySingular) names the eigenvalues of `a` and `b` whose sum is nearest to zero, when
/// the separation is not above `max(n, m) eps (||A|| + ||B||)`; [`NotSquare`](crate::LinalgError::NotSquare),
/// [`DimensionMismatch`](crate::LinalgError::DimensionMismatch), [`NotFinite`](crate::LinalgError::NotFinite),
/// [`Overflow`](crate::LinalgError::Overflow), and those of [`schur()`].
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
pub fn sylvester(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<Sylvester> {
    let (n, m) = (square("a", a)?, square("b", b)?);
    shaped("c", c, n, m)?;
    SylvesterEquation::new(a, b)?.solve(c)
}
