//! Observers on measured data: the true state is unknown, and an observer is assessed by its innovation.

use luenberger::prelude::*;
use nalgebra::{DMatrix, Matrix1, Matrix2, RowVector2, Vector2};

/// A motor: its voltage and the angle measured by its encoder, sampled at 100 Hz.
const LOG: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../study/templates/measured-log.csv");

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let text = std::fs::read_to_string(LOG)?;
    let rows: Result<Vec<Vec<f64>>, _> =
        text.lines().skip(1).map(|line| line.split(',').map(str::parse).collect()).collect();
    let rows = rows?;
    let column = |k: usize| DMatrix::from_fn(rows.len(), 1, |row, _| rows[row][k]);
    let recording = Recording::new(rows.iter().map(|row| row[0]).collect(), column(1), column(2))?;

    // angle' = speed, speed' = -2 speed + 8 voltage.
    let plant = LinearPlant::new(Matrix2::new(0.0, 1.0, 0.0, -2.0), Vector2::new(0.0, 8.0), RowVector2::new(1.0, 0.0))?;
    let noises = NoiseModel { w: Matrix2::new(0.0, 0.0, 0.0, 0.01), v: Matrix1::new(1e-4), p0: Matrix2::identity() };
    let replayed = Replay::new(plant.clone(), recording)
        .observer("slow", LinearObserver::of(plant.clone(), Vector2::new(1.0, 1.0))?, &[0.0, 0.0])
        .observer("fast", LinearObserver::of(plant.clone(), Vector2::new(43.0, 414.0))?, &[0.0, 0.0])
        .filter("Kalman filter", ExtendedKalmanFilter::new(plant, noises, 0.01, 1)?, &[0.0, 0.0])
        .run()?;

    println!("{} samples; innovations from t = 1 on:", rows.len());
    for observer in &replayed.observers {
        let angle = &observer.statistics(1.0)?[0];
        let white = angle.whiteness.as_ref().map_or("-".to_owned(), |test| format!("{:.3}", test.p_value));
        let last = observer.estimate[(observer.t.len() - 1, 1)];
        println!(
            "{:>14}: rms {:.4}, whiteness test p-value {white}, speed at the end {last:.3}",
            observer.name, angle.rms
        );
    }
    // The filter says how sure it is as well, and the data agree. The slow observer has not caught up with the speed:
    // its innovation is the largest.
    let filter = replayed.observer("Kalman filter")?;
    let consistency = filter.consistency(1.0)?.ok_or("a filter knows its covariance")?;
    let (low, high) = consistency.bounds;
    println!("nu' S^-1 nu of the filter is {:.3} on average; it should be {low:.3} to {high:.3}", consistency.mean);
    assert!((low..high).contains(&consistency.mean));
    assert!(replayed.observer("slow")?.statistics(1.0)?[0].rms > filter.statistics(1.0)?[0].rms);
    Ok(())
}
