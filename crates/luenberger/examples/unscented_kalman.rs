//! The unscented Kalman filter: right to second order; and what its smoother makes of a log.

use luenberger::observers::SigmaPoints;
use luenberger::prelude::*;
use nalgebra::{Matrix1, SVector, Vector1};

/// A constant x, measured as x^2.
struct Square;

luenberger::plants::plant!(Square, (1, 0, 1), |plant, t, x, u| [x[0]], [x[0] * x[0]]);

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The variance of a measurement is 0.01, the initial estimate 1 with variance 0.25.
    let noises = NoiseModel { w: Matrix1::new(1e-6_f64), v: Matrix1::new(0.01), p0: Matrix1::new(0.25) };
    let filter = UnscentedKalmanFilter::discrete(Square, noises, SigmaPoints::default(), 1.0)?;
    let u = SVector::zeros();
    let mut estimate = filter.initial(0.0, &Vector1::new(1.0), &u, &Vector1::zeros());
    let innovation = filter.update(0.0, &mut estimate, &u, &Vector1::new(1.44)).ok_or("a factor")?;
    // E x^2 = 1 + 0.25, and var x^2 = 4 * 0.25 + 2 * 0.25^2. To first order it would be 1, and 4 * 0.25.
    println!(
        "y is expected to be {:.3}, with variance {:.3}",
        1.44 - innovation.value[0],
        innovation.covariance[(0, 0)]
    );
    assert!((innovation.value[0] - 0.19).abs() < 1e-12 && (innovation.covariance[(0, 0)] - 1.135).abs() < 1e-12);

    // The true x is 1.2. Ten measurements, and what the whole log says of the first row.
    let y = DMatrix::from_fn(10, 1, |k, _| 1.44 + if k % 2 == 0 { 0.1 } else { -0.1 });
    let recording = Recording::new((0..10).map(f64::from).collect(), DMatrix::zeros(10, 0), y)?;
    let replayed = Replay::new(Square, recording).smoothed_filter("filter", filter, &[1.0]).run()?;
    let found = replayed.observer("filter")?;
    let smoothed = found.smoothed.as_ref().ok_or("a smoothed filter")?;
    for k in [0, 4, 9] {
        println!(
            "row {k}: {:.4} from the past, {:.4} from the whole log",
            found.estimate[(k, 0)],
            smoothed.estimate[(k, 0)]
        );
    }
    assert!((found.estimate[(9, 0)] - 1.2).abs() < 0.02);
    assert!((smoothed.estimate[(0, 0)] - 1.2).abs() < (found.estimate[(0, 0)] - 1.2).abs());
    Ok(())
}
