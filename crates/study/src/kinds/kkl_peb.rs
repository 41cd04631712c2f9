//! The [KKL+PEB] observer: a KKL observer whose Lambda has rows of zeros, with an estimator of the constant that they
//! leave.

use super::as_kind;
use super::declaration::{Declaration, Tuning};
use super::keys::{LAMBDA, MAPS, PHI, REGRESSION};
use super::peb::{self, ParameterEstimation};
use crate::study::{PlantClass, Time};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "kkl-peb",
    about: "[KKL+PEB] observer: a KKL observer whose Lambda has rows of zeros, with an estimator of the constant that they leave.",
    source: "Yi, Ortega and Zhang 2018, eq. (15), Propositions 3, 6 and 7",
    plant: PlantClass::Nonlinear(Time::OF_STATE),
    keys: &[&[PHI, LAMBDA], MAPS, REGRESSION],
    kind: as_kind::<ParameterEstimation>,
    read: |given, reader| peb::read(given, true, reader),
    takes_long: false,
    tuning: Tuning::MAPS_BY_HAND,
};
