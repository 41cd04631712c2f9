//! The robot link with a flexible joint, Example 2 of the mean-value-theorem paper: with its misprint corrected, as
//! printed, and classical.
//!
//! ```text
//! x1' = x2                                     angle and speed of the motor
//! x2' = -48.6 x1 - 1.25 x2 + 48.6 x3 + 21.6 u
//! x3' = x4                                     angle and speed of the link
//! x4' = 19.5 x1 - 19.5 x3 + a44 x4 - 3.33 sin(x3)
//! ```
//!
//! The paper prints `a44 = 3.33`, which makes the plant unstable, and `y = (x1, x2, x3)`. [`corrected`] repairs that
//! misprint and nothing else: it is the plant of the example. In the classical benchmark `a44 = 0` too, and the motor
//! alone is measured, `y = (x1, x2)`. Each is here under its name.
//!
//! Sources: R. Ben Messaoud and S. Hajji, WSEAS Transactions on Systems 17, 2018, Example 2; R. Rajamani, Observers for
//! Lipschitz nonlinear systems, IEEE Transactions on Automatic Control 43, 1998, for the benchmark.

use nalgebra::{Matrix4, RealField, SVector, Vector1, Vector4, convert};

use crate::plant::{Dimensions, Plant, Shape};

/// The flexible joint with the first P states measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlexibleJoint<const P: usize> {
    a44: f64,
}

/// The classical benchmark: `a44 = 0`, `C = [I2 0]`.
///
/// ```
/// use luenberger_plants::{Plant, flexible_joint};
/// use nalgebra::{Vector1, Vector4};
/// let slope = flexible_joint::classical().derivative(0.0, &Vector4::new(1.0, 0.0, 1.0, 2.0), &Vector1::new(1.0));
/// assert!((slope - Vector4::new(0.0, 21.6, 2.0, -3.33 * 1f64.sin())).amax() <= 16.0 * f64::EPSILON);
/// ```
pub fn classical() -> FlexibleJoint<2> {
    FlexibleJoint { a44: 0.0 }
}

/// Example 2 with its misprint corrected: `a44 = 0`, `C = [I3 0]` as printed.
///
/// ```
/// use luenberger_plants::{Shape, flexible_joint};
/// use nalgebra::Vector4;
/// let plant = flexible_joint::corrected();
/// assert_eq!(plant.linear_part(), flexible_joint::classical().linear_part());
/// assert_eq!(plant.dimensions().outputs, 3);
/// ```
pub fn corrected() -> FlexibleJoint<3> {
    FlexibleJoint { a44: 0.0 }
}

/// As the paper prints it: `a44 = 3.33`, `C = [I3 0]`.
///
/// ```
/// let plant = luenberger_plants::flexible_joint::printed();
/// assert_eq!((plant.linear_part()[(3, 3)], luenberger_plants::flexible_joint::classical().linear_part()[(3, 3)]), (3.33, 0.0));
/// ```
pub fn printed() -> FlexibleJoint<3> {
    FlexibleJoint { a44: 3.33 }
}

impl<const P: usize> FlexibleJoint<P> {
    /// The matrix A of `x' = A x + B u + (0, 0, 0, -3.33 sin x3)`.
    pub fn linear_part(&self) -> Matrix4<f64> {
        Matrix4::new(
            0.0, 1.0, 0.0, 0.0, //
            -48.6, -1.25, 48.6, 0.0, //
            0.0, 0.0, 0.0, 1.0, //
            19.5, 0.0, -19.5, self.a44,
        )
    }
}

impl<const P: usize> crate::jacobian::ByDual for FlexibleJoint<P> {}

impl<const P: usize> Shape for FlexibleJoint<P> {
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: 4, inputs: 1, outputs: P }
    }
}

impl<T: RealField + Copy, const P: usize> Plant<T> for FlexibleJoint<P> {
    type State = Vector4<T>;
    type Input = Vector1<T>;
    type Output = SVector<T, P>;

    fn derivative(&self, _t: T, x: &Vector4<T>, u: &Vector1<T>) -> Vector4<T> {
        let number = |value: f64| convert::<f64, T>(value);
        let mut slope = self.linear_part().map(number) * x;
        slope[1] += number(21.6) * u[0];
        slope[3] -= number(3.33) * x[2].sin();
        slope
    }

    fn output(&self, _t: T, x: &Vector4<T>, _u: &Self::Input) -> SVector<T, P> {
        // The constructors make P = 2 and P = 3 only.
        SVector::from_fn(|i, _| x[i])
    }
}
