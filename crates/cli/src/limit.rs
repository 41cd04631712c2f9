//! The option `--limit`: bounds on the time and memory of a study.

use luenberger_study::Limits;
use std::str::FromStr;

/// One bound, `memory=4GiB` or `time=24h`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Limit {
    /// Bytes.
    Memory(f64),
    /// Seconds.
    Time(f64),
}

const SIZES: &[(&str, f64)] = &[
    ("KiB", 1024.0),
    ("MiB", 1_048_576.0),
    ("GiB", 1_073_741_824.0),
    ("TiB", 1_099_511_627_776.0),
    ("kB", 1e3),
    ("MB", 1e6),
    ("GB", 1e9),
    ("TB", 1e12),
];

const TIMES: &[(&str, f64)] =
    &[("min", 60.0), ("s", 1.0), ("h", 3600.0), ("days", 86400.0), ("day", 86400.0), ("d", 86400.0)];

impl FromStr for Limit {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        let expected = "expected memory=SIZE or time=TIME, such as memory=4GiB, time=30min or time=none";
        let (what, value) = word.split_once('=').ok_or(expected)?;
        match what {
            "memory" => amount(value, SIZES).map(Self::Memory),
            "time" => amount(value, TIMES).map(Self::Time),
            _ => None,
        }
        .ok_or_else(|| expected.to_owned())
    }
}

/// A positive number with one of the units, or `none`.
fn amount(word: &str, units: &[(&str, f64)]) -> Option<f64> {
    if word == "none" {
        return Some(f64::INFINITY);
    }
    let with_unit = |(unit, size): &(&str, f64)| Some(word.strip_suffix(unit)?.parse::<f64>().ok()? * size);
    units.iter().find_map(with_unit).filter(|amount| *amount > 0.0 && amount.is_finite())
}

/// A positive time in seconds, with its unit.
pub(crate) fn time(word: &str) -> Result<f64, String> {
    let found = amount(word, TIMES).filter(|seconds| seconds.is_finite());
    found.ok_or_else(|| "a positive time with its unit is expected, such as 30s or 5min".to_owned())
}

/// The limits, of which the later options replace the earlier ones and the defaults.
pub(crate) fn limits(given: &[Limit]) -> Limits {
    let mut limits = Limits::default();
    for limit in given {
        match limit {
            Limit::Memory(bytes) => limits.memory = *bytes,
            Limit::Time(seconds) => limits.seconds = *seconds,
        }
    }
    limits
}
