//! The steps of observers of a linear plant: with a constant gain, in filter form, with a cubic part, at varying
//! periods.

use luenberger_observers::SampledCubicObserver;
use luenberger_observers::semi_implicit::reach;
use luenberger_observers::varying_period::DEGREE;
use nalgebra::{DMatrix, Dyn};

use super::kernels::{self, Macros};
use crate::Export;
use crate::exportable_observer::ExportableObserver;
use crate::scalar::Scalar;

pub(super) fn step(text: &mut String, export: &Export) {
    let mut macros = Macros::of(export);
    let cubic = match &export.observer {
        ExportableObserver::Cubic(observer) => Some(observer),
        ExportableObserver::Varying(step) => Some(step.observer().nominal()),
        _ => None,
    };
    macros.option("CUBIC", cubic.is_some());
    if let Some(cubic) = cubic {
        flow(text, export, &mut macros, cubic);
    }
    if export.observer.takes_time() {
        let parts = export.observer.prediction_substeps(export.scalar);
        macros.number("PARTS", parts as f64);
        macros.integer("PART_COUNT", parts);
        macros.integer("SERIES_DEGREE", DEGREE);
        macros.write(text, kernels::VARYING);
    } else {
        macros.write(text, kernels::LINEAR);
    }
}

/// The flow of the cubic part, exact or in a semi-implicit step.
fn flow(text: &mut String, export: &Export, macros: &mut Macros, cubic: &SampledCubicObserver<f64, Dyn, Dyn, Dyn>) {
    let (epsilon, largest) = match export.scalar {
        Scalar::Binary32 => (f64::from(f32::EPSILON), f64::from(f32::MAX.sqrt())),
        Scalar::Binary64 => (f64::EPSILON, f64::MAX.sqrt()),
    };
    let largest = cubic.coupling().map_or(largest, |coupling| reach_of(coupling, export.scalar));
    macros.number("CUBIC_RATE", cubic.w());
    macros.number("LARGE_REACH", 1.0 / epsilon);
    macros.number("MOST_PULL", largest);
    macros.write(text, if cubic.coupling().is_some() { kernels::SEMI_IMPLICIT } else { kernels::CUBIC_FLOW });
}

/// The largest s of a semi-implicit step, as it is computed in the format.
fn reach_of(coupling: &DMatrix<f64>, scalar: Scalar) -> f64 {
    match scalar {
        Scalar::Binary32 => f64::from(reach(&coupling.map(|x| x as f32))),
        Scalar::Binary64 => reach(coupling),
    }
}
