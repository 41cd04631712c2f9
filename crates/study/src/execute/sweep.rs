//! Parameter sweep: every observer at every value, with an ensemble of noise seeds and initial errors, in parallel.
//!
//! Each run depends only on the study, the value and its index in the ensemble. Number and order of threads do not
//! affect the result.

use luenberger_sim::{Noise, SimError};
use rayon::prelude::*;

use super::options::RunOptions;
use super::simulate::{self, Variation};
use super::{Member, member};
use crate::design::{Designed, NoDesign, design};
use crate::error::StudyError;
use crate::results::{MeritsReport, SweepReport, SweepRow};
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
/// norm in random directions.
fn initial(wish: &ObserverSpec, simulation: &Simulation, seed: u64, number: usize) -> Vec<f64> {
    if number == 0 {
        return wish.initial.clone();
    }
    // Gaussian entries, so that the direction is uniformly distributed.
    let direction = Noise::gaussian(&vec![1.0; simulation.x0.len()], 1.0, seed).sample(number as u64);
    let norm = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    let error = simulate::initial_error(simulation, &wish.initial);
    simulation.x0.iter().zip(&direction).map(|(x, d)| x - error * d / norm).collect()
}

/// Number of runs of a sweep.
pub(super) fn runs(study: &Study, sweep: &Sweep) -> usize {
    chosen(study, sweep).len() * sweep.values.len() * sweep.ensemble
}

fn chosen<'a>(study: &'a Study, sweep: &Sweep) -> Vec<&'a ObserverSpec> {
    let named = |wish: &&ObserverSpec| sweep.observers.as_ref().is_none_or(|names| names.contains(&wish.name));
    study.observers.iter().filter(named).collect()
}

/// The rows in the order of observers and values; rows not finished before an interruption are omitted.
pub(super) fn all(
    study: &Study,
    simulation: &Simulation,
    sweep: &Sweep,
    members: &[Member<'_>],
    options: &RunOptions<'_>,
) -> Result<SweepReport, StudyError> {
    let cells: Vec<(&ObserverSpec, f64)> = chosen(study, sweep)
        .into_iter()
        .flat_map(|wish| sweep.values.iter().map(move |value| (wish, *value)))
        .collect();
    let cells: Vec<(ObserverSpec, f64)> = cells
        .into_iter()
        .filter_map(|(wish, value)| Some((varied(wish, simulation, sweep.parameter, value)?, value)))
        .collect();
    let done = std::sync::atomic::AtomicUsize::new(0);
    let total = cells.len();
    let one =
        |(wish, value): &(ObserverSpec, f64)| match cell(study, simulation, sweep, members, (wish, *value), options) {
            Ok(row) => {
                let count = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
                options.tell("sweep", &wish.name, count, total);
                Some(Ok(row))
            }
            Err(StudyError::Interrupted) => None,
            Err(error) => Some(Err(error)),
        };
    let rows = cells.par_iter().filter_map(one).collect::<Result<Vec<SweepRow>, StudyError>>()?;
    Ok(SweepReport {
        parameter: sweep.parameter.name().to_owned(),
        ensemble: sweep.ensemble,
        values: sweep.values.clone(),
        rows,
    })
}

fn cell(
    study: &Study,
    simulation: &Simulation,
    sweep: &Sweep,
    members: &[Member<'_>],
    (wish, value): (&ObserverSpec, f64),
    options: &RunOptions<'_>,
) -> Result<SweepRow, StudyError> {
    options.check()?;
    let mut row = SweepRow {
        observer: wish.name.clone(),
        value,
        finished: 0,
        settling: None,
        rms: None,
        peak: None,
        last: None,
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
                return Ok(row);
            }
        }
    } else {
        let Some(member) = member(members, &wish.name) else {
            row.failure = Some("it has no design".to_owned());
            return Ok(row);
        };
        member.designed
    };
    let factor = if sweep.parameter == Swept::Noise { value } else { 1.0 };
    let mut merits: Vec<MeritsReport> = Vec::new();
    for number in 0..sweep.ensemble {
        options.check()?;
        let wish = ObserverSpec { initial: initial(wish, simulation, sweep.seed, number), ..wish.clone() };
        let member = Member { wish: &wish, designed };
        // If the observer in the feedback loop is the swept one, its swept version is fed back, otherwise the study's
        // own.
        let variation = Variation { noise: factor, seed: number as u64 };
        let outcome = simulate::trajectory(study, simulation, members, Some(&member), variation)
            .and_then(|trajectory| simulate::merits(study, simulation, &trajectory, &member));
        match outcome {
            Ok(one) => merits.push(one),
            Err(
                error @ (SimError::BlowUp { .. }
                | SimError::NotDefined { .. }
                | SimError::StepSize { .. }
                | SimError::TooManySteps { .. }),
            ) => {
                row.failure.get_or_insert_with(|| error.to_string());
            }
            Err(error) => return Err(error.into()),
        }
    }
    row.finished = merits.len();
    row.rms = median(merits.iter().map(|merits| merits.rms));
    row.peak = median(merits.iter().map(|merits| merits.peak));
    row.last = median(merits.iter().map(|merits| merits.last));
    // A run that does not settle counts as infinite: the median is finite if most runs settle.
    let settling = median(merits.iter().map(|merits| merits.settling_last.unwrap_or(f64::INFINITY)));
    row.settling = settling.filter(|time| time.is_finite());
    Ok(row)
}

/// The median; for an even number of values the lower of the middle two, which is an actual value.
fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len().saturating_sub(1) / 2).copied()
}
