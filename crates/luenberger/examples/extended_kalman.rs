//! The extended Kalman filter: it uses the covariances of the noise, computes its own, and has no global certificate.

use luenberger::plants::VanDerPol;
use luenberger::prelude::*;
use nalgebra::{DMatrix, Matrix1, Matrix2};

/// 100 Hz.
const PERIOD: f64 = 0.01;

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    // x1' = x2, x2' = (1 - x1^2) x2 - x1; x1 is measured, with noise of standard deviation 0.05.
    let plant = VanDerPol { mu: 1.0 };
    let noise = Noise::gaussian(&[0.05], PERIOD, 7);
    let filter = |v: f64| {
        let (w, v, p0) = (Matrix2::identity() * 1e-3, Matrix1::new(v), Matrix2::identity());
        ExtendedKalmanFilter::new(plant, NoiseModel { w, v, p0 }, PERIOD, 1)
    };
    let run = Scenario::new(plant)
        .initial_state(&[1.0, 0.0])
        .noise(noise.clone())
        .sampled_observer("filter", filter(0.0025)?, &[0.0, 2.0])
        .until(20.0, 2001)
        .run()?;
    let error = &run.observer("filter")?.error;
    for k in [0, 100, 500, 2000] {
        println!("t = {:4}: e = ({:+.4}, {:+.4})", run.t[k], error[(k, 0)], error[(k, 1)]);
    }
    let late = error.rows(500, 1501).column(0).norm() / 1501f64.sqrt();
    println!("root mean square of e1 from t = 5 on: {late:.4}; of the sensor alone: 0.05");
    assert!(late < 0.03);

    // What the sensor said, once more through three filters: which of them believes in the right noise?
    let y =
        DMatrix::from_fn(run.t.len(), 1, |k, _| run.y[(k, 0)] + noise.sample(Purpose::MeasurementNoise, k as u64)[0]);
    let recording = Recording::new(run.t.clone(), DMatrix::zeros(run.t.len(), 0), y)?;
    for v in [0.000025, 0.0025, 0.25] {
        let replay = Replay::new(plant, recording.clone()).filter("filter", filter(v)?, &[0.0, 2.0]);
        let replayed = replay.run()?;
        let consistency = replayed.observer("filter")?.consistency(5.0)?.ok_or("a filter knows its covariance")?;
        let (low, high) = consistency.bounds;
        println!("V = {v}: nu' S^-1 nu is {:.2} on average; it should be {low:.2} to {high:.2}", consistency.mean);
    }
    Ok(())
}
