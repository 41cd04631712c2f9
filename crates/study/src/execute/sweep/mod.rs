//! Parameter sweep: every observer at every value, with an ensemble of noise seeds and initial errors, in parallel.
//!
//! Each run depends only on the study, the value and its index in the ensemble. Number and order of threads do not
//! affect the result.

mod runs;
mod statistics;

use std::sync::atomic::{AtomicUsize, Ordering};

use luenberger_proof::wording::counted;
use luenberger_sim::{Noise, SimError};
use rayon::prelude::*;

use super::excursion::{self, Excursion};
use super::options::RunOptions;
use super::scores::Scoring;
use super::simulate::{self, Variation};
use super::stopped::why;
use super::{Member, member};
use crate::design::{Designed, NoDesign, design_until};
use crate::error::StudyError;
use crate::results::{MeritsReport, SweepReport, SweepRow};
use crate::study::{ObserverSpec, Simulation, Study, Sweep, Swept};

/// The specification of an observer at a value; none if it does not have the parameter.
fn varied(wish: &ObserverSpec, simulation: &Simulation, parameter: &Swept, value: f64) -> Option<ObserverSpec> {
    let mut wish = wish.clone();
    match parameter {
        Swept::Gamma => wish.kind = wish.kind.with_gamma(value)?,
        Swept::Poles => wish.kind = wish.kind.faster(value),
        Swept::Noise | Swept::Number(_) => {}
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

/// What a sweep leaves.
pub(super) struct Outcome {
    pub(super) report: SweepReport,
    pub(super) warnings: Vec<String>,
    /// Every run as a line of comma-separated values.
    pub(super) csv: String,
}

/// The rows in the order of observers and values; rows not finished before an interruption are omitted.
pub(super) fn all(
    study: &Study,
    simulation: &Simulation,
    sweep: &Sweep,
    members: &[Member<'_>],
    options: &RunOptions<'_>,
) -> Result<Outcome, StudyError> {
    let mut cells = Vec::new();
    for wish in chosen(study, sweep) {
        for (k, &value) in sweep.values.iter().enumerate() {
            // A number of the study is varied in the study itself.
            let study = sweep.variants.get(k).unwrap_or(study);
            let Some(wish) = study.observer(&wish.name) else { continue };
            let simulation = study.simulation.as_ref().unwrap_or(simulation);
            let Some(wish) = varied(wish, simulation, &sweep.parameter, value) else { continue };
            cells.push(Cell { study, simulation, wish, value });
        }
    }
    let compared = members.iter().filter(|member| cells.iter().any(|cell| cell.wish.name == member.wish.name));
    let scoring = Scoring::of(study, simulation, compared, members)?;
    let report = scoring.report(study);
    let all = Common {
        sweep,
        members,
        scoring: &scoring,
        options,
        head: runs::head(study, sweep.parameter.name(), &report),
        done: AtomicUsize::new(0),
        total: cells.len() * sweep.ensemble,
    };
    let one = |cell: &Cell<'_>| match all.cell(cell) {
        Ok(row) => Some(Ok(row)),
        Err(StudyError::Interrupted) => None,
        Err(error) => Some(Err(error)),
    };
    let finished = cells.par_iter().filter_map(one).collect::<Result<Vec<Finished>, StudyError>>()?;
    let mut csv = runs::line(&all.head);
    csv.extend(finished.iter().map(|row| row.csv.as_str()));
    let (rows, excursions): (Vec<_>, Vec<_>) = finished.into_iter().map(|row| (row.row, row.excursions)).unzip();
    let report = SweepReport {
        parameter: sweep.parameter.name().to_owned(),
        ensemble: sweep.ensemble,
        values: sweep.values.clone(),
        scoring: report,
        rows,
    };
    let mut warnings = warnings(&report, &excursions);
    if report.rows.len() < cells.len() {
        let (open, all) = (cells.len() - report.rows.len(), cells.len());
        warnings.push(format!("Not finished: {open} of {} of the sweep", counted(all, "row")));
    }
    Ok(Outcome { report, warnings, csv })
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

/// One observer at one value.
struct Cell<'a> {
    study: &'a Study,
    simulation: &'a Simulation,
    wish: ObserverSpec,
    value: f64,
}

/// A row, for each run of it that finished how it left the region of the design, and the lines of its runs.
struct Finished {
    row: SweepRow,
    excursions: Vec<Option<Excursion>>,
    csv: String,
}

/// What all cells of a sweep have in common.
struct Common<'a> {
    sweep: &'a Sweep,
    members: &'a [Member<'a>],
    scoring: &'a Scoring,
    options: &'a RunOptions<'a>,
    /// The head of the table of runs.
    head: Vec<String>,
    /// Runs that are done, of all.
    done: AtomicUsize,
    total: usize,
}

impl Common<'_> {
    fn told(&self, name: &str, runs: usize) {
        let count = self.done.fetch_add(runs, Ordering::Relaxed) + runs;
        self.options.tell("sweep", name, count, self.total);
    }

    fn cell(&self, cell: &Cell<'_>) -> Result<Finished, StudyError> {
        let Self { sweep, members, options, .. } = *self;
        let Cell { study, wish, value, .. } = cell;
        options.check()?;
        let mut row = SweepRow { observer: wish.name.clone(), value: *value, ..SweepRow::default() };
        let none = |mut row: SweepRow, why: String| {
            self.told(&wish.name, sweep.ensemble);
            row.failure = Some(why);
            Ok(Finished { row, excursions: Vec::new(), csv: String::new() })
        };
        let anew: Designed;
        let designed = if sweep.parameter.redesigns() {
            match design_until(study, wish, options.cancel, options.until) {
                Ok(designed) => {
                    anew = designed;
                    &anew
                }
                Err(NoDesign::Interrupted) => return Err(StudyError::Interrupted),
                Err(NoDesign::Misfit(failure)) => return none(row, failure.hypothesis),
            }
        } else {
            let Some(member) = member(members, &wish.name) else { return none(row, "no design".to_owned()) };
            member.designed
        };
        // The observer that is fed back is designed for the same study, unless it is the swept one.
        let other = simulate::fed(study).filter(|fed| *fed != wish.name).and_then(|fed| study.observer(fed));
        let fed: Option<(&ObserverSpec, Designed)> = match (&sweep.parameter, other) {
            (Swept::Number(_), Some(fed)) if sweep.parameter.redesigns() => {
                match design_until(study, fed, options.cancel, options.until) {
                    Ok(designed) => Some((fed, designed)),
                    Err(NoDesign::Interrupted) => return Err(StudyError::Interrupted),
                    Err(NoDesign::Misfit(failure)) => {
                        return none(
                            row,
                            format!("the observer {:?} in the feedback loop: {}", fed.name, failure.hypothesis),
                        );
                    }
                }
            }
            _ => None,
        };
        let fed = fed.as_ref().map(|(wish, designed)| Member { wish, designed });
        let others: Vec<Member<'_>> = match fed {
            Some(fed) => vec![fed],
            None => members.to_vec(),
        };
        let runs = (0..sweep.ensemble).into_par_iter().map(|number| self.run(cell, designed, &others, number));
        let runs = runs.collect::<Result<Vec<_>, StudyError>>()?;
        let (mut merits, mut excursions, mut csv) = (Vec::new(), Vec::new(), String::new());
        for (number, run) in runs.into_iter().enumerate() {
            let outcome = run.as_ref().map(|(merits, _)| merits).map_err(String::as_str);
            csv += &runs::line(&runs::cells((&wish.name, *value, number), outcome, self.head.len()));
            match run {
                Ok((one, excursion)) => {
                    merits.push(one);
                    excursions.push(excursion);
                }
                Err(why) => {
                    row.failure.get_or_insert(why);
                }
            }
        }
        statistics::fill(&mut row, &merits);
        Ok(Finished { row, excursions, csv })
    }

    /// One run: its scores and how it left the region, or why it ended early.
    fn run(
        &self,
        cell: &Cell<'_>,
        designed: &Designed,
        others: &[Member<'_>],
        number: usize,
    ) -> Result<Ran, StudyError> {
        self.options.check()?;
        let Cell { study, simulation, wish, value } = cell;
        let initial = initial(wish, simulation, self.scoring.scale(), self.sweep.seed, number);
        let wish = ObserverSpec { initial, ..wish.clone() };
        let member = Member { wish: &wish, designed };
        let factor = if self.sweep.parameter == Swept::Noise { *value } else { 1.0 };
        let variation = Variation { noise: factor, seed: number as u64 };
        let outcome = simulate::trajectory(study, simulation, others, Some(&member), variation, self.options.until)
            .and_then(|trajectory| {
                let merits = self.scoring.merits(study, &trajectory, &wish.name)?;
                Ok((merits, excursion::of_simulation(study, &wish, &trajectory)?))
            });
        self.told(&wish.name, 1);
        match outcome {
            Ok(finished) => Ok(Ok(finished)),
            Err(SimError::TimeLimit { .. }) => Err(StudyError::Interrupted),
            Err(error) if error.ends_run() => Ok(Err(why(study, &error))),
            Err(error) => Err(error.into()),
        }
    }
}

/// A run that finished, or why it ended.
type Ran = Result<(MeritsReport, Option<Excursion>), String>;
