//! The parameter-estimation-based observer: Lambda is zero, and an estimator finds the constant that is left.

use super::as_kind;
use super::declaration::{Declaration, Tuning};
use super::keys::{MAPS, PHI, REGRESSION};
use super::peb::{self, ParameterEstimation};
use crate::study::{PlantClass, Time};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "pebo",
    about: "Parameter-estimation-based observer xi' = B(y, u), xhat = phi^L(xi + theta, y), with an estimator of the constant theta.",
    source: "Yi, Ortega and Zhang 2018, eq. (8) to (12), Proposition 2",
    plant: PlantClass::Nonlinear(Time::OF_STATE),
    keys: &[&[PHI], MAPS, REGRESSION],
    kind: as_kind::<ParameterEstimation>,
    read: |given, reader| peb::read(given, false, reader),
    takes_long: false,
    tuning: Tuning::MAPS_BY_HAND,
};
