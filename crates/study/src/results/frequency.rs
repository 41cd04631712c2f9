//! Frequency responses of observers and of the loop, in numbers.

use serde::Serialize;

/// The frequency responses of a study. Frequencies are in radians per unit of time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FrequencyReport {
    /// First and last frequency of the figures and tables.
    pub range: [f64; 2],
    /// The linear observers.
    pub observers: Vec<ObserverFrequencies>,
    /// The loop with the feedback of the study, opened at the inputs and at the outputs of the plant.
    #[serde(rename = "loop", skip_serializing_if = "Option::is_none")]
    pub feedback: Option<LoopReport>,
}

/// How an observer amplifies measurement noise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ObserverFrequencies {
    /// Its name.
    pub observer: String,
    /// For each state the largest gain from the measurement noise v to its error, over all frequencies.
    pub noise_peaks: Vec<Peak>,
}

/// A largest singular value and the frequency at which it is attained.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Peak {
    /// The value.
    pub norm: f64,
    /// The frequency; none if it is attained in the limit.
    pub frequency: Option<f64>,
}

/// The loop `u = -K xhat`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LoopReport {
    /// The observer whose estimate is fed back.
    pub observer: String,
    /// Opened at the inputs, and at the outputs of the plant.
    pub opened: Vec<OpenedLoop>,
    /// The same with the filter for `W + q^2 B B'`, for each q that the study names.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub recovery: Vec<RecoveryReport>,
    /// Why recovery is not complete, however large q is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub obstacle: Option<String>,
}

/// A loop, opened at one side of the plant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OpenedLoop {
    /// `inputs` or `outputs`.
    pub at: &'static str,
    /// Whether the closed loop is stable, to working precision.
    pub stable: bool,
    /// The margins of each channel, with the others closed.
    pub channels: Vec<ChannelMargins>,
    /// The peak of the sensitivity; none if the loop is not stable.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensitivity: Option<Peak>,
    /// The peak of the complementary sensitivity; none if the loop is not stable.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub complementary_sensitivity: Option<Peak>,
    /// Factors between which all gains may change at once, an infinite one left out.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub all_gains: Vec<f64>,
    /// Degrees by which all phases may change at once.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub all_phases: Option<f64>,
}

/// The margins of one channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelMargins {
    /// The input or the output.
    pub channel: String,
    /// The least factor above 1 that brings the loop to -1.
    pub gain_margin: Option<Crossing>,
    /// The largest factor below 1 that does so.
    pub gain_reduction: Option<Crossing>,
    /// The smallest angle, in degrees, that does so; a lead where it is negative.
    pub phase_margin: Option<Crossing>,
    /// The shortest delay that does so.
    pub delay_margin: Option<Crossing>,
    /// All frequencies at which the loop is real and negative, and the factors.
    pub gain: Vec<Crossing>,
    /// All frequencies at which its gain is 1, and the angles in degrees.
    pub phase: Vec<Crossing>,
}

/// A margin.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Crossing {
    /// The frequency; none if it is infinite.
    pub frequency: Option<f64>,
    /// The factor, the angle or the delay.
    pub margin: f64,
}

/// A step of loop transfer recovery.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RecoveryReport {
    /// q.
    pub q: f64,
    /// The H-infinity norm of the difference of the sensitivities at the inputs, of this loop and of state feedback.
    pub difference: f64,
    /// The peak of the sensitivity at the inputs.
    pub sensitivity: Option<f64>,
    /// The smallest phase margin of an input, in degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase_margin: Option<f64>,
    /// The spectral norm of L.
    pub gain: f64,
}
