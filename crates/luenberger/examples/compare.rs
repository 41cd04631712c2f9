//! Observers of the flexible joint: the printed observer with the true and with a zero initial error, the observer
//! with output injection, and the extended Kalman filter.
//!
//! `cargo run --release -p luenberger --example compare`

use luenberger::linalg::kalman_gain;
use luenberger::observers::{Beta, ExtendedKalmanFilter, Integral, MeanValueObserver, NoiseModel};
use luenberger::plants::flexible_joint;
use luenberger::sim::{Comparison, Noise, Scenario, Signal};
use nalgebra::{DMatrix, Matrix2, Matrix4, SMatrix, Vector4};

pub(crate) fn main() -> Result<(), luenberger::Error> {
    let plant = flexible_joint::classical();
    let (x0, xhat0) = (Vector4::repeat(3.0), Vector4::new(1.0, 2.0, 0.5, 1.0));

    let a = DMatrix::from_column_slice(4, 4, plant.linear_part().as_slice());
    let (w, v) = (DMatrix::identity(4, 4) * 10.0, DMatrix::identity(2, 2) * 1e-3);
    let l = kalman_gain(&a, &DMatrix::identity(2, 4), &w, &v)?.l;
    let l = SMatrix::<f64, 4, 2>::from_column_slice(l.as_slice());

    let informed = MeanValueObserver::new(plant, 1.0, Beta, x0 - xhat0)?;
    let uninformed = MeanValueObserver::new(plant, 1.0, Beta, Vector4::zeros())?;
    let injected = MeanValueObserver::with_output_injection(plant, 1.0, Integral, Vector4::zeros(), l)?;
    let noises =
        NoiseModel { w: Matrix4::identity() * 0.1, v: Matrix2::identity() * 1e-4, p0: Matrix4::identity() * 4.0 };
    let filter = ExtendedKalmanFilter::new(plant, noises, 0.01, 2)?;

    let scenario = Scenario::new(plant)
        .initial_state(x0.as_slice())
        .input(Signal::scalar(f64::sin))
        .hold_input(0.01)
        .noise(Noise::gaussian(&[0.01, 0.01], 0.01, 1))
        .until(10.0, 101);
    let table = Comparison::new(scenario, xhat0.as_slice())
        .observer("printed, e(0) = x(0) - xhat(0)", &informed)
        .observer("printed, e(0) = 0", &uninformed)
        .observer("output injection, e(0) = 0", &injected)
        .sampled_observer("extended Kalman filter", &filter)
        .run()?;
    println!("{table}");
    Ok(())
}
