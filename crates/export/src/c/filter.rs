//! The steps of the extended and of the unscented Kalman filter.

use luenberger_expression::ExpressionPlant;
use luenberger_observers::{ExtendedKalmanFilter, UnscentedKalmanFilter};
use nalgebra::Dyn;

use super::kernels::{self, Macros};
use super::plant;
use crate::Export;
use crate::exportable_observer::Maps;

type Extended = ExtendedKalmanFilter<ExpressionPlant, f64, Dyn, Dyn, Dyn>;

pub(super) fn extended(text: &mut String, export: &Export, maps: &Maps, filter: &Extended) {
    plant::functions(text, export, maps);
    let mut macros = Macros::of(export);
    macros.option("ITERATED", filter.iterations() > 1);
    macros.integer("ITERATIONS", filter.iterations());
    transition(text, export, &macros);
    macros.write(text, kernels::INNOVATION);
    angles(text, export, &macros);
    macros.write(text, kernels::KALMAN);
    step(text, export, &macros);
}

/// The step, and its halves where they are functions of their own.
fn step(text: &mut String, export: &Export, macros: &Macros) {
    macros.write(text, kernels::FILTER_STEP);
    if export.has_halves() {
        macros.write(text, kernels::FILTER_HALVES);
    }
}

/// Differences of angles, where there are some.
pub(super) fn angles(text: &mut String, export: &Export, macros: &Macros) {
    if export.observer.turns().is_some() {
        macros.write(text, kernels::ANGLES);
    }
}

/// The plant over a period.
pub(super) fn transition(text: &mut String, export: &Export, macros: &Macros) {
    if export.observer.unit_vectors().is_none() {
        macros.write(text, kernels::SYMMETRIC);
    }
    if export.observer.substeps().is_some() {
        macros.write(text, kernels::CLASSICAL);
    }
    macros.write(text, kernels::TRANSITION);
}

type Unscented = UnscentedKalmanFilter<ExpressionPlant, f64, Dyn, Dyn, Dyn>;

pub(super) fn unscented(text: &mut String, export: &Export, maps: &Maps, filter: &Unscented) {
    plant::functions(text, export, maps);
    let mut macros = Macros::of(export);
    let weights = filter.weights();
    macros.option("NEGATIVE_CENTRE", weights.is_negative);
    let noise = export.observer.noise_weight(export.scalar);
    for (name, x) in [
        ("DISTANCE", weights.distance),
        ("OUTER_WEIGHT", weights.outer),
        ("HALF_WEIGHT", weights.half),
        ("CENTRE_WEIGHT", weights.centre),
        ("NOISE_WEIGHT", noise),
        ("TWICE_NOISE_WEIGHT", 2.0 * noise),
    ] {
        macros.number(name, x);
    }
    macros.set("MOTION", "centre");
    macros.set("SLOPE", "motion");
    macros.integer("LENGTH", export.observer.dimensions().estimate);
    macros.write(text, kernels::COLUMNS);
    if filter.substeps().is_some() {
        macros.write(text, kernels::RUNGE_KUTTA);
        macros.write(text, kernels::CLASSICAL);
        macros.write(text, kernels::NOISE);
    }
    angles(text, export, &macros);
    macros.write(text, kernels::UNSCENTED);
    step(text, export, &macros);
}
