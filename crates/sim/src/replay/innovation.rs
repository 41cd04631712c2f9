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

use nalgebra::{DMatrix, DVector};

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

/// A square `e' P^+ e`, with the pseudo-inverse of the covariance P, and its degrees of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalisedSquare {
    /// The square.
    pub square: f64,
    /// The degrees of freedom: the rank of P.
    pub degrees: usize,
    /// How many entries e has: the outputs that were measured (NIS), or the states whose truth is known (NEES).
    pub entries: usize,
    /// Whether e has a component in the null space of P: the filter takes it for exact, and it is not.
    pub is_outside: bool,
}

impl NormalisedSquare {
    /// The square of an innovation with so many entries; its covariance S has full rank.
    pub fn of_innovation(square: f64, entries: usize) -> Self {
        Self { square, degrees: entries, entries, is_outside: false }
    }

    /// The square of the error e by its covariance P, in units of the standard deviations `sqrt(P_ii)`; none if one of
    /// them is not finite.
    ///
    /// The rank counts the eigenvalues of the correlation matrix above `sqrt(EPSILON)`: the covariance of a filter is a
    /// difference, and has lost half of its digits before a smaller eigenvalue means anything. A component of e in the
    /// null space is one if it exceeds what this threshold leaves of it, five standard deviations of
    /// `EPSILON^(1/4)` each; for a state of variance zero, if it exceeds `sqrt(EPSILON)` of the magnitude `x`.
    ///
    /// ```
    /// use luenberger_sim::replay::NormalisedSquare;
    /// use nalgebra::{DMatrix, DVector};
    /// // Two states of variance 4 and correlation 1: the error (2, 2) is one standard deviation of one degree.
    /// let p = DMatrix::from_element(2, 2, 4.0);
    /// let both = NormalisedSquare::of_error(&DVector::from_element(2, 2.0), &p, &DVector::zeros(2)).ok_or("finite")?;
    /// assert!((both.square - 1.0).abs() < 1e-12 && both.degrees == 1 && !both.is_outside);
    /// let apart = DVector::from_vec(vec![2.0, -2.0]);
    /// assert!(NormalisedSquare::of_error(&apart, &p, &DVector::zeros(2)).ok_or("finite")?.is_outside);
    /// # Ok::<(), &str>(())
    /// ```
    pub fn of_error(e: &DVector<f64>, p: &DMatrix<f64>, x: &DVector<f64>) -> Option<Self> {
        if !(e.iter().all(|e| e.is_finite()) && p.iter().all(|p| p.is_finite())) {
            return None;
        }
        let threshold = f64::EPSILON.sqrt();
        let known: Vec<usize> = (0..e.len()).filter(|&i| p[(i, i)] > 0.0).collect();
        let mut is_outside = (0..e.len()).any(|i| p[(i, i)] <= 0.0 && e[i].abs() > threshold * x[i].abs());
        let deviation: Vec<f64> = known.iter().map(|&i| p[(i, i)].sqrt()).collect();
        let correlation =
            DMatrix::from_fn(known.len(), known.len(), |i, j| p[(known[i], known[j])] / (deviation[i] * deviation[j]));
        let scaled = DVector::from_fn(known.len(), |i, _| e[known[i]] / deviation[i]);
        let (mut square, mut degrees) = (0.0, 0);
        if !known.is_empty() {
            let eigen = correlation.symmetric_eigen();
            let components = eigen.eigenvectors.tr_mul(&scaled);
            for (value, component) in eigen.eigenvalues.iter().zip(&components) {
                if *value > threshold {
                    square += component * component / value;
                    degrees += 1;
                } else {
                    is_outside |= component.abs() > 5.0 * threshold.sqrt();
                }
            }
        }
        Some(Self { square, degrees, entries: e.len(), is_outside })
    }
}

/// Whether the innovations of a filter, or its errors, have the covariance that it computes: the test of NIS or NEES.
#[derive(Clone, Debug, PartialEq)]
pub struct Consistency {
    /// The mean of the normalised squares, `nu' S^-1 nu` for NIS and `e' P^+ e` for NEES; 0 without samples. Above the
    /// region, the filter is overconfident; below, conservative.
    pub mean: f64,
    /// Its expected value for a consistent filter: the mean number of degrees of freedom per sample.
    pub expected: f64,
    /// The acceptance region, two-sided, 95 %: for a consistent filter the sum of the squares is chi-squared with as
    /// many degrees as all samples have, and the mean lies in here with a probability of 95 %. Exact for NIS and a
    /// linear plant; errors of successive samples are correlated, so that NEES leaves its region more often.
    pub bounds: (f64, f64),
    /// How many samples were used: those with a degree of freedom.
    pub samples: usize,
    /// In how many samples, used or not, the covariance is singular: it has fewer degrees of freedom than entries.
    pub singular: usize,
    /// In how many of these the error has a component without variance, so that no square measures it.
    pub outside: usize,
    /// How many samples have no square: the covariance is not finite, or the update had no result.
    pub left_out: usize,
}

impl Consistency {
    /// The test of these squares, `None` for a sample without one; none if there is no sample.
    ///
    /// ```
    /// use luenberger_sim::replay::{Consistency, NormalisedSquare};
    /// let square = |k| NormalisedSquare::of_innovation(if k % 2 == 0 { 1.9 } else { 0.1 }, 1);
    /// let test = Consistency::of((0..100).map(|k| Some(square(k)))).ok_or("squares")?;
    /// // A hundredth of the quantiles of chi-squared with 100 degrees: 74.22 and 129.56.
    /// assert!((test.mean - 1.0).abs() < 1e-12 && (test.bounds.0 - 0.7422).abs() < 1e-4 && test.accepted());
    /// # Ok::<(), &str>(())
    /// ```
    pub fn of(squares: impl IntoIterator<Item = Option<NormalisedSquare>>) -> Option<Self> {
        let (mut all, mut sum, mut degrees) = (0usize, 0.0, 0usize);
        let mut test =
            Self { mean: 0.0, expected: 0.0, bounds: (0.0, 0.0), samples: 0, singular: 0, outside: 0, left_out: 0 };
        for square in squares {
            all += 1;
            let Some(square) = square else {
                test.left_out += 1;
                continue;
            };
            (sum, degrees) = (sum + square.square, degrees + square.degrees);
            test.samples += usize::from(square.degrees > 0);
            test.singular += usize::from(square.degrees < square.entries);
            test.outside += usize::from(square.is_outside);
        }
        if degrees > 0 {
            let (count, degrees) = (test.samples as f64, degrees as f64);
            test.bounds = (quantile(0.025, degrees) / count, quantile(0.975, degrees) / count);
            (test.mean, test.expected) = (sum / count, degrees / count);
        }
        (all > 0).then_some(test)
    }

    /// Whether the mean lies in the acceptance region, and no error is without variance.
    pub fn accepted(&self) -> bool {
        (self.bounds.0..=self.bounds.1).contains(&self.mean) && self.outside == 0
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
