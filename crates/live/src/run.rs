//! The simulation of an experiment for given positions of the sliders.

use luenberger_sim::{Change, Errors, Integrator, Scenario, ScoreGrid, Sensor, row_times};
use nalgebra::DMatrix;

use crate::experiment::{Estimates, Experiment, Feedback, FeedbackSignal, Method, Sliders, StoredObserver};
use crate::input::Inputs;
use crate::join::join;
use crate::plants::{Plants, Result, text};
use crate::rows::Rows;

/// What the page draws.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Outcome {
    /// One run for each observer, in the order of the experiment.
    pub runs: Vec<Run>,
}

/// The run of one observer.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct Run {
    /// The observer.
    pub name: String,
    /// Why it ended early or did not run; the rest is empty then.
    pub failure: Option<String>,
    /// The times.
    pub t: Vec<f64>,
    /// The states, one list for each.
    pub x: Rows,
    /// The estimates, one list for each.
    pub xhat: Rows,
    /// The norm of the error; empty without a scale.
    pub norm: Vec<f64>,
    /// The scores of the norm; none without a scale.
    pub scores: Option<Scores>,
    /// The scores of each state, in its unit.
    pub states: Vec<Scores>,
}

/// Scores of the norm of the error, or of the error of one state.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Scores {
    /// The root mean square.
    pub rms: f64,
    /// The largest value.
    pub peak: f64,
    /// From when on it stays within the band, of a state 5 % of its value at the start; none if it does not.
    pub settled: Option<f64>,
    /// The value at the end.
    pub last: f64,
}

/// The experiment with these positions of the sliders. An observer whose run fails leaves the others unchanged.
pub fn run(experiment: &Experiment, sliders: &Sliders) -> Outcome {
    let sliders = experiment.fitted(sliders);
    let runs = experiment.observers.iter().map(|observer| {
        one(experiment, observer, &sliders).unwrap_or_else(|failure| Run {
            name: observer.name.clone(),
            failure: Some(failure),
            ..Run::default()
        })
    });
    Outcome { runs: runs.collect() }
}

impl Experiment {
    /// Whether its expressions can be read.
    ///
    /// # Errors
    /// What is wrong with a plant or the input.
    pub fn check(&self) -> Result<()> {
        Plants::new(self)?;
        Inputs::new(self).map(|_| ())
    }
}

fn one(experiment: &Experiment, observer: &StoredObserver, sliders: &Sliders) -> Result<Run> {
    let plants = Plants::new(experiment)?;
    let model = plants.model.any();
    let mut scenario = scenario(experiment, sliders, &plants, &observer.name)?;
    if let Some(Feedback { of: FeedbackSignal::Estimate(name), .. }) = &experiment.feedback
        && *name != observer.name
    {
        let fed = experiment.observers.iter().find(|fed| fed.name == *name);
        let fed = fed.ok_or_else(|| format!("the observer {name} in the feedback loop is not in the page"))?;
        scenario = join(scenario, experiment, fed, sliders, model)?;
    }
    let scenario = join(scenario, experiment, observer, sliders, model)?;
    finished(experiment, observer, sliders, scenario)
}

/// The sampling period of an observer at these positions; none for one in continuous time.
fn period(observer: &StoredObserver, sliders: &Sliders) -> Option<f64> {
    observer.kind.period().map(|period| sliders.period * period)
}

fn scenario<'a>(
    experiment: &Experiment,
    sliders: &Sliders,
    plants: &'a Plants,
    observer: &str,
) -> Result<Scenario<'a>> {
    let [rtol, atol] = experiment.tolerances;
    let inputs = Inputs::new(experiment)?;
    let mut scenario = Scenario::new(plants.truth.as_ref().unwrap_or(&plants.model).any())
        .model(plants.model.any())
        .initial_state(&experiment.x0)
        .tolerances(rtol, atol)
        .integrator(match experiment.integrator {
            Method::Auto => Integrator::Auto,
            Method::Explicit => Integrator::Explicit,
            Method::Implicit => Integrator::Implicit,
        })
        .breakpoints(&inputs.breakpoints(experiment))
        .input(inputs.signal(experiment, observer));
    if let Some(truth) = &experiment.truth {
        scenario = scenario.disturbances(truth.disturbances());
        for (event, plant) in truth.events.iter().zip(&plants.later) {
            let mut change = Change::at(event.at);
            if let Some(plant) = plant {
                change = change.plant(plant.any());
            }
            if !event.jump.is_empty() {
                change = change.jump(&event.jump);
            }
            scenario = scenario.change(change);
        }
    }
    if let Some(dt) = experiment.dt {
        scenario = scenario.discrete_time(dt);
    }
    if let Some(hold) = experiment.hold {
        scenario = scenario.hold_input(hold);
    }
    if let Some(noise) = experiment.noise.as_ref().filter(|_| sliders.noise > 0.0) {
        scenario = scenario.noise(noise.scaled(sliders.noise));
    }
    for of in &experiment.sensors {
        let sensor = Sensor::new(of.output, of.period).offset(of.offset);
        let amplitude = sliders.noise * of.amplitude;
        let sensor = if of.gaussian { sensor.gaussian(amplitude, of.seed) } else { sensor.uniform(amplitude, of.seed) };
        scenario = scenario.sensor(sensor);
    }
    if experiment.hold_measurements {
        scenario = scenario.hold_measurements();
    }
    Ok(scenario)
}

/// The instants that all observers are scored at.
fn grid(experiment: &Experiment, sliders: &Sliders) -> Result<ScoreGrid> {
    if let Some(period) = experiment.score_period {
        return Ok(ScoreGrid::Samples { period });
    }
    let periods: Vec<Option<f64>> = experiment.observers.iter().map(|observer| period(observer, sliders)).collect();
    ScoreGrid::common(&periods, experiment.duration).map_err(text)
}

fn finished(
    experiment: &Experiment,
    observer: &StoredObserver,
    sliders: &Sliders,
    scenario: Scenario<'_>,
) -> Result<Run> {
    let period = period(observer, sliders);
    let (mut times, end) = row_times(experiment.duration, experiment.samples, period);
    let shown = times.len();
    times.extend(end);
    let trajectory = scenario.times(&times).run().map_err(text)?;
    let name = observer.name.as_str();
    let columns = |m: &DMatrix<f64>| -> Rows {
        m.column_iter().map(|column| column.iter().take(shown).copied().collect()).collect()
    };
    let estimates = match experiment.estimates {
        Estimates::Filtered => luenberger_sim::Estimates::Filtered,
        Estimates::Predicted => luenberger_sim::Estimates::Predicted,
    };
    let estimate = trajectory.observer(name).map_err(text)?.estimates(&times[..shown], estimates);
    let norm = |scale: &Vec<f64>, k: usize| {
        let share = |(i, unit): (usize, &f64)| (trajectory.x[(k, i)] - estimate[(k, i)]) / unit;
        scale.iter().enumerate().map(|entry| share(entry).powi(2)).sum::<f64>().sqrt()
    };
    let errors = Errors::of_estimates(&trajectory, name, grid(experiment, sliders)?, estimates).map_err(text)?;
    let scores = match &experiment.scale {
        Some(scale) => {
            let of = errors.norm(Some(scale), experiment.band).map_err(text)?;
            Some(Scores { rms: of.rmse, peak: of.peak, settled: of.settling_last, last: of.last })
        }
        None => None,
    };
    let states = errors.states().map_err(text)?.into_iter();
    let states = states.map(|of| Scores { rms: of.rmse, peak: of.peak, settled: of.settling_5, last: of.last });
    Ok(Run {
        name: name.to_owned(),
        failure: None,
        norm: experiment.scale.iter().flat_map(|scale| (0..shown).map(|k| norm(scale, k))).collect(),
        x: columns(&trajectory.x),
        xhat: columns(&estimate),
        scores,
        states: states.collect(),
        t: times.into_iter().take(shown).collect(),
    })
}
