//! DOP853: the explicit Runge-Kutta method of order 8 of Dormand and Prince, with dense output of order 7.
//!
//! Error control by the blend of the estimates of order 5 and 3 that its authors recommend, and by the defect of the
//! dense output: near the border of stability the step may be good to the tolerance and the interpolant a hundred times
//! worse, and trajectories and events are read from the interpolant. The defect is sampled at two points of the step:
//! it is largest near 15/16 for almost every problem, near 5/8 for most of the others, and in the middle it may be a
//! hundredth of that. The error of the interpolant, the integral of the defect, is about a ninth of the largest defect:
//! about two tolerances at the largest of 20 000 random problems. Stiffness is suspected when the step stays at that
//! border for fifteen steps.
//!
//! Source: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., Springer 1993,
//! sections II.5, II.6 (dense output), IV.2 of volume II (stiffness).

use crate::dop853_tableau::{A, C, DENSE, ERROR5, THIRD};
use crate::step::{Attempt, Tolerance};

/// Stages with dense output.
pub(crate) const STAGES: usize = 16;
/// Coefficients of the interpolant.
pub(crate) const COEFFICIENTS: usize = 8;
/// The stage that is the slope at the end of the step.
pub(crate) const END: usize = 12;
/// `h lambda` at the border of stability. The region itself ends at 6.1; the defect holds the step back from 2 on.
pub(crate) const BORDER: f64 = 2.0;
/// So many steps at the border count as stiff.
pub(crate) const STIFF: usize = 15;
/// Where in the step the defect of the dense output is sampled.
pub(crate) const SAMPLES: [f64; 2] = [0.9375, 0.625];
/// The samples that are accepted, in units of the tolerance. Over the whole step the defect was at most twice as large
/// in 20 000 random problems.
pub(crate) const DEFECT: f64 = 8.0;

/// Entries of a column that are worked on together: every sum has its terms in the same order, one sum per lane.
const LANES: usize = 4;
type Lanes = [f64; LANES];

/// Columns of n entries are filled up with zeros to whole lanes.
fn column(n: usize) -> Vec<Lanes> {
    vec![[0.0; LANES]; n.div_ceil(LANES)]
}

/// `sum_j weight_j column_j`, in the order of the list. The lists are constants, so that the loop is unrolled.
#[inline(always)]
#[allow(clippy::inline_always, reason = "the list is a constant only where it is seen")]
fn combine<const COUNT: usize>(columns: &[Lanes; COUNT], weights: &[(usize, f64)]) -> Lanes {
    let mut sum = [0.0; LANES];
    for &(k, weight) in weights {
        for (sum, entry) in sum.iter_mut().zip(&columns[k]) {
            *sum += weight * entry;
        }
    }
    sum
}

/// The state of a DOP853 integration, and the memory that its attempts work in.
pub(crate) struct Dop853 {
    n: usize,
    t: f64,
    h: f64,
    /// The present state, and the end of the step that is attempted.
    y: Vec<Lanes>,
    end: Vec<Lanes>,
    /// The slope at the present state.
    slope: Vec<Lanes>,
    rejected: bool,
    /// Steps at the border of stability, and the steps off it since.
    at_border: usize,
    off_border: usize,
    /// The last accepted step: its start, its size, and the coefficients of its interpolant.
    last: Option<(f64, f64)>,
    dense: Vec<[Lanes; COEFFICIENTS]>,
    /// The interpolant of the step that is attempted.
    attempted: Vec<[Lanes; COEFFICIENTS]>,
    slopes: Vec<[Lanes; STAGES]>,
    /// A stage, and a slope on its way.
    stage: Vec<Lanes>,
    received: Vec<Lanes>,
    /// The derivative of the interpolant where the defect is sampled, and that of the plant.
    inner: Vec<Lanes>,
    derivative: Vec<Lanes>,
}

/// Square roots are the same on every machine, a general power is not.
pub(crate) fn eighth_root(x: f64) -> f64 {
    x.sqrt().sqrt().sqrt()
}

/// `y + h increment`.
#[inline]
fn advance(y: &Lanes, h: f64, increment: &Lanes) -> Lanes {
    std::array::from_fn(|lane| y[lane] + h * increment[lane])
}

impl Dop853 {
    pub(crate) fn new(t: f64, y: &[f64], slope: &[f64], h: f64) -> Self {
        let n = y.len();
        let chunks = n.div_ceil(LANES);
        let mut method = Self {
            n,
            t,
            h,
            y: column(n),
            end: column(n),
            slope: column(n),
            rejected: false,
            at_border: 0,
            off_border: 0,
            last: None,
            dense: vec![[[0.0; LANES]; COEFFICIENTS]; chunks],
            attempted: vec![[[0.0; LANES]; COEFFICIENTS]; chunks],
            slopes: vec![[[0.0; LANES]; STAGES]; chunks],
            stage: column(n),
            received: column(n),
            inner: column(n),
            derivative: column(n),
        };
        method.restart(t, y, slope, h);
        method
    }

    /// Starts anew at another point of the same space.
    pub(crate) fn restart(&mut self, t: f64, y: &[f64], slope: &[f64], h: f64) {
        self.y.as_flattened_mut()[..self.n].copy_from_slice(y);
        self.slope.as_flattened_mut()[..self.n].copy_from_slice(slope);
        (self.t, self.h, self.rejected, self.last) = (t, h, false, None);
        (self.at_border, self.off_border) = (0, 0);
    }

    pub(crate) fn t(&self) -> f64 {
        self.t
    }

    pub(crate) fn y(&self) -> &[f64] {
        &self.y.as_flattened()[..self.n]
    }

    pub(crate) fn h(&self) -> f64 {
        self.h
    }

    pub(crate) fn set_h(&mut self, h: f64) {
        self.h = h;
    }

    /// Whether stability, not accuracy, has decided the last steps.
    pub(crate) fn stiff(&self) -> bool {
        self.at_border >= STIFF
    }

    /// The slope at stage `stage`, from the slopes before it.
    #[inline(always)]
    #[allow(clippy::inline_always, reason = "the coefficients are constants only where the stage is seen")]
    fn evaluate(&mut self, f: &impl Fn(f64, &[f64], &mut [f64]), stage: usize) {
        for ((moved, y), slopes) in self.stage.iter_mut().zip(&self.y).zip(&self.slopes) {
            *moved = advance(y, self.h, &combine(slopes, A[stage]));
        }
        self.slope_of(f, self.t + C[stage] * self.h, stage);
    }

    /// The slope of stage `stage`, at the end of the step or at the stage.
    #[inline]
    fn slope_of(&mut self, f: &impl Fn(f64, &[f64], &mut [f64]), t: f64, stage: usize) {
        let y = &(if stage == END { &self.end } else { &self.stage }).as_flattened()[..self.n];
        if let [slopes] = &mut self.slopes[..] {
            return f(t, y, &mut slopes[stage][..self.n]);
        }
        f(t, y, &mut self.received.as_flattened_mut()[..self.n]);
        for (slopes, received) in self.slopes.iter_mut().zip(&self.received) {
            slopes[stage] = *received;
        }
    }

    /// One attempt at a step of the present size. It allocates nothing.
    pub(crate) fn attempt(&mut self, f: &impl Fn(f64, &[f64], &mut [f64]), tolerance: Tolerance) -> Attempt {
        let n = self.n;
        let (t, h) = (self.t, self.h);
        for (slopes, slope) in self.slopes.iter_mut().zip(&self.slope) {
            slopes[0] = *slope;
        }
        self.evaluate(f, 1);
        self.evaluate(f, 2);
        self.evaluate(f, 3);
        self.evaluate(f, 4);
        self.evaluate(f, 5);
        self.evaluate(f, 6);
        self.evaluate(f, 7);
        self.evaluate(f, 8);
        self.evaluate(f, 9);
        self.evaluate(f, 10);
        self.evaluate(f, 11);
        let scale = |y: f64, end: f64| tolerance.atol + tolerance.rtol * y.abs().max(end.abs());
        let (mut err5, mut err3) = (0.0, 0.0);
        for (at, ((end, y), slopes)) in self.end.iter_mut().zip(&self.y).zip(&self.slopes).enumerate() {
            let increment = combine(slopes, A[END]);
            *end = advance(y, h, &increment);
            let (error5, third) = (combine(slopes, ERROR5), combine(slopes, THIRD));
            for lane in 0..LANES.min(n - at * LANES) {
                let scale = scale(y[lane], end[lane]);
                err5 += (error5[lane] / scale).powi(2);
                err3 += ((increment[lane] - third[lane]) / scale).powi(2);
            }
        }
        let blend = err5 + 0.01 * err3;
        let err = if blend > 0.0 { h * err5 / (blend * n as f64).sqrt() } else { 0.0 * blend };
        let factor = |err: f64| 0.9 / eighth_root(err.max(1e-16));
        if !(err <= 1.0 && self.end.as_flattened().iter().all(|entry| entry.is_finite())) {
            // NaN or infinity: far too long.
            self.h *= if err.is_finite() { factor(err).clamp(0.1, 0.9) } else { 0.1 };
            self.rejected = true;
            return Attempt::Rejected;
        }
        self.slope_of(f, t + h, END);
        let h_lambda = self.slope_ratio();
        self.evaluate(f, 13);
        self.evaluate(f, 14);
        self.evaluate(f, 15);
        self.interpolate_attempt();
        let mut squared: f64 = 0.0;
        for s in SAMPLES {
            let sample = self.squared_defect(f, s, scale);
            // NaN stays.
            squared = if sample > squared || sample.is_nan() { sample } else { squared };
        }
        let defect = (squared / n as f64).sqrt() / DEFECT;
        // NaN, from a slope that is not finite, is rejected as well.
        if defect.is_nan() || defect > 1.0 {
            self.h *= if defect.is_finite() { (0.9 / eighth_root(defect)).clamp(0.1, 0.9) } else { 0.1 };
            self.rejected = true;
            return Attempt::Rejected;
        }
        let factor = factor(err.max(defect));
        self.last = Some((t, h));
        std::mem::swap(&mut self.dense, &mut self.attempted);
        std::mem::swap(&mut self.y, &mut self.end);
        for (slope, slopes) in self.slope.iter_mut().zip(&self.slopes) {
            *slope = slopes[END];
        }
        self.t = t + h;
        let growth = if self.rejected { 1.0 } else { 6.0 };
        self.rejected = false;
        self.h = h * factor.clamp(1.0 / 3.0, growth);
        self.watch(h_lambda);
        Attempt::Accepted
    }

    /// The coefficients of the interpolant.
    fn interpolate_attempt(&mut self) {
        let h = self.h;
        let ends = self.y.iter().zip(&self.end).zip(&self.slopes);
        for (((y, end), slopes), attempted) in ends.zip(&mut self.attempted) {
            let (first, last) = (&slopes[0], &slopes[END]);
            let moved: Lanes = std::array::from_fn(|lane| end[lane] - y[lane]);
            let bend: Lanes = std::array::from_fn(|lane| h * first[lane] - moved[lane]);
            let rest = std::array::from_fn(|lane| moved[lane] - h * last[lane] - bend[lane]);
            let high = |weights: &[(usize, f64)]| combine(slopes, weights).map(|sum| h * sum);
            *attempted = [*y, moved, bend, rest, high(DENSE[0]), high(DENSE[1]), high(DENSE[2]), high(DENSE[3])];
        }
    }

    /// The sum of the squares of the defect of the attempted interpolant at `s` of the step, in units of `scale`.
    #[inline]
    fn squared_defect(&mut self, f: &impl Fn(f64, &[f64], &mut [f64]), s: f64, scale: impl Fn(f64, f64) -> f64) -> f64 {
        let (n, h) = (self.n, self.h);
        for ((attempted, value), slope) in self.attempted.iter().zip(&mut self.stage).zip(&mut self.inner) {
            (*value, *slope) = interpolant(attempted, s);
        }
        f(self.t + s * h, &self.stage.as_flattened()[..n], &mut self.derivative.as_flattened_mut()[..n]);
        let (inner, derivative) = (self.inner.as_flattened(), self.derivative.as_flattened());
        let pairs = self.y.as_flattened().iter().zip(self.end.as_flattened()).zip(inner.iter().zip(derivative)).take(n);
        pairs.map(|((y, end), (inner, derivative))| ((inner - h * derivative) / scale(*y, *end)).powi(2)).sum()
    }

    /// `h lambda` from the slopes at the end of the step and at the stage before it, which are nearly the same point;
    /// `None` if they are.
    fn slope_ratio(&self) -> Option<f64> {
        let (mut apart, mut turn) = (0.0, 0.0);
        let points = self.end.as_flattened().iter().zip(self.stage.as_flattened());
        for (a, b) in points.take(self.n) {
            apart += (a - b).powi(2);
        }
        for (at, slopes) in self.slopes.iter().enumerate() {
            for (a, b) in slopes[END].iter().zip(&slopes[END - 1]).take(self.n - at * LANES) {
                turn += (a - b).powi(2);
            }
        }
        let apart = f64::sqrt(apart);
        (apart > 0.0).then(|| self.h * f64::sqrt(turn) / apart)
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
    #[inline]
    pub(crate) fn interpolate(&self, t: f64, value: &mut [f64]) {
        let Some((start, h)) = self.last else { return value.copy_from_slice(self.y()) };
        let s = (t - start) / h;
        for (coefficients, value) in self.dense.iter().zip(value.chunks_mut(LANES)) {
            // The first point of dense output is the start.
            let lanes = if s == 0.0 { coefficients[0] } else { polynomial(coefficients, s) };
            for (value, lane) in value.iter_mut().zip(lanes) {
                *value = lane;
            }
        }
    }
}

/// The interpolant at `s` of the step:
/// `c0 + s (c1 + r (c2 + s (c3 + r (c4 + s (c5 + r (c6 + s c7))))))`, `r = 1 - s`.
#[inline]
pub(crate) fn polynomial<const L: usize>(coefficients: &[[f64; L]; COEFFICIENTS], s: f64) -> [f64; L] {
    let mut value = coefficients[7];
    for (j, coefficient) in coefficients[..7].iter().enumerate().rev() {
        let factor = if j % 2 == 0 { s } else { 1.0 - s };
        value = std::array::from_fn(|lane| coefficient[lane] + factor * value[lane]);
    }
    value
}

/// The [`polynomial`] and its derivative with respect to s.
fn interpolant(coefficients: &[Lanes; COEFFICIENTS], s: f64) -> (Lanes, Lanes) {
    let (mut value, mut slope) = (coefficients[7], [0.0; LANES]);
    for (j, coefficient) in coefficients[..7].iter().enumerate().rev() {
        let (factor, turn) = if j % 2 == 0 { (s, 1.0) } else { (1.0 - s, -1.0) };
        slope = std::array::from_fn(|lane| turn * value[lane] + factor * slope[lane]);
        value = std::array::from_fn(|lane| coefficient[lane] + factor * value[lane]);
    }
    (value, slope)
}
