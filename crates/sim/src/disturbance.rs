//! Disturbances that the observers do not know: process noise, delays, faults of actuators
//! and sensors, quantisation, dropouts and outliers.
//!
//! The plant gets `gain u(t - d) + bias` and process noise in its derivative (in discrete time, in its next state); of
//! its output the observers read `gain y(t - d) + bias` with the measurement noise, rounded to the quantisation, with
//! outliers; a value that does not arrive is no measurement ([`sensor`](crate::sensor)). The observers themselves are
//! given the input u as it is commanded.
//!
//! A delayed quantity is read from the dense output, and no step of the integrator is longer than a delay, so that
//! feedback through a delay is integrated by the method of steps (Bellen and Zennaro, 2003, section 3). Before the
//! start everything has the value of the start.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use luenberger_random::{Purpose, Stream};

use crate::dense::Dense;
use crate::error::{SimError, check, check_finite, check_positive};
use crate::noise::Noise;

/// Gain and bias of an actuator or a sensor from a time on; before it they are 1 and 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Factor of each input or output.
    pub gain: Vec<f64>,
    /// Bias added to each input or output.
    pub bias: Vec<f64>,
    /// Time at which the fault begins.
    pub from: f64,
}

impl Fault {
    fn check(&self, what: &str, entries: usize) -> Result<(), SimError> {
        check(&format!("the gain of {what}"), &self.gain, entries)?;
        check(&format!("the bias of {what}"), &self.bias, entries)?;
        check_finite(&format!("the start of the fault of {what}"), &[self.from])
    }

    fn apply(&self, t: f64, entries: &mut [f64]) {
        if t >= self.from {
            for ((entry, gain), bias) in entries.iter_mut().zip(&self.gain).zip(&self.bias) {
                *entry = gain * *entry + bias;
            }
        }
    }
}

/// Dropouts and outliers of the measurements. They are drawn at each measurement for an output with a
/// [`Sensor`](crate::Sensor), and every `period` for the others.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasurementLoss {
    /// The probability of a dropout: that a measurement does not arrive, or for an output without a sensor that it is
    /// not measured during one period.
    pub dropout: f64,
    /// The probability of an outlier.
    pub outlier: f64,
    /// The magnitude of an outlier, one for each output; its sign is random.
    pub outlier_size: Vec<f64>,
    /// The period.
    pub period: f64,
    /// The seed.
    pub seed: u64,
}

/// Disturbances of plant, actuators and sensors; the observers do not know them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Disturbances {
    /// Added to the derivative of the plant, or to the next state of one in discrete time; one entry for each state,
    /// held over its period.
    pub process_noise: Option<Noise>,
    /// Delay from the commanded input to the plant, in units of time.
    pub input_delay: f64,
    /// Delay of the outputs that the observers read, in units of time.
    pub output_delay: f64,
    /// Further delays, one for each output; empty for none.
    pub output_delays: Vec<f64>,
    /// Fault of the actuators; `None` for none.
    pub actuator: Option<Fault>,
    /// Fault of the sensors; `None` for none.
    pub sensor: Option<Fault>,
    /// Quantisation steps, one for each output, 0 for an output without; empty for no quantisation.
    pub quantisation: Vec<f64>,
    /// Dropouts and outliers.
    pub channel: Option<MeasurementLoss>,
}

impl Disturbances {
    pub(crate) fn check(&self, states: usize, inputs: usize, outputs: usize) -> Result<(), SimError> {
        if let Some(noise) = &self.process_noise {
            noise.check(states)?;
        }
        for (what, delay) in [("the input delay", self.input_delay), ("the output delay", self.output_delay)] {
            if delay != 0.0 {
                check_positive(what, delay)?;
            }
        }
        if !self.output_delays.is_empty() {
            check("the delays of the outputs", &self.output_delays, outputs)?;
        }
        for delay in self.output_delays.iter().filter(|delay| **delay != 0.0) {
            check_positive("the delay of an output", *delay)?;
        }
        if let Some(fault) = &self.actuator {
            fault.check("the actuators", inputs)?;
        }
        if let Some(fault) = &self.sensor {
            fault.check("the sensors", outputs)?;
        }
        if !self.quantisation.is_empty() {
            check("the quantisation", &self.quantisation, outputs)?;
        }
        if let Some(channel) = &self.channel {
            check("the size of outliers", &channel.outlier_size, outputs)?;
            check_positive("the period of dropouts and outliers", channel.period)?;
            for (what, value) in [("dropouts", channel.dropout), ("outliers", channel.outlier)] {
                if !(0.0..=1.0).contains(&value) {
                    return Err(SimError::Probability { what, value });
                }
            }
        }
        Ok(())
    }

    /// The delay of output j.
    fn delay(&self, j: usize) -> f64 {
        self.output_delay + self.output_delays.get(j).copied().unwrap_or(0.0)
    }

    /// The delays of the outputs, or that of all.
    fn of_outputs(&self) -> impl Iterator<Item = f64> {
        (0..self.output_delays.len().max(1)).map(|j| self.delay(j))
    }

    /// Whether inputs reach the plant, and outputs the observers, without delay, fault and quantisation.
    pub(crate) fn leave_signals(&self) -> bool {
        self.input_delay == 0.0
            && self.output_delay == 0.0
            && self.output_delays.iter().all(|delay| *delay == 0.0)
            && self.actuator.is_none()
            && self.sensor.is_none()
            && self.quantisation.is_empty()
    }

    /// The shortest delay; no step of the integrator is longer.
    pub(crate) fn shortest_delay(&self) -> f64 {
        let delays = self.of_outputs().chain([self.input_delay]).filter(|delay| *delay > 0.0);
        delays.fold(f64::INFINITY, f64::min)
    }

    /// Times at which the plant jumps because something jumped at `times`, or because a fault begins.
    pub(crate) fn breakpoints(&self, times: &[f64]) -> Vec<f64> {
        let faults = [&self.actuator, &self.sensor].into_iter().flatten().map(|fault| fault.from);
        let both = self.of_outputs().map(|delay| self.input_delay + delay);
        let mut delays: Vec<f64> = [self.input_delay].into_iter().chain(self.of_outputs()).chain(both).collect();
        delays.sort_by(f64::total_cmp);
        delays.dedup();
        let delayed = delays.into_iter().filter(|delay| *delay > 0.0);
        delayed.flat_map(|delay| times.iter().map(move |t| t + delay)).chain(faults).collect()
    }

    /// The input that reaches the plant, from the one that is commanded and those that were.
    pub(crate) fn applied(&self, t: f64, history: &History, offset: usize, u: &[f64], applied: &mut [f64]) {
        applied.copy_from_slice(u);
        if self.input_delay > 0.0 {
            history.at(t, self.input_delay, offset, applied);
        }
        if let Some(fault) = &self.actuator {
            fault.apply(t, applied);
        }
    }

    /// What is read of the output `y`, before and without what does not arrive.
    pub(crate) fn read(
        &self,
        t: f64,
        history: &History,
        offset: usize,
        noise: &[f64],
        (y, seen): (&[f64], &mut [f64]),
    ) {
        seen.copy_from_slice(y);
        for (j, seen) in seen.chunks_exact_mut(1).enumerate() {
            let delay = self.delay(j);
            if delay > 0.0 {
                history.at(t, delay, offset + j, seen);
            }
        }
        if let Some(fault) = &self.sensor {
            fault.apply(t, seen);
        }
        for (seen, noise) in seen.iter_mut().zip(noise) {
            *seen += noise;
        }
        for (seen, step) in seen.iter_mut().zip(&self.quantisation) {
            if *step > 0.0 {
                *seen = (*seen / step).round() * step;
            }
        }
    }
}

impl MeasurementLoss {
    /// Whether value `k` of an output arrives, in the run of this member.
    pub(crate) fn arrives(&self, member: u64, output: usize, k: u64) -> bool {
        let stream = Stream::new(self.seed, Purpose::Dropout, output as u64).member(member);
        self.dropout == 0.0 || stream.draws(k).uniform() >= self.dropout
    }

    /// The outlier of value `k` of an output, 0 for none, in the run of this member.
    pub(crate) fn outlier(&self, member: u64, output: usize, k: u64) -> f64 {
        if self.outlier == 0.0 {
            return 0.0;
        }
        let mut draws = Stream::new(self.seed, Purpose::Outlier, output as u64).member(member).draws(k);
        let size = if draws.uniform() < self.outlier { self.outlier_size[output] } else { 0.0 };
        if draws.uniform() >= 0.5 { size } else { -size }
    }
}

/// What has been, for delays.
#[derive(Clone, Default)]
pub(crate) struct History {
    pub(crate) dense: Rc<RefCell<Dense>>,
    /// A time within the interval that is integrated; infinite at its end, when what happens there has happened. It
    /// decides on which side of a jump a delayed quantity is read.
    pub(crate) within: Cell<f64>,
    /// Input and output at the start: the row that was before.
    pub(crate) first: Vec<f64>,
}

impl History {
    /// The entries from `offset` on at `t - delay`; left as they are while nothing has been.
    fn at(&self, t: f64, delay: f64, offset: usize, entries: &mut [f64]) {
        let dense = self.dense.borrow();
        let side = if self.within.get() >= t { 1e-9 } else { -1e-9 };
        let picked = t - delay + side * delay;
        if dense.step_count() == 0 || picked < dense.span().0 {
            if let Some(first) = self.first.get(offset..offset + entries.len()) {
                entries.copy_from_slice(first);
            }
            return;
        }
        let (step, (start, end)) = dense.step_near(picked);
        dense.on_step(step, (t - delay).clamp(start, end), offset, entries);
    }
}
