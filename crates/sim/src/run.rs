//! A run: one plant and any number of observers, integrated as one stacked equation.
//!
//! The stacked state is (x, z_1, ..., z_k, q_1, ..., q_j): the plant, the observers in continuous time, the integrals.
//! Integration stops and goes on wherever something jumps: a new value of the noise, a sample, a held input, a breakpoint of
//! the input. Sampled-data observers are stepped at their samples; between samples their estimate stands still.

use std::cell::RefCell;

use luenberger_observers::{Observer, SampledObserver};
use luenberger_plants::{Dimensions, Plant};

use crate::dense::{Dense, NODES, node};
use crate::erased::{AnyObserver, AnyPlant, Continuous, Erased, Sampled};
use crate::error::{SimError, check, check_finite, check_positive};
use crate::integral::Integrand;
use crate::integrate::{Integrator, March, Settings};
use crate::noise::Noise;
use crate::signal::Signal;
use crate::trajectory::{Layout, ObserverLayout, Trajectory};
use crate::view::View;

/// A plant, observers, an input and all else that a run needs.
///
/// Nothing is checked before [`run`](Self::run), which reports the first thing that does not fit.
pub struct Scenario<'a> {
    plant: Box<dyn AnyPlant + 'a>,
    x0: Option<Vec<f64>>,
    start: f64,
    times: Vec<f64>,
    input: Signal<'a>,
    hold: Option<f64>,
    noise: Option<Noise>,
    observers: Vec<Entry<'a>>,
    integrals: Vec<(String, Integrand<'a>)>,
    breakpoints: Vec<f64>,
    settings: Settings,
}

struct Entry<'a> {
    name: String,
    observer: Box<dyn AnyObserver + 'a>,
    initial: Vec<f64>,
    /// Which plant states are estimated; the first ones unless told.
    states: Option<Vec<usize>>,
}

impl<'a> Scenario<'a> {
    /// A scenario with this plant, at rest in the origin, without input, from t = 0.
    pub fn new(plant: impl Plant<f64> + 'a) -> Self {
        Self {
            plant: Box::new(Erased(plant)),
            x0: None,
            start: 0.0,
            times: Vec::new(),
            input: Signal::zero(),
            hold: None,
            noise: None,
            observers: Vec::new(),
            integrals: Vec::new(),
            breakpoints: Vec::new(),
            settings: Settings::default(),
        }
    }

    /// The plant's state at the start.
    #[must_use]
    pub fn initial_state(mut self, x0: &[f64]) -> Self {
        self.x0 = Some(x0.to_vec());
        self
    }

    /// The time of the start, 0 unless told.
    #[must_use]
    pub fn start(mut self, t: f64) -> Self {
        self.start = t;
        self
    }

    /// The times at which the trajectory is wanted, increasing; the last one ends the run.
    #[must_use]
    pub fn times(mut self, times: &[f64]) -> Self {
        self.times = times.to_vec();
        self
    }

    /// From the start (0 unless [`start`](Self::start) was called before) to `end`, at so many equally spaced times.
    #[must_use]
    pub fn until(mut self, end: f64, samples: usize) -> Self {
        let last = samples.max(2) - 1;
        let time = |k: usize| if k == last { end } else { self.start + (end - self.start) * k as f64 / last as f64 };
        self.times = (0..=last).map(time).collect();
        self
    }

    /// The input.
    #[must_use]
    pub fn input(mut self, input: Signal<'a>) -> Self {
        self.input = input;
        self
    }

    /// The input is evaluated every `period` and held in between, as by a digital controller.
    #[must_use]
    pub fn hold_input(mut self, period: f64) -> Self {
        self.hold = Some(period);
        self
    }

    /// Times at which the input or the plant jumps, so that no step crosses them.
    #[must_use]
    pub fn breakpoints(mut self, times: &[f64]) -> Self {
        self.breakpoints.extend_from_slice(times);
        self
    }

    /// Noise on the outputs that the observers see.
    #[must_use]
    pub fn noise(mut self, noise: Noise) -> Self {
        self.noise = Some(noise);
        self
    }

    /// An observer in continuous time, and its estimate at the start.
    #[must_use]
    pub fn observer(self, name: &str, observer: impl Observer<f64> + 'a, initial: &[f64]) -> Self {
        self.entry(name, Box::new(Continuous(observer)), initial, None)
    }

    /// An observer of some states of the plant: entry i of its estimate is for the state `states[i]`, from 0.
    #[must_use]
    pub fn partial_observer(
        self,
        name: &str,
        observer: impl Observer<f64> + 'a,
        initial: &[f64],
        states: &[usize],
    ) -> Self {
        self.entry(name, Box::new(Continuous(observer)), initial, Some(states.to_vec()))
    }

    /// A sampled-data observer, and its estimate at the start, which is its first sample.
    ///
    /// It assumes an input that is held between its samples; make it so with [`hold_input`](Self::hold_input).
    #[must_use]
    pub fn sampled_observer(self, name: &str, observer: impl SampledObserver<f64> + 'a, initial: &[f64]) -> Self {
        self.entry(name, Box::new(Sampled(observer)), initial, None)
    }

    /// A sampled-data observer of some states of the plant.
    #[must_use]
    pub fn partial_sampled_observer(
        self,
        name: &str,
        observer: impl SampledObserver<f64> + 'a,
        initial: &[f64],
        states: &[usize],
    ) -> Self {
        self.entry(name, Box::new(Sampled(observer)), initial, Some(states.to_vec()))
    }

    pub(crate) fn entry(
        mut self,
        name: &str,
        observer: Box<dyn AnyObserver + 'a>,
        initial: &[f64],
        states: Option<Vec<usize>>,
    ) -> Self {
        self.observers.push(Entry { name: name.to_owned(), observer, initial: initial.to_vec(), states });
        self
    }

    /// An integral along the run, 0 at the start.
    #[must_use]
    pub fn integral(mut self, name: &str, integrand: Integrand<'a>) -> Self {
        self.integrals.push((name.to_owned(), integrand));
        self
    }

    /// Method, tolerances and caps.
    #[must_use]
    pub fn settings(mut self, settings: Settings) -> Self {
        self.settings = settings;
        self
    }

    /// The method alone.
    #[must_use]
    pub fn integrator(mut self, integrator: Integrator) -> Self {
        self.settings.integrator = integrator;
        self
    }

    /// The tolerances alone.
    #[must_use]
    pub fn tolerances(mut self, rtol: f64, atol: f64) -> Self {
        (self.settings.rtol, self.settings.atol) = (rtol, atol);
        self
    }

    /// Runs.
    ///
    /// # Errors
    /// What does not fit: [`SimError::Length`], [`SimError::NotFinite`], [`SimError::NotPositive`], [`SimError::TimeSpan`],
    /// [`SimError::TimesUnsorted`], [`SimError::DuplicateName`], [`SimError::UnknownName`], [`SimError::Index`],
    /// [`SimError::AlgebraicLoop`]. What happens on the way: [`SimError::BlowUp`], [`SimError::StepSize`],
    /// [`SimError::TooManySteps`].
    pub fn run(self) -> Result<Trajectory, SimError> {
        let end = self.check_times()?;
        let model = Model::new(self)?;
        Runner::new(&model)?.run(end)
    }

    /// Checks everything about time, and returns the end.
    fn check_times(&self) -> Result<f64, SimError> {
        self.settings.check()?;
        check_finite("the requested times", &self.times)?;
        check_finite("the breakpoints", &self.breakpoints)?;
        let end = self.times.last().copied().unwrap_or(self.start);
        if !self.start.is_finite() || end <= self.start {
            return Err(SimError::TimeSpan { start: self.start, end });
        }
        if self.times[0] < self.start {
            return Err(SimError::Outside { time: self.times[0], start: self.start, end });
        }
        for (index, pair) in self.times.windows(2).enumerate() {
            if pair[1] <= pair[0] {
                return Err(SimError::TimesUnsorted { index: index + 1, previous: pair[0], next: pair[1] });
            }
        }
        if let Some(period) = self.hold {
            check_positive("the period of the held input", period)?;
        }
        Ok(end)
    }
}

/// The checked scenario: what evaluates the stacked right-hand side.
struct Model<'a> {
    plant: Box<dyn AnyPlant + 'a>,
    size: Dimensions,
    x0: Vec<f64>,
    start: f64,
    times: Vec<f64>,
    input: Signal<'a>,
    hold: Option<f64>,
    noise: Option<Noise>,
    names: Vec<String>,
    observers: Vec<Fitted<'a>>,
    integrals: Vec<(String, Integrand<'a>)>,
    breakpoints: Vec<f64>,
    settings: Settings,
}

struct Fitted<'a> {
    observer: Box<dyn AnyObserver + 'a>,
    initial: Vec<f64>,
    states: Vec<usize>,
    /// Length of its state.
    length: usize,
    period: Option<f64>,
    /// Where its state begins in the stacked state, if it is integrated.
    offset: usize,
}

/// Everything at one instant.
#[derive(Clone, Default)]
struct Instant {
    u: Vec<f64>,
    y: Vec<f64>,
    /// Output with noise.
    seen: Vec<f64>,
    estimates: Vec<Vec<f64>>,
    errors: Vec<Vec<f64>>,
}

/// What stands still between jumps.
#[derive(Clone, Default)]
struct Still {
    noise: Vec<f64>,
    held: Option<Vec<f64>>,
    /// States of the sampled-data observers; empty for the others.
    sampled: Vec<Vec<f64>>,
}

impl<'a> Model<'a> {
    fn new(scenario: Scenario<'a>) -> Result<Self, SimError> {
        scenario.plant.check()?;
        let size = scenario.plant.dimensions();
        let x0 = scenario.x0.unwrap_or_else(|| vec![0.0; size.states]);
        check("the initial state", &x0, size.states)?;
        if let Some(noise) = &scenario.noise {
            noise.check(size.outputs)?;
        }
        let mut names: Vec<String> = Vec::new();
        let mut observers = Vec::new();
        let mut offset = size.states;
        for Entry { name, observer, initial, states } in scenario.observers {
            observer.check()?;
            let own = observer.dimensions();
            let expect = |what: &str, expected: usize, found: usize| {
                let what = format!("{what} of observer {name:?}");
                if expected == found { Ok(()) } else { Err(SimError::Length { what, expected, found }) }
            };
            expect("the input", size.inputs, own.inputs)?;
            expect("the output", size.outputs, own.outputs)?;
            check(&format!("the initial estimate of observer {name:?}"), &initial, own.estimate)?;
            let states = states.unwrap_or_else(|| (0..size.states).collect());
            expect("the estimate", states.len(), own.estimate)?;
            if let Some(&index) = states.iter().find(|&&index| index >= size.states) {
                return Err(SimError::Index { what: "plant state", index, count: size.states });
            }
            let period = observer.period();
            if let Some(period) = period {
                check_positive("the period of a sampled-data observer", period)?;
            }
            let length = own.state;
            observers.push(Fitted { observer, initial, states, length, period, offset });
            offset += if period.is_none() { length } else { 0 };
            names.push(name);
        }
        let estimates: Vec<_> = names.iter().cloned().zip(observers.iter().map(|o| o.states.len())).collect();
        scenario.input.check(size.states, size.inputs, &estimates)?;
        for (_, integrand) in &scenario.integrals {
            integrand.check(size.states, size.inputs, &estimates)?;
        }
        unique(&names.iter().collect::<Vec<_>>())?;
        unique(&scenario.integrals.iter().map(|(name, _)| name).collect::<Vec<_>>())?;
        let mut breakpoints = scenario.breakpoints;
        breakpoints.sort_by(f64::total_cmp);
        Ok(Self {
            plant: scenario.plant,
            size,
            x0,
            start: scenario.start,
            times: scenario.times,
            input: scenario.input,
            hold: scenario.hold,
            noise: scenario.noise,
            names,
            observers,
            integrals: scenario.integrals,
            breakpoints,
            settings: scenario.settings,
        })
    }

    fn instant(&self) -> Instant {
        let estimates: Vec<Vec<f64>> = self.observers.iter().map(|o| vec![0.0; o.states.len()]).collect();
        Instant {
            u: vec![0.0; self.size.inputs],
            y: vec![0.0; self.size.outputs],
            seen: vec![0.0; self.size.outputs],
            errors: estimates.clone(),
            estimates,
        }
    }

    fn view<'v>(&'v self, t: f64, x: &'v [f64], now: &'v Instant) -> View<'v> {
        View { t, x, u: &now.u, y: &now.y, names: &self.names, estimates: &now.estimates, errors: &now.errors }
    }

    /// State of observer `k`.
    fn state<'s>(&self, k: usize, stacked: &'s [f64], still: &'s Still) -> &'s [f64] {
        let observer = &self.observers[k];
        match observer.period {
            Some(_) => &still.sampled[k],
            None => &stacked[observer.offset..observer.offset + observer.length],
        }
    }

    fn estimates(&self, t: f64, stacked: &[f64], still: &Still, now: &mut Instant) {
        for (k, Fitted { observer, states, .. }) in self.observers.iter().enumerate() {
            observer.estimate(t, self.state(k, stacked, still), &now.u, &now.seen, &mut now.estimates[k]);
            for ((error, estimate), &i) in now.errors[k].iter_mut().zip(&now.estimates[k]).zip(states) {
                *error = stacked[i] - estimate;
            }
        }
    }

    /// Input, outputs and estimates at `t`.
    fn evaluate(&self, t: f64, stacked: &[f64], still: &Still, now: &mut Instant) {
        let x = &stacked[..self.size.states];
        self.see(t, x, still, now);
        match &still.held {
            Some(held) => now.u.copy_from_slice(held),
            None => self.steer(t, stacked, still, now),
        }
        self.estimates(t, stacked, still, now);
    }

    /// The output and what the observers see of it.
    fn see(&self, t: f64, x: &[f64], still: &Still, now: &mut Instant) {
        self.plant.output(t, x, &mut now.y);
        for ((seen, y), noise) in now.seen.iter_mut().zip(&now.y).zip(&still.noise) {
            *seen = y + noise;
        }
    }

    /// The input by its law.
    fn steer(&self, t: f64, stacked: &[f64], still: &Still, now: &mut Instant) {
        now.u.fill(0.0);
        if self.input.reads_estimates() {
            self.estimates(t, stacked, still, now);
        }
        self.law(t, stacked, now);
    }

    /// The input from the estimates there are.
    fn law(&self, t: f64, stacked: &[f64], now: &mut Instant) {
        let mut u = std::mem::take(&mut now.u);
        let zero = vec![0.0; u.len()];
        let view = View { u: &zero, ..self.view(t, &stacked[..self.size.states], now) };
        self.input.write(&view, &mut u);
        now.u = u;
    }

    fn derivative(&self, t: f64, stacked: &[f64], still: &Still, now: &mut Instant, slope: &mut [f64]) {
        self.evaluate(t, stacked, still, now);
        let (x, n) = (&stacked[..self.size.states], self.size.states);
        self.plant.derivative(t, x, &now.u, &mut slope[..n]);
        let mut end = n;
        for (k, Fitted { observer, length, period, .. }) in self.observers.iter().enumerate() {
            if period.is_none() {
                let state = self.state(k, stacked, still);
                observer.derivative(t, state, &now.u, &now.seen, &mut slope[end..end + length]);
                end += length;
            }
        }
        let view = self.view(t, x, now);
        for ((_, integrand), slope) in self.integrals.iter().zip(&mut slope[end..]) {
            *slope = integrand.value(&view);
        }
    }

    fn stacked_length(&self) -> usize {
        let integrated = self.observers.iter().filter(|o| o.period.is_none()).map(|o| o.length).sum::<usize>();
        self.size.states + integrated + self.integrals.len()
    }

    fn layout(&self) -> Layout {
        let Dimensions { states, inputs, outputs } = self.size;
        let mut width = states + inputs + outputs;
        let mut observers = Vec::new();
        for fitted in &self.observers {
            let estimate = width + fitted.length;
            observers.push(ObserverLayout { estimate, states: fitted.states.clone() });
            width = estimate + fitted.states.len();
        }
        Layout {
            size: self.size,
            names: self.names.clone(),
            observers,
            integrals: width,
            width: width + self.integrals.len(),
        }
    }

    /// Everything at `t` in one row: x, u, y, then state and estimate of each observer, then the integrals.
    fn row(&self, t: f64, stacked: &[f64], still: &Still, now: &mut Instant, row: &mut Vec<f64>) {
        self.evaluate(t, stacked, still, now);
        row.extend_from_slice(&stacked[..self.size.states]);
        row.extend_from_slice(&now.u);
        row.extend_from_slice(&now.y);
        for k in 0..self.observers.len() {
            row.extend_from_slice(self.state(k, stacked, still));
            row.extend_from_slice(&now.estimates[k]);
        }
        row.extend_from_slice(&stacked[stacked.len() - self.integrals.len()..]);
    }
}

/// Checks that no name occurs twice.
fn unique(names: &[&String]) -> Result<(), SimError> {
    for (k, name) in names.iter().enumerate() {
        if names[..k].contains(name) {
            return Err(SimError::DuplicateName { name: (*name).clone() });
        }
    }
    Ok(())
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

/// A run on its way.
struct Runner<'m, 'a> {
    model: &'m Model<'a>,
    still: Still,
    /// What the sampled-data observers will hold from their next sample on.
    pending: Vec<Vec<f64>>,
    stacked: Vec<f64>,
    now: RefCell<Instant>,
    noise_clock: Option<Periodic>,
    hold_clock: Option<Periodic>,
    sample_clocks: Vec<Option<Periodic>>,
}

impl<'m, 'a> Runner<'m, 'a> {
    /// Starts: noise, input and observers at the initial time.
    fn new(model: &'m Model<'a>) -> Result<Self, SimError> {
        let t = model.start;
        let mut now = model.instant();
        let mut still = Still {
            noise: model.noise.as_ref().map_or_else(|| vec![0.0; model.size.outputs], |noise| noise.sample(0)),
            held: None,
            sampled: vec![Vec::new(); model.observers.len()],
        };
        model.see(t, &model.x0, &still, &mut now);
        check_finite("the output at the start", &now.y)?;
        // The input at the start follows from the estimates that are wished for the start.
        for (k, fitted) in model.observers.iter().enumerate() {
            now.estimates[k].copy_from_slice(&fitted.initial);
            for ((error, estimate), &i) in now.errors[k].iter_mut().zip(&fitted.initial).zip(&fitted.states) {
                *error = model.x0[i] - estimate;
            }
        }
        model.law(t, &model.x0, &mut now);
        check_finite("the input at the start", &now.u)?;
        let mut stacked = vec![0.0; model.stacked_length()];
        stacked[..model.size.states].copy_from_slice(&model.x0);
        for (k, fitted) in model.observers.iter().enumerate() {
            let mut state = vec![0.0; fitted.length];
            fitted.observer.initial(t, &fitted.initial, &now.u, &now.seen, &mut state);
            check_finite(&format!("the initial state of observer {:?}", model.names[k]), &state)?;
            match fitted.period {
                Some(_) => still.sampled[k] = state,
                None => stacked[fitted.offset..fitted.offset + fitted.length].copy_from_slice(&state),
            }
        }
        if model.input.reads_estimates() {
            model.steer(t, &stacked, &still, &mut now);
            let before = now.u.clone();
            model.estimates(t, &stacked, &still, &mut now);
            model.law(t, &stacked, &mut now);
            let change = before.iter().zip(&now.u).fold(0.0f64, |change, (a, b)| change.max((a - b).abs()));
            let size = before.iter().fold(1.0f64, |size, entry| size.max(entry.abs()));
            if change > 1e-9 * size {
                return Err(SimError::AlgebraicLoop { change });
            }
        }
        let clock = |period: f64| Periodic::new(t, period);
        let mut runner = Self {
            model,
            pending: still.sampled.clone(),
            still,
            stacked,
            now: RefCell::new(now),
            noise_clock: model.noise.as_ref().map(|noise| clock(noise.period())),
            hold_clock: model.hold.map(clock),
            sample_clocks: model.observers.iter().map(|fitted| fitted.period.map(clock)).collect(),
        };
        let everybody = vec![true; model.observers.len()];
        runner.jump(t, model.hold.is_some(), &everybody);
        Ok(runner)
    }

    /// New held input, new samples.
    fn jump(&mut self, t: f64, hold: bool, sample: &[bool]) {
        let model = self.model;
        for (k, _) in sample.iter().enumerate().filter(|(_, due)| **due) {
            self.still.sampled[k].clone_from(&self.pending[k]);
        }
        let now = self.now.get_mut();
        if hold {
            self.still.held = None;
            model.evaluate(t, &self.stacked, &self.still, now);
            self.still.held = Some(now.u.clone());
        }
        if sample.contains(&true) {
            model.evaluate(t, &self.stacked, &self.still, now);
        }
        for (k, fitted) in model.observers.iter().enumerate() {
            if sample[k] && fitted.period.is_some() {
                fitted.observer.step(t, &mut self.pending[k], &now.u, &now.seen);
            }
        }
    }

    /// Everything that happens at `t`.
    fn tick(&mut self, t: f64) {
        if let Some(clock) = &mut self.noise_clock
            && clock.happens(t)
            && let Some(noise) = &self.model.noise
        {
            self.still.noise = noise.sample(clock.count);
        }
        let hold = self.hold_clock.as_mut().is_some_and(|clock| clock.happens(t));
        let sample: Vec<bool> =
            self.sample_clocks.iter_mut().map(|clock| clock.as_mut().is_some_and(|clock| clock.happens(t))).collect();
        if hold || sample.contains(&true) {
            self.jump(t, hold, &sample);
        }
    }

    /// When something jumps next after `t`, `end` at the latest.
    fn next_jump(&self, t: f64, end: f64) -> f64 {
        let clocks = [&self.noise_clock, &self.hold_clock].into_iter().chain(&self.sample_clocks).flatten();
        let breakpoint = self.model.breakpoints.iter().copied().find(|&breakpoint| breakpoint > t);
        clocks.map(Periodic::next).chain(breakpoint).fold(end, f64::min)
    }

    fn run(mut self, end: f64) -> Result<Trajectory, SimError> {
        let model = self.model;
        let layout = model.layout();
        let mut dense = Dense::new(layout.width);
        let mut samples = Vec::with_capacity(model.times.len() * layout.width);
        let mut waiting = model.times.iter().copied().peekable();
        let mut march = March::new(model.settings);
        let mut t = model.start;
        while t < end {
            let next = self.next_jump(t, end);
            if next <= t {
                return Err(SimError::StepSize { time: t, step: next - t });
            }
            let seam = next - 8.0 * f64::EPSILON * next.abs();
            let (still, now) = (&self.still, &self.now);
            let right_hand_side = |t: f64, stacked: &[f64], slope: &mut [f64]| {
                model.derivative(t, stacked, still, &mut now.borrow_mut(), slope);
            };
            let mut stacked = std::mem::take(&mut self.stacked);
            march.advance(&right_hand_side, t, next, &mut stacked, &mut |step| {
                let mut now = now.borrow_mut();
                let mut rows = Vec::with_capacity(NODES * layout.width);
                for i in 0..NODES {
                    let t = step.start + node(i) * (step.end - step.start);
                    model.row(t, &step.at(t), still, &mut now, &mut rows);
                }
                check_finite("a quantity of the run", &rows)?;
                dense.push(step.start, step.end, rows);
                // A time at the seam of two intervals, up to rounding, waits for what happens there.
                while let Some(t) = waiting.next_if(|&t| t < step.end.min(seam)) {
                    model.row(t, &step.at(t), still, &mut now, &mut samples);
                }
                Ok(())
            })?;
            self.stacked = stacked;
            t = next;
            self.tick(t);
        }
        for t in waiting {
            model.row(t, &self.stacked, &self.still, self.now.get_mut(), &mut samples);
        }
        let lengths: Vec<usize> = model.observers.iter().map(|fitted| fitted.length).collect();
        let integrals = model.integrals.iter().map(|(name, _)| name.clone()).collect();
        Ok(Trajectory::new(&model.times, &lengths, integrals, layout, &samples, dense, march.steps()))
    }
}
