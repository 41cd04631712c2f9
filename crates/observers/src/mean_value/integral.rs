//! The integral mean of the Jacobian, `Dbar = int_0^1 Df(xhat + s e) ds`.
//!
//! `Dbar e = f(xhat + e) - f(xhat)` exactly, for every continuously differentiable f: that is the fundamental theorem
//! of calculus along the segment. Dbar depends continuously on xhat and e, and nothing has to be solved for.
//!
//! Method: Gauss and Legendre with eight points, exact for polynomials of degree 15 in s (P. J. Davis and P.
//! Rabinowitz, Methods of Numerical Integration, 2nd ed., 1984, section 2.7).

use luenberger_plants::{Differentiable, Size};
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField, convert};

use crate::mean_value::{Mean, MeanJacobian};

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

/// Dbar by eight points. xhat and e have length n. Costs 8 n derivatives along a direction.
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
    let order = xhat.shape_generic().0;
    let mut mean = OMatrix::zeros_generic(order, order);
    for (s, weight) in GAUSS_LEGENDRE_8 {
        let at = xhat + e * convert::<f64, T>(s);
        mean += plant.state_jacobian(t, &at, u) * convert::<f64, T>(weight);
    }
    mean
}
