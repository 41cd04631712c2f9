//! A plant split at a point into its linear part and the rest: `f(t, x, u) = A x + phi(t, x, u)` with
//! `A = Df(t, x0, u0)`.
//!
//! The Lipschitz constant of phi over a region is the largest `|Df(t, x, u) - A|` there. A supremum is not proved by
//! sampling: the user states the constant, and [`Split::slope`] at any point can contradict it.

use luenberger_linalg::lambda_max;
use luenberger_plants::{Differentiable, Size};
use nalgebra::{DMatrix, DefaultAllocator, Dim, OVector};

use crate::error::DesignError;

/// `A = Df(t, x0, u0)` and `C = Dh(t, x0)` at a point; phi is the remainder of f.
#[derive(Debug, Clone, PartialEq)]
pub struct Split {
    /// A, n x n.
    pub a: DMatrix<f64>,
    /// C, p x n.
    pub c: DMatrix<f64>,
}

impl Split {
    /// The plant split at time t, state x and input u, by its dual-number Jacobians. Costs 2 n directional derivatives.
    ///
    /// ```
    /// use luenberger_design::lipschitz::Split;
    /// use luenberger_plants::flexible_joint;
    /// use nalgebra::{Vector1, Vector4};
    /// let plant = flexible_joint::classical();
    /// let split = Split::at(&plant, 0.0, &Vector4::new(0.0, 0.0, std::f64::consts::FRAC_PI_2, 0.0), &Vector1::zeros())?;
    /// // Where the cosine vanishes, A is the linear part, and phi has the slope -3.33 cos(x3).
    /// assert!((split.a[(3, 2)] + 19.5).abs() < 1e-15 * 20.0);
    /// let constant = split.slope_norm(&plant, 0.0, &Vector4::zeros(), &Vector1::zeros())?;
    /// assert!((constant - 3.33).abs() < 1e-14);
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    /// # Errors
    /// [`DesignError::NotDifferentiable`] names the point and the entry that is not finite.
    pub fn at<S, N: Dim, M: Dim, P: Dim>(
        plant: &S,
        t: f64,
        x: &OVector<f64, N>,
        u: &OVector<f64, M>,
    ) -> Result<Self, DesignError>
    where
        S: Differentiable<f64, N, M, P>,
        DefaultAllocator: Size<N, M, P>,
    {
        let a = plant.state_jacobian(t, x, u);
        let c = plant.output_jacobian(t, x, u);
        let a = DMatrix::from_column_slice(a.nrows(), a.ncols(), a.as_slice());
        let c = DMatrix::from_column_slice(c.nrows(), c.ncols(), c.as_slice());
        finite("Df", &a, x.as_slice())?;
        finite("Dh", &c, x.as_slice())?;
        Ok(Self { a, c })
    }

    /// `Df(t, x, u) - A`, the slope of phi at a point.
    ///
    /// # Errors
    /// [`DesignError::NotDifferentiable`] names the point.
    pub fn slope<S, N: Dim, M: Dim, P: Dim>(
        &self,
        plant: &S,
        t: f64,
        x: &OVector<f64, N>,
        u: &OVector<f64, M>,
    ) -> Result<DMatrix<f64>, DesignError>
    where
        S: Differentiable<f64, N, M, P>,
        DefaultAllocator: Size<N, M, P>,
    {
        let here = Self::at(plant, t, x, u)?.a;
        crate::check::matrix("Df", &here, self.a.shape())?;
        Ok(here - &self.a)
    }

    /// `|Df(t, x, u) - A|`, its largest singular value: no Lipschitz constant of phi on a region that contains x is
    /// below this.
    ///
    /// # Errors
    /// As [`slope`](Self::slope).
    pub fn slope_norm<S, N: Dim, M: Dim, P: Dim>(
        &self,
        plant: &S,
        t: f64,
        x: &OVector<f64, N>,
        u: &OVector<f64, M>,
    ) -> Result<f64, DesignError>
    where
        S: Differentiable<f64, N, M, P>,
        DefaultAllocator: Size<N, M, P>,
    {
        let slope = self.slope(plant, t, x, u)?;
        // Scaled, so that the squares neither overflow nor vanish.
        let scale = slope.amax();
        if scale == 0.0 {
            return Ok(0.0);
        }
        let slope = slope / scale;
        Ok(scale * lambda_max(&(slope.transpose() * &slope))?.max(0.0).sqrt())
    }
}

fn finite(what: &'static str, m: &DMatrix<f64>, point: &[f64]) -> Result<(), DesignError> {
    for column in 0..m.ncols() {
        for row in 0..m.nrows() {
            let value = m[(row, column)];
            if !value.is_finite() {
                return Err(DesignError::NotDifferentiable { what, row, column, value, point: point.to_vec() });
            }
        }
    }
    Ok(())
}
