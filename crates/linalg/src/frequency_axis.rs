//! The frequencies of a plant in continuous or in discrete time, in radians per unit of time, and what is computed over
//! them: responses, margins, norms. The rest of the crate has the angles of discrete time, in radians per sample.

use nalgebra::Complex;
use std::f64::consts::PI;

use crate::{
    FrequencyResponse, HInfinityNorm, LoopMargins, Realization, Result, discrete_h_infinity_norm, h_infinity_norm,
};

/// The axis of frequencies w: `s = jw` in continuous time, `z = e^{jwh}` for the sampling period h.
///
/// ```
/// use luenberger_linalg::{FrequencyAxis, Realization};
/// use nalgebra::dmatrix;
/// // 1/(z - 1) with the period 0.1: a loop that is -1/2 at the angle pi.
/// let open = Realization::new(&dmatrix![1.0], &dmatrix![1.0], &dmatrix![1.0], &dmatrix![0.0])?;
/// let margin = FrequencyAxis::new(Some(0.1)).margins(&open)?.channels[0].gain_margin().ok_or("a margin")?;
/// assert!((margin.factor - 2.0).abs() < 1e-12 && (margin.frequency - 31.41592653589793).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrequencyAxis {
    period: Option<f64>,
}

impl FrequencyAxis {
    /// That of discrete time with this period, positive; of continuous time without.
    pub fn new(period: Option<f64>) -> Self {
        Self { period }
    }

    /// The unit of angles: 1 in continuous time.
    fn unit(self) -> f64 {
        self.period.unwrap_or(1.0)
    }

    /// `w h`, the angle of z in radians; w itself in continuous time.
    pub fn angle(self, w: f64) -> f64 {
        w * self.unit()
    }

    /// The frequency of an angle, or of a frequency of continuous time.
    pub fn frequency(self, angle: f64) -> f64 {
        angle / self.unit()
    }

    /// The largest frequency: `pi/h`, infinite in continuous time.
    pub fn highest(self) -> f64 {
        self.period.map_or(f64::INFINITY, |h| PI / h)
    }

    /// Whether w is on the axis, where `pi/h` may be written with fifteen digits, the last rounded up.
    pub fn contains(self, w: f64) -> bool {
        w >= 0.0 && w <= self.highest() * (1.0 + 1e-14)
    }

    /// The response of a plant at these frequencies.
    ///
    /// # Errors
    /// Those of [`FrequencyResponse::continuous`].
    pub fn response(self, plant: &Realization) -> Result<FrequencyResponse> {
        match self.period {
            None => FrequencyResponse::continuous(plant),
            Some(_) => FrequencyResponse::discrete(plant),
        }
    }

    /// The margins of a loop, with frequencies and delays in units of time.
    ///
    /// # Errors
    /// Those of [`LoopMargins::continuous`].
    pub fn margins(self, open: &Realization) -> Result<LoopMargins> {
        let mut found = match self.period {
            None => LoopMargins::continuous(open)?,
            Some(_) => LoopMargins::discrete(open)?,
        };
        for channel in &mut found.channels {
            for one in &mut channel.gain {
                one.frequency = self.frequency(one.frequency);
            }
            for one in &mut channel.phase {
                (one.frequency, one.delay) = (self.frequency(one.frequency), one.delay * self.unit());
            }
            channel.sensitivity = channel.sensitivity.map(|peak| self.peak(peak));
        }
        found.sensitivity = found.sensitivity.map(|peak| self.peak(peak));
        found.complementary = found.complementary.map(|peak| self.peak(peak));
        Ok(found)
    }

    /// The H-infinity norm, with its frequency in radians per unit of time.
    ///
    /// # Errors
    /// Those of [`h_infinity_norm`] and [`discrete_h_infinity_norm`].
    pub fn h_infinity_norm(self, system: &Realization) -> Result<HInfinityNorm> {
        let Realization { a, b, c, d } = system;
        Ok(self.peak(match self.period {
            None => h_infinity_norm(a, b, c, d)?,
            Some(_) => discrete_h_infinity_norm(a, b, c, d)?,
        }))
    }

    fn peak(self, found: HInfinityNorm) -> HInfinityNorm {
        HInfinityNorm { frequency: self.frequency(found.frequency), ..found }
    }

    /// Frequencies, equally spaced in their logarithm, that show a response with these poles and zeros, each of them s
    /// or z.
    ///
    /// Where an end of the range is not given, it is a decade below the slowest or above the fastest of them, those at
    /// 0 left out; in discrete time the last one is `pi/h`. `points` is two or more. Beside them stand the frequencies
    /// of lightly damped poles and zeros, at which peaks are.
    pub fn grid(self, features: &[Complex<f64>], range: [Option<f64>; 2], points: usize) -> Vec<f64> {
        let range = range.map(|w| w.map(|w| self.angle(w)));
        let grid = match self.period {
            None => of_continuous_time(features, range, points),
            Some(_) => of_discrete_time(features, range, points),
        };
        grid.into_iter().map(|angle| self.frequency(angle)).collect()
    }
}

fn of_continuous_time(features: &[Complex<f64>], range: [Option<f64>; 2], points: usize) -> Vec<f64> {
    let (from, to) = around(features).map_or((0.1, 10.0), |(slowest, fastest)| (0.1 * slowest, 10.0 * fastest));
    let (from, to) = match range {
        [Some(first), Some(last)] => (first, last),
        [Some(first), None] => (first, to.max(100.0 * first)),
        [None, Some(last)] => (from.min(0.01 * last), last),
        [None, None] => (from, to),
    };
    spaced(from, to, points, features)
}

fn of_discrete_time(features: &[Complex<f64>], range: [Option<f64>; 2], points: usize) -> Vec<f64> {
    // A pole of discrete time is one of continuous time by its logarithm, at most pi from the axis.
    let features: Vec<Complex<f64>> = features.iter().filter(|z| z.norm() > 0.0).map(|z| z.ln()).collect();
    let slowest = around(&features).map_or(0.1, |(slowest, _)| slowest);
    let (from, to) = match range {
        [Some(first), Some(last)] => (first, last),
        [Some(first), None] => (first, PI),
        [None, last] => ((0.1 * slowest).min(0.01 * last.unwrap_or(10.0)), last.unwrap_or(PI)),
    };
    spaced(from, to, points, &features)
}

/// The slowest and the fastest, those at 0 left out.
fn around(features: &[Complex<f64>]) -> Option<(f64, f64)> {
    let fastest = features.iter().map(|s| s.norm()).fold(0.0, f64::max);
    // What is nearer to 0 is there but for rounding.
    let moving = features.iter().map(|s| s.norm()).filter(|size| *size > 1e-9 * fastest);
    let slowest = moving.fold(f64::INFINITY, f64::min);
    slowest.is_finite().then_some((slowest, fastest))
}

fn spaced(from: f64, to: f64, points: usize, features: &[Complex<f64>]) -> Vec<f64> {
    let steps = points.max(2) - 1;
    let ratio = to / from;
    let mut all: Vec<f64> = (0..steps).map(|k| from * ratio.powf(k as f64 / steps as f64)).collect();
    all.push(to);
    let peaks = features.iter().filter(|s| s.re.abs() < 0.5 * s.im.abs()).map(|s| s.im.abs());
    all.extend(peaks.filter(|w| *w > from && *w < to));
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}
