//! The plant: `x' = f(t, x, u)`, `y = h(t, x, u)`.
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

/// The numbers of states, inputs and outputs of a plant: the same for every scalar.
///
/// ```
/// use luenberger_plants::{Chaotic, Plant, Shape};
/// // No scalar has to be named, although Chaotic is a plant over every scalar.
/// assert_eq!(Chaotic.dimensions().states, 3);
/// fn order(plant: &(impl Plant<f64> + Plant<f32>)) -> usize {
///     plant.dimensions().states
/// }
/// assert_eq!(order(&Chaotic), 3);
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not say how many states, inputs and outputs it has",
    note = "implement `luenberger_plants::Shape`, `luenberger::plants::Shape`, beside `Plant<T>`"
)]
pub trait Shape {
    /// Numbers of states, inputs and outputs.
    fn dimensions(&self) -> Dimensions;
}

/// A plant `x' = f(t, x, u)`, `y = h(t, x, u)` over the scalar `T`.
///
/// A nonlinear plant supplied by the user, written once for every scalar that nalgebra can compute with; the macro
/// [`plant!`](crate::plant!) does the same from f and h alone:
/// ```
/// use luenberger_plants::{Dimensions, Plant, Shape};
/// use nalgebra::{RealField, SVector, Vector1, Vector2};
///
/// /// Van der Pol's oscillator x1' = x2, x2' = (1 - x1^2) x2 - x1, y = x1.
/// struct VanDerPol;
///
/// impl Shape for VanDerPol {
///     fn dimensions(&self) -> Dimensions {
///         Dimensions { states: 2, inputs: 0, outputs: 1 }
///     }
/// }
///
/// impl<T: RealField + Copy> Plant<T> for VanDerPol {
///     type State = Vector2<T>;
///     type Input = SVector<T, 0>;
///     type Output = Vector1<T>;
///     fn derivative(&self, _t: T, x: &Vector2<T>, _u: &SVector<T, 0>) -> Vector2<T> {
///         Vector2::new(x[1], (T::one() - x[0] * x[0]) * x[1] - x[0])
///     }
///     fn output(&self, _t: T, x: &Vector2<T>, _u: &Self::Input) -> Vector1<T> {
///         Vector1::new(x[0])
///     }
/// }
/// let slope = VanDerPol.derivative(0.0, &Vector2::new(2.0, 1.0), &SVector::zeros());
/// assert_eq!(slope, Vector2::new(1.0, -5.0));
/// ```
///
/// Where h depends on u, as in `y = C x + D u`, the output is that of the input at the same instant.
///
/// Columns of dynamic length must have the lengths that [`dimensions`](Shape::dimensions) gives; simulation checks that
/// once, before the first call.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a plant over the scalar `{T}`",
    note = "implement `Plant<T>` for every `T: RealField + Copy`",
    note = "or make it of closures with `luenberger_plants::from_fn`, `luenberger::plants::from_fn`"
)]
pub trait Plant<T>: Shape {
    /// Column of the n states.
    type State: Column<T>;
    /// Column of the m inputs.
    type Input: Column<T>;
    /// Column of the p measured outputs.
    type Output: Column<T>;

    /// `f(t, x, u)`.
    fn derivative(&self, t: T, x: &Self::State, u: &Self::Input) -> Self::State;

    /// `h(t, x, u)`.
    fn output(&self, t: T, x: &Self::State, u: &Self::Input) -> Self::Output;

    /// Whether f and h are affine in x and u and do not depend on t; simulation then uses the exact solution. Return
    /// false (default) if this is not known.
    fn is_affine(&self) -> bool {
        false
    }

    /// [`derivative`](Self::derivative) on slices, with the same result to the last bit: what simulation calls. Returns
    /// whether the lengths fit; otherwise `slope` is not written.
    ///
    /// The default makes columns and copies; override it for columns of dynamic length to avoid their allocation.
    fn derivative_into(&self, t: T, x: &[T], u: &[T], slope: &mut [T]) -> bool
    where
        T: Copy,
    {
        let (Some(x), Some(u)) = (Self::State::try_from_slice(x), Self::Input::try_from_slice(u)) else { return false };
        put(&self.derivative(t, &x, &u), slope)
    }

    /// [`output`](Self::output) on slices, as [`derivative_into`](Self::derivative_into).
    fn output_into(&self, t: T, x: &[T], u: &[T], y: &mut [T]) -> bool
    where
        T: Copy,
    {
        let (Some(x), Some(u)) = (Self::State::try_from_slice(x), Self::Input::try_from_slice(u)) else { return false };
        put(&self.output(t, &x, &u), y)
    }
}

/// Copies a column out; whether its length fits.
pub(crate) fn put<T: Copy>(column: &impl Column<T>, target: &mut [T]) -> bool {
    let fits = column.as_slice().len() == target.len();
    if fits {
        target.copy_from_slice(column.as_slice());
    }
    fits
}

impl<S: Shape + ?Sized> Shape for &S {
    fn dimensions(&self) -> Dimensions {
        (**self).dimensions()
    }
}

impl<T, S: Plant<T> + ?Sized> Plant<T> for &S {
    type State = S::State;
    type Input = S::Input;
    type Output = S::Output;

    fn derivative(&self, t: T, x: &Self::State, u: &Self::Input) -> Self::State {
        (**self).derivative(t, x, u)
    }

    fn output(&self, t: T, x: &Self::State, u: &Self::Input) -> Self::Output {
        (**self).output(t, x, u)
    }

    fn is_affine(&self) -> bool {
        (**self).is_affine()
    }

    fn derivative_into(&self, t: T, x: &[T], u: &[T], slope: &mut [T]) -> bool
    where
        T: Copy,
    {
        (**self).derivative_into(t, x, u, slope)
    }

    fn output_into(&self, t: T, x: &[T], u: &[T], y: &mut [T]) -> bool
    where
        T: Copy,
    {
        (**self).output_into(t, x, u, y)
    }
}
