//! Simulations: each observer in its own run, so that a diverging one affects only its own row of the table.
//!
//! With feedback, the observer in the loop is part of every run, so that all see the same plant trajectory.

use luenberger_sim::{Integrand, Merits, Scenario, SimError, Trajectory};
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::options::RunOptions;
use super::{Member, filter};
use crate::results::{FilterReport, MeritsReport, RunReport, SimulationReport};
use crate::signal::Input;
use crate::study::{Simulation, Study};

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
    /// The standard deviations of the estimates, of a filter.
    pub(super) deviation: Option<DMatrix<f64>>,
}

/// The observer in the feedback loop.
pub(super) fn fed(study: &Study) -> Option<&str> {
    match &study.input {
        Input::Feedback { observer, .. } => Some(observer),
        _ => None,
    }
}

/// One run, with the observer `member` and the one in the feedback loop.
pub(super) fn trajectory(
    study: &Study,
    simulation: &Simulation,
    members: &[Member<'_>],
    member: Option<&Member<'_>>,
    variation: Variation,
) -> Result<Trajectory, SimError> {
    let mut scenario = Scenario::new(&study.plant.model)
        .initial_state(&simulation.x0)
        .until(simulation.duration, simulation.samples)
        .settings(simulation.settings)
        .input(study.input.signal())
        .breakpoints(&study.input.breakpoints(0.0, simulation.duration));
    if let Some(period) = simulation.hold {
        scenario = scenario.hold_input(period);
    }
    if let Some(noise) = &simulation.noise {
        scenario = scenario.noise(noise.noise(variation.noise, noise.seed.wrapping_add(variation.seed)));
    }
    let name = member.map(|member| member.wish.name.as_str());
    if let Some(observer) = fed(study).filter(|observer| Some(*observer) != name)
        && let Some(fed) = members.iter().find(|fed| fed.wish.name == observer)
    {
        scenario = fed.designed.runnable.join(scenario, &fed.wish.name, &fed.wish.initial);
    }
    if let Some(member) = member {
        let name = &member.wish.name;
        scenario = member.designed.runnable.join(scenario, name, &member.wish.initial);
        scenario = scenario.integral("e^2", Integrand::squared_error(name));
        for i in 0..study.plant.states.len() {
            scenario = scenario.integral(&format!("e{}^2", i + 1), Integrand::squared_error_of(name, i));
        }
    }
    scenario.run()
}

/// The initial error, |x(0) - xhat(0)|.
pub(super) fn initial_error(simulation: &Simulation, initial: &[f64]) -> f64 {
    simulation.x0.iter().zip(initial).map(|(x, xhat)| (x - xhat).powi(2)).sum::<f64>().sqrt()
}

pub(super) fn merits(
    study: &Study,
    simulation: &Simulation,
    trajectory: &Trajectory,
    member: &Member<'_>,
) -> Result<MeritsReport, SimError> {
    let initial = initial_error(simulation, &member.wish.initial);
    let band = simulation.band * initial;
    let merits = Merits::of(trajectory, &member.wish.name, simulation.band)?;
    let by_state = (0..study.plant.states.len()).map(|i| {
        let square = trajectory.integral(&format!("e{}^2", i + 1))?.last().copied().unwrap_or(0.0);
        Ok((square.max(0.0) / simulation.duration).sqrt())
    });
    Ok(MeritsReport {
        initial,
        band,
        settling_first: merits.settling_first,
        settling_last: merits.settling_last,
        peak: merits.peak,
        rms: merits.rms,
        last: merits.last,
        rms_by_state: by_state.collect::<Result<_, SimError>>()?,
    })
}

/// The samples of a run, with the measured outputs.
pub(super) fn samples(simulation: &Simulation, trajectory: &Trajectory, member: Option<&Member<'_>>) -> Run {
    let mut y = trajectory.y.clone();
    if let Some(wish) = &simulation.noise {
        let noise = wish.noise(1.0, wish.seed);
        for (row, t) in trajectory.t.iter().enumerate() {
            // A time that is a multiple of the period up to rounding belongs to the period that begins there.
            let period = (t / wish.period * (1.0 + 4.0 * f64::EPSILON)).floor() as u64;
            for (column, value) in noise.sample(period).into_iter().enumerate() {
                y[(row, column)] += value;
            }
        }
    }
    let estimate = member.and_then(|member| trajectory.observer(&member.wish.name).ok()).map(|o| o.estimate.clone());
    let deviation = member.and_then(|member| filter::deviation(trajectory, member));
    let (t, x, u) = (trajectory.t.clone(), trajectory.x.clone(), trajectory.u.clone());
    Run { t, x, u, y, estimate, innovation: None, deviation }
}

/// A run with its observer, or the error that ended it.
pub(super) type Outcome<'a> = (Member<'a>, Result<Run, SimError>);

/// All runs, in the order of the observers. `finished` is called for each run that ends, from any thread. Observers not
/// reached before an interruption are omitted.
pub(super) fn all<'a>(
    study: &Study,
    simulation: &Simulation,
    members: &[Member<'a>],
    options: &RunOptions<'_>,
    finished: &(dyn Fn(&Member<'_>, &Run) + Sync),
) -> (SimulationReport, Vec<Outcome<'a>>, Vec<FilterReport>) {
    let done = std::sync::atomic::AtomicUsize::new(0);
    let one = |member: &Member<'a>| {
        if options.interrupted() {
            return None;
        }
        let outcome = fed_back(study, members).and_then(|()| {
            trajectory(study, simulation, members, Some(member), Variation::NONE).and_then(|trajectory| {
                let merits = merits(study, simulation, &trajectory, member)?;
                let filter = filter::consistency(study, simulation, &trajectory, member)?;
                Ok((samples(simulation, &trajectory, Some(member)), merits, filter))
            })
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
    let mut filters = Vec::new();
    for (member, outcome) in outcomes {
        let observer = member.wish.name.clone();
        match outcome {
            Ok((run, merits, filter)) => {
                filters.extend(filter);
                if x_end.is_empty() {
                    x_end = run.x.row(run.x.nrows() - 1).iter().copied().collect();
                }
                rows.push(RunReport { observer, merits: Some(merits), failure: None });
                runs.push((member, Ok(run)));
            }
            Err(error) => {
                rows.push(RunReport { observer, merits: None, failure: Some(error.to_string()) });
                runs.push((member, Err(error)));
            }
        }
    }
    let report = SimulationReport {
        duration: simulation.duration,
        x0: simulation.x0.clone(),
        x_end,
        seed: simulation.noise.as_ref().map(|noise| noise.seed),
        rows,
    };
    (report, runs, filters)
}

/// Checks that the observer in the feedback loop has a design.
fn fed_back(study: &Study, members: &[Member<'_>]) -> Result<(), SimError> {
    match fed(study) {
        Some(observer) if !members.iter().any(|member| member.wish.name == observer) => {
            Err(SimError::UnknownName { name: observer.to_owned() })
        }
        _ => Ok(()),
    }
}
