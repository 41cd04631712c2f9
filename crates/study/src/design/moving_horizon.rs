//! Moving-horizon estimators.

use luenberger_observers::{MovingHorizonEstimator, NoiseModel, Prediction};
use luenberger_proof::wording::counted;
use nalgebra::DVector;

use super::explain::Misfit;
use super::{Designed, matrix, number, uncertified};
use crate::model::Model;
use crate::results::{DesignReport, Statement};
use crate::runnable::Runnable;
use crate::study::MovingHorizonSpec;

/// The estimator of a plant in continuous or in discrete time.
pub(super) fn design(model: &Model, spec: &MovingHorizonSpec, prediction: Prediction) -> Result<Designed, Misfit> {
    let MovingHorizonSpec { w, v, p0, period, horizon, bounds, .. } = spec;
    let noises = NoiseModel { w: w.clone(), v: v.clone(), p0: p0.clone() };
    let mut estimator =
        MovingHorizonEstimator::discrete(model.clone(), noises, *horizon, *period)?.with_prediction(prediction)?;
    let mut bounded = String::new();
    if let Some(bounds) = bounds {
        let (lower, upper): (Vec<f64>, Vec<f64>) = bounds.iter().copied().unzip();
        estimator = estimator.with_bounds(DVector::from_vec(lower), DVector::from_vec(upper))?;
        " The estimates at the samples stay within the bounds of the states.".clone_into(&mut bounded);
    }
    let report = DesignReport {
        statement: Statement::of(format!(
            "One measurement every {period}; the states of the last {} by least squares, {} at each.{bounded}",
            counted(horizon.window, "sample"),
            counted(horizon.iterations, "Gauss-Newton step")
        )),
        matrices: vec![matrix("W", w), matrix("V", v), matrix("P(0)", p0)],
        numbers: vec![
            number("period", *period),
            number("window", horizon.window as f64),
            number("iterations", horizon.iterations as f64),
        ],
        ..uncertified("no theorem of stability")
    };
    Ok(Designed::new(Runnable::MovingHorizon(Box::new(estimator)), report, None))
}
