//! The comparison on a log: prior information from the part that is fitted, scores on the part that is held out.

use luenberger_sim::Samples;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::candidate::{Candidate, Score};
use crate::RunOptions;
use crate::design::attempt;
use crate::error::StudyError;
use crate::execute::prediction::{self, Predictions};
use crate::statistics::percentile;
use crate::study::{AdviseSpec, Log, OutputNoise, Study};
use crate::trajectory::Member;
use crate::tuning::{Basis, Information, ranges};

/// What the information is derived from: the rows before `first`.
pub(super) fn basis(
    (study, log): (&Study, &Log),
    spec: &AdviseSpec,
    first: usize,
    run: &RunOptions<'_>,
) -> Result<Basis, StudyError> {
    let recording = &log.recording;
    let times = recording.times();
    let fitted = |samples: &Samples| {
        // What is missing of an input is the value before.
        DMatrix::from_fn(first, samples.values().ncols(), |k, j| samples.values()[(k, j)])
    };
    let mut start = vec![0.0; study.plant.inputs.len()];
    recording.inputs().at(times[0], &mut start);
    let filter = study.observers.iter().find_map(|observer| Some((observer.kind.noises()?, observer.name.as_str())));
    let settings = study.simulation.as_ref();
    let (states, outputs) = (study.plant.states.len(), study.plant.outputs.len());
    let per_time = study.plant.dt.unwrap_or(1.0);
    Ok(Basis {
        noises: noises((study, log), spec, first, filter),
        states: bounds((study, log), first, run)?,
        inputs: (ranges(&fitted(recording.inputs())), start),
        period: Basis::period_of_log(study, spec, recording.median_period()),
        scale: settings.and_then(|settings| settings.scale.clone()),
        duration: times[times.len() - 1] - times[0],
        band: settings.map_or(0.05, |settings| settings.band),
        w: filter
            .filter(|([w, v], _)| w.nrows() == states && v.nrows() == outputs)
            .map(|([w, _], name)| (w / per_time, format!("w of the observer {name:?}"))),
    })
}

/// The noise of each output, and where it is from.
fn noises(
    (study, log): (&Study, &Log),
    spec: &AdviseSpec,
    first: usize,
    filter: Option<([&DMatrix<f64>; 2], &str)>,
) -> (Vec<Option<OutputNoise>>, String) {
    let outputs = study.plant.outputs.len();
    let (deviations, from): (Vec<f64>, String) = match (&spec.noise, filter) {
        (Some(noise), _) => (noise.clone(), "advise.noise".to_owned()),
        (None, Some(([_, v], name))) if v.nrows() == outputs => {
            (v.diagonal().iter().map(|v| v.sqrt()).collect(), format!("v of the observer {name:?}"))
        }
        _ => {
            let of = (0..outputs).map(|j| from_second_differences((study, log), j, first)).collect();
            (
                of,
                "the median second difference of the measurements, which has the fast motion of the outputs, too"
                    .to_owned(),
            )
        }
    };
    let one = |(j, amplitude): (usize, f64)| {
        let period = log.recording.output_period(j);
        (amplitude > 0.0).then_some(OutputNoise { gaussian: true, amplitude, period })
    };
    (deviations.into_iter().enumerate().map(one).collect(), from)
}

/// The 3/4 quantile of the standard normal distribution, the median of its magnitude.
const MEDIAN_OF_MAGNITUDE: f64 = 0.674_489_750_196_081_7;

/// The standard deviation of white noise whose second differences have this median: their variance is 6 times its own.
/// Of a quantised signal that rests, that of a rounding error.
fn from_second_differences((study, log): (&Study, &Log), j: usize, first: usize) -> f64 {
    let y: Vec<f64> = (0..first).filter_map(|k| log.recording.outputs().value(k, j)).collect();
    let differences: Vec<f64> = y.windows(2).map(|pair| study.plant.innovation(j, pair[1], pair[0])).collect();
    let mut second: Vec<f64> = differences.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let median = percentile(&mut second, 50).unwrap_or(0.0);
    if median > 0.0 {
        return median / (MEDIAN_OF_MAGNITUDE * 6f64.sqrt());
    }
    let step = differences.iter().map(|step| step.abs()).filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
    if step.is_finite() { step / 12f64.sqrt() } else { 0.0 }
}

/// Least and largest values of the states, and which they are.
type Bounds = Option<(Vec<(f64, f64)>, String)>;

/// Where the states are in the rows that are fitted: the true ones where the log has them, otherwise the estimates of
/// the first observer of the study that runs.
fn bounds((study, log): (&Study, &Log), first: usize, run: &RunOptions<'_>) -> Result<Bounds, StudyError> {
    let of_column = |truth: &Samples, i: usize| {
        let all = (0..first).filter_map(|k| truth.value(k, i));
        all.fold(None, |found: Option<(f64, f64)>, x| {
            let (low, high) = found.unwrap_or((x, x));
            Some((low.min(x), high.max(x)))
        })
    };
    let states = study.plant.states.len();
    let known: Vec<Option<(f64, f64)>> =
        (0..states).map(|i| log.truth.as_ref().and_then(|truth| of_column(truth, i))).collect();
    if let Some(all) = known.iter().copied().collect::<Option<Vec<_>>>() {
        return Ok(Some((all, "the true states in the log".to_owned())));
    }
    for requested in &study.observers {
        let Ok(designed) = attempt(study, requested, run.cancel, run.until) else { continue };
        let estimate = match prediction::estimate((study, log), &Member { requested, designed: &designed }, run.until)?
        {
            Some(estimate) if estimate.ncols() == states => estimate,
            _ => continue,
        };
        let rows = first.min(estimate.nrows());
        let own = ranges(&estimate.rows(0, rows).into_owned());
        let all = known.iter().zip(own).map(|(known, own)| known.unwrap_or(own)).collect();
        let and = if known.iter().any(Option::is_some) { "the true states in the log, the" } else { "the" };
        return Ok(Some((all, format!("{and} estimates of {:?}", requested.name))));
    }
    Ok(None)
}

/// Scores all candidates on the rows that are held out; one that does not run has its reason. Returns these rows as a
/// sentence.
pub(super) fn scored(
    (study, log): (&Study, &Log),
    first: usize,
    candidates: &mut Vec<Candidate>,
    information: &Information,
    (run, open): (&RunOptions<'_>, &mut Vec<String>),
) -> Result<Option<String>, StudyError> {
    let done = std::sync::atomic::AtomicUsize::new(0);
    let count = candidates.len();
    let one = |candidate: &Candidate| {
        if run.interrupted() {
            return Ok(None);
        }
        let member = Member { requested: &candidate.spec, designed: &candidate.designed };
        let found = match Predictions::of((study, log), &member, first, run.until) {
            Err(StudyError::Interrupted) => return Ok(None),
            found => found?,
        };
        let finished = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
        run.tell("log", &candidate.spec.name, finished, count);
        Ok(Some(found))
    };
    let found = candidates.par_iter().map(one).collect::<Result<Vec<_>, StudyError>>()?;
    let mut kept = Vec::new();
    for (candidate, found) in std::mem::take(candidates).into_iter().zip(found) {
        match found {
            Some(found) => kept.push((candidate, found)),
            None => open.push(format!("the run of {} on the log", candidate.spec.name)),
        }
    }
    let ran = |(candidate, found): &'_ (Candidate, Result<Predictions, String>)| {
        found.as_ref().ok().map(|_| candidate.spec.name.clone())
    };
    let names: Vec<String> = kept.iter().filter_map(ran).collect();
    let all: Vec<(&str, &Predictions)> =
        names.iter().map(String::as_str).zip(kept.iter().filter_map(|(_, found)| found.as_ref().ok())).collect();
    let words = if all.is_empty() {
        None
    } else {
        let common = prediction::common(log, first, &all)?;
        let words = prediction::rows_in_words(log, first, &common);
        let scale = Some(information.scale.as_slice());
        let judged = |one: &Predictions| prediction::judged((study, log), one, (first, &common), scale);
        let reports: Vec<_> = kept.iter().map(|(_, found)| found.as_ref().ok().map(judged)).collect();
        for ((candidate, found), report) in kept.iter_mut().zip(reports) {
            if let (Ok(one), Some(report)) = (found, report) {
                candidate.runs = vec![Ok(Score::OnLog(report, one.outside))];
            }
        }
        Some(words)
    };
    for (mut candidate, found) in kept {
        if let Err(why) = found {
            candidate.runs = vec![Err(why)];
        }
        candidates.push(candidate);
    }
    Ok(words)
}
