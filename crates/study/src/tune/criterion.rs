//! What a fit is by, as a function of what is fitted: the log-likelihood of the innovations of a filter on the logs, or
//! that of normally distributed prediction errors, or errors of states, with the variances that they have.
//!
//! For prediction errors with unknown variances the largest log-likelihood over the variances is
//! `-sum_j N_j/2 (ln(2 pi rms_j^2) + 1)`: the least geometric mean of the rms of the outputs is the most likely (Ljung
//! 1999, section 7.4). Errors of states are added in units of the deviations of the states, `J = mean_i (rms_i/d_i)^2`.
//!
//! Measurements that are late stand at their times in what the likelihood is of: the terms of a record do not depend on
//! the order in which it became known. What is measured within the longest delay after the first row of a part would be
//! of another part for another delay, and is left out.

use std::sync::atomic::AtomicBool;

use luenberger_sim::replay::ReplayedObserver;
use luenberger_sim::{BetweenRows, Recording, SampleInterpolation, Samples, Settings};
use nalgebra::DMatrix;

use crate::design::{Designed, attempt};
use crate::execute::prediction::Predictions;
use crate::execute::{replay_of, replay_settings, with_variances};
use crate::kinds;
use crate::read::{Edit, Editable};
use crate::study::{Log, ObserverSpec, Study, Tunable, TuneCriterion, TuneSpec};
use crate::synthesis::Plan;
use crate::trajectory::Member;

/// A log: times, inputs and outputs, and how many of its first rows are fitted.
pub(super) struct Data<'a> {
    pub(super) name: String,
    pub(super) t: Vec<f64>,
    u: DMatrix<Option<f64>>,
    y: DMatrix<Option<f64>>,
    log: &'a Log,
    pub(super) fitted: usize,
}

/// Rows that are closer than this share of the median period are one.
const SAME: f64 = 1e-6;

impl<'a> Data<'a> {
    /// The log without what is measured within the `longest` delay of each output after the start of its parts.
    fn new(name: &str, log: &'a Log, held_out: f64, longest: &[f64]) -> Self {
        let recording = &log.recording;
        let table = |samples: &Samples| {
            let (rows, columns) = samples.values().shape();
            DMatrix::from_fn(rows, columns, |k, j| samples.value(k, j))
        };
        let (t, fitted) = (recording.times().to_vec(), log.fitted(held_out));
        let (u, mut y) = (table(recording.inputs()), table(recording.outputs()));
        let same = SAME * recording.median_period();
        for start in [0, fitted] {
            for (j, delay) in longest.iter().enumerate().filter(|_| start < t.len()) {
                for k in (start..t.len()).take_while(|k| t[*k] < t[start] + delay - same) {
                    y[(k, j)] = None;
                }
            }
        }
        Self { name: name.to_owned(), fitted, t, u, y, log }
    }

    fn value(&self, k: usize, j: usize, bias: &[f64]) -> Option<f64> {
        self.y[(k, j)].map(|y| y - bias[j])
    }

    /// The first rows, outputs less their biases.
    fn recording(&self, rows: usize, bias: &[f64]) -> Result<Recording, String> {
        let y = DMatrix::from_fn(rows, self.y.ncols(), |k, j| self.value(k, j, bias));
        let u = self.u.rows(0, rows).into_owned();
        let recording = Recording::with_missing(self.t[..rows].to_vec(), &u, &y).map_err(|error| error.to_string())?;
        Ok(recording.between(self.log.recording.inputs().between(), BetweenRows::Predicted))
    }

    /// The first rows as a log, with the rule of the study for what is between them.
    fn log(&self, rows: usize, bias: &[f64]) -> Result<Log, String> {
        let (recording, between) = (self.recording(rows, bias)?, self.log.recording.outputs_between());
        let inputs = recording.inputs().between();
        Ok(Log { recording: recording.between(inputs, between), suspicions: Vec::new(), ..self.log.clone() })
    }

    /// The first rows with late outputs at their times, outputs less their biases, and the variances of these rows.
    fn on_time(&self, rows: usize, (bias, delays): (&[f64], &[f64])) -> Result<(Recording, Option<Samples>), String> {
        let same = SAME * self.log.recording.median_period();
        let late = |k: usize| (0..self.y.ncols()).filter(move |j| delays[*j] > 0.0 && self.y[(k, *j)].is_some());
        let mut t = self.t[..rows].to_vec();
        t.extend((0..rows).flat_map(|k| late(k).map(move |j| self.t[k] - delays[j])));
        t.sort_by(f64::total_cmp);
        t.dedup_by(|next, last| *next - *last <= same);
        let place = |time: f64| t.partition_point(|other| *other < time - same);
        let (mut u, mut y) = (
            DMatrix::from_element(t.len(), self.u.ncols(), None),
            DMatrix::from_element(t.len(), self.y.ncols(), None),
        );
        let mut variances = y.clone();
        for k in 0..rows {
            let row = place(self.t[k]);
            u.set_row(row, &self.u.row(k));
            for j in 0..self.y.ncols() {
                let row = if delays[j] > 0.0 { place(self.t[k] - delays[j]) } else { row };
                if self.y[(k, j)].is_some() {
                    y[(row, j)] = self.value(k, j, bias);
                    variances[(row, j)] = self.log.variances.as_ref().and_then(|of| of.value(k, j));
                }
            }
        }
        let recording = Recording::with_missing(t.clone(), &u, &y).map_err(|error| error.to_string())?;
        let recording = recording.between(self.log.recording.inputs().between(), BetweenRows::Predicted);
        let variances = self.log.variances.as_ref().map(|_| {
            Samples::with_missing(t, &variances, SampleInterpolation::ZeroOrderHold).map_err(|error| error.to_string())
        });
        Ok((recording, variances.transpose()?))
    }

    /// The period of rows that are equally spaced.
    pub(super) fn equal_period(&self) -> Option<f64> {
        let (first, last) = (self.t[0], self.t[self.fitted - 1]);
        let period = (last - first) / (self.fitted - 1).max(1) as f64;
        let is_equal = |pair: &[f64]| (pair[1] - pair[0] - period).abs() < 1e-3 * period;
        (period > 0.0 && self.t[..self.fitted].windows(2).all(is_equal)).then_some(period)
    }

    /// Inputs, and outputs less their biases, of the rows that are fitted, if all are measured, with one variance.
    pub(super) fn recorded(&self, bias: &[f64]) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let all = |of: &DMatrix<Option<f64>>| -> Option<DMatrix<f64>> {
            let cells: Option<Vec<f64>> = of.rows(0, self.fitted).iter().copied().collect();
            Some(DMatrix::from_vec(self.fitted, of.ncols(), cells?))
        };
        let mut y = all(&self.y)?;
        for (j, bias) in bias.iter().enumerate() {
            y.column_mut(j).add_scalar_mut(-bias);
        }
        let inputs = self.log.recording.inputs();
        let is_held = inputs.between() == SampleInterpolation::ZeroOrderHold || inputs.values().ncols() == 0;
        (self.log.variances.is_none() && is_held).then_some((all(&self.u)?, y))
    }

    /// How many measurements rows have.
    pub(super) fn measurements(&self, rows: std::ops::Range<usize>) -> usize {
        rows.map(|k| self.y.row(k).iter().flatten().count()).sum()
    }

    /// The reading of an output at the row of this time; none if no row has it.
    pub(super) fn reading(&self, t: f64, j: usize) -> Option<f64> {
        let same = SAME * self.log.recording.median_period();
        let k = self.t.partition_point(|row| *row < t - same);
        (*self.t.get(k)? <= t + same).then(|| self.y[(k, j)])?
    }

    /// The true values of a state that rows have.
    fn truth(&self, i: usize, rows: std::ops::Range<usize>) -> impl Iterator<Item = f64> {
        let truth = self.log.truth.as_ref();
        rows.filter_map(move |k| truth?.value(k, i))
    }

    /// The value of an input, if it is the same in all rows that are fitted.
    pub(super) fn constant_input(&self, input: usize) -> Option<f64> {
        let mut values = self.u.column(input).into_iter().take(self.fitted).flatten();
        let first = *values.next()?;
        values.all(|u| *u == first).then_some(first)
    }
}

/// A run of a filter on a log with its measurements at their times, and its first row that is held out.
pub(super) struct OnTime {
    pub(super) replayed: ReplayedObserver,
    first: usize,
}

impl OnTime {
    /// Its samples that are held out.
    pub(super) fn held_out(&self) -> Vec<usize> {
        (0..self.replayed.t.len()).filter(|k| self.replayed.row[*k].is_some_and(|row| row >= self.first)).collect()
    }

    /// Their log-likelihood.
    pub(super) fn log_likelihood_held_out(&self) -> Result<f64, String> {
        sum(self, self.first)
    }
}

/// Mean squares of errors: how many, their rms, and what they are relative to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Errors {
    pub(super) count: usize,
    pub(super) rms: f64,
    pub(super) deviation: f64,
}

impl Errors {
    fn of(errors: &[f64], about: &[f64]) -> Self {
        let deviation = rms(about);
        Self { count: errors.len(), rms: rms(errors), deviation: if deviation > 0.0 { deviation } else { 1.0 } }
    }
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// What is fitted.
pub(super) struct Criterion<'a> {
    pub(super) study: &'a Study,
    pub(super) spec: &'a TuneSpec,
    pub(super) requested: &'a ObserverSpec,
    pub(super) editable: Editable<'a>,
    pub(super) data: Vec<Data<'a>>,
    /// As of any replay of the study.
    settings: Settings,
    /// Measurements that the gate of the filter rejects with the values of the study: of the rows that are fitted, and
    /// of those that are held out.
    pub(super) rejected: [usize; 2],
    /// How many errors there are with the values of the study.
    count: Option<usize>,
    pub(super) cancel: &'a AtomicBool,
}

impl<'a> Criterion<'a> {
    /// None if the text of the study has no such observer.
    pub(super) fn new(study: &'a Study, spec: &'a TuneSpec, cancel: &'a AtomicBool) -> Option<Self> {
        let requested = study.observer(&spec.observer)?;
        let editable = Editable::new(study, &spec.observer)?;
        let mut longest = delays(study);
        for one in &spec.parameters {
            if let (Tunable::Delay(j), Some((_, high))) = (&one.what, one.bounds) {
                longest[*j] = high;
            }
        }
        let data = spec.logs.iter().map(|(name, log)| Data::new(name, log, spec.held_out, &longest)).collect();
        Some(Self {
            study,
            spec,
            requested,
            editable,
            data,
            settings: replay_settings(study, None),
            rejected: [0; 2],
            count: None,
            cancel,
        })
    }

    /// What holds for all values, from those of the study: what the gate of a filter rejects is not measured, since the
    /// likelihood would grow with what is rejected; and how many errors there are.
    pub(super) fn prepare(&mut self) -> Result<(), String> {
        let plan = Plan { study: self.study, requested: self.requested, cancel: self.cancel, end: None };
        if self.requested.kind.has_likelihood(self.study.plant.dt) {
            let designed = kinds::with_covariance(&plan).map_err(|none| none.hypothesis)?;
            let none = vec![0.0; self.study.plant.outputs.len()];
            for data in &mut self.data {
                let recorded = (data.recording(data.t.len(), &none)?, data.log.variances.as_ref());
                let replayed = run(self.study, (self.requested, &designed), recorded, self.settings)?;
                for (k, j) in replayed.consistency.iter().flat_map(|consistency| &consistency.rejected) {
                    if let Some(row) = replayed.row[*k] {
                        data.y[(row, *j)] = None;
                        self.rejected[usize::from(row >= data.fitted)] += 1;
                    }
                }
            }
        }
        if self.spec.criterion != TuneCriterion::Likelihood {
            self.count = Some(self.errors(&self.start(), false)?.iter().map(|one| one.count).sum());
        }
        Ok(())
    }

    /// The values of the study.
    pub(super) fn start(&self) -> Vec<f64> {
        self.spec.parameters.iter().map(|one| one.value).collect()
    }

    /// What changes in the study.
    pub(super) fn edits(&self, values: &[f64], is_written: bool) -> Result<Vec<Edit>, String> {
        let edits = self.editable.edits(&self.spec.parameters, values, is_written);
        edits.ok_or_else(|| "the study has no place for the values".to_owned())
    }

    /// Whether outputs are late.
    pub(super) fn has_delays(&self) -> bool {
        !self.study.plant.delays.is_empty()
            || self.spec.parameters.iter().any(|one| matches!(one.what, Tunable::Delay(_)))
    }

    /// The biases with these values.
    pub(super) fn biases(&self, values: &[f64]) -> Vec<f64> {
        let [bias, _] = self.of_sensors(values);
        bias
    }

    /// The biases, and the delays with these values.
    fn of_sensors(&self, values: &[f64]) -> [Vec<f64>; 2] {
        let (mut bias, mut delays) = (vec![0.0; self.study.plant.outputs.len()], delays(self.study));
        for (one, value) in self.spec.parameters.iter().zip(values) {
            match one.what {
                Tunable::Bias(j) => bias[j] = *value,
                Tunable::Delay(j) => delays[j] = *value,
                _ => {}
            }
        }
        [bias, delays]
    }

    /// The filter with these values on the logs with their measurements at their times, on what is fitted or on all
    /// rows.
    pub(super) fn replayed(&self, values: &[f64], is_whole: bool) -> Result<Vec<OnTime>, String> {
        let study = self.editable.study(&self.edits(values, false)?, true)?;
        let requested = study.observer(&self.spec.observer).ok_or("the study has lost its observer")?;
        let plan = Plan { study: &study, requested, cancel: self.cancel, end: None };
        let designed = kinds::with_covariance(&plan).map_err(|none| none.hypothesis)?;
        let [bias, delays] = self.of_sensors(values);
        let of = |data: &Data<'_>| {
            let rows = if is_whole { data.t.len() } else { data.fitted };
            let (recording, variances) = data.on_time(rows, (&bias, &delays))?;
            let end = data.t.get(data.fitted).copied().unwrap_or(f64::INFINITY);
            let first = recording.times().partition_point(|t| *t < end - SAME * data.log.recording.median_period());
            let recorded = (recording, variances.as_ref());
            Ok(OnTime { replayed: run(&study, (requested, &designed), recorded, self.settings)?, first })
        };
        self.data.iter().map(of).collect()
    }

    /// What the observer with these values predicts on the logs as they became known: of the rows that are fitted, or
    /// of those that are held out, which it runs through the others into.
    pub(super) fn predictions(&self, values: &[f64], is_held_out: bool) -> Result<Vec<Predictions>, String> {
        let mut study = self.editable.study(&self.edits(values, false)?, false)?;
        study.simulation.clone_from(&self.study.simulation);
        let requested = study.observer(&self.spec.observer).ok_or("the study has lost its observer")?;
        let designed = attempt(&study, requested, self.cancel, None).map_err(|none| none.hypothesis)?;
        let member = Member { requested, designed: &designed };
        let [bias, _] = self.of_sensors(values);
        let of = |data: &Data<'_>| {
            let (rows, first) = if is_held_out { (data.t.len(), data.fitted) } else { (data.fitted, 0) };
            let log = data.log(rows, &bias)?;
            Predictions::of((&study, &log), &member, first, None).map_err(|error| error.to_string())?
        };
        self.data.iter().map(of).collect()
    }

    /// The errors that are fitted, or those that are held out: of each output, or of each state that the logs know.
    pub(super) fn errors(&self, values: &[f64], is_held_out: bool) -> Result<Vec<Errors>, String> {
        let predictions = self.predictions(values, is_held_out)?;
        Ok(self.errors_of(&predictions, is_held_out))
    }

    /// Those of these predictions.
    pub(super) fn errors_of(&self, predictions: &[Predictions], is_held_out: bool) -> Vec<Errors> {
        let plant = &self.study.plant;
        let rows = |data: &Data<'_>| if is_held_out { data.fitted..data.t.len() } else { 0..data.fitted };
        let about = |all: Vec<f64>, difference: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
            let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
            all.into_iter().map(|x| difference(x, mean)).collect()
        };
        let of_output = |j: usize| {
            let nu: Vec<f64> = predictions.iter().flat_map(|of| of.innovations(j)).collect();
            let y = self.data.iter().flat_map(|data| rows(data).filter_map(|k| data.y[(k, j)])).collect();
            Errors::of(&nu, &about(y, &|y, mean| plant.innovation(j, y, mean)))
        };
        let of_state = |i: usize| {
            let errors: Vec<f64> = predictions.iter().flat_map(|of| of.errors(i)).collect();
            let x = self.data.iter().flat_map(|data| data.truth(i, rows(data))).collect();
            Errors::of(&errors, &about(x, &|x, mean| x - mean))
        };
        let all: Vec<Errors> = match self.spec.criterion {
            TuneCriterion::Errors => (0..plant.states.len()).map(of_state).collect(),
            _ => (0..plant.outputs.len()).map(of_output).collect(),
        };
        all.into_iter().filter(|one| one.count > 0).collect()
    }

    /// The rms of errors relative to the deviations: the geometric mean over the measurements of innovations, the root
    /// of the mean over the states of their squares.
    pub(super) fn relative(&self, errors: &[Errors]) -> f64 {
        if self.spec.criterion == TuneCriterion::Errors {
            let squares = errors.iter().map(|one| (one.rms / one.deviation).powi(2));
            return (squares.sum::<f64>() / errors.len().max(1) as f64).sqrt();
        }
        let count: usize = errors.iter().map(|one| one.count).sum();
        let logarithms = errors.iter().map(|one| one.count as f64 * (one.rms / one.deviation).ln());
        (logarithms.sum::<f64>() / count.max(1) as f64).exp()
    }

    /// The log-likelihood of the rows that are fitted.
    pub(super) fn log_likelihood(&self, values: &[f64]) -> Result<f64, String> {
        let normal = |count: usize, rms: f64| -0.5 * count as f64 * ((std::f64::consts::TAU * rms * rms).ln() + 1.0);
        let total: f64 = match self.spec.criterion {
            TuneCriterion::Likelihood => {
                self.replayed(values, false)?.iter().map(|of| sum(of, 0)).sum::<Result<f64, String>>()?
            }
            criterion => {
                let errors = self.errors(values, false)?;
                let count: usize = errors.iter().map(|one| one.count).sum();
                // Fewer errors would be a gain.
                if let Some(expected) = self.count.filter(|expected| *expected != count) {
                    return Err(format!("it has {count} errors, and {expected} with the values of the study"));
                }
                if criterion == TuneCriterion::Errors {
                    normal(count, self.relative(&errors))
                } else {
                    errors.iter().map(|one| normal(one.count, one.rms)).sum()
                }
            }
        };
        if total.is_finite() { Ok(total) } else { Err(format!("the log-likelihood is {total}")) }
    }

    /// The states whose errors are fitted.
    pub(super) fn reference(&self) -> Vec<String> {
        let is_known = |i: &usize| self.data.iter().any(|data| data.truth(*i, 0..data.fitted).next().is_some());
        let all = (0..self.study.plant.states.len()).filter(|_| self.spec.criterion == TuneCriterion::Errors);
        all.filter(is_known).map(|i| self.study.plant.states[i].clone()).collect()
    }

    /// How many errors or measurements rows of a log have.
    pub(super) fn count_of(&self, data: &Data<'_>, rows: std::ops::Range<usize>) -> usize {
        match self.spec.criterion {
            TuneCriterion::Errors => {
                (0..self.study.plant.states.len()).map(|i| data.truth(i, rows.clone()).count()).sum()
            }
            _ => data.measurements(rows),
        }
    }
}

fn run(
    study: &Study,
    (requested, designed): (&ObserverSpec, &Designed),
    (recording, variances): (Recording, Option<&Samples>),
    settings: Settings,
) -> Result<ReplayedObserver, String> {
    let replay = replay_of(&study.plant, recording, settings);
    let of_rows = with_variances(&designed.runnable, variances);
    let runnable = of_rows.as_ref().unwrap_or(&designed.runnable);
    let replayed = runnable.replay(replay, &requested.name, &requested.initial).run();
    let mut replayed = replayed.map_err(|error| error.to_string())?;
    replayed.observers.pop().ok_or_else(|| "the log was not replayed".to_owned())
}

/// The delay of each output.
fn delays(study: &Study) -> Vec<f64> {
    let mut delays = study.plant.delays.clone();
    delays.resize(study.plant.outputs.len(), 0.0);
    delays
}

/// The sum from this row on.
fn sum(of: &OnTime, from: usize) -> Result<f64, String> {
    let replayed = &of.replayed;
    let consistency = replayed.consistency.as_ref().ok_or("the observer is no filter with a covariance")?;
    // A measurement that is passed over would be a gain.
    if let Some(k) = consistency.passed_over.first() {
        return Err(format!("the covariance of the innovation is not positive definite at t = {}", replayed.t[*k]));
    }
    let is_in = |k: &usize| replayed.row[*k].is_some_and(|row| row >= from);
    Ok((0..replayed.t.len()).filter(is_in).filter_map(|k| consistency.log_likelihood[k]).sum())
}
