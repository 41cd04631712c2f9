//! The statistics of an ensemble in the row of the results.

use luenberger_proof::wording::counted;

use super::percentiles::PERCENT;
use super::runs::{NORM, STATE};
use crate::results::{PercentileReport, ScoreStatistics, StateReport, SweepRow};
use crate::statistics::Moments;
use crate::study::Study;

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
        row.statistics = names.iter().zip(scores).map(|(name, score)| statistics(name, &score.moments)).collect();
    }
}

fn statistics(score: &str, moments: &Moments) -> ScoreStatistics {
    ScoreStatistics {
        score: score.to_owned(),
        count: moments.count(),
        mean: moments.mean(),
        deviation: moments.deviation(),
        min: moments.min(),
        max: moments.max(),
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
