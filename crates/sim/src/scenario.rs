//! A scenario: one plant, any number of observers, an input, noise, and the requested times.

use std::sync::Arc;

use luenberger_observers::{ContinuousDiscreteObserver, Observer, SampledObserver};
use luenberger_plants::Plant;
use nalgebra::DMatrix;

use crate::change::Change;
use crate::disturbance::Disturbances;
use crate::erased::{AnyObserver, AnyPlant, Continuous, Erased, Sampled};
use crate::error::{SimError, check_finite, check_positive};
use crate::integral::Integrand;
use crate::integrate::{Integrator, Settings};
use crate::noise::Noise;
use crate::sample_times::SampleTimes;
use crate::sensor::Sensor;
use crate::signal::Signal;

/// The setup of a run: a plant, observers, an input, noise, times and settings.
///
/// Nothing is checked before [`run`](Self::run), which reports the first error.
///
/// Plants, observers and closures are `Send` and `Sync`, so that copies run in threads:
/// ```
/// use luenberger_observers::LinearObserver;
/// use luenberger_sim::{Noise, Scenario};
/// use nalgebra::Vector2;
/// let plant = luenberger_plants::double_integrator();
/// let scenario = Scenario::new(plant.clone())
///     .observer("linear", LinearObserver::of(plant, Vector2::new(7.0, 10.0))?, &[1.0, 0.0])
///     .until(5.0, 2);
/// let of_seed = |seed| scenario.clone().noise(Noise::gaussian(&[0.01], 0.01, seed)).run()?.rmse("linear");
/// let rmse: Vec<_> = std::thread::scope(|scope| {
///     let runs = [1, 2].map(|seed| scope.spawn(move || of_seed(seed)));
///     runs.into_iter().map(|run| run.join().expect("no panic")).collect::<Result<_, _>>()
/// })?;
/// assert!(rmse[0] != rmse[1] && rmse[0] < 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scenario<'a> {
    pub(crate) plant: Arc<dyn AnyPlant + 'a>,
    /// The plant as the observers take it, if it is another.
    pub(crate) model: Option<Arc<dyn AnyPlant + 'a>>,
    pub(crate) changes: Vec<Change<'a>>,
    pub(crate) x0: Option<Vec<f64>>,
    /// The full turns of the states that are angles, 0 of the others; empty without angles.
    pub(crate) turns: Vec<f64>,
    pub(crate) start: f64,
    pub(crate) times: Vec<f64>,
    /// End and number of equally spaced times, if that is how they are wanted.
    span: Option<(f64, usize)>,
    pub(crate) input: Signal<'a>,
    pub(crate) hold: Option<f64>,
    pub(crate) step: Option<f64>,
    pub(crate) noise: Option<Noise>,
    pub(crate) sensors: Vec<Sensor>,
    pub(crate) measurements_are_held: bool,
    pub(crate) member: u64,
    pub(crate) disturbances: Disturbances,
    pub(crate) observers: Vec<Entry<'a>>,
    pub(crate) integrals: Vec<(String, Integrand<'a>)>,
    pub(crate) breakpoints: Vec<f64>,
    pub(crate) settings: Settings,
}

#[derive(Clone, Debug)]
pub(crate) struct Entry<'a> {
    pub(crate) name: String,
    pub(crate) observer: Arc<dyn AnyObserver + 'a>,
    pub(crate) initial: Vec<f64>,
    pub(crate) of: Estimated,
}

/// What an observer estimates.
#[derive(Clone, Debug)]
pub(crate) enum Estimated {
    /// The whole state.
    State,
    /// Some states, from 0.
    States(Vec<usize>),
    /// K x.
    Functions(DMatrix<f64>),
}

impl<'a> Scenario<'a> {
    /// A scenario with this plant, at rest in the origin, without input, from t = 0.
    pub fn new(plant: impl Plant<f64> + Send + Sync + 'a) -> Self {
        Self {
            plant: Arc::new(Erased(plant)),
            model: None,
            changes: Vec::new(),
            x0: None,
            turns: Vec::new(),
            start: 0.0,
            times: Vec::new(),
            span: None,
            input: Signal::zero(),
            hold: None,
            step: None,
            noise: None,
            sensors: Vec::new(),
            measurements_are_held: false,
            member: 0,
            disturbances: Disturbances::default(),
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

    /// The full turn of each state that is an angle, in its unit (2 pi or 360), and 0 for the others: errors and their
    /// scores are [wrapped](luenberger_plants::wrap()) into half a turn to either side.
    ///
    /// ```
    /// use luenberger_observers::LinearObserver;
    /// use luenberger_sim::Scenario;
    /// use nalgebra::Vector2;
    /// let plant = luenberger_plants::double_integrator();
    /// let observer = LinearObserver::of(plant.clone(), Vector2::new(7.0, 10.0))?;
    /// let run = Scenario::new(plant)
    ///     .angles(&[360.0, 0.0])
    ///     .initial_state(&[359.0, 0.0])
    ///     .observer("linear", observer, &[1.0, 0.0])
    ///     .until(0.01, 2)
    ///     .run()?;
    /// assert_eq!(run.observer("linear")?.error[(0, 0)], -2.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn angles(mut self, turns: &[f64]) -> Self {
        self.turns = turns.to_vec();
        self
    }

    /// The time of the start (default 0).
    #[must_use]
    pub fn start(mut self, t: f64) -> Self {
        self.start = t;
        self
    }

    /// The times at which the trajectory is wanted, increasing; the last one ends the run.
    #[must_use]
    pub fn times(mut self, times: &[f64]) -> Self {
        (self.times, self.span) = (times.to_vec(), None);
        self
    }

    /// Sets the end of the run, with `samples` equally spaced times from the start to `end`, both included: at least 2.
    #[must_use]
    pub fn until(mut self, end: f64, samples: usize) -> Self {
        self.span = Some((end, samples));
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

    /// The plant is in discrete time with this period: its `derivative` is the next state, `x+ = f(t, x, u)`, the input
    /// is evaluated at the samples and held, and observers are sampled ones.
    ///
    /// ```
    /// use luenberger_plants::StaticPlant;
    /// use luenberger_sim::Scenario;
    /// use nalgebra::{Matrix1, SMatrix};
    /// // x+ = x/2 every 0.1.
    /// let plant = StaticPlant::new(Matrix1::new(0.5), SMatrix::<f64, 1, 0>::zeros(), Matrix1::new(1.0))?;
    /// let run = Scenario::new(plant).discrete_time(0.1).initial_state(&[8.0]).times(&[0.0, 0.1, 0.25, 0.3]).run()?;
    /// assert_eq!(run.x.as_slice(), [8.0, 4.0, 2.0, 1.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn discrete_time(mut self, period: f64) -> Self {
        (self.step, self.hold) = (Some(period), Some(period));
        self
    }

    /// Times at which the input or the plant jumps, so that no step crosses them.
    #[must_use]
    pub fn breakpoints(mut self, times: &[f64]) -> Self {
        self.breakpoints.extend_from_slice(times);
        self
    }

    /// Noise on the outputs that the observers read; not on outputs with a [`sensor`](Self::sensor).
    #[must_use]
    pub fn noise(mut self, noise: Noise) -> Self {
        self.noise = Some(noise);
        self
    }

    /// A sensor that samples one output with its own period and noise.
    #[must_use]
    pub fn sensor(mut self, sensor: Sensor) -> Self {
        self.sensors.push(sensor);
        self
    }

    /// Observers in continuous time hold the measurement of a sensor until its next one, late by half a period on
    /// average; without this it moves with the model of the plant ([`sensor`](crate::sensor)).
    #[must_use]
    pub fn hold_measurements(self) -> Self {
        Self { measurements_are_held: true, ..self }
    }

    /// The number of the run in its ensemble (default 0). It belongs to the key of all that is random in the run,
    /// beside the seeds: noises, sensors, dropouts, outliers and sample times of two members are independent.
    #[must_use]
    pub fn member(mut self, number: u64) -> Self {
        self.member = number;
        self
    }

    /// The model of the plant from whose h an output that is not measured is predicted (default: the simulated
    /// plant).
    #[must_use]
    pub fn model(mut self, model: impl Plant<f64> + Send + Sync + 'a) -> Self {
        self.model = Some(Arc::new(Erased(model)));
        self
    }

    /// Disturbances of plant, actuators and sensors, which the observers do not know.
    ///
    /// ```
    /// use luenberger_observers::LinearObserver;
    /// use luenberger_sim::{Disturbances, Fault, Scenario};
    /// use nalgebra::Vector2;
    /// let plant = luenberger_plants::double_integrator();
    /// let bias = Fault { gain: vec![1.0], bias: vec![0.1], from: 0.0 };
    /// let run = Scenario::new(plant.clone())
    ///     .observer("linear", LinearObserver::of(plant, Vector2::new(7.0, 10.0))?, &[1.0, 0.0])
    ///     .disturbances(Disturbances { sensor: Some(bias), ..Disturbances::default() })
    ///     .until(10.0, 2)
    ///     .run()?;
    /// // The bias of the sensor is an error of the position.
    /// assert!((run.observers[0].error[(1, 0)] + 0.1).abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn disturbances(mut self, disturbances: Disturbances) -> Self {
        self.disturbances = disturbances;
        self
    }

    /// An observer in continuous time, and its estimate at the start.
    #[must_use]
    pub fn observer(self, name: &str, observer: impl Observer<f64> + Send + Sync + 'a, initial: &[f64]) -> Self {
        self.entry(name, Arc::new(Continuous::new(observer)), initial, Estimated::State)
    }

    /// An observer of some states of the plant: entry i of its estimate is for the state `states[i]`, from 0.
    #[must_use]
    pub fn partial_observer(
        self,
        name: &str,
        observer: impl Observer<f64> + Send + Sync + 'a,
        initial: &[f64],
        states: &[usize],
    ) -> Self {
        self.entry(name, Arc::new(Continuous::new(observer)), initial, Estimated::States(states.to_vec()))
    }

    /// An observer of the functions `z = K x`, with their first estimate. Its errors are `K x - zhat`.
    ///
    /// ```
    /// use luenberger_observers::FunctionalObserver;
    /// use nalgebra::{dmatrix, matrix};
    /// // The double integrator: the speed alone, by one state.
    /// let speed = FunctionalObserver::new(matrix![-4.0], matrix![-16.0], matrix![1.0], matrix![4.0])?;
    /// let run = luenberger_sim::Scenario::new(luenberger_plants::double_integrator())
    ///     .initial_state(&[0.0, 2.0])
    ///     .functional_observer("speed", speed, &[1.0], &dmatrix![0.0, 1.0])
    ///     .until(1.0, 2)
    ///     .run()?;
    /// assert!((run.observers[0].error[(1, 0)] - (-4.0f64).exp()).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn functional_observer(
        self,
        name: &str,
        observer: impl Observer<f64> + Send + Sync + 'a,
        initial: &[f64],
        k: &DMatrix<f64>,
    ) -> Self {
        self.entry(name, Arc::new(Continuous::new(observer)), initial, Estimated::Functions(k.clone()))
    }

    /// A sampled-data observer of the functions `z = K x`, with their first estimate.
    #[must_use]
    pub fn sampled_functional_observer(
        self,
        name: &str,
        observer: impl SampledObserver<f64> + Send + Sync + 'a,
        initial: &[f64],
        k: &DMatrix<f64>,
    ) -> Self {
        self.entry(name, Arc::new(Sampled(observer)), initial, Estimated::Functions(k.clone()))
    }

    /// An observer that is corrected at samples of varying periods, some of them missed, and its estimate at the start.
    /// The trajectory has the [`samples`](crate::ObserverTrajectory::samples).
    ///
    /// ```
    /// use luenberger_observers::{SampledCubicGains, SampledCubicObserver, VaryingPeriodObserver};
    /// use luenberger_sim::{SampleTimes, Scenario};
    /// use nalgebra::{Matrix1, Matrix2, RowVector2, Vector2};
    /// let (h, c) = (0.1, RowVector2::new(1.0, 0.0));
    /// let (ad, bd) = (Matrix2::new(1.0, h, 0.0, 1.0), Vector2::new(h * h / 2.0, h));
    /// let (ld, n) = (Vector2::new(0.9, 2.0), Vector2::new(-1.0, -1.5));
    /// let gains = SampledCubicGains { ad, bd, c, ld, n, theta: Matrix1::new(10.0), w: 1.0, period: h };
    /// let nominal = SampledCubicObserver::new(gains)?;
    /// let (a, b, k) = (Matrix2::new(0.0, 1.0, 0.0, 0.0), Vector2::new(0.0, 1.0), Vector2::new(0.7, 2.0));
    /// let observer = VaryingPeriodObserver::new(nominal, a, b, k, 0.26)?;
    /// let times = SampleTimes { shortest: 0.08, longest: 0.13, misses: 1, seed: 1 };
    /// let run = Scenario::new(luenberger_plants::double_integrator())
    ///     .initial_state(&[1.0, -1.0])
    ///     .continuous_discrete_observer("jitter", observer, times, &[0.0, 0.0])
    ///     .until(20.0, 2)
    ///     .run()?;
    /// let observer = &run.observers[0];
    /// assert!(observer.error.row(1).norm() < 1e-6);
    /// // One sample in a row may be missed.
    /// assert!(observer.samples.iter().any(|sample| !sample.arrives));
    /// assert!(observer.samples.iter().all(|sample| sample.elapsed < 0.26 + 1e-9));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn continuous_discrete_observer(
        self,
        name: &str,
        observer: impl ContinuousDiscreteObserver<f64> + Send + Sync + 'a,
        times: SampleTimes,
        initial: &[f64],
    ) -> Self {
        self.entry(name, Arc::new(Continuous::sampled_at(observer, times)), initial, Estimated::State)
    }

    /// A sampled-data observer, and its estimate at the start, which is its first sample.
    ///
    /// It assumes an input that is held between its samples; make it so with [`hold_input`](Self::hold_input).
    #[must_use]
    pub fn sampled_observer(
        self,
        name: &str,
        observer: impl SampledObserver<f64> + Send + Sync + 'a,
        initial: &[f64],
    ) -> Self {
        self.entry(name, Arc::new(Sampled(observer)), initial, Estimated::State)
    }

    /// A sampled-data observer of some states of the plant.
    #[must_use]
    pub fn partial_sampled_observer(
        self,
        name: &str,
        observer: impl SampledObserver<f64> + Send + Sync + 'a,
        initial: &[f64],
        states: &[usize],
    ) -> Self {
        self.entry(name, Arc::new(Sampled(observer)), initial, Estimated::States(states.to_vec()))
    }

    /// An observer of any kind, and its estimate of the state at the start.
    #[must_use]
    pub fn any_observer(self, name: &str, observer: Arc<dyn AnyObserver + 'a>, initial: &[f64]) -> Self {
        self.entry(name, observer, initial, Estimated::State)
    }

    pub(crate) fn entry(
        mut self,
        name: &str,
        observer: Arc<dyn AnyObserver + 'a>,
        initial: &[f64],
        of: Estimated,
    ) -> Self {
        self.observers.push(Entry { name: name.to_owned(), observer, initial: initial.to_vec(), of });
        self
    }

    /// An integral along the run, 0 at the start.
    #[must_use]
    pub fn integral(mut self, name: &str, integrand: Integrand<'a>) -> Self {
        self.integrals.push((name.to_owned(), integrand));
        self
    }

    /// Adds a change of the plant. Of several at the same time, the last plant is used and the jumps are added.
    #[must_use]
    pub fn change(mut self, change: Change<'a>) -> Self {
        self.changes.push(change);
        self
    }

    /// Method, tolerances and caps.
    #[must_use]
    pub fn settings(mut self, settings: Settings) -> Self {
        self.settings = settings;
        self
    }

    /// The integration method; other settings are kept.
    #[must_use]
    pub fn integrator(mut self, integrator: Integrator) -> Self {
        self.settings.integrator = integrator;
        self
    }

    /// Relative and absolute tolerance; other settings are kept.
    #[must_use]
    pub fn tolerances(mut self, rtol: f64, atol: f64) -> Self {
        (self.settings.rtol, self.settings.atol) = (rtol, atol);
        self
    }

    /// The duration of the run.
    pub(crate) fn duration(&self) -> Result<f64, SimError> {
        let end = self.span.map(|(end, _)| end).or(self.times.last().copied()).unwrap_or(self.start);
        if end > self.start { Ok(end - self.start) } else { Err(SimError::TimeSpan { start: self.start, end }) }
    }

    /// Sets the times of a span, checks everything about time, and returns the end.
    pub(crate) fn resolve_times(&mut self) -> Result<f64, SimError> {
        if let Some((end, samples)) = self.span {
            self.times = equally_spaced(self.start, end, samples)?;
        }
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

/// So many times from start to end.
pub(crate) fn equally_spaced(start: f64, end: f64, samples: usize) -> Result<Vec<f64>, SimError> {
    if samples < 2 {
        return Err(SimError::Samples { samples });
    }
    let last = samples - 1;
    Ok((0..=last).map(|k| if k == last { end } else { start + (end - start) * k as f64 / last as f64 }).collect())
}
