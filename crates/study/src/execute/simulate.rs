//! Simulations: each observer in its own run, so that a diverging one affects only its own row of the table.
//!
//! With feedback, the observer in the loop is part of every run, so that all see the same plant trajectory.
//!
//! The rows of a run are equally spaced times; those of a run with a sampled observer are at its samples, where its
//! estimate is defined.

use std::time::Instant;

use luenberger_sim::{Change, SampleTime, Scenario, Settings, SimError, Trajectory, row_times};
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::options::RunOptions;
use super::scores::Scoring;
use super::stopped::why;
use super::{Member, excursion, filter, sampling};
use crate::error::StudyError;
use crate::results::{FilterReport, IntervalReport, ObserverRun, RunReport, SamplingReport, SimulationReport};
use crate::signal::Input;
use crate::study::{SamplingSpec, Simulation, Study};

/// Deviation from the study's own run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Variation {
    /// Factor of the noise amplitude.
    pub(super) noise: f64,
    /// Number added to the seed.
    pub(super) seed: u64,
}

impl Variation {
    pub(super) const NONE: Self = Self { noise: 1.0, seed: 0 };
}

/// Result of a run: one row for each time.
pub(super) struct Run {
    pub(super) t: Vec<f64>,
    pub(super) x: DMatrix<f64>,
    pub(super) u: DMatrix<f64>,
    /// The measured outputs, with noise.
    pub(super) y: DMatrix<f64>,
    /// The estimates of the observer; none for the plant alone.
    pub(super) estimate: Option<DMatrix<f64>>,
    /// `y - h(xhat)` as the observer had it, on a log; NaN where nothing was measured.
    pub(super) innovation: Option<DMatrix<f64>>,
    /// The standard deviations of the estimates, of a filter; those of a stationary one are constant.
    pub(super) deviation: Option<DMatrix<f64>>,
    /// The half-widths of the bounds, of an interval observer.
    pub(super) half_width: Option<DMatrix<f64>>,
    /// The smoothed estimates with their standard deviations, of a filter on a log.
    pub(super) smoothed: Option<(DMatrix<f64>, DMatrix<f64>)>,
    /// Functions of the state and their estimates with their names, of an observer of functions.
    pub(super) functions: Option<(Vec<String>, DMatrix<f64>, DMatrix<f64>)>,
    /// The estimates of disturbances with their names, of an observer that has some; none on a log.
    pub(super) disturbance: Option<(Vec<String>, DMatrix<f64>)>,
    /// The samples of an observer at varying periods; none on a log.
    pub(super) samples: Vec<SampleTime>,
}

impl Run {
    /// As the results have it.
    pub(super) fn named(self, observer: &str, on_log: bool) -> ObserverRun {
        let Self { t, x, u, y, estimate, deviation, functions, .. } = self;
        let estimate = estimate.or(functions.map(|(_, _, estimate)| estimate));
        ObserverRun { observer: observer.to_owned(), on_log, t, x, u, y, estimate, deviation }
    }
}

/// The runs that finished, as the results have them.
pub(super) fn named(runs: Vec<Outcome<'_>>, on_log: bool) -> impl Iterator<Item = ObserverRun> + use<'_> {
    runs.into_iter().filter_map(move |(member, run)| Some(run?.named(&member.wish.name, on_log)))
}

/// The observer in the feedback loop.
pub(super) fn fed(study: &Study) -> Option<&str> {
    match &study.input {
        Input::Feedback { observer, .. } => Some(observer),
        _ => None,
    }
}

/// The rows of a run, and its end if that is no row.
fn times(simulation: &Simulation, period: Option<f64>) -> (Vec<f64>, Option<f64>) {
    row_times(simulation.duration, simulation.samples, period)
}

/// One run, with the observer `member` and the one in the feedback loop, until the instant `until` at most.
pub(super) fn trajectory(
    study: &Study,
    simulation: &Simulation,
    members: &[Member<'_>],
    member: Option<&Member<'_>>,
    variation: Variation,
    until: Option<Instant>,
) -> Result<Trajectory, SimError> {
    let (mut wanted, end) = times(simulation, member.and_then(|member| member.designed.runnable.period()));
    wanted.extend(end);
    let settings = Settings { end: until, ..simulation.settings };
    trajectory_at(study, &Simulation { settings, ..simulation.clone() }, members, member, variation, &wanted)
}

/// The same with rows at the given times.
pub(super) fn trajectory_at(
    study: &Study,
    simulation: &Simulation,
    members: &[Member<'_>],
    member: Option<&Member<'_>>,
    variation: Variation,
    times: &[f64],
) -> Result<Trajectory, SimError> {
    let truth = study.truth.as_ref();
    let simulated = truth.and_then(|truth| truth.plant.as_ref()).map_or(&study.plant.model, |other| &other.model);
    let mut scenario = Scenario::new(simulated)
        .model(&study.plant.model)
        .initial_state(&simulation.x0)
        .times(times)
        .settings(simulation.settings)
        .input(study.input.signal_at(study.operating_point.as_ref()))
        .breakpoints(&study.input.breakpoints(0.0, simulation.duration));
    if let Some(period) = simulation.hold {
        scenario = scenario.hold_input(period);
    }
    if let Some(truth) = truth {
        scenario = scenario.disturbances(truth.disturbances.reseeded(variation.seed));
        // One after the end of the run is not reached.
        for event in truth.events.iter().filter(|event| event.at <= simulation.duration) {
            let mut change = Change::at(event.at);
            if let Some(other) = &event.plant {
                change = change.plant(&other.model);
            }
            if !event.jump.is_empty() {
                change = change.jump(&event.jump);
            }
            scenario = scenario.change(change);
        }
    }
    if let Some(dt) = study.plant.dt {
        scenario = scenario.discrete_time(dt);
    }
    if let Some(noise) = &simulation.noise {
        scenario = scenario.noise(noise.noise(variation.noise, noise.seed.wrapping_add(variation.seed)));
    }
    for sensor in &simulation.sensors {
        scenario = scenario.sensor(sensor.sensor(variation.noise, variation.seed));
    }
    let sampling = SamplingSpec { seed: simulation.sampling.seed.wrapping_add(variation.seed), ..simulation.sampling };
    let name = member.map(|member| member.wish.name.as_str());
    if let Some(observer) = fed(study).filter(|observer| Some(*observer) != name)
        && let Some(fed) = members.iter().find(|fed| fed.wish.name == observer)
    {
        scenario = fed.designed.runnable.join_sampled(scenario, &fed.wish.name, &fed.wish.initial, &sampling);
    }
    if let Some(member) = member {
        let name = &member.wish.name;
        scenario = member.designed.runnable.join_sampled(scenario, name, &member.wish.initial, &sampling);
    }
    scenario.run()
}

/// The rows of a run, with the measured outputs.
pub(super) fn samples(simulation: &Simulation, trajectory: &Trajectory, member: Option<&Member<'_>>) -> Run {
    let (wanted, _) = times(simulation, member.and_then(|member| member.designed.runnable.period()));
    let rows = wanted.len();
    let of = |matrix: &DMatrix<f64>| matrix.rows(0, rows).into_owned();
    let mut estimate = member.and_then(|member| trajectory.observer(&member.wish.name).ok()).map(|o| of(&o.estimate));
    let deviation = member.and_then(|member| match filter::deviation(trajectory, member) {
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
        let states = &trajectory.observer(&member.wish.name).ok()?.state;
        let found = member.designed.runnable.disturbance(states)?;
        Some((member.wish.kind.estimated_disturbances(), of(&found)))
    });
    let half_width = member.and_then(|member| {
        let states = &trajectory.observer(&member.wish.name).ok()?.state;
        member.designed.runnable.half_widths(states).map(|found| of(&found))
    });
    let functions = member.and_then(|member| {
        let (k, names) = member.wish.kind.functions()?;
        Some((names, &x * k.transpose(), estimate.take()?))
    });
    let (innovation, smoothed) = (None, None);
    let samples = member.and_then(|member| trajectory.observer(&member.wish.name).ok());
    let samples = samples.map(|observer| observer.samples.clone()).unwrap_or_default();
    Run { t: wanted, x, u, y, estimate, innovation, deviation, half_width, functions, disturbance, smoothed, samples }
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
pub(super) fn all<'a>(
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
            trajectory(study, simulation, members, Some(member), Variation::NONE, options.until)
                .and_then(|trajectory| {
                    let merits = scoring.merits(study, &trajectory, member.wish)?;
                    let filter = filter::consistency(simulation, &trajectory, member)?;
                    let last = trajectory.x.nrows() - 1;
                    let end: Vec<f64> = trajectory.x.row(last).iter().copied().collect();
                    let left = excursion::of_simulation(study, member.wish, &trajectory)?;
                    Ok((samples(simulation, &trajectory, Some(member)), merits, filter, left, end))
                })
                .map_err(|error| why(study, &error))
        });
        let count = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
        options.tell("simulate", &member.wish.name, count, members.len());
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
        let observer = member.wish.name.clone();
        match outcome {
            Ok((run, merits, filter, left, end)) => {
                filters.extend(filter);
                warnings.extend(left.map(|left| left.in_run(&observer)));
                sampled.extend(sampling::report(study, simulation, &member, &run.samples));
                if x_end.is_empty() {
                    x_end = end;
                }
                rows.push(RunReport { observer, merits: Some(merits), failure: None });
                runs.push((member, Some(run)));
            }
            Err(failure) => {
                rows.push(RunReport { observer, merits: None, failure: Some(failure) });
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
        IntervalReport::of(&member.wish.name, (&run.x, estimate), half)
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
        if member.wish.kind.varying_periods().is_some() {
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
        Some(observer) if !members.iter().any(|member| member.wish.name == observer) => {
            Err(format!("not simulated: the observer {observer:?} in the feedback loop has no design"))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_a_sampled_observer_are_samples() {
        let study = crate::Study::from_text(
            "t.toml",
            "[plant]\na = [[-1]]\nc = [[1]]\n[simulation]\nx0 = [1]\nduration = 1\nsamples = 6\n",
            crate::Format::Toml,
            ".".as_ref(),
        )
        .unwrap();
        let simulation = study.simulation.unwrap();
        let near = |period, wished: &[f64], end| {
            let (times, rest) = times(&simulation, period);
            assert!(times.len() == wished.len() && times.iter().zip(wished).all(|(a, b)| (a - b).abs() < 1e-12));
            assert_eq!(rest, end);
        };
        near(None, &[0.0, 0.2, 0.4, 0.6, 0.8, 1.0], None);
        near(Some(0.1), &[0.0, 0.2, 0.4, 0.6, 0.8, 1.0], None);
        // Eight samples, every second of them; the run goes on to its end.
        near(Some(0.13), &[0.0, 0.26, 0.52, 0.78], Some(1.0));
        near(Some(0.3), &[0.0, 0.3, 0.6, 0.9], Some(1.0));
        near(Some(2.0), &[0.0], Some(1.0));
    }
}
