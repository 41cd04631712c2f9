//! The examples of the papers that several subjects are tested on.

use luenberger_design::{CubicDesign, CubicGain, LinearDesign, LyapunovWeight};
use luenberger_plants::{StateSpace, double_integrator};
use nalgebra::dmatrix;

/// Example 1 of the cubic-observer paper: the plant, the linear and the cubic observer.
pub(crate) fn example_1() -> (StateSpace, LinearDesign, CubicDesign) {
    let plant = double_integrator().to_dynamic();
    let linear = LinearDesign::with_poles_and_weight(&plant, &[-2.0, -5.0], LyapunovWeight::Identity(10.0)).unwrap();
    let cubic = CubicDesign::new(&linear, &dmatrix![10.0], &CubicGain::Gamma(2.0)).unwrap();
    (plant, linear, cubic)
}
