//! Simulations: each observer in its own run, so that a diverging one affects only its own row of the table.
//!
//! The rows of a run are equally spaced times; those of a run with a sampled observer are at its samples, where its
//! estimate is defined.

use luenberger_sim::Trajectory;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::options::RunOptions;
use super::rows::Run;
use super::scores::Scoring;
use super::stopped::why;
use super::{excursion, filter, sampling};
use crate::error::StudyError;
use crate::results::{FilterReport, IntervalReport, ObserverRun, RunReport, SamplingReport, SimulationReport};
use crate::study::{Simulation, Study};
use crate::trajectory::{self, Member, Variation, fed, times};

/// The runs that finished, as the results have them.
pub(super) fn named(runs: Vec<Outcome<'_>>, on_log: bool) -> impl Iterator<Item = ObserverRun> + use<'_> {
    runs.into_iter().filter_map(move |(member, run)| Some(run?.named(&member.requested.name, on_log)))
}

/// The rows of a run, with the measured outputs.
pub(super) fn samples(simulation: &Simulation, trajectory: &Trajectory, member: Option<&Member<'_>>) -> Run {
    let (wanted, _) = times(simulation, member.and_then(|member| member.designed.runnable.period()));
    let rows = wanted.len();
    let of = |matrix: &DMatrix<f64>| matrix.rows(0, rows).into_owned();
    let mut estimate = member
        .and_then(|member| trajectory.observer(&member.requested.name).ok())
        .map(|observer| observer.estimates(&wanted, simulation.estimates));
    let deviation = member.and_then(|member| match filter::deviation(trajectory, member, simulation.estimates) {
        Some(deviation) => Some(of(&deviation)),
        // The stationary covariance is that of a measurement at every sample.
        None if simulation.sensors.is_empty() => filter::stationary_deviation(member, rows),
        None => None,
    });
    let (x, u, mut y) = (of(&trajectory.x), of(&trajectory.u), of(&trajectory.measured));
    if member.is_some_and(|member| member.designed.runnable.period().is_some()) {
        // What a sensor holds between its measurements is no measurement at a sample.
        for j in (0..y.ncols()).filter(|j| simulation.sensor(*j).is_some()) {
            for (y, t) in y.column_mut(j).iter_mut().zip(&wanted) {
                *y = if trajectory.is_measured(j, *t) { *y } else { f64::NAN };
            }
        }
    }
    let disturbance = member.and_then(|member| {
        let states = &trajectory.observer(&member.requested.name).ok()?.state;
        let found = member.designed.runnable.disturbance(states)?;
        Some((member.requested.kind.estimated_disturbances(), of(&found)))
    });
    let modes = member.and_then(|member| {
        let names = member.requested.kind.modes();
        let found = if names.is_empty() { None } else { filter::modes(trajectory, member, simulation.estimates) };
        Some((names, of(&found?)))
    });
    let half_width = member.and_then(|member| {
        let states = &trajectory.observer(&member.requested.name).ok()?.state;
        member.designed.runnable.half_widths(states).map(|found| of(&found))
    });
    let functions = member.and_then(|member| {
        let (k, names) = member.requested.kind.functions()?;
        Some((names, &x * k.transpose(), estimate.take()?))
    });
    let (innovation, smoothed) = (None, None);
    let samples = member.and_then(|member| trajectory.observer(&member.requested.name).ok());
    let samples = samples.map(|observer| observer.samples.clone()).unwrap_or_default();
    Run {
        t: wanted,
        x,
        u,
        y,
        estimate,
        innovation,
        deviation,
        half_width,
        functions,
        disturbance,
        modes,
        smoothed,
        samples,
        warnings: Vec::new(),
    }
}

/// A run with its observer, or why it ended.
pub(super) type Outcome<'a> = (Member<'a>, Option<Run>);

/// What the simulations leave.
pub(super) struct Simulated<'a> {
    pub(super) report: SimulationReport,
    pub(super) runs: Vec<Outcome<'a>>,
    pub(super) filters: Vec<FilterReport>,
    pub(super) intervals: Vec<IntervalReport>,
    /// How runs left the regions of the designs.
    pub(super) warnings: Vec<String>,
}

/// All runs, in the order of the observers. `finished` is called for each run that ends, from any thread. Observers not
/// reached before an interruption are omitted.
pub(super) fn simulate_all<'a>(
    study: &Study,
    simulation: &Simulation,
    members: &[Member<'a>],
    options: &RunOptions<'_>,
    finished: &(dyn Fn(&Member<'_>, &Run) + Sync),
) -> Result<Simulated<'a>, StudyError> {
    let scoring = Scoring::of(study, simulation, members.iter(), members)?;
    let done = std::sync::atomic::AtomicUsize::new(0);
    let one = |member: &Member<'a>| {
        if options.interrupted() {
            return None;
        }
        let outcome = fed_back(study, members).and_then(|()| {
            trajectory::run(study, simulation, members, Some(member), Variation::NONE, options.until)
                .and_then(|trajectory| {
                    let merits = scoring.merits(study, &trajectory, member.requested)?;
                    let filter = filter::consistency((study, simulation), &trajectory, member)?;
                    let last = trajectory.x.nrows() - 1;
                    let end: Vec<f64> = trajectory.x.row(last).iter().copied().collect();
                    let left = excursion::of_simulation(study, member.requested, &trajectory)?;
                    Ok((samples(simulation, &trajectory, Some(member)), merits, filter, left, end))
                })
                .map_err(|error| why(study, &error))
        });
        let count = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
        options.tell("simulate", &member.requested.name, count, members.len());
        if let Ok((run, ..)) = &outcome {
            finished(member, run);
        }
        Some((*member, outcome))
    };
    let outcomes: Vec<_> = members.par_iter().filter_map(one).collect();
    let mut rows = Vec::new();
    let mut runs = Vec::new();
    let mut x_end = Vec::new();
    let (mut filters, mut warnings) = (Vec::new(), Vec::new());
    let mut sampled: Vec<SamplingReport> = Vec::new();
    for (member, outcome) in outcomes {
        let (observer, initial) = (member.requested.name.clone(), member.requested.initial.clone());
        match outcome {
            Ok((mut run, merits, filter, left, end)) => {
                filters.extend(filter);
                run.warnings.extend(left.map(|left| left.in_run(&observer)));
                warnings.extend(run.warnings.iter().cloned());
                sampled.extend(sampling::report(study, simulation, &member, &run.samples));
                if x_end.is_empty() {
                    x_end = end;
                }
                rows.push(RunReport { observer, initial, merits: Some(merits), failure: None });
                runs.push((member, Some(run)));
            }
            Err(failure) => {
                rows.push(RunReport { observer, initial, merits: None, failure: Some(failure) });
                runs.push((member, None));
            }
        }
    }
    let report = SimulationReport {
        duration: simulation.duration,
        x0: simulation.x0.clone(),
        x_end,
        seed: simulation.noise.as_ref().map(|noise| noise.seed),
        truth: study.truth.as_ref().map(|truth| truth.words.clone()),
        measurements: measurements(study, simulation, members),
        sampling: sampled,
        scoring: scoring.report(study),
        rows,
    };
    let intervals = runs.iter().filter_map(|(member, run)| {
        let run = run.as_ref()?;
        let (estimate, half) = (run.estimate.as_ref()?, run.half_width.as_ref()?);
        IntervalReport::of(&member.requested.name, (&run.x, estimate), half)
    });
    let intervals = intervals.collect();
    Ok(Simulated { report, runs, filters, intervals, warnings })
}

/// When outputs are measured, and what observers make of those that are not; none if all are read at all times.
fn measurements(study: &Study, simulation: &Simulation, members: &[Member<'_>]) -> Option<String> {
    let channel = study.truth.as_ref().and_then(|truth| truth.disturbances.channel.as_ref());
    if simulation.sensors.is_empty() && channel.is_none_or(|channel| channel.dropout == 0.0) {
        return None;
    }
    let unit = study.plant.time_unit.as_ref().map(|unit| format!(" {unit}")).unwrap_or_default();
    let mut words: Vec<String> = Vec::new();
    for sensor in &simulation.sensors {
        let from = if sensor.offset > 0.0 { format!(" from t = {}{unit} on", sensor.offset) } else { String::new() };
        words.push(format!("{} is measured every {}{unit}{from}.", study.plant.outputs[sensor.output], sensor.period));
    }
    let (mut filters, mut sampled, mut continuous, mut varying) = (false, false, false, false);
    for member in members {
        if member.requested.kind.varying_periods().is_some() {
            varying = true;
            continue;
        }
        match member.designed.runnable.period() {
            Some(_) if filter::is_filter(member) => filters = true,
            Some(_) => sampled = true,
            None => continuous = true,
        }
    }
    words.push("Only measurements correct the estimates.".to_owned());
    if filters {
        words.push("At a sample without a measurement a Kalman filter predicts.".to_owned());
    }
    if sampled {
        words.push(
            "At a sample without a measurement the other sampled observers take the output that they predict."
                .to_owned(),
        );
    }
    if continuous {
        words.push(
            "Observers in continuous time hold a measurement until the next one is due, and take the output that they predict where none arrives.".to_owned(),
        );
    }
    if varying {
        words.push(
            "An observer at varying periods takes the last measurement of a sensor at each of its samples; one at which no measurement arrives is missed."
                .to_owned(),
        );
    }
    Some(words.join(" "))
}

/// Checks that the observer in the feedback loop has a design.
fn fed_back(study: &Study, members: &[Member<'_>]) -> Result<(), String> {
    match fed(study) {
        Some(observer) if !members.iter().any(|member| member.requested.name == observer) => {
            Err(format!("not simulated: the observer {observer:?} in the feedback loop has no design"))
        }
        _ => Ok(()),
    }
}
