//! The experiment of a study as the page of its report runs it.

use luenberger_expression::{Expression, Parameters};
use luenberger_live::{
    Estimates, Event, Experiment, Feedback, FeedbackSignal, Hypotheses, Law, Lookup, Method, Rows, Sensor, StoredNoise,
    StoredObserver, StoredPlant, Table, Truth,
};
use luenberger_proof::certificate::{ProvedTheorem, Theorem};
use luenberger_sim::{Integrator, SampleInterpolation};

use super::scores;
use super::scores::Scoring;
use crate::designed::rows;
use crate::model::{Builtin, Model};
use crate::signal::{Input, Program};
use crate::study::{self, OtherPlant, SensorSpec, Simulation, Study};
use crate::trajectory::Member;

/// The most times that the page shows.
const SHOWN: usize = 401;

/// The most states: a slider should move without delay.
const STATES: usize = 12;

/// The most bytes of the certificates of one observer: what a browser verifies while a slider is moved.
const CERTIFICATES: usize = 200_000;

/// The most numbers of an input table.
const TABLE: usize = 20_000;

/// The experiment and the observers that are not in it, or in a sentence why the page does not simulate the study; none
/// for a study without a simulation.
pub(crate) fn experiment(study: &Study, members: &[Member<'_>]) -> Option<Result<(Experiment, Vec<String>), String>> {
    study.simulation.as_ref().map(|simulation| experiment_of(study, simulation, members))
}

fn experiment_of(
    study: &Study,
    simulation: &Simulation,
    members: &[Member<'_>],
) -> Result<(Experiment, Vec<String>), String> {
    let names = &study.plant;
    if !names.turns.is_empty() {
        return Err("the page has no code for angles".to_owned());
    }
    if names.states.len() > STATES {
        return Err(format!("its plant has more than {STATES} states"));
    }
    let mut omitted: Vec<String> = Vec::new();
    let mut observers = Vec::new();
    for member in members {
        match observer(study, member) {
            Some(observer) => observers.push(observer),
            None => omitted.push(described(study, member)),
        }
    }
    if observers.is_empty() {
        return Err(format!("the page has no code for its observers, {}", omitted.join(", ")));
    }
    if !names.delays.is_empty() {
        return Err("the page has no code for outputs that are measured late".to_owned());
    }
    let (input, table, law) = program(&study.input)?;
    let feedback = feedback(study);
    if let Some(Feedback { of: FeedbackSignal::Estimate(name), .. }) = &feedback
        && !observers.iter().any(|observer| observer.name == *name)
    {
        return Err(format!("the page has no code for the observer {name} in the feedback loop"));
    }
    let noise = simulation.noise.as_ref().map(|noise| StoredNoise {
        gaussian: noise.gaussian,
        amplitude: noise.amplitude.clone(),
        period: noise.period,
        seed: noise.seed,
    });
    let sensor = |of: &SensorSpec| Sensor {
        output: of.output,
        period: of.period,
        offset: of.offset,
        gaussian: of.gaussian,
        amplitude: of.amplitude,
        seed: of.seed,
    };
    // Observers that are not in the page count for the instants of the scores all the same.
    let score_period = match (simulation.score_period, omitted.is_empty()) {
        (None, false) => Scoring::of(study, simulation, members.iter(), members).ok().and_then(|of| of.period()),
        (given, _) => given,
    };
    let no_plant = "the page has no code for its plant, which is one of the library";
    let experiment = Experiment {
        states: names.states.clone(),
        units: names.units_of(&names.states),
        time_unit: names.time_unit.clone(),
        input,
        table,
        law,
        feedback,
        parameters: names.parameters.clone(),
        tables: names.tables.iter().map(|(name, table)| (name.clone(), Lookup::of(table))).collect(),
        dt: names.dt,
        truth: match &study.truth {
            Some(of) => Some(Box::new(truth(study, of, simulation).ok_or(no_plant)?)),
            None => None,
        },
        hold: simulation.hold,
        tolerances: [simulation.settings.rtol, simulation.settings.atol],
        integrator: match simulation.settings.integrator {
            Integrator::Auto => Method::Auto,
            Integrator::Explicit => Method::Explicit,
            Integrator::Implicit => Method::Implicit,
        },
        noise,
        sensors: simulation.sensors.iter().map(sensor).collect(),
        scale: scores::scale(study, simulation).map(|(scale, _)| scale),
        band: simulation.band,
        score_period,
        hold_measurements: simulation.hold_measurements,
        estimates: match simulation.estimates {
            luenberger_sim::Estimates::Filtered => Estimates::Filtered,
            luenberger_sim::Estimates::Predicted => Estimates::Predicted,
        },
        observers,
        ..Experiment::new(
            plant(study, &names.model, None).ok_or(no_plant)?,
            &simulation.x0,
            simulation.duration,
            simulation.samples.min(SHOWN),
        )
    };
    match experiment.check() {
        Ok(()) => Ok((experiment, omitted)),
        Err(why) => Err(format!("its expressions do not stand alone ({why})")),
    }
}

/// An observer that the page has no code for.
fn described(study: &Study, member: &Member<'_>) -> String {
    let time = if study.plant.dt.is_some() { ", in discrete time" } else { "" };
    format!("{} (kind {}{time})", member.requested.name, member.requested.kind.name())
}

/// The plant as it is simulated; none for one that the page has no code for.
fn truth(study: &Study, of: &study::Truth, simulation: &Simulation) -> Option<Truth> {
    let other = |other: &OtherPlant| plant(study, &other.model, Some(&other.parameters));
    let within = of.events.iter().filter(|event| event.at <= simulation.duration);
    let events = within.map(|event| {
        let plant = match &event.plant {
            Some(plant) => Some(other(plant)?),
            None => None,
        };
        Some(Event { at: event.at, plant, jump: event.jump.clone() })
    });
    let plant = match &of.plant {
        Some(plant) => Some(other(plant)?),
        None => None,
    };
    Some(Truth { plant, events: events.collect::<Option<_>>()?, ..Truth::of(&of.disturbances) })
}

/// The input as expressions of time, as a table, or as a law with the true state.
type Inputs = (Vec<String>, Option<Table>, Option<Law>);

fn program(input: &Input) -> Result<Inputs, String> {
    let texts = |rows: &[Expression]| rows.iter().map(|row| row.text().to_owned()).collect();
    if let Input::Law { law, jumps } = input {
        return Ok((Vec::new(), None, Some(Law { rows: texts(law), jumps: jumps.clone() })));
    }
    match input.program() {
        Some(Program::Expressions(rows)) => Ok((texts(rows), None, None)),
        Some(Program::Table(samples)) if samples.values().len() > TABLE => {
            Err(format!("the table of its input has more than {TABLE} numbers"))
        }
        Some(Program::Table(samples)) => {
            let line = samples.between() == SampleInterpolation::Linear;
            let table = Table { t: samples.times().to_vec(), rows: rows(samples.values()), line };
            Ok((Vec::new(), Some(table), None))
        }
        None => Ok((Vec::new(), None, None)),
    }
}

fn feedback(study: &Study) -> Option<Feedback> {
    let (gain, of) = match &study.input {
        Input::Zero | Input::Program(_) | Input::Law { .. } => return None,
        Input::Feedback { observer, gain, .. } => (gain, FeedbackSignal::Estimate(observer.clone())),
        Input::StateFeedback { gain, .. } => (gain, FeedbackSignal::State),
    };
    let point = study.operating_point.as_ref();
    let shift = point.map_or_else(Vec::new, |point| (&point.u + gain * &point.x).as_slice().to_vec());
    Some(Feedback { gain: rows(gain), of, shift })
}

/// A plant with the names of the study, and its parameters if they are not those of the model.
fn plant(study: &Study, model: &Model, parameters: Option<&Parameters>) -> Option<StoredPlant> {
    match model {
        Model::Linear(plant) | Model::Builtin(Builtin::DoubleIntegrator(plant) | Builtin::ThirdOrder(plant)) => {
            Some(StoredPlant::linear(plant))
        }
        Model::Expressions(plant, _) => {
            let texts = |rows: &[Expression]| rows.iter().map(|row| row.text().to_owned()).collect();
            Some(StoredPlant::Expressions {
                states: study.plant.states.clone(),
                inputs: study.plant.inputs.clone(),
                f: texts(plant.f()),
                h: texts(plant.h()),
                parameters: parameters.filter(|own| **own != study.plant.parameters).cloned(),
            })
        }
        Model::Builtin(_) => None,
    }
}

fn observer(study: &Study, member: &Member<'_>) -> Option<StoredObserver> {
    let (kind, point) = member.designed.runnable.live(study)?;
    let theorems = member.designed.certificate.iter().flat_map(luenberger_design::Certificate::theorems);
    // A bound of the error under disturbances is beside the theorem of convergence.
    let theorems = theorems.filter(|of| {
        !matches!(of.theorem(), Theorem::InputToStateStability(_) | Theorem::DiscreteInputToStateStability(_))
    });
    let file = |of: &ProvedTheorem| {
        luenberger_live::verifies(of.theorem())
            .then(|| of.file(&member.requested.name).ok())
            .flatten()
            .map(|file| file.to_json())
    };
    let certificates: Option<Vec<String>> = theorems.map(file).collect();
    let certificates = certificates.filter(|files| files.iter().map(String::len).sum::<usize>() <= CERTIFICATES);
    let hypotheses = hypotheses(member);
    Some(StoredObserver {
        point,
        certificates,
        hypotheses,
        ..StoredObserver::new(&member.requested.name, kind, &member.requested.initial)
    })
}

/// The noise and the first errors that a certificate is for. The interval observer is the only one in the page whose
/// theorem has bounds of them: the others hold for every first error and say nothing of noise, or have no bound of it.
fn hypotheses(member: &Member<'_>) -> Option<Hypotheses> {
    let start = member.designed.runnable.first_widths()?.to_vec();
    let theorems = member.designed.certificate.iter().flat_map(luenberger_design::Certificate::theorems);
    let of = theorems.map(ProvedTheorem::theorem).find_map(|theorem| match theorem {
        Theorem::IntervalEnclosure(of) => Some(of),
        _ => None,
    })?;
    let rows = |m: &luenberger_proof::Matrix<f64>| (0..m.rows()).map(|i| m.row(i).to_vec()).collect::<Rows>();
    // y = Cx + Dw with |w_j| <= W_j, an output having a noise of its own.
    let bound = |row: &Vec<f64>| row.iter().zip(&of.disturbances).map(|(d, bound)| d.abs() * bound).sum();
    Some(Hypotheses {
        noise: rows(&of.d).iter().map(bound).collect(),
        t: rows(&of.coordinates.t),
        blocks: of.coordinates.blocks.clone(),
        start,
    })
}
