//! Runs that leave the region of a design, outside of which its guarantee is not valid.

use luenberger_proof::wording::{counted, significant};

use super::Member;
use super::simulate::Run;
use crate::study::{ObserverKind, ObserverSpec, Study};

/// How a run left the region of a design.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Excursion {
    /// What does not hold outside of it.
    what: &'static str,
    /// Rows outside, and all rows.
    rows: (usize, usize),
    /// The first time outside.
    t: f64,
    /// What left the region then, with its value and the bounds.
    name: String,
    value: f64,
    bounds: (f64, f64),
}

impl Excursion {
    /// As a sentence about one run.
    fn in_run(&self, observer: &str) -> String {
        let (outside, all) = self.rows;
        format!("{}: {observer}: outside at {outside} of {}, first {}", self.what, counted(all, "row"), self.first())
    }

    /// As a sentence about the runs of a sweep, of which this is the first that left.
    pub(super) fn in_sweep(&self, observer: &str, runs: usize, all: usize, parameter: &str, value: f64) -> String {
        let (what, value) = (self.what, significant(value, 5));
        format!(
            "{what}: {observer}: left in {runs} of {} of the sweep, first with {parameter} = {value} {}",
            counted(all, "run"),
            self.first()
        )
    }

    fn first(&self) -> String {
        let [t, value, low, high] = [self.t, self.value, self.bounds.0, self.bounds.1].map(|x| significant(x, 5));
        format!("at t = {t}, where {} = {value} is not in [{low}, {high}]", self.name)
    }
}

/// Whether state, estimate, input or time of a run leave the region of the observer's design.
pub(super) fn excursion(study: &Study, wish: &ObserverSpec, run: &Run) -> Option<Excursion> {
    let region = wish.kind.region()?;
    let what = match wish.kind {
        ObserverKind::KklNumerical(_) => "Fit not valid outside the design region",
        _ => "Guarantee not valid outside the design region",
    };
    let plant = &study.plant;
    let inputs = region.input_bounds().map(|bounds| ("", &plant.inputs, Some(&run.u), bounds));
    let states = ("", &plant.states, Some(&run.x), region.states());
    let estimates = ("estimate of ", &plant.states, run.estimate.as_ref(), region.states());
    let quantities: Vec<_> = [Some(states), inputs, Some(estimates)].into_iter().flatten().collect();
    let outside = |k: usize| -> Option<(String, f64, (f64, f64))> {
        // What is not known is not outside.
        let beyond = |x: f64, (low, high): (f64, f64)| x < low || x > high;
        for (prefix, names, values, bounds) in &quantities {
            let Some(values) = values else { continue };
            // On a log the true states are unknown: there are no columns.
            let found = (0..values.ncols()).find(|i| beyond(values[(k, *i)], bounds[*i]));
            if let Some(i) = found {
                return Some((format!("{prefix}{}", names[i]), values[(k, i)], bounds[i]));
            }
        }
        let time = region.time_bounds();
        beyond(run.t[k], time).then(|| ("t".to_owned(), run.t[k], time))
    };
    let (mut count, mut first) = (0, None);
    for k in 0..run.t.len() {
        let found = outside(k);
        count += usize::from(found.is_some());
        first = first.or(found.map(|found| (k, found)));
    }
    let (k, (name, value, bounds)) = first?;
    let rows = (count, run.t.len());
    Some(Excursion { what, rows, t: run.t[k], name, value, bounds })
}

/// Runs that leave the region for which a property was proved, or in which a map was fitted.
pub(super) fn warnings(study: &Study, runs: &[(&Member<'_>, &Run)]) -> Vec<String> {
    let sentence =
        |(member, run): &(&Member<'_>, &Run)| Some(excursion(study, member.wish, run)?.in_run(&member.wish.name));
    runs.iter().filter_map(sentence).collect()
}
