//! Noise as a page stores it.

use serde::{Deserialize, Serialize};

/// Noise of the outputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredNoise {
    /// Gaussian if true, otherwise uniform.
    pub gaussian: bool,
    /// Standard deviations or amplitudes, one for each output.
    pub amplitude: Vec<f64>,
    /// The hold time of each value.
    pub period: f64,
    /// The seed.
    pub seed: u64,
}

impl StoredNoise {
    /// The noise of a simulation.
    pub fn of(noise: &luenberger_sim::Noise) -> Self {
        Self {
            gaussian: noise.is_gaussian(),
            amplitude: noise.amplitude().to_vec(),
            period: noise.period(),
            seed: noise.seed(),
        }
    }

    /// The noise with its amplitude times a factor.
    pub(crate) fn scaled(&self, factor: f64) -> luenberger_sim::Noise {
        let amplitude: Vec<f64> = self.amplitude.iter().map(|amplitude| factor * amplitude).collect();
        let with = if self.gaussian { luenberger_sim::Noise::gaussian } else { luenberger_sim::Noise::uniform };
        with(&amplitude, self.period, self.seed)
    }
}
