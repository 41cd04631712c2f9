//! The fit in words.

use std::fmt::Write as _;

use luenberger_proof::wording::{counted, significant};
use luenberger_wording::rounded;

use super::coordinate::Coordinate;
use super::criterion::Criterion;
use super::information::Information;
use super::judge;
use super::report::{HeldOut, TunedParameter};
use crate::kinds;
use crate::kinds::keys::GATE;
use crate::study::{Study, Tunable, TuneCriterion};

/// The unit of a parameter of the plant, of a bias or of what a coloured noise has, if the study gives it.
pub(super) fn unit(study: &Study, what: &Tunable) -> Option<String> {
    let name = match what {
        Tunable::Parameter(name) | Tunable::Deviation(name) => name,
        Tunable::Bias(j) => &study.plant.outputs[*j],
        Tunable::CorrelationTime(_) | Tunable::Delay(_) => return study.plant.time_unit.clone(),
        _ => return None,
    };
    study.plant.unit(name).cloned()
}

/// Which inputs of the logs are constant, for a message.
pub(super) fn constant_inputs(criterion: &Criterion<'_>) -> String {
    let constant = |(j, input): (usize, &String)| {
        let values: Option<Vec<f64>> = criterion.data.iter().map(|data| data.constant_input(j)).collect();
        let first = *values.as_ref()?.first()?;
        Some(format!("{input} = {}", significant(first, 4)))
    };
    let found: Vec<String> = criterion.study.plant.inputs.iter().enumerate().filter_map(constant).collect();
    if found.is_empty() { String::new() } else { format!(" (inputs that are constant: {})", found.join(", ")) }
}

/// What a fit makes as large or as small as it can be, in words.
struct Sought {
    name: &'static str,
    best: &'static str,
    point: &'static str,
    others: &'static str,
    /// What it does beyond a bound that a value is at.
    beyond: &'static str,
}

impl Sought {
    fn of(criterion: TuneCriterion) -> Self {
        match criterion {
            TuneCriterion::Errors => Self {
                name: "sum of squares",
                best: "least",
                point: "minimum",
                others: "higher, in other minima",
                beyond: "falls",
            },
            TuneCriterion::Likelihood | TuneCriterion::Innovations => Self {
                name: "likelihood",
                best: "largest",
                point: "maximum",
                others: "lower, in other maxima",
                beyond: "grows",
            },
        }
    }
}

/// What else is to be known of a fit.
pub(super) fn remarks(
    criterion: &Criterion<'_>,
    parameters: &[TunedParameter],
    (free, coordinates): (&[usize], &[Coordinate]),
    (information, starts, agreeing): (&Information, usize, usize),
) -> Vec<String> {
    let sought = Sought::of(criterion.spec.criterion);
    let names: Vec<&str> = free.iter().map(|i| parameters[*i].name.as_str()).collect();
    let mut words: Vec<String> =
        information.flat.iter().map(|direction| undetermined(direction, &names, coordinates, sought.name)).collect();
    if words.is_empty() {
        words.push(format!("At this {} the log determines every parameter that is not at a bound.", sought.point));
    }
    for one in parameters {
        if let Some((why, does)) = one.without.and_then(|why| Some((why, why.at_end_does(sought.beyond)?))) {
            words.push(format!("{} = {} is {why}: the {} {does}.", one.name, significant(one.after, 4), sought.name));
        }
    }
    if information.discrepancy > 0.1 && criterion.spec.criterion != TuneCriterion::Errors {
        words.push(format!(
            "The log-likelihood is no parabola within a fraction of a standard error (second derivatives by two steps differ by {} %): the intervals of the profiles are better than those of the standard errors.",
            significant(100.0 * information.discrepancy, 2)
        ));
    }
    if starts > 1 && agreeing < starts {
        words.push(format!(
            "Searches from {agreeing} of {} found the {} {}; the others ended {} or too early.",
            counted(starts, "start"),
            sought.best,
            sought.name,
            sought.others
        ));
    }
    let rejected: usize = criterion.rejected.iter().sum();
    if rejected > 0 {
        words.push(format!(
            "The gate of {} rejects {} with the values of the study; they are left out for all values.",
            criterion.spec.observer,
            counted(rejected, "measurement")
        ));
    }
    words
}

/// A gate that an outlier does not pass, and hardly any other measurement fails.
const USUAL_GATE: f64 = 5.0;

/// Where the filter with the fitted values is inconsistent on what was held out: the test, the measurement that fits it
/// least, and what can be done if that is an outlier.
pub(super) fn warnings(criterion: &Criterion<'_>, held_out: &HeldOut, values: &[f64], file: &str) -> Vec<String> {
    let Some(nis) = held_out.after.nis.as_ref().filter(|nis| !nis.accepted) else { return Vec::new() };
    let observer = &criterion.spec.observer;
    let mut text = format!(
        "With the fitted values the NIS of {observer} on the rows that were held out is {}, the region of 95 %: these rows have another covariance than the filter computes.",
        nis.in_words()
    );
    if let Some(largest) = judge::largest(criterion, values) {
        let plant = &criterion.study.plant;
        let reading = largest.reading.map_or_else(
            || largest.output.clone(),
            |y| format!("{} = {}", largest.output, plant.measured(&largest.output, significant(y, 6))),
        );
        let t = rounded(largest.t, 9);
        _ = write!(
            text,
            " The largest normalised innovation, of {} standard deviations, is that of {reading} at t = {} in {}",
            significant(largest.deviations, 3),
            plant.time_in_words(t),
            largest.file
        );
        let kind = kinds::named(criterion.requested.kind.name());
        let has_gate = kind.is_some_and(|kind| kind.keys.iter().copied().flatten().any(|key| key.name == GATE.name));
        let is_gated = criterion.rejected.iter().any(|count| *count > 0);
        if largest.deviations > USUAL_GATE && has_gate && !is_gated {
            _ = write!(
                text,
                ": if it is an outlier, add `{} = {USUAL_GATE}` to {observer} in {file}, which leaves such measurements out, and tune that study",
                GATE.name
            );
        }
        text.push('.');
    }
    vec![text]
}

/// An entry of a direction that is named.
const NAMED: f64 = 0.1;

/// A direction along which what is sought hardly changes.
fn undetermined(direction: &[f64], names: &[&str], coordinates: &[Coordinate], sought: &str) -> String {
    let mut entries: Vec<usize> = (0..direction.len()).filter(|&i| direction[i].abs() >= NAMED).collect();
    entries.sort_by(|a, b| direction[*b].abs().total_cmp(&direction[*a].abs()));
    match entries[..] {
        [] => String::new(),
        [one] => format!("The log does not determine {}: {}.", names[one], flat(coordinates[one].is_log(), sought)),
        [a, b] if coordinates[a].is_log() && coordinates[b].is_log() => {
            // Along the direction ln a = s, ln b = r s: what is left is ln b - r ln a.
            let r = direction[b] / direction[a];
            let power = |r: f64| if (r - 1.0).abs() < 0.05 { String::new() } else { format!("^{}", significant(r, 2)) };
            let (name, other) = (format!("{}{}", names[a], power(r.abs())), names[b]);
            let combination = if r < 0.0 { format!("{name} x {other}") } else { format!("{name} / {other}") };
            format!("The log determines only {combination}, not {} and {} apart.", names[a], names[b])
        }
        _ => {
            let all_logs = entries.iter().all(|&i| coordinates[i].is_log());
            let term = |&i: &usize| {
                let entry = significant(direction[i] * coordinates[i].vague() / coordinates[entries[0]].vague(), 2);
                if all_logs { format!("{} by c^{entry}", names[i]) } else { format!("{} by {entry}", names[i]) }
            };
            let terms: Vec<String> = entries.iter().map(term).collect();
            let what =
                if all_logs { "multiplied at once" } else { "moved at once, positive ones in their logarithms," };
            format!(
                "The log does not determine one combination: the {sought} hardly changes where they are {what}, {}.",
                terms.join(", ")
            )
        }
    }
}

fn flat(is_log: bool, sought: &str) -> String {
    let range = if is_log { "a factor of 10" } else { "a quarter of its bounds" };
    format!("the {sought} hardly changes over {range}")
}
