//! The observer on the part of the logs that was held out.

use luenberger_sim::replay::{Consistency, InnovationStatistics};

use super::criterion::{Criterion, OnTime};
use super::report::{Judged, JudgedOutput, JudgedState};
use crate::execute::prediction::Predictions;
use crate::results::ConsistencyReport;
use crate::study::TuneCriterion;

/// How good the observer is with these values; it runs through what was fitted before.
pub(super) fn judged(criterion: &Criterion<'_>, values: &[f64]) -> Judged {
    let none = Judged { log_likelihood: None, nis: None, relative: None, innovations: Vec::new(), errors: Vec::new() };
    if criterion.spec.criterion == TuneCriterion::Likelihood {
        return of_filter(criterion, values).unwrap_or(none);
    }
    let Ok(predictions) = criterion.predictions(values, true) else { return none };
    Judged {
        relative: Some(criterion.relative(&criterion.errors_of(&predictions, true))),
        innovations: outputs(criterion, |log, j| predictions[log].innovations(j)),
        errors: states(criterion, |log, i| predictions[log].errors(i)),
        ..none
    }
}

/// The measurements of a time whose innovation is the largest by its covariance.
pub(super) struct Largest {
    pub(super) file: String,
    pub(super) t: f64,
    /// The output of which the innovation is the largest, relative to the others of that output.
    pub(super) output: String,
    /// Its reading; none of an output that is late.
    pub(super) reading: Option<f64>,
    /// The root of `nu' S^-1 nu`.
    pub(super) deviations: f64,
}

/// That of all rows with these values, fitted or held out.
pub(super) fn largest(criterion: &Criterion<'_>, values: &[f64]) -> Option<Largest> {
    let on_time = criterion.replayed(values, true).ok()?;
    let of_log = |(log, OnTime { replayed, .. }): (usize, &OnTime)| {
        let squares = replayed.consistency.iter().flat_map(|consistency| consistency.nis.iter().enumerate());
        squares.filter_map(|(k, nis)| nis.map(|nis| (log, k, nis.square))).collect::<Vec<_>>()
    };
    let all = on_time.iter().enumerate().flat_map(of_log);
    let (log, k, square) = all.max_by(|one, other| one.2.total_cmp(&other.2))?;
    let (data, replayed) = (&criterion.data[log], &on_time[log].replayed);
    let innovation = replayed.innovation.as_ref()?;
    let relative = |j: usize| {
        let nu = innovation[(k, j)]?;
        let all: Vec<f64> = innovation.column(j).iter().copied().flatten().collect();
        Some((j, nu.abs() / InnovationStatistics::of(&all).rms))
    };
    let (j, _) = (0..innovation.ncols()).filter_map(relative).max_by(|one, other| one.1.total_cmp(&other.1))?;
    Some(Largest {
        file: data.name.clone(),
        t: replayed.t[k],
        output: criterion.study.plant.outputs[j].clone(),
        reading: if criterion.has_delays() { None } else { data.reading(replayed.t[k], j) },
        deviations: square.sqrt(),
    })
}

fn of_filter(criterion: &Criterion<'_>, values: &[f64]) -> Option<Judged> {
    let on_time = criterion.replayed(values, true).ok()?;
    let held: Vec<Vec<usize>> = on_time.iter().map(OnTime::held_out).collect();
    let mut squares = Vec::new();
    for (of, held) in on_time.iter().zip(&held) {
        let Some(consistency) = &of.replayed.consistency else { continue };
        squares.extend(held.iter().filter_map(|k| consistency.nis[*k]).map(Some));
        squares.extend(consistency.passed_over.iter().filter(|k| held.contains(k)).map(|_| None));
    }
    let innovations = |log: usize, j: usize| {
        let innovation = on_time[log].replayed.innovation.as_ref();
        innovation.map_or_else(Vec::new, |innovation| held[log].iter().filter_map(|k| innovation[(*k, j)]).collect())
    };
    // The estimates are those of a filter that gets late measurements late.
    let late: Option<Vec<Predictions>> =
        criterion.has_delays().then(|| criterion.predictions(values, true).unwrap_or_default());
    let errors = |log: usize, i: usize| -> Vec<f64> {
        if let Some(late) = &late {
            return late.get(log).map_or_else(Vec::new, |of| of.errors(i));
        }
        let (_, of) = &criterion.spec.logs[log];
        let errors = of.truth.as_ref().and_then(|truth| on_time[log].replayed.errors(truth).ok());
        errors.map_or_else(Vec::new, |errors| held[log].iter().filter_map(|k| errors[(*k, i)]).collect())
    };
    Some(Judged {
        log_likelihood: on_time
            .iter()
            .map(OnTime::log_likelihood_held_out)
            .sum::<Result<f64, String>>()
            .ok()
            .filter(|sum| sum.is_finite()),
        nis: Consistency::of(squares).map(ConsistencyReport::from),
        relative: None,
        innovations: outputs(criterion, innovations),
        errors: states(criterion, errors),
    })
}

/// The innovations of each output of each log.
fn outputs(criterion: &Criterion<'_>, innovations: impl Fn(usize, usize) -> Vec<f64>) -> Vec<JudgedOutput> {
    let logs = criterion.data.iter().enumerate();
    let one = |(log, data): (usize, &super::criterion::Data<'_>)| {
        let of = |(j, output): (usize, &String)| {
            let statistics = InnovationStatistics::of(&innovations(log, j));
            (statistics.samples > 0).then(|| JudgedOutput {
                file: data.name.clone(),
                output: output.clone(),
                samples: statistics.samples,
                mean: statistics.mean,
                rms: statistics.rms,
                white: statistics.whiteness.map(|whiteness| whiteness.p_value),
            })
        };
        criterion.study.plant.outputs.iter().enumerate().filter_map(of).collect::<Vec<_>>()
    };
    logs.flat_map(one).collect()
}

/// The errors of the states that the logs know, after the measurement of a row.
fn states(criterion: &Criterion<'_>, errors: impl Fn(usize, usize) -> Vec<f64>) -> Vec<JudgedState> {
    let one = |(i, state): (usize, &String)| {
        let all: Vec<f64> = (0..criterion.data.len()).flat_map(|log| errors(log, i)).collect();
        let samples = all.len();
        let rms = (all.iter().map(|error| error * error).sum::<f64>() / samples.max(1) as f64).sqrt();
        (samples > 0).then(|| JudgedState { state: state.clone(), samples, rms })
    };
    criterion.study.plant.states.iter().enumerate().filter_map(one).collect()
}
