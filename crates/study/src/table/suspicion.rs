//! Suspicious data of a log: gaps, missing values, and outputs that are constant or stay at a limit.

use luenberger_proof::wording::{counted, significant};
use luenberger_sim::Recording;

use crate::statistics::percentile;

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
    /// An output that the logger repeats until it is measured again; each measurement counts once.
    Repeated {
        /// Its name.
        column: String,
        /// Rows from one measurement to the next, in the median.
        each: usize,
        /// Number of measurements.
        measurements: usize,
    },
    /// Times that are whole numbers far apart, as microseconds and nanoseconds are.
    Ticks {
        /// The column of times.
        column: String,
        /// The median distance.
        usual: f64,
    },
    /// Several of one kind, of the same column.
    Several {
        /// The first.
        first: Box<Self>,
        /// How many there are.
        count: usize,
    },
    /// An output that jumps to and fro from row to row, as where two sensors write into one column.
    Alternating {
        /// Its name.
        column: String,
        /// How far it jumps from one value to the next, in the median.
        step: f64,
        /// How far it is from a value to the one after the next.
        over_two: f64,
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
    pub fn in_words(&self, time_unit: Option<&str>) -> String {
        let unit = time_unit.map(|unit| format!(" {unit}")).unwrap_or_default();
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
            Self::Repeated { column, each, measurements } => format!(
                "`{column}` changes in about every {} row: taken for {measurements} measurements that the logger repeats, each of which counts once (`repeats = \"measured\"` counts every row)",
                ordinal(*each)
            ),
            Self::Ticks { column, usual } => {
                let (name, second) = if *usual < 2e6 { ("micro", "1e6") } else { ("nano", "1e9") };
                format!(
                    "the times are whole numbers, {} apart in the median: where they are {name}seconds, `time = \"{column}/{second}\"` has seconds",
                    time(*usual)
                )
            }
            Self::Several { first, count } => format!("{}; the first of {count}", first.in_words(time_unit)),
            Self::Alternating { column, step, over_two } => format!(
                "`{column}` jumps to and fro by {} from value to value, and moves by {} over two (medians): two sensors in one column?",
                significant(*step, 3),
                significant(*over_two, 3)
            ),
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

/// `10th`, `2nd`.
fn ordinal(count: usize) -> String {
    let ending = match (count % 10, count % 100) {
        (_, 11..=13) => "th",
        (1, _) => "st",
        (2, _) => "nd",
        (3, _) => "rd",
        _ => "th",
    };
    format!("{count}{ending}")
}

/// More than this many of one kind and column are one, with their number.
const SINGLY: usize = 3;

/// Those of one kind and column as one, at the place of the first, if there are many.
fn grouped(all: Vec<Suspicion>) -> Vec<Suspicion> {
    let is_like = |one: &Suspicion, other: &Suspicion| match (one, other) {
        (Suspicion::Gap { column: one, .. }, Suspicion::Gap { column: other, .. }) => one == other,
        (Suspicion::Frozen { column: one, .. }, Suspicion::Frozen { column: other, .. }) => one == other,
        _ => false,
    };
    let mut kinds: Vec<Vec<Suspicion>> = Vec::new();
    for suspicion in all {
        match kinds.iter_mut().find(|kind| is_like(&kind[0], &suspicion)) {
            Some(kind) => kind.push(suspicion),
            None => kinds.push(vec![suspicion]),
        }
    }
    let said = |mut kind: Vec<Suspicion>| {
        let count = kind.len();
        if count > SINGLY {
            kind.truncate(1);
            kind = kind.into_iter().map(|first| Suspicion::Several { first: Box::new(first), count }).collect();
        }
        kind
    };
    kinds.into_iter().flat_map(said).collect()
}

/// Whether times look like those of a counter: whole numbers, a thousand or more apart in the median, and no minutes.
fn ticks(recording: &Recording, time: &str) -> Option<Suspicion> {
    let usual = recording.median_period();
    let is_whole = recording.times().iter().all(|t| t.fract() == 0.0);
    let is_counter = is_whole && usual >= 1000.0 && usual % 60.0 != 0.0;
    is_counter.then(|| Suspicion::Ticks { column: time.to_owned(), usual })
}

/// Minimal number of consecutive equal samples, at a limit and in between.
const AT_LIMIT: usize = 4;
const IN_BETWEEN: usize = 10;

/// A smooth signal is on its highest step for at most this many times as long as on the step below: 2/(sqrt(2) - 1) is
/// 4.8 for a parabola that just reaches it.
const TURN: usize = 6;

/// Coarsely quantized columns repeat values normally: repetitions are only reported if the column has at least this
/// many different values.
const DIFFERENT: usize = 100;

/// The suspicious data of a log, whose times, inputs and outputs have these names.
/// `repeated` says in how many rows an output is repeated.
pub(super) fn suspicions(
    recording: &Recording,
    time: &str,
    (inputs, outputs): (&[&str], &[&str]),
    repeated: &[Option<usize>],
) -> Vec<Suspicion> {
    let usual = recording.median_period();
    let mut found: Vec<Suspicion> = ticks(recording, time).into_iter().collect();
    found.extend(recording.gaps().into_iter().map(|(from, to)| Suspicion::Gap { column: None, from, to, usual }));
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
        if let Some(each) = repeated[j] {
            found.push(Suspicion::Repeated { column: column.clone(), each, measurements: there.len() });
        }
        let own = recording.output_gaps(j).into_iter().filter(|gap| !recording.gaps().contains(gap));
        found.extend(own.map(|(from, to)| Suspicion::Gap { column: Some(column.clone()), from, to, usual }));
        let t: Vec<f64> = there.iter().map(|k| recording.times()[*k]).collect();
        let y: Vec<f64> = there.iter().map(|k| recording.outputs().values()[(*k, j)]).collect();
        found.extend(alternating(name, &y));
        found.extend(stuck(name, &t, &y));
    }
    grouped(found)
}

/// The fewest values of which it can be said that they alternate.
const ALTERNATING: usize = 20;

/// A column whose values go up and down in turn, ten times as far from one to the next as over two.
fn alternating(name: &str, column: &[f64]) -> Option<Suspicion> {
    let steps: Vec<f64> = column.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let turns = steps.windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count();
    if column.len() < ALTERNATING || 20 * turns < 19 * (steps.len() - 1) {
        return None;
    }
    let median = |mut sizes: Vec<f64>| percentile(&mut sizes, 50);
    let step = median(steps.iter().map(|step| step.abs()).collect())?;
    let over_two = median(column.windows(3).map(|of| (of[2] - of[0]).abs()).collect())?;
    (step > 10.0 * over_two).then(|| Suspicion::Alternating { column: name.to_owned(), step, over_two })
}

/// The quantum of a column whose values are multiples of one, if each value occurs twice or more on average.
fn quantum(different: &[f64], count: usize) -> Option<f64> {
    let least = different.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let is_multiple = |x: f64| (x / least - (x / least).round()).abs() < 1e-3;
    let first = *different.first()?;
    (2 * different.len() <= count && different.iter().all(|x| is_multiple(x - first))).then_some(least)
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
    let quantum = quantum(&different, column.len());
    // Runs of equal values: start index, length.
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for (k, value) in column.iter().enumerate() {
        match runs.last_mut() {
            Some((start, length)) if column[*start] == *value => *length += 1,
            _ => runs.push((k, 1)),
        }
    }
    let span = |(start, length): (usize, usize)| (t[start], t[start + length - 1]);
    // A quantised signal that moves slowly comes to a value by one quantum, leaves it by one, and rests on its
    // neighbours too.
    let is_slow = |k: usize| {
        let is_near = |other: Option<&(usize, usize)>| {
            other.is_none_or(|(start, length)| {
                let step = (column[*start] - column[runs[k].0]).abs();
                step <= 1.5 * quantum.unwrap_or(0.0) && runs[k].1 <= TURN * length
            })
        };
        quantum.is_some() && is_near(k.checked_sub(1).and_then(|k| runs.get(k))) && is_near(runs.get(k + 1))
    };
    let mut found = Vec::new();
    for value in [low, high] {
        let is_at = |k: &usize| column[runs[*k].0] == value && runs[*k].1 >= AT_LIMIT && !is_slow(*k);
        let at: Vec<_> = (0..runs.len()).filter(is_at).map(|k| runs[k]).collect();
        if let Some(longest) = at.iter().copied().max_by_key(|(_, length)| *length) {
            let samples = at.iter().map(|(_, length)| length).sum();
            found.push(Suspicion::Saturated { column: column_name.clone(), value, samples, longest: span(longest) });
        }
    }
    let is_frozen = |k: &usize| {
        let (start, length) = runs[*k];
        length >= IN_BETWEEN && column[start] != low && column[start] != high && !is_slow(*k)
    };
    for run in (0..runs.len()).filter(is_frozen).map(|k| runs[k]) {
        let (value, samples) = (column[run.0], run.1);
        found.push(Suspicion::Frozen { column: column_name.clone(), value, samples, during: span(run) });
    }
    found
}
