//! Statistics of scores over an ensemble: moments, and the row of the results.

use luenberger_proof::wording::counted;

use super::percentiles::PERCENT;
use super::runs::{NORM, STATE};
use crate::results::{PercentileReport, ScoreStatistics, StateReport, SweepRow};
use crate::study::Study;

/// Count, mean, sum of the squared deviations from it, and extremes of the finite values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moments {
    count: u64,
    mean: f64,
    squares: f64,
    min: f64,
    max: f64,
}

impl Default for Moments {
    fn default() -> Self {
        Self { count: 0, mean: 0.0, squares: 0.0, min: f64::INFINITY, max: f64::NEG_INFINITY }
    }
}

impl Moments {
    /// Those of some values, by the update of Welford, Technometrics 4, 1962.
    pub(super) fn of(values: &[f64]) -> Self {
        let mut moments = Self::default();
        for &x in values.iter().filter(|x| x.is_finite()) {
            moments.count += 1;
            let before = x - moments.mean;
            moments.mean += before / moments.count as f64;
            moments.squares += before * (x - moments.mean);
            (moments.min, moments.max) = (moments.min.min(x), moments.max.max(x));
        }
        moments
    }

    /// Those of both, by the update of Chan, Golub and LeVeque, The American Statistician 37, 1983. The last bits
    /// depend on the order.
    #[must_use]
    pub(super) fn merge(self, other: Self) -> Self {
        if self.count == 0 || other.count == 0 {
            return if self.count == 0 { other } else { self };
        }
        let count = self.count + other.count;
        let (share, apart) = (other.count as f64 / count as f64, other.mean - self.mean);
        Self {
            count,
            mean: self.mean + apart * share,
            squares: self.squares + other.squares + apart * apart * share * self.count as f64,
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    fn report(self, score: &str) -> ScoreStatistics {
        let known = |x: f64| (self.count > 0).then_some(x);
        let deviation = (self.squares / (self.count.max(2) - 1) as f64).sqrt();
        ScoreStatistics {
            score: score.to_owned(),
            count: self.count,
            mean: known(self.mean),
            deviation: (self.count > 1).then_some(deviation),
            min: known(self.min),
            max: known(self.max),
        }
    }
}

/// What is known of a score of a row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Summary {
    pub(super) moments: Moments,
    /// The percentiles, in the order of [`PERCENT`].
    pub(super) percentiles: [f64; 3],
}

/// Fills the row with the medians of the runs that finished, and for an ensemble with the other percentiles and the
/// moments. `scores` has the scores in the order of `names`.
pub(super) fn fill(row: &mut SweepRow, study: &Study, names: &[String], scores: &[Summary]) {
    let PercentileReport { settling, rms, peak, last, steady_rms, states, .. } = percentile(study, scores, 0);
    (row.settling, row.rms, row.peak, row.last, row.steady_rms) = (settling, rms, peak, last, steady_rms);
    row.states = states;
    if row.finished > 1 {
        row.percentiles = [1, 2].map(|k| percentile(study, scores, k)).to_vec();
        row.statistics = names.iter().zip(scores).map(|(name, score)| score.moments.report(name)).collect();
    }
}

/// The scores that so many percent of the runs do not exceed. A run that does not settle counts as infinite.
fn percentile(study: &Study, scores: &[Summary], k: usize) -> PercentileReport {
    let finite = |time: f64| time.is_finite().then_some(time);
    let of_states = study.plant.states.len() * STATE.len();
    let (norm, states) = scores.split_at(scores.len() - of_states);
    assert!(norm.is_empty() || norm.len() == NORM.len(), "{}", counted(norm.len(), "score"));
    let norm = |score: usize| norm.get(score).map(|score| score.percentiles[k]);
    let state = |(i, scores): (usize, &[Summary])| {
        let of = |score: usize| scores[score].percentiles[k];
        StateReport {
            state: study.plant.states[i].clone(),
            unit: study.plant.unit(&study.plant.states[i]).cloned(),
            initial: of(0),
            rmse: of(1),
            peak: of(2),
            overshoot: of(3),
            settling_5: finite(of(4)),
            settling_2: finite(of(5)),
            last: of(6),
            steady_rmse: of(7),
        }
    };
    PercentileReport {
        percent: PERCENT[k],
        settling: norm(0).and_then(finite),
        peak: norm(1),
        rms: norm(2),
        last: norm(3),
        steady_rms: norm(4),
        states: states.chunks(STATE.len()).enumerate().map(state).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By Python's math.fsum: mean and standard deviation of sin(k), k = 0..99.
    #[test]
    fn moments_of_parts_are_those_of_the_whole() {
        let values: Vec<f64> = (0..100).map(|k| f64::from(k).sin()).collect();
        let whole = Moments::of(&values).report("x");
        let (mean, deviation) = (whole.mean.unwrap(), whole.deviation.unwrap());
        assert!((mean - 0.0037919462744933886).abs() < 1e-15, "{mean:e}");
        assert!((deviation - 0.7107439797448485).abs() < 1e-14, "{deviation:e}");
        let extremes = (whole.min.unwrap(), whole.max.unwrap());
        assert_eq!(extremes, (f64::from(11).sin(), f64::from(33).sin()));
        for size in [1, 7, 32, 100] {
            let parts = values.chunks(size).map(Moments::of).fold(Moments::default(), Moments::merge).report("x");
            assert_eq!((parts.count, parts.min, parts.max), (100, whole.min, whole.max));
            assert!((parts.mean.unwrap() - mean).abs() < 1e-15 && (parts.deviation.unwrap() - deviation).abs() < 1e-14);
        }
        // Times of runs that do not settle are not among them.
        let report = Moments::of(&[f64::INFINITY, 2.0]).report("x");
        assert_eq!((report.count, report.mean, report.deviation), (1, Some(2.0), None));
        assert_eq!(Moments::of(&[f64::INFINITY]).report("x").mean, None);
    }
}
