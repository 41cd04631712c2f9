//! An immersion-and-invariance observer of Van der Pol's oscillator: only the maps beta and phi are written down, the
//! observer follows.

use luenberger::plants::VanDerPol;
use luenberger::prelude::*;
use nalgebra::{RealField, U0, U1, U2, Vector1, Vector2, convert};

/// phi = x2 and beta = chi + k y: on the manifold beta = phi the estimate is right, and off it e' = (mu (1 - y^2) - k)
/// e.
#[derive(Clone, Copy)]
struct Shifted {
    k: f64,
}

#[rustfmt::skip]
impl luenberger::plants::ByDual for Shifted {}

impl<T: RealField + Copy> Immersion<T> for Shifted {
    type States = U2;
    type Inputs = U0;
    type Outputs = U1;
    type Manifold = U1;
    type Extension = U1;
    type Estimate = U1;
    fn beta(&self, y: &Vector1<T>, chi: &Vector1<T>) -> Vector1<T> {
        chi + y * convert::<f64, T>(self.k)
    }
    fn phi(&self, x: &Vector2<T>) -> Vector1<T> {
        Vector1::new(x[1])
    }
    fn left_inverse(&self, z: &Vector1<T>, y: &Vector1<T>) -> Vector2<T> {
        Vector2::new(y[0], z[0])
    }
    fn estimate(&self, xhat: &Vector2<T>) -> Vector1<T> {
        Vector1::new(xhat[1])
    }
    fn start(&self, estimate: &Vector1<T>, y: &Vector1<T>) -> Vector1<T> {
        estimate - y * convert::<f64, T>(self.k)
    }
}

pub(crate) fn main() -> Result<(), luenberger::Error> {
    let plant = VanDerPol { mu: 1.0 };
    let observer = |k: f64| ImmersionInvarianceObserver::new(plant, Shifted { k });
    let run = Scenario::new(plant)
        .initial_state(&[2.0, 0.5])
        .partial_observer("k = 0", observer(0.0), &[3.0], &[1])
        .partial_observer("k = 3", observer(3.0), &[3.0], &[1])
        .partial_observer("k = 10", observer(10.0), &[3.0], &[1])
        .until(2.0, 5)
        .run()?;
    for name in ["k = 0", "k = 3", "k = 10"] {
        let error: Vec<String> = run.observer(name)?.error.iter().map(|e| format!("{e:+.1e}")).collect();
        println!("{name:6}: x2 - xhat2 at t = 0, 0.5, .., 2: {}", error.join("  "));
    }
    // Where |y| < 1 the plant pushes errors apart by at most mu = 1: k = 3 leaves a rate of 2 everywhere.
    let last = run.observer("k = 3")?.error[(4, 0)].abs();
    assert!(last <= 2.5 * (-2.0 * 2f64).exp());
    Ok(())
}
