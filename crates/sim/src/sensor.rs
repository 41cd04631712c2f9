//! Sensors with individual sampling periods, and how observers treat an output that is not measured.
//!
//! A [`Sensor`] measures one output every period, from an offset on; its noise is drawn anew at each measurement. An
//! output without one is read at all times. A measurement that does not arrive ([`MeasurementLoss::dropout`]) is no
//! measurement.
//!
//! | observer | at a measurement | otherwise |
//! |---|---|---|
//! | a filter with a covariance | is updated by the outputs that are measured at its sample | predicts |
//! | another sampled one | takes the outputs that are measured at its sample | takes the output that it predicts, h(xhat): its innovation is zero |
//! | one in continuous time | takes the measurement, which moves with the model until the next one is due | takes the output that it predicts |
//!
//! It is the same with logs ([`replay`](crate::replay)). A measurement between two samples of a sampled observer is not
//! used. An observer of some states only predicts no output, and holds the last one, unless its correction leaves out
//! what was not measured; so does every one in continuous time with
//! [`Scenario::hold_measurements`](crate::Scenario::hold_measurements).

use luenberger_random::Purpose;

use crate::disturbance::MeasurementLoss;
use crate::error::{SimError, check_positive};
use crate::noise::Noise;

/// Share of the period by which a time and a measurement may differ and be the same.
const SAME: f64 = 1e-6;

/// A sensor that measures one output periodically.
///
/// ```
/// use luenberger_observers::{ExtendedKalmanFilter, NoiseModel};
/// use luenberger_sim::{Scenario, Sensor};
/// use nalgebra::{Matrix1, Matrix2};
/// let plant = luenberger_plants::double_integrator();
/// let noises = NoiseModel { w: Matrix2::zeros(), v: Matrix1::new(1e-4), p0: Matrix2::identity() };
/// let filter = ExtendedKalmanFilter::new(plant.clone(), noises, 0.1, 1)?;
/// // The filter runs every 0.1, the sensor every 0.5.
/// let run = Scenario::new(plant)
///     .initial_state(&[1.0, -1.0])
///     .sensor(Sensor::new(0, 0.5).gaussian(0.01, 7))
///     .sampled_observer("filter", filter, &[0.0, 0.0])
///     .until(5.0, 51)
///     .run()?;
/// assert!(run.is_measured(0, 1.5) && !run.is_measured(0, 1.6));
/// assert!(run.observers[0].error.row(50).norm() < 0.05);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    output: usize,
    period: f64,
    offset: f64,
    /// One entry.
    noise: Option<Noise>,
}

impl Sensor {
    /// A sensor of this output (from 0) that measures at the start and every `period` after it, without noise.
    pub fn new(output: usize, period: f64) -> Self {
        Self { output, period, offset: 0.0, noise: None }
    }

    /// The first measurement is this much after the start.
    #[must_use]
    pub fn offset(self, offset: f64) -> Self {
        Self { offset, ..self }
    }

    /// Gaussian noise of this standard deviation. Sensors of different outputs with one seed have different noise.
    #[must_use]
    pub fn gaussian(self, deviation: f64, seed: u64) -> Self {
        let noise = Noise::gaussian(&[deviation], self.period, seed);
        Self { noise: Some(noise), ..self }
    }

    /// Noise that is uniform on `[-amplitude, amplitude]`.
    #[must_use]
    pub fn uniform(self, amplitude: f64, seed: u64) -> Self {
        let noise = Noise::uniform(&[amplitude], self.period, seed);
        Self { noise: Some(noise), ..self }
    }

    /// The output that it measures, from 0.
    pub fn output(&self) -> usize {
        self.output
    }

    /// The time between two measurements.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// The first measurement `(k = 0)` after the start.
    pub(crate) fn delay(&self) -> f64 {
        self.offset
    }

    /// The noise of measurement k in the run of this member.
    pub(crate) fn noise(&self, member: u64, k: u64) -> f64 {
        let value = |noise: &Noise| {
            let stream = noise.stream(Purpose::SensorNoise, self.output as u64).member(member);
            noise.values(stream, k).next()
        };
        self.noise.as_ref().and_then(value).unwrap_or(0.0)
    }

    /// How many of the measurements up to `end` lie on multiples of `period`, and how many there are; times are those
    /// after the start.
    pub fn on_samples(&self, period: f64, end: f64) -> (u64, u64) {
        if end < self.offset {
            return (0, 0);
        }
        let all = ((end - self.offset) / self.period + SAME).floor() as u64 + 1;
        let lies = |k: &u64| {
            let phase = (self.offset + *k as f64 * self.period) / period;
            (phase - phase.round()).abs() <= SAME
        };
        ((0..all).filter(lies).count() as u64, all)
    }
}

/// When the outputs of a run are measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Sampling {
    pub(crate) start: f64,
    /// The sensor of each output, where it has one of its own.
    pub(crate) sensors: Vec<Option<Sensor>>,
    pub(crate) channel: Option<MeasurementLoss>,
    /// The number of the run in its ensemble.
    pub(crate) member: u64,
}

impl Sampling {
    /// The sampling of so many outputs.
    pub(crate) fn new(
        start: f64,
        outputs: usize,
        sensors: Vec<Sensor>,
        channel: Option<MeasurementLoss>,
        member: u64,
    ) -> Result<Self, SimError> {
        let mut of: Vec<Option<Sensor>> = vec![None; outputs];
        for sensor in sensors {
            check_positive("the period of a sensor", sensor.period)?;
            if sensor.offset != 0.0 {
                check_positive("the offset of a sensor", sensor.offset)?;
            }
            if let Some(noise) = &sensor.noise {
                noise.check(1)?;
            }
            let output = sensor.output;
            let count = outputs;
            let place = of.get_mut(output).ok_or(SimError::Index { what: "output", index: output, count })?;
            if place.replace(sensor).is_some() {
                return Err(SimError::SensorTwice { output });
            }
        }
        Ok(Self { start, sensors: of, channel, member })
    }

    /// The shortest period of a sensor; infinite without one.
    pub(crate) fn shortest_period(&self) -> f64 {
        self.sensors.iter().flatten().map(|sensor| sensor.period).fold(f64::INFINITY, f64::min)
    }

    /// Whether every output is read at all times.
    pub(crate) fn is_continuous(&self) -> bool {
        self.channel.is_none() && self.sensors.iter().all(Option::is_none)
    }

    /// Whether value `k` of an output arrives.
    pub(crate) fn arrives(&self, k: u64, output: usize) -> bool {
        self.channel.as_ref().is_none_or(|channel| channel.arrives(self.member, output, k))
    }

    /// The outlier of value `k` of an output, 0 for none.
    pub(crate) fn outlier(&self, k: u64, output: usize) -> f64 {
        self.channel.as_ref().map_or(0.0, |channel| channel.outlier(self.member, output, k))
    }

    /// Whether an output is measured at t, and the measurement arrives.
    pub(crate) fn is_measured(&self, output: usize, t: f64) -> bool {
        let since = t - self.start;
        match (self.sensors.get(output), &self.channel) {
            (Some(Some(sensor)), _) => {
                let phase = (since - sensor.offset) / sensor.period;
                let k = phase.round();
                k >= 0.0 && (phase - k).abs() <= SAME && self.arrives(k as u64, output)
            }
            (Some(None), Some(channel)) => self.arrives((since / channel.period + SAME).floor() as u64, output),
            (known, _) => known.is_some(),
        }
    }
}

/// What is known of an output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reading {
    /// It is read now.
    Now,
    /// Its last measurement, until the next one is due.
    Held(f64),
    /// Nothing: the measurement did not arrive, or there has been none.
    Nothing,
}
