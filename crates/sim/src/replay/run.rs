//! The run of one observer over a recording.

use nalgebra::DMatrix;

use super::filter::AnyFilter;
use super::hold::{Between, Hold, Source, reach};
use super::replayed::{FilterConsistency, ReplayedObserver};
use super::smoother::Record;
use super::{BetweenRows, Entry, Keeps, Progress, Recording};
use crate::erased::{AnyObserver, AnyPlant};
use crate::error::{SimError, check_finite, check_positive};
use crate::integrate::{Settings, Stepper};

/// A row lies on a sample of an observer in discrete time if it is no further away than this share of the period.
const ON_A_SAMPLE: f64 = 0.01;

/// Most steps of an observer in discrete time, and of a prediction.
const MOST_STEPS: f64 = 2e7;

/// Most numbers that are kept for a smoother.
const MOST_NUMBERS: f64 = 1.5e8;

/// The observer, and what is recorded of it at the times so far.
pub(super) struct ReplayRun<'r> {
    plant: &'r dyn AnyPlant,
    recording: &'r Recording,
    settings: Settings,
    entry: &'r Entry<'r>,
    u: Vec<f64>,
    /// The outputs; the entries that were not measured are those that the observer predicts.
    y: Vec<f64>,
    measured: Vec<bool>,
    t: Vec<f64>,
    row: Vec<Option<usize>>,
    predicted: Vec<f64>,
    estimates: Vec<f64>,
    states: Vec<f64>,
    innovations: Vec<Option<f64>>,
    consistency: Option<FilterConsistency>,
    record: Option<Record>,
    interpolated: usize,
    steps: usize,
    keeps: Keeps,
    progress: Option<Progress<'r>>,
}

/// It is told how many rows are done of a log of at least so many, in so many parts.
const TOLD: usize = 20_000;
const PARTS: usize = 50;

impl<'r> ReplayRun<'r> {
    pub(super) fn new(
        plant: &'r dyn AnyPlant,
        recording: &'r Recording,
        settings: Settings,
        entry: &'r Entry<'r>,
    ) -> Self {
        let size = plant.dimensions();
        Self {
            plant,
            recording,
            settings,
            entry,
            u: vec![0.0; size.inputs],
            y: vec![0.0; size.outputs],
            measured: vec![false; size.outputs],
            t: Vec::new(),
            row: Vec::new(),
            predicted: Vec::new(),
            estimates: Vec::new(),
            states: Vec::new(),
            innovations: Vec::new(),
            consistency: None,
            record: entry.is_smoothed.then(Record::default),
            interpolated: 0,
            steps: 0,
            keeps: Keeps { predictions: true, covariances: true, states: false },
            progress: None,
        }
    }

    /// Sets what is kept, and what is told of the rows.
    pub(super) fn keep(&mut self, keeps: Keeps, progress: Option<Progress<'r>>) {
        (self.keeps, self.progress) = (keeps, progress);
    }

    /// Input and output of row k: what was measured of it, the rest as it was.
    fn read(&mut self, k: usize) {
        self.recording.inputs().on(k, self.recording.times()[k], &mut self.u);
        for (j, (y, measured)) in self.y.iter_mut().zip(&mut self.measured).enumerate() {
            let value = self.recording.outputs().value(k, j);
            *measured = value.is_some();
            *y = value.unwrap_or(*y);
        }
    }

    /// Puts h(xhat) in the place of what was not measured, and gives the innovation of what was. An observer of some
    /// states predicts no output: the last value stays.
    fn predict_outputs(&mut self, t: f64, row: Option<usize>, estimate: &[f64]) -> Result<(), SimError> {
        if !self.entry.whole {
            return Ok(());
        }
        let mut expected = vec![0.0; self.y.len()];
        self.plant.output(t, estimate, &self.u, &mut expected);
        if let Some(output) = expected.iter().position(|h| !h.is_finite()) {
            return Err(self.undefined(t, row, output, expected[output]));
        }
        for ((y, measured), h) in self.y.iter_mut().zip(&self.measured).zip(&expected) {
            self.innovations.push(measured.then_some(*y - h));
            *y = if *measured { *y } else { *h };
        }
        Ok(())
    }

    /// The innovations of a filter, which needs the outputs that were measured, and no other.
    fn innovate(&mut self, t: f64, row: Option<usize>, filter: &dyn AnyFilter, state: &[f64]) -> Result<(), SimError> {
        let innovation = filter.innovation(t, state, &self.u, &self.y);
        if let Some(output) = (0..innovation.len()).find(|&j| self.measured[j] && !innovation[j].is_finite()) {
            return Err(self.undefined(t, row, output, innovation[output]));
        }
        let of = |(measured, nu): (&bool, f64)| measured.then_some(nu);
        self.innovations.extend(self.measured.iter().zip(innovation).map(of));
        Ok(())
    }

    fn undefined(&self, time: f64, row: Option<usize>, output: usize, value: f64) -> SimError {
        let (observer, is_measured) = (self.entry.name.clone(), self.measured[output]);
        SimError::OutputNotFinite { observer, time, row, output, value, is_measured }
    }

    fn check_state(&self, time: f64, state: &[f64]) -> Result<(), SimError> {
        let Some(index) = state.iter().position(|entry| !entry.is_finite()) else { return Ok(()) };
        Err(SimError::ObserverNotFinite { observer: self.entry.name.clone(), time, index, value: state[index] })
    }

    /// The estimates at `t` before and after its measurements.
    fn note(
        &mut self,
        t: f64,
        row: Option<usize>,
        state: &[f64],
        (predicted, estimate): (&[f64], &[f64]),
    ) -> Result<(), SimError> {
        self.settings.check_time(t)?;
        self.check_state(t, estimate)?;
        self.t.push(t);
        self.row.push(row);
        if self.keeps.predictions {
            self.predicted.extend_from_slice(predicted);
        }
        self.estimates.extend_from_slice(estimate);
        if self.keeps.states {
            self.states.extend_from_slice(state);
        }
        let rows = self.recording.times().len();
        if let (Some(tell), Some(row), true) = (self.progress, row, rows >= TOLD)
            && (row + 1) * PARTS / rows > row * PARTS / rows
        {
            tell(row + 1, rows);
        }
        Ok(())
    }

    /// The state of an observer at the start, for the outputs of the first row.
    fn start(&mut self, observer: &dyn AnyObserver) -> Result<Vec<f64>, SimError> {
        self.read(0);
        let (start, initial) = (self.recording.times()[0], &self.entry.initial);
        if self.entry.whole && self.measured.contains(&false) {
            self.predict_outputs(start, Some(0), initial)?;
            self.innovations.clear();
        }
        let mut state = vec![0.0; observer.dimensions().state];
        observer.initial(start, initial, &self.u, &self.y, &mut state);
        check_finite(&format!("the initial state of observer {:?}", self.entry.name), &state)?;
        Ok(state)
    }

    /// The estimate at `t`; and where something was not measured, again with what is predicted of it.
    fn arrive(
        &mut self,
        observer: &dyn AnyObserver,
        t: f64,
        row: Option<usize>,
        state: &[f64],
    ) -> Result<(), SimError> {
        let mut estimate = vec![0.0; observer.dimensions().estimate];
        observer.estimate(t, state, &self.u, &self.y, &mut estimate);
        self.predict_outputs(t, row, &estimate)?;
        let predicted = estimate.clone();
        observer.correct(state, &self.u, &self.y, &self.measured, &mut estimate);
        self.note(t, row, state, (&predicted, &estimate))
    }

    /// An observer in continuous time, from row to row.
    pub(super) fn integrate(&mut self, observer: &dyn AnyObserver) -> Result<(), SimError> {
        let recording = self.recording;
        let times = recording.times();
        let most = self.settings.max_steps.saturating_add(16 * times.len());
        let mut stepper = Stepper::new(Settings { max_steps: most, ..self.settings });
        let mut holds: Vec<Hold> = (0..self.y.len()).map(|output| Hold::new(recording, output)).collect();
        let mut state = self.start(observer)?;
        self.arrive(observer, times[0], Some(0), &state)?;
        let own = state.len();
        let is_moving = self.entry.whole && recording.outputs_between() == BetweenRows::Predicted;
        // The predicted outputs, behind the state of the observer.
        state.extend(is_moving.then_some(&self.y).into_iter().flatten());
        let mut jumps = Jumps::new(times[0], observer.jump_period());
        for (k, pair) in times.windows(2).enumerate() {
            for hold in &mut holds {
                hold.arrive(recording, k);
            }
            let held: Vec<f64> = holds.iter().map(|hold| hold.until(pair[0], pair[1])).collect();
            let mut ends: Vec<f64> = held.iter().copied().filter(|t| *t > pair[0] && *t < pair[1]).collect();
            ends.push(pair[1]);
            ends.extend(jumps.within(pair[0], pair[1]));
            ends.sort_by(f64::total_cmp);
            ends.dedup();
            let mut from = pair[0];
            for to in ends {
                let sources = holds.iter().zip(&held).map(|(hold, until)| hold.source(to, *until)).collect();
                let plant = self.entry.whole.then_some(self.plant);
                let last = &self.y;
                let between = Between { plant, observer, recording, row: k, sources, last, own, is_moving };
                let right_hand_side = |t: f64, state: &[f64], slope: &mut [f64]| between.derivative(t, state, slope);
                stepper.advance(&right_hand_side, from, to, &mut state, &mut |_| Ok(()))?;
                if to < pair[1] && jumps.happens(to) {
                    let (u, y) = between.known(to, &state);
                    observer.jump(to, &mut state[..own], &u, &y);
                }
                from = to;
            }
            self.read(k + 1);
            self.arrive(observer, pair[1], Some(k + 1), &state[..own])?;
            if jumps.happens(pair[1]) {
                observer.jump(pair[1], &mut state[..own], &self.u, &self.y);
            }
            for ((moving, y), _) in state[own..].iter_mut().zip(&self.y).zip(&self.measured).filter(|(_, is)| **is) {
                *moving = *y;
            }
        }
        self.steps = stepper.steps();
        Ok(())
    }

    /// An observer that samples correct: at the rows that measured something, over whatever time has passed.
    pub(super) fn correct_at_rows(&mut self, observer: &dyn AnyObserver) -> Result<(), SimError> {
        let recording = self.recording;
        let times = recording.times();
        let most = self.settings.max_steps.saturating_add(16 * times.len());
        let mut stepper = Stepper::new(Settings { max_steps: most, ..self.settings });
        let mut state = self.start(observer)?;
        let (inputs, mut estimate) = (self.u.len(), vec![0.0; observer.dimensions().estimate]);
        let mut last = times[0];
        for (k, &t) in times.iter().enumerate() {
            if let Some(before) = k.checked_sub(1) {
                let y = &self.y;
                let predicted = |t: f64, state: &[f64], slope: &mut [f64]| {
                    let mut u = vec![0.0; inputs];
                    recording.inputs().on(before, t, &mut u);
                    observer.derivative(t, state, &u, y, slope);
                };
                stepper.advance(&predicted, times[before], t, &mut state, &mut |_| Ok(()))?;
            }
            self.read(k);
            observer.estimate(t, &state, &self.u, &self.y, &mut estimate);
            self.predict_outputs(t, Some(k), &estimate)?;
            let predicted = estimate.clone();
            if self.measured.contains(&true) {
                let seen = |(y, is): (&f64, &bool)| if *is { *y } else { f64::NAN };
                let y: Vec<f64> = self.y.iter().zip(&self.measured).map(seen).collect();
                observer.correct_at(&mut state, &self.u, &y, t - last);
                last = t;
            }
            observer.estimate(t, &state, &self.u, &self.y, &mut estimate);
            self.note(t, Some(k), &state, (&predicted, &estimate))?;
        }
        self.steps = stepper.steps();
        Ok(())
    }

    /// A sampled-data observer at its own period: rows on its samples correct it, and at other samples it predicts.
    pub(super) fn sample(&mut self, observer: &dyn AnyObserver, period: f64) -> Result<(), SimError> {
        let mut grid = Grid::new(&self.entry.name, self.recording, period)?;
        let reaches: Vec<f64> = (0..self.y.len()).map(|output| reach(self.recording, output)).collect();
        let mut state = self.start(observer)?;
        while let Some((t, row)) = grid.next() {
            match row {
                Some(row) => self.read(row),
                None => self.between(grid.last, t, &reaches),
            }
            self.arrive(observer, t, row, &state)?;
            observer.step(t, &mut state, &self.u, &self.y, &self.measured);
            self.check_state(t, &state)?;
        }
        Ok(())
    }

    /// A sample between rows, of which k is the last: nothing is measured, unless lines are asked for.
    fn between(&mut self, k: usize, t: f64, reaches: &[f64]) {
        self.recording.inputs().on(k, t, &mut self.u);
        self.measured.fill(false);
        if self.recording.outputs_between() == BetweenRows::Linear {
            for (j, (y, measured)) in self.y.iter_mut().zip(&mut self.measured).enumerate() {
                if let Some(value) = on_line(self.recording, k, j, t, reaches[j]) {
                    (*y, *measured) = (value, true);
                }
            }
            self.interpolated += usize::from(self.measured.contains(&true));
        }
    }

    /// A Kalman filter: updated at rows, predicted in between.
    pub(super) fn filter(&mut self, filter: &dyn AnyFilter) -> Result<(), SimError> {
        let own = filter.dimensions();
        let times = self.recording.times();
        let consistency = FilterConsistency::new((0..own.estimate).map(|i| filter.unit_vector_of(i)).collect());
        self.consistency = Some(consistency);
        let mut state = vec![0.0; own.state];
        filter.initial(times[0], &self.entry.initial, &self.u, &self.y, &mut state);
        if let Some(period) = filter.grid() {
            let mut grid = Grid::new(&self.entry.name, self.recording, period)?;
            self.check_record(grid.samples as f64, own.estimate)?;
            while let Some((t, row)) = grid.next() {
                if let Some(row) = row {
                    self.read(row);
                } else {
                    self.recording.inputs().on(grid.last, t, &mut self.u);
                    self.measured.fill(false);
                }
                self.correct(filter, t, row, &mut state)?;
                if !grid.is_done() {
                    self.predict(filter, t, &mut state, period);
                }
            }
            return Ok(());
        }
        let pieces: f64 = times.windows(2).map(|pair| filter.pieces(pair[1] - pair[0])).sum();
        if pieces > MOST_STEPS {
            return Err(self.too_many(pieces, MOST_STEPS));
        }
        self.check_record(pieces, own.estimate)?;
        for (k, t) in times.iter().enumerate() {
            self.read(k);
            self.correct(filter, *t, Some(k), &mut state)?;
            if let Some(next) = times.get(k + 1) {
                self.predict(filter, *t, &mut state, next - t);
            }
        }
        Ok(())
    }

    /// Whether what a smoother needs fits into memory.
    fn check_record(&self, steps: f64, n: usize) -> Result<(), SimError> {
        let limit = (MOST_NUMBERS / (3 * n * n + 2 * n) as f64).floor();
        if self.record.is_some() && steps > limit { Err(self.too_many(steps, limit)) } else { Ok(()) }
    }

    fn too_many(&self, steps: f64, limit: f64) -> SimError {
        let times = self.recording.times();
        let period = (times[times.len() - 1] - times[0]) / steps;
        SimError::TooManySamples { name: self.entry.name.clone(), period, steps, limit }
    }

    fn predict(&mut self, filter: &dyn AnyFilter, t: f64, state: &mut [f64], duration: f64) {
        filter.predict(t, state, &self.u, duration, self.record.as_mut());
    }

    /// The update at `t` by what was measured.
    fn correct(
        &mut self,
        filter: &dyn AnyFilter,
        t: f64,
        row: Option<usize>,
        state: &mut [f64],
    ) -> Result<(), SimError> {
        self.check_state(t, state)?;
        let (predicted, before) = if self.keeps.predictions {
            (filter.estimate(state), filter.covariance(state))
        } else {
            (Vec::new(), Vec::new())
        };
        self.innovate(t, row, filter, state)?;
        let rejected: Vec<usize> =
            (0..self.y.len()).filter(|&j| self.measured[j] && filter.rejects(t, state, &self.u, &self.y, j)).collect();
        for &j in &rejected {
            self.measured[j] = false;
        }
        let update = if self.measured.contains(&true) {
            filter.update(t, state, &self.u, &self.y, &self.measured)
        } else {
            None
        };
        let (estimate, covariance) = (filter.estimate(state), filter.covariance(state));
        self.note(t, row, state, (&predicted, &estimate))?;
        if let Some(consistency) = &mut self.consistency {
            consistency.rejected.extend(rejected.into_iter().map(|output| (consistency.nis.len(), output)));
            if update.is_none() && self.measured.contains(&true) {
                consistency.passed_over.push(consistency.nis.len());
            }
            consistency.nis.push(update.map(|update| update.square));
            consistency.log_likelihood.push(update.and_then(|update| update.log_likelihood()));
            if self.keeps.predictions {
                consistency.predicted.extend_from_slice(&before);
            }
            if self.keeps.covariances {
                consistency.covariances.extend_from_slice(&covariance);
            } else {
                let n = estimate.len();
                consistency.deviations.extend((0..n).map(|i| covariance[i * n + i].max(0.0).sqrt()));
            }
        }
        if let Some(record) = &mut self.record {
            record.places.push(record.steps());
            record.last = (estimate, covariance);
        }
        Ok(())
    }

    pub(super) fn finish(self, estimate: usize) -> ReplayedObserver {
        let (rows, outputs) = (self.t.len(), self.y.len());
        // One after the other: what has been copied is given back.
        let by_rows = |numbers: Vec<f64>, of: usize| DMatrix::from_row_slice(numbers.len() / of.max(1), of, &numbers);
        let (estimate, predicted) = (by_rows(self.estimates, estimate), by_rows(self.predicted, estimate));
        let entries = self.states.len() / rows.max(1);
        let states = self.keeps.states.then(|| by_rows(self.states, entries));
        let innovations = self.innovations;
        ReplayedObserver {
            name: self.entry.name.clone(),
            estimate,
            predicted,
            innovation: self.entry.whole.then(|| DMatrix::from_row_slice(rows, outputs, &innovations)),
            consistency: self.consistency,
            smoothed: self.record.map(Record::smooth),
            states,
            interpolated: self.interpolated,
            steps: self.steps,
            row: self.row,
            turns: Vec::new(),
            t: self.t,
        }
    }
}

/// Output j at `t` on the line through its measurements before and after, if they are successive ones.
fn on_line(recording: &Recording, k: usize, j: usize, t: f64, reach: f64) -> Option<f64> {
    let (times, outputs) = (recording.times(), recording.outputs());
    let point = |k: usize| Some((times[k], outputs.value(k, j)?));
    let from = (0..=k).rev().find_map(point)?;
    let to = (k + 1..times.len()).find_map(point)?;
    if to.0 - from.0 <= reach { Source::Line(from, to).at(t) } else { None }
}

/// When the state of an observer jumps.
struct Jumps {
    start: f64,
    period: Option<f64>,
    count: u64,
}

impl Jumps {
    fn new(start: f64, period: Option<f64>) -> Self {
        Self { start, period, count: 0 }
    }

    fn instant(&self, period: f64, count: u64) -> f64 {
        self.start + count as f64 * period
    }

    /// The instants between two times.
    fn within(&self, from: f64, to: f64) -> Vec<f64> {
        let Some(period) = self.period else { return Vec::new() };
        let all = (self.count + 1..).map(|count| self.instant(period, count));
        all.skip_while(|t| *t <= from).take_while(|t| *t < to).collect()
    }

    /// Whether an instant has come since the last one.
    fn happens(&mut self, t: f64) -> bool {
        let Some(period) = self.period else { return false };
        let due = self.instant(period, self.count + 1) <= t;
        while self.instant(period, self.count + 1) <= t {
            self.count += 1;
        }
        due
    }
}

/// The samples of an observer in discrete time, and the rows that lie on them.
struct Grid<'r> {
    times: &'r [f64],
    period: f64,
    samples: u64,
    next: u64,
    /// The first row that is still to come.
    ahead: usize,
    /// The last row that has passed.
    last: usize,
}

impl<'r> Grid<'r> {
    fn new(name: &str, recording: &'r Recording, period: f64) -> Result<Self, SimError> {
        check_positive("the period of a sampled-data observer", period)?;
        let times = recording.times();
        let steps = ((times[times.len() - 1] - times[0]) / period + ON_A_SAMPLE).floor() + 1.0;
        if steps > MOST_STEPS {
            return Err(SimError::TooManySamples { name: name.to_owned(), period, steps, limit: MOST_STEPS });
        }
        let grid = Self { times, period, samples: steps as u64, next: 0, ahead: 0, last: 0 };
        let off = |t: &f64| {
            let phase = (t - times[0]) / period;
            phase.round() < 1.0 || (phase - phase.round()).abs() > ON_A_SAMPLE
        };
        if times[1..].iter().all(off) {
            let (rows, median) = (times.len(), recording.median_period());
            return Err(SimError::PeriodDoesNotFit { name: name.to_owned(), period, rows, median });
        }
        Ok(grid)
    }

    /// Whether the last sample has passed.
    fn is_done(&self) -> bool {
        self.next == self.samples
    }

    /// The next sample, with the row on it.
    fn next(&mut self) -> Option<(f64, Option<usize>)> {
        if self.next == self.samples {
            return None;
        }
        let t = self.times[0] + self.next as f64 * self.period;
        self.next += 1;
        let near = ON_A_SAMPLE * self.period;
        let mut row: Option<usize> = None;
        while let Some(time) = self.times.get(self.ahead).filter(|time| **time <= t + near) {
            let nearest = row.is_none_or(|row| (self.times[row] - t).abs() > (time - t).abs());
            if *time >= t - near && nearest {
                row = Some(self.ahead);
            }
            self.last = self.ahead;
            self.ahead += 1;
        }
        Some((t, row))
    }
}
