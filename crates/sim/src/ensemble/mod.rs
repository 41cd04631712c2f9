//! Ensembles: one plant and one observer from many initial states, with many realisations of the noise.
//!
//! Eight runs are integrated at once, each in its own lane with its own steps and error control; a lane that has
//! finished takes the next run. Every run is bitwise equal to that of a [`Scenario`] with the same plant, observer,
//! input and noise: it depends neither on the other runs nor on their number. Members may be divided among threads
//! in any way.
//!
//! Runs that a lane cannot handle (stiff runs, runs that end early) are computed by a scenario instead.

mod lanes;

use std::cell::RefCell;
use std::sync::Arc;

use luenberger_observers::{LaneObserver, Observer};
use luenberger_plants::{LanePlant, Plant};
use luenberger_random::{Purpose, Stream};
use nalgebra::DMatrix;

use self::lanes::{Attempted, Dop853Lanes, Field, LANES, Lanes};
use crate::dop853::{BORDER, STIFF};
use crate::error::SimError;
use crate::integrate::{Integrator, Settings, first_step};
use crate::noise::Noise;
use crate::scenario::{Scenario, equally_spaced};
use crate::signal::Signal;
use crate::step::Tolerance;

/// A function of time that writes the input.
type Input<'a> = Arc<dyn Fn(f64, &mut [f64]) + Send + Sync + 'a>;

/// What distinguishes a run of an ensemble.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// The plant's state at the start.
    pub x0: Vec<f64>,
    /// The estimate at the start.
    pub estimate: Vec<f64>,
    /// Its number: members of different numbers have independent noise, whatever the seed of the noise is.
    pub number: u64,
}

/// A run of an ensemble: one row per requested time.
#[derive(Clone, Debug, PartialEq)]
pub struct EnsembleRun {
    /// States of the plant.
    pub x: DMatrix<f64>,
    /// Estimates.
    pub estimate: DMatrix<f64>,
    /// Steps the integrator attempted.
    pub steps: usize,
}

impl EnsembleRun {
    /// The errors `x - xhat`.
    pub fn error(&self) -> DMatrix<f64> {
        &self.x - &self.estimate
    }
}

/// One plant and one observer, with what their runs have in common.
///
/// ```
/// use luenberger_observers::CubicObserver;
/// use luenberger_sim::{Ensemble, Member};
/// use nalgebra::{Matrix1, Vector2};
/// let plant = luenberger_plants::double_integrator();
/// let (l, n) = (Vector2::new(7.0, 10.0), Vector2::new(-168.0, -196.0) / 17.0);
/// let observer = CubicObserver::of(plant.clone(), l, n, Matrix1::new(10.0))?;
/// let members: Vec<Member> = (0..20)
///     .map(|k| Member { x0: vec![3.0 - 0.3 * f64::from(k), 1.0], estimate: vec![0.0, 0.0], number: 0 })
///     .collect();
/// let runs = Ensemble::new(&plant, &observer).input(|t, u| u.fill(t.sin())).until(8.0, 5).run(&members);
/// for run in runs {
///     assert!(run?.error().row(4).norm() < 1e-3);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Ensemble<'a, P, O> {
    plant: P,
    observer: O,
    input: Option<Input<'a>>,
    noise: Option<Noise>,
    start: f64,
    times: Vec<f64>,
    settings: Settings,
}

impl<'a, P, O> Ensemble<'a, P, O>
where
    P: Plant<f64> + LanePlant + Sync,
    O: Observer<f64> + LaneObserver + Sync,
{
    /// Runs of this plant with this observer, without input, from t = 0.
    pub fn new(plant: P, observer: O) -> Self {
        let settings = Settings::default();
        Self { plant, observer, input: None, noise: None, start: 0.0, times: Vec::new(), settings }
    }

    /// `f(t, u)` writes the input at time t into `u` (default zero).
    #[must_use]
    pub fn input(mut self, f: impl Fn(f64, &mut [f64]) + Send + Sync + 'a) -> Self {
        self.input = Some(Arc::new(f));
        self
    }

    /// Noise on the outputs that the observer sees; each member has its own realisation.
    #[must_use]
    pub fn noise(mut self, noise: Noise) -> Self {
        self.noise = Some(noise);
        self
    }

    /// The times at which the runs are wanted, increasing; the last one ends them.
    #[must_use]
    pub fn times(mut self, times: &[f64]) -> Self {
        self.times = times.to_vec();
        self
    }

    /// Sets the end of the runs and `samples` equally spaced times from the start to `end`, both included: at least 2.
    #[must_use]
    pub fn until(mut self, end: f64, samples: usize) -> Self {
        self.times = equally_spaced(self.start, end, samples).unwrap_or_default();
        self
    }

    /// Method, tolerances and caps.
    #[must_use]
    pub fn settings(mut self, settings: Settings) -> Self {
        self.settings = settings;
        self
    }

    /// The runs of the members, in their order.
    ///
    /// # Errors
    /// Of each run, those of [`Scenario::run`].
    pub fn run(&self, members: &[Member]) -> Vec<Result<EnsembleRun, SimError>> {
        let in_lanes = if self.fits() { InLanes::new(self).run(members) } else { vec![None; members.len()] };
        let alone = |(run, member): (Option<EnsembleRun>, &Member)| match run {
            Some(run) => Ok(run),
            None => self.alone(member),
        };
        in_lanes.into_iter().zip(members).map(alone).collect()
    }

    /// A run by itself.
    fn alone(&self, member: &Member) -> Result<EnsembleRun, SimError> {
        let mut scenario = Scenario::new(&self.plant)
            .initial_state(&member.x0)
            .start(self.start)
            .times(&self.times)
            .settings(self.settings)
            .observer("observer", &self.observer, &member.estimate);
        if let Some(input) = &self.input {
            scenario = scenario.input(Signal::function(|t, u| input(t, u)));
        }
        if let Some(noise) = &self.noise {
            scenario = scenario.noise(noise.clone()).member(member.number);
        }
        let mut run = scenario.run()?;
        let estimate = run.observers.remove(0).estimate;
        Ok(EnsembleRun { x: run.x, estimate, steps: run.steps })
    }

    /// The end of the runs.
    fn end(&self) -> f64 {
        self.times.last().copied().unwrap_or(self.start)
    }

    /// Whether runs can be made in lanes; what is wrong is said by a run alone.
    fn fits(&self) -> bool {
        let (plant, observer) = (self.plant.dimensions(), self.observer.dimensions());
        let sizes = (plant.inputs, plant.outputs, plant.states, plant.states);
        let sorted = self.times.windows(2).all(|pair| pair[0] < pair[1]);
        self.settings.check().is_ok()
            && self.settings.integrator != Integrator::Implicit
            && sizes == (observer.inputs, observer.outputs, observer.estimate, observer.state)
            && self.noise.as_ref().is_none_or(|noise| noise.check(plant.outputs).is_ok())
            && self.times.iter().all(|t| t.is_finite())
            && self.times.first().is_some_and(|first| *first >= self.start)
            && self.times.last().is_some_and(|last| *last > self.start)
            && sorted
    }
}

/// A lane with a run.
struct Lane<'a> {
    member: usize,
    /// With the stream of the member.
    noise: Option<(&'a Noise, Stream)>,
    /// The start of the run.
    start: f64,
    /// How often the noise has changed since then.
    count: u64,
    /// Where the present interval ends.
    until: f64,
    /// Step size to go on with.
    h: Option<f64>,
    /// What the step that is attempted was proposed as, and whether it ends the interval.
    proposed: f64,
    last: bool,
    steps: usize,
    at_border: usize,
    off_border: usize,
    /// The requested times that have not been reached.
    waiting: &'a [f64],
    rows: Vec<f64>,
}

/// Runs in lanes.
struct InLanes<'e, 'a, P, O> {
    ensemble: &'e Ensemble<'a, P, O>,
    tolerance: Tolerance,
    /// Number of states of the plant, and of the observer.
    states: usize,
    method: Dop853Lanes,
    lanes: [Option<Lane<'e>>; LANES],
    /// Added to the outputs.
    noise: Vec<Lanes>,
}

/// Plant and observer over lanes.
struct Stacked<'s, 'a, P, O> {
    ensemble: &'s Ensemble<'a, P, O>,
    states: usize,
    noise: &'s [Lanes],
    scratch: &'s RefCell<Scratch>,
}

/// Inputs and outputs of all lanes, and the inputs of one.
struct Scratch {
    u: Vec<Lanes>,
    y: Vec<Lanes>,
    one: Vec<f64>,
}

impl<P: LanePlant, O: LaneObserver> Field for Stacked<'_, '_, P, O> {
    #[inline(always)]
    #[allow(clippy::inline_always, reason = "it is compiled for other instructions where it is inlined only")]
    fn slope(&self, t: &Lanes, stacked: &[Lanes], slope: &mut [Lanes]) {
        let Scratch { u, y, one } = &mut *self.scratch.borrow_mut();
        if let Some(input) = &self.ensemble.input {
            for lane in 0..LANES {
                input(t[lane], one);
                for (u, one) in u.iter_mut().zip(&*one) {
                    u[lane] = *one;
                }
            }
        }
        let (x, xhat) = stacked.split_at(self.states);
        let (of_plant, of_observer) = slope.split_at_mut(self.states);
        self.ensemble.plant.output_lanes(t, x, u, y);
        for (y, noise) in y.iter_mut().zip(self.noise) {
            for lane in 0..LANES {
                y[lane] += noise[lane];
            }
        }
        self.ensemble.plant.derivative_lanes(t, x, u, of_plant);
        self.ensemble.observer.derivative_lanes(t, xhat, u, y, of_observer);
    }
}

/// An attempt, compiled for the vector instructions that there are.
struct Attempt<'m, F> {
    method: &'m mut Dop853Lanes,
    f: F,
    tolerance: Tolerance,
}

impl<F: Field> pulp::WithSimd for Attempt<'_, F> {
    type Output = [Attempted; LANES];

    #[inline(always)]
    #[allow(clippy::inline_always, reason = "it is compiled for other instructions where it is inlined only")]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Self::Output {
        self.method.attempt(&self.f, self.tolerance)
    }
}

impl<'e, 'a, P, O> InLanes<'e, 'a, P, O>
where
    P: Plant<f64> + LanePlant + Sync,
    O: Observer<f64> + LaneObserver + Sync,
{
    fn new(ensemble: &'e Ensemble<'a, P, O>) -> Self {
        let size = ensemble.plant.dimensions();
        Self {
            ensemble,
            tolerance: ensemble.settings.tolerance(),
            states: size.states,
            method: Dop853Lanes::new(2 * size.states),
            lanes: std::array::from_fn(|_| None),
            noise: vec![[0.0; LANES]; size.outputs],
        }
    }

    /// The runs that are finished in lanes.
    fn run(mut self, members: &[Member]) -> Vec<Option<EnsembleRun>> {
        let ensemble = self.ensemble;
        let inputs = ensemble.plant.dimensions().inputs;
        let (u, one) = (vec![[0.0; LANES]; inputs], vec![0.0; inputs]);
        let scratch = RefCell::new(Scratch { u, y: self.noise.clone(), one });
        let mut finished: Vec<Option<EnsembleRun>> = vec![None; members.len()];
        let mut waiting = members.iter().enumerate();
        let arch = pulp::Arch::new();
        let mut begins = [true; LANES];
        loop {
            for (lane, begins) in begins.iter_mut().enumerate() {
                if self.lanes[lane].is_none() {
                    *begins = self.take(lane, &mut waiting);
                }
            }
            if self.lanes.iter().all(Option::is_none) {
                return finished;
            }
            let Self { states, .. } = self;
            if begins.contains(&true) {
                let mut slope = std::mem::take(&mut self.method.received);
                let field = Stacked { ensemble, states, noise: &self.noise, scratch: &scratch };
                field.slope(&self.method.t, &self.method.y, &mut slope);
                for lane in (0..LANES).filter(|&lane| begins[lane]) {
                    self.begin(lane, &slope);
                }
                self.method.received = slope;
            }
            for lane in 0..LANES {
                self.propose(lane);
            }
            let f = Stacked { ensemble, states, noise: &self.noise, scratch: &scratch };
            let outcomes = arch.dispatch(Attempt { method: &mut self.method, f, tolerance: self.tolerance });
            for (lane, outcome) in outcomes.into_iter().enumerate() {
                begins[lane] = self.after(lane, outcome, &mut finished);
            }
        }
    }

    /// Puts the next member into a lane; whether there is one.
    fn take<'m>(&mut self, lane: usize, members: &mut impl Iterator<Item = (usize, &'m Member)>) -> bool {
        let Ensemble { noise, start, times, .. } = self.ensemble;
        let n = self.states;
        let fits = |(_, member): &(usize, &Member)| {
            let entries = member.x0.iter().chain(&member.estimate);
            (member.x0.len(), member.estimate.len()) == (n, n) && entries.clone().all(|entry| entry.is_finite())
        };
        let Some((number, member)) = members.find(fits) else { return false };
        for (y, entry) in self.method.y.iter_mut().zip(member.x0.iter().chain(&member.estimate)) {
            y[lane] = *entry;
        }
        let mut next = Lane {
            member: number,
            noise: noise
                .as_ref()
                .map(|noise| (noise, noise.stream(Purpose::MeasurementNoise, 0).member(member.number))),
            start: *start,
            count: 0,
            until: *start,
            h: None,
            proposed: 0.0,
            last: false,
            steps: 0,
            at_border: 0,
            off_border: 0,
            waiting: times,
            rows: Vec::with_capacity(times.len() * 2 * n),
        };
        self.method.t[lane] = *start;
        next.interval(lane, &mut self.noise, self.ensemble.end());
        self.lanes[lane] = Some(next);
        true
    }

    /// Starts the integration of an interval, with the slopes at its start.
    fn begin(&mut self, lane: usize, slopes: &[Lanes]) {
        let Some(run) = &mut self.lanes[lane] else { return };
        if !slopes.iter().all(|slope| slope[lane].is_finite()) {
            self.lanes[lane] = None;
            return;
        }
        for (slope, found) in self.method.slope.iter_mut().zip(slopes) {
            slope[lane] = found[lane];
        }
        let of_lane = |columns: &[Lanes]| columns.iter().map(|entry| entry[lane]).collect::<Vec<f64>>();
        let start = self.method.t[lane];
        let first = || first_step(&of_lane(&self.method.y), &of_lane(slopes), self.tolerance);
        let h = run.h.unwrap_or_else(first).min(self.ensemble.settings.max_step).min(run.until - start);
        (run.at_border, run.off_border) = (0, 0);
        self.method.restart(lane, start, h);
    }

    /// Sets the size of the next step; a run that needs more than that leaves its lane.
    fn propose(&mut self, lane: usize) {
        let settings = &self.ensemble.settings;
        let Some(run) = &mut self.lanes[lane] else {
            // What an empty lane computes has no effect.
            self.method.h[lane] = 0.0;
            return;
        };
        let t = self.method.t[lane];
        let rest = run.until - t;
        run.proposed = self.method.h[lane].min(settings.max_step);
        run.last = run.proposed * 1.001 >= rest;
        let h = if run.last { rest } else { run.proposed };
        let goes_on = run.last || h > 8.0 * f64::EPSILON * t.abs().max(f64::MIN_POSITIVE);
        if !goes_on || run.steps >= settings.max_steps || settings.check_time(t).is_err() {
            self.lanes[lane] = None;
            return;
        }
        run.steps += 1;
        self.method.h[lane] = h;
    }

    /// Goes on after an attempt; whether an interval begins.
    fn after(&mut self, lane: usize, outcome: Attempted, finished: &mut [Option<EnsembleRun>]) -> bool {
        let Self { ensemble, method, .. } = self;
        let Some(run) = &mut self.lanes[lane] else { return false };
        let mut begins = false;
        if outcome == Attempted::Accepted {
            run.watch(method.h_lambda[lane]);
            run.h = Some(if run.last { method.h[lane].max(run.proposed) } else { method.h[lane] });
            if largest_of(&method.y, lane) > 1e100 {
                self.lanes[lane] = None;
                return false;
            }
            let step_end = if run.last { run.until } else { method.t[lane] };
            // A time at the seam of two intervals, up to rounding, waits for what happens there.
            let seam = run.until - 8.0 * f64::EPSILON * run.until.abs();
            while let Some((t, rest)) = run.waiting.split_first().filter(|(t, _)| **t < step_end.min(seam)) {
                method.interpolate(lane, *t, &mut run.rows);
                run.waiting = rest;
            }
            if run.last {
                method.t[lane] = run.until;
                if run.until >= ensemble.end() {
                    for _ in run.waiting {
                        run.rows.extend(method.y.iter().map(|entry| entry[lane]));
                    }
                    finished[run.member] = Some(run.finish(self.states));
                    self.lanes[lane] = None;
                    return false;
                }
                run.interval(lane, &mut self.noise, ensemble.end());
                begins = true;
            }
        }
        let spent = run.steps > ensemble.settings.max_steps / 2;
        if ensemble.settings.integrator == Integrator::Auto && (spent || run.at_border >= STIFF) {
            self.lanes[lane] = None;
            return false;
        }
        begins
    }
}

impl Lane<'_> {
    /// The noise of the next interval, and where it ends.
    fn interval(&mut self, lane: usize, lanes: &mut [Lanes], end: f64) {
        let start = self.until;
        self.until = end;
        if let Some((noise, stream)) = self.noise {
            let next = |count: u64| self.start + (count + 1) as f64 * noise.period();
            if start > self.start {
                self.count += u64::from(next(self.count) <= start + 1e-9 * noise.period());
            }
            self.until = next(self.count).min(end);
            for (of_lanes, value) in lanes.iter_mut().zip(noise.values(stream, self.count)) {
                of_lanes[lane] = value;
            }
        }
    }

    /// Counts the steps at the border of stability.
    fn watch(&mut self, h_lambda: f64) {
        if h_lambda > BORDER {
            self.off_border = 0;
            self.at_border += 1;
        } else {
            self.off_border += 1;
            if self.off_border >= 6 {
                self.at_border = 0;
            }
        }
    }

    fn finish(&mut self, n: usize) -> EnsembleRun {
        let (rows, width) = (std::mem::take(&mut self.rows), 2 * n);
        let block = |offset: usize| DMatrix::from_fn(rows.len() / width, n, |i, j| rows[i * width + offset + j]);
        EnsembleRun { x: block(0), estimate: block(n), steps: self.steps }
    }
}

fn largest_of(columns: &[Lanes], lane: usize) -> f64 {
    columns.iter().fold(0.0, |largest: f64, entry| largest.max(entry[lane].abs()))
}
