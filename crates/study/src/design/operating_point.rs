//! Linear observers of a nonlinear plant, shifted to its operating point.

use luenberger_design::{DesignError, OperatingPoint};
use luenberger_observers::DeviationObserver;
use luenberger_proof::wording::significant;

use super::Designed;
use super::explain::Misfit;
use crate::model::Model;
use crate::results::Statement;
use crate::runnable::{At, Runnable};
use crate::study::Study;

/// The observer of the linearisation, run in deviations from the operating point, with what its certificate speaks of.
pub(super) fn shifted(study: &Study, design: Designed, point: &OperatingPoint) -> Result<Designed, Misfit> {
    let Designed { runnable, mut report, certificate, origin } = design;
    let runnable = match runnable {
        Runnable::Linear(observer) => Runnable::LinearAt(Box::new(at(*observer, point)?)),
        Runnable::Cubic(observer) => Runnable::CubicAt(Box::new(at(*observer, point)?)),
        Runnable::SampledCubic(observer) => Runnable::SampledCubicAt(Box::new(at(*observer, point)?)),
        Runnable::VaryingPeriods(varying) => Runnable::VaryingPeriods(Box::new(varying.at(point)?)),
        other => other,
    };
    let named = |names: &[String], values: &[f64]| {
        let one = |(name, value): (&String, &f64)| format!("{name} = {}", significant(*value, 5));
        names.iter().zip(values).map(one).collect::<Vec<_>>().join(", ")
    };
    let mut place = named(&study.plant.states, point.x.as_slice());
    if !point.u.is_empty() {
        place = format!("{place}; {}", named(&study.plant.inputs, point.u.as_slice()));
    }
    let truth = if is_affine(&study.plant.model) {
        "The plant is affine: up to the rounding of A, B, C and of the operating point this system is the plant."
    } else {
        "The certificate is of the linearisation: nothing is proved of the nonlinear plant."
    };
    report.statement =
        Statement::of(format!("Linearised at the operating point {place}.")).and(&report.statement).remark(truth);
    Ok(Designed { runnable, report, certificate, origin })
}

fn at<O>(observer: O, point: &OperatingPoint) -> Result<At<O>, Misfit> {
    let made = DeviationObserver::new(observer, point.x.clone(), point.u.clone(), point.y.clone());
    made.map_err(|error| DesignError::from(error).into())
}

fn is_affine(model: &Model) -> bool {
    matches!(model, Model::Expressions(plant) if plant.affine().is_ok())
}
