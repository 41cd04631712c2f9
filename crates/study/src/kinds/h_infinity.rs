//! The H-infinity filter: the energy of the errors is bounded by that of disturbances and noise.

use luenberger_design::SystemNorm;

use super::as_kind;
use super::declaration::{Declaration, Information, Rule, Tuning};
use super::norm_filter::{self, NormFilter, NormFilterSpec};
use crate::study::{PlantClass, Time};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "h-infinity",
    about: "H-infinity filter: the energy of the errors z = H e is below gamma^2 times that of disturbances and noise, for linear plants.",
    source: "Nagpal and Khargonekar 1991; as an inequality Boyd et al. 1994",
    plant: PlantClass::AtPoint(Time::ANY),
    keys: &[NormFilter::KEYS],
    kind: as_kind::<NormFilterSpec>,
    read: |given, reader| norm_filter::read(given, SystemNorm::HInfinity, reader),
    takes_long: false,
    tuning: Tuning::Rules(&[Rule {
        name: "h-infinity",
        turn: 4,
        tuning: "the least norm from process and measurement noise, in units of their intensities, to the errors in units of the scale",
        source: "docs/disturbances.md",
        character: "it bounds the errors under the worst noise of the same energy, and is no optimum under white noise",
        information: &[Information::Noise, Information::ProcessNoise],
        keys: norm_filter::tuned,
    }]),
};
