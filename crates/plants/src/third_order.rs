//! The two third-order plants of the cubic-observer paper.
//!
//! Source: M. M. Share Pasand, Luenberger-type cubic observers for state estimation of linear systems, Examples 2 and
//! 3.

use nalgebra::{Matrix3, Matrix3x2, RowVector3, SMatrix};

use crate::linear::{LinearPlant, StaticPlant};

/// Example 2: a stable plant without input (B has no columns), on which the paper studies robustness.
///
/// ```
/// use luenberger_plants::Shape;
/// let plant = luenberger_plants::third_order::example2();
/// assert_eq!(plant.dimensions().inputs, 0);
/// ```
pub fn example2() -> StaticPlant<f64, 3, 0, 1> {
    LinearPlant {
        a: Matrix3::new(-0.1, -0.2, 0.0, 0.3, 0.0, 0.0, 0.1, 0.2, -3.0),
        b: SMatrix::<f64, 3, 0>::zeros(),
        c: RowVector3::new(1.0, 1.0, 2.0),
        d: None,
    }
}

/// Example 3: an unstable plant with two inputs, on which the paper closes the loop `u = -K xhat`.
///
/// ```
/// use luenberger_plants::Shape;
/// let plant = luenberger_plants::third_order::example3();
/// assert_eq!((plant.dimensions().inputs, plant.a[(2, 2)]), (2, 3.0));
/// ```
pub fn example3() -> StaticPlant<f64, 3, 2, 1> {
    LinearPlant {
        a: Matrix3::new(0.1, -2.0, 0.0, 0.3, 0.0, -1.0, 0.1, 0.2, 3.0),
        b: Matrix3x2::new(1.0, 2.0, 2.0, 0.0, 0.0, 1.0),
        c: RowVector3::new(1.0, 1.0, 2.0),
        d: None,
    }
}
