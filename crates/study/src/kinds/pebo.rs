//! The parameter-estimation-based observer: Lambda is zero, and an estimator finds the constant that is left.

use luenberger_design::Region;

use super::declaration::{Declaration, Tuning};
use super::keys::{
    ALPHA, B, BOUNDED, ESTIMATOR, KNOWN, LEAKAGE, LEFT_INVERSE, MISSING, PHI, REGRESSOR, RESET, SIGNAL, THETA_MIN,
    THETA_REGION, THETA_START, WINDOW,
};
use super::{Kind, of, peb};
use crate::maps::PebSpec;
use crate::reader::{Given, Reader, maps};
use crate::results::{Advice, Cause, NoObserver};
use crate::study::{ObserverKind, PlantClass, Specification, Time};
use crate::synthesis::kkl_maps::other_maps;
use crate::synthesis::{Designed, Plan};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "pebo",
    about: "Parameter-estimation-based observer xi' = B(y, u), xhat = phi^L(xi + theta, y), with an estimator of the constant theta.",
    source: "Yi, Ortega and Zhang 2018, eq. (8) to (12), Proposition 2",
    plant: PlantClass::Nonlinear(Time::OF_STATE),
    keys: &[
        PHI,
        B,
        LEFT_INVERSE,
        BOUNDED,
        SIGNAL,
        KNOWN,
        REGRESSOR,
        MISSING,
        THETA_REGION,
        THETA_MIN,
        THETA_START,
        ALPHA,
        ESTIMATOR,
        LEAKAGE,
        RESET,
        WINDOW,
    ],
    kind: of::<Pebo>,
    read,
    takes_long: false,
    tuning: Tuning::MAPS_BY_HAND,
};

fn read(given: &Given<'_>, reader: &mut Reader) -> Option<ObserverKind> {
    Some(Pebo(maps::peb(given.node, given.plant, reader)?).into())
}

/// The observer with these maps, regression and estimator.
#[derive(Debug, Clone, PartialEq)]
pub struct Pebo(pub PebSpec);

impl Specification for Pebo {
    declared!();

    fn region_of_design(&self) -> Option<Region> {
        Some(self.0.region.clone())
    }
}

impl Kind for Pebo {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        peb::designed(plan.study, plan.requested, &self.0)
    }

    fn advice(&self, plan: &Plan<'_>, cause: &Cause) -> Option<Advice> {
        other_maps(plan.study, cause)
    }
}
