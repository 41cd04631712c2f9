//! The step of an export in binary64, sample by sample, with its estimates and bands.

use std::fmt;
use std::sync::Arc;

use luenberger_export::{Export, ExportableObserver};
use luenberger_observers::{ObserverError, StationaryKalmanFilter};
use luenberger_plants::Plant;
use luenberger_sim::{AnyObserver, Estimates, Sampled};
use nalgebra::{DMatrix, DVector};

use super::position::Position;
use crate::deployment::{ExportRefusal, SampledDesign};
use crate::designed::{Designed, Filter};
use crate::model::Model;
use crate::study::{ObserverSpec, Study};

/// The estimates of a row.
pub(super) struct Shown {
    pub(super) values: Vec<f64>,
    /// Columns of the band, one after the other.
    pub(super) bands: Vec<Vec<f64>>,
    /// Whether the band is known.
    pub(super) has_bands: bool,
    /// Whether they are those at the sample of the row, and not for the next one.
    pub(super) is_of_sample: bool,
}

/// What is known of the error beside the estimate.
enum Band {
    Nothing,
    /// The covariance of a filter.
    Covariance(Box<dyn Filter + Send>),
    /// The standard deviations of a stationary filter, while nothing is missing.
    Stationary(Vec<f64>),
    /// The half-widths behind the estimate, while nothing is missing.
    HalfWidths,
}

/// The step.
pub(super) struct StepOfStream {
    observer: String,
    any: Arc<dyn AnyObserver>,
    plant: Model,
    /// The names of the estimates that are shown, which are the first.
    names: Vec<String>,
    initial: Vec<f64>,
    period: f64,
    /// Inputs of the plant.
    inputs: usize,
    takes_time: bool,
    /// Whether the estimate after a step is that of its sample.
    is_of_sample: bool,
    /// Whether the estimate begins with the state of the plant before the next sample.
    predicts_outputs: bool,
    band: Band,
}

impl fmt::Debug for StepOfStream {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("StepOfStream").field("observer", &self.observer).field("any", &self.any).finish_non_exhaustive()
    }
}

/// An observer as it is stepped, and its covariance if it has one.
type Stepped = (Arc<dyn AnyObserver>, Option<Box<dyn Filter + Send>>);

/// The observer of an export.
fn stepped(export: &Export) -> Result<Stepped, ObserverError> {
    let any: Arc<dyn AnyObserver> = match (export.observer().clone(), export.update_gain()) {
        (ExportableObserver::Linear(of), Some(k)) => Arc::new(Sampled(StationaryKalmanFilter::new(of, k.clone())?)),
        (ExportableObserver::Linear(of), None) => Arc::new(Sampled(of)),
        (ExportableObserver::Cubic(of), _) => Arc::new(Sampled(of)),
        (ExportableObserver::Varying(of), _) => Arc::new(Sampled(of)),
        (ExportableObserver::Kalman(of), _) => return Ok((Arc::new(Sampled(of.clone())), Some(Box::new(of)))),
        (ExportableObserver::Unscented(of), _) => return Ok((Arc::new(Sampled(of.clone())), Some(Box::new(of)))),
        (ExportableObserver::MovingHorizon(of), _) => return Ok((Arc::new(Sampled(of.clone())), Some(Box::new(of)))),
        (ExportableObserver::SampledNonlinear(of), _) => Arc::new(Sampled(of)),
        (ExportableObserver::Discrete(of), _) => Arc::new(Sampled(of)),
        (ExportableObserver::Kkl(of), _) => Arc::new(Sampled(of)),
        (ExportableObserver::Extension(of), _) => Arc::new(Sampled(of)),
        (ExportableObserver::Step(of), _) => Arc::new(Sampled(of)),
    };
    Ok((any, None))
}

impl StepOfStream {
    pub(super) fn of(
        (study, observer, designed): (&Study, &ObserverSpec, &Designed),
        design: &SampledDesign,
        export: &Export,
    ) -> Result<Self, ExportRefusal> {
        let (any, filter) = stepped(export).map_err(|error| ExportRefusal::design(observer, error.into()))?;
        let of_plant = observer.kind.functions().is_none();
        let shown = match observer.kind.functions() {
            Some((_, names)) => names,
            None => [study.plant.states.clone(), observer.kind.estimated_disturbances()].concat(),
        };
        let count = shown.len().min(any.dimensions().estimate);
        let is_of_sample = export.is_of_sample() && !export.is_filter() || export.observer().takes_time();
        let stationary = designed.report.stationary_deviation.clone().filter(|_| study.plant.dt.is_some());
        let band = match (filter, design, stationary) {
            (Some(filter), ..) => Band::Covariance(filter),
            (None, SampledDesign::Interval(_), _) => Band::HalfWidths,
            (None, _, Some(deviation)) => Band::Stationary(deviation),
            _ => Band::Nothing,
        };
        Ok(Self {
            observer: observer.name.clone(),
            any,
            plant: study.plant.model.clone(),
            names: shown[..count].to_vec(),
            initial: export.first_estimate().to_vec(),
            period: export.observer().period(),
            inputs: export.observer().plant_inputs(),
            takes_time: export.observer().takes_time(),
            is_of_sample,
            predicts_outputs: of_plant && !is_of_sample && count >= study.plant.states.len(),
            band,
        })
    }

    pub(super) fn observer(&self) -> &str {
        &self.observer
    }

    pub(super) fn period(&self) -> f64 {
        self.period
    }

    /// Whether a step takes the time since the last one.
    pub(super) fn takes_time(&self) -> bool {
        self.takes_time
    }

    /// The names of the results.
    pub(super) fn names(&self, estimates: Estimates) -> Vec<String> {
        let all = |ending: &str| self.names.iter().map(|name| format!("{name}{ending}")).collect::<Vec<_>>();
        let bands: &[&str] = match &self.band {
            Band::Nothing => &[],
            // Its covariance is that of the estimate with the measurement.
            Band::Stationary(_) if estimates == Estimates::Predicted => &[],
            Band::Covariance(_) | Band::Stationary(_) => &["_2sigma"],
            Band::HalfWidths => &["_lower", "_upper"],
        };
        let bands = bands.iter().flat_map(|ending| all(ending));
        std::iter::once("t".to_owned()).chain(all("_hat")).chain(bands).collect()
    }

    /// The position before the first row.
    pub(super) fn start(&self) -> Position {
        let size = self.any.dimensions();
        let mut state = vec![0.0; size.state];
        self.any.initial(0.0, &self.initial, &vec![0.0; size.inputs], &vec![0.0; size.outputs], &mut state);
        Position {
            samples: 0,
            state,
            time: None,
            inputs: vec![0.0; self.inputs],
            outputs: vec![0.0; size.outputs],
            has_missed: false,
            times: "unknown".to_owned(),
        }
    }

    /// A sample that is missed.
    pub(super) fn miss(&self, at: &mut Position) {
        self.take(at, &vec![None; at.outputs.len()], self.period, Estimates::Predicted);
    }

    /// A sample.
    pub(super) fn take(&self, at: &mut Position, outputs: &[Option<f64>], elapsed: f64, estimates: Estimates) -> Shown {
        let t = at.samples as f64 * self.period;
        let mut u = at.inputs.clone();
        u.extend(self.takes_time.then_some(elapsed));
        let measured: Vec<bool> = outputs.iter().map(Option::is_some).collect();
        for (last, output) in at.outputs.iter_mut().zip(outputs) {
            *last = output.unwrap_or(*last);
        }
        at.has_missed |= measured.contains(&false);
        let mut y = at.outputs.clone();
        if measured.contains(&false) && self.predicts_outputs {
            let n = self.plant.size().states;
            let xhat = DVector::from_column_slice(&self.estimate(&at.state)[..n]);
            let h = self.plant.output(t, &xhat, &DVector::from_column_slice(&at.inputs));
            for ((y, h), _) in y.iter_mut().zip(&h).zip(&measured).filter(|(_, measured)| !**measured) {
                *y = *h;
            }
        }
        let of_sample = (estimates == Estimates::Filtered).then(|| self.filtered((t, &at.state), &u, &y, &measured));
        self.any.step(t, &mut at.state, &u, &y, &measured);
        at.samples += 1;
        let (values, state, is_of_sample) = match of_sample.flatten() {
            Some((values, state)) => (values, state, true),
            None => (self.estimate(&at.state), at.state.clone(), self.is_of_sample),
        };
        let (bands, has_bands) = self.bands(&values, &state, at.has_missed, estimates);
        Shown { values: values[..self.names.len()].to_vec(), bands, has_bands, is_of_sample }
    }

    /// The estimate with the measurement of the sample, and the state that has it, of a filter.
    fn filtered(
        &self,
        (t, state): (f64, &[f64]),
        u: &[f64],
        y: &[f64],
        measured: &[bool],
    ) -> Option<(Vec<f64>, Vec<f64>)> {
        let mut state = state.to_vec();
        if self.any.is_filter() {
            let mut values = self.estimate(&state);
            self.any.correct(&state, u, y, measured, &mut values);
            return Some((values, state));
        }
        self.any.update(t, &mut state, u, y, measured).then(|| (self.estimate(&state), state))
    }

    fn estimate(&self, state: &[f64]) -> Vec<f64> {
        let size = self.any.dimensions();
        let mut estimate = vec![0.0; size.estimate];
        self.any.estimate(0.0, state, &vec![0.0; size.inputs], &vec![0.0; size.outputs], &mut estimate);
        estimate
    }

    /// The columns of the band, and whether it is known.
    fn bands(&self, values: &[f64], state: &[f64], has_missed: bool, estimates: Estimates) -> (Vec<Vec<f64>>, bool) {
        let twice = |deviation: &[f64]| vec![deviation.iter().map(|sigma| 2.0 * sigma).collect()];
        match &self.band {
            Band::Nothing => (Vec::new(), false),
            Band::Covariance(filter) => {
                let deviation = filter.deviation(&DMatrix::from_row_slice(1, state.len(), state), self.names.len());
                (twice(deviation.as_slice()), true)
            }
            Band::Stationary(_) if estimates == Estimates::Predicted => (Vec::new(), false),
            Band::Stationary(deviation) => (twice(deviation), !has_missed),
            Band::HalfWidths => {
                let n = self.names.len();
                let side = |sign: f64| (0..n).map(|i| values[i] + sign * values[n + i]).collect();
                (vec![side(-1.0), side(1.0)], !has_missed)
            }
        }
    }
}
