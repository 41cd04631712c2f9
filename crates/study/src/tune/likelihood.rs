//! The log-likelihood of the innovations of a filter on the logs, as a function of what is fitted.

use std::sync::atomic::AtomicBool;

use luenberger_sim::replay::ReplayedObserver;
use luenberger_sim::{Recording, Settings};
use nalgebra::DMatrix;

use crate::design::Designed;
use crate::execute::{replay_of, replay_settings, with_variances};
use crate::kinds;
use crate::read::{Edit, Editable};
use crate::study::{Log, ObserverSpec, Study, Tunable, TuneSpec};
use crate::synthesis::Plan;

/// A log: times, inputs and outputs, and how many of its first rows are fitted.
pub(super) struct Data<'a> {
    pub(super) name: String,
    pub(super) t: Vec<f64>,
    u: DMatrix<Option<f64>>,
    y: DMatrix<Option<f64>>,
    log: &'a Log,
    pub(super) fitted: usize,
}

impl<'a> Data<'a> {
    fn new(name: &str, log: &'a Log, held_out: f64) -> Self {
        let recording = &log.recording;
        let table = |samples: &luenberger_sim::Samples| {
            let (rows, columns) = samples.values().shape();
            DMatrix::from_fn(rows, columns, |k, j| samples.value(k, j))
        };
        let t = recording.times().to_vec();
        let (u, y) = (table(recording.inputs()), table(recording.outputs()));
        Self { name: name.to_owned(), fitted: log.fitted(held_out), t, u, y, log }
    }

    /// The first rows, outputs less their biases.
    fn recording(&self, rows: usize, bias: &[f64]) -> Result<Recording, String> {
        let y = DMatrix::from_fn(rows, self.y.ncols(), |k, j| self.y[(k, j)].map(|y| y - bias[j]));
        let u = self.u.rows(0, rows).into_owned();
        Recording::with_missing(self.t[..rows].to_vec(), &u, &y).map_err(|error| error.to_string())
    }

    /// How many measurements rows have.
    pub(super) fn measurements(&self, rows: std::ops::Range<usize>) -> usize {
        rows.map(|k| self.y.row(k).iter().flatten().count()).sum()
    }

    /// The value of an input, if it is the same in all rows that are fitted.
    pub(super) fn constant_input(&self, input: usize) -> Option<f64> {
        let mut values = self.u.column(input).into_iter().take(self.fitted).flatten();
        let first = *values.next()?;
        values.all(|u| *u == first).then_some(first)
    }
}

/// The log-likelihood.
pub(super) struct Criterion<'a> {
    pub(super) study: &'a Study,
    pub(super) spec: &'a TuneSpec,
    pub(super) requested: &'a ObserverSpec,
    pub(super) editable: Editable<'a>,
    pub(super) data: Vec<Data<'a>>,
    /// As of any replay of the study.
    settings: Settings,
    /// Measurements that the gate of the filter rejects with the values of the study.
    pub(super) rejected: usize,
    pub(super) cancel: &'a AtomicBool,
}

impl<'a> Criterion<'a> {
    /// None if the text of the study has no such observer.
    pub(super) fn new(study: &'a Study, spec: &'a TuneSpec, cancel: &'a AtomicBool) -> Option<Self> {
        let requested = study.observer(&spec.observer)?;
        let editable = Editable::new(study, &spec.observer)?;
        let data = spec.logs.iter().map(|(name, log)| Data::new(name, log, spec.held_out)).collect();
        Some(Self {
            study,
            spec,
            requested,
            editable,
            data,
            settings: replay_settings(study, None),
            rejected: 0,
            cancel,
        })
    }

    /// Takes what the gate of the filter rejects with the values of the study as not measured, for all values: the
    /// likelihood would grow with what is rejected.
    pub(super) fn reject(&mut self) -> Result<(), String> {
        let plan = Plan { study: self.study, requested: self.requested, cancel: self.cancel, end: None };
        let designed = kinds::with_covariance(&plan).map_err(|none| none.hypothesis)?;
        let none = vec![0.0; self.study.plant.outputs.len()];
        for data in &mut self.data {
            let recording = data.recording(data.t.len(), &none)?;
            let replayed = run(self.study, (self.requested, &designed), (data.log, recording), self.settings)?;
            for (k, j) in replayed.consistency.iter().flat_map(|consistency| &consistency.rejected) {
                if let Some(row) = replayed.row[*k] {
                    data.y[(row, *j)] = None;
                    self.rejected += 1;
                }
            }
        }
        Ok(())
    }

    /// The values of the study.
    pub(super) fn start(&self) -> Vec<f64> {
        self.spec.parameters.iter().map(|one| one.value).collect()
    }

    /// The filter with these values on the logs, on what is fitted or on all rows.
    pub(super) fn replayed(&self, values: &[f64], is_whole: bool) -> Result<Vec<ReplayedObserver>, String> {
        let edits = self.edits(values, false)?;
        let study = self.editable.study(&edits)?;
        let requested = study.observer(&self.spec.observer).ok_or("the study has lost its observer")?;
        let plan = Plan { study: &study, requested, cancel: self.cancel, end: None };
        let designed = kinds::with_covariance(&plan).map_err(|none| none.hypothesis)?;
        let mut bias = vec![0.0; study.plant.outputs.len()];
        for (one, value) in self.spec.parameters.iter().zip(values) {
            if let Tunable::Bias(j) = one.what {
                bias[j] = *value;
            }
        }
        let of = |data: &Data<'_>| {
            let rows = if is_whole { data.t.len() } else { data.fitted };
            run(&study, (requested, &designed), (data.log, data.recording(rows, &bias)?), self.settings)
        };
        self.data.iter().map(of).collect()
    }

    /// What changes in the study.
    pub(super) fn edits(&self, values: &[f64], is_written: bool) -> Result<Vec<Edit>, String> {
        let edits = self.editable.edits(&self.spec.parameters, values, is_written);
        edits.ok_or_else(|| "the study has no place for the values".to_owned())
    }

    /// `sum ln p(y_k | y_1 .. y_k-1)` over the rows that are fitted.
    pub(super) fn log_likelihood(&self, values: &[f64]) -> Result<f64, String> {
        let replayed = self.replayed(values, false)?;
        let sums = replayed.iter().map(|replayed| sum(replayed, 0));
        let total: f64 = sums.collect::<Result<Vec<_>, _>>()?.iter().sum();
        if total.is_finite() { Ok(total) } else { Err(format!("the log-likelihood is {total}")) }
    }

    /// The same over the rows that are held out, of a replay of all rows.
    pub(super) fn held_out(&self, replayed: &[ReplayedObserver]) -> Result<f64, String> {
        let sums = replayed.iter().zip(&self.data).map(|(replayed, data)| sum(replayed, data.fitted));
        Ok(sums.collect::<Result<Vec<_>, _>>()?.iter().sum())
    }
}

/// The sum from this row on.
fn sum(replayed: &ReplayedObserver, from: usize) -> Result<f64, String> {
    let consistency = replayed.consistency.as_ref().ok_or("the observer is no filter with a covariance")?;
    // A measurement that is passed over would be a gain.
    if let Some(k) = consistency.passed_over.first() {
        return Err(format!("the covariance of the innovation is not positive definite at t = {}", replayed.t[*k]));
    }
    let is_in = |k: &usize| replayed.row[*k].is_some_and(|row| row >= from);
    Ok((0..replayed.t.len()).filter(is_in).filter_map(|k| consistency.log_likelihood[k]).sum())
}

fn run(
    study: &Study,
    (requested, designed): (&ObserverSpec, &Designed),
    (log, recording): (&Log, Recording),
    settings: Settings,
) -> Result<ReplayedObserver, String> {
    let replay = replay_of(&study.plant, recording, settings);
    let of_rows = with_variances(&designed.runnable, log);
    let runnable = of_rows.as_ref().unwrap_or(&designed.runnable);
    let replayed = runnable.replay(replay, &requested.name, &requested.initial).run();
    let mut replayed = replayed.map_err(|error| error.to_string())?;
    replayed.observers.pop().ok_or_else(|| "the log was not replayed".to_owned())
}
