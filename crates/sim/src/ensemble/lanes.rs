//! DOP853 over lanes: as many integrations at once as there are lanes, each with its own time, step and error control.
//!
//! The operations of a lane are those of [`Dop853`](crate::dop853) in the same order, so that its steps are the same to
//! the last bit, whatever the other lanes do. What is not the same for all lanes (whether a step is accepted, the next
//! step size) is decided lane by lane.

#![allow(clippy::inline_always, reason = "vector instructions are used where the function is inlined only")]

use crate::dop853::{COEFFICIENTS, DEFECT, END, SAMPLES, STAGES, eighth_root, polynomial};
use crate::dop853_tableau::{A, C, DENSE, ERROR5, THIRD};
use crate::step::Tolerance;

/// As many doubles as two or four vector registers have.
pub(super) const LANES: usize = 8;
pub(super) type Lanes = [f64; LANES];

/// The outcome of an attempt in one lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Attempted {
    Rejected,
    Accepted,
}

/// A right-hand side over lanes. It is a trait because a closure is not inlined for sure.
pub(super) trait Field {
    fn slope(&self, t: &Lanes, y: &[Lanes], slope: &mut [Lanes]);
}

/// The state of the integrations, and the memory that attempts work in. All columns have one entry per state.
pub(super) struct Dop853Lanes {
    pub(super) t: Lanes,
    pub(super) h: Lanes,
    pub(super) y: Vec<Lanes>,
    pub(super) slope: Vec<Lanes>,
    rejected: [bool; LANES],
    /// `h lambda` at the end of the last step, not a number if it is not known.
    pub(super) h_lambda: Lanes,
    /// Start and size of the last accepted step, and the coefficients of its interpolant.
    last: [(f64, f64); LANES],
    dense: Vec<[Lanes; COEFFICIENTS]>,
    attempted: Vec<[Lanes; COEFFICIENTS]>,
    slopes: Vec<[Lanes; STAGES]>,
    stage: Vec<Lanes>,
    end: Vec<Lanes>,
    inner: Vec<Lanes>,
    /// Slopes on their way.
    pub(super) received: Vec<Lanes>,
}

#[inline(always)]
fn lanes(of: impl FnMut(usize) -> f64) -> Lanes {
    std::array::from_fn(of)
}

#[inline(always)]
fn combine(columns: &[Lanes; STAGES], weights: &[(usize, f64)]) -> Lanes {
    let mut sum = [0.0; LANES];
    for &(k, weight) in weights {
        let column = &columns[k];
        for lane in 0..LANES {
            sum[lane] += weight * column[lane];
        }
    }
    sum
}

impl Dop853Lanes {
    pub(super) fn new(n: usize) -> Self {
        let column = || vec![[0.0; LANES]; n];
        Self {
            t: [0.0; LANES],
            h: [0.0; LANES],
            y: column(),
            slope: column(),
            rejected: [false; LANES],
            h_lambda: [f64::NAN; LANES],
            last: [(0.0, 1.0); LANES],
            dense: vec![[[0.0; LANES]; COEFFICIENTS]; n],
            attempted: vec![[[0.0; LANES]; COEFFICIENTS]; n],
            slopes: vec![[[0.0; LANES]; STAGES]; n],
            stage: column(),
            end: column(),
            inner: column(),
            received: column(),
        }
    }

    /// Starts a lane anew, at the state and with the slope that it has.
    pub(super) fn restart(&mut self, lane: usize, t: f64, h: f64) {
        (self.t[lane], self.h[lane], self.rejected[lane]) = (t, h, false);
    }

    /// One attempt at a step of the present size in every lane. It allocates nothing.
    #[inline(always)]
    pub(super) fn attempt(&mut self, f: &impl Field, tolerance: Tolerance) -> [Attempted; LANES] {
        let n = self.y.len();
        let (t, h) = (self.t, self.h);
        let scale = |y: f64, end: f64| tolerance.atol + tolerance.rtol * f64::max(y.abs(), end.abs());
        for (slopes, slope) in self.slopes.iter_mut().zip(&self.slope) {
            slopes[0] = *slope;
        }
        let (mut err5, mut err3) = ([0.0; LANES], [0.0; LANES]);
        let (mut apart, mut turn) = ([0.0; LANES], [0.0; LANES]);
        for stage in 1..STAGES {
            if stage == END {
                for ((end, y), slopes) in self.end.iter_mut().zip(&self.y).zip(&self.slopes) {
                    let increment = combine(slopes, A[END]);
                    *end = lanes(|lane| y[lane] + h[lane] * increment[lane]);
                    let (error5, third) = (combine(slopes, ERROR5), combine(slopes, THIRD));
                    for lane in 0..LANES {
                        let scale = scale(y[lane], end[lane]);
                        let (five, three) = (error5[lane] / scale, (increment[lane] - third[lane]) / scale);
                        err5[lane] += five * five;
                        err3[lane] += three * three;
                    }
                }
                // The last stage is nearly the end of the step.
                for (end, stage) in self.end.iter().zip(&self.stage) {
                    for lane in 0..LANES {
                        let difference = end[lane] - stage[lane];
                        apart[lane] += difference * difference;
                    }
                }
                self.stage.copy_from_slice(&self.end);
            } else {
                for ((moved, y), slopes) in self.stage.iter_mut().zip(&self.y).zip(&self.slopes) {
                    let increment = combine(slopes, A[stage]);
                    *moved = lanes(|lane| y[lane] + h[lane] * increment[lane]);
                }
            }
            let node = C[stage];
            f.slope(&lanes(|lane| t[lane] + node * h[lane]), &self.stage, &mut self.received);
            for (slopes, received) in self.slopes.iter_mut().zip(&self.received) {
                slopes[stage] = *received;
            }
            if stage == END {
                for slopes in &self.slopes {
                    for lane in 0..LANES {
                        let difference = slopes[END][lane] - slopes[END - 1][lane];
                        turn[lane] += difference * difference;
                    }
                }
            }
        }
        self.interpolate_attempt();
        let mut squared = [0.0; LANES];
        for s in SAMPLES {
            self.sample(s);
            f.slope(&lanes(|lane| t[lane] + s * h[lane]), &self.stage, &mut self.received);
            let mut sample = [0.0; LANES];
            for i in 0..n {
                let (y, end, inner, wished) = (&self.y[i], &self.end[i], &self.inner[i], &self.received[i]);
                for lane in 0..LANES {
                    let defect = (inner[lane] - h[lane] * wished[lane]) / scale(y[lane], end[lane]);
                    sample[lane] += defect * defect;
                }
            }
            for lane in 0..LANES {
                let is_larger = sample[lane] > squared[lane] || sample[lane].is_nan();
                squared[lane] = if is_larger { sample[lane] } else { squared[lane] };
            }
        }
        let count = n as f64;
        std::array::from_fn(|lane| {
            let blend = err5[lane] + 0.01 * err3[lane];
            let err = if blend > 0.0 { h[lane] * err5[lane] / (blend * count).sqrt() } else { 0.0 * blend };
            let defect = (squared[lane] / count).sqrt() / DEFECT;
            let apart: f64 = f64::sqrt(apart[lane]);
            self.h_lambda[lane] = if apart > 0.0 { h[lane] * f64::sqrt(turn[lane]) / apart } else { f64::NAN };
            self.decide(lane, err, defect)
        })
    }

    /// Accepts or rejects the step of a lane, and sets the size of the next one.
    fn decide(&mut self, lane: usize, err: f64, defect: f64) -> Attempted {
        let factor = |err: f64| 0.9 / eighth_root(err.max(1e-16));
        let h = self.h[lane];
        let is_finite = self.end.iter().all(|end| end[lane].is_finite());
        let reject = if !(err <= 1.0 && is_finite) {
            Some(if err.is_finite() { factor(err).clamp(0.1, 0.9) } else { 0.1 })
        } else if defect.is_nan() || defect > 1.0 {
            Some(if defect.is_finite() { (0.9 / eighth_root(defect)).clamp(0.1, 0.9) } else { 0.1 })
        } else {
            None
        };
        if let Some(factor) = reject {
            self.h[lane] *= factor;
            self.rejected[lane] = true;
            return Attempted::Rejected;
        }
        self.last[lane] = (self.t[lane], h);
        for (i, attempted) in self.attempted.iter().enumerate() {
            for (kept, coefficient) in self.dense[i].iter_mut().zip(attempted) {
                kept[lane] = coefficient[lane];
            }
            self.y[i][lane] = self.end[i][lane];
            self.slope[i][lane] = self.slopes[i][END][lane];
        }
        self.t[lane] += h;
        let growth = if self.rejected[lane] { 1.0 } else { 6.0 };
        self.rejected[lane] = false;
        self.h[lane] = h * factor(err.max(defect)).clamp(1.0 / 3.0, growth);
        Attempted::Accepted
    }

    /// The coefficients of the interpolants.
    #[inline(always)]
    fn interpolate_attempt(&mut self) {
        let h = self.h;
        for i in 0..self.y.len() {
            let (y, end, slopes) = (&self.y[i], &self.end[i], &self.slopes[i]);
            let (first, last) = (&slopes[0], &slopes[END]);
            let moved = lanes(|lane| end[lane] - y[lane]);
            let bend = lanes(|lane| h[lane] * first[lane] - moved[lane]);
            let rest = lanes(|lane| moved[lane] - h[lane] * last[lane] - bend[lane]);
            let mut coefficients = [*y, moved, bend, rest, *y, *y, *y, *y];
            for (coefficient, weights) in coefficients[4..].iter_mut().zip(DENSE) {
                let sum = combine(slopes, weights);
                *coefficient = lanes(|lane| h[lane] * sum[lane]);
            }
            self.attempted[i] = coefficients;
        }
    }

    /// Values (in `stage`) and derivatives of the attempted interpolants at `s` of the step.
    #[inline(always)]
    fn sample(&mut self, s: f64) {
        for (i, coefficients) in self.attempted.iter().enumerate() {
            let (mut value, mut slope) = (coefficients[7], [0.0; LANES]);
            for (j, coefficient) in coefficients[..7].iter().enumerate().rev() {
                let (factor, turn) = if j % 2 == 0 { (s, 1.0) } else { (1.0 - s, -1.0) };
                slope = lanes(|lane| turn * value[lane] + factor * slope[lane]);
                value = lanes(|lane| coefficient[lane] + factor * value[lane]);
            }
            (self.stage[i], self.inner[i]) = (value, slope);
        }
    }

    /// Appends the solution of a lane at a time of its last accepted step.
    pub(super) fn interpolate(&self, lane: usize, t: f64, row: &mut Vec<f64>) {
        let (start, h) = self.last[lane];
        let s = (t - start) / h;
        for coefficients in &self.dense {
            let of_lane: [[f64; 1]; COEFFICIENTS] = std::array::from_fn(|k| [coefficients[k][lane]]);
            row.push(polynomial(&of_lane, s)[0]);
        }
    }
}
