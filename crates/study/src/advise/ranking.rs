//! Criteria, and the order that they give.
//!
//! The score of an observer is the weighted geometric mean of its values relative to the best ones: 1 is the best in
//! all that is asked for. It does not depend on units, and can be recomputed from the table.

use std::fmt;
use std::str::FromStr;

use serde::Serialize;

/// What observers are ranked by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Criterion {
    /// The root mean square of |e|.
    Error,
    /// What noise leaves: the root mean square of |e| over the second half of the run.
    Noise,
    /// The largest |e| relative to |e(0)|.
    Peak,
    /// The settling time.
    Settling,
    /// Floating-point operations of a step of the exported program.
    Cost,
    /// Whether convergence is proved.
    Proved,
    /// On a log: the root mean square of the innovations, each relative to the deviation of its output.
    Innovations,
    /// On a log: the inverse of the geometric mean of the probability densities that a filter gives the measurements.
    Likelihood,
}

impl Criterion {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Error,
        Self::Noise,
        Self::Peak,
        Self::Settling,
        Self::Cost,
        Self::Proved,
        Self::Innovations,
        Self::Likelihood,
    ];

    /// Whether it needs a log.
    pub(super) fn is_of_log(self) -> bool {
        matches!(self, Self::Innovations | Self::Likelihood)
    }

    /// Whether it needs a simulation.
    pub(super) fn is_of_simulation(self) -> bool {
        matches!(self, Self::Noise | Self::Peak | Self::Settling)
    }

    /// Its name in options.
    pub fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Noise => "noise",
            Self::Peak => "peak",
            Self::Settling => "settling",
            Self::Cost => "cost",
            Self::Proved => "proved",
            Self::Innovations => "innovations",
            Self::Likelihood => "likelihood",
        }
    }

    /// The quantity, in sentences.
    pub fn quantity(self) -> &'static str {
        match self {
            Self::Error => "rms |e|",
            Self::Noise => "rms |e| in the second half",
            Self::Peak => "peak |e|",
            Self::Settling => "settling time",
            Self::Cost => "operations per step",
            Self::Proved => "proof",
            Self::Innovations => "relative innovation",
            Self::Likelihood => "inverse density",
        }
    }
}

/// The factor of an observer without a proof, where a proof counts.
pub const UNPROVED_FACTOR: f64 = 10.0;

/// Criteria with their weights.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Criteria(pub Vec<(Criterion, f64)>);

impl Default for Criteria {
    fn default() -> Self {
        Criterion::Error.into()
    }
}

impl From<Criterion> for Criteria {
    fn from(criterion: Criterion) -> Self {
        Self(vec![(criterion, 1.0)])
    }
}

impl FromStr for Criteria {
    type Err = String;

    /// One criterion, or several with weights: `error=2,cost=1`.
    fn from_str(text: &str) -> Result<Self, String> {
        let names = || Criterion::ALL.map(Criterion::name).join(", ");
        let mut all: Vec<(Criterion, f64)> = Vec::new();
        for part in text.split(',') {
            let (name, weight) = part.split_once('=').unwrap_or((part, "1"));
            let found = Criterion::ALL.into_iter().find(|criterion| criterion.name() == name.trim());
            let criterion = found.ok_or_else(|| format!("there is no criterion {name:?}; there are {}", names()))?;
            let weight = match weight.trim().parse::<f64>() {
                Ok(weight) if weight > 0.0 && weight.is_finite() => weight,
                _ => return Err(format!("the weight of {name} is {weight:?}; a positive number is expected")),
            };
            if all.iter().any(|(other, _)| *other == criterion) {
                return Err(format!("{name} is named twice"));
            }
            all.push((criterion, weight));
        }
        Ok(Self(all))
    }
}

impl fmt::Display for Criteria {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let one = |(criterion, weight): &(Criterion, f64)| match self.0.len() {
            1 => criterion.name().to_owned(),
            _ => format!("{}={weight}", criterion.name()),
        };
        f.write_str(&self.0.iter().map(one).collect::<Vec<_>>().join(","))
    }
}

/// What a ranking reads of an observer; what it does not have is infinite.
pub trait Ranked {
    /// The value of a criterion, of which less is better.
    fn value(&self, criterion: Criterion) -> f64;
    /// Whether all its runs finished.
    fn is_complete(&self) -> bool;
}

/// Relative differences below this are not worth a choice.
pub(super) const SMALL: f64 = 0.05;

/// Those of a ranking whose runs all finished and whose score is within 5 % of the first one: they tie.
pub fn tied<'a, T: Ranked>(ordered: &[(&'a T, f64)]) -> Vec<&'a T> {
    let Some((_, least)) = ordered.first() else { return Vec::new() };
    let close = |(one, score): &&(&T, f64)| one.is_complete() && ratio(*score, *least) < 1.0 + SMALL;
    ordered.iter().take_while(close).map(|(one, _)| *one).collect()
}

/// The one of a tie that is recommended: with a proof, then of the least cost, then the first.
pub fn preferred<'a, T: Ranked>(tied: &[&'a T]) -> Option<&'a T> {
    let by = |criterion: Criterion| move |a: &&T, b: &&T| a.value(criterion).total_cmp(&b.value(criterion));
    tied.iter().copied().min_by(|a, b| by(Criterion::Proved)(a, b).then(by(Criterion::Cost)(a, b)))
}

/// The score of each, and the indices in the order of the ranking: those whose runs all finished first, by score, then
/// by `accuracy`.
pub fn rank<T: Ranked>(all: &[T], criteria: &Criteria, accuracy: Criterion) -> (Vec<f64>, Vec<usize>) {
    let best = |criterion: Criterion| {
        let values = |complete: bool| {
            let of = all.iter().filter(move |one| one.is_complete() || !complete);
            of.map(move |one| one.value(criterion)).fold(f64::INFINITY, f64::min)
        };
        let complete = values(true);
        if complete.is_finite() { complete } else { values(false) }
    };
    let total: f64 = criteria.0.iter().map(|(_, weight)| weight).sum();
    let score = |one: &T| {
        let logarithm =
            |(criterion, weight): &(Criterion, f64)| weight * ratio(one.value(*criterion), best(*criterion)).ln();
        (criteria.0.iter().map(logarithm).sum::<f64>() / total).exp()
    };
    let scores: Vec<f64> = all.iter().map(score).collect();
    let mut order: Vec<usize> = (0..all.len()).collect();
    // Scores that differ by rounding errors are equal.
    let key = |i: usize| (scores[i] * 1e9).round();
    order.sort_by(|&i, &j| {
        let complete = all[j].is_complete().cmp(&all[i].is_complete());
        let error = |i: usize| all[i].value(accuracy);
        complete.then(key(i).total_cmp(&key(j))).then(error(i).total_cmp(&error(j)))
    });
    (scores, order)
}

/// A value relative to the best one.
pub(super) fn ratio(value: f64, best: f64) -> f64 {
    match (value, best) {
        (value, best) if value == best => 1.0,
        (_, 0.0) => f64::INFINITY,
        (value, best) => value / best,
    }
}
