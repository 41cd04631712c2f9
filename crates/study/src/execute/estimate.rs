//! Estimate of the cost of an execution, to an order of magnitude, from a short part of the run.

use std::time::Instant;

use super::simulate::{self, Variation};
use super::{Step, sweep};
use crate::signal::Input;
use crate::study::{ObserverKind, Simulation, Study};

/// Estimated cost of an execution.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Number of runs of the plant.
    pub runs: usize,
    /// Seconds on one thread, to an order of magnitude.
    pub seconds: f64,
    /// The step that takes most of the time.
    pub mostly: String,
}

/// Seconds for one value of T by simulation: a trajectory over the memory of the filter with tolerance 1e-11.
const ONE_T: f64 = 2e-3;

/// Number of values of T that a design needs besides its table: validation points, and pairs tested for
/// indistinguishability.
const BESIDES: f64 = 2000.0;

/// Estimated cost of a step, from a simulation of one fiftieth of the duration.
pub fn estimate(study: &Study, step: Step) -> Estimate {
    let tables: f64 = study
        .observers
        .iter()
        .map(|wish| match &wish.kind {
            ObserverKind::KklNumerical(kkl) => {
                ((kkl.points as f64).powf(study.plant.states.len() as f64) + BESIDES) * ONE_T
                    + kkl.samples as f64 * 1e-5
            }
            _ => 0.0,
        })
        .sum();
    let designs = if step == Step::Observe { 0.0 } else { tables + 0.01 * study.observers.len() as f64 };
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
        Some(sweep) if swept > 0 && matches!(sweep.parameter.name(), "gamma" | "poles") => {
            tables * sweep.values.len() as f64
        }
        _ => 0.0,
    };
    let each = study.simulation.as_ref().map_or(0.0, |simulation| one_run(study, simulation));
    let runs = own + swept;
    let running = each * runs as f64;
    let mostly = if running > designs + again { "runs" } else { "designs" };
    Estimate { runs, seconds: designs + again + running, mostly: mostly.to_owned() }
}

/// Seconds of one run with an observer.
fn one_run(study: &Study, simulation: &Simulation) -> f64 {
    const SHARE: f64 = 0.02;
    // An observer costs about as much as the plant, and its transient about as much again.
    const WITH_OBSERVER: f64 = 4.0;
    let mut short = simulation.clone();
    short.duration *= SHARE;
    short.samples = 2;
    let plant = Study { input: study.input.program().cloned().map_or(Input::Zero, Input::Program), ..study.clone() };
    let began = Instant::now();
    // A plant that cannot be simulated is estimated as zero; the run itself reports the error.
    let _ = simulate::trajectory(&plant, &short, &[], None, Variation::NONE);
    let plant = began.elapsed().as_secs_f64() / SHARE * WITH_OBSERVER;
    // Filters step with their own period, independent of the integrator.
    let step = |wish: &crate::study::ObserverSpec| match &wish.kind {
        ObserverKind::ExtendedKalman { period, substeps, w, .. } => {
            let n = w.nrows() as f64;
            simulation.duration / period * *substeps as f64 * 4.0 * n * n * n * 4e-9
        }
        _ => 0.0,
    };
    plant + study.observers.iter().map(step).fold(0.0, f64::max)
}
