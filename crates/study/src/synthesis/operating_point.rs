//! Linear observers of a nonlinear plant, shifted to its operating point.

use luenberger_design::{DesignError, OperatingPoint};
use luenberger_live as live;
use luenberger_observers::DeviationObserver;
use luenberger_proof::wording::significant;

use super::Designed;
use crate::designed::At;
use crate::model::Model;
use crate::results::{NoObserver, Statement};
use crate::study::Study;

/// The observer of the linearisation, run in deviations from the operating point, with what its certificate speaks of.
pub(crate) fn shifted(study: &Study, design: Designed, point: &OperatingPoint) -> Result<Designed, NoObserver> {
    let Designed { runnable, mut report, certificate, origin } = design;
    let runnable = match runnable.at(point) {
        Some(shifted) => shifted?,
        None => runnable,
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

/// The observer in deviations from the point.
pub(crate) fn in_deviations<O>(observer: O, point: &OperatingPoint) -> Result<At<O>, DesignError> {
    let made = DeviationObserver::new(observer, point.x.clone(), point.u.clone(), point.y.clone());
    Ok(made?)
}

fn is_affine(model: &Model) -> bool {
    matches!(model, Model::Expressions(plant, _) if plant.affine().is_ok())
}

/// The operating point of an observer as the page of a report has it.
pub(crate) fn page_point<O>(at: &At<O>) -> live::OperatingPoint {
    let [x, u, y] = [at.x0(), at.u0(), at.y0()].map(|entries| entries.as_slice().to_vec());
    live::OperatingPoint { x, u, y }
}
