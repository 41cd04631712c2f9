//! A KKL observer with a phi found by hand: the equation that phi has to solve is proved on a box, and a slip of the
//! hand is refuted.

use luenberger::design::kkl::KklSettings;
use luenberger::prelude::*;
use nalgebra::{Matrix1, RealField, U1, Vector1, convert};

/// A concentration x1 feeds a temperature x2, which is measured: x1' = -x1 + u + x2^2, x2' = x1 - x2.
#[derive(Clone, Copy)]
struct Tank;

luenberger::plants::plant!(Tank, (2, 1, 1), |tank, t, x, u| [u[0] + x[1] * x[1] - x[0], x[0] - x[1]], [x[1]]);

/// phi = x1: xi' = Lambda xi + u + y^2, and the estimate of x1 is xi itself. Lambda has to be -1.
#[derive(Clone, Copy, Debug)]
struct Concentration {
    lambda: f64,
}

#[rustfmt::skip]
impl<T: RealField + Copy> KklMap<T> for Concentration {
    type Xi = U1; type Inputs = U1; type Outputs = U1; type Estimate = U1;
    fn lambda(&self, _t: T, _u: &Vector1<T>, _y: &Vector1<T>) -> Matrix1<T> { Matrix1::new(convert(self.lambda)) }
    fn injection(&self, _t: T, _xi: &Vector1<T>, u: &Vector1<T>, y: &Vector1<T>) -> Vector1<T> { Vector1::new(u[0] + y[0] * y[0]) }
    fn left_inverse(&self, _t: T, xi: &Vector1<T>, _y: &Vector1<T>) -> Vector1<T> { *xi }
    fn image(&self, _t: T, xhat: &Vector1<T>, _y: &Vector1<T>) -> Vector1<T> { *xhat }
}

pub(crate) fn main() -> Result<(), luenberger::Error> {
    let region = Region::new(&[(0.0, 1.0), (0.0, 1.0)]).inputs(&[(-1.0, 1.0)]);
    let settings = KklSettings::default();
    let design = KklDesign::new(&Tank, Concentration { lambda: -1.0 }, &[0], &region, &settings)?;
    println!("{}", design.report);
    let refused = KklDesign::new(&Tank, Concentration { lambda: -2.0 }, &[0], &region, &settings);
    println!("a slip of the hand, Lambda = -2: {}", refused.expect_err("phi does not solve its equation"));

    let run = Scenario::new(Tank)
        .initial_state(&[0.5, 0.2])
        .input(Signal::scalar(|t| 0.1 * t.cos()))
        .partial_observer("kkl", design.observer, &[0.0], &[0])
        .until(8.0, 5)
        .run()?;
    let error = &run.observer("kkl")?.error;
    for (k, t) in run.t.iter().enumerate() {
        println!("t = {t}: x1 - xhat1 = {:.3e}, and exp(-t)/2 = {:.3e}", error[(k, 0)], (-t).exp() / 2.0);
    }
    // e' = -e, whatever plant and input do. The tolerance of the integrator is 1e-8 or better.
    assert!((error[(4, 0)] - 0.5 * (-8f64).exp()).abs() < 1e-7);
    Ok(())
}
