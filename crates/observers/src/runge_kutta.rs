//! One step of the classical Runge-Kutta method, for two unknowns that are integrated together.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, RealField, convert};

/// From time t to `t + tau`: `x' = f(t, x, w)`, `w' = g(t, x, w)`, of which `slope` returns both.
///
/// The order of the operations is that of exported C: `x + (k1 + (k2 + k3) 2 + k4) (tau / 6)`.
#[inline]
pub(crate) fn step<T: RealField + Copy, N: Dim, P: Dim, C: Dim, K: Dim>(
    t: T,
    tau: T,
    (x, w): (&mut OMatrix<T, N, C>, &mut OMatrix<T, P, K>),
    slope: impl Fn(T, &OMatrix<T, N, C>, &OMatrix<T, P, K>) -> (OMatrix<T, N, C>, OMatrix<T, P, K>),
) where
    DefaultAllocator: Allocator<N, C> + Allocator<P, K>,
{
    let (half, sixth): (T, T) = (convert(0.5), convert(1.0 / 6.0));
    let two = T::one() + T::one();
    let (middle, whole) = (tau * half, tau * sixth);
    let (k1, w1) = slope(t, x, w);
    let (k2, w2) = slope(t + middle, &(&*x + &k1 * middle), &(&*w + &w1 * middle));
    let (k3, w3) = slope(t + middle, &(&*x + &k2 * middle), &(&*w + &w2 * middle));
    let (k4, w4) = slope(t + tau, &(&*x + &k3 * tau), &(&*w + &w3 * tau));
    *x += (k1 + (k2 + k3) * two + k4) * whole;
    *w += (w1 + (w2 + w3) * two + w4) * whole;
}
