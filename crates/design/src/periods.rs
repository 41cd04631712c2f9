//! Bounds of varying sampling periods, and sequences of periods for which the error grows.

use core::fmt;

use luenberger_proof::wording::{self, counted, significant};

/// Bounds of the sampling period, and the largest number of consecutive missed samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Periods {
    /// The shortest period.
    pub shortest: f64,
    /// The longest period.
    pub longest: f64,
    /// Largest number of consecutive missed samples.
    pub misses: usize,
}

impl Periods {
    /// Whether every sample comes after the same period.
    pub fn is_constant(&self) -> bool {
        self.shortest >= self.longest && self.misses == 0
    }
}

impl fmt::Display for Periods {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { shortest, longest, misses } = self;
        write!(f, "periods from {} to {}", wording::shortest(*shortest), wording::shortest(*longest))?;
        match misses {
            0 => write!(f, " without missed samples"),
            misses => write!(f, " with at most {} in a row", counted(*misses, "missed sample")),
        }
    }
}

/// Times between corrections for which the error grows, if they are repeated.
#[derive(Debug, Clone, PartialEq)]
pub struct GrowingTimes {
    /// The times, in their order.
    pub times: Vec<f64>,
    /// The spectral radius of the product of their maps, computed in floating point: above 1.
    pub radius: f64,
}

impl fmt::Display for GrowingTimes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let times: Vec<String> = self.times.iter().map(|t| significant(*t, 6)).collect();
        let radius = significant(self.radius, 6);
        write!(
            f,
            "with the {} {} between corrections, repeated, the error grows: the product of exp(A t)(I - KC) has the spectral radius {radius}",
            if times.len() == 1 { "time" } else { "times" },
            times.join(", ")
        )
    }
}
