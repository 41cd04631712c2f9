//! A plant from its equations, for every scalar.

/// `plant!(Type, (n, m, p), |plant, t, x, u| f, h)` implements [`Shape`](crate::Shape), [`Plant`](crate::Plant) over
/// every scalar and [`ByDual`](crate::ByDual) for a type, with f and h as arrays or columns of n and p numbers.
///
/// The scalar is `T`: a parameter of the plant, or a constant, becomes one by `nalgebra::convert`.
///
/// ```
/// use luenberger_plants::{Shape, plant, state_jacobian};
/// use nalgebra::{Matrix2, Vector1, Vector2, convert};
///
/// /// A pendulum with friction and a torque: x1' = x2, x2' = u - sin x1 - c x2, y = x1.
/// struct Pendulum {
///     c: f64,
/// }
///
/// plant!(
///     Pendulum,
///     (2, 1, 1),
///     |plant, _t, x, u| [x[1], u[0] - x[0].sin() - convert::<f64, T>(plant.c) * x[1]],
///     [x[0]]
/// );
///
/// let plant = Pendulum { c: 0.5 };
/// assert_eq!(plant.dimensions().states, 2);
/// let jacobian = state_jacobian(&plant, 0.0, &Vector2::zeros(), &Vector1::zeros());
/// assert_eq!(jacobian, Matrix2::new(0.0, 1.0, -1.0, -0.5));
/// ```
#[macro_export]
macro_rules! plant {
    (
        $plant:ty, ($n:literal, $m:literal, $p:literal),
        |$this:ident, $t:ident, $x:ident, $u:ident| $f:expr, $h:expr $(,)?
    ) => {
        impl $crate::ByDual for $plant {}

        impl $crate::Shape for $plant {
            fn dimensions(&self) -> $crate::Dimensions {
                $crate::Dimensions { states: $n, inputs: $m, outputs: $p }
            }
        }

        #[allow(unused_variables, reason = "f and h rarely need all of plant, t, x and u")]
        impl<T: $crate::nalgebra::RealField + Copy> $crate::Plant<T> for $plant {
            type State = $crate::nalgebra::SVector<T, $n>;
            type Input = $crate::nalgebra::SVector<T, $m>;
            type Output = $crate::nalgebra::SVector<T, $p>;

            fn derivative(&self, $t: T, $x: &Self::State, $u: &Self::Input) -> Self::State {
                let $this = self;
                $f.into()
            }

            fn output(&self, $t: T, $x: &Self::State, $u: &Self::Input) -> Self::Output {
                let $this = self;
                $h.into()
            }
        }
    };
}
