//! Unscented Kalman filters.

use luenberger_observers::{NoiseModel, Prediction, UnscentedKalmanFilter};

use super::explain::Misfit;
use super::{Designed, matrix, number, uncertified};
use crate::model::Model;
use crate::results::{DesignReport, Statement};
use crate::runnable::Runnable;
use crate::study::UnscentedSpec;

/// The filter of a plant in continuous or in discrete time.
pub(super) fn design(model: &Model, spec: &UnscentedSpec, prediction: Prediction) -> Result<Designed, Misfit> {
    let UnscentedSpec { w, v, p0, sigma, period, gate, .. } = spec;
    let noises = NoiseModel { w: w.clone(), v: v.clone(), p0: p0.clone() };
    let mut filter =
        UnscentedKalmanFilter::discrete(model.clone(), noises, *sigma, *period)?.with_prediction(prediction)?;
    let mut gated = String::new();
    if let Some(gate) = gate {
        filter = filter.with_gate(*gate)?;
        gated = format!(" Innovations beyond {gate} standard deviations are rejected.");
    }
    let points = 2 * w.nrows() + 1;
    let report = DesignReport {
        statement: Statement::of(format!(
            "One measurement every {period}; mean and covariance from {points} sigma points, the covariance by its factor.{gated}"
        )),
        matrices: vec![matrix("W", w), matrix("V", v), matrix("P(0)", p0)],
        numbers: vec![
            number("period", *period),
            number("alpha", sigma.alpha),
            number("beta", sigma.beta),
            number("kappa", sigma.kappa),
        ],
        ..uncertified("no theorem of stability")
    };
    Ok(Designed::new(Runnable::Unscented(Box::new(filter)), report, None))
}
