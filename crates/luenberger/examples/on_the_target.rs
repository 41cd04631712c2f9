//! The sampled-data cubic observer as it runs on a microcontroller: sizes known at compile time, single precision, no
//! allocation.
//!
//! The design is done once, on the desk, in double precision; what goes to the target is a handful of numbers.

use luenberger::prelude::*;
use nalgebra::{Matrix1, Matrix2, RowVector2, Vector1, Vector2, dmatrix};

/// 1 kHz.
const PERIOD: f64 = 1e-3;

pub(crate) fn main() -> Result<(), luenberger::Error> {
    // The desk.
    let plant = luenberger::plants::double_integrator().to_dynamic();
    let linear = LinearDesign::with_poles(&plant, &[-2.0, -5.0])?;
    let design = SampledCubicDesign::new(&linear, &dmatrix![1.0], 10.0, PERIOD)?;
    print!("{}", design.certificate);

    // The target: f32, on the stack.
    let o = &design.observer;
    let column = |m: &nalgebra::DMatrix<f64>| Vector2::new(m[(0, 0)] as f32, m[(1, 0)] as f32);
    let (c, n, theta) = (RowVector2::new(1.0_f32, 0.0), column(o.n()), Matrix1::new(1.0_f32));
    let ad = Matrix2::from_fn(|i, j| o.ad()[(i, j)] as f32);
    let (bd, ld, w, period) = (column(o.bd()), column(o.ld()), -n[0], PERIOD as f32);
    let observer = SampledCubicObserver::new(SampledCubicGains { ad, bd, c, ld, n, theta, w, period })?;

    let (mut x, mut xhat) = (Vector2::new(100.0_f32, 100.0), Vector2::zeros());
    for k in 0..8000_u16 {
        let (u, y) = (Vector1::new(0.0), Vector1::new(x[0]));
        observer.step(f32::from(k) * PERIOD as f32, &mut xhat, &u, &y);
        x[0] += PERIOD as f32 * x[1];
    }
    println!("after 8 s from an error of (100, 100): {:?}", x - xhat);
    Ok(())
}
