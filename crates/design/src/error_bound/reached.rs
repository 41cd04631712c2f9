//! What disturbances reach under a linear error system at one rate, in closed form: the head of `mod.rs`.

use luenberger_proof::statement::TimeDomain;
use nalgebra::{DMatrix, DVectorView};

use crate::lyapunov_choice::Solver;

/// `(F + rate I)Z + Z(F + rate I)' + Q = 0`, or `(F/q)Z(F/q)' - Z + Q = 0` with `q = exp(-rate)`.
pub(super) fn equation(time: TimeDomain, f: &DMatrix<f64>, rate: f64) -> Option<Solver> {
    let slower = match time {
        TimeDomain::Continuous => f + DMatrix::identity(f.nrows(), f.nrows()) * rate,
        TimeDomain::Discrete => f / (-rate).exp(),
    };
    Solver::new(time, &slower.transpose())
}

/// What the disturbances may add to V, in parts of U: `2 rate`, or `1 - q^2`.
pub(super) fn spent(time: TimeDomain, rate: f64) -> f64 {
    match time {
        TimeDomain::Continuous => 2.0 * rate,
        TimeDomain::Discrete => -(-2.0 * rate).exp_m1(),
    }
}

/// The matrices `Z_i` at one rate.
pub(super) struct Reached {
    pub(super) parts: Vec<DMatrix<f64>>,
    spent: f64,
}

impl Reached {
    pub(super) fn new(time: TimeDomain, f: &DMatrix<f64>, g: &DMatrix<f64>, rate: f64) -> Option<Self> {
        let mut equation = equation(time, f, rate)?;
        let mut part = |g: DVectorView<'_, f64>| equation.solve(&(g * g.transpose()));
        let parts = g.column_iter().map(&mut part).collect::<Option<_>>()?;
        Some(Self { parts, spent: spent(time, rate) })
    }

    /// The bound of a component if nothing but it counts.
    pub(super) fn component(&self, k: usize) -> f64 {
        let sum: f64 = self.parts.iter().map(|part| part[(k, k)].max(0.0).sqrt()).sum();
        sum / self.spent.sqrt()
    }

    /// The d of the least weighted sum of squares, and that sum. The columns of G include the bounds: all W are 1.
    pub(super) fn combined(&self, weights: &[f64]) -> (Vec<f64>, f64) {
        let cost =
            |part: &DMatrix<f64>| weights.iter().enumerate().map(|(k, w)| w * part[(k, k)].max(0.0)).sum::<f64>();
        let roots: Vec<f64> = self.parts.iter().map(|part| cost(part).sqrt()).collect();
        let total: f64 = roots.iter().sum();
        // A disturbance without effect is given the multiplier of a small one.
        let d = roots.iter().map(|root| total / (self.spent * root.max(1e-9 * total))).collect();
        (d, total * total / self.spent)
    }
}

/// The least value of a function on an interval by golden section, for a function with one minimum.
pub(super) fn golden(mut low: f64, mut high: f64, steps: usize, mut f: impl FnMut(f64) -> f64) -> f64 {
    let ratio = (5.0_f64.sqrt() - 1.0) / 2.0;
    let (mut a, mut b) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut at_a, mut at_b) = (f(a), f(b));
    for _ in 0..steps {
        if at_a <= at_b {
            (high, b, at_b) = (b, a, at_a);
            a = high - ratio * (high - low);
            at_a = f(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + ratio * (high - low);
            at_b = f(b);
        }
    }
    if at_a <= at_b { a } else { b }
}
