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

/// Entries of a column that are worked on together: every sum has its terms in the same order, one sum per lane.
const LANES: usize = 4;
type Lanes = [f64; LANES];

/// Columns of n entries, one after the other, each filled up with zeros to whole lanes.
struct Columns {
    n: usize,
    lanes: Vec<Lanes>,
}

impl Columns {
    fn new(n: usize, count: usize) -> Self {
        Self { n, lanes: vec![[0.0; LANES]; count * n.div_ceil(LANES)] }
    }

    fn column(&self, k: usize) -> &[Lanes] {
        let length = self.n.div_ceil(LANES);
        &self.lanes[k * length..][..length]
    }

    fn column_mut(&mut self, k: usize) -> &mut [Lanes] {
        let length = self.n.div_ceil(LANES);
        &mut self.lanes[k * length..][..length]
    }

    fn entries(&self, k: usize) -> &[f64] {
        &self.column(k).as_flattened()[..self.n]
    }

    fn entries_mut(&mut self, k: usize) -> &mut [f64] {
        let n = self.n;
        &mut self.column_mut(k).as_flattened_mut()[..n]
    }

    /// `sum_j weight_j column_j` of the lanes `at`, in the order of the list.
    fn combine(&self, weights: &[(usize, f64)], at: usize) -> Lanes {
        let length = self.n.div_ceil(LANES);
        let mut sum = [0.0; LANES];
        for &(k, weight) in weights {
            let column = &self.lanes[k * length + at];
            for (sum, entry) in sum.iter_mut().zip(column) {
                *sum += weight * entry;
            }
        }
        sum
    }
}

/// The state of a DOP853 integration, and the memory that its attempts work in.
pub(crate) struct Dop853 {
    t: f64,
    /// The present state, and the end of the step that is attempted.
    y: Columns,
    end: Columns,
    h: f64,
    slope: Vec<f64>,
    rejected: bool,
    /// Steps at the border of stability, and the steps off it since.
    at_border: usize,
    off_border: usize,
    /// The last accepted step: its start, its size, and the eight coefficients of its interpolant.
    last: Option<(f64, f64)>,
    dense: Columns,
    /// The interpolant of the step that is attempted.
    attempted: Columns,
    slopes: Columns,
    /// A stage.
    stage: Columns,
    /// The derivative of the interpolant in the middle of the step, and that of the plant.
    middle: Columns,
}

/// Square roots are the same on every machine, a general power is not.
fn eighth_root(x: f64) -> f64 {
    x.sqrt().sqrt().sqrt()
}

/// `y + h increment`.
fn advance(y: &Lanes, h: f64, increment: &Lanes) -> Lanes {
    std::array::from_fn(|lane| y[lane] + h * increment[lane])
}

impl Dop853 {
    pub(crate) fn new(t: f64, y: &[f64], slope: &[f64], h: f64) -> Self {
        let n = y.len();
        let mut method = Self {
            t,
            y: Columns::new(n, 1),
            end: Columns::new(n, 1),
            h,
            slope: slope.to_vec(),
            rejected: false,
            at_border: 0,
            off_border: 0,
            last: None,
            dense: Columns::new(n, 8),
            attempted: Columns::new(n, 8),
            slopes: Columns::new(n, STAGES),
            stage: Columns::new(n, 1),
            middle: Columns::new(n, 2),
        };
        method.restart(t, y, slope, h);
        method
    }

    /// Starts anew at another point of the same space.
    pub(crate) fn restart(&mut self, t: f64, y: &[f64], slope: &[f64], h: f64) {
        self.y.entries_mut(0).copy_from_slice(y);
        self.slope.copy_from_slice(slope);
        (self.t, self.h, self.rejected, self.last) = (t, h, false, None);
        (self.at_border, self.off_border) = (0, 0);
    }

    pub(crate) fn t(&self) -> f64 {
        self.t
    }

    pub(crate) fn y(&self) -> &[f64] {
        self.y.entries(0)
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

    /// The slope at stage `stage`, from the slopes before it.
    fn evaluate(&mut self, f: &Rhs<'_>, stage: usize) {
        for (at, (moved, y)) in self.stage.lanes.iter_mut().zip(&self.y.lanes).enumerate() {
            *moved = advance(y, self.h, &self.slopes.combine(A[stage], at));
        }
        f(self.t + C[stage] * self.h, self.stage.entries(0), self.slopes.entries_mut(stage));
    }

    /// One attempt at a step of the present size. It allocates nothing.
    pub(crate) fn attempt(&mut self, f: &Rhs<'_>, tolerance: Tolerance) -> Attempt {
        let n = self.y.n;
        let (t, h) = (self.t, self.h);
        self.slopes.entries_mut(0).copy_from_slice(&self.slope);
        for stage in 1..END {
            self.evaluate(f, stage);
        }
        let scale = |y: f64, end: f64| tolerance.atol + tolerance.rtol * y.abs().max(end.abs());
        let (mut err5, mut err3) = (0.0, 0.0);
        for (at, (end, y)) in self.end.lanes.iter_mut().zip(&self.y.lanes).enumerate() {
            let increment = self.slopes.combine(A[END], at);
            *end = advance(y, h, &increment);
            let (error5, third) = (self.slopes.combine(ERROR5, at), self.slopes.combine(THIRD, at));
            for lane in 0..LANES.min(n - at * LANES) {
                let scale = scale(y[lane], end[lane]);
                err5 += (error5[lane] / scale).powi(2);
                err3 += ((increment[lane] - third[lane]) / scale).powi(2);
            }
        }
        let blend = err5 + 0.01 * err3;
        let err = if blend > 0.0 { h * err5 / (blend * n as f64).sqrt() } else { 0.0 * blend };
        // NaN or infinity: far too long.
        let factor = if err.is_finite() { 0.9 / eighth_root(err.max(1e-16)) } else { 0.1 };
        if !(err <= 1.0 && self.end.entries(0).iter().all(|entry| entry.is_finite())) {
            self.h *= factor.clamp(0.1, 0.9);
            self.rejected = true;
            return Attempt::Rejected;
        }
        f(t + h, self.end.entries(0), self.slopes.entries_mut(END));
        let (slopes, end) = (&self.slopes, self.end.entries(0));
        let h_lambda = slope_ratio(h, (slopes.entries(END), end), (slopes.entries(END - 1), self.stage.entries(0)));
        for stage in END + 1..STAGES {
            self.evaluate(f, stage);
        }
        self.interpolate_attempt();
        f(t + 0.5 * h, self.stage.entries(0), self.middle.entries_mut(1));
        let (inner, wished) = (self.middle.entries(0), self.middle.entries(1));
        let squared = self.y.entries(0).iter().zip(self.end.entries(0)).zip(inner.iter().zip(wished));
        let squared = squared.map(|((y, end), (inner, wished))| ((inner - h * wished) / scale(*y, *end)).powi(2));
        let defect = (squared.sum::<f64>() / n as f64).sqrt() / DEFECT;
        // NaN, from a slope that is not finite, is rejected as well.
        if defect.is_nan() || defect > 1.0 {
            self.h *= if defect.is_finite() { (0.9 / eighth_root(defect)).clamp(0.1, 0.9) } else { 0.1 };
            self.rejected = true;
            return Attempt::Rejected;
        }
        let factor = factor.min(0.9 / eighth_root(defect.max(1e-16)));
        self.last = Some((t, h));
        std::mem::swap(&mut self.dense, &mut self.attempted);
        std::mem::swap(&mut self.y, &mut self.end);
        self.slope.copy_from_slice(self.slopes.entries(END));
        self.t = t + h;
        let growth = if self.rejected { 1.0 } else { 6.0 };
        self.rejected = false;
        self.h = h * factor.clamp(1.0 / 3.0, growth);
        self.watch(h_lambda);
        Attempt::Accepted
    }

    /// The coefficients of the interpolant, its value in the middle (in `stage`) and its derivative there.
    fn interpolate_attempt(&mut self) {
        let h = self.h;
        for at in 0..self.y.lanes.len() {
            let (y, end) = (self.y.lanes[at], self.end.lanes[at]);
            let (first, last) = (self.slopes.column(0)[at], self.slopes.column(END)[at]);
            let moved: Lanes = std::array::from_fn(|lane| end[lane] - y[lane]);
            let bend: Lanes = std::array::from_fn(|lane| h * first[lane] - moved[lane]);
            let rest = std::array::from_fn(|lane| moved[lane] - h * last[lane] - bend[lane]);
            for (k, lanes) in [y, moved, bend, rest].into_iter().enumerate() {
                self.attempted.column_mut(k)[at] = lanes;
            }
            for (k, weights) in DENSE.into_iter().enumerate() {
                self.attempted.column_mut(4 + k)[at] = self.slopes.combine(weights, at).map(|sum| h * sum);
            }
            let (value, slope) = interpolant(&self.attempted, at, 0.5);
            (self.stage.lanes[at], self.middle.column_mut(0)[at]) = (value, slope);
        }
    }

    /// Counts the steps at the border of stability, by the estimate of `h lambda`.
    fn watch(&mut self, h_lambda: Option<f64>) {
        if h_lambda.is_some_and(|estimate| estimate > BORDER) {
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
    pub(crate) fn interpolate(&self, t: f64, value: &mut [f64]) {
        let Some((start, h)) = self.last else { return value.copy_from_slice(self.y()) };
        let s = (t - start) / h;
        for (at, value) in value.chunks_mut(LANES).enumerate() {
            value.copy_from_slice(&interpolant(&self.dense, at, s).0[..value.len()]);
        }
    }
}

/// `h lambda` from two slopes at nearly the same point, if the points differ.
fn slope_ratio(h: f64, (slope, y): (&[f64], &[f64]), (slope_before, y_before): (&[f64], &[f64])) -> Option<f64> {
    let distance = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    let apart = distance(y, y_before);
    (apart > 0.0).then(|| h * distance(slope, slope_before) / apart)
}

/// Lanes `at` of the interpolant at `s` of the step, and their derivative with respect to s:
/// `c0 + s (c1 + r (c2 + s (c3 + r (c4 + s (c5 + r (c6 + s c7))))))`, `r = 1 - s`.
fn interpolant(coefficients: &Columns, at: usize, s: f64) -> (Lanes, Lanes) {
    let (mut value, mut slope) = (coefficients.column(7)[at], [0.0; LANES]);
    for j in (0..7).rev() {
        let (factor, turn) = if j % 2 == 0 { (s, 1.0) } else { (1.0 - s, -1.0) };
        let coefficient = &coefficients.column(j)[at];
        for lane in 0..LANES {
            slope[lane] = turn * value[lane] + factor * slope[lane];
            value[lane] = coefficient[lane] + factor * value[lane];
        }
    }
    (value, slope)
}
