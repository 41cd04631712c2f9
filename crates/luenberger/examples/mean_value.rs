//! The mean-value-theorem observer on a flexible joint: as printed it converges if e(0) = x(0) - xhat(0),
//! with output injection from any e(0).

use luenberger::design::mean_value::MeanValueDesign;
use luenberger::observers::Integral;
use luenberger::plants::flexible_joint;
use luenberger::prelude::*;
use nalgebra::{DMatrix, Vector4};

pub(crate) fn main() -> Result<(), luenberger::Error> {
    // Angle and speed of the motor are measured, those of the link are wanted; gravity pulls the link by 3.33 sin x3.
    let plant = flexible_joint::classical();
    let a = DMatrix::from_column_slice(4, 4, plant.linear_part().as_slice());
    let vertices = [-3.33, 3.33].map(|slope| {
        let mut vertex = a.clone();
        vertex[(3, 2)] += slope;
        vertex
    });
    // One gain for every slope that the sine has: the error decays at least like exp(-t), from wherever it starts.
    let design = MeanValueDesign::new(&vertices, 2, 1.0)?;
    println!("L = {:.2}{}", design.l, design.certificate);

    let (x0, xhat0) = (Vector4::repeat(3.0), Vector4::new(1.0, 2.0, 0.5, 1.0));
    let zero = Vector4::zeros();
    let informed = MeanValueObserver::new(plant, 1.0, Integral, x0 - xhat0)?;
    let printed = MeanValueObserver::new(plant, 1.0, Integral, zero)?;
    let injected = design.observer(plant, 1.0, Integral, zero)?;
    let scenario = Scenario::new(plant).initial_state(x0.as_slice()).input(Signal::scalar(f64::sin)).until(10.0, 101);
    let table = Comparison::new(scenario, xhat0.as_slice())
        .observer("printed, e(0) = x(0) - xhat(0)", &informed)
        .observer("printed, e(0) = 0", &printed)
        .observer("output injection, e(0) = 0", &injected)
        .run()?;
    println!("{table}");
    assert!(table.metrics("output injection, e(0) = 0")?.last < 1e-2 * table.metrics("printed, e(0) = 0")?.last);
    Ok(())
}
