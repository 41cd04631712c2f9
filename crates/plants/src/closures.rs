//! A plant from two closures, f and h.

use nalgebra::{RealField, SVector};

use crate::plant::{Dimensions, Plant, Shape};

/// The plant that [`from_fn`] makes of two closures.
#[derive(Clone, Copy, Debug)]
pub struct FromFn<F, H, const N: usize, const M: usize, const P: usize> {
    f: F,
    h: H,
}

/// The plant `x' = f(t, x, u)`, `y = h(t, x, u)` of two closures, with N states, M inputs and P outputs.
///
/// The parameters are the scalar and the sizes; with them given, the arguments of the closures need no types.
///
/// For simulation and for observers that need no derivatives: a closure is defined for one scalar type, so that dual
/// numbers do not apply. A plant whose Jacobians are needed implements [`Plant`] for every scalar; see
/// [`ByDual`](crate::ByDual).
///
/// ```
/// use luenberger_plants::{Plant, Shape, from_fn};
/// use nalgebra::{Vector1, Vector2, vector};
/// // A pendulum with a torque, its angle measured: two states, one input, one output.
/// let pendulum = from_fn::<f64, 2, 1, 1, _, _>(
///     |_t, x, u| vector![x[1], u[0] - x[0].sin()],
///     |_t, x, _u| vector![x[0]],
/// );
/// assert_eq!(pendulum.derivative(0.0, &Vector2::new(0.0, 1.0), &Vector1::new(0.5)), Vector2::new(1.0, 0.5));
/// assert_eq!(pendulum.dimensions().inputs, 1);
/// ```
pub fn from_fn<T, const N: usize, const M: usize, const P: usize, F, H>(f: F, h: H) -> FromFn<F, H, N, M, P>
where
    T: RealField + Copy,
    F: Fn(T, &SVector<T, N>, &SVector<T, M>) -> SVector<T, N>,
    H: Fn(T, &SVector<T, N>, &SVector<T, M>) -> SVector<T, P>,
{
    FromFn { f, h }
}

impl<F, H, const N: usize, const M: usize, const P: usize> Shape for FromFn<F, H, N, M, P> {
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: N, inputs: M, outputs: P }
    }
}

impl<T, F, H, const N: usize, const M: usize, const P: usize> Plant<T> for FromFn<F, H, N, M, P>
where
    T: RealField + Copy,
    F: Fn(T, &SVector<T, N>, &SVector<T, M>) -> SVector<T, N>,
    H: Fn(T, &SVector<T, N>, &SVector<T, M>) -> SVector<T, P>,
{
    type State = SVector<T, N>;
    type Input = SVector<T, M>;
    type Output = SVector<T, P>;

    fn derivative(&self, t: T, x: &Self::State, u: &Self::Input) -> Self::State {
        (self.f)(t, x, u)
    }

    fn output(&self, t: T, x: &Self::State, u: &Self::Input) -> Self::Output {
        (self.h)(t, x, u)
    }
}
