//! The error `e' = F e + w - L v + (r'theta r) N r`, `r = C e + v`, integrated by Runge and Kutta's method with steps
//! as short as the cubic term is stiff, without allocation.

// At the optimisation of tests, adapters of iterators are calls: here they take as long as the arithmetic.
#![allow(clippy::needless_range_loop)]

use nalgebra::DMatrix;

/// Rates times steps: the error of a step of the fourth order is about their fifth power over 120.
const STEP: f64 = 0.25;
/// Longest integration of a first error.
const MOST_STEPS: usize = 40_000;
/// Longest integration of a period of the noise.
const MOST_SUBSTEPS: f64 = 100.0;

/// A cubic observer in the units of the problem.
pub(super) struct Gains {
    pub(super) l: DMatrix<f64>,
    pub(super) n: DMatrix<f64>,
    pub(super) theta: DMatrix<f64>,
}

pub(super) struct ErrorFlow {
    n: usize,
    p: usize,
    f: Vec<f64>,
    c: Vec<f64>,
    l: Vec<f64>,
    gain: Vec<f64>,
    theta: Vec<f64>,
    weight: Vec<f64>,
    /// The largest modulus of an eigenvalue of F.
    fastest: f64,
    /// `|C N|`.
    output_gain: f64,
}

/// Columns that a step needs.
pub(super) struct Work {
    r: Vec<f64>,
    theta_r: Vec<f64>,
    forcing: Vec<f64>,
    v: Vec<f64>,
    at: Vec<f64>,
    slopes: [Vec<f64>; 4],
}

impl Work {
    pub(super) fn new(n: usize, p: usize) -> Self {
        let column = |length| vec![0.0; length];
        Self {
            r: column(p),
            theta_r: column(p),
            forcing: column(n),
            v: column(p),
            at: column(n),
            slopes: [column(n), column(n), column(n), column(n)],
        }
    }
}

/// Row by row.
fn rows(m: &DMatrix<f64>) -> Vec<f64> {
    m.transpose().as_slice().to_vec()
}

#[inline]
fn row_times(m: &[f64], i: usize, x: &[f64]) -> f64 {
    let row = &m[i * x.len()..(i + 1) * x.len()];
    let mut sum = 0.0;
    for k in 0..x.len() {
        sum += row[k] * x[k];
    }
    sum
}

impl ErrorFlow {
    pub(super) fn new(f: &DMatrix<f64>, c: &DMatrix<f64>, gains: &Gains, weight: &DMatrix<f64>, fastest: f64) -> Self {
        Self {
            n: f.nrows(),
            p: c.nrows(),
            f: rows(f),
            c: rows(c),
            l: rows(&gains.l),
            gain: rows(&gains.n),
            theta: rows(&gains.theta),
            weight: rows(weight),
            fastest,
            output_gain: (c * &gains.n).norm(),
        }
    }

    /// `e'Te`.
    pub(super) fn square(&self, e: &[f64]) -> f64 {
        let mut sum = 0.0;
        for i in 0..self.n {
            sum += e[i] * row_times(&self.weight, i, e);
        }
        sum
    }

    /// r and theta r; returns `r'theta r`.
    fn residual(&self, e: &[f64], work: &mut Work) -> f64 {
        for i in 0..self.p {
            work.r[i] = row_times(&self.c, i, e) + work.v[i];
        }
        let mut q = 0.0;
        for i in 0..self.p {
            let value = row_times(&self.theta, i, &work.r);
            work.theta_r[i] = value;
            q += value * work.r[i];
        }
        q
    }

    /// A bound of the eigenvalues of the Jacobian of the cubic term.
    fn stiffness(&self, e: &[f64], work: &mut Work) -> f64 {
        let q = self.residual(e, work);
        let (mut length, mut weighted) = (0.0, 0.0);
        for i in 0..self.p {
            length += work.r[i] * work.r[i];
            weighted += work.theta_r[i] * work.theta_r[i];
        }
        self.output_gain * (q + 2.0 * (length * weighted).sqrt())
    }

    fn slope(&self, stage: usize, work: &mut Work) {
        let at = core::mem::take(&mut work.at);
        let q = self.residual(&at, work);
        for i in 0..self.n {
            work.slopes[stage][i] =
                row_times(&self.f, i, &at) + work.forcing[i] + q * row_times(&self.gain, i, &work.r);
        }
        work.at = at;
    }

    /// A step of length h; with `cost`, the integral of `e'Te` over it is added there.
    fn step(&self, e: &mut [f64], h: f64, cost: Option<&mut f64>, work: &mut Work) {
        let mut sum = 0.0;
        for stage in 0..4 {
            let (share, weight) = [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)][stage];
            let before = stage.saturating_sub(1);
            for i in 0..self.n {
                work.at[i] = if stage == 0 { e[i] } else { e[i] + share * h * work.slopes[before][i] };
            }
            if cost.is_some() {
                sum += weight * self.square(&work.at);
            }
            self.slope(stage, work);
        }
        if let Some(cost) = cost {
            *cost += sum * h / 6.0;
        }
        let [a, b, c, d] = &work.slopes;
        for i in 0..self.n {
            e[i] += h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
        }
    }

    /// `int_0^inf e'Te dt` from a first error, without noise. Where the cubic term is a thousandth of the slowest mode,
    /// the rest is that of the linear observer, `e'Me`.
    pub(super) fn transient(&self, first: &[f64], slowest: f64, tail: &DMatrix<f64>, work: &mut Work) -> Option<f64> {
        work.forcing.fill(0.0);
        work.v.fill(0.0);
        let mut e = first.to_vec();
        let mut sum = 0.0;
        for _ in 0..MOST_STEPS {
            let stiffness = self.stiffness(&e, work);
            if stiffness <= 1e-3 * slowest {
                let rest: f64 = (0..self.n).map(|i| e[i] * (0..self.n).map(|j| tail[(i, j)] * e[j]).sum::<f64>()).sum();
                return (sum + rest).is_finite().then_some(sum + rest);
            }
            self.step(&mut e, STEP / (self.fastest + stiffness), Some(&mut sum), work);
        }
        None
    }

    /// The error after a period with noise that is held.
    pub(super) fn held(&self, e: &mut [f64], w: &[f64], v: &[f64], period: f64, work: &mut Work) -> Option<()> {
        work.v.copy_from_slice(v);
        for (i, (forcing, w)) in work.forcing.iter_mut().zip(w).enumerate() {
            *forcing = w - row_times(&self.l, i, v);
        }
        let stiffness = self.stiffness(e, work);
        let steps = (period * (self.fastest + stiffness) / (2.0 * STEP)).ceil().max(1.0);
        if steps.is_nan() || steps > MOST_SUBSTEPS {
            return None;
        }
        for _ in 0..steps as usize {
            self.step(e, period / steps, None, work);
        }
        Some(())
    }
}
