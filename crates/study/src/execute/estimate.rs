//! What an execution will cost, before it begins: an order of magnitude, from a short piece of the run.

use std::time::Instant;

use super::simulate::{self, Variation};
use super::{Step, sweep};
use crate::signal::Input;
use crate::study::{ObserverKind, Simulation, Study};

/// What an execution will cost.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// How many runs of the plant it has.
    pub runs: usize,
    /// Seconds on one thread, to an order of magnitude.
    pub seconds: f64,
    /// What most of them are spent on.
    pub mostly: String,
}

/// One value of T by simulation, in seconds: a trajectory over the memory of the filter at 1e-11.
const ONE_T: f64 = 2e-3;

/// Values of T that a design needs besides its table: held-out points, and pairs that y might not tell apart.
const BESIDES: f64 = 2000.0;

/// What a step will cost. Runs the plant over a fiftieth of the duration to find out.
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
    // An observer has about the cost of the plant, and its transient that of the plant again.
    const WITH_OBSERVER: f64 = 4.0;
    let mut short = simulation.clone();
    short.duration *= SHARE;
    short.samples = 2;
    let plant = Study { input: study.input.program().cloned().map_or(Input::Zero, Input::Program), ..study.clone() };
    let began = Instant::now();
    // A plant that cannot be run costs nothing; the run itself will say why.
    let _ = simulate::trajectory(&plant, &short, &[], None, Variation::NONE);
    let plant = began.elapsed().as_secs_f64() / SHARE * WITH_OBSERVER;
    // Filters step at their own period, whatever the integrator does.
    let step = |wish: &crate::study::ObserverSpec| match &wish.kind {
        ObserverKind::ExtendedKalman { period, substeps, w, .. } => {
            let n = w.nrows() as f64;
            simulation.duration / period * *substeps as f64 * 4.0 * n * n * n * 4e-9
        }
        _ => 0.0,
    };
    plant + study.observers.iter().map(step).fold(0.0, f64::max)
}
