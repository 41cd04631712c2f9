//! The Kalman filter as the opponent of the cubic observer of least cost. Our addition: the paper compares with a
//! linear observer of the same L.
//!
//! A first error of known covariance P0 is Kalman's problem: with one measurement of deviation sigma per period h, the
//! time-varying filter that starts at P0 has the least mean of `e'Te` at every time among all estimators of Gaussian
//! data. Its covariance is propagated exactly, and with it the cost `J = int_0^tau trace(T P) dt` of the section on the
//! cubic observer of least cost in `docs/theory-cubic.md`. It does not expect later pushes, unless a process noise w
//! stands for them.

use std::sync::Arc;

use luenberger_design::{EstimationProblem, OptimalCubicDesign};
use luenberger_plants::double_integrator;
use nalgebra::{Matrix2, Vector2};

use crate::claim::{CheckError, Claim, Class, Outcome};
use crate::context::Context;
use crate::evidence::Evidence;
use crate::value::{Value, short};

/// The problems of the table in `docs/cubic-or-linear.md`: first errors, deviation and period of the noise.
const PROBLEMS: [([f64; 2], f64, f64); 5] = [
    ([1.0, 1.0], 0.01, 0.01),
    ([1.0, 1.0], 0.1, 0.01),
    ([1.0, 1.0], 0.5, 0.05),
    ([0.1, 1.0], 0.1, 0.01),
    ([0.01, 1.0], 0.01, 0.01),
];
const HORIZON: f64 = 20.0;
/// Intensities of the process noise tried as what the filter expects of pushes of the velocity.
const EXPECTED: [f64; 8] = [0.0, 1e-4, 1e-3, 1e-2, 0.1, 0.5, 1.0, 3.0];

const PLANT: &str = "the double integrator, y its position, errors in units of the first error; 20 s of operation, Gaussian noise held for a period";

pub(super) fn claims() -> Vec<Claim> {
    vec![
        Claim::holds(
            Class::Ours,
            "cubic.kalman.first-error",
            "beyond the paper: the cubic observer of least cost",
            "for a first error of known covariance the time-varying Kalman filter with P0 costs less than half of the cubic and of the linear optimum (costs J of five problems: filter, then the better of the two)",
            &[
                PLANT,
                "(first errors, noise): (1, 1), 0.01; (1, 1), 0.1; (1, 1), 0.5 held for 50 ms; (0.1, 1), 0.1; (0.01, 1), 0.01",
            ],
            first_error,
        ),
        Claim::holds(
            Class::Ours,
            "cubic.kalman.push",
            "beyond the paper: the cubic observer of least cost",
            "after a push at 10 s that nobody expects the optimal cubic observer costs less than the linear optimum and than the filter, whatever process noise that has (costs of the last 10 s: cubic, linear, best filter, filter without process noise)",
            &[
                PLANT,
                "noise 0.1; the first error and the push are of the size (1, 1)",
                "process noise of the velocity from 0 to 3, in eight steps",
            ],
            push,
        ),
    ]
}

/// The cost of a filter from the first error to the end, and over the second half of the time, with or without a push
/// of the size of the first error in the middle.
fn filter([d1, d2]: [f64; 2], sigma: f64, period: f64, w: f64, pushed: bool) -> [f64; 2] {
    let start = Matrix2::from_diagonal(&Vector2::new(d1 * d1, d2 * d2)) * 0.5;
    let weight = Vector2::new(1.0 / (d1 * d1), 1.0 / (d2 * d2));
    let flow = |t: f64| Matrix2::new(1.0, t, 0.0, 1.0);
    let step = flow(period);
    let (h, variance) = (period, sigma * sigma);
    let process = Matrix2::new(h * h * h / 3.0, h * h / 2.0, h * h / 2.0, h) * w;
    // What the filter believes of its error, and the covariance of its error.
    let (mut believed, mut actual) = (start, start);
    let periods = (HORIZON / period).round() as usize;
    let (mut whole, mut late) = (0.0, 0.0);
    for k in 0..periods {
        if pushed && k == periods / 2 {
            actual += start;
        }
        let gain = believed.column(0) / (believed[(0, 0)] + variance);
        let kept = Matrix2::new(1.0 - gain[0], 0.0, -gain[1], 1.0);
        believed = kept * believed;
        actual = kept * actual * kept.transpose() + gain * gain.transpose() * variance;
        // trace(T F(t) X F(t)') is a polynomial of degree 2 in t: Simpson's rule is exact.
        let at = |t: f64| {
            let x = flow(t) * actual * flow(t).transpose();
            weight[0] * x[(0, 0)] + weight[1] * x[(1, 1)]
        };
        let cost = h / 6.0 * (at(0.0) + 4.0 * at(h / 2.0) + at(h));
        whole += cost;
        if k >= periods / 2 {
            late += cost;
        }
        believed = step * believed * step.transpose() + process;
        actual = step * actual * step.transpose();
    }
    [whole, late]
}

fn optima(context: &Context) -> Result<Arc<Vec<OptimalCubicDesign>>, CheckError> {
    context.once("cubic.kalman", || {
        let plant = double_integrator().to_dynamic();
        PROBLEMS
            .iter()
            .map(|(d, sigma, period)| {
                Ok(OptimalCubicDesign::new(&plant, &EstimationProblem::new(d, &[*sigma], *period, HORIZON), None)?)
            })
            .collect()
    })
}

fn first_error(context: &Context) -> Result<Outcome, CheckError> {
    let optima = optima(context)?;
    let filters: Vec<f64> = PROBLEMS.iter().map(|(d, sigma, h)| filter(*d, *sigma, *h, 0.0, false)[0]).collect();
    let others: Vec<f64> = optima.iter().map(|optimum| optimum.cost.total).collect();
    let ratios: Vec<f64> = filters.iter().zip(&others).map(|(filter, other)| other / filter).collect();
    let linear: Vec<f64> = optima.iter().map(|optimum| optimum.linear_cost.total).collect();
    Ok(Outcome::new(Evidence::holds_by(ratios.iter().all(|ratio| *ratio > 2.0), [filters, others].concat())).note(format!(
        "The optimum of the search costs {} times as much as the filter; the linear optima cost {}. The filter knows what the search knows: P0, the noise and its period. It is not steady, and has two more \
         numbers to keep for each pair of states.",
        Value::from(ratios),
        Value::from(linear)
    )))
}

fn push(context: &Context) -> Result<Outcome, CheckError> {
    let (d, sigma, period) = PROBLEMS[1];
    let optimum = &optima(context)?[1];
    let half = HORIZON / 2.0;
    let cubic = optimum.cost.transient + half * optimum.cost.mean_square;
    let linear = optimum.linear_cost.transient + half * optimum.linear_cost.mean_square;
    let filters: Vec<f64> = EXPECTED.iter().map(|w| filter(d, sigma, period, *w, true)[1]).collect();
    let first: Vec<f64> = EXPECTED.iter().map(|w| filter(d, sigma, period, *w, false)[0]).collect();
    let best = (0..EXPECTED.len()).min_by(|&a, &b| filters[a].total_cmp(&filters[b])).unwrap_or(0);
    let holds = cubic < linear && linear < filters[best] && optimum.cubic.is_some();
    Ok(Outcome::new(Evidence::holds_by(holds, [cubic, linear, filters[best], filters[0]])).note(format!(
        "Without process noise the gain of the filter is small by then, and it does not see the push. Of w = {} the best for the push is {}, with which the first error costs {} (without w it costs {}). A \
         filter whose covariance is set back to P0 where an innovation is too large for its variance would do as well as at the start, at the price of a test.",
        Value::from(EXPECTED),
        short(EXPECTED[best]),
        short(first[best]),
        short(first[0])
    )))
}
