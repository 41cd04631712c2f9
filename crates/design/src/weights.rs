//! Remark 1: the weight theta of the cubic term, from the importance of the outputs.

use luenberger_linalg::lyapunov;
use nalgebra::{DMatrix, DVector};

use crate::check;
use crate::error::DesignError;
use crate::linear::LinearDesign;

/// `theta = diag(r_1, .., r_p)`, one importance index `r_i >= 0` for each output.
///
/// # Errors
/// [`PlantError::NotFinite`](luenberger_plants::PlantError::NotFinite) or
/// [`LinalgError::NotPositiveSemidefinite`](luenberger_linalg::LinalgError::NotPositiveSemidefinite) names the index
/// that is not a number or negative.
pub fn theta_from_importance(importance: &[f64]) -> Result<DMatrix<f64>, DesignError> {
    let theta = DMatrix::from_diagonal(&DVector::from_column_slice(importance));
    check::positive_semidefinite("theta", &theta, importance.len())?;
    Ok(theta)
}

/// Each output's share of the estimation cost of the linear observer, as theta with trace `scale`.
///
/// Output i costs `J_i = int_0^inf (c_i e)^2 dt = e(0)'M_i e(0)` along `e' = F e`, where `F'M_i + M_i F = -c_i'c_i`.
/// With `initial_error = None` the mean over directions of e(0) is taken, `trace(M_i)/n`. Then
/// `theta_ii = scale J_i / sum J_j`.
///
/// ```
/// use luenberger_design::{LyapunovWeight, LinearDesign, theta_from_cost_shares};
/// let plant = luenberger_plants::double_integrator().to_dynamic();
/// let linear = LinearDesign::with_poles(&plant, &[-2.0, -5.0])?;
/// // One output has the whole cost.
/// assert!((theta_from_cost_shares(&linear, None, 10.0)?[(0, 0)] - 10.0).abs() < 1e-14);
/// # Ok::<(), luenberger_design::DesignError>(())
/// ```
///
/// # Errors
/// A wrong length or a non-finite entry of the initial error; [`DesignError::NotPositive`] when the scale is not
/// positive or no output sees that initial error.
pub fn theta_from_cost_shares(
    linear: &LinearDesign,
    initial_error: Option<&DVector<f64>>,
    scale: f64,
) -> Result<DMatrix<f64>, DesignError> {
    check::positive("scale", scale)?;
    let (f, c) = (linear.error_matrix(), &linear.observer.c);
    let n = f.nrows();
    if let Some(e0) = initial_error {
        check::matrix("initial error", &DMatrix::from_column_slice(e0.len(), 1, e0.as_slice()), (n, 1))?;
    }
    let mut cost = DVector::zeros(c.nrows());
    for (i, row) in c.row_iter().enumerate() {
        let m = lyapunov(&f, &(row.transpose() * row))?.p;
        cost[i] = match initial_error {
            Some(e0) => e0.dot(&(&m * e0)),
            None => m.trace() / n as f64,
        };
    }
    let total = cost.sum();
    check::positive("total cost of the outputs", total)?;
    Ok(DMatrix::from_diagonal(&(cost * (scale / total))))
}
