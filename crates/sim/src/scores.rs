//! Scores of an observer's error, and the times at which errors are scored.
//!
//! The estimate of a sampled-data observer is defined at its samples only. That of a filter, which is an update by the
//! sample and a prediction, is by default the *filtered* one: what is known of x(t_k) after the measurement of t_k, as
//! on a log. [`Estimates::Predicted`] is what is known before it. Other sampled observers have a prediction only. Held
//! until the next sample an estimate lags behind the plant by up to a period, and that lag is no error of the observer.
//! Hence one rule for all that is compared: if any of the observers is sampled, all of
//! them are scored at the same instants, the samples; if none is, in continuous time.
//!
//! | score | at the samples | in continuous time |
//! |---|---|---|
//! | RMSE | root of the mean square over the samples | `sqrt(1/T int e^2 dt)`, from the dense output |
//! | peak | largest magnitude: of a sampled observer at its samples, of one in continuous time at all times | largest magnitude |
//! | overshoot | likewise, after the first change of sign | the same |
//! | settling | first sample from which it stays within the band | last crossing of the band |
//! | at the end | at the last sample | at the end of the run |
//! | at the start | of the first estimate, before any measurement: the unit of settling | the same |
//! | steady state | RMSE over the samples of the second half | RMSE over the second half |
//!
//! Errors of different states have different units. Scores of single states are in the unit of the state; a norm takes
//! a scale, one positive number per state, by which each error is divided.

use std::fmt;

use luenberger_plants::wrap;
use luenberger_wording::significant;
use nalgebra::DMatrix;

use crate::error::{SimError, check, check_positive};
use crate::events::Trace;
use crate::metrics;
use crate::trajectory::Trajectory;

pub use crate::score_grid::ScoreGrid;
pub use crate::updates::Estimates;

/// Scores of the error of one state, in its unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateScores {
    /// The error at the start.
    pub initial: f64,
    /// Root mean square.
    pub rmse: f64,
    /// The largest magnitude; at least that at the start.
    pub peak: f64,
    /// The largest magnitude after the first change of sign; 0 if the sign never changes.
    pub overshoot: f64,
    /// The time from which the magnitude stays within 5 % of that at the start; `None` if it does not, or if the error
    /// starts at 0.
    pub settling_5: Option<f64>,
    /// Likewise for 2 %.
    pub settling_2: Option<f64>,
    /// The magnitude at the end.
    pub last: f64,
    /// Root mean square over the second half of the run: what noise leaves once the initial error is gone.
    pub steady_rmse: f64,
}

/// Figures of merit of the norm of the error, |e|.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorMetrics {
    /// |e| at the start.
    pub initial: f64,
    /// The first time |e| is within the band; `None` if it never is.
    pub settling_first: Option<f64>,
    /// The time from which |e| stays within the band; `None` if it does not.
    pub settling_last: Option<f64>,
    /// The largest |e|; at least |e(0)|.
    pub peak: f64,
    /// The root mean square of |e|.
    pub rmse: f64,
    /// |e| at the end.
    pub last: f64,
    /// The root mean square of |e| over the second half of the run.
    pub steady_rmse: f64,
}

impl fmt::Display for ErrorMetrics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let short = |x: f64| significant(x, 4);
        let time = |time: Option<f64>| time.map_or_else(|| "never".to_owned(), short);
        write!(f, "|e| at the start {}, peak {}, ", short(self.initial), short(self.peak))?;
        write!(f, "RMSE {}, in the second half {}, ", short(self.rmse), short(self.steady_rmse))?;
        write!(f, "at the end {}; enters the band at {}, ", short(self.last), time(self.settling_first))?;
        write!(f, "settles at {}", time(self.settling_last))
    }
}

impl ErrorMetrics {
    /// The merits of an observer in a run; settled is within `band |e(0)|`, `e(0)` the error at the start.
    ///
    /// If any observer of the run is sampled, the merits are those at the samples (see the [module](self)), on the grid
    /// that [`Trajectory::score_grid`] names. The norm is Euclid's of the errors as they are, which adds up units; with
    /// a scale it is [`Errors::norm`].
    ///
    /// ```
    /// use luenberger_sim::{ErrorMetrics, Scenario};
    /// use luenberger_observers::LinearObserver;
    /// use nalgebra::Vector2;
    /// let plant = luenberger_plants::double_integrator();
    /// let run = Scenario::new(plant.clone())
    ///     .observer("linear", LinearObserver::of(plant, Vector2::new(7.0, 10.0))?, &[1.0, 0.0])
    ///     .until(8.0, 2)
    ///     .run()?;
    /// let merits = ErrorMetrics::of(&run, "linear", 0.05)?;
    /// assert!(merits.peak >= 1.0 && merits.last < 1e-5 && merits.settling_last < Some(3.0));
    /// assert!(merits.to_string().starts_with("|e| at the start 1, peak "));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`SimError::UnknownName`], [`SimError::NoCommonGrid`]; [`SimError::NotPositive`] for a band that is not
    /// positive.
    pub fn of(trajectory: &Trajectory, observer: &str, band: f64) -> Result<Self, SimError> {
        Errors::of(trajectory, observer, trajectory.score_grid()?)?.norm(None, band)
    }
}

/// The band of settling.
#[derive(Clone, Copy)]
pub(crate) enum Band {
    /// A share of the norm at the start.
    Share(f64),
    /// A norm.
    Within(f64),
}

impl Band {
    fn of(self, initial: f64) -> f64 {
        match self {
            Self::Share(share) => share * initial,
            Self::Within(within) => within,
        }
    }
}

/// The errors of one observer in a run at the instants of a grid.
pub struct Errors<'t> {
    trajectory: &'t Trajectory,
    observer: &'t str,
    /// The times and the errors there, one row each; `None` in continuous time.
    samples: Option<(Vec<f64>, DMatrix<f64>)>,
    /// The errors of the first estimate of a filter, before its measurement.
    first: Option<Vec<f64>>,
    count: usize,
    /// Whether the observer is in continuous time: its extrema are those of all times.
    continuous: bool,
}

impl<'t> Errors<'t> {
    /// The errors of an observer on a grid.
    ///
    /// On a grid of a period that is no multiple of its own, a sampled observer is scored at its last sample up to each
    /// instant, against the state of the plant at that sample.
    ///
    /// ```
    /// use luenberger_observers::LinearObserver;
    /// use luenberger_sim::{Errors, Scenario, ScoreGrid};
    /// use nalgebra::Vector2;
    /// let plant = luenberger_plants::double_integrator();
    /// let run = Scenario::new(plant.clone())
    ///     .observer("linear", LinearObserver::of(plant, Vector2::new(7.0, 10.0))?, &[1.0, 0.0])
    ///     .until(8.0, 2)
    ///     .run()?;
    /// let position = Errors::of(&run, "linear", ScoreGrid::Continuous)?.state(0)?;
    /// assert!(position.peak == 1.0 && position.overshoot < 0.25 && position.settling_5 < position.settling_2);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`SimError::UnknownName`]; [`SimError::ScorePeriod`] for a grid finer than the samples of the observer.
    pub fn of(trajectory: &'t Trajectory, observer: &'t str, grid: ScoreGrid) -> Result<Self, SimError> {
        Self::of_estimates(trajectory, observer, grid, Estimates::Filtered)
    }

    /// The same of the estimates of a filter before or after the measurement of each sample.
    ///
    /// ```
    /// use luenberger_observers::{KalmanFilter, KalmanModel};
    /// use luenberger_sim::{Errors, Estimates, Scenario};
    /// use nalgebra::{Matrix1, SMatrix};
    /// // The constant 1, measured exactly with the variance 1 assumed, from the estimate 0 with the variance 1: the
    /// // error is 1 before and 1/2 after the first measurement, 1/3 after the second, 1/4 after the third.
    /// let one = Matrix1::new(1.0);
    /// let bd = SMatrix::<f64, 1, 0>::zeros();
    /// let model = KalmanModel { ad: one, bd, c: one, w: one * 0.0, v: one, p0: one, period: 1.0 };
    /// let plant = luenberger_plants::StaticPlant::new(one * 0.0, bd, one)?;
    /// let filter = KalmanFilter::new(model)?;
    /// let run = Scenario::new(plant)
    ///     .initial_state(&[1.0])
    ///     .sampled_observer("filter", filter, &[0.0])
    ///     .until(2.0, 3)
    ///     .run()?;
    /// let last = |estimates| -> Result<f64, luenberger_sim::SimError> {
    ///     Ok(Errors::of_estimates(&run, "filter", run.score_grid()?, estimates)?.state(0)?.last)
    /// };
    /// assert!((last(Estimates::Filtered)? - 0.25).abs() < 1e-15);
    /// assert!((last(Estimates::Predicted)? - 1.0 / 3.0).abs() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// As [`of`](Self::of).
    pub fn of_estimates(
        trajectory: &'t Trajectory,
        observer: &'t str,
        grid: ScoreGrid,
        estimates: Estimates,
    ) -> Result<Self, SimError> {
        let own = trajectory.observer(observer)?;
        let (count, continuous) = (own.estimate.ncols(), own.period.is_none());
        let samples = match grid {
            ScoreGrid::Continuous => None,
            ScoreGrid::Samples { period } => Some(trajectory.errors_at_samples(observer, period, estimates)?),
        };
        let first = match (&samples, &own.at_samples) {
            (Some((times, _)), Some(at_samples)) => {
                let wanted = trajectory.wanted_at(observer, times[0])?;
                let turns = trajectory.turns_of(observer)?;
                let error = |(j, x): (usize, f64)| wrap(x - at_samples.predicted[(0, j)], turns[j]);
                Some(wanted.into_iter().enumerate().map(error).collect())
            }
            _ => None,
        };
        Ok(Self { trajectory, observer, samples, first, count, continuous })
    }

    /// Number of components: the states, or functions of the state, that the observer estimates.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether the observer estimates nothing.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The scores of component `component`, from 0.
    ///
    /// # Errors
    /// [`SimError::Index`].
    pub fn state(&self, component: usize) -> Result<StateScores, SimError> {
        let curve = match &self.samples {
            Some((_, errors)) if component >= errors.ncols() => {
                let count = errors.ncols();
                return Err(SimError::Index { what: "component of the error", index: component, count });
            }
            Some((times, errors)) => Curve::Samples(times, errors.column(component).iter().copied().collect()),
            None => Curve::Continuous(self.trajectory.error_trace(self.observer, component)?),
        };
        // A peak between samples of another observer is a peak.
        let extrema = match &curve {
            Curve::Samples(..) if self.continuous => {
                Some(Curve::Continuous(self.trajectory.error_trace(self.observer, component)?))
            }
            _ => None,
        };
        let extrema = extrema.as_ref().unwrap_or(&curve);
        let initial = match &self.first {
            Some(first) => first[component],
            None => curve.initial()?,
        };
        let settling = |share: f64| if initial == 0.0 { None } else { curve.stays_within(share * initial.abs()) };
        Ok(StateScores {
            initial,
            rmse: curve.rms(),
            peak: extrema.peak()?.max(initial.abs()),
            overshoot: match (&curve, &self.first) {
                // The first estimate comes before the first sample.
                (Curve::Samples(times, values), Some(_)) => {
                    Curve::Samples(times, [&[initial], values.as_slice()].concat()).overshoot()
                }
                _ => extrema.overshoot(),
            },
            settling_5: settling(0.05),
            settling_2: settling(0.02),
            last: curve.last().abs(),
            steady_rmse: curve.steady_rms(),
        })
    }

    /// The scores of all components.
    ///
    /// # Errors
    /// As [`state`](Self::state).
    pub fn states(&self) -> Result<Vec<StateScores>, SimError> {
        (0..self.count).map(|component| self.state(component)).collect()
    }

    /// The merits of the norm `sqrt(sum_i (e_i / scale_i)^2)`, Euclid's without a scale; settled is within `band` of
    /// its value at the start. An error that starts at 0 has no settling time.
    ///
    /// # Errors
    /// [`SimError::Length`], [`SimError::NotFinite`] or [`SimError::NotPositive`] for a scale that does not fit, and
    /// for a band that is not positive.
    pub fn norm(&self, scale: Option<&[f64]>, band: f64) -> Result<ErrorMetrics, SimError> {
        check_positive("the band of settling", band)?;
        self.merits(scale, Band::Share(band))
    }

    /// As [`norm`](Self::norm), settled within a band of either kind.
    pub(crate) fn merits(&self, scale: Option<&[f64]>, band: Band) -> Result<ErrorMetrics, SimError> {
        let scale = match scale {
            Some(scale) => check_scale(scale, self.count).map(|()| scale.to_vec())?,
            None => vec![1.0; self.count],
        };
        let curve = match &self.samples {
            Some((times, errors)) => {
                let norms = errors.row_iter().map(|row| scaled_norm(row.iter(), &scale));
                Curve::Samples(times, norms.collect())
            }
            None => Curve::Continuous(self.trajectory.scaled_norm(self.observer, &scale)?),
        };
        let extrema = match &curve {
            Curve::Samples(..) if self.continuous => {
                Some(Curve::Continuous(self.trajectory.scaled_norm(self.observer, &scale)?))
            }
            _ => None,
        };
        let initial = match &self.first {
            Some(first) => scaled_norm(first.iter(), &scale),
            None => curve.initial()?,
        };
        let peak = extrema.as_ref().unwrap_or(&curve).peak()?.max(initial);
        let within = band.of(initial);
        let starts = |time: Option<f64>| time.filter(|_| initial > 0.0);
        Ok(ErrorMetrics {
            initial,
            settling_first: starts(curve.first_within(within)),
            settling_last: starts(curve.stays_within(within)),
            peak,
            rmse: curve.rms(),
            last: curve.last(),
            steady_rmse: curve.steady_rms(),
        })
    }
}

impl Trajectory {
    /// The root mean square of `|e|` of an observer: over the samples if any observer of the run is sampled, otherwise
    /// `sqrt(1/T int |e|^2 dt)` (see the [module](crate::scores)).
    ///
    /// # Errors
    /// [`SimError::UnknownName`], [`SimError::NoCommonGrid`].
    pub fn rmse(&self, observer: &str) -> Result<f64, SimError> {
        Ok(ErrorMetrics::of(self, observer, 1.0)?.rmse)
    }

    /// The scores of each component that an observer estimates, on the grid of [`score_grid`](Self::score_grid).
    ///
    /// # Errors
    /// [`SimError::UnknownName`], [`SimError::NoCommonGrid`].
    pub fn state_scores(&self, observer: &str) -> Result<Vec<StateScores>, SimError> {
        Errors::of(self, observer, self.score_grid()?)?.states()
    }

    /// The time from which `|e|` stays within `band |e(0)|`, `e(0)` the error at the start; `None` if it does not. At
    /// the samples, if any observer of the run is sampled.
    ///
    /// ```
    /// use luenberger_observers::LinearObserver;
    /// use nalgebra::Vector2;
    /// let plant = luenberger_plants::double_integrator();
    /// let run = luenberger_sim::Scenario::new(plant.clone())
    ///     .observer("linear", LinearObserver::of(plant, Vector2::new(7.0, 10.0))?, &[1.0, 0.0])
    ///     .until(8.0, 201)
    ///     .run()?;
    /// let settled = run.settling_time("linear", 0.05)?.ok_or("it settles")?;
    /// assert!(settled < 3.0 && run.rmse("linear")? < 1.0);
    /// assert_eq!(run.state_scores("linear")?[0].peak, 1.0);
    /// assert_eq!(run.to_csv().lines().next(), Some("t,x1,x2,u1,y1,linear.xhat1,linear.xhat2"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`SimError::UnknownName`], [`SimError::NoCommonGrid`]; [`SimError::NotPositive`] for a band that is not
    /// positive.
    pub fn settling_time(&self, observer: &str, band: f64) -> Result<Option<f64>, SimError> {
        Ok(ErrorMetrics::of(self, observer, band)?.settling_last)
    }
}

/// `sqrt(sum_i (e_i / scale_i)^2)`.
fn scaled_norm<'e>(errors: impl Iterator<Item = &'e f64>, scale: &[f64]) -> f64 {
    errors.zip(scale).map(|(error, scale)| (error / scale).powi(2)).sum::<f64>().sqrt()
}

/// Checks a scale: one positive number per state.
pub(crate) fn check_scale(scale: &[f64], states: usize) -> Result<(), SimError> {
    check("the scale of the states", scale, states)?;
    scale.iter().try_for_each(|entry| check_positive("an entry of the scale of the states", *entry))
}

/// A scalar error, as it is scored.
enum Curve<'t> {
    Continuous(Trace<'t>),
    Samples(&'t [f64], Vec<f64>),
}

impl Curve<'_> {
    fn initial(&self) -> Result<f64, SimError> {
        match self {
            Self::Continuous(trace) => trace.at(trace.span().0),
            Self::Samples(_, values) => Ok(values[0]),
        }
    }

    fn last(&self) -> f64 {
        match self {
            Self::Continuous(trace) => trace.last(),
            Self::Samples(_, values) => values[values.len() - 1],
        }
    }

    fn rms(&self) -> f64 {
        match self {
            Self::Continuous(trace) => {
                let (start, end) = trace.span();
                (trace.integral_of_square_from(start) / (end - start)).sqrt()
            }
            Self::Samples(_, values) => root_mean_square(values),
        }
    }

    /// Root mean square over the second half.
    fn steady_rms(&self) -> f64 {
        match self {
            Self::Continuous(trace) => {
                let (start, end) = trace.span();
                let middle = start + (end - start) / 2.0;
                (trace.integral_of_square_from(middle) / (end - middle)).sqrt()
            }
            Self::Samples(_, values) => root_mean_square(&values[values.len() / 2..]),
        }
    }

    fn peak(&self) -> Result<f64, SimError> {
        match self {
            Self::Continuous(trace) => Ok(metrics::peak(trace)?.value),
            Self::Samples(_, values) => Ok(largest(values)),
        }
    }

    fn overshoot(&self) -> f64 {
        match self {
            Self::Continuous(trace) => metrics::overshoot(trace).map_or(0.0, |extremum| extremum.value),
            Self::Samples(_, values) => {
                let Some(sign) = values.iter().find(|x| **x != 0.0) else { return 0.0 };
                let crossed = values.iter().position(|x| x * sign < 0.0);
                crossed.map_or(0.0, |first| largest(&values[first..]))
            }
        }
    }

    fn first_within(&self, band: f64) -> Option<f64> {
        match self {
            Self::Continuous(trace) => metrics::settling_first(trace, band),
            Self::Samples(times, values) => values.iter().position(|x| x.abs() <= band).map(|k| times[k]),
        }
    }

    fn stays_within(&self, band: f64) -> Option<f64> {
        match self {
            Self::Continuous(trace) => metrics::settling_last(trace, band),
            Self::Samples(times, values) => match values.iter().rposition(|x| x.abs() > band) {
                None => times.first().copied(),
                Some(outside) => times.get(outside + 1).copied(),
            },
        }
    }
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()))
}
