//! What innovations `y - h(xhat)` say of an observer: their size, whether they are white, whether a filter believes in
//! the right covariance.
//!
//! Where plant, noise and filter agree, the innovations of a Kalman filter are white, of mean 0, and of the covariance
//! S that the filter computes. An observer with a constant gain has white innovations only by luck; their spectrum then
//! still says what is left in the data: a mean is a bias of a sensor or of the model, a slow autocorrelation is
//! dynamics that the model does not have.
//!
//! Sources: G. M. Ljung and G. E. P. Box, On a measure of lack of fit in time series models, Biometrika 65, 1978; Y.
//! Bar-Shalom, X. R. Li and T. Kirubarajan, Estimation with Applications to Tracking and Navigation, Wiley 2001,
//! section 5.4.

/// Statistics of the innovation of one output.
#[derive(Clone, Debug, PartialEq)]
pub struct InnovationStatistics {
    /// How many innovations were used.
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
    /// How probable a Q at least as large is for a white sequence: below 0.05 one says that it is not white.
    pub p_value: f64,
}

/// Whether the innovations of a filter have the covariance that it believes in.
#[derive(Clone, Debug, PartialEq)]
pub struct Consistency {
    /// The mean of `nu' S^-1 nu`, which is p where everything agrees. Above, the filter trusts itself too much; below,
    /// too little.
    pub mean: f64,
    /// The mean lies between these two with a probability of 95 %, where everything agrees (by the normal approximation
    /// of chi-squared with N p degrees).
    pub bounds: (f64, f64),
}

/// The longest lag.
const LAGS: usize = 20;

/// The statistics of a sequence of finite numbers; none for an empty one.
pub(super) fn statistics(innovations: &[f64]) -> Option<InnovationStatistics> {
    if innovations.is_empty() {
        return None;
    }
    let count = innovations.len() as f64;
    let mean = innovations.iter().sum::<f64>() / count;
    let rms = (innovations.iter().map(|nu| nu * nu).sum::<f64>() / count).sqrt();
    let peak = innovations.iter().fold(0.0f64, |peak, nu| peak.max(nu.abs()));
    Some(InnovationStatistics {
        samples: innovations.len(),
        mean,
        rms,
        peak,
        whiteness: whiteness(innovations, mean, rms),
    })
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
    Some(Whiteness {
        autocorrelation,
        bound: 1.96 / count.sqrt(),
        statistic,
        p_value: chi_squared_tail(statistic, lags),
    })
}

/// The probability that chi-squared with an even number of degrees exceeds x: `exp(-x/2) sum_(i < k/2) (x/2)^i/i!`.
fn chi_squared_tail(x: f64, degrees: usize) -> f64 {
    let half = x / 2.0;
    let (mut term, mut sum) = (1.0, 0.0);
    for i in 0..degrees / 2 {
        sum += term;
        term *= half / (i + 1) as f64;
    }
    ((-half).exp() * sum).clamp(0.0, 1.0)
}

/// The mean of normalised innovations squared of p outputs, with the bounds of what it should be.
pub(super) fn consistency(normalised: &[f64], outputs: usize) -> Option<Consistency> {
    if normalised.is_empty() {
        return None;
    }
    let (count, expected) = (normalised.len() as f64, outputs as f64);
    let reach = 1.96 * (2.0 * expected / count).sqrt();
    let bounds = ((expected - reach).max(0.0), expected + reach);
    Some(Consistency { mean: normalised.iter().sum::<f64>() / count, bounds })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tail_of_chi_squared_is_that_of_the_tables() {
        // Abramowitz and Stegun, table 26.8: 95 % and 99 % points.
        for (degrees, x, tail) in [(2, 5.99147, 0.05), (10, 18.3070, 0.05), (20, 31.4104, 0.05), (20, 37.5662, 0.01)] {
            assert!((chi_squared_tail(x, degrees) - tail).abs() < 1e-6, "{degrees} {x}");
        }
        assert_eq!((chi_squared_tail(0.0, 4), chi_squared_tail(1e9, 20)), (1.0, 0.0));
    }

    #[test]
    fn a_sequence_with_a_known_correlation() {
        // 1, -1, 1, ...: r_k = (-1)^k (N - k)/N, so that Q = (N + 2)/N sum (N - k).
        let alternating: Vec<f64> = (0..100).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let statistics = statistics(&alternating).unwrap();
        assert_eq!((statistics.mean, statistics.rms, statistics.peak), (0.0, 1.0, 1.0));
        let whiteness = statistics.whiteness.unwrap();
        assert_eq!(whiteness.autocorrelation.len(), 10);
        assert!(
            (whiteness.autocorrelation[0] + 0.99).abs() < 1e-15 && (whiteness.autocorrelation[1] - 0.98).abs() < 1e-15
        );
        assert!((whiteness.statistic - 1.02 * 945.0).abs() < 1e-9 && whiteness.p_value < 1e-190);
        assert!(super::statistics(&[0.1; 50]).unwrap().whiteness.is_none());
        assert!(super::statistics(&[]).is_none());
    }
}
