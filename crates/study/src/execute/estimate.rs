//! Estimates of the cost of an execution, to an order of magnitude: time from a short part of the run, memory from the
//! sizes.

use std::time::Instant;

use super::{Step, sweep};
use crate::limits::{Excess, Limits};
use crate::signal::Input;
use crate::study::{NUMBER, ObserverSpec, Simulation, Study};
use crate::trajectory::{self, Variation};

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
    let each_design: f64 = study.observers.iter().map(|requested| requested.kind.seconds(study)).sum();
    let n = study.plant.states.len() as f64;
    let observed = if matches!(step, Step::Observe | Step::Run) { 1e-7 * n * n * n } else { 0.0 };
    let designs =
        observed + if step == Step::Observe { 0.0 } else { each_design + 0.01 * study.observers.len() as f64 };
    let own = match step {
        Step::Simulate | Step::Compare | Step::Run => study.observers.len(),
        Step::Sweep => 1,
        Step::Observe | Step::Design | Step::Certify => 0,
    };
    let swept = match (&study.sweep, step) {
        (Some(sweep), Step::Sweep | Step::Run) => sweep::runs(study, sweep),
        _ => 0,
    };
    let again = match &study.sweep {
        Some(sweep) if swept > 0 && sweep.parameter.redesigns() => each_design * sweep.values.len() as f64,
        _ => 0.0,
    };
    let memory = memory(study, step, threads);
    let simulated = study.simulation.as_ref().filter(|_| own + swept > 0);
    let (each, written) = simulated.map_or((0.0, 0.0), |s| (one_run(study, s), writing(study, s)));
    let runs = own + swept;
    // Of the runs of a sweep only the scores are written.
    let running = each * runs as f64 + if step == Step::Sweep { 0.0 } else { written * own as f64 };
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
    if let (Some(sweep), Step::Sweep | Step::Run) = (&study.sweep, step) {
        parts.push((sweep::memory(study, sweep), "the percentiles of the sweep"));
    }
    let bytes = parts.iter().map(|part| part.0).sum();
    let mostly = parts.into_iter().max_by(|x, y| x.0.total_cmp(&y.0)).map_or("", |part| part.1);
    MemoryEstimate { bytes, mostly }
}

/// Seconds of one run with an observer.
fn one_run(study: &Study, simulation: &Simulation) -> f64 {
    const SHARE: f64 = 0.02;
    // An observer costs about as much as the plant, and its transient about as much again.
    const WITH_OBSERVER: f64 = 4.0;
    // The first is slower than those that follow, and the machine may be busy.
    const REPETITIONS: usize = 5;
    let mut short = simulation.clone();
    short.duration *= SHARE;
    short.samples = 2;
    let input = match &study.input {
        law @ Input::Law { .. } => law.clone(),
        other => other.program().cloned().map_or(Input::Zero, Input::Program),
    };
    let plant = Study { input, ..study.clone() };
    let once = || {
        let began = Instant::now();
        // A plant that cannot be simulated is estimated as zero; the run itself reports the error.
        let _ = trajectory::run(&plant, &short, &[], None, Variation::NONE, None);
        began.elapsed().as_secs_f64()
    };
    let least = (0..REPETITIONS).map(|_| once()).fold(f64::INFINITY, f64::min);
    // Filters step with their own period, independent of the integrator.
    let step = |requested: &ObserverSpec| requested.kind.seconds_of_steps(simulation.duration);
    least / SHARE * WITH_OBSERVER + study.observers.iter().map(step).fold(0.0, f64::max)
}

/// Seconds to write and draw one run.
fn writing(study: &Study, simulation: &Simulation) -> f64 {
    // Of a number as text.
    const EACH: f64 = 3e-7;
    let size = study.plant.model.size();
    simulation.samples as f64 * (1 + 2 * size.states + size.inputs + size.outputs) as f64 * EACH
}
