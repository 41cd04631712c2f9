//! Observers on recorded data: no plant is simulated, and what an observer is judged by is its innovation
//! `y - h(xhat)`.
//!
//! An observer in continuous time is integrated from one sample of the log to the next, with inputs and outputs in
//! between by the recording's rules ([`Recording::new`] says which, and why); a sampled-data observer is stepped at its
//! own period, from the first time of the log on. Its samples should be samples of the log: where they are not, they
//! are taken from in between, and counted. The times of the log need not be equally spaced.
//!
//! The observers are the very objects that run in a [`Scenario`](crate::Scenario) and on the target.

mod filter;
mod innovation;
mod recording;

use luenberger_observers::kalman::ExtendedKalmanFilter;
use luenberger_observers::{Observer, SampledObserver};
use luenberger_plants::{Differentiable, Plant, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{DMatrix, DVector, DefaultAllocator, DimAdd, DimSum, U1};

use crate::erased::{AnyObserver, AnyPlant, Continuous, Erased, Sampled};
use crate::error::{SimError, check, check_finite, check_positive};
use crate::integrate::{Settings, Stepper};
use filter::Filter;

pub use innovation::{Consistency, InnovationStatistics, Whiteness};
pub use recording::Recording;

/// Observers, and the data they are to run on.
///
/// ```
/// use luenberger_observers::LinearObserver;
/// use luenberger_sim::replay::{Recording, Replay};
/// use nalgebra::{DMatrix, Vector2};
///
/// // A mass that was pushed with u = 1 from rest: position t^2/2, every 0.1 s.
/// let t: Vec<f64> = (0..=50).map(|k| 0.1 * f64::from(k)).collect();
/// let y = DMatrix::from_fn(51, 1, |k, _| t[k] * t[k] / 2.0);
/// let recording = Recording::new(t, DMatrix::from_element(51, 1, 1.0), y)?;
/// let plant = luenberger_plants::double_integrator();
/// let observer = LinearObserver::of(plant.clone(), Vector2::new(7.0, 10.0))?;
/// let replayed = Replay::new(plant, recording).observer("linear", observer, &[1.0, 0.0]).run()?;
///
/// let linear = replayed.observer("linear")?;
/// let speed = linear.estimate[(50, 1)];
/// // The straight lines between samples are above the parabola by h^2/12 = 1e-3 on average.
/// assert!((speed - 5.0).abs() < 5e-3 && linear.statistics(3.0)?[0].rms < 5e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Replay<'a> {
    plant: Box<dyn AnyPlant + 'a>,
    recording: Recording,
    observers: Vec<Entry<'a>>,
    settings: Settings,
}

struct Entry<'a> {
    name: String,
    observer: Box<dyn AnyObserver + 'a>,
    initial: Vec<f64>,
    /// Whether the estimate is the whole state, so that h can be evaluated at it.
    whole: bool,
}

/// What observers made of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Replayed {
    /// The observers, in the order they were added.
    pub observers: Vec<ReplayedObserver>,
}

/// What one observer made of a recording. Matrices have one row for each of its times.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplayedObserver {
    /// Its name.
    pub name: String,
    /// The times: those of the log, or the samples of a sampled-data observer.
    pub t: Vec<f64>,
    /// The estimates; at a sample, what is known before it.
    pub estimate: DMatrix<f64>,
    /// `y - h(xhat)`; none for an observer of some states only.
    pub innovation: Option<DMatrix<f64>>,
    /// `nu' S^-1 nu` at each time, of a filter that knows the covariance S of its innovation.
    pub normalised: Option<Vec<f64>>,
    /// How many samples of a sampled-data observer were taken from between those of the log.
    pub interpolated: usize,
    /// Steps the integrator attempted.
    pub steps: usize,
}

impl<'a> Replay<'a> {
    /// A replay of the recording; the plant is asked for h only.
    pub fn new(plant: impl Plant<f64> + 'a, recording: Recording) -> Self {
        let settings = Settings { rtol: 1e-9, ..Settings::default() };
        Self { plant: Box::new(Erased(plant)), recording, observers: Vec::new(), settings }
    }

    /// An observer in continuous time, with its estimate at the first time of the log.
    #[must_use]
    pub fn observer(self, name: &str, observer: impl Observer<f64> + 'a, initial: &[f64]) -> Self {
        self.entry(name, Box::new(Continuous(observer)), initial, true)
    }

    /// An observer of some states; it has no innovation.
    #[must_use]
    pub fn partial_observer(self, name: &str, observer: impl Observer<f64> + 'a, initial: &[f64]) -> Self {
        self.entry(name, Box::new(Continuous(observer)), initial, false)
    }

    /// A sampled-data observer, with its estimate at the first time of the log, which is its first sample.
    #[must_use]
    pub fn sampled_observer(self, name: &str, observer: impl SampledObserver<f64> + 'a, initial: &[f64]) -> Self {
        self.entry(name, Box::new(Sampled(observer)), initial, true)
    }

    /// A sampled-data observer of some states; it has no innovation.
    #[must_use]
    pub fn partial_sampled_observer(
        self,
        name: &str,
        observer: impl SampledObserver<f64> + 'a,
        initial: &[f64],
    ) -> Self {
        self.entry(name, Box::new(Sampled(observer)), initial, false)
    }

    /// A Kalman filter, whose innovations are compared with the covariance that it believes they have.
    #[must_use]
    pub fn filter<S, N, M, P>(self, name: &str, filter: ExtendedKalmanFilter<S, f64, N, M, P>, initial: &[f64]) -> Self
    where
        S: Differentiable<f64, N, M, P> + 'a,
        N: DimAdd<U1>,
        M: nalgebra::Dim,
        P: nalgebra::Dim,
        DefaultAllocator: Size<N, M, P> + Allocator<N, DimSum<N, U1>>,
    {
        self.entry(name, Box::new(Filter(filter)), initial, true)
    }

    /// Method, tolerances and caps for observers in continuous time (default rtol 1e-9 and atol 1e-12), far below what
    /// is lost between samples.
    #[must_use]
    pub fn settings(mut self, settings: Settings) -> Self {
        self.settings = settings;
        self
    }

    fn entry(mut self, name: &str, observer: Box<dyn AnyObserver + 'a>, initial: &[f64], whole: bool) -> Self {
        self.observers.push(Entry { name: name.to_owned(), observer, initial: initial.to_vec(), whole });
        self
    }

    /// Runs.
    ///
    /// # Errors
    /// What does not fit: [`SimError::Length`], [`SimError::NotFinite`], [`SimError::NotPositive`],
    /// [`SimError::DuplicateName`]. What happens on the way: the errors with
    /// [`SimError::ends_run`].
    pub fn run(self) -> Result<Replayed, SimError> {
        self.settings.check()?;
        self.plant.check()?;
        self.recording.check(self.plant.dimensions())?;
        let mut observers: Vec<ReplayedObserver> = Vec::with_capacity(self.observers.len());
        for entry in &self.observers {
            if observers.iter().any(|other| other.name == entry.name) {
                return Err(SimError::DuplicateName { name: entry.name.clone() });
            }
            observers.push(self.run_one(entry)?);
        }
        Ok(Replayed { observers })
    }

    fn run_one(&self, entry: &Entry<'a>) -> Result<ReplayedObserver, SimError> {
        let (size, own) = (self.plant.dimensions(), entry.observer.dimensions());
        let name = &entry.name;
        entry.observer.check()?;
        let expect = |what: &str, expected: usize, found: usize| {
            let what = format!("{what} of observer {name:?}");
            if expected == found { Ok(()) } else { Err(SimError::Length { what, expected, found }) }
        };
        expect("the input", size.inputs, own.inputs)?;
        expect("the output", size.outputs, own.outputs)?;
        if entry.whole {
            expect("the estimate", size.states, own.estimate)?;
        }
        check(&format!("the initial estimate of observer {name:?}"), &entry.initial, own.estimate)?;
        let mut log = Log::new(self, entry);
        let start = self.recording.times()[0];
        log.read(0, start);
        let mut state = vec![0.0; own.state];
        entry.observer.initial(start, &entry.initial, &log.u, &log.y, &mut state);
        check_finite(&format!("the initial state of observer {name:?}"), &state)?;
        match entry.observer.period() {
            Some(period) => log.step(state, period)?,
            None => log.integrate(state)?,
        }
        Ok(log.finish())
    }
}

/// One observer on its way through the recording.
struct Log<'r, 'a> {
    replay: &'r Replay<'a>,
    entry: &'r Entry<'a>,
    u: Vec<f64>,
    y: Vec<f64>,
    t: Vec<f64>,
    estimates: Vec<f64>,
    innovations: Vec<f64>,
    normalised: Option<Vec<f64>>,
    interpolated: usize,
    steps: usize,
}

impl<'r, 'a> Log<'r, 'a> {
    fn new(replay: &'r Replay<'a>, entry: &'r Entry<'a>) -> Self {
        let size = replay.plant.dimensions();
        Self {
            replay,
            entry,
            u: vec![0.0; size.inputs],
            y: vec![0.0; size.outputs],
            t: Vec::new(),
            estimates: Vec::new(),
            innovations: Vec::new(),
            normalised: Some(Vec::new()),
            interpolated: 0,
            steps: 0,
        }
    }

    /// Input and output at `t` by what holds from sample k of the log to the next.
    fn read(&mut self, k: usize, t: f64) {
        self.replay.recording.inputs().on(k, t, &mut self.u);
        self.replay.recording.outputs().on(k, t, &mut self.y);
    }

    /// Notes estimate and innovation at `t`, for the input and output that were read.
    fn note(&mut self, t: f64, state: &[f64]) -> Result<(), SimError> {
        let own = self.entry.observer.dimensions();
        let mut estimate = vec![0.0; own.estimate];
        self.entry.observer.estimate(t, state, &self.u, &self.y, &mut estimate);
        check_finite(&format!("the estimate of observer {:?} at t = {t}", self.entry.name), &estimate)?;
        self.t.push(t);
        if self.entry.whole {
            let mut expected = vec![0.0; own.outputs];
            self.replay.plant.output(t, &estimate, &self.u, &mut expected);
            let innovation: Vec<f64> = self.y.iter().zip(&expected).map(|(y, h)| y - h).collect();
            check_finite(&format!("the innovation of observer {:?} at t = {t}", self.entry.name), &innovation)?;
            let squared = self.entry.observer.innovation_covariance(t, state, &self.u).and_then(|s| {
                let nu = DVector::from_column_slice(&innovation);
                Some(nu.dot(&s.cholesky()?.solve(&nu)))
            });
            match (squared, &mut self.normalised) {
                (Some(squared), Some(normalised)) => normalised.push(squared),
                _ => self.normalised = None,
            }
            self.innovations.extend(innovation);
        } else {
            self.normalised = None;
        }
        self.estimates.extend(estimate);
        Ok(())
    }

    /// An observer in continuous time, from sample to sample of the log.
    fn integrate(&mut self, mut state: Vec<f64>) -> Result<(), SimError> {
        let replay = self.replay;
        let (recording, observer) = (&replay.recording, &self.entry.observer);
        let times = recording.times();
        let mut march = Stepper::new(replay.settings);
        self.note(times[0], &state)?;
        for (k, pair) in times.windows(2).enumerate() {
            let (inputs, outputs) = (self.u.len(), self.y.len());
            let right_hand_side = |t: f64, state: &[f64], slope: &mut [f64]| {
                let (mut u, mut y) = (vec![0.0; inputs], vec![0.0; outputs]);
                recording.inputs().on(k, t, &mut u);
                recording.outputs().on(k, t, &mut y);
                observer.derivative(t, state, &u, &y, slope);
            };
            march.advance(&right_hand_side, pair[0], pair[1], &mut state, &mut |_| Ok(()))?;
            self.read(k + 1, pair[1]);
            self.note(pair[1], &state)?;
        }
        self.steps = march.steps();
        Ok(())
    }

    /// A sampled-data observer at its own period.
    fn step(&mut self, mut state: Vec<f64>, period: f64) -> Result<(), SimError> {
        check_positive("the period of a sampled-data observer", period)?;
        let times = self.replay.recording.times();
        let (start, end) = (times[0], times[times.len() - 1]);
        // Bounded: no more samples than fit, and a log of 1e9 of them is none that anybody has recorded.
        let samples = (((end - start) / period + 1e-9).floor() as usize).min(1_000_000_000);
        for j in 0..=samples {
            let t = start + j as f64 * period;
            if let Some(k) = self.replay.recording.inputs().sample_at(t, period) {
                self.read(k, times[k]);
            } else {
                self.interpolated += 1;
                self.read(times.partition_point(|&sample| sample <= t).saturating_sub(1), t);
            }
            self.note(t, &state)?;
            self.entry.observer.step(t, &mut state, &self.u, &self.y);
            check_finite(&format!("the state of observer {:?} after the sample at t = {t}", self.entry.name), &state)?;
        }
        Ok(())
    }

    fn finish(self) -> ReplayedObserver {
        let own = self.entry.observer.dimensions();
        let rows = self.t.len();
        ReplayedObserver {
            name: self.entry.name.clone(),
            estimate: DMatrix::from_row_slice(rows, own.estimate, &self.estimates),
            innovation: self.entry.whole.then(|| DMatrix::from_row_slice(rows, own.outputs, &self.innovations)),
            normalised: self.normalised,
            interpolated: self.interpolated,
            steps: self.steps,
            t: self.t,
        }
    }
}

impl Replayed {
    /// The observer of that name.
    ///
    /// # Errors
    /// [`SimError::UnknownName`].
    pub fn observer(&self, name: &str) -> Result<&ReplayedObserver, SimError> {
        let found = self.observers.iter().find(|observer| observer.name == name);
        found.ok_or_else(|| SimError::UnknownName { name: name.to_owned() })
    }
}

impl ReplayedObserver {
    /// The statistics of the innovation of each output from the time `from` on, which leaves out how the estimate came
    /// in.
    ///
    /// Whiteness counts lags in samples; of a log that is not equally spaced it says little.
    ///
    /// # Errors
    /// [`SimError::Outside`] when nothing is left.
    pub fn statistics(&self, from: f64) -> Result<Vec<InnovationStatistics>, SimError> {
        let first = self.first(from)?;
        let columns = self.innovation.as_ref().map_or(0, DMatrix::ncols);
        let column = |j: usize| -> Vec<f64> {
            self.innovation.iter().flat_map(|nu| nu.column(j).iter().skip(first).copied().collect::<Vec<_>>()).collect()
        };
        Ok((0..columns).filter_map(|j| innovation::statistics(&column(j))).collect())
    }

    /// Whether the innovations of a filter have, from the time `from` on, the covariance that it believes in; none for
    /// other observers.
    ///
    /// # Errors
    /// [`SimError::Outside`] when nothing is left.
    pub fn consistency(&self, from: f64) -> Result<Option<Consistency>, SimError> {
        let first = self.first(from)?;
        let outputs = self.innovation.as_ref().map_or(0, DMatrix::ncols);
        Ok(self.normalised.as_ref().and_then(|normalised| innovation::consistency(&normalised[first..], outputs)))
    }

    /// The first row at or after `from`.
    fn first(&self, from: f64) -> Result<usize, SimError> {
        let outside = || SimError::Outside {
            time: from,
            start: self.t.first().copied().unwrap_or(f64::NAN),
            end: self.t.last().copied().unwrap_or(f64::NAN),
        };
        self.t.iter().position(|&t| t >= from).ok_or_else(outside)
    }
}
