//! The double integrator: Example 1 of the cubic-observer paper.

use nalgebra::{Matrix2, RowVector2, Vector2};

use crate::linear::{LinearPlant, StaticPlant};

/// `x1' = x2`, `x2' = u`, `y = x1`: position is measured, force is the input, speed is wanted.
///
/// ```
/// use luenberger_plants::Plant;
/// use nalgebra::{Vector1, Vector2};
/// let plant = luenberger_plants::double_integrator();
/// assert_eq!(plant.derivative(0.0, &Vector2::new(1.0, 2.0), &Vector1::new(3.0)), Vector2::new(2.0, 3.0));
/// ```
///
/// Source: M. M. Share Pasand, Luenberger-type cubic observers for state estimation of linear systems, Example 1.
pub fn double_integrator() -> StaticPlant<f64, 2, 1, 1> {
    LinearPlant {
        a: Matrix2::new(0.0, 1.0, 0.0, 0.0),
        b: Vector2::new(0.0, 1.0),
        c: RowVector2::new(1.0, 0.0),
        d: None,
    }
}
