//! Noise in continuous and in discrete time: intensities (power spectral densities) and covariances of samples.
//!
//! White noise of intensity V has no variance; its mean over a period h has the covariance `V/h`. A data sheet or a log
//! gives standard deviations of samples; a Kalman filter in continuous time (`kalman_gain`) takes intensities:
//!
//! | quantity | continuous | discrete | conversion |
//! |---|---|---|---|
//! | measurement noise | intensity V | covariance R of a sample | `V = R h` |
//! | process noise | intensity W of `x' = A x + w` | covariance Qd of `x+ = Ad x + w` | `Qd = int_0^h e^{As} W e^{A's} ds` |

use nalgebra::DMatrix;

use super::period;
use crate::argument::{RealMatrixView, owned, shaped, square, symmetric};
use crate::balance::{Balance, are_near};
use crate::definite::{in_units, unit_diagonal};
use crate::discretize::expm;
use crate::{LinalgError, Result};

/// Intensity `V = R h` of the white measurement noise whose mean over the period `h` has the covariance `R`, p x p.
///
/// Each sample of a sensor with the standard deviation `sigma` has the covariance `sigma^2`. The unit of V is that of R
/// times that of time.
///
/// # Errors
/// [`LinalgError::InvalidPeriod`], [`LinalgError::NotSquare`], [`LinalgError::NotFinite`],
/// [`LinalgError::NotSymmetric`].
///
/// # Example
/// ```
/// use luenberger_linalg::{measurement_intensity, sampled_measurement_covariance};
/// use nalgebra::dmatrix;
///
/// // 5 mm at 100 Hz.
/// let v = measurement_intensity(&dmatrix![0.005 * 0.005], 0.01)?;
/// assert!((v[0] - 2.5e-7).abs() < 1e-22);
/// assert!((sampled_measurement_covariance(&v, 0.01)?[0].sqrt() - 0.005).abs() < 1e-18);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Lewis, Xie, Popa, Optimal and Robust Estimation, section 3.1; Simon, Optimal State Estimation, section 8.1.
pub fn measurement_intensity<'a>(r: impl Into<RealMatrixView<'a>>, h: f64) -> Result<DMatrix<f64>> {
    let r = owned(r);
    symmetric("R", &r)?;
    Ok(r * period(h)?)
}

/// Covariance `R = V / h` of the samples of white measurement noise of intensity `V`, p x p, averaged over the period
/// `h`: the inverse of [`measurement_intensity`].
///
/// # Errors
/// As [`measurement_intensity`].
pub fn sampled_measurement_covariance<'a>(v: impl Into<RealMatrixView<'a>>, h: f64) -> Result<DMatrix<f64>> {
    let v = owned(v);
    symmetric("V", &v)?;
    Ok(v / period(h)?)
}

/// Covariance `Qd = int_0^h e^{As} W e^{A's} ds` that process noise of intensity `W` in `x' = A x + w` adds to the
/// state within one period.
///
/// `a` is n x n, `w` n x n, symmetric (for noise that enters through G, `G W G'`), `h > 0`.
///
/// Method: Van Loan's exponential `exp([-A W; 0 A'] h) = [.. F2; 0 F3]`, `Qd = F3' F2`, in steps of at most
/// `|A| h = 1`, doubled by `Q(2s) = Q(s) + e^{As} Q(s) e^{A's}`: one exponential of a long period would lose the digits
/// of Qd in the growth of `e^{-Ah}`.
///
/// # Errors
/// [`LinalgError::InvalidPeriod`], [`LinalgError::NotSquare`], [`LinalgError::DimensionMismatch`],
/// [`LinalgError::NotFinite`], [`LinalgError::NotSymmetric`], [`LinalgError::Overflow`].
///
/// # Cost
/// One exponential of order 2 n, and `4 n^3` flops for each doubling.
///
/// # Example
/// The double integrator with acceleration noise, against the textbook's formula.
/// ```
/// use luenberger_linalg::discrete_process_noise;
/// use nalgebra::dmatrix;
///
/// let h: f64 = 0.5;
/// let qd = discrete_process_noise(&dmatrix![0.0, 1.0; 0.0, 0.0], &dmatrix![0.0, 0.0; 0.0, 2.0], h)?;
/// let residual = (qd - dmatrix![h.powi(3) / 3.0, h * h / 2.0; h * h / 2.0, h] * 2.0).norm();
/// println!("residual {residual:e}");
/// assert!(residual < 1e-15);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Van Loan, IEEE TAC 23, 1978; Bar-Shalom, Li, Kirubarajan, Estimation with Applications, (6.2.2-12).
pub fn discrete_process_noise<'a>(
    a: impl Into<RealMatrixView<'a>>,
    w: impl Into<RealMatrixView<'a>>,
    h: f64,
) -> Result<DMatrix<f64>> {
    let (a, w) = (owned(a), owned(w));
    let n = square("A", &a)?;
    shaped("W", &w, n, n)?;
    symmetric("W", &w)?;
    let h = period(h)?;
    let q = if are_near(a.iter()) {
        accumulated(&a, &w, h)?
    } else {
        let balance = Balance::fitted(&a);
        balance.form(&accumulated(&balance.similar(&a), &balance.form_back(&w), h)?)
    };
    if q.iter().all(|x| x.is_finite()) { Ok(q) } else { Err(LinalgError::Overflow { what: "Qd" }) }
}

/// Qd, for arguments in balanced units of the state.
fn accumulated(a: &DMatrix<f64>, w: &DMatrix<f64>, h: f64) -> Result<DMatrix<f64>> {
    let n = a.nrows();
    let doublings = (a.norm() * h).log2().ceil().clamp(0.0, 1000.0) as i32;
    let step = h * 2f64.powi(-doublings);
    let mut augmented = DMatrix::zeros(2 * n, 2 * n);
    augmented.view_mut((0, 0), (n, n)).copy_from(&(a * -step));
    augmented.view_mut((n, n), (n, n)).copy_from(&(a.transpose() * step));
    // Linear in W: its size does not have to scale the exponential.
    let size = w.amax();
    if size > 0.0 {
        augmented.view_mut((0, n), (n, n)).copy_from(&(w / size * step));
    }
    let e = expm(&augmented)?;
    let mut transition = e.view((n, n), (n, n)).transpose();
    let mut q = &transition * e.view((0, n), (n, n)) * size;
    for _ in 0..doublings {
        q += &transition * &q * transition.transpose();
        transition = &transition * &transition;
    }
    Ok((&q + q.transpose()) * 0.5)
}

/// Intensity `W` of the process noise in `x' = A x + w` that adds the covariance `Qd` to the state within each period:
/// the inverse of [`discrete_process_noise`].
///
/// `a` is n x n, `qd` n x n, symmetric. W is unique if `lambda_i + lambda_j` is no nonzero multiple of `2 pi i / h` for
/// eigenvalues of A. It is symmetric, and need not be semidefinite: not every covariance comes from white noise (of a
/// double integrator, not `diag(0, 1)`).
///
/// # Errors
/// Those of [`discrete_process_noise`]; [`LinalgError::Singular`] if W is not unique, or not to working precision.
///
/// # Cost
/// `O(n^6)`: a system of linear equations for the entries of W.
///
/// # Example
/// ```
/// use luenberger_linalg::{continuous_process_noise, discrete_process_noise};
/// use nalgebra::dmatrix;
///
/// let (a, w) = (dmatrix![0.0, 1.0; -4.0, -0.4], dmatrix![0.2, 0.1; 0.1, 3.0]);
/// let qd = discrete_process_noise(&a, &w, 0.1)?;
/// let residual = (continuous_process_noise(&a, &qd, 0.1)? - w).norm();
/// println!("residual {residual:e}");
/// assert!(residual < 1e-11);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub fn continuous_process_noise<'a>(
    a: impl Into<RealMatrixView<'a>>,
    qd: impl Into<RealMatrixView<'a>>,
    h: f64,
) -> Result<DMatrix<f64>> {
    let (a, qd) = (owned(a), owned(qd));
    let n = square("A", &a)?;
    shaped("Qd", &qd, n, n)?;
    symmetric("Qd", &qd)?;
    // One column for each entry of W on and above the diagonal.
    let pairs: Vec<(usize, usize)> = (0..n).flat_map(|j| (0..=j).map(move |i| (i, j))).collect();
    let mut map = DMatrix::zeros(pairs.len(), pairs.len());
    for (k, (i, j)) in pairs.iter().enumerate() {
        let mut unit = DMatrix::zeros(n, n);
        unit[(*i, *j)] = 1.0;
        unit[(*j, *i)] = 1.0;
        let image = discrete_process_noise(&a, &unit, h)?;
        for (row, (i, j)) in pairs.iter().enumerate() {
            map[(row, k)] = image[(*i, *j)];
        }
    }
    let what = "the map from W to Qd";
    let (inverse, condition) = super::equilibrated_inverse(what, &map)?;
    let solved = inverse * DMatrix::from_fn(pairs.len(), 1, |k, _| qd[pairs[k]]);
    let place = |i: usize, j: usize| pairs.iter().position(|pair| *pair == (i.min(j), i.max(j))).unwrap_or(0);
    let w = DMatrix::from_fn(n, n, |i, j| solved[place(i, j)]);
    if !w.iter().all(|x| x.is_finite()) {
        return Err(LinalgError::Overflow { what: "W" });
    }
    // A map that is singular but for its rounding has an inverse, whose W has another Qd.
    let units = unit_diagonal(&qd);
    let missed = in_units(&(discrete_process_noise(&a, &w, h)? - &qd), &units).norm();
    if missed <= f64::EPSILON.sqrt() * in_units(&qd, &units).norm() {
        Ok(w)
    } else {
        Err(LinalgError::Singular { what, condition })
    }
}
