//! The tables [[simulation.sensor]].

use crate::model::PlantModel;
use crate::reader::tree::Node;
use crate::reader::{Reader, check};
use crate::study::{NoiseSpec, SensorSpec};

/// The sensors; none if one has a mistake.
pub(super) fn sensors(
    node: Option<&Node>,
    plant: &PlantModel,
    noise: Option<&NoiseSpec>,
    reader: &mut Reader,
) -> Option<Vec<SensorSpec>> {
    let Some(node) = node else { return Some(Vec::new()) };
    let mut sensors: Vec<SensorSpec> = Vec::new();
    let mut sound = true;
    for node in node.list()? {
        match sensor(node, plant, noise, reader) {
            Some(sensor) if sensors.iter().any(|other| other.output == sensor.output) => {
                let name = &plant.outputs[sensor.output];
                let span = node.get("output").map_or_else(|| check::head(node), |name| name.span.clone());
                reader.wrong(span, format!("output {name:?} has two sensors"), "expected one sensor for each output");
                sound = false;
            }
            Some(sensor) => sensors.push(sensor),
            None => sound = false,
        }
    }
    sound.then_some(sensors)
}

fn sensor(node: &Node, plant: &PlantModel, noise: Option<&NoiseSpec>, reader: &mut Reader) -> Option<SensorSpec> {
    let output = reader.position(node.get("output")?, "output", &plant.outputs)?;
    let period = node.get("period")?.number().filter(|period| *period > 0.0 && period.is_finite())?;
    let offset = node.get("offset").map_or(Some(0.0), Node::number)?;
    if let Some(dt) = plant.dt {
        for (key, value) in [("period", period), ("offset", offset)] {
            let steps = value / dt;
            if let (Some(entry), true) = (node.get(key), (steps - steps.round()).abs() > 1e-6) {
                let message = format!("`{key}` is {value}, not a multiple of `dt` = {dt}");
                return reader.refuse(entry.span.clone(), message, "expected a multiple of the period of the plant");
            }
        }
    }
    Some(SensorSpec {
        output,
        period,
        offset,
        gaussian: match node.get("distribution").and_then(Node::text) {
            Some(distribution) => distribution != "uniform",
            None => noise.is_none_or(|noise| noise.gaussian),
        },
        amplitude: match node.get("amplitude") {
            Some(amplitude) => amplitude.number()?,
            None => noise.map_or(0.0, |noise| noise.amplitude[output]),
        },
        seed: match node.get("seed") {
            Some(seed) => seed.count()? as u64,
            None => noise.map_or(0, |noise| noise.seed),
        },
    })
}
