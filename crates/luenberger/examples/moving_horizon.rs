//! The moving-horizon estimator: least squares over the last samples, with bounds that the Kalman filter does not know.

use luenberger::observers::moving_horizon::{Horizon, MovingHorizonEstimator, state_length};
use luenberger::prelude::*;
use nalgebra::{Const, Matrix1, Matrix2, Vector1, Vector2};

/// Samples in the window.
const WINDOW: usize = 6;

/// Numbers of its state, which lives on the stack.
const STATE: usize = state_length(2, 1, 1, WINDOW);

type Estimator<S> = MovingHorizonEstimator<S, f64, Const<2>, Const<1>, Const<1>, Const<STATE>, WINDOW>;

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A belt whose speed cannot be negative stands still for two seconds, and is then pushed. Its position is measured.
    let plant = luenberger::plants::double_integrator();
    let noises = NoiseModel { w: Matrix2::new(0.0, 0.0, 0.0, 0.01), v: Matrix1::new(0.01), p0: Matrix2::identity() };
    let filter = ExtendedKalmanFilter::new(plant.clone(), noises.clone(), 0.1, 1)?;
    let free: Estimator<_> =
        MovingHorizonEstimator::new(plant, noises, Horizon { window: WINDOW, iterations: 1 }, 0.1, 1)?;
    let bounded = free.clone().with_bounds(Vector2::new(f64::NEG_INFINITY, 0.0), Vector2::repeat(f64::INFINITY))?;

    let (start, none) = (Vector2::new(0.5, 0.5), Vector1::zeros());
    let mut estimate = filter.initial(0.0, &start, &none, &none);
    let (mut window, mut within) =
        (free.initial(0.0, &start, &none, &none), bounded.initial(0.0, &start, &none, &none));
    let (mut worst, mut sums) = (0.0f64, [0.0, 0.0]);
    for k in 0..40 {
        let t = 0.1 * f64::from(k);
        let (u, pushed) = if k < 20 { (0.0, 0.0) } else { (0.5, t - 2.0) };
        let y = Vector1::new(0.25 * pushed * pushed + 0.1 * (12.0 * t).sin());
        let u = Vector1::new(u);
        filter.update(t, &mut estimate, &u, &y);
        free.update(t, &mut window, &u, &y, |_| true);
        bounded.update(t, &mut within, &u, &y, |_| true);
        // Without bounds it is the filter, to rounding.
        worst = worst.max((free.estimate(&window) - estimate.estimate()).amax());
        let speed = 0.5 * pushed;
        sums[0] += (estimate.estimate()[1] - speed).powi(2);
        sums[1] += (bounded.estimate(&within)[1] - speed).powi(2);
        assert!(bounded.estimate(&within)[1] >= 0.0);
        assert!(filter.predict(t, &mut estimate, &u, 0.1));
        assert!(free.predict(t, &mut window, &u, 0.1) && bounded.predict(t, &mut within, &u, 0.1));
    }
    let [of_filter, of_bounded] = sums.map(|sum: f64| (sum / 40.0).sqrt());
    println!("without bounds it differs from the Kalman filter by {worst:.1e}");
    println!("root mean square of the error of the speed: filter {of_filter:.3}, with the bound {of_bounded:.3}");
    assert!(worst < 1e-10 && of_bounded < of_filter);
    Ok(())
}
