//! The trajectory of a study's plant with its observers, as the simulation of the study has it.
//!
//! With feedback, the observer in the loop is part of every run, so that all see the same plant trajectory.

use luenberger_clock::Instant;
use luenberger_sim::{Change, Disturbances, Scenario, Settings, SimError, Trajectory, row_times};

use crate::designed::Designed;
use crate::signal::Input;
use crate::study::{ObserverSpec, Simulation, Study};

/// An observer that has been designed.
#[derive(Clone, Copy)]
pub(crate) struct Member<'a> {
    pub(crate) requested: &'a ObserverSpec,
    pub(crate) designed: &'a Designed,
}

/// The designed observer of that name.
pub(crate) fn member<'a, 'b>(members: &'b [Member<'a>], name: &str) -> Option<&'b Member<'a>> {
    members.iter().find(|member| member.requested.name == name)
}

/// Deviation from the study's own run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Variation {
    /// Factor of the noise amplitude.
    pub(crate) noise: f64,
    /// The number of the run in its ensemble.
    pub(crate) member: u64,
}

impl Variation {
    pub(crate) const NONE: Self = Self { noise: 1.0, member: 0 };
}

/// The observer in the feedback loop.
pub(crate) fn fed(study: &Study) -> Option<&str> {
    match &study.input {
        Input::Feedback { observer, .. } => Some(observer),
        _ => None,
    }
}

/// Whether the input of the plant is a feedback of this observer's estimate.
pub(crate) fn is_fed(study: &Study, observer: &str) -> bool {
    fed(study) == Some(observer)
}

/// The rows of a run, and its end if that is no row.
pub(crate) fn times(simulation: &Simulation, period: Option<f64>) -> (Vec<f64>, Option<f64>) {
    row_times(simulation.duration, simulation.samples, period)
}

/// One run, with the observer `member` and the one in the feedback loop, until the instant `until` at most.
pub(crate) fn run(
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
    run_at(study, &Simulation { settings, ..simulation.clone() }, members, member, variation, &wanted)
}

/// The same with rows at the given times.
pub(crate) fn run_at(
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
        .angles(&study.plant.turns_of(&study.plant.states).unwrap_or_default())
        .initial_state(&simulation.x0)
        .times(times)
        .settings(simulation.settings)
        .member(variation.member)
        .input(study.input.signal_at(study.operating_point.as_ref()))
        .breakpoints(&study.input.breakpoints(0.0, simulation.duration));
    if let Some(period) = simulation.hold {
        scenario = scenario.hold_input(period);
    }
    if truth.is_some() || !study.plant.delays.is_empty() {
        let own = truth.map_or_else(Disturbances::default, |truth| truth.disturbances.clone());
        scenario = scenario.disturbances(Disturbances { output_delays: study.plant.delays.clone(), ..own });
    }
    if let Some(truth) = truth {
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
        scenario = scenario.noise(noise.noise(variation.noise));
    }
    for sensor in &simulation.sensors {
        scenario = scenario.sensor(sensor.sensor(variation.noise));
    }
    if simulation.hold_measurements {
        scenario = scenario.hold_measurements();
    }
    let name = member.map(|member| member.requested.name.as_str());
    if let Some(observer) = fed(study).filter(|observer| Some(*observer) != name)
        && let Some(fed) = members.iter().find(|fed| fed.requested.name == observer)
    {
        scenario =
            fed.designed.runnable.join(scenario, &fed.requested.name, &fed.requested.initial, &simulation.sampling);
    }
    if let Some(member) = member {
        let name = &member.requested.name;
        scenario = member.designed.runnable.join(scenario, name, &member.requested.initial, &simulation.sampling);
    }
    scenario.run()
}

/// The run of the plant alone; none with feedback of an estimate, or if it cannot be simulated.
pub(crate) fn of_plant(study: &Study, simulation: &Simulation) -> Option<Trajectory> {
    if fed(study).is_some() {
        return None;
    }
    run(study, simulation, &[], None, Variation::NONE, None).ok()
}

/// The run with an observer at given times; none if it cannot be simulated.
pub(crate) fn of_observer_at(
    study: &Study,
    simulation: &Simulation,
    members: &[Member<'_>],
    member: &Member<'_>,
    times: &[f64],
) -> Option<Trajectory> {
    run_at(study, simulation, members, Some(member), Variation::NONE, times).ok()
}
