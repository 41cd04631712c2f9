//! A plant of Proposition 7's class, checked along a run, and observed: x' = -x + k u, where the gain k drifts with x.

use luenberger::design::kkl_peb::{Excite, KklPebDesign, SampledRun};
use luenberger::observers::{KklPebObserver, cascade::Cascade, estimator::gradient::Gradient};
use luenberger::prelude::*;
use nalgebra::{Matrix1, SMatrix, SVector, U0, U1, Vector1, convert};

#[derive(Clone, Copy)]
struct Drifting;
type V0 = SVector<f64, 0>;
type M0 = SMatrix<f64, 0, 0>;
type V1 = Vector1<f64>;

luenberger::plants::plant!(
    Drifting,
    (2, 1, 1),
    |plant, t, x, u| [-x[0] + x[1] * u[0], convert::<f64, T>(-0.1) * x[0]],
    [x[0]]
);

#[rustfmt::skip]
impl Cascade<f64> for Drifting {
    type Second = U0; type Third = U0; type Fourth = U1; type Inputs = U1; type Outputs = U1;
    fn a2(&self) -> M0 { M0::zeros() }
    fn a3(&self) -> M0 { M0::zeros() }
    fn k(&self) -> usize { 0 }
    fn f1k(&self, y: &V1, _: &V0, _: &V0, _: &V1) -> f64 { -y[0] }
    fn f2(&self, _: &V1, _: &V1) -> V0 { V0::zeros() }
    fn f3(&self, _: &V1, _: &V0, _: &V1) -> V0 { V0::zeros() }
    fn f4(&self, y: &V1, _: &V0, _: &V0, _: &V1) -> V1 { y * -0.1 }
    fn b(&self, _: &V1, _: &V0, _: &V0, u: &V1) -> V1 { *u }
}

pub(crate) fn main() -> Result<(), luenberger::Error> {
    let scenario = || Scenario::new(Drifting).initial_state(&[0.0, 2.0]).input(Signal::function(|t, u| u[0] = t.sin()));
    let run = scenario().until(20.0, 2001).run()?;
    let (samples, excite) = (SampledRun::new(&run.t, &run.x, &run.u)?, Excite::within(std::f64::consts::PI));
    let gradient = Gradient::new(Matrix1::new(5.0))?;
    let design =
        KklPebDesign::new(&Drifting, Drifting, &samples, &excite, |map| KklPebObserver::new(map, gradient, 5.0))?;
    let run = scenario().partial_observer("[KKL+PEB]O", &design.observer, &[0.0], &[1]).until(20.0, 5).run()?;
    println!("{}k - khat = {:.4}", design.report, run.observer("[KKL+PEB]O")?.error.transpose());
    Ok(())
}
