//! The filter on the part of the logs that was held out.

use luenberger_sim::replay::{Consistency, InnovationStatistics, ReplayedObserver};

use super::likelihood::Criterion;
use super::report::{Judged, JudgedOutput, JudgedState};
use crate::results::ConsistencyReport;

/// How good the filter is with these values; it runs through what was fitted before.
pub(super) fn judged(criterion: &Criterion<'_>, values: &[f64]) -> Judged {
    let Ok(replayed) = criterion.replayed(values, true) else {
        return Judged { log_likelihood: None, nis: None, innovations: Vec::new(), errors: Vec::new() };
    };
    let of = |replayed: &ReplayedObserver, fitted: usize| -> Vec<usize> {
        (0..replayed.t.len()).filter(|k| replayed.row[*k].is_some_and(|row| row >= fitted)).collect()
    };
    let held: Vec<Vec<usize>> =
        replayed.iter().zip(&criterion.data).map(|(replayed, data)| of(replayed, data.fitted)).collect();
    let mut squares = Vec::new();
    for (replayed, held) in replayed.iter().zip(&held) {
        let Some(consistency) = &replayed.consistency else { continue };
        squares.extend(held.iter().filter_map(|k| consistency.nis[*k]).map(Some));
        squares.extend(consistency.passed_over.iter().filter(|k| held.contains(k)).map(|_| None));
    }
    let mut innovations = Vec::new();
    for ((replayed, held), data) in replayed.iter().zip(&held).zip(&criterion.data) {
        let Some(innovation) = &replayed.innovation else { continue };
        for (j, output) in criterion.study.plant.outputs.iter().enumerate() {
            let of: Vec<f64> = held.iter().filter_map(|k| innovation[(*k, j)]).collect();
            let statistics = InnovationStatistics::of(&of);
            if statistics.samples > 0 {
                innovations.push(JudgedOutput {
                    file: data.name.clone(),
                    output: output.clone(),
                    samples: statistics.samples,
                    mean: statistics.mean,
                    rms: statistics.rms,
                    white: statistics.whiteness.map(|whiteness| whiteness.p_value),
                });
            }
        }
    }
    Judged {
        log_likelihood: criterion.held_out(&replayed).ok().filter(|sum| sum.is_finite()),
        nis: Consistency::of(squares).map(ConsistencyReport::from),
        innovations,
        errors: errors(criterion, &replayed, &held),
    }
}

/// The errors of the states that the logs know, after the measurement of a row.
fn errors(criterion: &Criterion<'_>, replayed: &[ReplayedObserver], held: &[Vec<usize>]) -> Vec<JudgedState> {
    let states = criterion.study.plant.states.iter().enumerate();
    let one = |(i, state): (usize, &String)| {
        let mut squares = Vec::new();
        for ((replayed, held), (_, log)) in replayed.iter().zip(held).zip(&criterion.spec.logs) {
            let Some(errors) = log.truth.as_ref().and_then(|truth| replayed.errors(truth).ok()) else { continue };
            squares.extend(held.iter().filter_map(|k| errors[(*k, i)]).map(|error| error * error));
        }
        let samples = squares.len();
        let rms = (squares.iter().sum::<f64>() / samples.max(1) as f64).sqrt();
        (samples > 0).then(|| JudgedState { state: state.clone(), samples, rms })
    };
    states.filter_map(one).collect()
}
