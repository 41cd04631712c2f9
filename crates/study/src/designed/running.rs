//! An observer that is ready to run, of any kind.

use std::any::Any;
use std::fmt;
use std::sync::Arc;

use luenberger_design::{DesignError, OperatingPoint};
use luenberger_export::extension::RecordedObserver;
use luenberger_expression::{ExpressionPlant, Recording};
use luenberger_live as live;
use luenberger_observers::{DeviationObserver, Observer, ObserverDimensions, SampledObserver};
use luenberger_plants::StateSpace;
pub(crate) use luenberger_plants::serialization::rows;
use luenberger_sim::{AnyObserver, Continuous, Replay, Sampled, Scenario};
use nalgebra::{DMatrix, DVector, Dyn};

use super::{Designed, Filter, NonlinearStep, RowVariances};
use crate::results::NoObserver;
use crate::study::{ObserverSpec, SamplingSpec, Study};

/// An observer of the deviations from an operating point.
pub type At<O> = DeviationObserver<O, f64, Dyn, Dyn, Dyn>;

/// A filter with a smoother as a [`Running`]: simulated in samples, and replayed with its covariance.
macro_rules! runs_as_filter {
    () => {
        fn any(&self) -> std::sync::Arc<dyn luenberger_sim::AnyObserver + '_> {
            crate::designed::sampled(self)
        }

        fn replay<'a>(
            &'a self,
            replay: luenberger_sim::Replay<'a>,
            name: &str,
            initial: &[f64],
        ) -> luenberger_sim::Replay<'a> {
            replay.filter(name, self.clone(), initial)
        }

        fn replay_smoothed<'a>(
            &'a self,
            replay: luenberger_sim::Replay<'a>,
            name: &str,
            initial: &[f64],
        ) -> luenberger_sim::Replay<'a> {
            replay.smoothed_filter(name, self.clone(), initial)
        }

        fn filter(&self) -> Option<&dyn crate::designed::Filter> {
            Some(self)
        }
    };
}
pub(crate) use runs_as_filter;

/// An observer that runs: in simulations, on logs, in the page of a report, and on a target.
pub trait Running: Any + fmt::Debug + Send + Sync {
    /// As one that is simulated.
    fn any(&self) -> Arc<dyn AnyObserver + '_>;

    /// The scenario with this observer added; one at varying periods has the samples of `sampling`.
    fn join<'a>(
        &'a self,
        scenario: Scenario<'a>,
        name: &str,
        initial: &[f64],
        sampling: &SamplingSpec,
    ) -> Scenario<'a> {
        let _ = sampling;
        scenario.any_observer(name, self.any(), initial)
    }

    /// The replay of a log with this observer added, one at varying periods at the times of its rows.
    fn replay<'a>(&'a self, replay: Replay<'a>, name: &str, initial: &[f64]) -> Replay<'a> {
        replay.any_observer(name, self.any(), initial)
    }

    /// The same, with smoothed estimates where it has a smoother.
    fn replay_smoothed<'a>(&'a self, replay: Replay<'a>, name: &str, initial: &[f64]) -> Replay<'a> {
        self.replay(replay, name, initial)
    }

    /// Number of its last states that are estimates of disturbances.
    fn disturbances(&self) -> usize {
        0
    }

    /// The half-widths of the bounds of its errors, from its state.
    fn half_widths_of(&self, state: &[f64]) -> Option<DVector<f64>> {
        let _ = state;
        None
    }

    /// The same at the start, as the design bounds them.
    fn first_widths(&self) -> Option<&[f64]> {
        None
    }

    /// The same in deviations from an operating point, of an observer of a linearisation.
    fn at(&self, point: &OperatingPoint) -> Option<Result<Runnable, DesignError>> {
        let _ = point;
        None
    }

    /// L, of an observer whose loop with a feedback is a linear system of twice its order.
    fn gain_of_loop(&self) -> Option<DMatrix<f64>> {
        None
    }

    /// The probabilities of its models, from its state, of an observer that has several.
    fn mode_probabilities(&self, state: &[f64]) -> Option<DVector<f64>> {
        let _ = state;
        None
    }

    /// Its matrices, of an observer that is linear.
    fn linear(&self) -> Option<LinearForm> {
        None
    }

    /// As a filter with a covariance.
    fn filter(&self) -> Option<&dyn Filter> {
        None
    }

    /// The same with the variances of the rows of a log in place of those of V; none of an observer without V.
    fn with_variances(&self, rows: &Arc<RowVariances>) -> Option<Runnable> {
        let _ = rows;
        None
    }

    /// As the page of a report runs it, with the operating point of one in deviations; none if the page has no code
    /// for it.
    fn live(&self, study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        let _ = study;
        None
    }

    /// Its body over the scalar that records.
    ///
    /// # Errors
    /// Why it has no program.
    fn record(&self, of: &StepOf<'_>, recording: &mut Recording) -> Result<RecordedObserver, NoObserver> {
        let _ = (of, recording);
        Err(NoObserver::new("the observer has no program"))
    }

    /// Its step for each sample, where it is not that of the recorded program.
    ///
    /// # Errors
    /// Why it has none.
    fn step(&self, of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        let _ = of;
        Ok(None)
    }

    /// The state at the start with what it tends to at once in place of what begins at zero.
    fn settled(&self, of: &StepOf<'_>, z: DVector<f64>, u: &DVector<f64>, y: &DVector<f64>) -> DVector<f64> {
        let _ = (of, u, y);
        z
    }

    /// What is to be known of this step.
    fn remark_of_step(&self) -> &'static str {
        ""
    }
}

/// The matrices of a linear observer `xhat' = A xhat + B u + L (y - C xhat - D u)`, in discrete time `xhat+`.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearForm {
    /// A, B, C and D.
    pub plant: StateSpace,
    /// L, n x p.
    pub l: DMatrix<f64>,
    /// The gain of the measurement update, n x p, of the filter form: the estimate is `xhat + K (y - C xhat - D u)`.
    pub update: Option<DMatrix<f64>>,
}

/// What the step of an observer is made of.
#[derive(Debug, Clone, Copy)]
pub struct StepOf<'a> {
    /// The study.
    pub study: &'a Study,
    /// The observer.
    pub observer: &'a ObserverSpec,
    /// Its design.
    pub designed: &'a Designed,
    /// The plant.
    pub plant: &'a ExpressionPlant,
    /// The sampling period.
    pub period: f64,
    /// Runge-Kutta steps per period, if they are given.
    pub substeps: Option<usize>,
}

pub(crate) fn continuous<'a>(observer: &'a (impl Observer<f64> + Sync)) -> Arc<dyn AnyObserver + 'a> {
    Arc::new(Continuous::new(observer))
}

pub(crate) fn sampled<'a>(observer: &'a (impl SampledObserver<f64> + Sync)) -> Arc<dyn AnyObserver + 'a> {
    Arc::new(Sampled(observer))
}

/// An observer, ready to run.
#[derive(Clone)]
pub struct Runnable(Arc<dyn Running>);

impl<O: Running> From<O> for Runnable {
    fn from(observer: O) -> Self {
        Self(Arc::new(observer))
    }
}

impl fmt::Debug for Runnable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl std::ops::Deref for Runnable {
    type Target = dyn Running;

    fn deref(&self) -> &Self::Target {
        &*self.0
    }
}

impl Runnable {
    /// The observer, if it is of this type.
    pub fn of<O: Running>(&self) -> Option<&O> {
        let any: &dyn Any = &*self.0;
        any.downcast_ref()
    }

    /// Lengths of its columns.
    pub fn dimensions(&self) -> ObserverDimensions {
        self.any().dimensions()
    }

    /// The sampling period; none in continuous time, and for an observer that predicts between its samples.
    pub fn period(&self) -> Option<f64> {
        self.any().period()
    }

    /// The entries of the state that gives this estimate at time `t`; none for slices of the wrong length.
    pub fn initial(&self, t: f64, estimate: &[f64], u: &[f64], y: &[f64]) -> Option<Vec<f64>> {
        let observer = self.any();
        let size = observer.dimensions();
        (estimate.len() == size.estimate && takes(size, u, y)).then(|| {
            let mut state = vec![0.0; size.state];
            observer.initial(t, estimate, u, y, &mut state);
            state
        })
    }

    /// The derivative of the state; for samples the next state. None for slices of the wrong length.
    ///
    /// ```
    /// use luenberger_study::{Format, Study, design::design, template};
    /// use std::sync::atomic::AtomicBool;
    /// let text = template::text("double-integrator").ok_or("a template")?;
    /// let study = Study::from_text("study.toml", text, Format::Toml, ".".as_ref())?;
    /// let designed = design(&study, &study.observers[0], &AtomicBool::new(false)).map_err(|why| format!("{why:?}"))?;
    /// // At rest, with the output that the estimate predicts.
    /// assert_eq!(designed.runnable.motion(0.0, &[1.0, 0.0], &[0.0], &[1.0]), Some(vec![0.0, 0.0]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn motion(&self, t: f64, state: &[f64], u: &[f64], y: &[f64]) -> Option<Vec<f64>> {
        let observer = self.any();
        let size = observer.dimensions();
        (state.len() == size.state && takes(size, u, y)).then(|| {
            let mut motion = state.to_vec();
            match observer.period() {
                None => observer.derivative(t, state, u, y, &mut motion),
                Some(_) => observer.step(t, &mut motion, u, y, &[]),
            }
            motion
        })
    }

    /// The estimate of a state; none for slices of the wrong length.
    pub fn estimate(&self, t: f64, state: &[f64], u: &[f64], y: &[f64]) -> Option<Vec<f64>> {
        let observer = self.any();
        let size = observer.dimensions();
        (state.len() == size.state && takes(size, u, y)).then(|| {
            let mut estimate = vec![0.0; size.estimate];
            observer.estimate(t, state, u, y, &mut estimate);
            estimate
        })
    }

    /// The estimate of a state with the measurement of its sample, where the observer has one; otherwise as
    /// [`estimate`](Self::estimate).
    pub fn estimate_at(&self, t: f64, state: &[f64], u: &[f64], y: &[f64]) -> Option<Vec<f64>> {
        let mut estimate = self.estimate(t, state, u, y)?;
        self.any().correct(state, u, y, &[], &mut estimate);
        Some(estimate)
    }

    /// The estimates of the disturbance, of an observer that has some, from its states (a row for each time).
    pub fn disturbance(&self, states: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let count = self.disturbances();
        let first = states.ncols().checked_sub(count)?;
        (count > 0).then(|| states.columns(first, count).into_owned())
    }

    /// The probabilities of the models of an observer that has several, from its states (a row for each time).
    pub fn modes(&self, states: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let of = |row: Vec<f64>| self.0.mode_probabilities(&row).map(|modes| modes.transpose());
        let rows: Vec<_> = states.row_iter().map(|row| of(row.iter().copied().collect())).collect::<Option<_>>()?;
        if rows.is_empty() { None } else { Some(DMatrix::from_rows(&rows)) }
    }

    /// The half-widths of the bounds of an interval observer, from its states (a row for each time).
    pub fn half_widths(&self, states: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let of = |row: Vec<f64>| self.0.half_widths_of(&row).map(|widths| widths.transpose());
        let rows: Vec<_> = states.row_iter().map(|row| of(row.iter().copied().collect())).collect::<Option<_>>()?;
        if rows.is_empty() { None } else { Some(DMatrix::from_rows(&rows)) }
    }
}

/// Whether inputs and outputs have these lengths.
fn takes(size: ObserverDimensions, u: &[f64], y: &[f64]) -> bool {
    u.len() == size.inputs && y.len() == size.outputs
}
