//! The checked scenario: the stacked right-hand side, and everything at one instant.
//!
//! The stacked state is (x, z_1, ..., z_k, q_1, ..., q_j): the plant, the observers in continuous time, the integrals.

use std::sync::Arc;

use luenberger_plants::{Dimensions, wrap};
use luenberger_random::Purpose;
use nalgebra::DMatrix;

use crate::change::Change;
use crate::disturbance::{Disturbances, History};
use crate::erased::{AnyObserver, AnyPlant};
use crate::error::{SimError, check, check_finite, check_positive};
use crate::integral::Integrand;
use crate::integrate::Settings;
use crate::moving::output_rate;
use crate::noise::Noise;
use crate::scenario::{Entry, Estimated, Scenario};
use crate::sensor::{Reading, Sampling};
use crate::signal::Signal;
use crate::trajectory::{Layout, ObserverLayout};
use crate::view::View;

/// The checked scenario: what evaluates the stacked right-hand side.
pub(crate) struct Model<'a> {
    plant: Arc<dyn AnyPlant + 'a>,
    /// In the order of their times.
    pub(crate) changes: Vec<Change<'a>>,
    /// The plant as the observers take it.
    pub(crate) observer_plant: Arc<dyn AnyPlant + 'a>,
    pub(crate) size: Dimensions,
    pub(crate) x0: Vec<f64>,
    pub(crate) start: f64,
    pub(crate) times: Vec<f64>,
    pub(crate) input: Signal<'a>,
    pub(crate) hold: Option<f64>,
    /// The period of a plant in discrete time.
    pub(crate) step: Option<f64>,
    pub(crate) noise: Option<Noise>,
    /// The number of the run in its ensemble.
    pub(crate) member: u64,
    pub(crate) sampling: Sampling,
    pub(crate) disturbances: Disturbances,
    pub(crate) names: Vec<String>,
    pub(crate) observers: Vec<ObserverSlot<'a>>,
    pub(crate) integrals: Vec<(String, Integrand<'a>)>,
    pub(crate) breakpoints: Vec<f64>,
    pub(crate) settings: Settings,
    /// The input zero.
    no_input: Vec<f64>,
    /// Whether derivatives read outputs: those of observers in continuous time, and of integrals.
    reads_outputs: bool,
    /// Whether the input reaches the plant as it is, and noise is all that is added to outputs.
    plain: bool,
}

pub(crate) struct ObserverSlot<'a> {
    pub(crate) observer: Arc<dyn AnyObserver + 'a>,
    pub(crate) initial: Vec<f64>,
    /// The states that it estimates; none if it estimates functions of the state.
    pub(crate) states: Vec<usize>,
    /// K of the functions `K x` that it estimates; without rows if it estimates states.
    pub(crate) k: DMatrix<f64>,
    /// The full turns of what it estimates, 0 for what is no angle.
    pub(crate) turns: Vec<f64>,
    /// Whether it estimates the whole state, so that it predicts outputs.
    pub(crate) whole: bool,
    /// Length of its state.
    pub(crate) length: usize,
    pub(crate) period: Option<f64>,
    /// Where its state begins in the stacked state, if it is integrated.
    pub(crate) offset: usize,
    /// How many outputs move with the model behind its state: all or none.
    pub(crate) moving: usize,
}

impl ObserverSlot<'_> {
    /// Length of its estimate.
    pub(crate) fn width(&self) -> usize {
        self.states.len() + self.k.nrows()
    }

    /// Where in the stacked state the outputs are that move with the model.
    pub(crate) fn moving(&self) -> std::ops::Range<usize> {
        // A sampled observer has no place there.
        let start = if self.moving > 0 { self.offset + self.length } else { 0 };
        start..start + self.moving
    }

    /// What it estimates, at the state x of the plant.
    pub(crate) fn estimated<'x>(&'x self, x: &'x [f64]) -> impl Iterator<Item = f64> + 'x {
        let functions = self.k.row_iter().map(move |row| row.iter().zip(x).map(|(k, x)| k * x).sum());
        self.states.iter().map(|&i| x[i]).chain(functions)
    }

    /// Writes the errors of an estimate at the state x of the plant.
    pub(crate) fn errors(&self, x: &[f64], estimate: &[f64], errors: &mut [f64]) {
        let all = errors.iter_mut().zip(estimate).zip(self.estimated(x)).zip(&self.turns);
        for (((error, estimate), x), turn) in all {
            *error = wrap(x - estimate, *turn);
        }
    }

    /// Whether the estimate is held between samples. That of a filter has the measurement, which may vary.
    fn is_held(&self) -> bool {
        self.period.is_some() && !self.observer.is_filter()
    }
}

/// Everything at one instant.
#[derive(Clone, Default)]
pub(crate) struct Instant {
    pub(crate) u: Vec<f64>,
    /// The input that reaches the plant.
    pub(crate) applied: Vec<f64>,
    pub(crate) y: Vec<f64>,
    /// The output as it is read.
    pub(crate) seen: Vec<f64>,
    pub(crate) estimates: Vec<Vec<f64>>,
    pub(crate) errors: Vec<Vec<f64>>,
}

/// What is constant between jumps.
#[derive(Clone, Default)]
pub(crate) struct HeldValues {
    /// The change that the plant is from; none before the first.
    pub(crate) plant: Option<usize>,
    pub(crate) noise: Vec<f64>,
    /// Whether the input is held.
    pub(crate) input_is_held: bool,
    /// States of the sampled-data observers; empty for the others.
    pub(crate) sampled: Vec<Vec<f64>>,
    /// What is added to the derivative of the plant; empty for nothing.
    pub(crate) disturbance: Vec<f64>,
    /// What is known of each output; empty if all are read at all times.
    pub(crate) readings: Vec<Reading>,
    /// The last value of each output that each observer has had, for outputs that it cannot predict.
    pub(crate) known: Vec<Vec<f64>>,
    /// What is added to outputs; empty for nothing.
    pub(crate) outliers: Vec<f64>,
    pub(crate) history: History,
}

impl<'a> Model<'a> {
    pub(crate) fn new(scenario: Scenario<'a>) -> Result<Self, SimError> {
        scenario.plant.check()?;
        let size = scenario.plant.dimensions();
        if let Some(step) = scenario.step {
            check_positive("the period of the plant", step)?;
        }
        let x0 = scenario.x0.unwrap_or_else(|| vec![0.0; size.states]);
        check("the initial state", &x0, size.states)?;
        let no_angles = scenario.turns.is_empty();
        let turns = if no_angles { vec![0.0; size.states] } else { scenario.turns };
        check_turns(&turns, size.states)?;
        if let Some(noise) = &scenario.noise {
            noise.check(size.outputs)?;
        }
        let mut names: Vec<String> = Vec::new();
        let mut observers = Vec::new();
        let mut offset = size.states;
        for Entry { name, observer, initial, of } in scenario.observers {
            observer.check()?;
            let own = observer.dimensions();
            let expect = |what: &str, expected: usize, found: usize| {
                let what = format!("{what} of observer {name:?}");
                if expected == found { Ok(()) } else { Err(SimError::Length { what, expected, found }) }
            };
            expect("the input", size.inputs, own.inputs)?;
            expect("the output", size.outputs, own.outputs)?;
            check(&format!("the initial estimate of observer {name:?}"), &initial, own.estimate)?;
            let no_functions = DMatrix::zeros(0, size.states);
            let (states, k) = match of {
                Estimated::State => ((0..size.states).collect(), no_functions),
                Estimated::States(states) => (states, no_functions),
                Estimated::Functions(k) => (Vec::new(), k),
            };
            let whole = states.iter().copied().eq(0..size.states);
            expect("the estimate", states.len() + k.nrows(), own.estimate)?;
            expect("a row of K", size.states, k.ncols())?;
            check_finite(&format!("K of observer {name:?}"), k.as_slice())?;
            if let Some(&index) = states.iter().find(|&&index| index >= size.states) {
                return Err(SimError::Index { what: "plant state", index, count: size.states });
            }
            let period = observer.period();
            match period {
                Some(period) => check_positive("the period of a sampled-data observer", period)?,
                None if scenario.step.is_some() => return Err(SimError::ContinuousObserver { name }),
                None => {}
            }
            if let Some(times) = observer.sample_times() {
                times.check()?;
            }
            let of = states.iter().map(|&state| turns[state]).chain(k.row_iter().map(|_| 0.0)).collect();
            let length = own.state;
            let moves = whole && period.is_none() && !observer.is_corrected() && !scenario.measurements_are_held;
            let moving = if moves && !scenario.sensors.is_empty() { size.outputs } else { 0 };
            observers.push(ObserverSlot {
                observer,
                initial,
                states,
                k,
                turns: of,
                whole,
                length,
                period,
                offset,
                moving,
            });
            offset += if period.is_none() { length + moving } else { 0 };
            names.push(name);
        }
        let estimates: Vec<_> = names.iter().cloned().zip(observers.iter().map(ObserverSlot::width)).collect();
        scenario.input.check(size.states, size.inputs, &estimates)?;
        for (_, integrand) in &scenario.integrals {
            integrand.check(size.states, size.inputs, &estimates)?;
        }
        unique(&names.iter().collect::<Vec<_>>())?;
        unique(&scenario.integrals.iter().map(|(name, _)| name).collect::<Vec<_>>())?;
        let disturbances = scenario.disturbances;
        disturbances.check(size.states, size.inputs, size.outputs)?;
        let channel = disturbances.channel.clone();
        let sampling = Sampling::new(scenario.start, size.outputs, scenario.sensors, channel, scenario.member)?;
        let observer_plant = scenario.model.unwrap_or_else(|| Arc::clone(&scenario.plant));
        observer_plant.check()?;
        if observer_plant.dimensions() != size {
            let (expected, found) = (size.states, observer_plant.dimensions().states);
            return Err(SimError::Length { what: "the state of the model".to_owned(), expected, found });
        }
        let mut changes = scenario.changes;
        changes.sort_by(|one, other| one.time.total_cmp(&other.time));
        for change in &changes {
            change.check(scenario.start, scenario.plant.as_ref())?;
        }
        let mut breakpoints = scenario.breakpoints;
        breakpoints.extend(changes.iter().map(|change| change.time));
        let end = scenario.times.last().copied().unwrap_or(scenario.start);
        // Inputs that jump every period jump at the plant later.
        let held = scenario.hold.into_iter().chain(observers.iter().filter_map(|observer| observer.period));
        let jumps = |period: f64| {
            let count = ((end - scenario.start) / period) as u64;
            (0..=count).map(move |k| scenario.start + k as f64 * period)
        };
        let held: Vec<f64> = if disturbances.input_delay > 0.0 { held.flat_map(jumps).collect() } else { Vec::new() };
        breakpoints.extend(disturbances.breakpoints(&[breakpoints.clone(), held].concat()));
        breakpoints.sort_by(f64::total_cmp);
        let max_step = scenario.settings.max_step.min(disturbances.shortest_delay());
        let integrals = !scenario.integrals.is_empty();
        Ok(Self {
            reads_outputs: integrals || observers.iter().any(|observer| observer.period.is_none()),
            plain: disturbances.leave_signals() && sampling.is_continuous(),
            plant: scenario.plant,
            changes,
            observer_plant,
            size,
            x0,
            start: scenario.start,
            times: scenario.times,
            input: scenario.input,
            hold: scenario.hold,
            step: scenario.step,
            noise: scenario.noise,
            member: scenario.member,
            sampling,
            disturbances,
            names,
            observers,
            integrals: scenario.integrals,
            breakpoints,
            settings: Settings { max_step, ..scenario.settings },
            no_input: vec![0.0; size.inputs],
        })
    }

    /// The noise of the outputs in period k.
    pub(crate) fn measurement_noise(&self, k: u64) -> Option<impl Iterator<Item = f64>> {
        self.noise.as_ref().map(|noise| self.values(noise, Purpose::MeasurementNoise, k))
    }

    /// The noise of the derivatives, or of the next state, in period k.
    pub(crate) fn process_noise(&self, k: u64) -> Option<impl Iterator<Item = f64>> {
        self.disturbances.process_noise.as_ref().map(|noise| self.values(noise, Purpose::ProcessNoise, k))
    }

    fn values<'n>(&self, noise: &'n Noise, purpose: Purpose, k: u64) -> impl Iterator<Item = f64> + use<'n> {
        noise.values(noise.stream(purpose, 0).member(self.member), k)
    }

    /// The plant as it is now.
    pub(crate) fn plant(&self, held: &HeldValues) -> &dyn AnyPlant {
        held.plant.and_then(|k| self.changes[k].plant.as_deref()).unwrap_or(self.plant.as_ref())
    }

    pub(crate) fn instant(&self) -> Instant {
        let estimates: Vec<Vec<f64>> = self.observers.iter().map(|o| vec![0.0; o.width()]).collect();
        Instant {
            u: vec![0.0; self.size.inputs],
            applied: vec![0.0; self.size.inputs],
            y: vec![0.0; self.size.outputs],
            seen: vec![0.0; self.size.outputs],
            errors: estimates.clone(),
            estimates,
        }
    }

    pub(crate) fn view<'v>(&'v self, t: f64, x: &'v [f64], now: &'v Instant) -> View<'v> {
        View { t, x, u: &now.u, y: &now.y, names: &self.names, estimates: &now.estimates, errors: &now.errors }
    }

    /// State of observer `k`.
    pub(crate) fn state<'s>(&self, k: usize, stacked: &'s [f64], held: &'s HeldValues) -> &'s [f64] {
        let observer = &self.observers[k];
        match observer.period {
            Some(_) => &held.sampled[k],
            None => &stacked[observer.offset..observer.offset + observer.length],
        }
    }

    /// The outputs as observer `k` takes them, of which the entries in `absent` are not measured: it takes what it
    /// predicts, or the last value if it predicts none. In the place of what is held it takes what is `moving`, if it
    /// is not empty.
    pub(crate) fn outputs_of(
        &self,
        k: usize,
        (t, state): (f64, &[f64]),
        held: &HeldValues,
        now: &Instant,
        moving: &[f64],
        absent: impl Fn(usize) -> bool,
    ) -> Vec<f64> {
        let ObserverSlot { observer, states, whole, .. } = &self.observers[k];
        let absent: Vec<usize> = (0..self.size.outputs).filter(|&j| absent(j)).collect();
        let mut y = now.seen.clone();
        for (j, moving) in moving.iter().enumerate() {
            if matches!(held.readings[j], Reading::Held(_)) {
                y[j] = *moving;
            }
        }
        for &j in &absent {
            y[j] = held.known[k][j];
        }
        if *whole && !absent.is_empty() {
            let (mut estimate, mut h) = (vec![0.0; states.len()], vec![0.0; y.len()]);
            observer.estimate(t, state, &now.u, &y, &mut estimate);
            self.observer_plant.output(t, &estimate, &now.u, &mut h);
            for &j in &absent {
                y[j] = h[j];
            }
        }
        y
    }

    /// The outputs as an observer takes them; none if all are known.
    fn predicted_of(&self, k: usize, t: f64, stacked: &[f64], held: &HeldValues, now: &Instant) -> Option<Vec<f64>> {
        let slot = &self.observers[k];
        if !held.readings.contains(&Reading::Nothing) && slot.moving == 0 {
            return None;
        }
        let absent = |j: usize| held.readings[j] == Reading::Nothing;
        let moving = &stacked[slot.moving()];
        Some(self.outputs_of(k, (t, self.state(k, stacked, held)), held, now, moving, absent))
    }

    pub(crate) fn estimates(&self, t: f64, stacked: &[f64], held: &HeldValues, now: &mut Instant) {
        for k in 0..self.observers.len() {
            self.estimate(k, t, stacked, held, now);
        }
    }

    fn estimate(&self, k: usize, t: f64, stacked: &[f64], held: &HeldValues, now: &mut Instant) {
        let slot = &self.observers[k];
        let observer = &slot.observer;
        let predicted = self.predicted_of(k, t, stacked, held, now);
        let seen = predicted.as_ref().unwrap_or(&now.seen);
        let state = self.state(k, stacked, held);
        observer.estimate(t, state, &now.u, seen, &mut now.estimates[k]);
        let measured = |reading: &Reading| *reading != Reading::Nothing;
        let measured: Vec<bool> =
            if predicted.is_some() { held.readings.iter().map(measured).collect() } else { Vec::new() };
        observer.correct(state, &now.u, seen, &measured, &mut now.estimates[k]);
        slot.errors(&stacked[..self.size.states], &now.estimates[k], &mut now.errors[k]);
    }

    /// Input, outputs and estimates at `t`.
    pub(crate) fn evaluate(&self, t: f64, stacked: &[f64], held: &HeldValues, now: &mut Instant) {
        self.input_and_output(t, stacked, held, now);
        self.estimates(t, stacked, held, now);
    }

    fn input_and_output(&self, t: f64, stacked: &[f64], held: &HeldValues, now: &mut Instant) {
        self.input(t, stacked, held, now);
        self.see(t, &stacked[..self.size.states], held, now);
    }

    fn input(&self, t: f64, stacked: &[f64], held: &HeldValues, now: &mut Instant) {
        // A held input is the present one.
        if !held.input_is_held {
            self.steer(t, stacked, held, now);
        }
    }

    /// The output under the input of the same instant, and what the observers see of it.
    pub(crate) fn see(&self, t: f64, x: &[f64], held: &HeldValues, now: &mut Instant) {
        self.apply(t, held, now);
        let applied = if self.plain { &now.u } else { &now.applied };
        self.plant(held).output(t, x, applied, &mut now.y);
        if self.plain {
            for ((seen, y), noise) in now.seen.iter_mut().zip(&now.y).zip(&held.noise) {
                *seen = y + noise;
            }
            return;
        }
        let output = self.size.states + self.size.inputs;
        self.disturbances.read(t, &held.history, output, &held.noise, (&now.y, &mut now.seen));
        for (seen, outlier) in now.seen.iter_mut().zip(&held.outliers) {
            *seen += outlier;
        }
        for (seen, reading) in now.seen.iter_mut().zip(&held.readings) {
            match reading {
                Reading::Now => {}
                Reading::Held(value) => *seen = *value,
                Reading::Nothing => *seen = f64::NAN,
            }
        }
    }

    /// The input that reaches the plant.
    pub(crate) fn applied<'n>(&self, now: &'n Instant) -> &'n [f64] {
        if self.plain { &now.u } else { &now.applied }
    }

    /// Finds it, where it is not the input itself.
    fn apply(&self, t: f64, held: &HeldValues, now: &mut Instant) {
        if !self.plain {
            self.disturbances.applied(t, &held.history, self.size.states, &now.u, &mut now.applied);
        }
    }

    /// The input by its law. What the law reads of output and estimates is that of the input zero; a law that would
    /// read another output under its own input is an algebraic loop.
    pub(crate) fn steer(&self, t: f64, stacked: &[f64], held: &HeldValues, now: &mut Instant) {
        now.u.fill(0.0);
        if self.input.reads_estimates() {
            self.see(t, &stacked[..self.size.states], held, now);
            self.estimates(t, stacked, held, now);
        }
        self.law(t, stacked, now);
    }

    /// The input from the estimates there are.
    pub(crate) fn law(&self, t: f64, stacked: &[f64], now: &mut Instant) {
        let mut u = std::mem::take(&mut now.u);
        let view = View { u: &self.no_input, ..self.view(t, &stacked[..self.size.states], now) };
        self.input.write(&view, &mut u);
        now.u = u;
    }

    pub(crate) fn derivative(&self, t: f64, stacked: &[f64], held: &HeldValues, now: &mut Instant, slope: &mut [f64]) {
        self.input(t, stacked, held, now);
        if self.plain && self.step.is_none() && self.integrals.is_empty() {
            return self.plain_derivative(t, stacked, held, now, slope);
        }
        if self.reads_outputs {
            self.see(t, &stacked[..self.size.states], held, now);
        } else {
            self.apply(t, held, now);
        }
        if !self.integrals.is_empty() {
            self.estimates(t, stacked, held, now);
        }
        let (x, n) = (&stacked[..self.size.states], self.size.states);
        if self.step.is_some() {
            // A plant in discrete time is constant between its steps.
            slope[..n].fill(0.0);
        } else {
            self.plant(held).derivative(t, x, self.applied(now), &mut slope[..n]);
            for (slope, disturbance) in slope.iter_mut().zip(&held.disturbance) {
                *slope += disturbance;
            }
        }
        let mut end = n;
        for (k, ObserverSlot { observer, length, period, moving, states, .. }) in self.observers.iter().enumerate() {
            if period.is_none() {
                let state = self.state(k, stacked, held);
                let predicted = self.predicted_of(k, t, stacked, held, now);
                let seen = predicted.as_ref().unwrap_or(&now.seen);
                observer.derivative(t, state, &now.u, seen, &mut slope[end..end + length]);
                end += length;
                if *moving > 0 {
                    let mut estimate = vec![0.0; states.len()];
                    observer.estimate(t, state, &now.u, seen, &mut estimate);
                    let moves = |j: usize| matches!(held.readings[j], Reading::Held(_));
                    let (plant, at) = (self.observer_plant.as_ref(), (t, &estimate[..], &now.u[..]));
                    output_rate(plant, at, self.sampling.shortest_period(), moves, &mut slope[end..end + moving]);
                    end += moving;
                }
            }
        }
        let view = self.view(t, x, now);
        for ((_, integrand), slope) in self.integrals.iter().zip(&mut slope[end..]) {
            *slope = integrand.value(&view);
        }
    }

    /// The derivative where the input reaches the plant as it is, and noise is all that is added to outputs.
    fn plain_derivative(&self, t: f64, stacked: &[f64], held: &HeldValues, now: &mut Instant, slope: &mut [f64]) {
        let ((x, _), (of_plant, _)) = (stacked.split_at(self.size.states), slope.split_at_mut(self.size.states));
        let plant = self.plant(held);
        if self.reads_outputs {
            plant.motion(t, x, &now.u, of_plant, &mut now.y);
            for ((seen, y), noise) in now.seen.iter_mut().zip(&now.y).zip(&held.noise) {
                *seen = y + noise;
            }
        } else {
            plant.derivative(t, x, &now.u, of_plant);
        }
        for (slope, disturbance) in of_plant.iter_mut().zip(&held.disturbance) {
            *slope += disturbance;
        }
        for ObserverSlot { observer, length, period, offset, .. } in &self.observers {
            if period.is_none() {
                let own = *offset..offset + length;
                observer.derivative(t, &stacked[own.clone()], &now.u, &now.seen, &mut slope[own]);
            }
        }
    }

    pub(crate) fn stacked_length(&self) -> usize {
        let integrated =
            self.observers.iter().filter(|o| o.period.is_none()).map(|o| o.length + o.moving).sum::<usize>();
        self.size.states + integrated + self.integrals.len()
    }

    /// Whether the stacked equation is affine with constant inputs from one jump to the next, and there are jumps.
    pub(crate) fn is_affine(&self) -> bool {
        let is_sampled = |slot: &ObserverSlot<'_>| slot.period.is_some() || slot.observer.sample_times().is_some();
        let sampled = self.observers.iter().any(is_sampled);
        let process = self.disturbances.process_noise.is_some();
        (self.hold.is_some() || self.noise.is_some() || process || sampled)
            && self.step.is_none()
            && self.integrals.is_empty()
            && self.plain
            && self.is_input_held()
            && self.changes.iter().all(|change| change.plant.is_none())
            && self.plant.is_affine()
            && self.observers.iter().all(|slot| slot.period.is_some() || slot.observer.is_affine())
    }

    /// Whether the input is constant within each step.
    fn is_input_held(&self) -> bool {
        self.hold.is_some() || self.input.is_constant()
    }

    pub(crate) fn layout(&self) -> Layout {
        let Dimensions { states, inputs, outputs } = self.size;
        let mut width = states + inputs + 2 * outputs;
        let mut observers = Vec::new();
        let mut constant = vec![false; width];
        constant[..states].fill(self.step.is_some());
        constant[states..states + inputs].fill(self.is_input_held());
        for fitted in &self.observers {
            let estimate = width + fitted.length;
            // Functions of the state follow the estimate.
            let (functions, after) = (fitted.k.nrows(), estimate + fitted.width());
            let of = fitted.states.iter().copied().chain(after..after + functions).collect();
            observers.push(ObserverLayout { estimate, of, turns: fitted.turns.clone(), period: fitted.period });
            width = after + functions;
            constant.resize(estimate, fitted.period.is_some());
            constant.resize(after, fitted.is_held());
            constant.resize(width, self.step.is_some());
        }
        constant.resize(width + self.integrals.len(), false);
        Layout {
            size: self.size,
            names: self.names.clone(),
            observers,
            integrals: width,
            width: width + self.integrals.len(),
            constant,
        }
    }

    /// Everything at `t` in one row: x, u, y and what is read of it, then state and estimate of each observer, then the
    /// integrals.
    pub(crate) fn row(&self, t: f64, stacked: &[f64], held: &HeldValues, now: &mut Instant, row: &mut Vec<f64>) {
        self.evaluate(t, stacked, held, now);
        row.extend_from_slice(&stacked[..self.size.states]);
        row.extend_from_slice(&now.u);
        row.extend_from_slice(&now.y);
        row.extend_from_slice(&now.seen);
        for k in 0..self.observers.len() {
            row.extend_from_slice(self.state(k, stacked, held));
            row.extend_from_slice(&now.estimates[k]);
            self.functions(k, stacked, row);
        }
        row.extend_from_slice(&stacked[stacked.len() - self.integrals.len()..]);
    }

    /// The entries of [`row`](Self::row) that vary within a step.
    pub(crate) fn varying(&self, t: f64, stacked: &[f64], held: &HeldValues, now: &mut Instant, row: &mut Vec<f64>) {
        self.input(t, stacked, held, now);
        self.see(t, &stacked[..self.size.states], held, now);
        if self.step.is_none() {
            row.extend_from_slice(&stacked[..self.size.states]);
        }
        if !self.is_input_held() {
            row.extend_from_slice(&now.u);
        }
        row.extend_from_slice(&now.y);
        row.extend_from_slice(&now.seen);
        for (k, observer) in self.observers.iter().enumerate() {
            if observer.period.is_none() {
                let state = self.state(k, stacked, held);
                if self.plain {
                    observer.observer.estimate(t, state, &now.u, &now.seen, &mut now.estimates[k]);
                } else {
                    self.estimate(k, t, stacked, held, now);
                }
                row.extend_from_slice(state);
                row.extend_from_slice(&now.estimates[k]);
            } else if !observer.is_held() {
                self.estimate(k, t, stacked, held, now);
                row.extend_from_slice(&now.estimates[k]);
            }
            if self.step.is_none() {
                self.functions(k, stacked, row);
            }
        }
        row.extend_from_slice(&stacked[stacked.len() - self.integrals.len()..]);
    }

    /// The functions that an observer estimates.
    fn functions(&self, k: usize, stacked: &[f64], row: &mut Vec<f64>) {
        let slot = &self.observers[k];
        row.extend(slot.estimated(&stacked[..self.size.states]).skip(slot.states.len()));
    }

    /// The others, at any time of a step, after [`varying`](Self::varying).
    pub(crate) fn constant(&self, t: f64, stacked: &[f64], held: &HeldValues, now: &mut Instant, row: &mut Vec<f64>) {
        if self.step.is_some() {
            row.extend_from_slice(&stacked[..self.size.states]);
        }
        if self.is_input_held() {
            row.extend_from_slice(&now.u);
        }
        for (k, observer) in self.observers.iter().enumerate() {
            if observer.period.is_some() {
                row.extend_from_slice(self.state(k, stacked, held));
            }
            if observer.is_held() {
                self.estimate(k, t, stacked, held, now);
                row.extend_from_slice(&now.estimates[k]);
            }
            if self.step.is_some() {
                self.functions(k, stacked, row);
            }
        }
    }
}

/// Checks that no name occurs twice.
/// Full turns of so many states.
pub(crate) fn check_turns(turns: &[f64], states: usize) -> Result<(), SimError> {
    check("the full turns", turns, states)?;
    turns.iter().filter(|turn| **turn != 0.0).try_for_each(|turn| check_positive("a full turn", *turn))
}

fn unique(names: &[&String]) -> Result<(), SimError> {
    for (k, name) in names.iter().enumerate() {
        if names[..k].contains(name) {
            return Err(SimError::DuplicateName { name: (*name).clone() });
        }
    }
    Ok(())
}
