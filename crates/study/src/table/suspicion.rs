//! Suspicious data of a log: gaps, missing values, and outputs that are constant or stay at a limit.

use luenberger_proof::wording::{counted, significant};
use luenberger_sim::Recording;

/// A pattern in a log that suggests a sensor fault.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Suspicion {
    /// No samples for several times the median period.
    Gap {
        /// The column; none if no column has a sample.
        column: Option<String>,
        /// The last time before the gap.
        from: f64,
        /// The first time after the gap.
        to: f64,
        /// The median period.
        usual: f64,
    },
    /// An output without any value.
    Empty {
        /// Its name.
        column: String,
    },
    /// An input with missing values, in whose place the last one before is taken.
    Held {
        /// Its name.
        column: String,
        /// How many are missing.
        missing: usize,
    },
    /// A column that never changes.
    Constant {
        /// Its name.
        column: String,
        /// Its value.
        value: f64,
    },
    /// A column that stays at its largest or smallest value: a sensor in saturation.
    Saturated {
        /// Its name.
        column: String,
        /// The value.
        value: f64,
        /// Number of samples at this value.
        samples: usize,
        /// Begin and end of the longest interval.
        longest: (f64, f64),
    },
    /// A column that repeats one value exactly, within its range: a sensor dropout.
    Frozen {
        /// Its name.
        column: String,
        /// The value.
        value: f64,
        /// Number of consecutive samples at this value.
        samples: usize,
        /// Begin and end of the interval.
        during: (f64, f64),
    },
}

impl Suspicion {
    /// The sentence, with the unit of the time if it is known: `Gap 499-900 s (median Ts 1 s)`.
    pub fn in_words(&self, unit: Option<&str>) -> String {
        let unit = unit.map(|unit| format!(" {unit}")).unwrap_or_default();
        let time = |t: f64| significant(t, 6);
        match self {
            Self::Gap { column, from, to, usual } => {
                let of = column.as_ref().map(|column| format!(" of `{column}`")).unwrap_or_default();
                format!("Gap{of} {}-{}{unit} (median Ts {}{unit})", time(*from), time(*to), time(*usual))
            }
            Self::Empty { column } => format!("`{column}` has no value"),
            Self::Held { column, missing } => {
                format!("{} of the input `{column}` missing: the value before is held", counted(*missing, "value"))
            }
            Self::Constant { column, value } => format!("`{column}` is {value} throughout"),
            Self::Saturated { column, value, samples, longest: (from, to) } => format!(
                "`{column}` is at its limit {value} in {samples} samples, longest from t = {} to {}{unit}: saturation?",
                time(*from),
                time(*to)
            ),
            Self::Frozen { column, value, samples, during: (from, to) } => format!(
                "`{column}` is exactly {value} in {samples} samples in a row, from t = {} to {}{unit}: a dropout?",
                time(*from),
                time(*to)
            ),
        }
    }
}

impl core::fmt::Display for Suspicion {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(&self.in_words(None))
    }
}

/// Minimal number of consecutive equal samples, at a limit and in between.
const AT_LIMIT: usize = 4;
const IN_BETWEEN: usize = 10;

/// Coarsely quantized columns repeat values normally: repetitions are only reported if the column has at least this
/// many different values.
const DIFFERENT: usize = 100;

/// The suspicious data of a log, whose inputs and outputs have these names.
pub(super) fn suspicions(recording: &Recording, inputs: &[&str], outputs: &[&str]) -> Vec<Suspicion> {
    let usual = recording.median_period();
    let mut found: Vec<Suspicion> =
        recording.gaps().into_iter().map(|(from, to)| Suspicion::Gap { column: None, from, to, usual }).collect();
    let rows = recording.times().len();
    for (j, name) in inputs.iter().enumerate() {
        let missing = rows - recording.inputs().count(j);
        if missing > 0 {
            found.push(Suspicion::Held { column: (*name).to_owned(), missing });
        }
    }
    for (j, name) in outputs.iter().enumerate() {
        let column = (*name).to_owned();
        let there: Vec<usize> = (0..rows).filter(|k| recording.outputs().value(*k, j).is_some()).collect();
        if there.is_empty() {
            found.push(Suspicion::Empty { column });
            continue;
        }
        let usual = recording.output_period(j);
        let own = recording.output_gaps(j).into_iter().filter(|gap| !recording.gaps().contains(gap));
        found.extend(own.map(|(from, to)| Suspicion::Gap { column: Some(column.clone()), from, to, usual }));
        let t: Vec<f64> = there.iter().map(|k| recording.times()[*k]).collect();
        let y: Vec<f64> = there.iter().map(|k| recording.outputs().values()[(*k, j)]).collect();
        found.extend(stuck(name, &t, &y));
    }
    found
}

fn stuck(name: &str, t: &[f64], column: &[f64]) -> Vec<Suspicion> {
    let (low, high) =
        column.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &y| (low.min(y), high.max(y)));
    let column_name = name.to_owned();
    if low == high {
        return vec![Suspicion::Constant { column: column_name, value: low }];
    }
    let mut different = column.to_vec();
    different.sort_by(f64::total_cmp);
    different.dedup();
    if different.len() < DIFFERENT.min(column.len() / 4) {
        return Vec::new();
    }
    // Runs of equal values: start index, length.
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for (k, value) in column.iter().enumerate() {
        match runs.last_mut() {
            Some((start, length)) if column[*start] == *value => *length += 1,
            _ => runs.push((k, 1)),
        }
    }
    let span = |(start, length): (usize, usize)| (t[start], t[start + length - 1]);
    let mut found = Vec::new();
    for value in [low, high] {
        let at: Vec<_> =
            runs.iter().copied().filter(|(start, length)| column[*start] == value && *length >= AT_LIMIT).collect();
        if let Some(longest) = at.iter().copied().max_by_key(|(_, length)| *length) {
            let samples = at.iter().map(|(_, length)| length).sum();
            found.push(Suspicion::Saturated { column: column_name.clone(), value, samples, longest: span(longest) });
        }
    }
    for run in runs
        .into_iter()
        .filter(|(start, length)| *length >= IN_BETWEEN && column[*start] != low && column[*start] != high)
    {
        let (value, samples) = (column[run.0], run.1);
        found.push(Suspicion::Frozen { column: column_name.clone(), value, samples, during: span(run) });
    }
    found
}
