//! The plant as it is simulated, where it differs from the model that the observers are designed for.

use luenberger_sim as sim;
use serde::{Deserialize, Serialize};

use crate::noise::StoredNoise;
use crate::plant::StoredPlant;

/// What the observers do not know of the plant.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Truth {
    /// The plant; none if it is the model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plant: Option<StoredPlant>,
    /// Its changes, in the order of their times.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<Event>,
    /// Added to the derivatives of the states; in discrete time to the next states.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub process_noise: Option<StoredNoise>,
    /// The input reaches the plant this much later.
    pub input_delay: f64,
    /// The output is read this much later.
    pub output_delay: f64,
    /// Of the actuators.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub actuator: Option<Fault>,
    /// Of the sensors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor: Option<Fault>,
    /// Measurements are multiples of these steps, 0 for none; empty for none at all.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub quantisation: Vec<f64>,
    /// Dropouts and outliers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channel: Option<MeasurementLoss>,
}

/// A change of the plant at a time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Event {
    /// When.
    pub at: f64,
    /// The plant from then on, if it changes.
    pub plant: Option<StoredPlant>,
    /// Added to the state; empty for nothing.
    pub jump: Vec<f64>,
}

/// Gain and bias of actuators or sensors from a time on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// Factors.
    pub gain: Vec<f64>,
    /// What is added.
    pub bias: Vec<f64>,
    /// When it begins.
    pub from: f64,
}

/// Measurements that do not arrive, and outliers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeasurementLoss {
    /// The probability that a measurement does not arrive.
    pub dropout: f64,
    /// The probability of an outlier.
    pub outlier: f64,
    /// The magnitude of an outlier, one for each output.
    pub outlier_size: Vec<f64>,
    /// The period.
    pub period: f64,
    /// The seed.
    pub seed: u64,
}

impl Truth {
    /// The disturbances of a simulation, with the plant and its changes left to the caller.
    pub fn of(disturbances: &sim::Disturbances) -> Self {
        let fault = |fault: &sim::Fault| {
            let sim::Fault { gain, bias, from } = fault.clone();
            Fault { gain, bias, from }
        };
        let channel = |channel: &sim::MeasurementLoss| {
            let sim::MeasurementLoss { dropout, outlier, outlier_size, period, seed } = channel.clone();
            MeasurementLoss { dropout, outlier, outlier_size, period, seed }
        };
        Self {
            plant: None,
            events: Vec::new(),
            process_noise: disturbances.process_noise.as_ref().map(StoredNoise::of),
            input_delay: disturbances.input_delay,
            output_delay: disturbances.output_delay,
            actuator: disturbances.actuator.as_ref().map(fault),
            sensor: disturbances.sensor.as_ref().map(fault),
            quantisation: disturbances.quantisation.clone(),
            channel: disturbances.channel.as_ref().map(channel),
        }
    }

    pub(crate) fn disturbances(&self) -> sim::Disturbances {
        let fault = |fault: &Fault| {
            let Fault { gain, bias, from } = fault.clone();
            sim::Fault { gain, bias, from }
        };
        let channel = |channel: &MeasurementLoss| {
            let MeasurementLoss { dropout, outlier, outlier_size, period, seed } = channel.clone();
            sim::MeasurementLoss { dropout, outlier, outlier_size, period, seed }
        };
        sim::Disturbances {
            process_noise: self.process_noise.as_ref().map(|noise| noise.scaled(1.0)),
            input_delay: self.input_delay,
            output_delay: self.output_delay,
            output_delays: Vec::new(),
            actuator: self.actuator.as_ref().map(fault),
            sensor: self.sensor.as_ref().map(fault),
            quantisation: self.quantisation.clone(),
            channel: self.channel.as_ref().map(channel),
        }
    }
}
