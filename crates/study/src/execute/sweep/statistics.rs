//! Percentiles of scores over an ensemble, by nearest rank: each is the score of an actual run.

use crate::results::{MeritsReport, NormReport, PercentileReport, StateReport, SweepRow};

/// Fills the row with the medians of the runs that finished, and with the 5th and the 95th percentile if there are
/// several.
pub(super) fn fill(row: &mut SweepRow, runs: &[MeritsReport]) {
    row.finished = runs.len();
    if runs.is_empty() {
        return;
    }
    let PercentileReport { settling, rms, peak, last, steady_rms, states, .. } = percentile(runs, 50);
    (row.settling, row.rms, row.peak, row.last, row.steady_rms) = (settling, rms, peak, last, steady_rms);
    row.states = states;
    if runs.len() > 1 {
        row.percentiles = [5, 95].into_iter().map(|percent| percentile(runs, percent)).collect();
    }
}

/// The scores that so many percent of the runs do not exceed. A run that does not settle counts as infinite.
fn percentile(runs: &[MeritsReport], percent: u8) -> PercentileReport {
    let norm = |score: fn(&NormReport) -> f64| {
        let scores: Option<Vec<f64>> = runs.iter().map(|run| run.norm.as_ref().map(score)).collect();
        scores.map(|scores| rank(scores, percent))
    };
    let state = |i: usize| {
        let of = |score: fn(&StateReport) -> f64| rank(runs.iter().map(|run| score(&run.states[i])).collect(), percent);
        let first = &runs[0].states[i];
        StateReport {
            state: first.state.clone(),
            unit: first.unit.clone(),
            initial: of(|run| run.initial),
            rmse: of(|run| run.rmse),
            peak: of(|run| run.peak),
            overshoot: of(|run| run.overshoot),
            settling_5: finite(of(|run| time(run.settling_5))),
            settling_2: finite(of(|run| time(run.settling_2))),
            last: of(|run| run.last),
            steady_rmse: of(|run| run.steady_rmse),
        }
    };
    PercentileReport {
        percent,
        settling: norm(|norm| time(norm.settling_last)).and_then(finite),
        rms: norm(|norm| norm.rms),
        peak: norm(|norm| norm.peak),
        last: norm(|norm| norm.last),
        steady_rms: norm(|norm| norm.steady_rms),
        states: (0..runs[0].states.len()).map(state).collect(),
    }
}

fn time(settling: Option<f64>) -> f64 {
    settling.unwrap_or(f64::INFINITY)
}

fn finite(time: f64) -> Option<f64> {
    time.is_finite().then_some(time)
}

/// The smallest value that at least so many percent of the values do not exceed.
fn rank(mut values: Vec<f64>, percent: u8) -> f64 {
    values.sort_by(f64::total_cmp);
    let rank = (values.len() * usize::from(percent)).div_ceil(100).max(1);
    values.get(rank - 1).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By numpy: percentile(values, q, method="inverted_cdf").
    #[test]
    fn percentiles_are_those_of_numpy() {
        let values = || vec![3.0, 1.0, 2.0, 5.0, 4.0, 9.0, 7.0, 8.0, 6.0, 10.0];
        assert_eq!([5, 50, 95].map(|percent| rank(values(), percent)), [1.0, 5.0, 10.0]);
        let values: Vec<f64> = (0..41).map(f64::from).collect();
        assert_eq!([5, 50, 95].map(|percent| rank(values.clone(), percent)), [2.0, 20.0, 38.0]);
    }
}
