//! Estimates of the cost of an execution: time from short parts of the runs, memory from the sizes.
//!
//! A study of seconds is estimated by its plant and by the operations of its observers, to an order of magnitude. Where
//! that says more, each observer whose design is quick is run over a part of the simulation or of the log.

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use luenberger_clock::Instant;
use luenberger_sim::replay::Recording;
use luenberger_sim::{SampleInterpolation, Samples, SimError};
use nalgebra::DMatrix;

use super::{Step, log, sweep};
use crate::design::{Designed, attempt};
use crate::limits::{Excess, Limits};
use crate::signal::Input;
use crate::study::{Log, NUMBER, ObserverSpec, Simulation, Study};
use crate::trajectory::{self, Member, Variation};

/// Estimated cost of an execution.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Number of runs of the plant.
    pub runs: usize,
    /// Seconds on one thread, to an order of magnitude.
    pub seconds: f64,
    /// The step that takes most of the time.
    pub mostly: String,
    /// The largest amount of memory in use.
    pub memory: MemoryEstimate,
}

/// Estimated memory of an execution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MemoryEstimate {
    /// Bytes.
    pub bytes: f64,
    /// What takes most of it, and how to reduce it.
    pub mostly: &'static str,
}

impl Estimate {
    /// An error if the time on `threads` threads exceeds its limit; the memory is checked by
    /// [`execute`](super::execute).
    ///
    /// # Errors
    /// [`Excess::Time`].
    pub fn within(&self, limits: &Limits, threads: usize) -> Result<(), Excess> {
        let needed = self.seconds / threads as f64;
        if needed > limits.seconds {
            return Err(Excess::Time { needed, limit: limits.seconds, mostly: self.mostly.clone() });
        }
        Ok(())
    }
}

impl MemoryEstimate {
    pub(super) fn within(self, limits: &Limits) -> Result<(), crate::StudyError> {
        if self.bytes > limits.memory {
            let excess = Excess::Memory { needed: self.bytes, limit: limits.memory, mostly: self.mostly };
            return Err(crate::StudyError::TooExpensive(excess));
        }
        Ok(())
    }
}

/// Bytes of a number as text, with all digits.
const DIGITS: f64 = 22.0;

/// Estimated cost of a step, from a simulation of one fiftieth of the duration.
pub fn estimate(study: &Study, step: Step, threads: usize) -> Estimate {
    estimated(study, step, threads, true)
}

/// The same from the plant alone, and coarser: no observer is run, so that an editor can ask for it after each change
/// of a study.
pub fn estimate_roughly(study: &Study, step: Step, threads: usize) -> Estimate {
    estimated(study, step, threads, false)
}

fn estimated(study: &Study, step: Step, threads: usize, closely: bool) -> Estimate {
    let each_design: f64 = study.observers.iter().map(|requested| requested.kind.seconds(study)).sum();
    let n = study.plant.states.len() as f64;
    let observed = if matches!(step, Step::Observe | Step::Run) { 1e-7 * n * n * n } else { 0.0 };
    let designs =
        observed + if step == Step::Observe { 0.0 } else { each_design + 0.01 * study.observers.len() as f64 };
    let own = match step {
        Step::Simulate | Step::Compare | Step::Run => study.observers.len(),
        Step::Sweep => usize::from(study.sweep.as_ref().is_none_or(|sweep| !sweep.on_log)),
        Step::Observe | Step::Design | Step::Certify => 0,
    };
    let swept = match (&study.sweep, step) {
        (Some(sweep), Step::Sweep | Step::Run) => sweep::simulated(study, sweep),
        _ => 0,
    };
    // How often all observers run on the log.
    let swept_on_log = match (&study.sweep, step) {
        (Some(sweep), Step::Sweep | Step::Run) if sweep.on_log => sweep.values.len(),
        _ => 0,
    };
    let again = match &study.sweep {
        Some(sweep) if swept + swept_on_log > 0 && sweep.parameter.redesigns() => {
            each_design * sweep.values.len() as f64
        }
        _ => 0.0,
    };
    let memory = memory(study, step, threads);
    let simulated = study.simulation.as_ref().filter(|_| own + swept > 0);
    let on_log = usize::from(matches!(step, Step::Simulate | Step::Compare | Step::Run)) + swept_on_log;
    let of_log = study.log.as_ref().filter(|_| on_log > 0);
    let runs = simulated.map_or(0, |_| own + swept) + of_log.map_or(0, |_| on_log * study.observers.len());
    // Of the runs of a sweep only the scores are written.
    let is_written = step != Step::Sweep;
    let running = simulated.map_or(0.0, |simulation| {
        let written = if is_written { writing(study, simulation.samples) } else { 0.0 };
        each_run(study, simulation, own + swept, closely) * (own + swept) as f64 + written * own as f64
    });
    let running = running + of_log.map_or(0.0, |log| on_log as f64 * all_on_log(study, log, closely));
    let mostly = if running > designs + again { "simulations" } else { "designs" };
    Estimate { runs, seconds: designs + again + running, mostly: mostly.to_owned(), memory }
}

/// Estimated memory of a step.
pub(super) fn memory(study: &Study, step: Step, threads: usize) -> MemoryEstimate {
    // Matrices of the order of the plant, in all steps.
    const MATRICES: f64 = 60.0;
    let n = study.plant.states.len() as f64;
    let mut parts = vec![(MATRICES * NUMBER * n * n, "matrices of the order of the plant")];
    if step != Step::Observe {
        parts.extend(study.observers.iter().map(|requested| requested.kind.memory(study)));
    }
    if let Some(simulation) = &study.simulation
        && matches!(step, Step::Simulate | Step::Compare | Step::Run | Step::Sweep)
    {
        let (n, m, p) = (study.plant.states.len(), study.plant.inputs.len(), study.plant.outputs.len());
        let (samples, columns) = (simulation.samples as f64, (1 + 2 * n + m + p) as f64);
        let observers = study.observers.len().max(1) as f64;
        let kept = if step == Step::Sweep { 0.0 } else { observers * samples * columns * NUMBER };
        // In progress: the trajectory with its integrals, the table, and the file as text.
        let text = if step == Step::Sweep { 0.0 } else { NUMBER + DIGITS };
        let active = observers.min(threads as f64).max(if study.sweep.is_some() { threads as f64 } else { 1.0 });
        let running = active * samples * ((columns + n as f64 + 1.0) * NUMBER + columns * text);
        parts.push((kept + running, "the trajectories (reduce simulation.samples)"));
    }
    if let (Some(log), Step::Simulate | Step::Compare | Step::Run) = (&study.log, step) {
        parts.push((of_log(study, log, threads), "the estimates on the log (a part of it, or fewer observers)"));
    }
    if let (Some(sweep), Step::Sweep | Step::Run) = (&study.sweep, step) {
        parts.push((sweep::memory(study, sweep), "the percentiles of the sweep"));
    }
    let bytes = parts.iter().map(|part| part.0).sum();
    let mostly = parts.into_iter().max_by(|x, y| x.0.total_cmp(&y.0)).map_or("", |part| part.1);
    MemoryEstimate { bytes, mostly }
}

/// Bytes for the log and the runs of its observers: what is shown of each, and what is recorded of those in progress.
fn of_log(study: &Study, log: &Log, threads: usize) -> f64 {
    let (n, m, p) =
        (study.plant.states.len() as f64, study.plant.inputs.len() as f64, study.plant.outputs.len() as f64);
    let observers = study.observers.len() as f64;
    let own = |requested: &ObserverSpec| {
        let covariances = if log.estimates == luenberger_sim::Estimates::Predicted { 2.0 } else { 1.0 };
        let all = if log.truth.is_some() || requested.kind.smooths() { covariances } else { 0.0 };
        let smoothed = if requested.kind.smooths() { 4.0 * n * n + 5.0 * n } else { 0.0 };
        all * n * n + smoothed
    };
    let recorded = study.observers.iter().map(own).fold(0.0, f64::max) + 4.0 * n + 5.0 * p + 9.0;
    let kept = 1.0 + 3.0 * n + m + 2.0 * p;
    let active = observers.min(threads as f64);
    log.recording.times().len() as f64 * NUMBER * (2.0 * (2.0 + m + p) + observers * kept + active * (recorded + kept))
}

/// An estimate of so many seconds is looked at more closely.
const CLOSELY: f64 = 2.0;

/// No observer is looked at for longer.
const LOOK: Duration = Duration::from_millis(500);

/// A design of so many seconds is quick.
const QUICK: f64 = 0.05;

/// A design that is quick.
fn quick(study: &Study, requested: &ObserverSpec) -> Option<Designed> {
    let is_quick = requested.kind.seconds(study) < QUICK;
    is_quick.then(|| attempt(study, requested, &AtomicBool::new(false), Some(Instant::now() + LOOK)).ok()).flatten()
}

/// Mean seconds of one of so many runs with an observer.
fn each_run(study: &Study, simulation: &Simulation, runs: usize, closely: bool) -> f64 {
    // An observer costs about as much as the plant, and its transient about as much again.
    const WITH_OBSERVER: f64 = 4.0;
    let alone = of_plant(study, simulation);
    // Filters step with their own period, independent of the integrator.
    let counted =
        |requested: &ObserverSpec| alone * WITH_OBSERVER + requested.kind.seconds_of_steps(simulation.duration);
    let count = study.observers.len().max(1) as f64;
    let roughly = study.observers.iter().map(counted).sum::<f64>() / count;
    if !closely || roughly * runs as f64 <= CLOSELY || trajectory::fed(study).is_some() {
        return roughly;
    }
    let one = |requested: &ObserverSpec| measured(study, simulation, requested).unwrap_or_else(|| counted(requested));
    study.observers.iter().map(one).sum::<f64>() / count
}

/// Seconds of a run with an observer, from a part of it.
fn measured(study: &Study, simulation: &Simulation, requested: &ObserverSpec) -> Option<f64> {
    // Long enough for the window of an estimator to fill.
    const PERIODS: f64 = 60.0;
    let designed = quick(study, requested)?;
    let member = Member { requested, designed: &designed };
    let period = requested.kind.period().unwrap_or(0.0);
    let duration = (SHARE * simulation.duration).max(PERIODS * period).min(simulation.duration);
    let short = Simulation { duration, samples: 2, ..simulation.clone() };
    let began = Instant::now();
    let run = trajectory::run(study, &short, &[member], Some(&member), Variation::NONE, Some(began + LOOK));
    let seconds = began.elapsed().as_secs_f64();
    match run {
        Ok(_) => Some(seconds * simulation.duration / duration),
        Err(SimError::TimeLimit { time }) if time > 0.0 => Some(seconds * simulation.duration / time),
        // The run itself says why.
        Err(_) => None,
    }
}

/// Seconds of all observers on a log, with their tables.
fn all_on_log(study: &Study, log: &Log, closely: bool) -> f64 {
    // Of a row, without knowing the observer.
    const ROW: f64 = 1e-5;
    const ROWS: usize = 2000;
    let rows = log.recording.times().len();
    let roughly = |requested: &ObserverSpec| {
        let times = log.recording.times();
        let span = times[rows - 1] - times[0];
        ROW * rows as f64 + requested.kind.seconds_of_steps(span)
    };
    let written = writing(study, rows) * study.observers.len() as f64;
    let sum: f64 = study.observers.iter().map(roughly).sum();
    if !closely || rows <= ROWS || sum <= CLOSELY {
        return sum + written;
    }
    let Some(first) = first_rows(log, ROWS) else { return sum + written };
    let one = |requested: &ObserverSpec| {
        let designed = quick(study, requested)?;
        let began = Instant::now();
        let run = log::replay_one(study, &first, &Member { requested, designed: &designed }, Some(began + LOOK));
        let seconds = began.elapsed().as_secs_f64();
        let times = log.recording.times();
        let done = match run {
            Ok(_) => ROWS,
            Err(SimError::TimeLimit { time }) => times.partition_point(|t| *t <= time).max(1),
            Err(_) => return None,
        };
        Some(seconds * rows as f64 / done as f64)
    };
    study.observers.iter().map(|requested| one(requested).unwrap_or_else(|| roughly(requested))).sum::<f64>() + written
}

/// The first rows of a log.
fn first_rows(log: &Log, rows: usize) -> Option<Log> {
    let of = |samples: &Samples| DMatrix::from_fn(rows, samples.values().ncols(), |k, j| samples.value(k, j));
    let recording = &log.recording;
    let times = recording.times()[..rows].to_vec();
    let short = Recording::with_missing(times, &of(recording.inputs()), &of(recording.outputs())).ok()?;
    let short = short.between(SampleInterpolation::ZeroOrderHold, recording.outputs_between());
    Some(Log {
        recording: short,
        truth: None,
        variances: None,
        suspicions: Vec::new(),
        columns: log.columns.clone(),
        ..*log
    })
}

/// The part of a run that is measured.
const SHARE: f64 = 0.02;

/// Seconds of one run of the plant.
fn of_plant(study: &Study, simulation: &Simulation) -> f64 {
    // The first is slower than those that follow, and the machine may be busy.
    const REPETITIONS: usize = 5;
    let mut short = simulation.clone();
    short.duration *= SHARE;
    short.samples = 2;
    let input = match &study.input {
        law @ Input::Law { .. } => law.clone(),
        other => other.program().cloned().map_or(Input::Zero, Input::Program),
    };
    let plant = Study { input, log: None, ..study.clone() };
    let once = || {
        let began = Instant::now();
        // A plant that cannot be simulated is estimated as zero; the run itself reports the error.
        let _ = trajectory::run(&plant, &short, &[], None, Variation::NONE, None);
        began.elapsed().as_secs_f64()
    };
    (0..REPETITIONS).map(|_| once()).fold(f64::INFINITY, f64::min) / SHARE
}

/// Seconds to write and draw a run with so many rows.
fn writing(study: &Study, rows: usize) -> f64 {
    // Of a number as text.
    const EACH: f64 = 3e-7;
    let size = study.plant.model.size();
    rows as f64 * (1 + 2 * size.states + size.inputs + size.outputs) as f64 * EACH
}
