//! A run: the stacked equation integrated from one jump to the next.
//!
//! Integration stops and goes on wherever something jumps: a new value of the noise, a sample, a held input, a
//! breakpoint of the input. Sampled-data observers are stepped at their samples; between samples their estimate is
//! held.

use std::cell::RefCell;
use std::rc::Rc;

use crate::dense::{Dense, NODE};
use crate::disturbance::History;
use crate::error::{SimError, check_finite};
use crate::exponential::Exponential;
use crate::integrate::Stepper;
use crate::model::{HeldValues, Instant, Model};
use crate::sample_times::{SampleClock, SampleTime};
use crate::scenario::Scenario;
use crate::sensor::Reading;
use crate::step::Accepted;
use crate::trajectory::Trajectory;
use crate::updates::Updates;

impl Scenario<'_> {
    /// Runs.
    ///
    /// # Errors
    /// What does not fit: [`SimError::Length`], [`SimError::NotFinite`], [`SimError::NotPositive`],
    /// [`SimError::TimeSpan`], [`SimError::TimesUnsorted`], [`SimError::DuplicateName`], [`SimError::UnknownName`],
    /// [`SimError::Index`], [`SimError::SensorTwice`], [`SimError::ChangeTime`], [`SimError::AlgebraicLoop`]. What
    /// happens on the way: the errors with [`SimError::ends_run`].
    pub fn run(mut self) -> Result<Trajectory, SimError> {
        let end = self.resolve_times()?;
        let model = Model::new(self)?;
        Runner::new(&model)?.run(end)
    }
}

/// Something that happens every period from the start on.
struct Periodic {
    start: f64,
    period: f64,
    /// How often it has happened since the start.
    count: u64,
}

impl Periodic {
    fn new(start: f64, period: f64) -> Self {
        Self { start, period, count: 0 }
    }

    /// When it happens next.
    fn next(&self) -> f64 {
        self.start + (self.count + 1) as f64 * self.period
    }

    /// Whether it happens at `t`, up to rounding in multiples of other periods; if so it has happened.
    fn happens(&mut self, t: f64) -> bool {
        let due = self.next() <= t + 1e-9 * self.period;
        self.count += u64::from(due);
        due
    }
}

/// What sums of periods and delays differ by where they are the same instant.
fn rounding(t: f64) -> f64 {
    8.0 * f64::EPSILON * t.abs()
}

/// What is known of an output from its value k on: it is read now, or does not arrive.
fn read(model: &Model<'_>, held: &mut HeldValues, output: usize, k: u64) {
    let arrives = model.sampling.arrives(k, output);
    held.readings[output] = if arrives { Reading::Now } else { Reading::Nothing };
    held.outliers[output] = model.sampling.outlier(k, output);
    if let Some(Some(sensor)) = model.sampling.sensors.get(output) {
        held.noise[output] = sensor.noise(model.member, k);
    }
}

/// A run on its way.
pub(crate) struct Runner<'m, 'a> {
    model: &'m Model<'a>,
    held: HeldValues,
    /// What the sampled-data observers will hold from their next sample on.
    pending: Vec<Vec<f64>>,
    stacked: Vec<f64>,
    now: RefCell<Instant>,
    noise_clock: Option<Periodic>,
    process_clock: Option<Periodic>,
    channel_clock: Option<Periodic>,
    /// Those of the outputs with sensors of their own.
    sensor_clocks: Vec<Option<Periodic>>,
    hold_clock: Option<Periodic>,
    plant_clock: Option<Periodic>,
    /// The next state of a plant in discrete time.
    next: Vec<f64>,
    sample_clocks: Vec<Option<Periodic>>,
    /// Those of observers in continuous time whose state jumps.
    jump_clocks: Vec<Option<Periodic>>,
    /// Those of observers that samples at varying periods correct, with the samples so far.
    varying_clocks: Vec<Option<SampleClock>>,
    samples: Vec<Vec<SampleTime>>,
    /// What each filter knows at its samples.
    updates: Vec<Updates>,
    /// How many changes of the plant there have been.
    changed: usize,
    /// Which outputs were measured at the last jump, and which observers were due.
    measured: Vec<bool>,
    due: Vec<bool>,
}

/// A law that reads an output with direct feedthrough is a loop even where the input at the start is zero: the output
/// is taken under another input, and the law must not see it.
fn runs_through_the_output(
    model: &Model<'_>,
    stacked: &[f64],
    held: &HeldValues,
    now: &mut Instant,
) -> Result<(), SimError> {
    let (t, x) = (model.start, &stacked[..model.size.states]);
    let (u, y) = (now.u.clone(), now.y.clone());
    let size = u.iter().fold(1.0f64, |size, entry| size.max(entry.abs()));
    now.u.iter_mut().for_each(|entry| *entry += size);
    model.see(t, x, held, now);
    let is_free = now.y == y;
    if !is_free {
        model.estimates(t, stacked, held, now);
        model.law(t, stacked, now);
    }
    let change = u.iter().zip(&now.u).fold(0.0f64, |change, (a, b)| change.max((a - b).abs()));
    now.u = u;
    model.see(t, x, held, now);
    model.estimates(t, stacked, held, now);
    if !is_free && change > 1e-9 * size { Err(SimError::AlgebraicLoop { change }) } else { Ok(()) }
}

impl<'m, 'a> Runner<'m, 'a> {
    /// Starts: noise, input and observers at the initial time.
    pub(crate) fn new(model: &'m Model<'a>) -> Result<Self, SimError> {
        let t = model.start;
        let process = model.disturbances.process_noise.as_ref();
        let channel = model.disturbances.channel.as_ref();
        let mut now = model.instant();
        let mut held = HeldValues {
            plant: None,
            noise: model.measurement_noise(0).map_or_else(|| vec![0.0; model.size.outputs], Iterator::collect),
            input_is_held: model.input.is_constant(),
            sampled: vec![Vec::new(); model.observers.len()],
            disturbance: model.process_noise(0).map(Iterator::collect).unwrap_or_default(),
            readings: Vec::new(),
            known: vec![Vec::new(); model.observers.len()],
            outliers: Vec::new(),
            history: History::default(),
        };
        if !model.sampling.is_continuous() {
            (held.readings, held.outliers) =
                (vec![Reading::Nothing; model.size.outputs], vec![0.0; model.size.outputs]);
            for (output, sensor) in model.sampling.sensors.iter().enumerate() {
                if sensor.as_ref().is_none_or(|sensor| sensor.delay() == 0.0) {
                    read(model, &mut held, output, 0);
                }
            }
        }
        model.see(t, &model.x0, &held, &mut now);
        check_finite("the output at the start", &now.y)?;
        // What an observer of some states cannot predict, it knows at the start.
        held.known.fill(now.y.clone());
        // The input at the start follows from the estimates that are wished for the start.
        for (k, fitted) in model.observers.iter().enumerate() {
            now.estimates[k].copy_from_slice(&fitted.initial);
            fitted.errors(&model.x0, &fitted.initial, &mut now.errors[k]);
        }
        model.law(t, &model.x0, &mut now);
        check_finite("the input at the start", &now.u)?;
        model.see(t, &model.x0, &held, &mut now);
        let mut stacked = vec![0.0; model.stacked_length()];
        stacked[..model.size.states].copy_from_slice(&model.x0);
        for (k, fitted) in model.observers.iter().enumerate() {
            let mut state = vec![0.0; fitted.length];
            let mut seen = now.seen.clone();
            if held.readings.contains(&Reading::Nothing) {
                let mut expected = now.y.clone();
                if fitted.whole {
                    model.observer_plant.output(t, &fitted.initial, &now.u, &mut expected);
                }
                for ((seen, reading), expected) in seen.iter_mut().zip(&held.readings).zip(expected) {
                    *seen = if *reading == Reading::Nothing { expected } else { *seen };
                }
                held.known[k].clone_from(&seen);
            }
            fitted.observer.initial(t, &fitted.initial, &now.u, &seen, &mut state);
            check_finite(&format!("the initial state of observer {:?}", model.names[k]), &state)?;
            match fitted.period {
                Some(_) => held.sampled[k] = state,
                None => stacked[fitted.offset..fitted.offset + fitted.length].copy_from_slice(&state),
            }
        }
        if model.input.reads_estimates() {
            model.steer(t, &stacked, &held, &mut now);
            let before = now.u.clone();
            model.see(t, &model.x0, &held, &mut now);
            model.estimates(t, &stacked, &held, &mut now);
            model.law(t, &stacked, &mut now);
            let change = before.iter().zip(&now.u).fold(0.0f64, |change, (a, b)| change.max((a - b).abs()));
            let size = before.iter().fold(1.0f64, |size, entry| size.max(entry.abs()));
            if change > 1e-9 * size {
                return Err(SimError::AlgebraicLoop { change });
            }
            runs_through_the_output(model, &stacked, &held, &mut now)?;
        }
        // Before the start input and output were what they are at the start.
        held.history.first = [&vec![0.0; model.size.states], &now.u, &now.y].map(Vec::as_slice).concat();
        let clock = |period: f64| Periodic::new(t, period);
        let mut runner = Self {
            model,
            pending: held.sampled.clone(),
            held,
            stacked,
            now: RefCell::new(now),
            noise_clock: model.noise.as_ref().map(|noise| clock(noise.period())),
            process_clock: process.map(|noise| clock(noise.period())),
            channel_clock: channel.map(|channel| clock(channel.period)),
            sensor_clocks: model
                .sampling
                .sensors
                .iter()
                .map(|sensor| {
                    let sensor = sensor.as_ref()?;
                    // The first measurement after the start is at the offset, if there is one.
                    let first = if sensor.delay() > 0.0 { sensor.delay() - sensor.period() } else { 0.0 };
                    Some(Periodic::new(t + first, sensor.period()))
                })
                .collect(),
            hold_clock: model.hold.map(clock),
            plant_clock: model.step.map(clock),
            next: model.x0.clone(),
            sample_clocks: model.observers.iter().map(|fitted| fitted.period.map(clock)).collect(),
            jump_clocks: model.observers.iter().map(|fitted| fitted.observer.jump_period().map(clock)).collect(),
            varying_clocks: model
                .observers
                .iter()
                .map(|fitted| Some(SampleClock::new(fitted.observer.sample_times()?, model.member, t)))
                .collect(),
            samples: vec![Vec::new(); model.observers.len()],
            updates: vec![Updates::default(); model.observers.len()],
            changed: 0,
            measured: Vec::new(),
            due: Vec::new(),
        };
        let all_observers = vec![true; model.observers.len()];
        runner.jump(t, model.hold.is_some(), model.step.is_some(), &all_observers)?;
        Ok(runner)
    }

    /// New state of a plant in discrete time, new held input, new samples.
    fn jump(&mut self, t: f64, hold: bool, plant: bool, sample: &[bool]) -> Result<(), SimError> {
        let model = self.model;
        if plant {
            self.stacked[..self.next.len()].copy_from_slice(&self.next);
        }
        for (k, _) in sample.iter().enumerate().filter(|(_, due)| **due) {
            self.held.sampled[k].clone_from(&self.pending[k]);
        }
        let now = self.now.get_mut();
        if hold {
            self.held.input_is_held = model.input.is_constant();
            model.evaluate(t, &self.stacked, &self.held, now);
            self.held.input_is_held = true;
        }
        let sampled = !self.held.readings.is_empty();
        // Under the input that has just been found, nothing else is found.
        if !hold && (plant || sampled || sample.contains(&true)) {
            model.evaluate(t, &self.stacked, &self.held, now);
        }
        self.freeze();
        let measured = std::mem::take(&mut self.measured);
        let now = self.now.get_mut();
        if plant {
            let x = &self.stacked[..model.size.states];
            model.plant(&self.held).derivative(t, x, model.applied(now), &mut self.next);
            for (next, disturbance) in self.next.iter_mut().zip(&self.held.disturbance) {
                *next += disturbance;
            }
            if !self.next.iter().all(|entry| entry.is_finite()) {
                check_finite(&format!("the next state of the plant after t = {t}"), &self.next)?;
            }
        }
        for (k, fitted) in model.observers.iter().enumerate() {
            if sample[k] && fitted.period.is_some() {
                let (state, held) = (&self.held.sampled[k], &self.held);
                let predicted = measured
                    .contains(&false)
                    .then(|| model.outputs_of(k, (t, state), held, now, &[], |j| !measured[j]));
                let y = predicted.as_deref().unwrap_or(&now.seen);
                let (observer, pending) = (fitted.observer.as_ref(), &mut self.pending[k]);
                let is_updated = observer.update(t, pending, &now.u, y, &measured);
                if is_updated || observer.is_filter() {
                    self.updates[k].note(t, observer, (state, pending), &now.u, (y, &measured));
                }
                if !(is_updated && observer.predict(t, pending, &now.u)) {
                    pending.copy_from_slice(state);
                    observer.step(t, pending, &now.u, y, &measured);
                }
                if let Some(index) = self.pending[k].iter().position(|entry| !entry.is_finite()) {
                    let (observer, value) = (model.names[k].clone(), self.pending[k][index]);
                    return Err(SimError::ObserverNotFinite { observer, time: t, index, value });
                }
            }
        }
        self.measured = measured;
        Ok(())
    }

    /// Keeps what was measured now by sensors with periods of their own, and which outputs were measured.
    fn freeze(&mut self) {
        let (now, HeldValues { readings, known, .. }) = (self.now.get_mut(), &mut self.held);
        self.measured.clear();
        self.measured.extend(readings.iter().map(|reading| *reading == Reading::Now));
        for (j, reading) in readings.iter_mut().enumerate().filter(|(_, reading)| **reading == Reading::Now) {
            for known in &mut *known {
                known[j] = now.seen[j];
            }
            for slot in self.model.observers.iter().filter(|slot| slot.moving > 0) {
                self.stacked[slot.moving()][j] = now.seen[j];
            }
            if self.sensor_clocks[j].is_some() {
                *reading = Reading::Held(now.seen[j]);
            }
        }
    }

    /// The changes of the plant that are due at `t`.
    fn change(&mut self, t: f64) {
        while let Some(change) = self.model.changes.get(self.changed).filter(|change| change.time <= t + rounding(t)) {
            if change.plant.is_some() {
                self.held.plant = Some(self.changed);
            }
            // A plant in discrete time has the state that it moves on to.
            let x = if self.model.step.is_some() { &mut self.next } else { &mut self.stacked };
            for (x, jump) in x.iter_mut().zip(change.jump.iter().flatten()) {
                *x += jump;
            }
            self.changed += 1;
        }
    }

    /// Everything that happens at `t`.
    fn tick(&mut self, t: f64) -> Result<(), SimError> {
        let model = self.model;
        let mut measures = false;
        if let Some(clock) = &mut self.channel_clock
            && clock.happens(t)
        {
            model.evaluate(t, &self.stacked, &self.held, self.now.get_mut());
            self.freeze();
            let count = self.channel_clock.as_ref().map_or(0, |clock| clock.count);
            for j in (0..self.sensor_clocks.len()).filter(|&j| self.sensor_clocks[j].is_none()) {
                read(model, &mut self.held, j, count);
            }
        }
        for (j, sensor) in model.sampling.sensors.iter().enumerate() {
            if let (Some(sensor), Some(clock)) = (sensor, &mut self.sensor_clocks[j])
                && clock.happens(t)
            {
                let k = clock.count - u64::from(sensor.delay() > 0.0);
                read(model, &mut self.held, j, k);
                measures = true;
            }
        }
        self.change(t);
        self.held.history.within.set(f64::INFINITY);
        if let Some(clock) = &mut self.process_clock
            && clock.happens(t)
            && let Some(values) = model.process_noise(clock.count)
        {
            self.held.disturbance.clear();
            self.held.disturbance.extend(values);
        }
        if let Some(clock) = &mut self.noise_clock
            && clock.happens(t)
            && let Some(values) = model.measurement_noise(clock.count)
        {
            for ((j, noise), sensor) in values.enumerate().zip(&self.sensor_clocks) {
                if sensor.is_none() {
                    self.held.noise[j] = noise;
                }
            }
        }
        let hold = self.hold_clock.as_mut().is_some_and(|clock| clock.happens(t));
        let mut sample = std::mem::take(&mut self.due);
        sample.clear();
        sample.extend(self.sample_clocks.iter_mut().map(|clock| clock.as_mut().is_some_and(|clock| clock.happens(t))));
        let plant = self.plant_clock.as_mut().is_some_and(|clock| clock.happens(t));
        if hold || plant || measures || sample.contains(&true) {
            self.jump(t, hold, plant, &sample)?;
        }
        self.due = sample;
        self.jump_observers(t)?;
        self.correct_observers(t)
    }

    /// The samples at varying periods that are due at `t`.
    fn correct_observers(&mut self, t: f64) -> Result<(), SimError> {
        let model = self.model;
        for (k, fitted) in model.observers.iter().enumerate() {
            let Some(clock) = self.varying_clocks[k].as_mut().filter(|clock| clock.next <= t) else { continue };
            let (is_sent, elapsed) = (clock.arrives(), t - clock.last);
            let now = self.now.get_mut();
            model.evaluate(t, &self.stacked, &self.held, now);
            let is_absent = |j: usize| self.held.readings.get(j) == Some(&Reading::Nothing);
            let absent = (0..model.size.outputs).filter(|&j| is_absent(j)).count();
            let arrives = is_sent && (model.size.outputs == 0 || absent < model.size.outputs);
            self.samples[k].push(SampleTime { time: t, arrives, elapsed, absent });
            if !arrives {
                continue;
            }
            clock.last = t;
            let state = &mut self.stacked[fitted.offset..fitted.offset + fitted.length];
            let mut y = model.outputs_of(k, (t, state), &self.held, now, &[], |_| false);
            for (_, y) in y.iter_mut().enumerate().filter(|(j, _)| is_absent(*j)) {
                *y = f64::NAN;
            }
            fitted.observer.correct_at(state, &now.u, &y, elapsed);
            if let Some(index) = state.iter().position(|entry| !entry.is_finite()) {
                let (observer, value) = (model.names[k].clone(), state[index]);
                return Err(SimError::ObserverNotFinite { observer, time: t, index, value });
            }
        }
        Ok(())
    }

    /// The jumps of observers in continuous time, with what they measure at `t`.
    fn jump_observers(&mut self, t: f64) -> Result<(), SimError> {
        let model = self.model;
        for (k, fitted) in model.observers.iter().enumerate() {
            if !self.jump_clocks[k].as_mut().is_some_and(|clock| clock.happens(t)) {
                continue;
            }
            let now = self.now.get_mut();
            model.evaluate(t, &self.stacked, &self.held, now);
            let (from, to) = (fitted.offset, fitted.offset + fitted.length);
            let moving = &self.stacked[fitted.moving()];
            let y = model.outputs_of(k, (t, &self.stacked[from..to]), &self.held, now, moving, |j| {
                self.held.readings.get(j) == Some(&Reading::Nothing)
            });
            let u = now.u.clone();
            fitted.observer.jump(t, &mut self.stacked[from..to], &u, &y);
            check_finite(
                &format!("the state of observer {:?} after t = {t}", model.names[k]),
                &self.stacked[from..to],
            )?;
        }
        Ok(())
    }

    /// When something jumps next after `t`, `end` at the latest.
    fn next_jump(&self, t: f64, end: f64) -> f64 {
        let own = [&self.noise_clock, &self.process_clock, &self.channel_clock, &self.hold_clock, &self.plant_clock];
        let observers = self.sample_clocks.iter().chain(&self.jump_clocks);
        let clocks = own.into_iter().chain(observers).chain(&self.sensor_clocks).flatten();
        // They are sorted, and a table of samples has many.
        let (breakpoints, now) = (&self.model.breakpoints, t + rounding(t));
        let breakpoint = breakpoints.get(breakpoints.partition_point(|&breakpoint| breakpoint <= now)).copied();
        let samples = self.varying_clocks.iter().flatten().map(|clock| clock.next);
        clocks.map(Periodic::next).chain(breakpoint).chain(samples).fold(end, f64::min)
    }

    /// The stacked equation of a model that is affine.
    fn exponential(&self) -> Option<Exponential> {
        let (model, mut held, mut now) = (self.model, self.held.clone(), self.now.borrow().clone());
        held.noise.fill(0.0);
        held.disturbance.fill(0.0);
        now.u.fill(0.0);
        Exponential::new(self.stacked.len(), |s, slope| {
            model.derivative(model.start, s, &held, &mut now, slope);
        })
    }

    pub(crate) fn run(mut self, end: f64) -> Result<Trajectory, SimError> {
        let model = self.model;
        let layout = model.layout();
        let dense = Rc::clone(&self.held.history.dense);
        dense.replace(Dense::of(&layout.constant));
        let mut samples = Vec::with_capacity(model.times.len() * layout.width);
        let mut waiting = model.times.iter().copied().peekable();
        let mut stepper = Stepper::new(model.settings);
        let mut at = vec![0.0; self.stacked.len()];
        let (mut rows, mut constant) = (Vec::new(), Vec::new());
        let varying = layout.constant.iter().filter(|constant| !**constant).count();
        let mut exponential = if model.is_affine() { self.exponential() } else { None };
        let mut t = model.start;
        while t < end {
            let next = self.next_jump(t, end);
            if next <= t {
                return Err(SimError::StepSize { time: t, step: next - t });
            }
            let seam = next - 8.0 * f64::EPSILON * next.abs();
            let (held, now) = (&self.held, &self.now);
            held.history.within.set(t + (next - t) / 2.0);
            let right_hand_side = |t: f64, stacked: &[f64], slope: &mut [f64]| {
                model.derivative(t, stacked, held, &mut now.borrow_mut(), slope);
            };
            let mut stacked = std::mem::take(&mut self.stacked);
            let mut on_step = |step: &Accepted<'_>| {
                let mut now = now.borrow_mut();
                rows.clear();
                constant.clear();
                for node in NODE {
                    let t = step.start + node * (step.end - step.start);
                    step.at(t, &mut at);
                    model.varying(t, &at, held, &mut now, &mut rows);
                }
                model.constant(step.start, &at, held, &mut now, &mut constant);
                // The output that nothing is known of is not a number.
                let unknown = |entry: usize| {
                    let output = entry.checked_sub(layout.measured());
                    output.and_then(|j| held.readings.get(j)) == Some(&Reading::Nothing)
                };
                let all = rows.iter().chain(&constant);
                // A sum with something that is not finite is not finite either; one that overflows is looked at.
                if !all.clone().sum::<f64>().is_finite() {
                    let kept = dense.borrow();
                    for (index, &value) in all.enumerate().filter(|(_, value)| !value.is_finite()) {
                        let (node, entry) = match index.checked_sub(rows.len()) {
                            None => (index / varying, kept.varying(index % varying)),
                            Some(index) => (0, kept.constant(index)),
                        };
                        if !unknown(entry) {
                            let time = step.start + NODE[node] * (step.end - step.start);
                            return Err(SimError::QuantityNotFinite { time, what: layout.name(entry), value });
                        }
                    }
                }
                dense.borrow_mut().push(step.start, step.end, &constant, &rows);
                // A time at the seam of two intervals, up to rounding, waits for what happens there.
                while let Some(t) = waiting.next_if(|&t| t < step.end.min(seam)) {
                    step.at(t, &mut at);
                    model.row(t, &at, held, &mut now, &mut samples);
                }
                Ok(())
            };
            let exact = exponential.as_mut().and_then(|exponential| {
                let slope = |s: &[f64], slope: &mut [f64]| right_hand_side(t, s, slope);
                exponential.advance(&model.settings, (t, next), &mut stacked, slope, &mut on_step)
            });
            match exact {
                Some(steps) => {
                    if !stepper.counts(steps?) {
                        return Err(SimError::TooManySteps { time: t, step: next - t, steps: stepper.steps() });
                    }
                }
                None => stepper.advance(&right_hand_side, t, next, &mut stacked, &mut on_step)?,
            }
            self.stacked = stacked;
            t = next;
            self.tick(t)?;
        }
        for t in waiting {
            model.row(t, &self.stacked, &self.held, self.now.get_mut(), &mut samples);
        }
        let lengths: Vec<usize> = model.observers.iter().map(|fitted| fitted.length).collect();
        let integrals = model.integrals.iter().map(|(name, _)| name.clone()).collect();
        let run = (dense.take(), stepper.steps(), model.sampling.clone(), self.samples, self.updates);
        Ok(Trajectory::new(&model.times, &lengths, integrals, layout, &samples, run))
    }
}
