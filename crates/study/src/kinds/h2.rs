//! The H2 filter: the variance of the errors under white noise is bounded.

use luenberger_design::SystemNorm;

use super::as_kind;
use super::declaration::{Declaration, Information, Rule, Tuning};
use super::norm_filter::{self, NormFilter, NormFilterSpec};
use crate::study::{PlantClass, Time};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "h2",
    about: "H2 filter: the variance of the errors z = H e under white noise is below gamma^2, for linear plants.",
    source: "Kalman and Bucy 1961; as an inequality Scherer, Gahinet and Chilali 1997",
    plant: PlantClass::AtPoint(Time::ANY),
    keys: &[NormFilter::KEYS],
    kind: as_kind::<NormFilterSpec>,
    read: |given, reader| norm_filter::read(given, SystemNorm::H2, reader),
    takes_long: false,
    tuning: Tuning::Rules(&[Rule {
        name: "h2",
        turn: 3,
        tuning: "the least variance of the errors in units of the scale, for the intensities of process and measurement noise",
        source: "docs/disturbances.md",
        character: "without a bound on its gain it is the Kalman filter of the same intensities, with a proved variance",
        information: &[Information::Noise, Information::ProcessNoise],
        keys: norm_filter::tuned,
    }]),
};
