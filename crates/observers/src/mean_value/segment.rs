//! Whether f and Df exist along the segment from xhat to xhat + e, and where they do not.
//!
//! The right-hand side of an observer returns no error; before a run, or after one that ended, this names the state
//! at which f or Df does not exist.

use luenberger_plants::{Differentiable, Size};
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField, convert};

use crate::error::{ObserverError, Point};
use crate::mean_value::quadrature::GAUSS_LEGENDRE_8;

/// f at both ends, and Df there and at the eight points of the quadrature between.
///
/// ```
/// use luenberger_observers::mean_value::segment::examine;
/// use luenberger_plants::Chaotic;
/// use nalgebra::{SVector, Vector3};
/// // x1 x3 overflows at the far end.
/// let error = examine(&Chaotic, 0.0, &Vector3::zeros(), &SVector::zeros(), &Vector3::new(1e200, 0.0, 1e200)).unwrap_err();
/// assert!(error.to_string().contains("at the state [1e200, 0.0, 1e200]"), "{error}");
/// ```
/// # Errors
/// [`ObserverError::SlopeNotFinite`] and [`ObserverError::JacobianNotFinite`] name the first such state. A pole between
/// the points is not seen.
pub fn examine<S, T, N, M, P>(
    plant: &S,
    t: T,
    xhat: &OVector<T, N>,
    u: &OVector<T, M>,
    e: &OVector<T, N>,
) -> Result<(), ObserverError>
where
    S: Differentiable<T, N, M, P>,
    T: RealField + Copy,
    N: Dim,
    M: Dim,
    P: Dim,
    DefaultAllocator: Size<N, M, P>,
{
    for s in [0.0, 1.0] {
        let at = xhat + e * convert::<f64, T>(s);
        let slope = plant.derivative(t, &at, u);
        if let Some(row) = slope.iter().position(|entry| !entry.is_finite()) {
            return Err(ObserverError::SlopeNotFinite { s, row, point: point(&at) });
        }
    }
    for s in [0.0].into_iter().chain(GAUSS_LEGENDRE_8.map(|(s, _)| s)).chain([1.0]) {
        jacobian_at(plant, t, xhat, u, e, s)?;
    }
    Ok(())
}

/// `Df(xhat + s e)`, finite.
pub(super) fn jacobian_at<S, T, N, M, P>(
    plant: &S,
    t: T,
    xhat: &OVector<T, N>,
    u: &OVector<T, M>,
    e: &OVector<T, N>,
    s: f64,
) -> Result<OMatrix<T, N, N>, ObserverError>
where
    S: Differentiable<T, N, M, P>,
    T: RealField + Copy,
    N: Dim,
    M: Dim,
    P: Dim,
    DefaultAllocator: Size<N, M, P>,
{
    let at = xhat + e * convert::<f64, T>(s);
    let jacobian = plant.state_jacobian(t, &at, u);
    for column in 0..jacobian.ncols() {
        for row in 0..jacobian.nrows() {
            if !jacobian[(row, column)].is_finite() {
                return Err(ObserverError::JacobianNotFinite { s, row, column, point: point(&at) });
            }
        }
    }
    Ok(jacobian)
}

fn point<T: RealField + Copy, N: Dim>(x: &OVector<T, N>) -> Point
where
    DefaultAllocator: nalgebra::allocator::Allocator<N>,
{
    Point::new(x.iter().map(|&x| x.to_subset_unchecked()))
}
