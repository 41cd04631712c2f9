//! The table [truth]: the plant as it is, where it is not as the observers take it to be.

use luenberger_sim::{Disturbances, Fault, MeasurementLoss, Noise};

use super::other_plant::{self, Whose};
use super::{Reported, estimate};
use crate::model::PlantModel;
use crate::reader::tree::{Entry, Node, Value};
use crate::reader::{Reader, check};
use crate::study::{Estimated, Event, Simulation, Truth};

pub(super) fn truth(
    (root, node): (&Node, &Node),
    (plant, estimated): (&PlantModel, &[Estimated]),
    simulation: &Simulation,
    reader: &mut Reader,
) -> Option<Truth> {
    let (n, m, p) = (plant.states.len(), plant.inputs.len(), plant.outputs.len());
    let mut tree = root.get("plant")?.clone();
    let other = other_plant::changed(&mut tree, node, (plant, estimated), Whose::Truth, reader).ok()?;
    let events = match node.get("event") {
        None => Vec::new(),
        Some(list) => events(list, &mut tree, (plant, estimated), reader)?,
    };
    let process_noise = match node.get("process_noise") {
        None => None,
        Some(noise) => {
            let mut amplitude = reader.numbers(noise.get("amplitude")?, "amplitude", n, "state")?;
            let (period, seed) =
                (noise.get("period")?.number()?, noise.get("seed").map_or(Some(0), Node::count)? as u64);
            let uniform = noise.get("distribution").and_then(Node::text) == Some("uniform");
            amplitude.extend(coloured((noise, period, uniform), plant.dt, estimated, reader)?);
            let of = if uniform { Noise::uniform } else { Noise::gaussian };
            Some(of(&amplitude, period, seed))
        }
    };
    let delay = |key: &str| node.get(key).map_or(Some(0.0), Node::number);
    let quantisation = match node.get("quantisation") {
        Some(list) => reader.numbers(list, "quantisation", p, "output")?,
        None => Vec::new(),
    };
    let disturbances = Disturbances {
        process_noise,
        input_delay: delay("input_delay")?,
        output_delay: delay("measurement_delay")?,
        // Those of [plant] are known to the observers.
        output_delays: Vec::new(),
        actuator: fault(node, "actuator", (m, "input"), reader).ok()?,
        sensor: fault(node, "sensor", (p, "output"), reader).ok()?,
        quantisation,
        channel: channel(node, p, simulation, reader).ok()?,
    };
    let words = words(node);
    let mut truth = Truth { plant: other, events, disturbances, words };
    estimate::in_truth(&mut truth, n, estimated);
    Some(truth)
}

/// The amplitudes of what drives the parameters that are estimated: 0, and of coloured noises, if they vary, those of
/// values held for `period` that give them their deviations.
fn coloured(
    (node, period, uniform): (&Node, f64, bool),
    dt: Option<f64>,
    estimated: &[Estimated],
    reader: &mut Reader,
) -> Option<Vec<f64>> {
    let Some(entry) = node.entry("noises").filter(|entry| entry.node.truth() == Some(true)) else {
        return Some(vec![0.0; estimated.len()]);
    };
    if estimated.iter().all(|one| one.noise.is_none()) {
        let message = "`noises` without [estimate.noises]";
        return reader.refuse(entry.span.clone(), message, "expected noises there, or no `noises` here");
    }
    if let Some(dt) = dt.filter(|dt| (period / dt - 1.0).abs() > 1e-9) {
        let message = format!("`noises` with the period {period} of a plant whose period is {dt}");
        return reader.refuse(node.get("period")?.span.clone(), message, format!("expected {dt}"));
    }
    // A uniform number has the variance amplitude^2/3.
    let factor = if uniform { 3.0_f64.sqrt() } else { 1.0 };
    let of = |one: &Estimated| one.noise.map_or(0.0, |noise| factor * noise.held(period, dt));
    Some(estimated.iter().map(of).collect())
}

/// The events, in the order of the file; each changes the plant that the ones before it have left.
fn events(
    list: &Node,
    tree: &mut Node,
    (plant, estimated): (&PlantModel, &[Estimated]),
    reader: &mut Reader,
) -> Option<Vec<Event>> {
    let mut events: Vec<Event> = Vec::new();
    for node in list.list()? {
        let at = node.get("at")?.number()?;
        if let Some(before) = events.last().map(|event| event.at).filter(|before| *before > at) {
            let message = format!("the event at t = {at} follows that at t = {before}");
            return reader.refuse(node.get("at")?.span.clone(), message, "expected events in the order of their times");
        }
        let jump = match node.get("jump") {
            None => Vec::new(),
            Some(jump) => reader.numbers(jump, "jump", plant.states.len(), "state")?,
        };
        let other = other_plant::changed(tree, node, (plant, estimated), Whose::Truth, reader).ok()?;
        if other.is_none() && jump.is_empty() {
            let expected = "expected `jump`, or another plant: `parameters`, `a`, `b`, `c`, `d`, `f` or `h`";
            return reader.refuse(check::head(node), "the event changes nothing", expected);
        }
        events.push(Event { at, plant: other, jump });
    }
    Some(events)
}

/// Gain and bias of actuators or sensors, if there is a fault; 1 and 0 where not given.
fn fault(node: &Node, key: &str, (count, of): (usize, &str), reader: &mut Reader) -> Result<Option<Fault>, Reported> {
    let Some(table) = node.get(key) else { return Ok(None) };
    let mut entries = |key: &str, otherwise: f64| match table.get(key) {
        Some(list) => reader.numbers(list, key, count, of).ok_or(Reported),
        None => Ok(vec![otherwise; count]),
    };
    let (gain, bias) = (entries("gain", 1.0)?, entries("bias", 0.0)?);
    let from = table.get("from").map_or(Some(0.0), Node::number).ok_or(Reported)?;
    Ok(Some(Fault { gain, bias, from }))
}

/// Dropouts and outliers, if there are any.
fn channel(
    node: &Node,
    outputs: usize,
    simulation: &Simulation,
    reader: &mut Reader,
) -> Result<Option<MeasurementLoss>, Reported> {
    let (dropout, outliers) = (node.get("dropout"), node.get("outliers"));
    if dropout.is_none() && outliers.is_none() {
        return Ok(None);
    }
    let mut probability = |at: Option<&Node>, name: &str| {
        let Some(at) = at else { return Ok(0.0) };
        let value = at.number().ok_or(Reported)?;
        if (0.0..=1.0).contains(&value) {
            return Ok(value);
        }
        reader.wrong(at.span.clone(), format!("`{name}` is {value}"), "expected a probability from 0 to 1");
        Err(Reported)
    };
    let dropout = probability(dropout, "dropout")?;
    let outlier = probability(outliers.and_then(|table| table.get("probability")), "probability")?;
    let outlier_size = match outliers {
        Some(table) => {
            let size = table.get("size").and_then(|size| reader.numbers(size, "size", outputs, "output"));
            size.ok_or(Reported)?
        }
        None => vec![0.0; outputs],
    };
    let period = match (node.get("period"), &simulation.noise) {
        (Some(period), _) => period.number().ok_or(Reported)?,
        (None, Some(noise)) => noise.period,
        // Every output has a sensor, for each measurement of which they are drawn.
        (None, None) if simulation.sensors.len() == outputs => 1.0,
        (None, None) => {
            let message = "`dropout` and `outliers` are drawn every period, and there is none";
            reader.absent(check::head(node), message, "expected `period`, or simulation.noise with its period");
            return Err(Reported);
        }
    };
    let seed = node.get("seed").map_or(Some(0), Node::count).ok_or(Reported)? as u64;
    Ok(Some(MeasurementLoss { dropout, outlier, outlier_size, period, seed }))
}

/// The table as a sentence.
fn words(node: &Node) -> String {
    let entries = node.entries().iter().filter(|entry| !["seed", "period"].contains(&entry.key.as_str()));
    let parameters = |inner: &[Entry]| {
        let values = inner.iter().filter_map(|entry| match &entry.node.value {
            Value::Number(x, _) => Some(format!("{} = {x}", entry.key)),
            Value::Text(text) => Some(format!("{} = {text}", entry.key)),
            _ => None,
        });
        values.collect::<Vec<_>>().join(", ")
    };
    let one = |entry: &Entry| match (&entry.node.value, entry.key.as_str()) {
        (Value::Number(x, _), key) => format!("{} = {x}", key.replace('_', " ")),
        (Value::Table(inner), "parameters") => parameters(inner),
        (Value::List(events), "event") => {
            let times = events.iter().filter_map(|event| Some(format!("t = {}", event.get("at")?.number()?)));
            format!("events at {}", times.collect::<Vec<_>>().join(", "))
        }
        (_, "f" | "h") => format!("other equations {}", entry.key),
        (_, "a" | "b" | "c" | "d") => format!("another {}", entry.key.to_uppercase()),
        (_, key) => key.replace('_', " "),
    };
    let list = entries.map(one).collect::<Vec<_>>().join("; ");
    format!("The simulated plant is not the model that observers are designed for: {list}.")
}
