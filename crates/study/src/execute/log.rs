//! The observers on a measured log: no plant is simulated; figures of merit are the innovations, and the errors where
//! the log has the true states.

use std::borrow::Cow;
use std::sync::Arc;

use luenberger_clock::Instant;
use luenberger_proof::wording::significant;
use luenberger_sim::replay::{FilterConsistency, Replay, ReplayedObserver};
use luenberger_sim::{BetweenRows, Estimates, Recording, Samples, Settings, SimError};
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::filter::stationary_deviation;
use super::options::RunOptions;
use super::rows::Run;
use super::scores::key;
use super::stationary::Stationary;
use super::stopped::why;
use super::{excursion, sampling};
use crate::designed::{RowVariances, Runnable};
use crate::model::PlantModel;
use crate::results::{
    ConsistencyReport, InnovationOf, InnovationReport, LogColumn, LogReport, SmoothedDeviation, SmoothedReport,
    StateScore,
};
use crate::study::{Log, Study};
use crate::trajectory::Member;

/// The settings of a replay of a log of this study.
pub(crate) fn settings(study: &Study, until: Option<Instant>) -> Settings {
    Settings { rtol: 1e-9, end: until, ..study.simulation.as_ref().map_or_else(Settings::default, |of| of.settings) }
}

/// The replay of a recording for the observers of a plant.
pub(crate) fn replay_of<'a>(
    plant: &'a PlantModel,
    recording: impl Into<Cow<'a, Recording>>,
    settings: Settings,
) -> Replay<'a> {
    let turns = plant.turns_of(&plant.states).unwrap_or_default();
    Replay::new(&plant.model, recording).settings(settings).angles(&turns)
}

/// The observer with the variances of the rows of a log, if it takes them and there are some.
pub(crate) fn with_variances(runnable: &Runnable, variances: Option<&Samples>) -> Option<Runnable> {
    runnable.with_variances(&Arc::new(RowVariances(variances?.clone())))
}

pub(super) fn replay(
    study: &Study,
    log: &Log,
    member: &Member<'_>,
    until: Option<Instant>,
    tell: &(dyn Fn(usize, usize) + Sync),
) -> Result<ReplayedObserver, SimError> {
    let mut replay = replay_of(&study.plant, &log.recording, settings(study, until)).progress(tell);
    // A long log is kept with what is shown of it only.
    if log.estimates == Estimates::Filtered {
        replay = replay.without_predictions();
        if log.truth.is_none() && !member.requested.kind.smooths() {
            replay = replay.deviations_only();
        }
    }
    let name = member.requested.name.as_str();
    let (of_rows, initial) =
        (with_variances(&member.designed.runnable, log.variances.as_ref()), &member.requested.initial);
    let runnable = of_rows.as_ref().unwrap_or(&member.designed.runnable);
    let replay = if holds_more(member) && log.estimates == Estimates::Filtered { replay.with_states() } else { replay };
    let replay = if member.requested.kind.smooths() {
        runnable.replay_smoothed(replay, name, initial)
    } else {
        runnable.replay(replay, name, initial)
    };
    let unknown = || SimError::UnknownName { name: name.to_owned() };
    replay.run()?.observers.pop().map(|replayed| shown(log, replayed)).ok_or_else(unknown)
}

/// Whether the state of the observer holds disturbances, probabilities of models or bounds besides the estimates.
fn holds_more(member: &Member<'_>) -> bool {
    let runnable = &member.designed.runnable;
    let state = vec![0.0; runnable.dimensions().state];
    runnable.disturbances() > 0
        || !member.requested.kind.modes().is_empty()
        || runnable.half_widths_of(&state).is_some()
}

/// The run of one observer, with its warnings and those of the log.
pub(super) fn replay_one(
    study: &Study,
    log: &Log,
    member: &Member<'_>,
    until: Option<Instant>,
) -> Result<Run, SimError> {
    let replayed = replay(study, log, member, until, &|_, _| ())?;
    let sampling = sampling::on_log(study, member, log.recording.outputs());
    // A log of a row or two has no statistics.
    let report = report(study, log, member, &replayed).map(|report| InnovationReport { sampling, ..report });
    let own = warnings(study, log, member, (&replayed, report.as_ref().ok()));
    let mut run = run(log, member, replayed);
    run.warnings = of_log(study, log);
    run.warnings.extend(own);
    run.warnings.extend(excursion::warnings(study, &[(member, &run)]));
    Ok(run)
}

/// With the estimates that the log asks for in the place of the filtered ones.
fn shown(log: &Log, replayed: ReplayedObserver) -> ReplayedObserver {
    match log.estimates {
        Estimates::Filtered => replayed,
        Estimates::Predicted => replayed.with_predictions(),
    }
}

fn report(
    study: &Study,
    log: &Log,
    member: &Member<'_>,
    replayed: &ReplayedObserver,
) -> Result<InnovationReport, SimError> {
    let times = log.recording.times();
    let middle = times[times.len() / 2];
    let rejected = |output: usize| {
        let all = replayed.consistency.iter().flat_map(|consistency| &consistency.rejected);
        all.filter(|(k, j)| *j == output && replayed.t[*k] >= middle).count()
    };
    let measured = replayed.statistics(middle)?.into_iter().zip(&study.plant.outputs).enumerate();
    let measured = measured.filter(|(j, (statistics, _))| statistics.samples + rejected(*j) > 0);
    let outputs = measured.map(|(j, (statistics, name))| InnovationOf {
        output: name.clone(),
        samples: statistics.samples,
        rejected: rejected(j),
        mean: statistics.mean,
        rms: statistics.rms,
        peak: statistics.peak,
        white: statistics.whiteness.map(|whiteness| whiteness.p_value),
    });
    let last = replayed.estimate.nrows().saturating_sub(1);
    let nis = replayed.consistency(middle)?.map(ConsistencyReport::from);
    let nees = log.truth.as_ref().map(|truth| replayed.nees(truth, middle)).transpose()?.flatten();
    let nees = nees.map(ConsistencyReport::from);
    let stationary = Stationary::of(study, member).filter(|_| replayed.consistency.is_none());
    let (nis, nees) = match stationary.map(|of| of.of_log(log, replayed, middle)).transpose()?.flatten() {
        Some(of) => (of.nis, of.nees),
        None => (nis, nees),
    };
    Ok(InnovationReport {
        observer: replayed.name.clone(),
        outputs: outputs.collect(),
        estimate: replayed.estimate.row(last).iter().copied().collect(),
        deviation: replayed.consistency.as_ref().and_then(FilterConsistency::last_deviation).unwrap_or_default(),
        normalised: nis.as_ref().map(|nis| nis.mean),
        nis,
        nees,
        errors: errors(study, log, replayed)?,
        smoothed: replayed
            .with_smoothed_estimates()
            .map(|smoothed| smoothed_report(study, log, replayed, &smoothed))
            .transpose()?,
        sampling: None,
        rows_used: replayed.rows_used(),
        interpolated: replayed.interpolated,
        failure: None,
    })
}

/// The smoothed estimates of a filter, beside its own.
fn smoothed_report(
    study: &Study,
    log: &Log,
    replayed: &ReplayedObserver,
    smoothed: &ReplayedObserver,
) -> Result<SmoothedReport, SimError> {
    let middle = log.recording.times()[log.recording.times().len() / 2];
    let nees = log.truth.as_ref().map(|truth| smoothed.nees(truth, middle)).transpose()?.flatten();
    let rms = |of: &ReplayedObserver, i: usize| {
        let deviation = of.consistency.as_ref().map(FilterConsistency::deviation);
        deviation.map_or(0.0, |deviation| deviation.column(i).norm() / (deviation.nrows() as f64).sqrt())
    };
    let deviation = |(i, state): (usize, &String)| SmoothedDeviation {
        state: state.clone(),
        filtered: rms(replayed, i),
        smoothed: rms(smoothed, i),
    };
    Ok(SmoothedReport {
        estimate: smoothed.estimate.row(0).iter().copied().collect(),
        deviations: study.plant.states.iter().enumerate().map(deviation).collect(),
        nees: nees.map(ConsistencyReport::from),
        errors: errors(study, log, smoothed)?,
    })
}

/// The errors of the states that the log knows.
fn errors(study: &Study, log: &Log, replayed: &ReplayedObserver) -> Result<Vec<StateScore>, SimError> {
    let Some(truth) = &log.truth else { return Ok(Vec::new()) };
    let errors = replayed.errors(truth)?;
    let score = |(i, state): (usize, &String)| {
        let errors: Vec<f64> = errors.column(i).iter().filter_map(|error| *error).collect();
        let last = *errors.last()?;
        let squares: f64 = errors.iter().map(|error| error * error).sum();
        Some(StateScore {
            state: state.clone(),
            samples: errors.len(),
            rmse: (squares / errors.len() as f64).sqrt(),
            peak: errors.iter().fold(0.0, |peak, error| peak.max(error.abs())),
            last,
        })
    };
    Ok(study.plant.states.iter().enumerate().filter_map(score).collect())
}

/// What limits the use of the log by an observer.
fn warning(study: &Study, log: &Log, replayed: &ReplayedObserver, period: Option<f64>) -> Option<String> {
    let (rows, used, samples) = (log.recording.times().len(), replayed.rows_used(), replayed.t.len());
    let period = period?;
    let unit = study.plant.time_unit.as_ref().map(|unit| format!(" {unit}")).unwrap_or_default();
    let (name, period) = (&replayed.name, significant(period, 6));
    let median = significant(log.recording.median_period(), 6);
    if used < rows {
        return Some(format!(
            "{name}: Only {used} of {rows} rows lie on the observer's samples (period {period}{unit}, median Ts {median}{unit}); the others are not used"
        ));
    }
    (2 * used < samples).then(|| {
        format!(
            "{name}: Only {used} of {samples} samples of the observer (period {period}{unit}, median Ts {median}{unit}) have a row; at the others it predicts"
        )
    })
}

/// A gate that rejects this share of the measurements of an output rejects more than outliers.
pub(super) const REJECTED: f64 = 0.1;

/// Outputs of which the gate of a filter rejects so much that it can no longer be trusted.
fn locked_out(study: &Study, log: &Log, replayed: &ReplayedObserver) -> Vec<String> {
    let Some(consistency) = &replayed.consistency else { return Vec::new() };
    let one = |(j, output): (usize, &String)| {
        let (rejected, all) =
            (consistency.rejected.iter().filter(|(_, of)| *of == j).count(), log.recording.outputs().count(j));
        (rejected as f64 > REJECTED * all as f64).then(|| {
            format!(
                "{}: the gate rejects {rejected} of {all} measurements of {output}: the filter is overconfident, or the model is wrong; increase p0, w or gate",
                replayed.name
            )
        })
    };
    study.plant.outputs.iter().enumerate().filter_map(one).collect()
}

/// Outputs of which an observer predicts less than their mean does.
fn astray(study: &Study, log: &Log, report: &InnovationReport) -> Vec<String> {
    let outputs = log.recording.outputs();
    let one = |of: &InnovationOf| {
        let j = study.plant.outputs.iter().position(|output| *output == of.output)?;
        let measured: Vec<f64> = (0..outputs.times().len()).filter_map(|k| outputs.value(k, j)).collect();
        let count = measured.len() as f64;
        let mean = measured.iter().sum::<f64>() / count;
        let deviation = (measured.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / count).sqrt();
        (of.rms > deviation && deviation > 0.0).then(|| {
            let (rms, deviation) = (significant(of.rms, 2), significant(deviation, 2));
            format!(
                "{}: the innovations of {} (rms {rms}) are larger than its deviation from its mean ({deviation}): the estimates are not usable. Too fast for the period of the log, a wrong model, or a filter that diverges",
                report.observer, of.output
            )
        })
    };
    report.outputs.iter().filter_map(one).collect()
}

/// An observer with its estimates on the log, if the replay finished.
pub(super) type Outcome<'a> = (Member<'a>, Option<Run>);

/// That a filter with a covariance has no use for the variances of the rows.
fn without_variances(log: &Log, member: &Member<'_>) -> Option<String> {
    let runnable = &member.designed.runnable;
    let is_without = log.variances.is_some()
        && runnable.filter().is_some()
        && with_variances(runnable, log.variances.as_ref()).is_none();
    is_without.then(|| {
        let (name, kind) = (&member.requested.name, member.requested.kind.name());
        format!("{name} has its own V in all rows: the kind {kind} does not take `variances` of the log.")
    })
}

/// The report, the runs, and the warnings.
pub(super) fn replay_all<'a>(
    study: &Study,
    log: &Log,
    members: &[Member<'a>],
    options: &RunOptions<'_>,
) -> (LogReport, Vec<Outcome<'a>>, Vec<String>) {
    let one = |member: &Member<'a>| {
        if options.interrupted() {
            return None;
        }
        let name = &member.requested.name;
        let tell = |done: usize, rows: usize| options.tell("log", &format!("{name}, rows"), done, rows);
        let outcome = replay(study, log, member, options.until, &tell).and_then(|replayed| {
            let report = InnovationReport {
                sampling: sampling::on_log(study, member, log.recording.outputs()),
                ..report(study, log, member, &replayed)?
            };
            let warnings = warnings(study, log, member, (&replayed, Some(&report)));
            let run = Run { warnings: warnings.clone(), ..run(log, member, replayed) };
            Ok((report, run, warnings))
        });
        options.tell("log", &member.requested.name, 1, 1);
        let failed = |error: SimError| InnovationReport {
            observer: member.requested.name.clone(),
            outputs: Vec::new(),
            estimate: Vec::new(),
            deviation: Vec::new(),
            normalised: None,
            nis: None,
            nees: None,
            errors: Vec::new(),
            smoothed: None,
            sampling: None,
            rows_used: 0,
            interpolated: 0,
            failure: Some(why(study, &error)),
        };
        Some(match outcome {
            Ok((report, run, warnings)) => (report, (*member, Some(run)), warnings),
            Err(error) => (failed(error), (*member, None), Vec::new()),
        })
    };
    let outcomes: Vec<_> = members.par_iter().filter_map(one).collect();
    let mut warnings = of_log(study, log);
    let (mut rows, mut runs) = (Vec::new(), Vec::new());
    for (report, run, own) in outcomes {
        rows.push(report);
        runs.push(run);
        warnings.extend(own);
    }
    (summary(study, log, rows), runs, warnings)
}

/// What limits the use of a log by an observer, with its report if it has one.
fn warnings(
    study: &Study,
    log: &Log,
    member: &Member<'_>,
    (replayed, report): (&ReplayedObserver, Option<&InnovationReport>),
) -> Vec<String> {
    let mut warnings = locked_out(study, log, replayed);
    warnings.extend(without_variances(log, member));
    if let Some(report) = report {
        warnings.extend(astray(study, log, report));
        warnings.extend(report.sampling.iter().filter(|found| found.outside > 0).map(|found| found.words.clone()));
    }
    warnings.extend(warning(study, log, replayed, member.designed.runnable.period()));
    warnings
}

/// What is suspicious in a log, and what is asked for that uses later measurements.
fn of_log(study: &Study, log: &Log) -> Vec<String> {
    let unit = study.plant.time_unit.as_deref();
    let mut warnings: Vec<String> =
        log.suspicions.iter().map(|suspicion| format!("in the log: {}", suspicion.in_words(unit))).collect();
    if linear(log) {
        warnings
            .push("in the log: linear interpolation between rows, as asked for, uses later measurements".to_owned());
    }
    warnings
}

fn linear(log: &Log) -> bool {
    log.recording.outputs_between() == BetweenRows::Linear
}

fn summary(study: &Study, log: &Log, rows: Vec<InnovationReport>) -> LogReport {
    let recording = &log.recording;
    let times = recording.times();
    let column = |(j, output): (usize, &String)| {
        let samples = recording.outputs().count(j);
        let median_period = recording.output_period(j);
        (samples < times.len()).then(|| LogColumn { output: output.clone(), samples, median_period })
    };
    LogReport {
        samples: times.len(),
        start: times.first().copied().unwrap_or(0.0),
        end: times.last().copied().unwrap_or(0.0),
        median_period: recording.median_period(),
        gaps: recording.gaps().into_iter().map(|(from, to)| [from, to]).collect(),
        estimates: key(log.estimates),
        interpolation: match recording.outputs_between() {
            BetweenRows::Predicted => "predicted",
            BetweenRows::Held => "held",
            BetweenRows::Linear => "linear",
        },
        columns: study.plant.outputs.iter().enumerate().filter_map(column).collect(),
        rows,
    }
}

/// Whether every output is measured in every row.
fn is_complete(outputs: &Samples) -> bool {
    (0..outputs.values().ncols()).all(|output| outputs.count(output) == outputs.times().len())
}

/// The rows of a table; what is not known is NaN.
fn run(log: &Log, member: &Member<'_>, replayed: ReplayedObserver) -> Run {
    let (runnable, kind) = (&member.designed.runnable, &member.requested.kind);
    let states = replayed.states.as_ref();
    let half_width = states.and_then(|states| runnable.half_widths(states));
    let disturbance = states.and_then(|states| Some((kind.estimated_disturbances(), runnable.disturbance(states)?)));
    let modes = states.and_then(|states| Some((kind.modes(), runnable.modes(states)?)));
    let (recording, rows) = (&log.recording, replayed.t.len());
    let mut u = DMatrix::zeros(rows, recording.inputs().values().ncols());
    let mut row = vec![0.0; u.ncols()];
    for (k, t) in replayed.t.iter().enumerate() {
        recording.inputs().at(*t, &mut row);
        row.iter().enumerate().for_each(|(j, x)| u[(k, j)] = *x);
    }
    let of = |samples: &Samples| {
        let value = |k: usize, j: usize| replayed.row[k].and_then(|k| samples.value(k, j)).unwrap_or(f64::NAN);
        DMatrix::from_fn(rows, samples.values().ncols(), value)
    };
    Run {
        x: log.truth.as_ref().map_or_else(|| DMatrix::zeros(rows, 0), of),
        y: of(recording.outputs()),
        u,
        innovation: replayed.innovation.map(|innovation| innovation.map(|nu| nu.unwrap_or(f64::NAN))),
        deviation: match &replayed.consistency {
            Some(consistency) => Some(consistency.deviation()),
            // The stationary covariance is that of a measurement at every sample.
            None if is_complete(recording.outputs()) => stationary_deviation(member, rows),
            None => None,
        },
        estimate: Some(replayed.estimate),
        half_width,
        functions: None,
        disturbance,
        modes,
        samples: Vec::new(),
        warnings: Vec::new(),
        smoothed: replayed.smoothed.map(|smoothed| (smoothed.estimate.clone(), smoothed.deviation())),
        t: replayed.t,
    }
}
