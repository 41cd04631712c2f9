//! The quantities of designs whose meaning is explained, and that others ask for.

/// A quantity of a design.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// A proved rate.
    Rate,
    /// The rate in the end, by the poles.
    DecayRate,
    /// The factor before the proved exponential.
    Overshoot,
    /// Vertices of the polytope.
    Vertices,
    /// The spectral norm of L.
    GainNorm,
    /// The noise gain.
    NoiseGain,
    /// The fastest pole of the observer relative to that of the plant.
    SpeedRatio,
    /// The sampling period.
    Period,
    /// The largest modulus of a pole in discrete time.
    LargestPole,
}

impl Quantity {
    /// All, in the order of their explanations.
    pub(crate) const ALL: [Self; 9] = [
        Self::Rate,
        Self::DecayRate,
        Self::Overshoot,
        Self::Vertices,
        Self::GainNorm,
        Self::NoiseGain,
        Self::SpeedRatio,
        Self::Period,
        Self::LargestPole,
    ];

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rate => "rate",
            Self::DecayRate => "decay rate",
            Self::Overshoot => "overshoot",
            Self::Vertices => "vertices",
            Self::GainNorm => "norm of L",
            Self::NoiseGain => "noise gain",
            Self::SpeedRatio => "fastest pole relative to the plant",
            Self::Period => "period",
            Self::LargestPole => "largest modulus of a pole",
        }
    }

    /// What it means.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Rate => "The error decays at least like exp(-rate t).",
            Self::DecayRate => {
                "The error decays in the end like exp(-t times the rate): distance of the poles from the imaginary axis."
            }
            Self::Overshoot => {
                "The factor before exp(-rate t): the error is never larger than the overshoot times the initial error."
            }
            Self::Vertices => {
                "The number of combinations of extreme values of the Jacobians over the region; the conditions hold at each."
            }
            Self::GainNorm => "The largest singular value of the gain.",
            Self::NoiseGain => {
                "White measurement noise of unit intensity leaves errors whose variances sum to the square of this number, by the linear part of the error equation."
            }
            Self::SpeedRatio => {
                "The largest modulus of a pole of A - L C, divided by that of A: large values need short sampling periods."
            }
            Self::Period => "The time between two samples.",
            Self::LargestPole => "The error shrinks in the end by this factor from sample to sample.",
        }
    }
}

/// The name of a number: that of a quantity, or of one design alone.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Label {
    pub(crate) name: String,
    pub(crate) quantity: Option<Quantity>,
}

impl From<Quantity> for Label {
    fn from(quantity: Quantity) -> Self {
        Self { name: quantity.name().to_owned(), quantity: Some(quantity) }
    }
}

impl From<&str> for Label {
    fn from(name: &str) -> Self {
        Self { name: name.to_owned(), quantity: None }
    }
}

impl From<&String> for Label {
    fn from(name: &String) -> Self {
        name.as_str().into()
    }
}
