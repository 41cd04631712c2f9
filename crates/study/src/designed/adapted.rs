//! Filters with the noises of a study along their way, with correlated noises, and with bounds of their estimates.

use std::fmt;
use std::sync::Arc;

use luenberger_expression::Expression;
use luenberger_observers::{
    AdaptableFilter, AdaptedFilter, CorrelatedFilter, DecorrelatedPlant, DelayedFilter, NoisesAlong, ObserverError,
    SampledObserver,
};
use luenberger_sim::{Replay, Samples};
use nalgebra::{DMatrix, DVector};

use super::{NonlinearStep, Runnable, Running, StepOf, runs_as_filter};
use crate::designed;
use crate::model::Model;
use crate::results::NoObserver;

/// The noises of a filter that are not constant: expressions of t, the estimate and the input.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Along {
    /// W.
    pub(crate) process: Option<ProcessNoise>,
    /// The diagonal of V, p expressions.
    pub(crate) measurement: Option<Vec<Expression>>,
}

/// `W = G Q G'`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ProcessNoise {
    /// G, n x q by rows; none for the identity.
    pub(crate) g: Option<Vec<Expression>>,
    /// Q.
    pub(crate) q: Intensity,
}

/// A covariance of order q.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Intensity {
    Constant(DMatrix<f64>),
    Diagonal(Vec<Expression>),
}

impl Along {
    /// Whether all noises are constant.
    pub(crate) fn is_constant(&self) -> bool {
        self.process.is_none() && self.measurement.is_none()
    }

    /// What the design says of them; empty if they are constant.
    pub(crate) fn words(&self) -> String {
        let list = |rows: &[Expression]| rows.iter().map(Expression::text).collect::<Vec<_>>().join(", ");
        let process = self.process.as_ref().map(|process| {
            let q = match &process.q {
                Intensity::Diagonal(rows) => format!("w = [{}]", list(rows)),
                Intensity::Constant(_) => "constant w".to_owned(),
            };
            let entering =
                process.g.as_ref().map(|g| format!(" and g = [{}], W = g w g'", list(g))).unwrap_or_default();
            format!(" W is that of the estimate before each prediction, by {q}{entering}.")
        });
        let measurement = self
            .measurement
            .as_ref()
            .map(|rows| format!(" V is that of the prediction for each sample, v = [{}].", list(rows)));
        process.into_iter().chain(measurement).collect()
    }
}

/// The variances of the measurements of a log, by its rows.
#[derive(Debug, Clone)]
pub struct RowVariances(pub(crate) Samples);

/// What a filter of a study takes in place of its constant noises.
#[derive(Debug, Clone, Default)]
pub(crate) struct NoisesOfStudy {
    along: Along,
    rows: Option<Arc<RowVariances>>,
    /// Of each output, how long after its time it stands in its row; empty if none is late.
    delays: Vec<f64>,
}

impl NoisesAlong<f64> for NoisesOfStudy {
    // The parameters that are estimated, behind the n states of G, have noises of their own.
    fn process_noise(&self, t: f64, xhat: &[f64], u: &[f64], w: &mut [f64]) -> bool {
        let Some(ProcessNoise { g, q }) = &self.along.process else { return false };
        let value = |row: &Expression| row.evaluate(t, xhat, u);
        let q = match q {
            Intensity::Constant(q) => q.clone(),
            Intensity::Diagonal(rows) => {
                DMatrix::from_diagonal(&DVector::from_iterator(rows.len(), rows.iter().map(value)))
            }
        };
        let whole = match g {
            None => q,
            Some(g) => {
                let columns = q.nrows();
                let g = DMatrix::from_row_iterator(g.len() / columns.max(1), columns, g.iter().map(value));
                &g * q * g.transpose()
            }
        };
        for j in 0..whole.ncols() {
            for i in 0..whole.nrows() {
                w[j * xhat.len() + i] = whole[(i, j)];
            }
        }
        true
    }

    fn measurement_noise(&self, t: f64, xhat: &[f64], u: &[f64], v: &mut [f64]) -> bool {
        let given = self.along.measurement.as_deref();
        let outputs = given.map_or_else(|| v.len().isqrt(), <[Expression]>::len);
        for (j, row) in given.into_iter().flatten().enumerate() {
            v[j * outputs + j] = row.evaluate(t, xhat, u);
        }
        let mut has_row = false;
        if let Some(rows) = &self.rows {
            let delay = |j: usize| self.delays.get(j).copied().unwrap_or(0.0);
            for (j, variance) in (0..outputs).filter_map(|j| Some((j, rows.at(t + delay(j), j)?))) {
                has_row = true;
                // Correlations stay.
                let factor = (variance / v[j * outputs + j]).sqrt();
                for k in (0..outputs).filter(|k| *k != j) {
                    v[j * outputs + k] *= factor;
                    v[k * outputs + j] *= factor;
                }
                v[j * outputs + j] = variance;
            }
        }
        given.is_some() || has_row
    }
}

impl RowVariances {
    /// That of output j in the row at this time, if the log has it.
    fn at(&self, t: f64, j: usize) -> Option<f64> {
        let times = self.0.times();
        // A sample of a plant in discrete time is up to a hundredth of a period from its row.
        let next = times.partition_point(|time| *time < t);
        let near = |k: usize| times.get(k).map(|time| (k, (time - t).abs()));
        let before = next.checked_sub(1).and_then(near);
        let (row, _) = before.into_iter().chain(near(next)).min_by(|a, b| a.1.total_cmp(&b.1))?;
        self.0.value(row, j)
    }
}

/// What a filter has to be to get the noises of a study.
pub(crate) trait OfStudy:
    AdaptableFilter<f64, Input = DVector<f64>, Output = DVector<f64>, Estimate = DVector<f64>>
    + Running
    + Clone
    + fmt::Debug
{
}

impl<F> OfStudy for F where
    F: AdaptableFilter<f64, Input = DVector<f64>, Output = DVector<f64>, Estimate = DVector<f64>>
        + Running
        + Clone
        + fmt::Debug
{
}

/// What a filter has to be to get correlated noises.
pub(crate) trait Correlatable:
    AdaptableFilter<f64, Input = DVector<f64>, Output = DVector<f64>, Estimate = DVector<f64>>
    + Clone
    + fmt::Debug
    + Send
    + Sync
    + 'static
{
}

impl<F> Correlatable for F where
    F: AdaptableFilter<f64, Input = DVector<f64>, Output = DVector<f64>, Estimate = DVector<f64>>
        + Clone
        + fmt::Debug
        + Send
        + Sync
        + 'static
{
}

/// The plant of a filter of correlated noises, with the full turns of its outputs.
pub(crate) fn decorrelated(
    model: Model,
    turns: Option<DVector<f64>>,
) -> Result<DecorrelatedPlant<Model, f64>, ObserverError> {
    let plant = DecorrelatedPlant::new(model);
    match turns {
        Some(turns) => plant.with_angles(turns),
        None => Ok(plant),
    }
}

/// The filter of a [`decorrelated`] plant with the cross-covariance S of its noises, and these bounds of its estimates.
pub(crate) fn correlated<F: Correlatable>(
    filter: F,
    bounds: Option<&[(f64, f64)]>,
    s: &DMatrix<f64>,
) -> Result<Runnable, NoObserver> {
    let filter = bounded(AdaptedFilter::new(filter, NoisesOfStudy::default()), bounds)?;
    Ok(CorrelatedFilter::new(filter, s.clone())?.into())
}

fn bounded<F: AdaptableFilter<f64>>(
    filter: AdaptedFilter<F, f64, NoisesOfStudy>,
    bounds: Option<&[(f64, f64)]>,
) -> Result<AdaptedFilter<F, f64, NoisesOfStudy>, ObserverError> {
    let Some(bounds) = bounds else { return Ok(filter) };
    let (lower, upper): (Vec<f64>, Vec<f64>) = bounds.iter().copied().unzip();
    filter.with_bounds(&lower, &upper)
}

/// The filter with these noises along its way, these bounds of its estimates, and these delays of its outputs; itself
/// if there are none.
pub(crate) fn adapted<F: OfStudy>(
    filter: F,
    along: &Along,
    bounds: Option<&[(f64, f64)]>,
    delays: &[f64],
) -> Result<Runnable, NoObserver>
where
    F::State: Clone,
{
    if along.is_constant() && bounds.is_none() && delays.is_empty() {
        return Ok(filter.into());
    }
    let noises = NoisesOfStudy { along: along.clone(), rows: None, delays: delays.to_vec() };
    let filter = bounded(AdaptedFilter::new(filter, noises), bounds)?;
    if delays.is_empty() {
        return Ok(filter.into());
    }
    let period = SampledObserver::<f64>::period(&filter);
    let steps = (delays.iter().copied().fold(0.0, f64::max) / period).ceil() as usize;
    Ok(DelayedFilter::new(filter, delays, times_kept(steps))?.into())
}

/// The times that a filter keeps of late measurements that are at most so many steps old: a late measurement may be a
/// time of its own between two.
fn times_kept(steps: usize) -> usize {
    2 * steps + 4
}

/// The filter with the variances of the rows of a log.
pub(crate) fn with_variances<F: OfStudy>(filter: &F, rows: &Arc<RowVariances>) -> Runnable
where
    F::State: Clone,
{
    let noises = NoisesOfStudy { rows: Some(Arc::clone(rows)), ..NoisesOfStudy::default() };
    AdaptedFilter::new(filter.clone(), noises).into()
}

impl<F: OfStudy> Running for DelayedFilter<AdaptedFilter<F, f64, NoisesOfStudy>, f64>
where
    F::State: Clone,
{
    fn any(&self) -> Arc<dyn luenberger_sim::AnyObserver + '_> {
        designed::sampled(self)
    }

    // The rows of a log may be closer than the period.
    fn replay<'a>(&'a self, replay: Replay<'a>, name: &str, initial: &[f64]) -> Replay<'a> {
        let longest = self.delays().iter().copied().fold(0.0, f64::max);
        let period = SampledObserver::<f64>::period(self);
        let times = replay.recording().times();
        let mut steps = vec![0.0];
        for pair in times.windows(2) {
            steps.push(steps[steps.len() - 1] + ((pair[1] - pair[0]) / period).ceil());
        }
        let within = |k: usize| {
            let first = times.partition_point(|t| *t < times[k] - longest).saturating_sub(1);
            (steps[k] - steps[first]) as usize
        };
        let most = times_kept((0..times.len()).map(within).max().unwrap_or(0));
        let filter = self.keeping(most).unwrap_or_else(|_| self.clone());
        replay.filter(name, filter, initial)
    }

    fn filter(&self) -> Option<&dyn designed::Filter> {
        Some(self)
    }

    fn with_variances(&self, rows: &Arc<RowVariances>) -> Option<Runnable> {
        let inner = self.inner();
        let noises = NoisesOfStudy { rows: Some(Arc::clone(rows)), ..inner.along().clone() };
        let filter = inner.clone().with_noises_along(noises);
        Some(DelayedFilter::new(filter, self.delays(), self.times_kept()).ok()?.into())
    }

    fn step(&self, of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        let name = of.observer.kind.name();
        Err(NoObserver::new(format!("the exported step of {name} takes no late measurements"))
            .hint("a plant without `delays`"))
    }
}

impl<F: OfStudy> Running for AdaptedFilter<F, f64, NoisesOfStudy>
where
    F::State: Clone,
{
    runs_as_filter!();

    fn with_variances(&self, rows: &Arc<RowVariances>) -> Option<Runnable> {
        let noises = NoisesOfStudy { rows: Some(Arc::clone(rows)), ..self.along().clone() };
        Some(self.clone().with_noises_along(noises).into())
    }

    fn step(&self, of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        let what = if self.along().along.is_constant() {
            "bounds of its estimates"
        } else {
            "noises that are expressions of the estimate"
        };
        let name = of.observer.kind.name();
        Err(NoObserver::new(format!("the exported step of {name} has no {what}"))
            .hint("an observer without them, or mhe for bounds"))
    }
}

impl<F: Correlatable> Running for CorrelatedFilter<F, f64, NoisesOfStudy> {
    runs_as_filter!();

    fn with_variances(&self, rows: &Arc<RowVariances>) -> Option<Runnable> {
        let noises = NoisesOfStudy { rows: Some(Arc::clone(rows)), ..self.inner().along().clone() };
        Some(self.clone().with_noises_along(noises).into())
    }

    fn step(&self, of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        let name = of.observer.kind.name();
        Err(NoObserver::new(format!("the exported step of {name} has no cross-covariance of the noises"))
            .hint("an observer without `s`; kalman of a linear plant is exported with it"))
    }
}
