//! Runs that leave the region of a design, outside of which its guarantee is not valid.
//!
//! Of a simulation every step of the integrator is examined, at eight points with both of its ends; of a log every row.

use luenberger_design::Region;
use luenberger_proof::wording::{counted, significant};
use luenberger_sim::replay::ReplayedObserver;
use luenberger_sim::{SimError, Trajectory};
use serde::{Deserialize, Serialize};

use super::rows::Run;
use super::sampling;
use crate::study::{Log, ObserverSpec, Study};
use crate::trajectory::Member;

/// How much of a run is outside.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Extent {
    /// So many rows, of all.
    Rows(usize, usize),
    /// So many samples, of all.
    Samples(usize, usize),
    /// This share of the time.
    Time(f64),
}

/// How a run left the region of a design.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Excursion {
    /// What does not hold outside of it.
    what: &'static str,
    /// How much of the run is outside.
    extent: Extent,
    /// The first time outside.
    t: f64,
    /// What left the region then.
    exit: Exit,
}

/// What is outside.
#[derive(Debug, Clone, PartialEq)]
enum Exit {
    /// What has this name is, with its value and the bounds.
    Bounds(String, f64, (f64, f64)),
    /// This inequality does not hold; of the estimate, or of the state.
    Inequality { text: String, of_estimate: bool },
}

impl Excursion {
    /// As a sentence about one run.
    pub(super) fn in_run(&self, observer: &str) -> String {
        let outside = match self.extent {
            Extent::Rows(outside, all) => format!("at {outside} of {}", counted(all, "row")),
            Extent::Samples(outside, all) => format!("at {outside} of {}", counted(all, "sample")),
            Extent::Time(share) => format!("for {} % of the run", significant(100.0 * share, 2)),
        };
        format!("{}: {observer}: outside {outside}, first {}", self.what, self.first())
    }

    /// What is said of it among the runs of a sweep.
    pub(super) fn first_exit(&self) -> FirstExit {
        FirstExit { what: self.what.to_owned(), first: self.first() }
    }

    fn first(&self) -> String {
        let t = significant(self.t, 5);
        match &self.exit {
            Exit::Bounds(name, value, (low, high)) => {
                let [value, low, high] = [value, low, high].map(|x| significant(*x, 5));
                format!("at t = {t}, where {name} = {value} is not in [{low}, {high}]")
            }
            Exit::Inequality { text, of_estimate: true } => {
                format!("at t = {t}, where the estimate does not satisfy {text}")
            }
            Exit::Inequality { text, of_estimate: false } => format!("at t = {t}, where {text} does not hold"),
        }
    }
}

/// The first exit from the region among the runs of a sweep, in words.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct FirstExit {
    /// What does not hold outside of it.
    pub(super) what: String,
    /// When and where it left.
    pub(super) first: String,
}

impl FirstExit {
    /// As a sentence, if so many of all runs left.
    pub(super) fn in_sweep(&self, observer: &str, runs: u64, all: usize, parameter: &str, value: f64) -> String {
        let Self { what, first } = self;
        let (all, value) = (counted(all, "run"), significant(value, 5));
        format!("{what}: {observer}: left in {runs} of {all} of the sweep, first with {parameter} = {value} {first}")
    }
}

/// The region of a design, and what has been found outside of it.
struct Watch<'a> {
    study: &'a Study,
    requested: &'a ObserverSpec,
    region: Region,
    first: Option<Excursion>,
}

impl<'a> Watch<'a> {
    fn of(study: &'a Study, requested: &'a ObserverSpec) -> Option<Self> {
        Some(Self { study, requested, region: requested.kind.region()?, first: None })
    }

    /// Whether a point is outside. What is not known is not outside.
    fn is_outside(&mut self, t: f64, x: &[f64], u: &[f64], estimate: &[f64]) -> bool {
        let beyond = |x: f64, (low, high): (f64, f64)| x < low || x > high;
        let plant = &self.study.plant;
        let inputs = self.region.input_bounds().unwrap_or_default();
        let quantities = [
            ("", &plant.states, x, self.region.states()),
            ("", &plant.inputs, u, inputs),
            ("estimate of ", &plant.states, estimate, self.region.states()),
        ];
        let found = quantities.into_iter().find_map(|(prefix, names, values, bounds)| {
            let i = values.iter().zip(bounds).position(|(value, bounds)| beyond(*value, *bounds))?;
            Some((format!("{prefix}{}", names[i]), values[i], bounds[i]))
        });
        let time = self.region.time_bounds();
        let found = found.or_else(|| beyond(t, time).then(|| ("t".to_owned(), t, time)));
        let of_bounds = found.map(|(name, value, bounds)| Exit::Bounds(name, value, bounds));
        let Some(exit) = of_bounds.or_else(|| self.broken(x, false)).or_else(|| self.broken(estimate, true)) else {
            return false;
        };
        let what = self.requested.kind.outside_region();
        self.first.get_or_insert(Excursion { what, extent: Extent::Rows(0, 0), t, exit });
        true
    }

    /// The first inequality of the region that these states break.
    fn broken(&self, x: &[f64], of_estimate: bool) -> Option<Exit> {
        let inequalities = self.requested.kind.inequalities();
        // States that are not known, as of a log, are missing; NaN is not greater than 0.
        let broken = inequalities.iter().find(|g| g.evaluate(0.0, x, &[]) > 0.0)?;
        Some(Exit::Inequality { text: broken.text().to_owned(), of_estimate })
    }

    fn finish(self, extent: Extent) -> Option<Excursion> {
        Some(Excursion { extent, ..self.first? })
    }
}

/// Whether state, estimate, input or time of a simulation leave the region of the observer's design, or its samples the
/// periods and misses.
pub(super) fn of_simulation(
    study: &Study,
    requested: &ObserverSpec,
    trajectory: &Trajectory,
) -> Result<Option<Excursion>, SimError> {
    if let Some(periods) = requested.kind.varying_periods() {
        let samples = &trajectory.observer(&requested.name)?.samples;
        let outside = sampling::outside(samples, periods);
        return Ok(outside.first().map(|first| Excursion {
            what: "Guarantee not valid outside the periods of the design",
            extent: Extent::Samples(outside.len(), samples.len()),
            t: first.t,
            exit: Exit::Bounds(first.name.to_owned(), first.value, first.bounds),
        }));
    }
    let Some(mut watch) = Watch::of(study, requested) else { return Ok(None) };
    // Half of the time between two points counts as the one does, and half as the other.
    let (start, end) = trajectory.span();
    let (mut before, mut outside) = ((start, 0.0), 0.0);
    trajectory.visit(&requested.name, |t, x, u, estimate| {
        let share = f64::from(u8::from(watch.is_outside(t, x, u, estimate)));
        outside += (t - before.0) * f64::midpoint(before.1, share);
        before = (t, share);
    })?;
    Ok(watch.finish(Extent::Time(outside / (end - start))))
}

/// Likewise of the rows of a run on a log.
pub(super) fn of_rows(study: &Study, requested: &ObserverSpec, run: &Run) -> Option<Excursion> {
    let mut watch = Watch::of(study, requested)?;
    let mut outside = 0;
    let row = |m: &nalgebra::DMatrix<f64>, k: usize| m.row(k).iter().copied().collect::<Vec<f64>>();
    for (k, t) in run.t.iter().enumerate() {
        let estimate = run.estimate.as_ref().map(|estimate| row(estimate, k)).unwrap_or_default();
        // On a log the true states may be unknown: there are no columns.
        outside += usize::from(watch.is_outside(*t, &row(&run.x, k), &row(&run.u, k), &estimate));
    }
    watch.finish(Extent::Rows(outside, run.t.len()))
}

/// At how many rows of a replay input or estimate are outside of the region of the design.
pub(super) fn rows_outside(study: &Study, requested: &ObserverSpec, log: &Log, replayed: &ReplayedObserver) -> usize {
    let Some(mut watch) = Watch::of(study, requested) else { return 0 };
    let mut u = vec![0.0; study.plant.inputs.len()];
    let mut row = |(k, t): (usize, &f64)| {
        log.recording.inputs().at(*t, &mut u);
        let estimate: Vec<f64> = replayed.estimate.row(k).iter().copied().collect();
        watch.is_outside(*t, &[], &u, &estimate)
    };
    replayed.t.iter().enumerate().filter(|at| row(*at)).count()
}

/// Runs on a log that leave the region for which a property was proved, or in which a map was fitted.
pub(super) fn warnings(study: &Study, runs: &[(&Member<'_>, &Run)]) -> Vec<String> {
    let sentence = |(member, run): &(&Member<'_>, &Run)| {
        Some(of_rows(study, member.requested, run)?.in_run(&member.requested.name))
    };
    runs.iter().filter_map(sentence).collect()
}
