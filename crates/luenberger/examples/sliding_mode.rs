//! The super-twisting observer: exact after a finite time, and without chattering by its implicit step.

use luenberger::design::{SuperTwistingDesign, sliding_mode_gains};
use luenberger::observers::SampledObserver;
use luenberger::observers::sliding_mode::{Discretisation, SlidingModeObserver};
use nalgebra::{U1, U2, Vector1, Vector2};

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A double integrator whose force is unknown, up to 1; its position is sampled every 10 ms.
    let (bound, h, force) = (1.0, 0.01, 0.8);
    let gains = sliding_mode_gains(2, bound)?;
    let design = SuperTwistingDesign::new([gains[0], gains[1]], bound)?.ok_or("no certificate for these gains")?;
    println!("in continuous time the error (0, 1) is 0 after {:.1} at most", design.reaching_time(0.0, 1.0));
    for rule in [Discretisation::Explicit, Discretisation::Implicit] {
        let plant = luenberger::plants::double_integrator();
        let gains = Vector2::new(gains[0], gains[1]);
        let observer = SlidingModeObserver::<_, f64, U2, U1, U1>::new(plant, gains, h, rule)?;
        let (mut x, mut xhat): (Vector2<f64>, Vector2<f64>) = (Vector2::new(0.5, -0.5), Vector2::zeros());
        let (mut largest, mut switched, mut last) = (0.0_f64, 0.0, 0.0);
        for k in 0..2000 {
            let s = observer.resolved(x[0] - xhat[0]).1;
            if k > 1000 {
                largest = largest.max((x[1] - xhat[1]).abs());
                switched += (s - last) * (s - last).signum();
            }
            last = s;
            observer.step(0.0, &mut xhat, &Vector1::zeros(), &Vector1::new(x[0]));
            x = Vector2::new(x[0] + h * x[1] + h * h / 2.0 * force, x[1] + h * force);
        }
        println!("{rule:?}: largest error of the velocity {largest:.4}, variation of the sign {switched:.1} in 10 s");
        if rule == Discretisation::Implicit {
            // What an unknown force does over a period and a half.
            assert!((largest - 1.5 * h * force).abs() < 1e-6 && switched < 1e-6);
        } else {
            assert!(switched > 100.0);
        }
    }
    Ok(())
}
