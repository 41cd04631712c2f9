//! Design of each `[[observer]]`, or the reason why it has none.

mod alternative;

use std::sync::atomic::AtomicBool;
use std::time::Instant;

pub use luenberger_export::moving_horizon::LONGEST_WINDOW;

pub use crate::designed::{Designed, Runnable};
use crate::kinds;
use crate::study::{ObserverSpec, Study};
use crate::synthesis::Plan;
pub use crate::synthesis::kkl_maps::candidate;
pub(crate) use crate::synthesis::noise_gain::SPEED_RATIO;
pub use crate::synthesis::{Advice, NoDesign};

/// The design of one observer of a study; of one that is refused, the alternatives that have a design. A design of
/// kind `kkl-numerical` takes minutes; it checks `cancel` continuously and stops once it is true.
///
/// # Errors
/// [`NoDesign`].
pub fn design(study: &Study, requested: &ObserverSpec, cancel: &AtomicBool) -> Result<Designed, NoDesign> {
    design_until(study, requested, cancel, None)
}

/// As [`design`], stopped at the instant `end` if there is one: matrix inequalities are solved no further, and a design
/// that fails for it is [`NoDesign::Interrupted`].
///
/// # Errors
/// [`NoDesign`].
pub fn design_until(
    study: &Study,
    requested: &ObserverSpec,
    cancel: &AtomicBool,
    end: Option<Instant>,
) -> Result<Designed, NoDesign> {
    attempt(study, requested, cancel, end).map_err(|none| match none {
        NoDesign::Misfit(refusal) => alternative::tried(study, requested, refusal, (cancel, end)).into(),
        NoDesign::Interrupted => NoDesign::Interrupted,
    })
}

/// As [`design_until`], without the alternatives of a refusal, which have to be designed themselves.
pub(crate) fn attempt(
    study: &Study,
    requested: &ObserverSpec,
    cancel: &AtomicBool,
    end: Option<Instant>,
) -> Result<Designed, NoDesign> {
    let designed = study.plant.names().with(|| kinds::design(&Plan { study, requested, cancel, end }));
    match designed {
        Err(_) if end.is_some_and(|end| Instant::now() >= end) => Err(NoDesign::Interrupted),
        designed => designed,
    }
}
