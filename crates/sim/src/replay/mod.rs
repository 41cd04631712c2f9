//! Observers on recorded data: no plant is simulated. An observer is assessed by its innovation
//! `y - h(xhat)`, or by its error where the true state was recorded.
//!
//! Estimates are corrected by measurements only, and by default causally. The times of a log need not be
//! equally spaced, and any value may be missing ([`Recording::with_missing`]).
//!
//! - A Kalman filter is updated at the rows of the log by the outputs that were measured there, and predicted from row
//!   to row over the time that has passed, in steps no longer than its period.
//! - A sampled-data observer of a fixed period is stepped at this period, from the first row on. A row that lies on one
//!   of its samples (to 1 % of the period) corrects it. At another sample, and for a missing value, it predicts: its
//!   innovation is zero, y := h(xhat).
//! - An observer that samples at varying periods correct predicts from row to row over the time that has passed, and is
//!   corrected at every row that measured something. A missing output is replaced by its prediction.
//! - Any other observer in continuous time is integrated from row to row. From the row that measured it on an output
//!   moves with the model, `w' = Dh(xhat) f(xhat, u)`, for its own median period, or until the next row that measures
//!   it. In a gap, and from a missing value on, the observer predicts.
//!
//! Held measurements, and straight lines between the rows, are on request ([`Recording::between`]); no line crosses a
//! gap or a missing value. Inputs are held from row to row for all.
//!
//! The observers are the very objects that run in a [`Scenario`](crate::Scenario) and on the target.

mod filter;
mod hold;
mod innovation;
mod recording;
mod replayed;
mod run;
mod smoother;

use std::borrow::Cow;
use std::sync::Arc;

use luenberger_observers::{
    ContinuousDiscreteObserver, CovarianceFilter, Observer, ObserverDimensions, SampledObserver,
};
use luenberger_plants::Plant;

use crate::erased::{AnyObserver, AnyPlant, Continuous, Erased, Sampled};
use crate::error::{SimError, check};
use crate::integrate::Settings;
use crate::model::check_turns;
use filter::{Any, AnyFilter};
use run::ReplayRun;

pub use innovation::{Consistency, InnovationStatistics, NormalisedSquare, Whiteness};
pub use recording::{BetweenRows, Recording};
pub use replayed::{FilterConsistency, Replayed, ReplayedObserver};
pub use smoother::Smoothed;

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
/// // The speed is 5; between the rows the measurement moves with the model.
/// assert!((speed - 5.0).abs() < 1e-3);
/// assert!(linear.statistics(3.0)?[0].rms < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Replay<'a> {
    plant: Box<dyn AnyPlant + 'a>,
    recording: Cow<'a, Recording>,
    observers: Vec<Entry<'a>>,
    settings: Settings,
    turns: Vec<f64>,
    keeps: Keeps,
    progress: Option<Progress<'a>>,
}

/// What is told how many rows are done, of how many.
type Progress<'a> = &'a (dyn Fn(usize, usize) + Sync);

/// What is recorded beside the estimates.
#[derive(Clone, Copy)]
struct Keeps {
    /// The estimates and covariances before the measurements.
    predictions: bool,
    /// The covariances, and not the standard deviations alone.
    covariances: bool,
    /// The states of the observers.
    states: bool,
}

enum Kind<'a> {
    Observer(Arc<dyn AnyObserver + 'a>),
    Filter(Box<dyn AnyFilter + 'a>),
}

struct Entry<'a> {
    name: String,
    kind: Kind<'a>,
    initial: Vec<f64>,
    /// Whether the estimate is the whole state, so that h can be evaluated at it.
    whole: bool,
    /// Whether the estimates of a filter are smoothed.
    is_smoothed: bool,
}

impl<'a> Replay<'a> {
    /// A replay of the recording; the plant is asked for h, and for f where an output moves with the
    /// model between the rows.
    pub fn new(plant: impl Plant<f64> + Send + Sync + 'a, recording: impl Into<Cow<'a, Recording>>) -> Self {
        let settings = Settings { rtol: 1e-9, ..Settings::default() };
        let (recording, keeps) = (recording.into(), Keeps { predictions: true, covariances: true, states: false });
        Self {
            plant: Box::new(Erased(plant)),
            recording,
            observers: Vec::new(),
            settings,
            turns: Vec::new(),
            keeps,
            progress: None,
        }
    }

    /// The data.
    pub fn recording(&self) -> &Recording {
        &self.recording
    }

    /// Without the estimates and covariances before the measurements, which take as much memory as those after them.
    #[must_use]
    pub fn without_predictions(mut self) -> Self {
        self.keeps.predictions = false;
        self
    }

    /// With the standard deviations of filters in place of their covariances, n numbers in place of n^2: without a test
    /// of the errors (NEES). Not for smoothed estimates, which need the covariances.
    #[must_use]
    pub fn deviations_only(mut self) -> Self {
        self.keeps.covariances = false;
        self
    }

    /// With the [states](ReplayedObserver::states) of the observers, which may hold more than their estimates.
    #[must_use]
    pub fn with_states(mut self) -> Self {
        self.keeps.states = true;
        self
    }

    /// Tells from time to time how many rows are done, and how many there are.
    #[must_use]
    pub fn progress(mut self, tell: &'a (dyn Fn(usize, usize) + Sync)) -> Self {
        self.progress = Some(tell);
        self
    }

    /// An observer in continuous time, with its estimate at the first time of the log.
    #[must_use]
    pub fn observer(self, name: &str, observer: impl Observer<f64> + Send + Sync + 'a, initial: &[f64]) -> Self {
        self.entry(name, Kind::Observer(Arc::new(Continuous::new(observer))), initial, true)
    }

    /// An observer that is corrected at samples of any distance, here at the rows of the log, with its estimate at the
    /// first time of the log.
    ///
    /// ```
    /// use luenberger_observers::{SampledCubicGains, SampledCubicObserver, VaryingPeriodObserver};
    /// use luenberger_sim::replay::{Recording, Replay};
    /// use nalgebra::{DMatrix, Matrix1, Matrix2, RowVector2, SMatrix, Vector2};
    /// // A mass at constant speed, measured at times that are not equally spaced.
    /// let t: Vec<f64> = (0..60).map(|k| 0.1 * f64::from(k) + 0.03 * f64::from(k % 3)).collect();
    /// let y = DMatrix::from_fn(60, 1, |k, _| 0.5 * t[k]);
    /// let recording = Recording::new(t, DMatrix::zeros(60, 0), y)?;
    /// let (a, none) = (Matrix2::new(0.0, 1.0, 0.0, 0.0), SMatrix::<f64, 2, 0>::zeros());
    /// let (c, h) = (RowVector2::new(1.0, 0.0), 0.1);
    /// let (ad, ld) = (Matrix2::new(1.0, h, 0.0, 1.0), Vector2::new(0.9, 2.0));
    /// let gains =
    ///     SampledCubicGains { ad, bd: none, c, ld, n: Vector2::zeros(), theta: Matrix1::new(0.0), w: 1.0, period: h };
    /// let nominal = SampledCubicObserver::new(gains)?;
    /// let observer = VaryingPeriodObserver::new(nominal, a, none, Vector2::new(0.7, 2.0), 0.2)?;
    /// let plant = luenberger_plants::StaticPlant::new(a, none, c)?;
    /// let replayed = Replay::new(plant, recording).corrected_observer("varying", observer, &[1.0, 0.0]).run()?;
    /// let last = replayed.observer("varying")?.estimate.row(59).clone_owned();
    /// assert!((last[1] - 0.5).abs() < 1e-8);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn corrected_observer(
        self,
        name: &str,
        observer: impl ContinuousDiscreteObserver<f64> + Send + Sync + 'a,
        initial: &[f64],
    ) -> Self {
        self.entry(name, Kind::Observer(Arc::new(Continuous::corrected(observer))), initial, true)
    }

    /// An observer of any kind, with its estimate of the state at the first time of the log, which is the first sample
    /// of a sampled one.
    #[must_use]
    pub fn any_observer(self, name: &str, observer: Arc<dyn AnyObserver + 'a>, initial: &[f64]) -> Self {
        self.entry(name, Kind::Observer(observer), initial, true)
    }

    /// An observer of some states; it has no innovation.
    #[must_use]
    pub fn partial_observer(
        self,
        name: &str,
        observer: impl Observer<f64> + Send + Sync + 'a,
        initial: &[f64],
    ) -> Self {
        self.entry(name, Kind::Observer(Arc::new(Continuous::new(observer))), initial, false)
    }

    /// A sampled-data observer, with its estimate at the first time of the log, which is its first sample.
    #[must_use]
    pub fn sampled_observer(
        self,
        name: &str,
        observer: impl SampledObserver<f64> + Send + Sync + 'a,
        initial: &[f64],
    ) -> Self {
        self.entry(name, Kind::Observer(Arc::new(Sampled(observer))), initial, true)
    }

    /// A sampled-data observer of some states; it has no innovation.
    #[must_use]
    pub fn partial_sampled_observer(
        self,
        name: &str,
        observer: impl SampledObserver<f64> + Send + Sync + 'a,
        initial: &[f64],
    ) -> Self {
        self.entry(name, Kind::Observer(Arc::new(Sampled(observer))), initial, false)
    }

    /// A filter with a covariance: updated at the rows of the log, and predicted in between over the time that has
    /// passed, in steps no longer than its period. One in discrete time (a Kalman filter, or the extended one of a
    /// plant in discrete time) is stepped at its own period from the first row on: updated at samples on which a row
    /// lies, and predicted from sample to sample. Its [`FilterConsistency`] is recorded.
    #[must_use]
    pub fn filter(self, name: &str, filter: impl CovarianceFilter<f64> + 'a, initial: &[f64]) -> Self {
        self.entry(name, Kind::Filter(Box::new(Any(filter))), initial, true)
    }

    /// The same, and its estimates smoothed: besides the estimates from the measurements up to their time there are
    /// those from the whole log ([`ReplayedObserver::smoothed`]).
    ///
    /// Keeps `3 n^2 + 2 n` numbers for each step of the prediction.
    ///
    /// ```
    /// use luenberger_observers::{KalmanFilter, KalmanModel};
    /// use luenberger_sim::replay::{Recording, Replay};
    /// use nalgebra::{DMatrix, Matrix1, SMatrix};
    /// // A constant, measured three times with the variance 1, from the variance 1/2 around 0.
    /// let one = Matrix1::new(1.0);
    /// let (w, p0, bd) = (Matrix1::zeros(), one * 0.5, SMatrix::<f64, 1, 0>::zeros());
    /// let filter = KalmanFilter::new(KalmanModel { ad: one, bd, c: one, w, v: one, p0, period: 1.0 })?;
    /// let y = DMatrix::from_column_slice(3, 1, &[1.0, 2.0, 3.0]);
    /// let recording = Recording::new(vec![0.0, 1.0, 2.0], DMatrix::zeros(3, 0), y)?;
    /// let plant = luenberger_plants::StaticPlant::new(one, bd, one)?;
    /// let replayed = Replay::new(plant, recording).smoothed_filter("constant", filter, &[0.0]).run()?;
    /// let constant = replayed.observer("constant")?;
    /// // The filter learns: (1)/3, (1 + 2)/4, (1 + 2 + 3)/5. The smoother knows the last from the start.
    /// let smoothed = constant.smoothed.as_ref().ok_or("smoothed")?;
    /// assert!((constant.estimate[(0, 0)] - 1.0 / 3.0).abs() < 1e-15);
    /// assert!(smoothed.estimate.iter().all(|x| (x - 6.0 / 5.0).abs() < 1e-14));
    /// assert!((smoothed.deviation()[(0, 0)] - 0.2f64.sqrt()).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn smoothed_filter(self, name: &str, filter: impl CovarianceFilter<f64> + 'a, initial: &[f64]) -> Self {
        let mut replay = self.filter(name, filter, initial);
        if let Some(entry) = replay.observers.last_mut() {
            entry.is_smoothed = true;
        }
        replay
    }

    /// The full turn of each state that is an angle, in its unit (2 pi or 360), and 0 for the others: errors, and with
    /// them NEES, are [wrapped](luenberger_plants::wrap()) into half a turn to either side. A filter wraps its
    /// innovations itself.
    #[must_use]
    pub fn angles(mut self, turns: &[f64]) -> Self {
        self.turns = turns.to_vec();
        self
    }

    /// Method, tolerances and caps for observers in continuous time (default rtol 1e-9 and atol 1e-12), far below what
    /// is lost between samples.
    #[must_use]
    pub fn settings(mut self, settings: Settings) -> Self {
        self.settings = settings;
        self
    }

    fn entry(mut self, name: &str, kind: Kind<'a>, initial: &[f64], whole: bool) -> Self {
        let (name, initial) = (name.to_owned(), initial.to_vec());
        self.observers.push(Entry { name, kind, initial, whole, is_smoothed: false });
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
        if !self.turns.is_empty() {
            check_turns(&self.turns, self.plant.dimensions().states)?;
        }
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
        let (size, own) = (self.plant.dimensions(), entry.kind.dimensions());
        let name = &entry.name;
        entry.kind.check()?;
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
        let mut run = ReplayRun::new(self.plant.as_ref(), &self.recording, self.settings, entry);
        run.keep(self.keeps, self.progress);
        match &entry.kind {
            Kind::Filter(filter) => run.filter(filter.as_ref())?,
            Kind::Observer(observer) => match observer.period() {
                Some(period) => run.sample(observer.as_ref(), period)?,
                None if observer.is_corrected() => run.correct_at_rows(observer.as_ref())?,
                None => run.integrate(observer.as_ref())?,
            },
        }
        let turns = if entry.whole { self.turns.clone() } else { Vec::new() };
        Ok(ReplayedObserver { turns, ..run.finish(own.estimate) })
    }
}

impl Kind<'_> {
    fn dimensions(&self) -> ObserverDimensions {
        match self {
            Self::Observer(observer) => observer.dimensions(),
            Self::Filter(filter) => filter.dimensions(),
        }
    }

    fn check(&self) -> Result<(), SimError> {
        match self {
            Self::Observer(observer) => observer.check(),
            Self::Filter(filter) => filter.check(),
        }
    }
}
