//! Warnings that qualify the results.

use luenberger_proof::wording::{counted, significant};

use super::Member;
use super::simulate::Run;
use crate::design::SPEED_RATIO;
use crate::results::report::eigenvalue;
use crate::results::{DesignReport, Results};
use crate::signal::Input;
use crate::study::{ObserverKind, ObserverSpec, Study};

/// Modes with a margin below this are weakly observable.
const HARDLY: f64 = 1e-6;

pub(super) fn of_designs(study: &Study, results: &Results) -> Vec<String> {
    let mut warnings = Vec::new();
    for point in results.observability.iter().flat_map(|report| &report.points) {
        let hidden = |margin: f64| point.hidden.iter().any(|mode| mode.margin >= margin);
        for mode in point.modes.iter().filter(|mode| mode.margin < HARDLY && !hidden(mode.margin)) {
            warnings.push(format!(
                "the outputs hardly see the mode {} along {} (margin {}): a small change of the plant hides it",
                eigenvalue(mode.eigenvalue),
                mode.words,
                significant(mode.margin, 2)
            ));
        }
    }
    for observer in &results.observers {
        let Some(design) = &observer.design else { continue };
        warnings.extend(amplification(study, &observer.name, design));
    }
    let driven = !matches!(study.input, Input::Zero);
    if let (Some(simulation), true) = (&study.simulation, driven) {
        for wish in &study.observers {
            let Some(period) = wish.kind.period() else { continue };
            if simulation.hold != Some(period) {
                let hold = simulation.hold.map_or_else(|| "not set".to_owned(), |hold| hold.to_string());
                let name = &wish.name;
                warnings.push(format!(
                    "{name} assumes a zero-order hold of the input: set simulation.hold = {period} (it is {hold})"
                ));
            }
        }
    }
    warnings
}

/// A verified transient beyond this factor is of no use.
const OVERSHOOT: f64 = 100.0;

/// Poles beyond this multiple of the plant's fastest mode are seldom intended.
const SPEED: f64 = 1e3;

/// Gains that are verified and of no use: an overshoot bound that says nothing, poles far beyond the plant, and noise
/// that leaves a larger error than the first one.
fn amplification(study: &Study, name: &str, design: &DesignReport) -> Vec<String> {
    const REMEDY: &str = "set `max_gain` or `noise`, or ask for a smaller rate";
    let mut warnings = Vec::new();
    if let Some(overshoot) = design.number("overshoot").filter(|overshoot| *overshoot > OVERSHOOT) {
        warnings.push(format!(
            "{name}: overshoot bound {}: the error may grow to this multiple of its first value before it decays; {REMEDY}",
            significant(overshoot, 4)
        ));
    }
    if let Some(ratio) = design.number(SPEED_RATIO).filter(|ratio| *ratio > SPEED) {
        warnings.push(format!(
            "{name}: its fastest pole is {} times as fast as the plant's fastest mode (norm of L {}): it amplifies measurement noise and unmodelled dynamics; {REMEDY}",
            significant(ratio, 2),
            significant(design.number("norm of L").unwrap_or(f64::NAN), 3)
        ));
    }
    let (Some(simulation), Some(observer)) = (&study.simulation, study.observer(name)) else { return warnings };
    let first = simulation.x0.iter().zip(&observer.initial).map(|(x, xhat)| (x - xhat).abs());
    let worst = design
        .noise_deviation
        .iter()
        .zip(first)
        .enumerate()
        .filter(|(_, (deviation, first))| *first > 0.0 && *deviation > first);
    if let Some((i, (deviation, first))) = worst.max_by(|x, y| (x.1.0 / x.1.1).total_cmp(&(y.1.0 / y.1.1))) {
        warnings.push(format!(
            "{name}: the measurement noise alone leaves an error of standard deviation {} in {}, more than the first error {}; {REMEDY}",
            significant(*deviation, 3),
            study.plant.states[i],
            significant(first, 3)
        ));
    }
    warnings
}

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
    // The time is a quantity of its own.
    let outside = |k: usize| -> Option<(String, f64, (f64, f64))> {
        let beyond = |x: f64, (low, high): (f64, f64)| !(low..=high).contains(&x);
        for (prefix, names, values, bounds) in &quantities {
            let Some(values) = values else { continue };
            // A log has no true states.
            let found = (0..values.ncols()).find(|i| beyond(values[(k, *i)], bounds[*i]));
            if let Some(i) = found {
                return Some((format!("{prefix}{}", names[i]), values[(k, i)], bounds[i]));
            }
        }
        let time = region.time_bounds();
        beyond(run.t[k], time).then(|| ("t".to_owned(), run.t[k], time))
    };
    let all: Vec<(usize, (String, f64, (f64, f64)))> =
        (0..run.t.len()).filter_map(|k| Some((k, outside(k)?))).collect();
    let rows = (all.len(), run.t.len());
    let (k, (name, value, bounds)) = all.into_iter().next()?;
    Some(Excursion { what, rows, t: run.t[k], name, value, bounds })
}

/// Runs that leave the region for which a property was proved, or in which a map was fitted.
pub(super) fn of_runs(study: &Study, runs: &[(&Member<'_>, &Run)]) -> Vec<String> {
    let sentence =
        |(member, run): &(&Member<'_>, &Run)| Some(excursion(study, member.wish, run)?.in_run(&member.wish.name));
    runs.iter().filter_map(sentence).collect()
}
