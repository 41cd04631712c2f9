//! The example of the README: design and certify a cubic observer.

use luenberger::design::{Correction, CubicDesign, Decrease, LinearDesign, Wish};
use luenberger::plants::DynamicPlant;
use nalgebra::dmatrix;

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Position is measured, velocity is wanted.
    let plant = DynamicPlant::new(dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0])?;
    let linear = LinearDesign::new(&plant, &Wish::poles(&[-2.0, -5.0]), &Decrease::Scaled(10.0))?;
    let cubic = CubicDesign::new(&linear, &dmatrix![10.0], &Correction::Gamma(2.0))?;
    println!("L = {}N = {}", cubic.observer.l, cubic.observer.n);
    println!("{}", cubic.certificate); // each inequality, proved outside floating point, with its margin
    Ok(())
}
