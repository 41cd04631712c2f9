//! The table [truth]: the plant as it is, where it is not as the observers take it to be.

use luenberger_sim::{Channel, Disturbances, Fault, Noise};

use super::tree::{Entry, Node, Value};
use super::{Reader, Reported, check, plant};
use crate::model::PlantModel;
use crate::study::{Simulation, Truth};

pub(super) fn truth(
    (root, node): (&Node, &Node),
    plant: &PlantModel,
    simulation: &Simulation,
    reader: &mut Reader,
) -> Option<Truth> {
    let (n, m, p) = (plant.states.len(), plant.inputs.len(), plant.outputs.len());
    let model = match node.get("parameters") {
        Some(parameters) => Some(varied(root.get("plant")?, parameters, reader)?.model),
        None => None,
    };
    let process_noise = match node.get("process_noise") {
        None => None,
        Some(noise) => {
            let amplitude = reader.numbers(noise.get("amplitude")?, "amplitude", n, "state")?;
            let (period, seed) =
                (noise.get("period")?.number()?, noise.get("seed").map_or(Some(0), Node::count)? as u64);
            let uniform = noise.get("distribution").and_then(Node::text) == Some("uniform");
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
        actuator: fault(node, "actuator", (m, "input"), reader).ok()?,
        sensor: fault(node, "sensor", (p, "output"), reader).ok()?,
        quantisation,
        channel: channel(node, p, simulation, reader).ok()?,
    };
    let words = words(node);
    Some(Truth { model, disturbances, words })
}

/// The plant with other values of some of its parameters.
fn varied(plant_node: &Node, parameters: &Node, reader: &mut Reader) -> Option<PlantModel> {
    let known: Vec<String> = match plant_node.get("parameters") {
        Some(node) => node.entries().iter().map(|entry| entry.key.clone()).collect(),
        None => Vec::new(),
    };
    let mut sound = true;
    for entry in parameters.entries() {
        if !known.contains(&entry.key) {
            let expected = if known.is_empty() {
                "expected a [plant] of expressions with `parameters`".to_owned()
            } else {
                format!("expected one of {}", known.join(", "))
            };
            reader.wrong(entry.span.clone(), format!("the plant has no parameter `{}`", entry.key), expected);
            sound = false;
        }
    }
    if !sound {
        return None;
    }
    let mut tree = plant_node.clone();
    if let Value::Table(entries) = &mut tree.value
        && let Some(Entry { node: Node { value: Value::Table(given), .. }, .. }) =
            entries.iter_mut().find(|entry| entry.key == "parameters")
    {
        for entry in given {
            if let Some(other) = parameters.get(&entry.key) {
                entry.node.value = other.value.clone();
            }
        }
    }
    let mut inner = Reader { mistakes: Vec::new(), absences: Vec::new(), folder: reader.folder.clone(), dt: reader.dt };
    let plant = plant::plant(&tree, &mut inner);
    if plant.is_none() {
        let why = inner.mistakes.into_iter().chain(inner.absences).next();
        let (message, expected) = why.map_or_else(Default::default, |mistake| (mistake.message, mistake.expected));
        reader.wrong(parameters.span.clone(), format!("with these parameters: {message}"), expected);
    }
    plant
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
) -> Result<Option<Channel>, Reported> {
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
    Ok(Some(Channel { dropout, outlier, outlier_size, period, seed }))
}

/// The table as a sentence.
fn words(node: &Node) -> String {
    let entries = node.entries().iter().filter(|entry| !["seed", "period"].contains(&entry.key.as_str()));
    let one = |entry: &Entry| match &entry.node.value {
        Value::Number(x, _) => format!("{} = {x}", entry.key),
        Value::Table(inner) if entry.key == "parameters" => {
            let values = inner.iter().filter_map(|entry| Some(format!("{} = {}", entry.key, entry.node.number()?)));
            values.collect::<Vec<_>>().join(", ")
        }
        _ => entry.key.clone(),
    };
    let list = entries.map(one).collect::<Vec<_>>().join("; ");
    format!("The simulated plant is not the model that observers are designed for: {list}.").replace('_', " ")
}
