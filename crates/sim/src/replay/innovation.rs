//! Statistics of the innovations `y - h(xhat)` of an observer: their size, whether they are white, whether they have
//! the covariance that a filter computes (NIS); and, where the truth is known, whether its errors have the covariance
//! it says (NEES).
//!
//! Where plant, noise and filter agree, the innovations of a Kalman filter are white, of mean 0, and of the covariance
//! S that the filter computes. An observer with a constant gain has white innovations only by luck; their spectrum then
//! still says what is left in the data: a mean is a bias of a sensor or of the model, a slow autocorrelation is
//! dynamics that the model does not have.
//!
//! Sources: G. M. Ljung and G. E. P. Box, On a measure of lack of fit in time series models, Biometrika 65, 1978; Y.
//! Bar-Shalom, X. R. Li and T. Kirubarajan, Estimation with Applications to Tracking and Navigation, Wiley 2001,
//! section 5.4.

use crate::chi_squared::{quantile, tail};

/// Statistics of the innovation of one output.
#[derive(Clone, Debug, PartialEq)]
pub struct InnovationStatistics {
    /// How many innovations were used; 0 for an output that was not measured, whose other numbers are 0 too.
    pub samples: usize,
    /// Their mean.
    pub mean: f64,
    /// Their root mean square.
    pub rms: f64,
    /// The largest magnitude.
    pub peak: f64,
    /// Whether they are white; none for fewer than 20 samples, and for innovations that do not vary.
    pub whiteness: Option<Whiteness>,
}

/// The test of Ljung and Box that a sequence is white.
#[derive(Clone, Debug, PartialEq)]
pub struct Whiteness {
    /// The autocorrelation at the lags 1, 2, ..., counted in samples: an even number of them, at most 20 and a tenth of
    /// the samples.
    pub autocorrelation: Vec<f64>,
    /// Of a white sequence, 95 % of the autocorrelations are below it: `1.96/sqrt(N)`.
    pub bound: f64,
    /// `Q = N (N + 2) sum r_k^2/(N - k)`.
    pub statistic: f64,
    /// Probability of a Q at least as large for a white sequence; below 0.05 whiteness is rejected.
    pub p_value: f64,
}

/// A square `e' S^-1 e`, and how many entries e has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalisedSquare {
    /// The square.
    pub square: f64,
    /// The degrees of freedom: the outputs that were measured (NIS), or the states whose truth is known (NEES).
    pub degrees: usize,
}

/// Whether the innovations of a filter, or its errors, have the covariance that it computes: the test of NIS or NEES.
#[derive(Clone, Debug, PartialEq)]
pub struct Consistency {
    /// The mean of the normalised squares, `nu' S^-1 nu` for NIS and `e' P^-1 e` for NEES. Above the region, the filter
    /// is overconfident; below, conservative.
    pub mean: f64,
    /// Its expected value for a consistent filter: the mean number of degrees of freedom per sample.
    pub expected: f64,
    /// The acceptance region, two-sided, 95 %: for a consistent filter the sum of the squares is chi-squared with as
    /// many degrees as all samples have, and the mean lies in here with a probability of 95 %. Exact for NIS and a
    /// linear plant; errors of successive samples are correlated, so that NEES leaves its region more often.
    pub bounds: (f64, f64),
    /// How many samples were used.
    pub samples: usize,
}

impl Consistency {
    /// The test of these squares; none for none of them.
    ///
    /// ```
    /// use luenberger_sim::replay::{Consistency, NormalisedSquare};
    /// let squares = (0..100).map(|k| NormalisedSquare { square: if k % 2 == 0 { 1.9 } else { 0.1 }, degrees: 1 });
    /// let test = Consistency::of(squares).ok_or("squares")?;
    /// // A hundredth of the quantiles of chi-squared with 100 degrees: 74.22 and 129.56.
    /// assert!((test.mean - 1.0).abs() < 1e-12 && (test.bounds.0 - 0.7422).abs() < 1e-4 && test.accepted());
    /// # Ok::<(), &str>(())
    /// ```
    pub fn of(squares: impl IntoIterator<Item = NormalisedSquare>) -> Option<Self> {
        let (mut samples, mut sum, mut degrees) = (0usize, 0.0, 0usize);
        for NormalisedSquare { square, degrees: own } in squares {
            (samples, sum, degrees) = (samples + 1, sum + square, degrees + own);
        }
        if degrees == 0 {
            return None;
        }
        let (count, degrees) = (samples as f64, degrees as f64);
        let bounds = (quantile(0.025, degrees) / count, quantile(0.975, degrees) / count);
        Some(Self { mean: sum / count, expected: degrees / count, bounds, samples })
    }

    /// Whether the mean lies in the acceptance region.
    pub fn accepted(&self) -> bool {
        (self.bounds.0..=self.bounds.1).contains(&self.mean)
    }
}

/// The longest lag.
const LAGS: usize = 20;

impl InnovationStatistics {
    /// The statistics of a sequence of finite numbers.
    pub fn of(innovations: &[f64]) -> Self {
        let count = innovations.len().max(1) as f64;
        let mean = innovations.iter().sum::<f64>() / count;
        let rms = (innovations.iter().map(|nu| nu * nu).sum::<f64>() / count).sqrt();
        let peak = innovations.iter().fold(0.0f64, |peak, nu| peak.max(nu.abs()));
        Self { samples: innovations.len(), mean, rms, peak, whiteness: whiteness(innovations, mean, rms) }
    }
}

fn whiteness(innovations: &[f64], mean: f64, rms: f64) -> Option<Whiteness> {
    let (length, count) = (innovations.len(), innovations.len() as f64);
    let lags = LAGS.min(length / 10) & !1;
    let about: Vec<f64> = innovations.iter().map(|nu| nu - mean).collect();
    let power = about.iter().map(|nu| nu * nu).sum::<f64>();
    // What is left of a constant is the rounding of its mean.
    if lags == 0 || power <= count * (count * f64::EPSILON * rms).powi(2) {
        return None;
    }
    let correlation = |lag: usize| about.iter().zip(&about[lag..]).map(|(a, b)| a * b).sum::<f64>() / power;
    let autocorrelation: Vec<f64> = (1..=lags).map(correlation).collect();
    let weighted = autocorrelation.iter().enumerate().map(|(k, r)| r * r / (count - (k + 1) as f64));
    let statistic = count * (count + 2.0) * weighted.sum::<f64>();
    Some(Whiteness { autocorrelation, bound: 1.96 / count.sqrt(), statistic, p_value: tail(statistic, lags as f64) })
}
