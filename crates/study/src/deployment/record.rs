//! The run of the study at the samples of an export: what the exported step is compared with.

use luenberger_clock::stop_flag;

use luenberger_proof::wording::{at_most, counted};
use luenberger_sim::Trajectory;
use serde::Serialize;

use super::Sampled;
use crate::design::{Designed, attempt};
use crate::study::{ObserverSpec, Study};
use crate::trajectory::{self, Member};

/// Samples of a run that are compared at most.
const MOST: usize = 20_000;

/// Inputs, measured outputs and estimates of a run, sample by sample.
#[derive(Debug, Clone, Default)]
pub struct Record {
    /// Inputs and measured outputs of each sample; at varying periods the time since the last one is behind the inputs.
    pub samples: Vec<(Vec<f64>, Vec<f64>)>,
    /// The estimate of the study's observer for the end of each period; in filter form and at varying periods at the
    /// sample.
    pub estimates: Vec<Vec<f64>>,
    /// The state of the plant at the same instant.
    pub states: Vec<Vec<f64>>,
}

/// The run of an observer in the simulation of the study, with its own step or in continuous time; none without a
/// simulation, with sensors of other periods, and if it cannot be simulated.
pub fn record(study: &Study, observer: &ObserverSpec, sampled: &Sampled) -> Option<Record> {
    // The exported step knows no sensors with instants of their own.
    let simulation = study.simulation.as_ref().filter(|simulation| simulation.sensors.is_empty())?;
    let cancel = stop_flag().unwrap_or_default();
    let others =
        study.observers.iter().filter(|other| trajectory::is_fed(study, &other.name) || other.name == observer.name);
    let of_the_study = |other: &ObserverSpec| match &sampled.of_the_study {
        Some(designed) if other.name == observer.name => Some(designed.clone()),
        _ => attempt(study, other, &cancel, None).ok(),
    };
    let designed: Vec<(&ObserverSpec, Designed)> =
        others.filter_map(|other| Some((other, of_the_study(other)?))).collect();
    let period = sampled.period;
    let is_varying = observer.kind.varying_periods().is_some();
    let members: Vec<Member<'_>> =
        designed.iter().map(|(requested, designed)| Member { requested, designed }).collect();
    let member = members.iter().find(|member| member.requested.name == observer.name)?;
    let count = ((simulation.duration / period + 1e-9).floor() as usize).min(MOST);
    let times: Vec<f64> = (0..=count).map(|k| (k as f64 * period).min(simulation.duration)).collect();
    let run_at = |times: &[f64]| trajectory::of_observer_at(study, simulation, &members, member, times);
    if is_varying {
        return at_samples(simulation.duration, &observer.name, &run_at);
    }
    let run = run_at(&times)?;
    let row = |m: &nalgebra::DMatrix<f64>, k: usize| m.row(k).iter().copied().collect::<Vec<_>>();
    let estimate = &run.observer(&observer.name).ok()?.estimate;
    let wanted = match observer.kind.functions() {
        Some((k, _)) => &run.x * k.transpose(),
        None => run.x.clone(),
    };
    let first = usize::from(!sampled.design.is_of_sample(observer));
    Some(Record {
        samples: (0..count).map(|k| (row(&run.u, k), row(&run.measured, k))).collect(),
        estimates: (first..first + count).map(|k| row(estimate, k)).collect(),
        states: (first..first + count).map(|k| row(&wanted, k)).collect(),
    })
}

/// The run of an observer at varying periods, at the samples that arrive: its step takes the inputs held since the last
/// one, with the time since then behind them.
fn at_samples(end: f64, name: &str, run_at: &dyn Fn(&[f64]) -> Option<Trajectory>) -> Option<Record> {
    let drawn = run_at(&[0.0, end])?;
    let arrived = drawn.observer(name).ok()?.samples.iter().filter(|sample| sample.arrives);
    let times: Vec<f64> = std::iter::once(0.0).chain(arrived.map(|sample| sample.time).take(MOST)).collect();
    let ended = times.last().is_some_and(|last| *last >= end);
    let run = run_at(&times.iter().copied().chain((!ended).then_some(end)).collect::<Vec<_>>())?;
    let row = |m: &nalgebra::DMatrix<f64>, k: usize| m.row(k).iter().copied().collect::<Vec<_>>();
    let estimate = &run.observer(name).ok()?.estimate;
    let sample = |k: usize| {
        let mut u = row(&run.u, k - 1);
        u.push(times[k] - times[k - 1]);
        (u, row(&run.measured, k))
    };
    Some(Record {
        samples: (1..times.len()).map(sample).collect(),
        estimates: (1..times.len()).map(|k| row(estimate, k)).collect(),
        states: (1..times.len()).map(|k| row(&run.x, k)).collect(),
    })
}

/// How far the exported step is from the observer of the study along its run, for each state.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    /// The largest difference of the estimates.
    pub largest: Vec<f64>,
    /// The same in the second half of the run.
    #[serde(rename = "second_half")]
    pub late: Vec<f64>,
    /// The largest error of the study's observer in the second half.
    #[serde(rename = "own_error_in_second_half")]
    pub own: Vec<f64>,
}

impl Record {
    /// The difference from exported estimates, one for each sample; `None` for an empty run.
    pub fn difference(&self, exported: &[Vec<f64>]) -> Option<Difference> {
        let count = self.estimates.len().min(exported.len());
        let n = self.estimates.first()?.len();
        let largest = |from: usize, a: &[Vec<f64>], b: &[Vec<f64>]| -> Vec<f64> {
            let of = |i: usize| a[from..count].iter().zip(&b[from..count]).map(move |(a, b)| (a[i] - b[i]).abs());
            // Not a number is larger than every number.
            (0..n).map(|i| of(i).fold(0.0, |x: f64, y| if y <= x { x } else { y })).collect()
        };
        let half = count / 2;
        Some(Difference {
            largest: largest(0, &self.estimates, exported),
            late: largest(half, &self.estimates, exported),
            own: largest(half, &self.estimates, &self.states),
        })
    }
}

/// The exported step of a [`Difference`], for its words.
#[derive(Debug, Clone, Copy)]
pub struct Compared<'a> {
    /// The format of its numbers.
    pub format: &'a str,
    /// The name with which its functions begin.
    pub step: &'a str,
    /// In how many samples of the run a value is cut off at an end of the range of the format.
    pub saturated: usize,
}

impl Difference {
    /// As a sentence, with the names and units of the states.
    pub fn words(&self, study: &Study, observer: &ObserverSpec, compared: &Compared<'_>) -> String {
        let Compared { format, step, saturated } = *compared;
        let plant = &study.plant;
        let one = |(name, value): (&String, &f64)| format!("{name} {}", plant.measured(name, at_most(*value, 3)));
        let list = |values: &[f64]| plant.states.iter().zip(values).map(one).collect::<Vec<_>>().join(", ");
        let whose = match observer.kind.period().or(plant.dt) {
            Some(_) => "the observer of the study in binary64",
            None => "the observer in continuous time",
        };
        if self.largest.iter().all(|difference| *difference == 0.0) {
            return format!(
                "Along the study's run the exported step in {format} gives the same estimates as {whose}, to the last bit."
            );
        }
        let far = self.late.iter().zip(&self.own).any(|(late, own)| late > own || late.is_nan());
        let advice = match observer.kind.period().or(plant.dt) {
            Some(_) if far && observer.kind.varying_periods().is_some() && !plant.inputs.is_empty() => &format!(
                " In this comparison the input of the last sample is held until the next; a prediction ({step}_predict) at each change of the input, and {step}_update at the sample, remove that difference."
            ),
            _ if saturated > 0 => &format!(
                " In {} of the run a value is beyond the range of {format} and cut off at its end: more bits before the point, or other units of the signals.",
                counted(saturated, "sample")
            ),
            None if far => " That is more than its own error: a shorter period brings the exported step nearer to it.",
            _ => "",
        };
        format!(
            "Along the study's run the exported step in {format} differs from {whose} by at most {}; in the second half of the run by at most {}, where the error of that observer itself is at most {}.{advice}",
            list(&self.largest),
            list(&self.late),
            list(&self.own)
        )
    }
}
