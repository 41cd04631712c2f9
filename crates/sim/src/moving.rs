//! A measurement that moves with the model until the next one.
//!
//! w with `w' = dh/dt + Dh(xhat) f(xhat, u)` and `w(t_k) = y_k`: where `xhat = x` it is the output, and held at `y_k`
//! it would be late by half a period on average. It is the error of the period squared that is left. Holding the
//! innovation, `y_k + h(xhat(t)) - h(xhat(t_k))`, is as accurate for slow observers, but is unstable for one whose gain
//! times the period exceeds about 2, and holds y itself where the estimate contains y.
//!
//! Source: I. Karafyllis and C. Kravaris, From continuous-time design to sampled-data design of observers, IEEE
//! Transactions on Automatic Control 54, 2009, eq. (1.3): the error of the observer decays for periods that are short
//! enough.

use crate::erased::AnyPlant;

/// The rates w' of the outputs for which `moves`, at the estimate x; 0 of the others, which need not be defined there.
///
/// It is the central difference of h along f over the share `EPSILON^(1/3)` of the period, where truncation and
/// rounding are alike: an error of w of about `EPSILON^(2/3) |h|`, 4e-11 of it.
pub(crate) fn output_rate(
    plant: &dyn AnyPlant,
    (t, x, u): (f64, &[f64], &[f64]),
    period: f64,
    moves: impl Fn(usize) -> bool,
    rate: &mut [f64],
) {
    let step = difference_step(period);
    let mut f = vec![0.0; x.len()];
    plant.derivative(t, x, u, &mut f);
    let output = |step: f64| {
        let along: Vec<f64> = x.iter().zip(&f).map(|(x, f)| x + step * f).collect();
        let mut h = vec![0.0; rate.len()];
        plant.output(t + step, &along, u, &mut h);
        h
    };
    let (before, after) = (output(-step), output(step));
    for (j, rate) in rate.iter_mut().enumerate() {
        *rate = if moves(j) { (after[j] - before[j]) / (2.0 * step) } else { 0.0 };
    }
}

/// Where truncation and rounding of a central difference are alike.
fn difference_step(period: f64) -> f64 {
    f64::EPSILON.cbrt() * period
}
