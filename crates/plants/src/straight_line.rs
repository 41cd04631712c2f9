//! A plant from four functions on arrays: what `luenberger export --to rust` writes.

/// Implements [`Shape`](crate::Shape), [`Plant`](crate::Plant) and [`Differentiable`](crate::Differentiable) for a
/// type, a scalar, n states, m inputs, p outputs and four functions:
///
/// | function | writes |
/// |---|---|
/// | first | `f(t, x, u)`, n numbers |
/// | second | `h(t, x, u)`, p numbers |
/// | third | `f(t, x, u)` and then df/dx row by row, n + n^2 numbers |
/// | fourth | `h(t, x, u)` and then dh/dx row by row, p + p n numbers |
///
/// Each takes t, x as an array, u as a slice of length m, and the array that it writes. The lengths are known, so that
/// nothing can panic.
/// ```
/// use luenberger_plants::nalgebra::{Matrix2, SVector, Vector2};
/// use luenberger_plants::{Differentiable, Plant, straight_line_plant};
///
/// /// The pendulum x1' = x2, x2' = -x1^3, y = x1.
/// struct Pendulum;
///
/// straight_line_plant!(Pendulum, f64, 2, 0, 1, f, h, motion, measurement);
///
/// fn f(_t: f64, x: &[f64; 2], _u: &[f64], out: &mut [f64; 2]) {
///     *out = [x[1], -x[0] * x[0] * x[0]];
/// }
///
/// fn h(_t: f64, x: &[f64; 2], _u: &[f64], out: &mut [f64; 1]) {
///     *out = [x[0]];
/// }
///
/// fn motion(_t: f64, x: &[f64; 2], _u: &[f64], out: &mut [f64; 6]) {
///     *out = [x[1], -x[0] * x[0] * x[0], 0.0, 1.0, -3.0 * x[0] * x[0], 0.0];
/// }
///
/// fn measurement(_t: f64, x: &[f64; 2], _u: &[f64], out: &mut [f64; 3]) {
///     *out = [x[0], 1.0, 0.0];
/// }
///
/// let (x, u) = (Vector2::new(2.0, 1.0), SVector::zeros());
/// assert_eq!(Pendulum.derivative(0.0, &x, &u), Vector2::new(1.0, -8.0));
/// assert_eq!(Pendulum.state_jacobian(0.0, &x, &u), Matrix2::new(0.0, 1.0, -12.0, 0.0));
/// ```
#[macro_export]
macro_rules! straight_line_plant {
    ($plant:ty, $scalar:ty, $n:literal, $m:literal, $p:literal, $f:path, $h:path, $motion:path, $measurement:path) => {
        impl $crate::Shape for $plant {
            fn dimensions(&self) -> $crate::Dimensions {
                $crate::Dimensions { states: $n, inputs: $m, outputs: $p }
            }
        }

        impl $crate::Plant<$scalar> for $plant {
            type State = $crate::nalgebra::SVector<$scalar, $n>;
            type Input = $crate::nalgebra::SVector<$scalar, $m>;
            type Output = $crate::nalgebra::SVector<$scalar, $p>;

            fn derivative(&self, t: $scalar, x: &Self::State, u: &Self::Input) -> Self::State {
                let mut out = [0.0; $n];
                $f(t, &x.data.0[0], u.as_slice(), &mut out);
                out.into()
            }

            fn output(&self, t: $scalar, x: &Self::State, u: &Self::Input) -> Self::Output {
                let mut out = [0.0; $p];
                $h(t, &x.data.0[0], u.as_slice(), &mut out);
                out.into()
            }
        }

        impl
            $crate::Differentiable<
                $scalar,
                $crate::nalgebra::Const<$n>,
                $crate::nalgebra::Const<$m>,
                $crate::nalgebra::Const<$p>,
            > for $plant
        {
            fn directional(
                &self,
                t: $scalar,
                x: &Self::State,
                u: &Self::Input,
                v: &Self::State,
            ) -> (Self::State, Self::State) {
                ($crate::Plant::derivative(self, t, x, u), $crate::Differentiable::state_jacobian(self, t, x, u) * v)
            }

            fn output_directional(
                &self,
                t: $scalar,
                x: &Self::State,
                u: &Self::Input,
                v: &Self::State,
            ) -> (Self::Output, Self::Output) {
                ($crate::Plant::output(self, t, x, u), $crate::Differentiable::output_jacobian(self, t, x, u) * v)
            }

            fn state_jacobian(
                &self,
                t: $scalar,
                x: &Self::State,
                u: &Self::Input,
            ) -> $crate::nalgebra::SMatrix<$scalar, $n, $n> {
                let mut out = [0.0; $n + $n * $n];
                $motion(t, &x.data.0[0], u.as_slice(), &mut out);
                $crate::nalgebra::SMatrix::from_fn(|i, j| out[$n + i * $n + j])
            }

            fn output_jacobian(
                &self,
                t: $scalar,
                x: &Self::State,
                u: &Self::Input,
            ) -> $crate::nalgebra::SMatrix<$scalar, $p, $n> {
                let mut out = [0.0; $p + $p * $n];
                $measurement(t, &x.data.0[0], u.as_slice(), &mut out);
                $crate::nalgebra::SMatrix::from_fn(|i, j| out[$p + i * $n + j])
            }
        }
    };
}
