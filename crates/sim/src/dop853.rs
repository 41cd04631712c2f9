//! DOP853: the explicit Runge-Kutta method of order 8 of Dormand and Prince, with dense output of order 7.
//!
//! Error control by the blend of the estimates of order 5 and 3 that its authors recommend, and by the defect of the
//! dense output: near the border of stability the step may be good to the tolerance and the interpolant a hundred times
//! worse, and trajectories and events are read from the interpolant. Stiffness is suspected when the step stays at that
//! border for fifteen steps.
//!
//! Source: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., Springer 1993,
//! sections II.5, II.6 (dense output), IV.2 of volume II (stiffness).

use crate::dop853_tableau::{A, C, DENSE, ERROR5, THIRD};
use crate::integrate::{Attempt, Rhs, Tolerance};

/// Stages with dense output.
const STAGES: usize = 16;
/// The stage that is the slope at the end of the step.
const END: usize = 12;
/// `h lambda` at the border of stability. The region itself ends at 6.1; the defect holds the step back from 2 on.
const BORDER: f64 = 2.0;
/// Defect of the dense output that is accepted, in units of the tolerance.
const DEFECT: f64 = 4.0;

/// The state of a DOP853 integration.
pub(crate) struct Dop853 {
    t: f64,
    y: Vec<f64>,
    h: f64,
    slope: Vec<f64>,
    rejected: bool,
    /// Steps at the border of stability, and the steps off it since.
    at_border: usize,
    off_border: usize,
    /// The last accepted step: its start, its size, and the coefficients of its interpolant.
    last: Option<(f64, f64, [Vec<f64>; 8])>,
}

impl Dop853 {
    pub(crate) fn new(t: f64, y: &[f64], slope: &[f64], h: f64) -> Self {
        let (y, slope) = (y.to_vec(), slope.to_vec());
        Self { t, y, h, slope, rejected: false, at_border: 0, off_border: 0, last: None }
    }

    pub(crate) fn t(&self) -> f64 {
        self.t
    }

    pub(crate) fn y(&self) -> &[f64] {
        &self.y
    }

    pub(crate) fn h(&self) -> f64 {
        self.h
    }

    pub(crate) fn set_h(&mut self, h: f64) {
        self.h = h;
    }

    /// Whether stability, not accuracy, has decided the last steps.
    pub(crate) fn stiff(&self) -> bool {
        self.at_border >= 15
    }

    /// One attempt at a step of the present size.
    pub(crate) fn attempt(&mut self, f: &Rhs<'_>, tolerance: Tolerance) -> Attempt {
        let n = self.y.len();
        let (t, h) = (self.t, self.h);
        let mut k = vec![Vec::new(); STAGES];
        k[0].clone_from(&self.slope);
        let combine = |weights: &[(usize, f64)], k: &[Vec<f64>]| {
            let mut sum = vec![0.0; n];
            for &(stage, weight) in weights {
                for (sum, slope) in sum.iter_mut().zip(&k[stage]) {
                    *sum += weight * slope;
                }
            }
            sum
        };
        let advance = |increment: &[f64], y: &[f64]| -> Vec<f64> {
            y.iter().zip(increment).map(|(y, increment)| y + h * increment).collect()
        };
        let eval = |t: f64, y: &[f64]| {
            let mut slope = vec![0.0; n];
            f(t, y, &mut slope);
            slope
        };
        let mut before_end = Vec::new();
        for stage in 1..END {
            let y = advance(&combine(A[stage], &k), &self.y);
            k[stage] = eval(t + C[stage] * h, &y);
            before_end = y;
        }
        let increment = combine(A[END], &k);
        let end = advance(&increment, &self.y);

        let (error5, third) = (combine(ERROR5, &k), combine(THIRD, &k));
        let (mut err5, mut err3) = (0.0, 0.0);
        for i in 0..n {
            let scale = tolerance.atol + tolerance.rtol * self.y[i].abs().max(end[i].abs());
            err5 += (error5[i] / scale).powi(2);
            err3 += ((increment[i] - third[i]) / scale).powi(2);
        }
        let blend = err5 + 0.01 * err3;
        let err = if blend > 0.0 { h * err5 / (blend * n as f64).sqrt() } else { 0.0 * blend };
        // NaN or infinity: far too long.
        let factor = if err.is_finite() { 0.9 * err.max(1e-16).powf(-0.125) } else { 0.1 };
        if !(err <= 1.0 && end.iter().all(|entry| entry.is_finite())) {
            self.h *= factor.clamp(0.1, 0.9);
            self.rejected = true;
            return Attempt::Rejected;
        }
        k[END] = eval(t + h, &end);
        for stage in END + 1..STAGES {
            k[stage] = eval(t + C[stage] * h, &advance(&combine(A[stage], &k), &self.y));
        }
        let mut cont: [Vec<f64>; 8] = std::array::from_fn(|_| vec![0.0; n]);
        for i in 0..n {
            let moved = end[i] - self.y[i];
            let bend = h * k[0][i] - moved;
            cont[0][i] = self.y[i];
            cont[1][i] = moved;
            cont[2][i] = bend;
            cont[3][i] = moved - h * k[END][i] - bend;
        }
        for (target, weights) in cont[4..].iter_mut().zip(DENSE) {
            *target = combine(weights, &k).iter().map(|sum| h * sum).collect();
        }
        let (middle, slope): (Vec<f64>, Vec<f64>) = (0..n).map(|i| interpolant(&cont, i, 0.5)).unzip();
        let wished = eval(t + 0.5 * h, &middle);
        let squared = (0..n).map(|i| {
            let scale = tolerance.atol + tolerance.rtol * self.y[i].abs().max(end[i].abs());
            ((slope[i] - h * wished[i]) / scale).powi(2)
        });
        let defect = (squared.sum::<f64>() / n as f64).sqrt() / DEFECT;
        // NaN, from a slope that is not finite, is rejected as well.
        if defect.is_nan() || defect > 1.0 {
            self.h *= if defect.is_finite() { (0.9 * defect.powf(-0.125)).clamp(0.1, 0.9) } else { 0.1 };
            self.rejected = true;
            return Attempt::Rejected;
        }
        self.watch(h, &k[END], &k[END - 1], &end, &before_end);
        let factor = factor.min(0.9 * defect.max(1e-16).powf(-0.125));
        self.last = Some((t, h, cont));
        self.t = t + h;
        self.y = end;
        self.slope = std::mem::take(&mut k[END]);
        let growth = if self.rejected { 1.0 } else { 6.0 };
        self.rejected = false;
        self.h = h * factor.clamp(1.0 / 3.0, growth);
        Attempt::Accepted
    }

    /// Estimates `h lambda` from two slopes at nearly the same point.
    fn watch(&mut self, h: f64, slope: &[f64], slope_before: &[f64], y: &[f64], y_before: &[f64]) {
        let distance = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        let apart = distance(y, y_before);
        if apart > 0.0 && h * distance(slope, slope_before) / apart > BORDER {
            self.off_border = 0;
            self.at_border += 1;
        } else {
            self.off_border += 1;
            if self.off_border >= 6 {
                self.at_border = 0;
            }
        }
    }

    /// The dense output of the last accepted step.
    pub(crate) fn interpolate(&self, t: f64) -> Vec<f64> {
        let Some((start, h, cont)) = &self.last else { return self.y.clone() };
        let s = (t - start) / h;
        (0..self.y.len()).map(|i| interpolant(cont, i, s).0).collect()
    }
}

/// Component `i` of the interpolant at `s` of the step, and its derivative with respect to s:
/// `c0 + s (c1 + r (c2 + s (c3 + r (c4 + s (c5 + r (c6 + s c7))))))`, `r = 1 - s`.
fn interpolant(cont: &[Vec<f64>; 8], i: usize, s: f64) -> (f64, f64) {
    (0..7).rev().fold((cont[7][i], 0.0), |(value, slope), j| {
        let (factor, turn) = if j % 2 == 0 { (s, 1.0) } else { (1.0 - s, -1.0) };
        (cont[j][i] + factor * value, turn * value + factor * slope)
    })
}
