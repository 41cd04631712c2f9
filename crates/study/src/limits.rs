//! Bounds on the cost of an execution, and amounts of memory and time in words.

use std::fmt;

use luenberger_proof::wording::significant;
use luenberger_wording::setters;

/// Bounds on the cost of an execution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Memory in bytes: an execution whose estimate exceeds it is refused (default 4 GiB).
    pub memory: f64,
    /// Time in seconds: an execution whose estimate exceeds it is refused, and one that takes longer is stopped, also
    /// within a design or an integration, with its finished results kept (default 24 h).
    pub seconds: f64,
    /// Time in seconds for the alternatives to an observer that is refused, which are designed before they are named
    /// (default 5). A safeguard: designs of usual sizes do not reach it.
    pub alternatives: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { memory: 4.0 * GIB, seconds: 86400.0, alternatives: 5.0 }
    }
}

impl Limits {
    setters! { memory: f64, seconds: f64, alternatives: f64 }
}

impl Limits {
    /// No bounds.
    pub const NONE: Self = Self { memory: f64::INFINITY, seconds: f64::INFINITY, alternatives: f64::INFINITY };
}

/// Bytes of a GiB.
const GIB: f64 = 1024.0 * 1024.0 * 1024.0;

/// An estimate that exceeds its limit.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Excess {
    /// More memory than allowed.
    Memory {
        /// Estimated bytes.
        needed: f64,
        /// The limit in bytes.
        limit: f64,
        /// What takes most of it, and how to reduce it.
        mostly: &'static str,
    },
    /// More time than allowed.
    Time {
        /// Estimated seconds.
        needed: f64,
        /// The limit in seconds.
        limit: f64,
        /// What takes most of it.
        mostly: String,
    },
}

impl fmt::Display for Excess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Memory { needed, limit, mostly } => {
                let allowed = (needed / GIB * 1.25).ceil();
                write!(
                    f,
                    "the study needs about {} of memory (limit {}), most of it for {mostly}; a larger limit: \
                     --limit memory={allowed}GiB",
                    bytes(*needed),
                    bytes(*limit)
                )
            }
            Self::Time { needed, limit, mostly } => {
                let allowed = (needed / 3600.0 * 2.0).ceil();
                write!(
                    f,
                    "the study takes about {} (limit {}), most of it for the {mostly}; a longer limit: \
                     --limit time={allowed}h",
                    about(*needed),
                    duration(*limit)
                )
            }
        }
    }
}

/// A size in binary units with two digits: `1.5 GiB`.
pub fn bytes(count: f64) -> String {
    const UNITS: [(f64, &str); 4] = [(1024.0 * GIB, "TiB"), (GIB, "GiB"), (1_048_576.0, "MiB"), (1024.0, "KiB")];
    let (unit, name) = UNITS.into_iter().find(|(unit, _)| count >= *unit).unwrap_or((1.0, "B"));
    format!("{} {name}", significant(count / unit, 2))
}

/// A time with its unit: `1.5 h`, `30 s`.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s >= 2.0 * 86400.0 => format!("{} days", significant(s / 86400.0, 3)),
        s if s >= 3600.0 => format!("{} h", significant(s / 3600.0, 3)),
        s if s >= 120.0 => format!("{} min", significant(s / 60.0, 3)),
        s => format!("{} s", significant(s, 3)),
    }
}

/// An order of magnitude: one digit, in the largest unit of which there is at least one.
pub fn about(seconds: f64) -> String {
    const UNITS: [(f64, &str); 4] = [(86400.0, "day"), (3600.0, "hour"), (60.0, "minute"), (1.0, "second")];
    let (unit, name) = UNITS.into_iter().find(|(unit, _)| seconds >= *unit).unwrap_or((1.0, "second"));
    let count = (seconds / unit).max(1.0);
    let digit = 10f64.powf(count.log10().floor());
    let count = (count / digit).round() * digit;
    format!("{count} {name}{}", if count == 1.0 { "" } else { "s" })
}
