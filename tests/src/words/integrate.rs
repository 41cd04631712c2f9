//! An integrator that shares nothing with `luenberger-sim`: Dormand and Prince's pair of orders 5 and 4, and where its
//! steps are limited by stability, the linearly implicit Euler method with extrapolation (Hairer and Wanner, *Solving
//! Ordinary Differential Equations II*, IV.9).

use nalgebra::DMatrix;

use super::linear::abscissa;

/// Why a trajectory ends early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stop {
    /// The right-hand side has no finite value.
    Undefined,
    /// Too many evaluations, or no step is short enough.
    Slow,
}

/// The right-hand side: dy for t and y, and whether it is defined.
pub(super) type Motion<'a> = dyn FnMut(f64, &[f64], &mut [f64]) -> bool + 'a;

/// What an integration keeps from one interval to the next.
#[derive(Debug, Clone)]
pub(super) struct Integrator {
    /// The relative tolerance of a step.
    pub(super) tolerance: f64,
    /// Below this an entry is 0, relative to the largest it had.
    pub(super) least: f64,
    /// The largest magnitude of each entry so far.
    largest: Vec<f64>,
    step: f64,
    is_stiff: bool,
    /// Evaluations that are left.
    budget: usize,
}

/// Steps of the explicit method in an interval beyond which it is taken to be stiff.
const MOST_EXPLICIT: usize = 300;

/// Columns of the extrapolation table.
const COLUMNS: usize = 7;

const NODES: [f64; 7] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
const STAGES: [[f64; 6]; 7] = [
    [0.0; 6],
    [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
const DIFFERENCE: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];

impl Integrator {
    pub(super) fn new(tolerance: f64, budget: usize) -> Self {
        Self { tolerance, least: 1e-6, largest: Vec::new(), step: 0.0, is_stiff: false, budget }
    }

    /// From `from` to `to`, in place.
    ///
    /// # Errors
    /// [`Stop`].
    pub(super) fn advance(&mut self, motion: &mut Motion<'_>, from: f64, to: f64, y: &mut [f64]) -> Result<(), Stop> {
        self.largest.resize(y.len(), 0.0);
        let mut t = from;
        let span = to - from;
        let mut count = 0;
        let mut first = vec![0.0; y.len()];
        self.call(motion, t, y, &mut first)?;
        if self.step <= 0.0 {
            let rate = first.iter().zip(y.iter()).map(|(d, y)| d.abs() / (y.abs() + f64::MIN_POSITIVE.sqrt()));
            self.step = 0.01 / rate.fold(1.0 / span, f64::max);
        }
        while t < to {
            let least = 1e-13 * span.max(t.abs() * 1e-2);
            let h = self.step.max(least).min(to - t);
            let is_last = h >= to - t;
            let (next, error, order) = if self.is_stiff {
                self.implicit(motion, t, h, y, &first)?
            } else {
                let (next, error) = self.explicit(motion, t, h, y, &first)?;
                (next, error, 5.0)
            };
            count += 1;
            let factor = if error > 0.0 { 0.9 * error.powf(-1.0 / order) } else { 4.0 };
            let accepted = error <= 1.0;
            if !accepted && h <= least {
                return Err(Stop::Slow);
            }
            if accepted {
                t = if is_last { to } else { t + h };
                y.copy_from_slice(&next);
                self.call(motion, t, y, &mut first)?;
            }
            if !(is_last && accepted) || factor < 1.0 {
                self.step = h * if factor.is_finite() { factor.clamp(0.1, 4.0) } else { 0.1 };
            }
            if !self.is_stiff && count > MOST_EXPLICIT {
                self.is_stiff = true;
                self.step = (0.01 * (to - t)).max(h);
            }
        }
        Ok(())
    }

    fn call(&mut self, motion: &mut Motion<'_>, t: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Stop> {
        if self.budget == 0 {
            return Err(Stop::Slow);
        }
        self.budget -= 1;
        for (most, y) in self.largest.iter_mut().zip(y) {
            *most = most.max(y.abs());
        }
        if motion(t, y, dy) && dy.iter().all(|d| d.is_finite()) { Ok(()) } else { Err(Stop::Undefined) }
    }

    /// The error of a step in units of the tolerance.
    fn measure(&self, y: &[f64], next: &[f64], error: &[f64]) -> f64 {
        let one = |k: usize| {
            let size = y[k].abs().max(next[k].abs()).max(self.least * self.largest[k]);
            if error[k] == 0.0 { 0.0 } else { error[k].abs() / (self.tolerance * size + f64::MIN_POSITIVE) }
        };
        // Not a number is as bad as can be.
        (0..y.len()).map(one).fold(0.0, |most: f64, x| if x.is_finite() { most.max(x) } else { f64::INFINITY })
    }

    fn explicit(
        &mut self,
        motion: &mut Motion<'_>,
        t: f64,
        h: f64,
        y: &[f64],
        first: &[f64],
    ) -> Result<(Vec<f64>, f64), Stop> {
        let n = y.len();
        let mut slopes = vec![vec![0.0; n]; 7];
        slopes[0].copy_from_slice(first);
        let mut at = y.to_vec();
        for stage in 1..7 {
            for k in 0..n {
                at[k] = y[k] + h * (0..stage).map(|j| STAGES[stage][j] * slopes[j][k]).sum::<f64>();
            }
            let (_, rest) = slopes.split_at_mut(stage);
            match self.call(motion, t + NODES[stage] * h, &at, &mut rest[0]) {
                // A stage outside of the domain: a shorter step may stay in it.
                Err(Stop::Undefined) if h > 1e-9 * t.abs().max(h) && stage < 6 => return Ok((at, 1e10)),
                result => result?,
            }
        }
        let error: Vec<f64> = (0..n).map(|k| h * (0..7).map(|j| DIFFERENCE[j] * slopes[j][k]).sum::<f64>()).collect();
        let measured = self.measure(y, &at, &error);
        Ok((at, measured))
    }

    fn implicit(
        &mut self,
        motion: &mut Motion<'_>,
        t: f64,
        h: f64,
        y: &[f64],
        first: &[f64],
    ) -> Result<(Vec<f64>, f64, f64), Stop> {
        let n = y.len();
        let mut jacobian = vec![0.0; n * n];
        let (mut moved, mut slope) = (y.to_vec(), vec![0.0; n]);
        for j in 0..n {
            let delta = 1e-7 * y[j].abs().max(self.least * self.largest[j]).max(1e-300);
            moved[j] = y[j] + delta;
            let delta = moved[j] - y[j];
            self.call(motion, t, &moved, &mut slope)?;
            moved[j] = y[j];
            for i in 0..n {
                jacobian[i * n + j] = (slope[i] - first[i]) / delta;
            }
        }
        // A step over many time constants of what grows would damp it.
        let growth = abscissa(&DMatrix::from_row_slice(n, n, &jacobian));
        if growth * h > 0.5 {
            return Ok((y.to_vec(), 1e10, 2.0));
        }
        let mut table: Vec<Vec<f64>> = Vec::new();
        let (mut best, mut measured) = (y.to_vec(), 1e10);
        for j in 0..COLUMNS {
            let parts = j + 1;
            let step = h / parts as f64;
            let matrix: Vec<f64> =
                (0..n * n).map(|k| f64::from(u8::from(k / n == k % n)) - step * jacobian[k]).collect();
            let Some(factored) = Factored::new(matrix, n) else { return Ok((best, 1e10, 2.0)) };
            let mut at = y.to_vec();
            for part in 1..=parts {
                self.call(motion, t + part as f64 * step, &at, &mut slope)?;
                let mut change: Vec<f64> = slope.iter().map(|d| d * step).collect();
                factored.solve(&mut change);
                at.iter_mut().zip(&change).for_each(|(y, d)| *y += d);
            }
            let mut row = vec![at];
            for k in 0..j {
                let ratio = parts as f64 / (j - k) as f64 - 1.0;
                let next =
                    row[k].iter().zip(&table_entry(&table, j - 1, k)).map(|(a, b)| a + (a - b) / ratio).collect();
                row.push(next);
            }
            if j > 1 {
                let error: Vec<f64> = row[j].iter().zip(&row[j - 1]).map(|(a, b)| a - b).collect();
                measured = self.measure(y, &row[j], &error);
                best.clone_from(&row[j]);
                if measured <= 0.5 {
                    return Ok((best, measured, j as f64 + 1.0));
                }
            }
            keep(&mut table, row);
        }
        Ok((best, measured, COLUMNS as f64))
    }
}

/// The entry of the extrapolation table in this row and column: rows are stored one behind the other.
fn table_entry(table: &[Vec<f64>], row: usize, column: usize) -> Vec<f64> {
    table[row * (row + 1) / 2 + column].clone()
}

fn keep(table: &mut Vec<Vec<f64>>, row: Vec<Vec<f64>>) {
    table.extend(row);
}

/// LU factors with partial pivoting.
struct Factored {
    lu: Vec<f64>,
    order: Vec<usize>,
    n: usize,
}

impl Factored {
    fn new(mut lu: Vec<f64>, n: usize) -> Option<Self> {
        let mut order: Vec<usize> = (0..n).collect();
        for k in 0..n {
            let pivot = (k..n).max_by(|a, b| lu[a * n + k].abs().total_cmp(&lu[b * n + k].abs()))?;
            if !(lu[pivot * n + k].abs() > 0.0 && lu[pivot * n + k].is_finite()) {
                return None;
            }
            if pivot != k {
                for j in 0..n {
                    lu.swap(k * n + j, pivot * n + j);
                }
                order.swap(k, pivot);
            }
            for i in k + 1..n {
                lu[i * n + k] /= lu[k * n + k];
                let factor = lu[i * n + k];
                for j in k + 1..n {
                    lu[i * n + j] -= factor * lu[k * n + j];
                }
            }
        }
        Some(Self { lu, order, n })
    }

    fn solve(&self, b: &mut [f64]) {
        let n = self.n;
        let mut x: Vec<f64> = self.order.iter().map(|k| b[*k]).collect();
        for i in 0..n {
            for j in 0..i {
                x[i] -= self.lu[i * n + j] * x[j];
            }
        }
        for i in (0..n).rev() {
            for j in i + 1..n {
                x[i] -= self.lu[i * n + j] * x[j];
            }
            x[i] /= self.lu[i * n + i];
        }
        b.copy_from_slice(&x);
    }
}
