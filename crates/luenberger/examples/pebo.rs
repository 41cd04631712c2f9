//! A parameter-estimation-based observer: what integration leaves unknown is a constant, and constants can be
//! estimated.

use luenberger::observers::estimator::gradient::Gradient;
use luenberger::prelude::*;
use nalgebra::{Matrix1, U1, Vector1, convert};

type V1 = Vector1<f64>;

/// A mass on a stiffening spring: x1' = x2 + u, x2' = -x1^3; x1 is measured by a sensor that may be off.
#[derive(Clone, Copy)]
struct Spring {
    offset: f64,
}

luenberger::plants::plant!(
    Spring,
    (2, 1, 1),
    |spring, t, x, u| [x[1] + u[0], -x[0].powi(3)],
    [x[0] + convert::<f64, T>(spring.offset)]
);

/// phi = x2, and xi' = -y^3: then x2 = xi + theta with a constant theta.
#[rustfmt::skip]
impl KklMap<f64> for Spring {
    type Xi = U1; type Inputs = U1; type Outputs = U1; type Estimate = U1;
    fn injection(&self, _t: f64, _xi: &V1, _u: &V1, y: &V1) -> V1 { V1::new(-y[0].powi(3)) }
    fn left_inverse(&self, _t: f64, xi: &V1, _y: &V1) -> V1 { *xi }
    fn image(&self, _t: f64, xhat: &V1, _y: &V1) -> V1 { *xhat }
}

/// y' = (xi + u) + 1 theta, filtered on both sides, is a regression without y'.
#[rustfmt::skip]
impl Regression<f64> for Spring {
    type Rows = U1; type Parameters = U1;
    fn signal(&self, _t: f64, y: &V1) -> V1 { *y }
    fn known(&self, _t: f64, xi: &V1, u: &V1, _y: &V1) -> V1 { xi + u }
    fn regressor(&self, _t: f64, _xi: &V1, _u: &V1, _y: &V1) -> Matrix1<f64> { Matrix1::new(1.0) }
    fn missing(&self, theta: &V1) -> V1 { *theta }
}

pub(crate) fn main() -> Result<(), luenberger::Error> {
    for (what, offset) in [("a sensor without offset", 0.0), ("a sensor that is off by 0.01", 0.01)] {
        let observer = PeboObserver::new(Spring { offset }, Gradient::new(Matrix1::new(3.0))?, 10.0)?;
        let run = Scenario::new(Spring { offset })
            .initial_state(&[0.5, 0.3])
            .input(Signal::scalar(|t| 0.1 * t.sin()))
            .partial_observer("pebo", observer, &[-1.0], &[1])
            .until(40.0, 5)
            .run()?;
        let error = &run.observer("pebo")?.error;
        println!("{what}:");
        for (k, t) in run.t.iter().enumerate() {
            println!("  t = {t:2}: x2 - xhat2 = {:+.1e}", error[(k, 0)]);
        }
        // Integrators integrate every offset there is: the estimator has to run after it, and the error stays.
        let late = error.rows(1, 4).amax();
        assert!(if offset == 0.0 { late < 1e-9 } else { late > 1e-3 });
    }
    Ok(())
}
