//! The example of the README: design and certify a cubic observer.

use luenberger::design::{CubicDesign, CubicGain, LinearDesign, LyapunovWeight};
use luenberger::plants::StateSpace;
use nalgebra::dmatrix;

pub(crate) fn main() -> Result<(), luenberger::Error> {
    // Position is measured, velocity is wanted.
    let plant = StateSpace::new(dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0])?;
    let linear = LinearDesign::with_poles_and_weight(&plant, &[-2.0, -5.0], LyapunovWeight::Identity(10.0))?;
    let cubic = CubicDesign::new(&linear, &dmatrix![10.0], &CubicGain::Gamma(2.0))?;
    println!("L = {}N = {}", cubic.l(), cubic.observer.n);
    println!("{}", cubic.certificate); // each inequality, proved outside floating point, with its margin
    Ok(())
}
