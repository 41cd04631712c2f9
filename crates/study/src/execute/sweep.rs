//! Parameter sweep: every observer at every value, with an ensemble of noise seeds and initial errors, in parallel.
//!
//! Each run depends only on the study, the value and its index in the ensemble. Number and order of threads do not
//! affect the result.

use luenberger_sim::Noise;
use rayon::prelude::*;

use super::excursion::{Excursion, excursion};
use super::options::RunOptions;
use super::scores::Scoring;
use super::simulate::{self, Variation};
use super::stopped::why;
use super::{Member, member};
use crate::design::{Designed, NoDesign, design};
use crate::error::StudyError;
use crate::results::{MeritsReport, NormReport, StateReport, SweepReport, SweepRow};
use crate::study::{ObserverSpec, Simulation, Study, Sweep, Swept};

/// The specification of an observer at a value; none if it does not have the parameter.
fn varied(wish: &ObserverSpec, simulation: &Simulation, parameter: Swept, value: f64) -> Option<ObserverSpec> {
    let mut wish = wish.clone();
    match parameter {
        Swept::Gamma => wish.kind = wish.kind.with_gamma(value)?,
        Swept::Poles => wish.kind = wish.kind.faster(value),
        Swept::Noise => {}
        Swept::Initial => {
            for (xhat, x) in wish.initial.iter_mut().zip(&simulation.x0) {
                *xhat = x - value * (x - *xhat);
            }
        }
    }
    Some(wish)
}

/// The initial estimate of an ensemble member: member 0 uses the study's own, the others an initial error of the same
/// norm in a random direction, in units of the scale. Without a scale the unit of each state is its initial error.
fn initial(wish: &ObserverSpec, simulation: &Simulation, scale: Option<&[f64]>, seed: u64, number: usize) -> Vec<f64> {
    if number == 0 {
        return wish.initial.clone();
    }
    let errors: Vec<f64> = simulation.x0.iter().zip(&wish.initial).map(|(x, xhat)| x - xhat).collect();
    let unit = |i: usize| scale.map_or(errors[i].abs(), |scale| scale[i]);
    let norm = |entries: &mut dyn Iterator<Item = f64>| entries.map(|x| x * x).sum::<f64>().sqrt();
    let size = norm(&mut errors.iter().enumerate().filter(|(_, e)| **e != 0.0).map(|(i, e)| e / unit(i)));
    // Gaussian entries, so that the direction is uniformly distributed.
    let direction = Noise::gaussian(&vec![1.0; errors.len()], 1.0, seed).sample(number as u64);
    let length = norm(&mut direction.iter().copied());
    let entry = |(i, x): (usize, &f64)| x - unit(i) * size * direction[i] / length;
    simulation.x0.iter().enumerate().map(entry).collect()
}

/// Number of runs of a sweep.
pub(super) fn runs(study: &Study, sweep: &Sweep) -> usize {
    chosen(study, sweep).len() * sweep.values.len() * sweep.ensemble
}

fn chosen<'a>(study: &'a Study, sweep: &Sweep) -> Vec<&'a ObserverSpec> {
    let named = |wish: &&ObserverSpec| sweep.observers.as_ref().is_none_or(|names| names.contains(&wish.name));
    study.observers.iter().filter(named).collect()
}

/// The rows in the order of observers and values, and warnings; rows not finished before an interruption are omitted.
pub(super) fn all(
    study: &Study,
    simulation: &Simulation,
    sweep: &Sweep,
    members: &[Member<'_>],
    options: &RunOptions<'_>,
) -> Result<(SweepReport, Vec<String>), StudyError> {
    let cells: Vec<(&ObserverSpec, f64)> = chosen(study, sweep)
        .into_iter()
        .flat_map(|wish| sweep.values.iter().map(move |value| (wish, *value)))
        .collect();
    let cells: Vec<(ObserverSpec, f64)> = cells
        .into_iter()
        .filter_map(|(wish, value)| Some((varied(wish, simulation, sweep.parameter, value)?, value)))
        .collect();
    let compared = members.iter().filter(|member| cells.iter().any(|(wish, _)| wish.name == member.wish.name));
    let scoring = Scoring::of(study, simulation, compared, members)?;
    let all = Cells { study, simulation, sweep, members, scoring: &scoring, options };
    let done = std::sync::atomic::AtomicUsize::new(0);
    let total = cells.len();
    let one = |(wish, value): &(ObserverSpec, f64)| match all.cell(wish, *value) {
        Ok(row) => {
            let count = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
            options.tell("sweep", &wish.name, count, total);
            Some(Ok(row))
        }
        Err(StudyError::Interrupted) => None,
        Err(error) => Some(Err(error)),
    };
    let rows = cells.par_iter().filter_map(one).collect::<Result<Vec<_>, StudyError>>()?;
    let (rows, excursions): (Vec<SweepRow>, Vec<Vec<Option<Excursion>>>) = rows.into_iter().unzip();
    let report = SweepReport {
        parameter: sweep.parameter.name().to_owned(),
        ensemble: sweep.ensemble,
        values: sweep.values.clone(),
        scoring: scoring.report(study),
        rows,
    };
    let warnings = warnings(&report, &excursions);
    Ok((report, warnings))
}

/// One sentence for each observer whose runs leave the region of its design.
fn warnings(report: &SweepReport, excursions: &[Vec<Option<Excursion>>]) -> Vec<String> {
    let mut names: Vec<&str> = report.rows.iter().map(|row| row.observer.as_str()).collect();
    names.dedup();
    let sentence = |name: &str| {
        let rows = report.rows.iter().zip(excursions).filter(|(row, _)| row.observer == name);
        let runs: Vec<(f64, &Option<Excursion>)> =
            rows.flat_map(|(row, runs)| runs.iter().map(|run| (row.value, run))).collect();
        let count = runs.iter().filter(|(_, run)| run.is_some()).count();
        let (value, first) = runs.iter().find_map(|(value, run)| Some((value, run.as_ref()?)))?;
        Some(first.in_sweep(name, count, runs.len(), &report.parameter, *value))
    };
    names.into_iter().filter_map(sentence).collect()
}

/// What all cells of a sweep have in common.
struct Cells<'a> {
    study: &'a Study,
    simulation: &'a Simulation,
    sweep: &'a Sweep,
    members: &'a [Member<'a>],
    scoring: &'a Scoring,
    options: &'a RunOptions<'a>,
}

impl Cells<'_> {
    /// A row, and for each run of it that finished how it left the region of the design.
    fn cell(&self, wish: &ObserverSpec, value: f64) -> Result<(SweepRow, Vec<Option<Excursion>>), StudyError> {
        let Self { study, simulation, sweep, members, scoring, options } = *self;
        options.check()?;
        let mut row = SweepRow {
            observer: wish.name.clone(),
            value,
            finished: 0,
            settling: None,
            rms: None,
            peak: None,
            last: None,
            states: Vec::new(),
            failure: None,
        };
        let anew: Designed;
        let designed = if matches!(sweep.parameter, Swept::Gamma | Swept::Poles) {
            match design(study, wish, options.cancel) {
                Ok(designed) => {
                    anew = designed;
                    &anew
                }
                Err(NoDesign::Interrupted) => return Err(StudyError::Interrupted),
                Err(NoDesign::Misfit(failure)) => {
                    row.failure = Some(failure.hypothesis);
                    return Ok((row, Vec::new()));
                }
            }
        } else {
            let Some(member) = member(members, &wish.name) else {
                row.failure = Some("no design".to_owned());
                return Ok((row, Vec::new()));
            };
            member.designed
        };
        let factor = if sweep.parameter == Swept::Noise { value } else { 1.0 };
        let (mut merits, mut excursions): (Vec<MeritsReport>, Vec<Option<Excursion>>) = (Vec::new(), Vec::new());
        for number in 0..sweep.ensemble {
            options.check()?;
            let initial = initial(wish, simulation, scoring.scale(), sweep.seed, number);
            let wish = ObserverSpec { initial, ..wish.clone() };
            let member = Member { wish: &wish, designed };
            // If the observer in the feedback loop is the swept one, its swept version is fed back, otherwise the
            // study's own.
            let variation = Variation { noise: factor, seed: number as u64 };
            let outcome = simulate::trajectory(study, simulation, members, Some(&member), variation)
                .and_then(|trajectory| Ok((scoring.merits(study, &trajectory, &wish.name)?, trajectory)));
            match outcome {
                Ok((one, trajectory)) => {
                    let run = simulate::samples(simulation, &trajectory, Some(&member));
                    excursions.push(excursion(study, &wish, &run));
                    merits.push(one);
                }
                Err(error) if error.ends_run() => {
                    row.failure.get_or_insert_with(|| why(study, &error));
                }
                Err(error) => return Err(error.into()),
            }
        }
        row.finished = merits.len();
        let norm =
            |score: fn(&NormReport) -> f64| median(merits.iter().filter_map(|one| Some(score(one.norm.as_ref()?))));
        (row.rms, row.peak, row.last) = (norm(|norm| norm.rms), norm(|norm| norm.peak), norm(|norm| norm.last));
        row.settling = norm(|norm| time(norm.settling_last)).filter(|time| time.is_finite());
        let first = merits.first().map(|one| one.states.as_slice()).unwrap_or_default();
        row.states = (0..first.len()).map(|i| medians(&merits, i, &first[i])).collect();
        Ok((row, excursions))
    }
}

/// A run that does not settle counts as infinite: the median is finite if most runs settle.
fn time(settling: Option<f64>) -> f64 {
    settling.unwrap_or(f64::INFINITY)
}

/// The median of each score of state i.
fn medians(runs: &[MeritsReport], i: usize, first: &StateReport) -> StateReport {
    let of = |score: fn(&StateReport) -> f64| median(runs.iter().map(|run| score(&run.states[i]))).unwrap_or(f64::NAN);
    StateReport {
        state: first.state.clone(),
        unit: first.unit.clone(),
        initial: of(|run| run.initial),
        rmse: of(|run| run.rmse),
        peak: of(|run| run.peak),
        overshoot: of(|run| run.overshoot),
        settling_5: Some(of(|run| time(run.settling_5))).filter(|time| time.is_finite()),
        settling_2: Some(of(|run| time(run.settling_2))).filter(|time| time.is_finite()),
        last: of(|run| run.last),
    }
}

/// The median; for an even number of values the lower of the middle two, which is an actual value.
fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len().saturating_sub(1) / 2).copied()
}
