//! A high-gain observer: fast as one likes, at the price of peaking and of noise.

use luenberger::observers::high_gain::ChainPosition;
use luenberger::prelude::*;
use nalgebra::{U1, U2, Vector1, Vector2};

type V1 = Vector1<f64>;

/// A cart in air: x1' = x2, x2' = u - x2|x2|; the position is measured.
#[derive(Clone, Copy, Debug)]
struct Cart;

luenberger::plants::plant!(Cart, (2, 1, 1), |cart, t, x, u| [x[1], u[0] - x[1] * x[1].abs()], [x[0]]);

/// One chain of two integrators, which is the cart itself.
#[rustfmt::skip]
impl HighGainMap<f64> for Cart {
    type Xi = U2; type Inputs = U1; type Outputs = U1; type Estimate = U2;
    fn place(&self, i: usize) -> ChainPosition { ChainPosition { output: 0, position: i + 1 } }
    fn drift(&self, t: f64, xi: &Vector2<f64>, u: &V1, _y: &V1) -> Vector2<f64> { self.derivative(t, xi, u) }
    fn estimate(&self, _t: f64, xi: &Vector2<f64>, _u: &V1, _y: &V1) -> Vector2<f64> { *xi }
    fn start(&self, _t: f64, estimate: &Vector2<f64>, _u: &V1, _y: &V1) -> Vector2<f64> { *estimate }
}

pub(crate) fn main() -> Result<(), luenberger::Error> {
    println!("s^2 + 2 s + 1 speeded up by 1/r; the position is 1 off at the start, then noise of 1 mm\n");
    println!("{:>6} {:>12} {:>12} {:>18}", "r", "settled at", "peak of e2", "rms e2, 5 <= t <= 10");
    let mut noisy = Vec::new();
    for r in [0.5, 0.1, 0.02] {
        let observer = HighGainObserver::new(Cart, Vector2::new(2.0, 1.0), r)?;
        let scenario = || Scenario::new(Cart).initial_state(&[1.0, 0.5]).input(Signal::scalar(f64::cos));
        let clean = scenario().observer("o", observer.clone(), &[0.0, 0.0]).until(10.0, 2).run()?;
        let error = clean.error_trace("o", 1)?;
        let settled = metrics::settling_last(&error, 0.05).map_or("-".to_owned(), |t| format!("{t:.3}"));
        let noise = Noise::gaussian(&[1e-3], 1e-3, 1);
        let run = scenario().noise(noise).observer("o", observer, &[0.0, 0.0]).until(10.0, 1001).run()?;
        let late = run.observer("o")?.error.view((500, 1), (501, 1)).norm() / 501f64.sqrt();
        println!("{r:>6} {settled:>12} {:>12.2} {late:>18.2e}", metrics::peak(&error)?.value.abs());
        noisy.push(late);
    }
    assert!(noisy[2] > 3.0 * noisy[1] && noisy[1] > 3.0 * noisy[0]);
    Ok(())
}
