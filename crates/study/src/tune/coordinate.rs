//! What is fitted as the search sees it: positive numbers by their logarithms.

use crate::study::{Tunable, Tuned};

/// A coordinate of the search: `value = exp(x)`, or `value = origin + scale x`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Coordinate {
    is_log: bool,
    origin: f64,
    scale: f64,
    pub(super) low: f64,
    pub(super) high: f64,
    /// Whether the bounds are those of the study.
    pub(super) is_given: bool,
}

/// A positive number without bounds stays within this factor of its value.
const FACTOR: f64 = 1e6;

/// One of the observer itself, such as the rate of a pole, within this one: a faster observer takes smaller steps.
const FACTOR_OF_OWN: f64 = 1e3;

/// Another number without bounds stays within so many units.
const REACH: f64 = 100.0;

impl Coordinate {
    /// The coordinate of a parameter; of one that is not positive, in units of `unit` unless the study gives bounds.
    pub(super) fn new(one: &Tuned, unit: f64) -> Self {
        let is_given = one.bounds.is_some();
        if one.value > 0.0 && one.bounds.is_none_or(|(low, _)| low > 0.0) {
            let factor = if matches!(one.what, Tunable::Own(..)) { FACTOR_OF_OWN } else { FACTOR };
            let (low, high) = one.bounds.unwrap_or((one.value / factor, one.value * factor));
            return Self { is_log: true, origin: 0.0, scale: 1.0, low: low.ln(), high: high.ln(), is_given };
        }
        let scale = one.bounds.map_or(unit, |(low, high)| 0.1 * (high - low));
        let (low, high) = one.bounds.unwrap_or((one.value - REACH * scale, one.value + REACH * scale));
        let origin = one.value;
        Self { is_log: false, origin, scale, low: (low - origin) / scale, high: (high - origin) / scale, is_given }
    }

    pub(super) fn is_log(&self) -> bool {
        self.is_log
    }

    pub(super) fn value(&self, x: f64) -> f64 {
        if self.is_log { x.exp() } else { self.origin + self.scale * x }
    }

    pub(super) fn of(&self, value: f64) -> f64 {
        if self.is_log { value.ln() } else { (value - self.origin) / self.scale }
    }

    /// The derivative of the value.
    pub(super) fn slope(&self, x: f64) -> f64 {
        if self.is_log { x.exp() } else { self.scale }
    }

    /// A standard deviation beyond this says nothing: a factor of 10, or half of the way to a bound.
    pub(super) fn vague(&self) -> f64 {
        if self.is_log { std::f64::consts::LN_10 } else { 0.25 * (self.high - self.low) }
    }

    /// How far a random start is from the value of the study, at most.
    pub(super) fn spread(&self) -> f64 {
        if self.is_log { std::f64::consts::LN_10 } else { 1.0 }
    }

    /// Which bound a point is at, if at one: -1 or 1.
    pub(super) fn bound(&self, x: f64) -> Option<f64> {
        let close = 1e-3 * (self.high - self.low);
        if x - self.low < close {
            Some(-1.0)
        } else if self.high - x < close {
            Some(1.0)
        } else {
            None
        }
    }
}
