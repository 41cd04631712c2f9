//! The experiment of a study as the page of its report runs it.

use luenberger_live::{
    Experiment, Feedback, FeedbackOf, Noise, Observer, ObserverKind, OperatingPoint, Plant, Rows, Sensor, Table,
};
use luenberger_observers::{DeviationObserver, SampledCubicObserver, SampledObserver};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::{ProvedTheorem, Theorem};
use luenberger_sim::{Between, Integrator};
use nalgebra::{DMatrix, Dyn};

use super::{Member, scores};
use crate::design::Runnable;
use crate::model::{Builtin, Model};
use crate::signal::{Input, Program};
use crate::study::{SensorSpec, Simulation, Study};

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
    study.simulation.as_ref().map(|simulation| of(study, simulation, members))
}

fn of(study: &Study, simulation: &Simulation, members: &[Member<'_>]) -> Result<(Experiment, Vec<String>), String> {
    let names = &study.plant;
    let refused = [
        (names.dt.is_some(), "its plant is in discrete time"),
        (study.truth.is_some(), "its plant is simulated with disturbances, changes or other parameters (`[truth]`)"),
        (simulation.settings.integrator != Integrator::Auto, "it chooses an integrator"),
        (names.states.len() > STATES, "its plant has more than 12 states"),
    ];
    if let Some((_, why)) = refused.into_iter().find(|(refused, _)| *refused) {
        return Err(why.to_owned());
    }
    let mut omitted: Vec<String> = Vec::new();
    let mut observers = Vec::new();
    for member in members {
        match observer(study, member) {
            Some(observer) => observers.push(observer),
            None => omitted.push(member.wish.name.clone()),
        }
    }
    if observers.is_empty() {
        return Err("the page has no code for its observers".to_owned());
    }
    let (input, table) = program(&study.input)?;
    let feedback = feedback(study)?;
    if let Some(Feedback { of: FeedbackOf::Estimate(name), .. }) = &feedback
        && !observers.iter().any(|observer| observer.name == *name)
    {
        return Err(format!("the page has no code for the observer {name} in the feedback loop"));
    }
    let noise = simulation.noise.as_ref().map(|noise| Noise {
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
    let plant = plant(study).ok_or("the page has no code for its plant, which is one of the library")?;
    let experiment = Experiment {
        states: names.states.clone(),
        units: names.units_of(&names.states),
        time_unit: names.time_unit.clone(),
        input,
        table,
        feedback,
        parameters: names.parameters.clone(),
        hold: simulation.hold,
        tolerances: [simulation.settings.rtol, simulation.settings.atol],
        noise,
        sensors: simulation.sensors.iter().map(sensor).collect(),
        scale: scores::scale(study, simulation),
        band: simulation.band,
        score_period: simulation.score_period,
        observers,
        ..Experiment::new(plant, &simulation.x0, simulation.duration, simulation.samples.min(SHOWN))
    };
    // An expression with a lookup table has no text that stands alone.
    match experiment.check() {
        Ok(()) => Ok((experiment, omitted)),
        Err(_) => Err("its expressions use lookup tables".to_owned()),
    }
}

/// The input as expressions or as a table.
fn program(input: &Input) -> Result<(Vec<String>, Option<Table>), String> {
    match input.program() {
        Some(Program::Expressions(rows)) => Ok((rows.iter().map(|row| row.text().to_owned()).collect(), None)),
        Some(Program::Table(samples)) if samples.values().len() > TABLE => {
            Err(format!("the table of its input has more than {TABLE} numbers"))
        }
        Some(Program::Table(samples)) => {
            let line = samples.between() == Between::Line;
            Ok((Vec::new(), Some(Table { t: samples.times().to_vec(), rows: rows(samples.values()), line })))
        }
        None => Ok((Vec::new(), None)),
    }
}

fn feedback(study: &Study) -> Result<Option<Feedback>, String> {
    let (gain, of) = match &study.input {
        Input::Zero | Input::Program(_) => return Ok(None),
        Input::Law { .. } => return Err("its input is a law with the true state".to_owned()),
        Input::Feedback { observer, gain, .. } => (gain, FeedbackOf::Estimate(observer.clone())),
        Input::StateFeedback { gain, .. } => (gain, FeedbackOf::State),
    };
    let point = study.operating_point.as_ref();
    let shift = point.map_or_else(Vec::new, |point| (&point.u + gain * &point.x).as_slice().to_vec());
    Ok(Some(Feedback { gain: rows(gain), of, shift }))
}

fn plant(study: &Study) -> Option<Plant> {
    match &study.plant.model {
        Model::Linear(plant) | Model::Builtin(Builtin::DoubleIntegrator(plant) | Builtin::ThirdOrder(plant)) => {
            Some(Plant::linear(plant))
        }
        Model::Expressions(plant) => {
            let texts =
                |rows: &[luenberger_expression::Expression]| rows.iter().map(|row| row.text().to_owned()).collect();
            Some(Plant::Expressions {
                states: study.plant.states.clone(),
                inputs: study.plant.inputs.clone(),
                f: texts(plant.f()),
                h: texts(plant.h()),
            })
        }
        Model::Builtin(_) => None,
    }
}

fn rows(m: &DMatrix<f64>) -> Rows {
    m.row_iter().map(|row| row.iter().copied().collect()).collect()
}

fn observer(study: &Study, member: &Member<'_>) -> Option<Observer> {
    let (kind, point) = match &member.designed.runnable {
        Runnable::Linear(linear) => (ObserverKind::Linear(linear.clone()), None),
        Runnable::Cubic(cubic) => (ObserverKind::Cubic(cubic.clone()), None),
        Runnable::LinearAt(at) => (ObserverKind::Linear(Box::new(at.inner().clone())), Some(point(at))),
        Runnable::CubicAt(at) => (ObserverKind::Cubic(Box::new(at.inner().clone())), Some(point(at))),
        Runnable::SampledCubic(sampled) => (sampled_cubic(sampled, &study.plant.model.linear()?), None),
        Runnable::SampledCubicAt(at) => {
            (sampled_cubic(at.inner(), &study.operating_point.as_ref()?.linear), Some(point(at)))
        }
        Runnable::NonlinearLuenberger(copy) => (ObserverKind::Copy { l: rows(copy.l()) }, None),
        Runnable::ExtendedKalman(filter) if filter.gate().is_none() => {
            let noises = filter.noise_model();
            let period = SampledObserver::<f64>::period(filter.as_ref());
            let [w, v, p0] = [&noises.w, &noises.v, &noises.p0].map(rows);
            (ObserverKind::Kalman { w, v, p0, period, substeps: filter.substeps()? }, None)
        }
        _ => return None,
    };
    let theorems = member.designed.certificate.iter().flat_map(luenberger_design::Certificate::theorems);
    // A bound of the error under disturbances is beside the theorem of convergence.
    let theorems = theorems.filter(|of| !matches!(of.theorem(), Theorem::InputToStateStability(_)));
    let file = |of: &ProvedTheorem| {
        luenberger_live::verifies(of.theorem())
            .then(|| of.file(&member.wish.name).ok())
            .flatten()
            .map(|file| file.to_json())
    };
    let certificates: Option<Vec<String>> = theorems.map(file).collect();
    let certificates = certificates.filter(|files| files.iter().map(String::len).sum::<usize>() <= CERTIFICATES);
    Some(Observer { point, certificates, ..Observer::new(&member.wish.name, kind, &member.wish.initial) })
}

fn sampled_cubic(observer: &SampledCubicObserver<f64, Dyn, Dyn, Dyn>, plant: &StateSpace) -> ObserverKind {
    ObserverKind::SampledCubic { observer: Box::new(observer.clone()), a: rows(&plant.a), b: rows(&plant.b) }
}

fn point<O>(at: &DeviationObserver<O, f64, Dyn, Dyn, Dyn>) -> OperatingPoint {
    let [x, u, y] = [at.x0(), at.u0(), at.y0()].map(|entries| entries.as_slice().to_vec());
    OperatingPoint { x, u, y }
}
