//! Steady-state Kalman gains: the Riccati equations of the transposed plant.
//!
//! The error covariance `P` solves, for process noise of covariance (intensity) `W` and measurement noise `V`,
//!
//! ```text
//! continuous   A P + P A' - P C'V^-1 C P + W = 0                      L = P C'V^-1
//! discrete     A P A' - P - A P C'(V + C P C')^-1 C P A' + W = 0      L = A P C'(V + C P C')^-1
//! ```
//!
//! or, if the two noises have the cross-covariance `S = E w v'`,
//!
//! ```text
//! continuous   A P + P A' - (P C' + S) V^-1 (C P + S') + W = 0                     L = (P C' + S) V^-1
//! discrete     A P A' - P - (A P C' + S)(V + C P C')^-1 (C P A' + S') + W = 0      L = (A P C' + S)(V + C P C')^-1
//! ```
//!
//! which is the regulator's equation with `A'` for `A`, `C'` for `B`, `W` for `Q`, `V` for `R`, and `L = K'`.

use std::fmt;

use super::scaled::{Data, Weight};
use super::{Riccati, continuous, discrete_or_singular, generalized_care, generalized_dare};
use crate::argument::{RealMatrixView, owned, shaped, square, symmetric_part};
use crate::definite::{positive_definite, positive_semidefinite};
use crate::error::listed;
use crate::{LinalgError, Result};
use luenberger_wording::significant;
use nalgebra::{Cholesky, Complex, DMatrix};

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

/// Continuous Kalman gain for correlated noises: `L = (P C' + S) V^-1`,
/// `A P + P A' - (P C' + S) V^-1 (C P + S') + W = 0`.
///
/// `s`, n x p, is the cross-intensity `E w v'` of the process noise w of `x' = A x + B u + w` and the measurement noise
/// v of `y = C x + v`; the other arguments are those of [`kalman_gain`]. `[W, S; S', V]` is positive semidefinite.
/// Noise that enters by G, `x' = A x + B u + G w`, has `G W G'` and `G S`. Cost as
/// [`generalized_care`].
///
/// # Errors
/// Those of [`kalman_gain`], of the plant `A - S V^-1 C` with the noise `W - S V^-1 S'` for a mode that is not excited;
/// [`LinalgError::NotPositiveSemidefinite`] names the joint intensity.
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// // The same noise drives the state and is measured: y says what entered, and the error decays by itself.
/// let one = dmatrix![1.0];
/// let kalman = luenberger_linalg::correlated_kalman_gain(&dmatrix![-1.0], &one, &one, &one, &one)?;
/// println!("{kalman}");
/// assert!((kalman.l[0] - 1.0).abs() < 1e-15 && kalman.p[0].abs() < 1e-15);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Anderson and Moore, Optimal Filtering, 1979, section 5.4.
pub fn correlated_kalman_gain<'a>(
    a: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
    w: impl Into<RealMatrixView<'a>>,
    v: impl Into<RealMatrixView<'a>>,
    s: impl Into<RealMatrixView<'a>>,
) -> Result<Kalman> {
    let equation: Generalized = |[a, b, q, r, s, e]| generalized_care(a, b, q, r, s, e);
    correlated(equation, [&owned(a), &owned(c), &owned(w), &owned(v), &owned(s)])
}

/// Discrete Kalman predictor gain for correlated noises: `L = (A P C' + S)(V + C P C')^-1`,
/// `A P A' - P - (A P C' + S)(V + C P C')^-1 (C P A' + S') + W = 0`.
///
/// `s`, n x p, is the cross-covariance `E w[k] v[k]'` of the noises of one sample; otherwise as
/// [`correlated_kalman_gain`] and [`discrete_kalman_gain`].
///
/// # Errors
/// As [`correlated_kalman_gain`], with the unit circle as stability boundary.
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let (a, one, s) = (dmatrix![0.5], dmatrix![1.0], dmatrix![0.5]);
/// let kalman = luenberger_linalg::discrete_correlated_kalman_gain(&a, &one, &one, &one, &s)?;
/// // P^2 + P/4 - 3/4 = 0, that is P = 3/4, and L = (P/2 + 1/2)/(1 + P).
/// println!("L = {}residual {:e}", kalman.l, kalman.residual);
/// assert!((kalman.p[0] - 0.75).abs() < 1e-15 && (kalman.l[0] - 0.5).abs() < 1e-15);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Anderson and Moore, Optimal Filtering, 1979, section 5.4.
pub fn discrete_correlated_kalman_gain<'a>(
    a: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
    w: impl Into<RealMatrixView<'a>>,
    v: impl Into<RealMatrixView<'a>>,
    s: impl Into<RealMatrixView<'a>>,
) -> Result<Kalman> {
    let equation: Generalized = |[a, b, q, r, s, e]| generalized_dare(a, b, q, r, s, e);
    correlated(equation, [&owned(a), &owned(c), &owned(w), &owned(v), &owned(s)])
}

/// The measurement update of a filter.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasurementUpdate {
    /// The gain M of `xhat+ = xhat + M (y - C xhat)`, n x p.
    pub gain: DMatrix<f64>,
    /// The covariance of the error after the update, exactly symmetric.
    pub p: DMatrix<f64>,
}

/// Measurement update `M = P C'(V + C P C')^-1`, `P+ = P - M C P`, of the prediction covariance `p`.
///
/// `p` is n x n and `v` p x p, symmetric positive semidefinite with `V + C P C' > 0`, `c` p x n. The predictor's gain
/// is `L = A M` if process and measurement noise are not correlated. P+ is computed as `(I - M C) P (I - M C)' + M V
/// M'`, which stays semidefinite in spite of rounding. About `4 n^3 + 4 n^2 p` flops.
///
/// # Errors
/// [`LinalgError::NotPositiveSemidefinite`] (`P`, `V`); [`LinalgError::NotPositiveDefinite`] (`V + C P C'`);
/// [`LinalgError::NotSquare`], [`LinalgError::DimensionMismatch`], [`LinalgError::NotFinite`],
/// [`LinalgError::NotSymmetric`].
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let one = dmatrix![1.0];
/// let update = luenberger_linalg::measurement_update(&dmatrix![3.0], &one, &one)?;
/// println!("M = {}P+ = {}", update.gain, update.p);
/// assert_eq!((update.gain[0], update.p[0]), (0.75, 0.75));
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Anderson and Moore, Optimal Filtering, 1979, chapter 3; Bucy and Joseph for the form of P+.
pub fn measurement_update<'a>(
    p: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
    v: impl Into<RealMatrixView<'a>>,
) -> Result<MeasurementUpdate> {
    let (p, c, v) = (owned(p), owned(c), owned(v));
    let n = square("P", &p)?;
    shaped("C", &c, c.nrows(), n)?;
    shaped("V", &v, c.nrows(), c.nrows())?;
    let (p, v) = (positive_semidefinite("P", &p)?, positive_semidefinite("V", &v)?);
    let seen = &c * &p;
    let innovation = positive_definite("V + C P C'", &symmetric_part(&(&v + &seen * c.transpose())))?;
    let solved = Cholesky::new(innovation).map(|factor| factor.solve(&seen));
    let gain = solved.ok_or(LinalgError::Overflow { what: "V + C P C'" })?.transpose();
    let left = DMatrix::identity(n, n) - &gain * c;
    let p = symmetric_part(&(&left * p * left.transpose() + &gain * v * gain.transpose()));
    Ok(MeasurementUpdate { gain, p })
}

type Generalized = fn([&DMatrix<f64>; 6]) -> Result<Riccati>;

fn correlated(equation: Generalized, [a, c, w, v, s]: [&DMatrix<f64>; 5]) -> Result<Kalman> {
    let (n, p) = (checked(a, c, w, v)?, c.nrows());
    shaped("S", s, n, p)?;
    positive_semidefinite("W", w)?;
    positive_semidefinite("V", v)?;
    let mut joint = DMatrix::zeros(n + p, n + p);
    joint.view_mut((0, 0), (n, n)).copy_from(w);
    joint.view_mut((n, n), (p, p)).copy_from(v);
    joint.view_mut((0, n), (n, p)).copy_from(s);
    joint.view_mut((n, 0), (p, n)).copy_from(&s.transpose());
    positive_semidefinite("the joint covariance [W, S; S', V]", &joint)?;
    let found = equation([&a.transpose(), &c.transpose(), w, v, s, &DMatrix::identity(n, n)]);
    found.map(Kalman::from).map_err(in_terms_of_the_filter)
}

type Equation = fn(&Data<'_>) -> Result<Riccati>;

fn dual(equation: Equation, a: &DMatrix<f64>, c: &DMatrix<f64>, w: &DMatrix<f64>, v: &DMatrix<f64>) -> Result<Kalman> {
    checked(a, c, w, v)?;
    let data = Data { a: &a.transpose(), b: &c.transpose(), q: w, r: v, weight: Weight::Semidefinite };
    equation(&data).map(Kalman::from).map_err(in_terms_of_the_filter)
}

/// The number of states. Shapes and entries are checked before transposition, so that errors name the user's matrices.
fn checked(a: &DMatrix<f64>, c: &DMatrix<f64>, w: &DMatrix<f64>, v: &DMatrix<f64>) -> Result<usize> {
    let n = square("A", a)?;
    if n == 0 {
        return Err(LinalgError::Empty { what: "A" });
    }
    shaped("C", c, c.nrows(), n)?;
    shaped("W", w, n, n)?;
    shaped("V", v, c.nrows(), c.nrows())?;
    Ok(n)
}

impl From<Riccati> for Kalman {
    fn from(found: Riccati) -> Self {
        let Riccati { x, k, poles, residual, condition, forward_error } = found;
        Self { l: k.transpose(), p: x, poles, residual, condition, forward_error }
    }
}

fn in_terms_of_the_filter(error: LinalgError) -> LinalgError {
    match error {
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
    }
}

fn renamed(what: &'static str) -> &'static str {
    match what {
        "Q" => "W",
        "R" => "V",
        other => other,
    }
}
