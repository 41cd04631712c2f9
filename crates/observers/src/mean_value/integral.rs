//! The integral mean of the Jacobian, `Dbar = int_0^1 Df(xhat + s e) ds`.
//!
//! `Dbar e = f(xhat + e) - f(xhat)` exactly, for every continuously differentiable f: that is the fundamental theorem
//! of calculus along the segment. Dbar depends continuously on xhat and e, and nothing has to be solved for.
//!
//! Method: Gauss and Legendre with eight points, exact for polynomials of degree 15 in s. The error is estimated twice:
//! by the difference from five points (degree 9), and, along e, by the identity itself.

use luenberger_plants::{Differentiable, Size};
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField, convert};

use crate::error::ObserverError;
use crate::mean_value::quadrature::GAUSS_LEGENDRE_5;
use crate::mean_value::{Mean, MeanJacobian, segment};

pub use crate::mean_value::quadrature::GAUSS_LEGENDRE_8;

/// The integral mean: continuous, and nothing is solved.
///
/// `D e` is the difference of f, without the quadrature, whose error stays in the gain G.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Integral;

impl<S, T, N, M, P> Mean<S, T, N, M, P> for Integral
where
    S: Differentiable<T, N, M, P>,
    T: RealField + Copy,
    N: Dim,
    M: Dim,
    P: Dim,
    DefaultAllocator: Size<N, M, P>,
{
    fn mean(&self, plant: &S, t: T, xhat: &OVector<T, N>, u: &OVector<T, M>, e: &OVector<T, N>) -> MeanJacobian<T, N> {
        MeanJacobian {
            jacobian: gauss_legendre(plant, t, xhat, u, e),
            forward: plant.derivative(t, &(xhat + e), u) - plant.derivative(t, xhat, u),
        }
    }
}

/// The integral mean of a Jacobian, with the evidence for it.
#[derive(Clone, Debug, PartialEq)]
pub struct IntegralMean<T: RealField + Copy, N: Dim>
where
    DefaultAllocator: nalgebra::allocator::Allocator<N, N>,
{
    /// Dbar, n x n.
    pub jacobian: OMatrix<T, N, N>,
    /// Largest entry of the difference between eight and five points: for a smooth f the error of five points, which
    /// the error of eight is far below; where the two rules disagree much, neither is accurate.
    pub difference: T,
    /// Largest entry of `|Dbar e - (f(xhat + e) - f(xhat))|`: the true error along e, with rounding.
    pub residual: T,
}

/// The integral mean of `Df` over the segment from `xhat` to `xhat + e`, with an estimate of its error.
///
/// xhat and e have length n. Costs 13 n derivatives along a direction and two evaluations of f.
///
/// ```
/// use luenberger_observers::mean_value::integral::integral_mean;
/// use luenberger_plants::Chaotic;
/// use nalgebra::{SVector, Vector3};
/// let (xhat, e) = (Vector3::new(-1.0, -0.5, -1.5), Vector3::new(-1.0, -0.5, 0.5));
/// let mean = integral_mean(&Chaotic, 0.0, &xhat, &SVector::zeros(), &e)?;
/// assert!(mean.residual < 1e-15 && mean.difference < 1e-9);
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
/// # Errors
/// [`ObserverError::JacobianNotFinite`] names the point of the segment, as the fraction s of the way and as a state,
/// and the entry.
///
/// Source: P. J. Davis and P. Rabinowitz, Methods of Numerical Integration, 2nd ed., 1984, section 2.7.
pub fn integral_mean<S, T, N, M, P>(
    plant: &S,
    t: T,
    xhat: &OVector<T, N>,
    u: &OVector<T, M>,
    e: &OVector<T, N>,
) -> Result<IntegralMean<T, N>, ObserverError>
where
    S: Differentiable<T, N, M, P>,
    T: RealField + Copy,
    N: Dim,
    M: Dim,
    P: Dim,
    DefaultAllocator: Size<N, M, P>,
{
    for (s, _) in GAUSS_LEGENDRE_8.into_iter().chain(GAUSS_LEGENDRE_5) {
        segment::jacobian_at(plant, t, xhat, u, e, s)?;
    }
    let jacobian = gauss_legendre(plant, t, xhat, u, e);
    let difference = (&jacobian - rule(&GAUSS_LEGENDRE_5, plant, t, xhat, u, e)).amax();
    let forward = plant.derivative(t, &(xhat + e), u) - plant.derivative(t, xhat, u);
    let residual = (&jacobian * e - forward).amax();
    Ok(IntegralMean { jacobian, difference, residual })
}

/// Dbar alone, by eight points: what a right-hand side needs. Costs 8 n derivatives along a direction.
pub fn gauss_legendre<S, T, N, M, P>(
    plant: &S,
    t: T,
    xhat: &OVector<T, N>,
    u: &OVector<T, M>,
    e: &OVector<T, N>,
) -> OMatrix<T, N, N>
where
    S: Differentiable<T, N, M, P>,
    T: RealField + Copy,
    N: Dim,
    M: Dim,
    P: Dim,
    DefaultAllocator: Size<N, M, P>,
{
    rule(&GAUSS_LEGENDRE_8, plant, t, xhat, u, e)
}

fn rule<S, T, N, M, P>(
    nodes: &[(f64, f64)],
    plant: &S,
    t: T,
    xhat: &OVector<T, N>,
    u: &OVector<T, M>,
    e: &OVector<T, N>,
) -> OMatrix<T, N, N>
where
    S: Differentiable<T, N, M, P>,
    T: RealField + Copy,
    N: Dim,
    M: Dim,
    P: Dim,
    DefaultAllocator: Size<N, M, P>,
{
    let order = xhat.shape_generic().0;
    let mut mean = OMatrix::zeros_generic(order, order);
    for &(s, weight) in nodes {
        let at = xhat + e * convert::<f64, T>(s);
        mean += plant.state_jacobian(t, &at, u) * convert::<f64, T>(weight);
    }
    mean
}
