//! The paper's computation of beta: `min sum_i X_i(beta_i)^2` over `[0, 1]^n` (its eq. 12), by bounded nonlinear least
//! squares.
//!
//! `X_i(beta_i) = f_i(xhat + e) - f_i(xhat) - Df_i(xhat + beta_i e) e` (11) depends on beta_i alone, so that a solver
//! of least squares is a general tool where a bracket per row is enough
//! ([`mean_value`](luenberger_observers::mean_value::beta::mean_value), which cannot miss: the integral of X_i over [0,
//! 1] is zero). What is lost by it:
//! - a local minimum of `X_i^2` with `X_i != 0` stops it. `f(x) = d^3/3 - 2 d^5`, `d = x - 1/2`, from xhat = 0 to 1 has
//!   one at 1/2, where every solver that is started in the middle stays: X = -1/24, although X vanishes at beta = 0.137
//!   and 0.863. The observer's e is then driven by X: it is wrong even from e(0) = x(0) - xhat(0). More
//!   [starts](LeastSquares::with_starts) help, and prove nothing;
//! - X is differenced once more, for the Jacobian of the least squares;
//! - time: measured beside the other means in `docs/theory-mvt.md`.
//!
//! Method: the trust-region-reflective method of `lsqnonlin` (T. F. Coleman and Y. Li, SIAM Journal on Optimization 6,
//! 1996), as the crate `basin` has it. Rows are scaled to size one; since they are independent that changes no
//! minimiser.

use std::convert::Infallible;

use basin::{BoxBounds, ConstraintDescription, ConstraintSet, Constraints, CostFunction, DenseMatrix, Executor};
use basin::{Jacobian, Residual, TrustRegionReflective};
use luenberger_observers::mean_value::{Mean, MeanJacobian};
use luenberger_plants::{Differentiable, Size};
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector};

use crate::error::DesignError;

/// Step of the differences of X along the segment, which has length 1: the cube root of the spacing of f64, where the
/// errors of truncation and of rounding are equal.
const STEP: f64 = 6.0554544523933395e-6;

/// The mean of the Jacobian by bounded nonlinear least squares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeastSquares {
    starts: u32,
    iterations: u64,
}

impl Default for LeastSquares {
    fn default() -> Self {
        Self { starts: 1, iterations: 100 }
    }
}

/// Result of least squares along one segment.
#[derive(Clone, Debug, PartialEq)]
pub struct LeastSquaresMean<N: Dim>
where
    DefaultAllocator: nalgebra::allocator::Allocator<N> + nalgebra::allocator::Allocator<N, N>,
{
    /// beta_i in [0, 1].
    pub beta: OVector<f64, N>,
    /// `X_i(beta_i)`: not zero where a local minimum held the solver.
    pub residual: OVector<f64, N>,
    /// Row i is the gradient of f_i at `xhat + beta_i e`.
    pub jacobian: OMatrix<f64, N, N>,
    /// Iterations of the solver, over all starts.
    pub iterations: u64,
}

impl LeastSquares {
    /// One start, at beta = 1/2, and at most 100 iterations.
    pub fn new() -> Self {
        Self::default()
    }

    /// The best of `starts` runs, from `beta = (k + 1/2)/starts` in every row (default 1), and at least 1.
    ///
    /// Rows are independent: the best beta is taken row by row.
    #[must_use]
    pub fn with_starts(self, starts: u32) -> Self {
        Self { starts: starts.max(1), ..self }
    }

    /// The cap on the iterations of one run (default 100), and at least 1.
    #[must_use]
    pub fn with_iterations(self, iterations: u64) -> Self {
        Self { iterations: iterations.max(1), ..self }
    }

    /// beta, residual and Jacobian for the segment from `xhat` to `xhat + e`.
    ///
    /// ```
    /// use luenberger_design::mean_value::LeastSquares;
    /// use luenberger_observers::mean_value::beta::mean_value;
    /// use luenberger_plants::Chaotic;
    /// use nalgebra::{SVector, Vector3};
    /// let (xhat, e) = (Vector3::new(-1.0, -0.5, -1.5), Vector3::new(-1.0, -0.5, 0.5));
    /// let found = LeastSquares::new().solve(&Chaotic, 0.0, &xhat, &SVector::zeros(), &e)?;
    /// assert!(found.residual.amax() < 1e-9);
    /// let bracketed = mean_value(&Chaotic, 0.0, &xhat, &SVector::zeros(), &e);
    /// assert!((found.beta - bracketed.beta).amax() < 1e-6);
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::JacobianNotFinite`](luenberger_observers::ObserverError::JacobianNotFinite) in
    /// [`DesignError::Observer`] names the point of the segment where the Jacobian does not exist.
    pub fn solve<S, N: Dim, M: Dim, P: Dim>(
        &self,
        plant: &S,
        t: f64,
        xhat: &OVector<f64, N>,
        u: &OVector<f64, M>,
        e: &OVector<f64, N>,
    ) -> Result<LeastSquaresMean<N>, DesignError>
    where
        S: Differentiable<f64, N, M, P>,
        DefaultAllocator: Size<N, M, P>,
    {
        self.examine(plant, t, xhat, u, e)?;
        Ok(self.search(plant, t, xhat, u, e))
    }

    fn search<S, N: Dim, M: Dim, P: Dim>(
        &self,
        plant: &S,
        t: f64,
        xhat: &OVector<f64, N>,
        u: &OVector<f64, M>,
        e: &OVector<f64, N>,
    ) -> LeastSquaresMean<N>
    where
        S: Differentiable<f64, N, M, P>,
        DefaultAllocator: Size<N, M, P>,
    {
        let n = xhat.nrows();
        let (order, column) = xhat.shape_generic();
        let rise = plant.derivative(t, &(xhat + e), u) - plant.derivative(t, xhat, u);
        let along = |s: f64| &rise - plant.directional(t, &(xhat + e * s), u, e).1;
        let middle = along(0.5);
        // The size of a row: 1 where nothing happens in it, or where it is not finite.
        let scale: Vec<f64> = (0..n)
            .map(|i| rise[i].abs() + (rise[i] - middle[i]).abs())
            .map(|size| if size > 0.0 && size.is_finite() { size } else { 1.0 })
            .collect();
        let mut beta = OVector::repeat_generic(order, column, 0.5);
        let mut residual = middle;
        let mut iterations = 0;
        for k in 0..self.starts {
            let start = (f64::from(k) + 0.5) / f64::from(self.starts);
            let rows = Rows { along: &along, scale: &scale, lower: vec![0.0; n], upper: vec![1.0; n] };
            // Zero residuals are the aim: the gradient may be as small as rounding leaves it.
            let method = TrustRegionReflective::new().with_absolute_scaled_gradient_tolerance(f64::EPSILON);
            let run = Executor::from_start(rows, method, vec![start; n]).max_iter(self.iterations).run();
            let Ok(found) = run else { continue };
            iterations += found.iter();
            // The method never accepts a worse point, so that the last is the best; `best_param` panics where no point
            // was finite.
            for (i, &s) in found.param().iter().enumerate() {
                let s = if s.is_finite() { s.clamp(0.0, 1.0) } else { 0.5 };
                let value = along(s)[i];
                if value.abs() < residual[i].abs() {
                    (beta[i], residual[i]) = (s, value);
                }
            }
        }
        let mut jacobian = OMatrix::zeros_generic(order, order);
        for i in 0..n {
            jacobian.set_row(i, &plant.state_jacobian(t, &(xhat + e * beta[i]), u).row(i));
        }
        LeastSquaresMean { beta, residual, jacobian, iterations }
    }
}

impl<S, N: Dim, M: Dim, P: Dim> Mean<S, f64, N, M, P> for LeastSquares
where
    S: Differentiable<f64, N, M, P>,
    DefaultAllocator: Size<N, M, P>,
{
    fn mean(
        &self,
        plant: &S,
        t: f64,
        xhat: &OVector<f64, N>,
        u: &OVector<f64, M>,
        e: &OVector<f64, N>,
    ) -> MeanJacobian<f64, N> {
        let jacobian = self.search(plant, t, xhat, u, e).jacobian;
        let forward = &jacobian * e;
        MeanJacobian { jacobian, forward }
    }
}

/// The residuals `X_i(beta_i)`, scaled, for the solver.
struct Rows<'a, F> {
    along: F,
    scale: &'a [f64],
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl<N: Dim, F: Fn(f64) -> OVector<f64, N>> Rows<'_, F>
where
    DefaultAllocator: nalgebra::allocator::Allocator<N>,
{
    fn row(&self, i: usize, s: f64) -> f64 {
        (self.along)(s)[i] / self.scale[i]
    }
}

impl<F> Constraints for Rows<'_, F> {
    type Set = ConstraintSet<BoxBounds<Vec<f64>>>;

    fn constraints(&self) -> <Self::Set as ConstraintDescription>::Borrowed<'_> {
        ConstraintSet::new().with_bounds(BoxBounds::new(Some(&self.lower), Some(&self.upper)))
    }
}

impl<N: Dim, F: Fn(f64) -> OVector<f64, N>> CostFunction for Rows<'_, F>
where
    DefaultAllocator: nalgebra::allocator::Allocator<N>,
{
    type Param = Vec<f64>;
    type Output = f64;
    type Error = Infallible;

    fn cost(&self, beta: &Vec<f64>) -> Result<f64, Infallible> {
        Ok(0.5 * beta.iter().enumerate().map(|(i, &s)| self.row(i, s).powi(2)).sum::<f64>())
    }
}

impl<N: Dim, F: Fn(f64) -> OVector<f64, N>> Residual for Rows<'_, F>
where
    DefaultAllocator: nalgebra::allocator::Allocator<N>,
{
    type Param = Vec<f64>;
    type Output = Vec<f64>;
    type Error = Infallible;

    fn residual(&self, beta: &Vec<f64>) -> Result<Vec<f64>, Infallible> {
        Ok(beta.iter().enumerate().map(|(i, &s)| self.row(i, s)).collect())
    }
}

impl<N: Dim, F: Fn(f64) -> OVector<f64, N>> Jacobian for Rows<'_, F>
where
    DefaultAllocator: nalgebra::allocator::Allocator<N>,
{
    type Jacobian = DenseMatrix;

    fn jacobian(&self, beta: &Vec<f64>) -> Result<DenseMatrix, Infallible> {
        let slopes: Vec<f64> = beta
            .iter()
            .enumerate()
            .map(|(i, &s)| {
                // Within the segment: f may not be defined beyond its ends.
                let (a, b) = ((s - STEP).max(0.0), (s + STEP).min(1.0));
                (self.row(i, b) - self.row(i, a)) / (b - a)
            })
            .collect();
        let n = slopes.len();
        Ok(DenseMatrix::from_fn(n, n, |i, j| if i == j { slopes[i] } else { 0.0 }))
    }
}
