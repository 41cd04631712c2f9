//! The plant: `x' = f(t, x, u)`, `y = h(t, x)`.
//!
//! The scalar `T` is a parameter of the trait, not of its methods: a plant written for every `T` that can add and
//! multiply is at once a plant for `f64`, for `f32` on a target, and for dual numbers, from which its Jacobians come.

use crate::column::Column;

/// How many states, inputs and outputs a plant has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dimensions {
    /// Number of states, n.
    pub states: usize,
    /// Number of inputs, m.
    pub inputs: usize,
    /// Number of outputs, p.
    pub outputs: usize,
}

/// A plant `x' = f(t, x, u)`, `y = h(t, x)` over the scalar `T`.
///
/// A nonlinear plant supplied by the user, written once for every scalar that nalgebra can compute with:
/// ```
/// use luenberger_plants::{Dimensions, Plant};
/// use nalgebra::{RealField, SVector, Vector1, Vector2};
///
/// /// Van der Pol's oscillator x1' = x2, x2' = (1 - x1^2) x2 - x1, y = x1.
/// struct VanDerPol;
///
/// impl<T: RealField + Copy> Plant<T> for VanDerPol {
///     type State = Vector2<T>;
///     type Input = SVector<T, 0>;
///     type Output = Vector1<T>;
///     fn dimensions(&self) -> Dimensions {
///         Dimensions { states: 2, inputs: 0, outputs: 1 }
///     }
///     fn derivative(&self, _t: T, x: &Vector2<T>, _u: &SVector<T, 0>) -> Vector2<T> {
///         Vector2::new(x[1], (T::one() - x[0] * x[0]) * x[1] - x[0])
///     }
///     fn output(&self, _t: T, x: &Vector2<T>) -> Vector1<T> {
///         Vector1::new(x[0])
///     }
/// }
/// let slope = VanDerPol.derivative(0.0, &Vector2::new(2.0, 1.0), &SVector::zeros());
/// assert_eq!(slope, Vector2::new(1.0, -5.0));
/// ```
///
/// Columns of dynamic length must have the lengths that [`dimensions`](Self::dimensions) says; simulation checks that
/// once, before the first call.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a plant over the scalar `{T}`",
    note = "implement `Plant<T>` for every `T: RealField + Copy`, or make it of closures with `luenberger_plants::from_fn`"
)]
pub trait Plant<T> {
    /// Column of the n states.
    type State: Column<T>;
    /// Column of the m inputs.
    type Input: Column<T>;
    /// Column of the p measured outputs.
    type Output: Column<T>;

    /// Numbers of states, inputs and outputs.
    fn dimensions(&self) -> Dimensions;

    /// `f(t, x, u)`.
    fn derivative(&self, t: T, x: &Self::State, u: &Self::Input) -> Self::State;

    /// `h(t, x)`.
    fn output(&self, t: T, x: &Self::State) -> Self::Output;
}

impl<T, S: Plant<T> + ?Sized> Plant<T> for &S {
    type State = S::State;
    type Input = S::Input;
    type Output = S::Output;

    fn dimensions(&self) -> Dimensions {
        (**self).dimensions()
    }

    fn derivative(&self, t: T, x: &Self::State, u: &Self::Input) -> Self::State {
        (**self).derivative(t, x, u)
    }

    fn output(&self, t: T, x: &Self::State) -> Self::Output {
        (**self).output(t, x)
    }
}
