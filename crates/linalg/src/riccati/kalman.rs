//! Steady-state Kalman gains: the Riccati equations of the transposed plant.
//!
//! The error covariance `P` solves, for process noise of covariance (intensity) `W` and measurement noise `V`,
//!
//! ```text
//! continuous   A P + P A' - P C'V^-1 C P + W = 0                      L = P C'V^-1
//! discrete     A P A' - P - A P C'(V + C P C')^-1 C P A' + W = 0      L = A P C'(V + C P C')^-1
//! ```
//!
//! which is the regulator's equation with `A'` for `A`, `C'` for `B`, `W` for `Q`, `V` for `R`, and `L = K'`.

use std::fmt;

use super::scaled::{Data, Weight};
use super::{Riccati, continuous, discrete_or_singular};
use crate::argument::{RealMatrixView, owned, shaped, square};
use crate::error::listed;
use crate::{LinalgError, Result};
use luenberger_wording::significant;
use nalgebra::{Complex, DMatrix};

/// Steady-state Kalman gain with residual, condition and error bound.
#[derive(Debug, Clone, PartialEq)]
pub struct Kalman {
    /// The observer gain, n x p, of `A - L C`.
    pub l: DMatrix<f64>,
    /// Steady-state covariance of the estimation error (discrete: of the one-step prediction error), exactly symmetric.
    pub p: DMatrix<f64>,
    /// Eigenvalues of `A - L C`, all stable.
    pub poles: Vec<Complex<f64>>,
    /// Relative residual of the Riccati equation.
    pub residual: f64,
    /// Condition number of that equation, as [`Riccati::condition`].
    pub condition: f64,
    /// Bound of the relative error of `p`, as [`Riccati::forward_error`].
    pub forward_error: f64,
}

impl fmt::Display for Kalman {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (residual, condition) = (significant(self.residual, 3), significant(self.condition, 3));
        write!(f, "L ={}P ={}poles {}", self.l, self.p, listed(&self.poles))?;
        write!(f, "; residual {residual}, condition {condition}")
    }
}

/// Continuous Kalman gain `L = P C'V^-1`, `A P + P A' - P C'V^-1 C P + W = 0`.
///
/// `a` is n x n, `c` p x n, `w` n x n symmetric positive semidefinite (intensity of the process noise), `v` p x p
/// symmetric positive definite (intensity of the measurement noise). Cost as [`care`](super::care).
///
/// # Errors
/// Those of [`care`](super::care), in terms of this equation: [`LinalgError::NotPositiveDefinite`] (`V`),
/// [`LinalgError::NotPositiveSemidefinite`] (`W`), [`LinalgError::NotDetectable`] names an undetectable eigenvalue,
/// [`LinalgError::NotExcited`] one on the imaginary axis that the process noise does not excite;
/// [`LinalgError::Empty`] for a plant without states.
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let a = dmatrix![0.0, 1.0; 0.0, 0.0];
/// let c = dmatrix![1.0, 0.0];
/// let kalman = luenberger_linalg::kalman_gain(&a, &c, &dmatrix![0.0, 0.0; 0.0, 1.0], &dmatrix![1.0])?;
/// println!("{kalman}");
/// assert!(kalman.residual <= 20.0 * 2.0 * f64::EPSILON);
/// assert!((kalman.l - dmatrix![2.0_f64.sqrt(); 1.0]).amax() <= 100.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Kalman and Bucy, J. Basic Engineering 83, 1961.
pub fn kalman_gain<'a>(
    a: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
    w: impl Into<RealMatrixView<'a>>,
    v: impl Into<RealMatrixView<'a>>,
) -> Result<Kalman> {
    dual(continuous, &owned(a), &owned(c), &owned(w), &owned(v))
}

/// Discrete Kalman predictor gain `L = A P C'(V + C P C')^-1`, `P` the covariance of the one-step prediction.
///
/// Shapes as [`kalman_gain`]; `w` and `v` are covariances per sample, and `v` may be singular, as long as
/// `V + C P C' > 0`: outputs without noise. The predictor is
/// `xhat+ = A xhat + B u + L (y - C xhat)`; `a` may be singular. Cost as [`dare`](super::dare).
///
/// # Errors
/// As [`kalman_gain`], with the unit circle as stability boundary.
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let one = dmatrix![1.0];
/// let kalman = luenberger_linalg::discrete_kalman_gain(&one, &one, &one, &one)?;
/// println!("L = {}residual {:e}", kalman.l, kalman.residual);
/// assert!((kalman.l[(0, 0)] - (5.0_f64.sqrt() - 1.0) / 2.0).abs() <= 10.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Anderson and Moore, Optimal Filtering, 1979, chapter 4.
pub fn discrete_kalman_gain<'a>(
    a: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
    w: impl Into<RealMatrixView<'a>>,
    v: impl Into<RealMatrixView<'a>>,
) -> Result<Kalman> {
    dual(discrete_or_singular, &owned(a), &owned(c), &owned(w), &owned(v))
}

type Equation = fn(&Data<'_>) -> Result<Riccati>;

fn dual(equation: Equation, a: &DMatrix<f64>, c: &DMatrix<f64>, w: &DMatrix<f64>, v: &DMatrix<f64>) -> Result<Kalman> {
    // Shapes and entries are checked here, before transposition, so that errors name the user's matrices.
    let n = square("A", a)?;
    if n == 0 {
        return Err(LinalgError::Empty { what: "A" });
    }
    shaped("C", c, c.nrows(), n)?;
    shaped("W", w, n, n)?;
    shaped("V", v, c.nrows(), c.nrows())?;
    let data = Data { a: &a.transpose(), b: &c.transpose(), q: w, r: v, weight: Weight::Semidefinite };
    let Riccati { x, k, poles, residual, condition, forward_error } = equation(&data).map_err(|error| match error {
        LinalgError::NotSymmetric { what, row, col, asymmetry, allowed } => {
            LinalgError::NotSymmetric { what: renamed(what), row, col, asymmetry, allowed }
        }
        LinalgError::NotPositiveDefinite { lambda_min, .. } => {
            LinalgError::NotPositiveDefinite { what: "V", lambda_min }
        }
        LinalgError::NotPositiveSemidefinite { lambda_min, .. } => {
            LinalgError::NotPositiveSemidefinite { what: "W", lambda_min }
        }
        LinalgError::NotStabilizable { eigenvalue, margin } => LinalgError::NotDetectable { eigenvalue, margin },
        LinalgError::NotWeighted { eigenvalue, margin } => LinalgError::NotExcited { eigenvalue, margin },
        other => other,
    })?;
    Ok(Kalman { l: k.transpose(), p: x, poles, residual, condition, forward_error })
}

fn renamed(what: &'static str) -> &'static str {
    match what {
        "Q" => "W",
        "R" => "V",
        other => other,
    }
}
