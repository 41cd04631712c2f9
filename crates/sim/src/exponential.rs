//! Intervals on which the stacked equation is linear with constant inputs, `s' = F s + g`: its solution is the series
//! of the exponential, and nothing is integrated.
//!
//! `s(t + sigma h) = sum_k c_k sigma^k` with `c_0 = s(t)`, `c_1 = h (F s(t) + g)`, `c_(k+1) = h F c_k/(k + 1)`. With
//! `|F| h <= 2` the series ends at rounding after at most 28 terms; it is as much work as to apply stored exponentials
//! for the eight points of dense output, and serves intervals of any length.
//!
//! The ends of steps are exact to rounding. Dense output keeps polynomials of degree 7 at eight Chebyshev points; they
//! are off by `sum_(k >= 8) binomial(k, 8) 2^-14 |c_k|` at most, the remainder of interpolation, and steps are so short
//! that this is within the tolerances.

use crate::error::SimError;
use crate::integrate::Settings;
use crate::step::{Accepted, Interpolant, Tolerance};

/// `(|F| h)^k/k!` that counts as nothing.
const NOTHING: f64 = 1e-19;
/// Largest `|F| h`: cancellation in the series loses a digit there.
const REACH: f64 = 2.0;
/// Largest number of steps of that length in an interval; a longer one is integrated.
const STEPS: f64 = 16.0;
/// Entries that are evaluated together.
const LANES: usize = 4;
/// The degree from which on powers are not kept by dense output.
const KEPT: usize = 8;

/// binomial(k, 8) from k = 8 on, as far as a series goes.
const BINOMIALS: [f64; 24] = {
    let mut binomials = [1.0; 24];
    let mut k = 1;
    while k < 24 {
        binomials[k] = binomials[k - 1] * (k + KEPT) as f64 / k as f64;
        k += 1;
    }
    binomials
};

/// The series of a step.
pub(crate) struct Series {
    start: f64,
    h: f64,
    n: usize,
    /// The coefficients, one after the other.
    coefficients: Vec<f64>,
}

impl Interpolant for Series {
    fn interpolate(&self, t: f64, value: &mut [f64]) {
        let sigma = (t - self.start) / self.h;
        for (at, value) in value.chunks_mut(LANES).enumerate() {
            let mut lanes = [0.0; LANES];
            for coefficient in self.coefficients.chunks_exact(self.n).rev() {
                let of_chunk = &coefficient[at * LANES..][..value.len()];
                if let Ok(all) = <&[f64; LANES]>::try_from(of_chunk) {
                    lanes = std::array::from_fn(|lane| all[lane] + sigma * lanes[lane]);
                } else {
                    for (lane, coefficient) in lanes.iter_mut().zip(of_chunk) {
                        *lane = coefficient + sigma * *lane;
                    }
                }
            }
            value.copy_from_slice(&lanes[..value.len()]);
        }
    }
}

impl Series {
    /// What the polynomials of dense output are off by at most, in units of the tolerances at the ends of the step.
    fn remainder(&self, start: &[f64], end: &[f64], tolerance: Tolerance) -> f64 {
        let mut off = 0.0;
        for (i, (start, end)) in start.iter().zip(end).enumerate() {
            let powers = self.coefficients.chunks_exact(self.n).skip(KEPT).zip(&BINOMIALS);
            let sum: f64 = powers.map(|(coefficient, binomial)| binomial * coefficient[i].abs()).sum();
            let scale = tolerance.atol + tolerance.rtol * start.abs().max(end.abs());
            off += (sum * 2f64.powi(-14) / scale).powi(2);
        }
        (off / self.n as f64).sqrt()
    }
}

/// `s' = F s + g`, with the memory of its steps.
pub(crate) struct Exponential {
    /// F by rows.
    f: Vec<f64>,
    /// `|F|`, the largest sum of magnitudes of a row.
    norm: f64,
    /// The size of the next step by the tolerances.
    h: f64,
    g: Vec<f64>,
    series: Series,
}

impl Exponential {
    /// Of the affine right-hand side `derivative(s, slope)`, its inputs being zero.
    pub(crate) fn new(n: usize, mut derivative: impl FnMut(&[f64], &mut [f64])) -> Option<Self> {
        let (mut s, mut offset, mut column) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        derivative(&s, &mut offset);
        let mut f = vec![0.0; n * n];
        for j in 0..n {
            s[j] = 1.0;
            derivative(&s, &mut column);
            s[j] = 0.0;
            for i in 0..n {
                f[i * n + j] = column[i] - offset[i];
            }
        }
        let norm = f.chunks_exact(n.max(1)).map(|row| row.iter().map(|entry| entry.abs()).sum()).fold(0.0, f64::max);
        let series = Series { start: 0.0, h: 1.0, n, coefficients: Vec::new() };
        (n > 0 && norm.is_finite()).then_some(Self { f, norm, h: f64::INFINITY, g: offset, series })
    }

    /// From `s` at `start` to `end`, under the inputs that `derivative` has now, leaving the result in `s`; `on_step`
    /// sees every step. Returns the number of steps; `None`, and nothing is done, if the interval is to be integrated.
    pub(crate) fn advance(
        &mut self,
        settings: &Settings,
        (start, end): (f64, f64),
        s: &mut [f64],
        mut derivative: impl FnMut(&[f64], &mut [f64]),
        on_step: &mut impl FnMut(&Accepted<'_>) -> Result<(), SimError>,
    ) -> Option<Result<usize, SimError>> {
        let most = (REACH / self.norm).min(settings.max_step);
        if (end - start) / most > STEPS || settings.check_time(start).is_err() {
            return None;
        }
        let before = s.to_vec();
        s.fill(0.0);
        derivative(s, &mut self.g);
        s.copy_from_slice(&before);
        // What is not finite is for the integrator to name.
        if !self.g.iter().all(|entry| entry.is_finite()) {
            return None;
        }
        let (mut t, mut steps) = (start, 0);
        while t < end {
            let parts = ((end - t) / self.h.min(most)).ceil().max(1.0);
            let to = if parts > 1.0 { t + (end - t) / parts } else { end };
            self.expand(t, to - t, s);
            steps += 1;
            let before = s.to_vec();
            self.series.interpolate(to, s);
            let largest = s.iter().fold(0.0, |largest: f64, entry| largest.max(entry.abs()));
            if largest > 1e100 || !s.iter().all(|entry| entry.is_finite()) {
                return Some(Err(SimError::BlowUp { time: t, norm: largest }));
            }
            let error = self.series.remainder(&before, s, settings.tolerance());
            // Square roots are the same on every machine, a general power is not.
            let factor = 0.9 / error.max(1e-16).sqrt().sqrt().sqrt();
            self.h = (to - t) * factor.clamp(0.1, 4.0);
            // Steps at the spacing of floating-point numbers are taken as they are.
            if error > 1.0 && to - t > 1e-9 * most {
                s.copy_from_slice(&before);
                continue;
            }
            if let Err(error) = on_step(&Accepted { start: t, end: to, solution: &self.series }) {
                return Some(Err(error));
            }
            t = to;
        }
        Some(Ok(steps))
    }

    /// The series at `start`, from s.
    fn expand(&mut self, start: f64, h: f64, s: &[f64]) {
        let n = self.series.n;
        (self.series.start, self.series.h) = (start, h);
        let coefficients = &mut self.series.coefficients;
        coefficients.clear();
        coefficients.extend_from_slice(s);
        let (theta, mut size) = (self.norm * h, 1.0);
        let mut k = 0;
        while size > NOTHING {
            k += 1;
            size *= theta / f64::from(k);
            let factor = h / f64::from(k);
            let last = coefficients.len() - n;
            for i in 0..n {
                let row = &self.f[i * n..][..n];
                let mut sum = if k == 1 { self.g[i] } else { 0.0 };
                for (f, entry) in row.iter().zip(&coefficients[last..last + n]) {
                    sum += f * entry;
                }
                coefficients.push(factor * sum);
            }
        }
    }
}
