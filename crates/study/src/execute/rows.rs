//! The rows of a run.

use luenberger_sim::SampleTime;
use nalgebra::DMatrix;

use crate::results::ObserverRun;

/// Result of a run: one row for each time.
pub(super) struct Run {
    pub(super) t: Vec<f64>,
    pub(super) x: DMatrix<f64>,
    pub(super) u: DMatrix<f64>,
    /// The measured outputs, with noise.
    pub(super) y: DMatrix<f64>,
    /// The estimates of the observer; none for the plant alone.
    pub(super) estimate: Option<DMatrix<f64>>,
    /// `y - h(xhat)` as the observer had it, on a log; NaN where nothing was measured.
    pub(super) innovation: Option<DMatrix<f64>>,
    /// The standard deviations of the estimates, of a filter; those of a stationary one are constant.
    pub(super) deviation: Option<DMatrix<f64>>,
    /// The half-widths of the bounds, of an interval observer.
    pub(super) half_width: Option<DMatrix<f64>>,
    /// The smoothed estimates with their standard deviations, of a filter on a log.
    pub(super) smoothed: Option<(DMatrix<f64>, DMatrix<f64>)>,
    /// Functions of the state and their estimates with their names, of an observer of functions.
    pub(super) functions: Option<(Vec<String>, DMatrix<f64>, DMatrix<f64>)>,
    /// The estimates of disturbances with their names, of an observer that has some.
    pub(super) disturbance: Option<(Vec<String>, DMatrix<f64>)>,
    /// The probabilities of the models of a filter that has several, with their names.
    pub(super) modes: Option<(Vec<String>, DMatrix<f64>)>,
    /// The samples of an observer at varying periods; none on a log.
    pub(super) samples: Vec<SampleTime>,
    /// What limits the use of its log, or that it left the region of its design.
    pub(super) warnings: Vec<String>,
}

impl Run {
    /// As the results have it.
    pub(super) fn named(self, observer: &str, on_log: bool) -> ObserverRun {
        let Self { t, x, u, y, estimate, deviation, smoothed, .. } = self;
        let (functions, estimate) = match self.functions {
            Some((names, functions, estimate)) => (Some((names, functions)), Some(estimate)),
            None => (None, estimate),
        };
        ObserverRun {
            observer: observer.to_owned(),
            on_log,
            t,
            x,
            u,
            y,
            estimate,
            functions,
            deviation,
            smoothed,
            half_width: self.half_width,
            disturbance: self.disturbance,
            modes: self.modes,
            warnings: self.warnings,
        }
    }
}
