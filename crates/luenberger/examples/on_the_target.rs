//! The sampled-data cubic observer as it runs on a microcontroller: sizes known at compile time, single precision, no
//! allocation.
//!
//! The design is done once, on the desk, in double precision; what goes to the target is a handful of numbers.

use luenberger::prelude::*;
use nalgebra::{Vector1, Vector2};

/// 1 kHz.
const PERIOD: f64 = 1e-3;

pub(crate) fn main() -> Result<(), luenberger::Error> {
    // The desk.
    let plant = luenberger::plants::double_integrator().to_dynamic();
    let linear = LinearDesign::with_poles(&plant, &[-2.0, -5.0])?;
    let design = SampledCubicDesign::new(&linear, &dmatrix![1.0], 10.0, PERIOD)?;
    print!("{}", design.certificate);

    // The target: f32, on the stack.
    let observer = design.observer.to_static::<f32, 2, 1, 1>()?;

    let (mut x, mut xhat) = (Vector2::new(100.0_f32, 100.0), Vector2::zeros());
    for k in 0..8000_u16 {
        let (u, y) = (Vector1::new(0.0), Vector1::new(x[0]));
        observer.step(f32::from(k) * PERIOD as f32, &mut xhat, &u, &y);
        x[0] += PERIOD as f32 * x[1];
    }
    println!("after 8 s from an error of (100, 100): {:?}", x - xhat);
    Ok(())
}
