//! The entry types of the definiteness tests.

use crate::exact::Exact;
use crate::interval::Interval;
use crate::ring::Ring;

/// A matrix entry: a binary64 number (taken as exact), an interval, or an exact number.
pub trait Entry: Clone {
    /// An interval that contains the entry.
    /// # Errors
    /// The entry itself if it is NaN or infinite.
    fn enclosure(&self) -> Result<Interval, f64>;
    /// The exact value, if the entry is a single number.
    fn exact(&self) -> Option<Exact>;
}

impl Entry for f64 {
    fn enclosure(&self) -> Result<Interval, f64> {
        Interval::from_f64(*self).ok_or(*self)
    }

    fn exact(&self) -> Option<Exact> {
        Exact::from_f64(*self)
    }
}

impl Entry for Interval {
    fn enclosure(&self) -> Result<Interval, f64> {
        Ok(*self)
    }

    fn exact(&self) -> Option<Exact> {
        if self.is_point() { Exact::from_f64(self.lo()) } else { None }
    }
}

impl Entry for Exact {
    fn enclosure(&self) -> Result<Interval, f64> {
        Ok(Exact::enclosure(self))
    }

    fn exact(&self) -> Option<Exact> {
        Some(self.clone())
    }
}
